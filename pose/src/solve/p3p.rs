//! The pose from three landmarks: up to four answers.

use nalgebra::{Matrix3, Vector2, Vector3};

use super::placement::Placement;

/// All placements under which three landmarks lie on three rays ahead of the camera.
///
/// Landmarks on one line have no finite set of answers and give none.
///
/// # Source
/// M. Persson and K. Nordberg, "Lambda Twist: an accurate fast robust perspective three point
/// solver", 2018.
pub(super) fn placements(
    landmarks_m: &[Vector3<f64>; 3],
    rays: &[Vector2<f64>; 3],
) -> Vec<Placement> {
    let sights = rays.map(|ray| Vector3::new(1.0, ray.x, ray.y).normalize());
    Distances::new(landmarks_m, &sights)
        .solve()
        .into_iter()
        .filter_map(|depths| {
            let seen = [0, 1, 2].map(|i| sights[i] * depths[i]);
            Placement::between(landmarks_m, &seen)
        })
        .collect()
}

/// Pairs of landmarks, in the order of the squared distances.
const PAIRS: [(usize, usize); 3] = [(0, 1), (0, 2), (1, 2)];

/// `l' forms[k] l = squares[k]` for the distances `l` of the landmarks from the camera.
struct Distances {
    forms: [Matrix3<f64>; 3],
    squares: [f64; 3],
}

impl Distances {
    /// The law of cosines for each pair.
    fn new(landmarks_m: &[Vector3<f64>; 3], sights: &[Vector3<f64>; 3]) -> Self {
        let forms = PAIRS.map(|(i, j)| {
            let mut form = Matrix3::zeros();
            form[(i, i)] = 1.0;
            form[(j, j)] = 1.0;
            form[(i, j)] = -sights[i].dot(&sights[j]);
            form[(j, i)] = form[(i, j)];
            form
        });
        let squares = PAIRS.map(|(i, j)| (landmarks_m[i] - landmarks_m[j]).norm_squared());
        Self { forms, squares }
    }

    /// All positive distances.
    ///
    /// Two combinations of the equations have no right side; a combination of
    /// these two that is singular is a pair of planes, and each plane meets the first in at most
    /// two lines.
    fn solve(&self) -> Vec<Vector3<f64>> {
        let [m12, m13, m23] = &self.forms;
        let [a12, a13, a23] = self.squares;
        let (d1, d2) = (m12 * a23 - m23 * a12, m13 * a23 - m23 * a13);
        let cubic = [
            d1.determinant(),
            (adjugate(&d1) * d2).trace(),
            (adjugate(&d2) * d1).trace(),
            d2.determinant(),
        ];
        let Some(planes) = real_roots(cubic)
            .into_iter()
            .find_map(|root| pair_of_planes(&(d1 + d2 * root)))
        else {
            return Vec::new();
        };
        planes
            .iter()
            .flat_map(|plane| lines(plane, &d1))
            .filter_map(|line| self.scaled(line))
            .collect()
    }

    /// The point of a line through the origin that satisfies the equations, polished by Newton's
    /// method; `None` unless all its distances are positive.
    fn scaled(&self, line: Vector3<f64>) -> Option<Vector3<f64>> {
        const STEPS: usize = 5;
        let size: f64 = self.forms.iter().map(|form| line.dot(&(form * line))).sum();
        let wanted: f64 = self.squares.iter().sum();
        if size <= 0.0 {
            return None;
        }
        let mut depths = line * (wanted / size).sqrt();
        if depths.sum() < 0.0 {
            depths = -depths;
        }
        for _ in 0..STEPS {
            let products = self.forms.map(|form| form * depths);
            let misses = Vector3::from_fn(|k, _| self.squares[k] - depths.dot(&products[k]));
            let slopes = Matrix3::from_rows(&products.map(|product| 2.0 * product.transpose()));
            depths += slopes.try_inverse()? * misses;
        }
        (depths.min() > 0.0).then_some(depths)
    }
}

fn adjugate(m: &Matrix3<f64>) -> Matrix3<f64> {
    let [a, b, c] = [0, 1, 2].map(|i| m.column(i).into_owned());
    Matrix3::from_rows(&[
        b.cross(&c).transpose(),
        c.cross(&a).transpose(),
        a.cross(&b).transpose(),
    ])
}

/// Real roots of `c[0] + c[1] x + c[2] x^2 + c[3] x^3`, each polished by Newton's method.
///
/// # Source
/// F. Viète, 1591 (three roots); G. Cardano, 1545 (one).
fn real_roots(c: [f64; 4]) -> Vec<f64> {
    const STEPS: usize = 2;
    let (a, b, d) = (c[2] / c[3], c[1] / c[3], c[0] / c[3]);
    let q = (a * a - 3.0 * b) / 9.0;
    let r = (a * (2.0 * a * a - 9.0 * b) + 27.0 * d) / 54.0;
    let mut roots = if r * r < q * q * q {
        let angle = (r / (q * q * q).sqrt()).clamp(-1.0, 1.0).acos();
        [0.0, 1.0, -1.0]
            .map(|k| -2.0 * q.sqrt() * ((angle + k * std::f64::consts::TAU) / 3.0).cos() - a / 3.0)
            .to_vec()
    } else {
        let s = -r.signum() * (r.abs() + (r * r - q * q * q).max(0.0).sqrt()).cbrt();
        let t = if s == 0.0 { 0.0 } else { q / s };
        vec![s + t - a / 3.0]
    };
    for root in &mut roots {
        for _ in 0..STEPS {
            let value = ((*root + a) * *root + b) * *root + d;
            let slope = (3.0 * *root + 2.0 * a) * *root + b;
            if slope != 0.0 {
                *root -= value / slope;
            }
        }
    }
    roots.retain(|root| root.is_finite());
    roots
}

/// The normals of the two planes that a singular form vanishes on, if they are real.
fn pair_of_planes(form: &Matrix3<f64>) -> Option<[Vector3<f64>; 2]> {
    let eigen = form.symmetric_eigen();
    let zero = eigen.eigenvalues.iamin();
    let (i, j) = PAIRS
        .into_iter()
        .find(|&(i, j)| i != zero && j != zero)
        .expect("one of three pairs leaves out an index");
    let ratio = -eigen.eigenvalues[j] / eigen.eigenvalues[i];
    let (e, f) = (eigen.eigenvectors.column(i), eigen.eigenvectors.column(j));
    (ratio >= 0.0).then(|| [e + f * ratio.sqrt(), e - f * ratio.sqrt()])
}

/// The lines of a plane through the origin on which a form vanishes.
fn lines(plane: &Vector3<f64>, form: &Matrix3<f64>) -> Vec<Vector3<f64>> {
    // Two directions of the plane: across its normal and the axis farthest from it.
    let least = plane.iamin();
    let across = plane.cross(&Vector3::ith(least, 1.0)).normalize();
    let along = plane.cross(&across).normalize();
    let (a, b, c) = (
        along.dot(&(form * along)),
        along.dot(&(form * across)),
        across.dot(&(form * across)),
    );
    let discriminant = b * b - a * c;
    if discriminant < 0.0 {
        return Vec::new();
    }
    // Of a s^2 + 2 b s t + c t^2 = 0, the two roots (s, t) without cancellation.
    let h = -(b + discriminant.sqrt().copysign(b));
    vec![along * h + across * a, along * c + across * h]
}
