//! The layer in front in small integers: sums and differences of pixels instead of a whitening.
//!
//! A whitening makes the pixels uncorrelated, so that words of a few bits hold what little the
//! landmarks' distances tell beside what they tell together. Nearly the same does an integer matrix of
//! determinant 1 or -1, which hardware forms with few adders and without rounding. Such matrices are the
//! bases of the lattice of integer vectors whose length is the deviation of that sum of pixels, and a
//! reduced basis is nearly orthogonal, that is, its sums are nearly uncorrelated.

use nalgebra::{DMatrix, DVector, RowDVector};

/// Lovász' condition, near its limit of 1: the dimensions are few.
const DELTA: f64 = 0.999;

/// Steps of the reduction at most; the canonical scene takes some hundreds.
const MOST_STEPS: usize = 100_000;

/// The greatest integer of a reduced basis that is of use.
const GREATEST: f64 = 1024.0;

/// Bits of precision, on the mean over the words, that shorter sums may cost.
const LOSS_BITS: f64 = 0.75;

/// Multiples of another row that are tried to make a row shorter.
const MULTIPLES: [f64; 8] = [1.0, -1.0, 2.0, -2.0, 3.0, -3.0, 4.0, -4.0];

/// Sums of pixels in the place of whitened ones.
#[derive(Clone, Debug, PartialEq)]
pub struct IntegerFront {
    /// Rows of small integers, each times the power of two that brings the deviation near to one.
    ///
    /// # Shape
    /// `[2n][2n]`, 1/px
    pub matrix: DMatrix<f64>,
    /// From these sums back to the whitened pixels.
    ///
    /// # Shape
    /// `[2n][2n]`
    pub back: DMatrix<f64>,
}

impl IntegerFront {
    /// For a whitening that keeps all axes; none for another.
    ///
    /// Source of the reduction: A. K. Lenstra, H. W. Lenstra, L. Lovász, "Factoring polynomials with
    /// rational coefficients", Mathematische Annalen 261, 1982.
    ///
    /// ```
    /// use hwgen_pose::train::IntegerFront;
    /// use nalgebra::dmatrix;
    /// // Two pixels of deviation 100 that differ by 2 or so.
    /// let whitening = dmatrix![0.005, 0.005; 0.5, -0.5];
    /// let front = IntegerFront::of(&whitening).unwrap();
    /// assert_eq!(front.matrix, dmatrix![0.0, 0.0078125; 0.5, -0.5]);
    /// assert!((&front.back * &front.matrix - whitening).amax() < 1e-12);
    /// ```
    pub fn of(whitening: &DMatrix<f64>) -> Option<Self> {
        if !whitening.is_square() {
            return None;
        }
        // Its rows are the pixels, by the axes along which all deviate by one.
        let pixels = whitening.clone().try_inverse()?;
        let mut rows = Rows {
            integers: DMatrix::identity(pixels.nrows(), pixels.nrows()),
            vectors: pixels.clone(),
        };
        if !rows.reduce() {
            return None;
        }
        rows.shorten();
        let mut order: Vec<usize> = (0..rows.len()).collect();
        order.sort_by(|i, j| rows.deviation(*j).total_cmp(&rows.deviation(*i)));
        let scaled: Vec<RowDVector<f64>> = order
            .iter()
            // Zero, not minus zero.
            .map(|i| (rows.integers.row(*i) * rows.scale(*i)).add_scalar(0.0))
            .collect();
        let matrix = DMatrix::from_rows(&scaled);
        let back = whitening * matrix.clone().try_inverse()?;
        Some(Self { matrix, back })
    }
}

/// A basis: integer combinations of the pixels, and the same as vectors.
struct Rows {
    integers: DMatrix<f64>,
    vectors: DMatrix<f64>,
}

impl Rows {
    fn len(&self) -> usize {
        self.integers.nrows()
    }

    fn deviation(&self, i: usize) -> f64 {
        self.vectors.row(i).norm()
    }

    /// The power of two that brings a row's deviation near to one, with the sign that makes most of its
    /// integers positive.
    fn scale(&self, i: usize) -> f64 {
        let row = self.integers.row(i);
        let first = row.iter().find(|w| **w != 0.0).copied().unwrap_or(1.0);
        let sum: f64 = row
            .iter()
            .map(|w| w.signum() * f64::from(u8::from(*w != 0.0)))
            .sum();
        let sign = if sum == 0.0 { first } else { sum };
        let power = libm::exp2(-libm::log2(self.deviation(i)).round());
        power.copysign(sign)
    }

    fn add(&mut self, to: usize, times: f64, from: usize) {
        for matrix in [&mut self.integers, &mut self.vectors] {
            let row = matrix.row(from) * times;
            let mut target = matrix.row_mut(to);
            target += row;
        }
    }

    /// The parts of row `k` along the orthogonalised rows before it, and the squares of the lengths of
    /// these and of what is left of it.
    fn orthogonal(&self, k: usize) -> (DVector<f64>, DVector<f64>) {
        let mut bases: Vec<RowDVector<f64>> = Vec::new();
        let mut parts = DVector::zeros(k + 1);
        for i in 0..=k {
            let mut left: RowDVector<f64> = self.vectors.row(i).into_owned();
            for (j, base) in bases.iter().enumerate() {
                let part = self.vectors.row(i).dot(base) / base.norm_squared();
                left -= base * part;
                if i == k {
                    parts[j] = part;
                }
            }
            bases.push(left);
        }
        let squares = bases.iter().map(|b| b.norm_squared());
        (parts, DVector::from_iterator(k + 1, squares))
    }

    /// Whether it came to an end, and to small integers: pixels that are nearly the same sum need greater
    /// ones than the arithmetic holds.
    fn reduce(&mut self) -> bool {
        let mut k = 1;
        for _ in 0..MOST_STEPS {
            if k >= self.len() {
                return self.integers.amax() <= GREATEST;
            }
            for j in (0..k).rev() {
                let times = self.orthogonal(k).0[j].round();
                if times != 0.0 {
                    self.add(k, -times, j);
                }
            }
            let (parts, squares) = self.orthogonal(k);
            if squares[k] >= (DELTA - parts[k - 1] * parts[k - 1]) * squares[k - 1] {
                k += 1;
            } else {
                self.integers.swap_rows(k, k - 1);
                self.vectors.swap_rows(k, k - 1);
                k = (k - 1).max(1);
            }
        }
        false
    }

    /// Adds rows to rows where that leaves fewer adders: of all such steps that which costs the least
    /// precision for an adder, until too much would be lost.
    fn shorten(&mut self) {
        let mut left = LOSS_BITS * f64::from(u16::try_from(self.len()).unwrap_or(u16::MAX));
        loop {
            let mut best: Option<(f64, f64, usize, f64, usize)> = None;
            for to in 0..self.len() {
                for from in (0..self.len()).filter(|from| *from != to) {
                    for times in MULTIPLES {
                        let row = |m: &DMatrix<f64>| m.row(to) + m.row(from) * times;
                        let before = digits(self.integers.row(to).iter());
                        let after = digits(row(&self.integers).iter());
                        if after >= before {
                            continue;
                        }
                        let loss = libm::log2(row(&self.vectors).norm() / self.deviation(to));
                        let price = loss / f64::from(before - after);
                        if loss <= left && best.is_none_or(|best| price < best.0) {
                            best = Some((price, loss, to, times, from));
                        }
                    }
                }
            }
            let Some((_, loss, to, times, from)) = best else {
                return;
            };
            left -= loss;
            self.add(to, times, from);
        }
    }
}

/// Signed powers of two that integers are sums of, at least.
fn digits<'a>(integers: impl Iterator<Item = &'a f64>) -> u32 {
    let digits = |w: &f64| {
        #[expect(clippy::cast_possible_truncation, reason = "small integers")]
        let w = w.abs() as i64;
        (w ^ (3 * w)).count_ones()
    };
    integers.map(digits).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pixels that have much in common: any whitening of them, its rows turned.
    fn whitening(n: usize) -> DMatrix<f64> {
        let common = DMatrix::from_fn(n, n, |i, j| {
            libm::sin((7 * i * n + 3 * j) as f64) / libm::exp2(j as f64)
        });
        (100.0 * common + DMatrix::identity(n, n))
            .try_inverse()
            .unwrap()
    }

    #[test]
    fn it_is_of_integers_and_of_determinant_one() {
        for n in 2..9 {
            let rows = IntegerFront::of(&whitening(n)).unwrap().matrix;
            for row in rows.row_iter() {
                let integers = (0..30).map(|places| row * libm::exp2(f64::from(places)));
                let mut whole = integers.filter(|r| r.iter().all(|w| w.fract() == 0.0));
                assert!(whole.next().is_some_and(|r| r.amax() < 64.0), "{n}: {row}");
            }
            // Powers of two alone are left.
            let left = libm::log2(rows.determinant().abs());
            assert!((left - left.round()).abs() < 1e-6, "{n}: {left}");
        }
    }

    #[test]
    fn sums_are_nearly_uncorrelated_and_of_deviation_one() {
        for n in 2..9 {
            let whitening = whitening(n);
            let front = IntegerFront::of(&whitening).unwrap();
            assert!((&front.back * &front.matrix - &whitening).amax() < 1e-9);
            let vectors = &front.matrix * whitening.try_inverse().unwrap();
            let product: f64 = vectors.row_iter().map(|row| row.norm()).product();
            for row in vectors.row_iter() {
                assert!((0.7..1.5).contains(&row.norm()), "{n}: {}", row.norm());
            }
            let lost = libm::log2(product / vectors.determinant().abs());
            assert!(lost < (1.0 + LOSS_BITS) * n as f64, "{n}: {lost} bits");
        }
    }

    #[test]
    fn what_no_small_integers_tell_apart_stays_as_it_is() {
        let nearly = DMatrix::from_row_slice(2, 2, &[1.0, -1e12, 0.0, 1e-3 * libm::sqrt(2.0)]);
        assert_eq!(IntegerFront::of(&nearly), None);
        let nothing = DMatrix::from_row_slice(2, 2, &[f64::NAN, 1.0, 0.0, 1.0]);
        assert_eq!(IntegerFront::of(&nothing), None);
    }

    #[test]
    fn a_whitening_without_some_axes_stays_as_it_is() {
        assert_eq!(IntegerFront::of(&DMatrix::from_element(2, 2, 1.0)), None);
        assert_eq!(IntegerFront::of(&DMatrix::from_element(1, 2, 1.0)), None);
    }
}
