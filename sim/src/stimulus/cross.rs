//! Conditions of a frame, crossed in pairs, and the count of the pairs that occurred.

use std::collections::BTreeMap;

use hwgen_spec::design::Design;
use rand::{RngExt, seq::IndexedRandom};
use rand_chacha::ChaCha8Rng;

use super::{Frame, lane_format, random_frame};

/// Cycles of a long pause, on either side: more than a counter of 8 bits reaches.
pub(crate) const LONG: usize = 260;
/// Random candidates for each frame of the covering array.
const CANDIDATES: usize = 40;

/// One value of one axis: what may be true of a frame and of its way through the core.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Condition {
    /// As many beats as a frame has.
    Whole,
    /// Fewer.
    Short,
    /// One or a few more.
    Long,
    /// Several frames' worth, and more than 256.
    FarTooLong,
    /// All words inside of the box, none at a limit on purpose.
    Inside,
    /// All words at the low limits.
    AtLow,
    /// All words at the high limits.
    AtHigh,
    /// One word one step below its limit.
    JustBelow,
    /// One word one step above its limit.
    JustAbove,
    /// A word of the first beat is outside of the box.
    ClippedFirst,
    /// A word of the last beat that carries one is outside of the box.
    ClippedLast,
    /// Its beats are offered without a pause.
    NoIdle,
    /// A few idle cycles before or between its beats.
    Idle,
    /// Hundreds of idle cycles before or between its beats.
    LongIdle,
    /// Its output is taken at once.
    NoStall,
    /// Its output waits for some cycles.
    Stall,
    /// Its output waits for hundreds of cycles.
    LongStall,
    /// It reaches the output.
    NoReset,
    /// A reset drops it.
    Reset,
}

use Condition::*;

/// The axes; conditions of one axis exclude each other.
const AXES: [&[Condition]; 5] = [
    &[Whole, Short, Long, FarTooLong],
    &[
        Inside,
        AtLow,
        AtHigh,
        JustBelow,
        JustAbove,
        ClippedFirst,
        ClippedLast,
    ],
    &[NoIdle, Idle, LongIdle],
    &[NoStall, Stall, LongStall],
    &[NoReset, Reset],
];

/// One condition of each axis.
pub(crate) type Row = [Condition; AXES.len()];

/// How often each pair of conditions occurred.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Pairs(BTreeMap<(Condition, Condition), usize>);

impl Pairs {
    /// Counts the pairs of a frame.
    pub(crate) fn count(&mut self, row: &Row) {
        for pair in pairs_of(row) {
            *self.0.entry(pair).or_default() += 1;
        }
    }

    /// Adds the counts of another run.
    pub fn add(&mut self, other: &Self) {
        for (pair, count) in &other.0 {
            *self.0.entry(*pair).or_default() += count;
        }
    }

    /// Pairs that a design can have and that never occurred.
    pub fn missing(&self, design: &Design) -> Vec<(Condition, Condition)> {
        let all = possible(design).into_iter();
        all.filter(|pair| self.0.get(pair).is_none_or(|count| *count == 0))
            .collect()
    }

    /// Pairs that occurred, and the least count of them.
    pub fn summary(&self) -> (usize, usize) {
        (self.0.len(), self.0.values().copied().min().unwrap_or(0))
    }
}

fn pairs_of(row: &Row) -> impl Iterator<Item = (Condition, Condition)> {
    (0..row.len()).flat_map(move |i| (i + 1..row.len()).map(move |j| (row[i], row[j])))
}

/// Whether frames of this design can have a condition.
fn can_have(design: &Design, condition: Condition) -> bool {
    let beats = design.source().beats();
    let per_beat = design.source().words_per_beat;
    let words = design.input().low.len();
    let outside = |mut words: std::ops::Range<usize>| words.any(|w| beyond(design, w).is_some());
    match condition {
        Short => beats > 1,
        JustBelow => (0..words).any(|w| below(design, w).is_some()),
        JustAbove => (0..words).any(|w| above(design, w).is_some()),
        ClippedFirst => outside(0..per_beat.min(words)),
        ClippedLast => outside((beats - 1) * per_beat..words),
        _ => true,
    }
}

fn possible(design: &Design) -> Vec<(Condition, Condition)> {
    let mut all = Vec::new();
    for (i, first) in AXES.iter().enumerate() {
        for second in &AXES[i + 1..] {
            for a in first.iter().filter(|c| can_have(design, **c)) {
                let legal = second.iter().filter(|c| can_have(design, **c));
                all.extend(legal.map(|b| (*a, *b)));
            }
        }
    }
    // A short frame has no word in the last beat; its own last beat may have none that can be outside.
    all.retain(|pair| *pair != (Short, ClippedLast) || can_have(design, ClippedFirst));
    let first_beat = 0..design.source().words_per_beat.min(design.input().low.len());
    let in_first = |code: fn(&Design, usize) -> Option<i64>| {
        first_beat.clone().any(|w| code(design, w).is_some())
    };
    all.retain(|pair| match pair {
        (Short, JustBelow) => in_first(below),
        (Short, JustAbove) => in_first(above),
        _ => true,
    });
    all
}

fn below(design: &Design, word: usize) -> Option<i64> {
    let low = design.input().low[word];
    (low > lane_format(design).min_code()).then(|| low - 1)
}

fn above(design: &Design, word: usize) -> Option<i64> {
    let high = design.input().high[word];
    (high < lane_format(design).max_code()).then(|| high + 1)
}

/// A code far outside of a word's box, where its lane has one.
fn beyond(design: &Design, word: usize) -> Option<i64> {
    let lane = lane_format(design);
    above(design, word)
        .map(|_| lane.max_code())
        .or(below(design, word).map(|_| lane.min_code()))
}

/// Frames in which every pair of conditions occurs, by a greedy choice among random rows.
pub(super) fn crossed(design: &Design, rng: &mut ChaCha8Rng) -> Vec<Frame> {
    let axes: Vec<Vec<Condition>> = AXES
        .iter()
        .map(|axis| {
            let legal = axis.iter().filter(|c| can_have(design, **c));
            legal.copied().collect()
        })
        .collect();
    let mut left = possible(design);
    let mut frames = Vec::new();
    while let Some(needed) = left.first().copied() {
        let draw = |rng: &mut ChaCha8Rng| -> Row {
            std::array::from_fn(|axis| {
                let axis = &axes[axis];
                let wanted = axis.iter().find(|c| **c == needed.0 || **c == needed.1);
                *wanted.unwrap_or_else(|| axis.choose(rng).expect("an axis has a condition"))
            })
        };
        let new = |row: &Row| pairs_of(row).filter(|pair| left.contains(pair)).count();
        let candidates: Vec<Row> = (0..CANDIDATES).map(|_| draw(rng)).collect();
        let best = *candidates.iter().max_by_key(|row| new(row)).expect("some");
        let mut frame = None;
        // A row may be one that no frame has, such as a short frame whose only beat can't be clipped.
        for _ in 0..8 {
            frame = build(design, &best, rng);
            if frame.is_some() {
                break;
            }
        }
        match frame {
            Some(frame) => {
                left.retain(|pair| !pairs_of(&best).any(|other| other == *pair));
                frames.push(frame);
            }
            None => {
                left.remove(0);
            }
        }
    }
    frames
}

/// A frame with the conditions of a row.
fn build(design: &Design, row: &Row, rng: &mut ChaCha8Rng) -> Option<Frame> {
    let input = design.input();
    let (whole, per_beat) = (design.source().beats(), design.source().words_per_beat);
    let beats = match row[0] {
        Short => rng.random_range(1..whole),
        Long => whole + rng.random_range(1..=3),
        FarTooLong => LONG.max(3 * whole) + rng.random_range(1..=3),
        _ => whole,
    };
    let mut frame = random_frame(design, false, rng);
    let words = input.low.len();
    let sent = words.min(beats * per_beat);
    let last = (beats.min(whole) - 1) * per_beat..sent;
    let mut set = |words: std::ops::Range<usize>, code: fn(&Design, usize) -> Option<i64>| {
        let fit: Vec<usize> = words.filter(|w| code(design, *w).is_some()).collect();
        let word = *fit.choose(rng)?;
        frame.lanes[word] = code(design, word)?;
        Some(())
    };
    match row[1] {
        AtLow => frame.lanes[..words].copy_from_slice(&input.low),
        AtHigh => frame.lanes[..words].copy_from_slice(&input.high),
        JustBelow => set(0..sent, below)?,
        JustAbove => set(0..sent, above)?,
        ClippedFirst => set(0..per_beat.min(words), beyond)?,
        ClippedLast => set(last, beyond)?,
        _ => {}
    }
    let lane = lane_format(design);
    let lanes = beats * per_beat;
    while frame.lanes.len() < lanes {
        frame
            .lanes
            .push(rng.random_range(lane.min_code()..=lane.max_code()));
    }
    frame.lanes.truncate(lanes);
    Some(Frame {
        beats,
        row: Some(*row),
        ..frame
    })
}
