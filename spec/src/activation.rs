//! The piecewise-linear table behind tanh and sigmoid.
//!
//! One odd table serves both, because `sigmoid(x) = (1 + tanh(x / 2)) / 2` is exact in fixed
//! point: the halving moves the binary point, and so does the outer one half.

/// A tanh on fixed-point codes: straight segments over the magnitude, the sign put back.
///
/// The magnitude `m = |z|` splits into a segment number (its high bits) and a distance `d` from
/// the segment's start (its low bits); the result is
/// `((offset << (slope_bits - 2)) + slope * d) >> slope_bits`, negated where `z` was negative.
///
/// # Format
/// Input and output have [`fraction`](Self::fraction) fraction bits `f`.
/// Input codes are `-(2^(r+f) - 1) ..= 2^(r+f) - 1` for the range `2^r`.
/// Slopes have `slope_bits` fraction bits.
/// Offsets have `f + 2` fraction bits and contain half an output step, so that dropping bits
/// rounds to nearest.
///
/// # Contract
/// Odd, monotone, and within `2^f - 1` in magnitude.
/// Every segment is the minimax line over its own codes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OddTable {
    fraction: u32,
    range_log2: u32,
    segments_log2: u32,
    slope_bits: u32,
    offsets: Vec<i64>,
    slopes: Vec<i64>,
    max_error_lsb_1000: i64,
}

/// Guard bits of the offsets below the output step.
pub const GUARD_BITS: u32 = 2;

/// Least and greatest number of output fraction bits that a table is made for.
pub const FRACTION_RANGE: std::ops::RangeInclusive<u32> = 2..=17;

impl OddTable {
    /// The smallest table, in powers of two, whose error stays below two output steps.
    ///
    /// `fraction` must lie in [`FRACTION_RANGE`].
    pub fn tanh(fraction: u32) -> Self {
        let widest = range_log2(fraction) + fraction - 1;
        (2..=widest)
            .map(|log2| Self::with_segments_log2(fraction, log2))
            .find(|table| table.max_error_lsb() < 2.0)
            .unwrap_or_else(|| Self::with_segments_log2(fraction, widest))
    }

    /// A table with `2^segments_log2` uniform segments (at most one for two codes).
    pub fn with_segments_log2(fraction: u32, segments_log2: u32) -> Self {
        assert!(
            FRACTION_RANGE.contains(&fraction),
            "{fraction} fraction bits"
        );
        let range_log2 = range_log2(fraction);
        let segments_log2 = segments_log2.min(range_log2 + fraction - 1);
        // The slope's own rounding moves a segment's far end by half an output step at most.
        let slope_bits = (fraction + range_log2)
            .saturating_sub(segments_log2)
            .max(GUARD_BITS);
        let mut table = Self {
            fraction,
            range_log2,
            segments_log2,
            slope_bits,
            offsets: Vec::new(),
            slopes: Vec::new(),
            max_error_lsb_1000: 0,
        };
        table.fit();
        table
    }

    fn fit(&mut self) {
        let one = libm::ldexp(1.0, self.fraction.cast_signed());
        let length = 1i64 << self.distance_bits();
        let limit = (1i64 << self.fraction) - 1;
        let mut worst = 0.0f64;
        let mut last = 0i64;
        for k in 0..1i64 << self.segments_log2 {
            // The function itself, in output steps, on every code of the segment.
            let exact: Vec<f64> = (0..length)
                .map(|d| libm::tanh(to_real(k * length + d) / one) * one)
                .collect();
            let end = libm::tanh(to_real((k + 1) * length) / one) * one;
            let ideal = (end - exact[0]) / to_real(length) * to_real(1 << self.slope_bits);
            let mut best: Option<(f64, i64, i64, i64)> = None;
            for slope in slope_candidates(ideal) {
                let line = |d: i64| to_real(slope * d) / to_real(1 << self.slope_bits);
                let residual = exact.iter().zip(0..).map(|(e, d)| e - line(d));
                let (low, high) = residual.fold((f64::MAX, f64::MIN), |(low, high), r| {
                    (low.min(r), high.max(r))
                });
                let centre = to_code((low + high) / 2.0 * 4.0) + 2;
                for offset in (centre - 2).max(0)..=centre + 2 {
                    let value = |d: i64| self.line(offset, slope, d);
                    let (first, final_value) = (value(0), value(length - 1));
                    if first < last || final_value > limit || (k == 0 && first != 0) {
                        continue;
                    }
                    let error = exact
                        .iter()
                        .zip(0..)
                        .map(|(e, d)| (to_real(value(d)) - e).abs())
                        .fold(0.0, f64::max);
                    if best.is_none_or(|(least, ..)| error < least) {
                        best = Some((error, offset, slope, final_value));
                    }
                }
            }
            // A constant at the last value is always monotone and in range.
            let (error, offset, slope, final_value) = best.unwrap_or_else(|| {
                let error = exact
                    .iter()
                    .map(|e| (e - to_real(last)).abs())
                    .fold(0.0, f64::max);
                (error, (last << GUARD_BITS) + 2, 0, last)
            });
            worst = worst.max(error);
            last = final_value;
            self.offsets.push(offset);
            self.slopes.push(slope);
        }
        self.max_error_lsb_1000 = to_code((worst * 1000.0).ceil());
    }

    fn line(&self, offset: i64, slope: i64, distance: i64) -> i64 {
        ((offset << (self.slope_bits - GUARD_BITS)) + slope * distance) >> self.slope_bits
    }

    /// The result for an input code; codes beyond the range are clipped to it first.
    pub fn apply(&self, z: i64) -> i64 {
        let limit = (1i64 << self.magnitude_bits()) - 1;
        let magnitude = z.clamp(-limit, limit).unsigned_abs().cast_signed();
        let distance = magnitude & ((1 << self.distance_bits()) - 1);
        let k = usize::try_from(magnitude >> self.distance_bits()).expect("a magnitude");
        let y = self.line(self.offsets[k], self.slopes[k], distance);
        if z < 0 { -y } else { y }
    }

    /// Fraction bits of input and output.
    pub fn fraction(&self) -> u32 {
        self.fraction
    }

    /// The input's range is `2^range_log2`, open.
    pub fn range_log2(&self) -> u32 {
        self.range_log2
    }

    /// Number of segments over `[0, 2^range_log2)`.
    pub fn segments(&self) -> usize {
        self.offsets.len()
    }

    /// Bits of the segment number.
    pub fn segment_bits(&self) -> u32 {
        self.segments_log2
    }

    /// Bits of a magnitude: the input word without its sign.
    #[inline]
    pub fn magnitude_bits(&self) -> u32 {
        self.range_log2 + self.fraction
    }

    /// Bits of the distance within a segment, at least one.
    #[inline]
    pub fn distance_bits(&self) -> u32 {
        self.magnitude_bits() - self.segments_log2
    }

    /// Fraction bits of a slope; a slope has one bit more.
    #[inline]
    pub fn slope_bits(&self) -> u32 {
        self.slope_bits
    }

    /// Bits of an offset, unsigned.
    pub fn offset_width(&self) -> u32 {
        self.fraction + GUARD_BITS
    }

    /// Bits of a slope, unsigned; slopes reach one.
    pub fn slope_width(&self) -> u32 {
        self.slope_bits + 1
    }

    /// Offsets and slopes in segment order.
    pub fn lines(&self) -> impl Iterator<Item = (i64, i64)> + '_ {
        self.offsets
            .iter()
            .copied()
            .zip(self.slopes.iter().copied())
    }

    /// Offset and slope of a segment.
    #[inline]
    pub fn line_of(&self, segment: usize) -> (i64, i64) {
        (self.offsets[segment], self.slopes[segment])
    }

    /// Greatest distance from tanh over all input codes, in output steps, rounded up to 1/1000.
    pub fn max_error_lsb(&self) -> f64 {
        to_real(self.max_error_lsb_1000) / 1000.0
    }
}

/// Beyond 4 tanh is within 1.4 steps of a constant for 12 fraction bits; finer words need 8.
fn range_log2(fraction: u32) -> u32 {
    if fraction <= 12 { 2 } else { 3 }
}

fn slope_candidates(ideal: f64) -> std::ops::RangeInclusive<i64> {
    let floor = to_code(ideal.floor());
    (floor - 1).max(0)..=floor + 2
}

#[expect(
    clippy::cast_precision_loss,
    reason = "codes here have at most 22 bits"
)]
fn to_real(code: i64) -> f64 {
    code as f64
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "values here have at most 22 bits"
)]
fn to_code(value: f64) -> i64 {
    value.round() as i64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_of_every_table_is_close_odd_monotone_and_in_range() {
        for fraction in FRACTION_RANGE {
            let table = OddTable::tanh(fraction);
            let limit = (1i64 << table.magnitude_bits()) - 1;
            let one = to_real(1 << fraction);
            let mut last = -(1 << fraction);
            for z in -limit..=limit {
                let y = table.apply(z);
                let error = (to_real(y) - libm::tanh(to_real(z) / one) * one).abs();
                assert!(error < 2.0, "fraction {fraction}, code {z}: {error} steps");
                assert!(error <= table.max_error_lsb(), "stated bound, code {z}");
                assert_eq!(y, -table.apply(-z), "odd at {z}");
                assert!(y >= last, "monotone at {z}");
                assert!(y.abs() < 1 << fraction, "in range at {z}");
                last = y;
            }
        }
    }

    #[test]
    fn table_fields_fit_their_widths() {
        for fraction in FRACTION_RANGE {
            let table = OddTable::tanh(fraction);
            for (offset, slope) in table.lines() {
                assert!((0..1 << table.offset_width()).contains(&offset));
                assert!((0..1 << table.slope_width()).contains(&slope));
            }
        }
    }

    #[test]
    fn twelve_bits_need_the_64_segments_that_were_measured() {
        let table = OddTable::tanh(12);
        assert_eq!((table.segments(), table.slope_bits()), (64, 8));
        assert!(table.max_error_lsb() < 1.8, "{}", table.max_error_lsb());
    }
}
