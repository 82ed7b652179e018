//! The best straight line over a segment of a table.

use super::{GUARD_BITS, OddTable, to_code, to_real};

/// A line over the codes of one segment.
pub(super) struct Line {
    pub(super) offset: i64,
    pub(super) slope: i64,
    /// Greatest distance from the function, in output steps.
    pub(super) error: f64,
}

/// What a line over a segment has to be near, and the offsets that it may have.
pub(super) struct Segment<'a> {
    pub(super) table: &'a OddTable,
    /// The function in output steps on every code.
    pub(super) exact: Vec<f64>,
    /// The last distance.
    pub(super) last: i64,
    /// Least offset.
    pub(super) least: i64,
    /// Greatest offset.
    pub(super) most: i64,
}

impl Segment<'_> {
    /// The line of least error; `chord` is the slope of the function's chord.
    ///
    /// Over a concave function the minimax line is parallel to the chord. Where its offset is
    /// not allowed, the slope is searched: the error of the best allowed offset is convex in it.
    pub(super) fn best(&self, chord: f64) -> Line {
        let steepest = self.steepest();
        let floor = to_code(chord.floor());
        let mut slopes: Vec<i64> = ((floor - 1).max(0)..=floor + 2).collect();
        if slopes.iter().any(|s| *s > steepest || self.clamped(*s).1) {
            let (mut low, mut high) = (0, steepest);
            while high - low > 2 {
                let third = (high - low) / 3;
                let (a, b) = (low + third, high - third);
                if self.estimate(a) <= self.estimate(b) {
                    high = b;
                } else {
                    low = a;
                }
            }
            slopes.extend((low - 1).max(0)..=high + 1);
        }
        slopes
            .into_iter()
            .filter(|slope| *slope <= steepest)
            .flat_map(|slope| {
                let (centre, _) = self.clamped(slope);
                let offsets = (centre - 2).max(self.least)..=(centre + 2).min(self.highest(slope));
                offsets.map(move |offset| self.line(offset, slope))
            })
            .reduce(|best, line| if line.error < best.error { line } else { best })
            .expect("the constant at the value before is allowed")
    }

    /// The greatest slope with which the line can stay within one.
    fn steepest(&self) -> i64 {
        let table = self.table;
        let room = self.ceiling() - (self.least << (table.slope_bits - GUARD_BITS));
        (room / self.last).min(1 << table.slope_bits)
    }

    /// The greatest sum that stays within `2^f - 1`.
    fn ceiling(&self) -> i64 {
        (1 << (self.table.fraction + self.table.slope_bits)) - 1
    }

    /// The greatest offset with which a line of this slope stays within one.
    fn highest(&self, slope: i64) -> i64 {
        let rise = slope * self.last;
        ((self.ceiling() - rise) >> (self.table.slope_bits - GUARD_BITS)).min(self.most)
    }

    /// The allowed offset that is nearest to the best one, and whether that is another.
    fn clamped(&self, slope: i64) -> (i64, bool) {
        let (low, high) = self.residual(slope);
        let wanted = to_code((low + high) / 2.0 * 4.0) + 2;
        let offset = wanted.clamp(self.least, self.highest(slope).max(self.least));
        (offset, offset != wanted)
    }

    /// The error of the best allowed offset, apart from the rounding to codes.
    fn estimate(&self, slope: i64) -> f64 {
        let (low, high) = self.residual(slope);
        let highest = to_real(self.highest(slope).min(1 << 30)) - 2.0;
        let offset = (2.0 * (low + high)).clamp(
            to_real(self.least) - 2.0,
            highest.max(to_real(self.least) - 2.0),
        ) / 4.0;
        (high - offset).max(offset - low)
    }

    /// Least and greatest of the function less a line of this slope from zero.
    fn residual(&self, slope: i64) -> (f64, f64) {
        let step = to_real(slope) / to_real(1 << self.table.slope_bits);
        let residual = self
            .exact
            .iter()
            .zip(0..)
            .map(|(e, d)| e - step * to_real(d));
        residual.fold((f64::MAX, f64::MIN), |(low, high), r| {
            (low.min(r), high.max(r))
        })
    }

    fn line(&self, offset: i64, slope: i64) -> Line {
        let value = |d: i64| to_real(self.table.line(offset, slope, d));
        let errors = self
            .exact
            .iter()
            .zip(0..)
            .map(|(e, d)| (value(d) - e).abs());
        Line {
            offset,
            slope,
            error: errors.fold(0.0, f64::max),
        }
    }
}
