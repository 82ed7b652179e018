//! The piecewise-linear table behind tanh and sigmoid.
//!
//! One odd table serves both, because `sigmoid(x) = (1 + tanh(x / 2)) / 2` is exact in fixed
//! point: the halving moves the binary point, and so does the outer one half.

use self::fit::Segment;

mod fit;

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
/// Every segment is the minimax line over its own codes among those that leave the table so.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OddTable {
    fraction: u32,
    range_log2: u32,
    segments_log2: u32,
    slope_bits: u32,
    offsets: Vec<i64>,
    slopes: Vec<i64>,
    range_error_lsb_1000: i64,
    max_error_lsb_1000: i64,
}

/// Guard bits of the offsets below the output step.
pub const GUARD_BITS: u32 = 2;

/// Least and greatest number of output fraction bits that a table is made for.
pub const FRACTION_RANGE: std::ops::RangeInclusive<u32> = 2..=17;

impl OddTable {
    /// The smallest table, in powers of two, whose error stays below two output steps
    /// over its range.
    ///
    /// `fraction` must lie in [`FRACTION_RANGE`].
    pub fn tanh(fraction: u32) -> Self {
        let widest = range_log2(fraction) + fraction - 1;
        (2..=widest)
            .find_map(|log2| {
                let mut table = Self::empty(fraction, log2);
                table.fit(1.999).then_some(table)
            })
            .unwrap_or_else(|| Self::with_segments_log2(fraction, widest))
    }

    /// A table with `2^segments_log2` uniform segments (at most one for two codes).
    pub fn with_segments_log2(fraction: u32, segments_log2: u32) -> Self {
        let mut table = Self::empty(fraction, segments_log2);
        table.fit(f64::INFINITY);
        table
    }

    fn empty(fraction: u32, segments_log2: u32) -> Self {
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
        Self {
            fraction,
            range_log2,
            segments_log2,
            slope_bits,
            offsets: Vec::new(),
            slopes: Vec::new(),
            range_error_lsb_1000: 0,
            max_error_lsb_1000: 0,
        }
    }

    /// Fits the segments one after the other; false as soon as an error exceeds `limit`.
    fn fit(&mut self, limit: f64) -> bool {
        let one = libm::ldexp(1.0, self.fraction.cast_signed());
        let length = 1i64 << self.distance_bits();
        let mut worst = 0.0f64;
        let mut last = 0i64;
        for k in 0..1i64 << self.segments_log2 {
            // The function itself, in output steps, on every code of the segment.
            let exact: Vec<f64> = (0..length)
                .map(|d| libm::tanh(to_real(k * length + d) / one) * one)
                .collect();
            let end = libm::tanh(to_real((k + 1) * length) / one) * one;
            let segment = Segment {
                table: self,
                exact,
                last: length - 1,
                // Monotone from the segment before.
                least: last << GUARD_BITS,
                // Zero leads to zero.
                most: if k == 0 { 3 } else { i64::MAX },
            };
            let ideal = (end - segment.exact[0]) / to_real(length);
            let line = segment.best(ideal * to_real(1 << self.slope_bits));
            worst = worst.max(line.error);
            if worst > limit {
                return false;
            }
            last = self.line(line.offset, line.slope, length - 1);
            self.offsets.push(line.offset);
            self.slopes.push(line.slope);
        }
        let thousandths = |steps: f64| to_code((steps * 1000.0).ceil());
        self.range_error_lsb_1000 = thousandths(worst);
        self.max_error_lsb_1000 = thousandths(worst.max(one - to_real(last)));
        true
    }

    fn line(&self, offset: i64, slope: i64, distance: i64) -> i64 {
        ((offset << (self.slope_bits - GUARD_BITS)) + slope * distance) >> self.slope_bits
    }

    /// The result for an input code; codes beyond the range are clipped to it first.
    pub fn apply(&self, z: i64) -> i64 {
        let magnitude = self.magnitude(z);
        let distance = magnitude & ((1 << self.distance_bits()) - 1);
        let k = self.segment_of(z);
        let y = self.line(self.offsets[k], self.slopes[k], distance);
        if z < 0 { -y } else { y }
    }

    /// The segment that an argument falls into.
    pub fn segment_of(&self, z: i64) -> usize {
        usize::try_from(self.magnitude(z) >> self.distance_bits()).expect("a magnitude")
    }

    fn magnitude(&self, z: i64) -> i64 {
        let limit = (1i64 << self.magnitude_bits()) - 1;
        z.clamp(-limit, limit).unsigned_abs().cast_signed()
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

    /// Greatest distance from tanh over the input codes of the range, in output steps, rounded up
    /// to 1/1000.
    pub fn range_error_lsb(&self) -> f64 {
        to_real(self.range_error_lsb_1000) / 1000.0
    }

    /// The same over all arguments, those that are clipped to the range included.
    pub fn max_error_lsb(&self) -> f64 {
        to_real(self.max_error_lsb_1000) / 1000.0
    }
}

/// Beyond 4 tanh is within 1.4 steps of a constant for 12 fraction bits; finer words need 8.
pub(crate) fn range_log2(fraction: u32) -> u32 {
    if fraction <= 12 { 2 } else { 3 }
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
                assert!(error <= table.range_error_lsb(), "stated bound, code {z}");
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
        assert!(table.range_error_lsb() < 1.8);
        // Beyond the range the table stays at its last value.
        assert_eq!((table.apply(1 << 20), table.max_error_lsb()), (4093, 3.0));
    }

    /// Least error of a straight line over `[from, to]` of tanh; one from zero starts there.
    /// None goes beyond one.
    fn least_error(from: f64, to: f64) -> f64 {
        let points: Vec<f64> = (0..=2000)
            .map(|i| from + (to - from) * f64::from(i) / 2000.0)
            .collect();
        let worst = |slope: f64, offset: f64| {
            let errors = points.iter().map(|x| libm::tanh(*x) - offset - slope * x);
            errors.fold((f64::MAX, f64::MIN), |(a, b), e| (a.min(e), b.max(e)))
        };
        if from > 0.0 {
            let slope = (libm::tanh(to) - libm::tanh(from)) / (to - from);
            let (low, high) = worst(slope, 0.0);
            return (high - low) / 2.0;
        }
        (0..=1000)
            .map(|i| f64::from(i) / 1000.0)
            .filter(|slope| slope * to <= 1.0)
            .map(|slope| worst(slope, 0.0))
            .map(|(low, high)| high.max(-low))
            .fold(f64::MAX, f64::min)
    }

    #[test]
    fn few_segments_are_as_good_as_so_many_lines_can_be() {
        for fraction in 7..=17 {
            for segments_log2 in 2..=6 {
                let table = OddTable::with_segments_log2(fraction, segments_log2);
                let range = f64::from(1u32 << table.range_log2());
                let count = 1u32 << segments_log2;
                let edge = |k: u32| range * f64::from(k) / f64::from(count);
                let least = (0..count)
                    .map(|k| least_error(edge(k), edge(k + 1)))
                    .fold(0.0, f64::max);
                let steps = least * to_real(1 << fraction);
                // Rounding of result, offset and slope; the limit one step below one.
                let found = table.range_error_lsb();
                assert!(
                    found <= 1.02 * steps + 2.0,
                    "{fraction} bits, {count} segments: {found} steps, {steps} possible"
                );
            }
        }
    }

    #[test]
    fn few_segments_leave_the_table_odd_monotone_and_in_range() {
        for fraction in [2, 7, 12, 17] {
            for segments_log2 in 2..=5 {
                let table = OddTable::with_segments_log2(fraction, segments_log2);
                let limit = (1i64 << table.magnitude_bits()) - 1;
                assert_eq!(table.apply(0), 0);
                let values: Vec<i64> = (0..=limit).map(|z| table.apply(z)).collect();
                assert!(values.is_sorted() && values[values.len() - 1] < 1 << fraction);
            }
        }
    }
}
