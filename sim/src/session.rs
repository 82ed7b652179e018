//! One segment driven through the model: the pins of every clock, and what came out.

use hwgen_spec::design::Design;
use hwgen_spec::format::to_bits;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::VecDeque;
use std::fmt::Write as _;

use crate::model::{Model, Pins};
use crate::stimulus::aim::reset_lanes;
use crate::stimulus::{
    Condition, Condition::*, Flow, Frame, LONG, Pairs, Resets, Segment, lane_format,
};

/// Cycles of reset at the start.
const RESET_CYCLES: usize = 5;
/// Resets in the flow that has random ones.
const RESETS: usize = 6;
/// Pauses of so many cycles count as hundreds.
const HUNDREDS: usize = 200;
/// Clocks that a session may take beyond what its frames need, before it counts as hung.
const PATIENCE: usize = 100_000;

/// A frame of answers at the pins.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Expected {
    codes: Vec<i64>,
    user: i64,
    taken_at: Option<usize>,
    /// Its frame in the segment.
    frame: usize,
    /// Idle cycles while it was sent, cycles that its output waited.
    idle: usize,
    stalled: usize,
}

/// Where the pins of the model part from the untimed values or from the protocol.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PinDifference {
    /// Rising edge.
    pub clock: usize,
    /// The port.
    pub signal: &'static str,
    /// Lane of TDATA.
    pub lane: usize,
    /// What the untimed model says.
    pub expected: i64,
    /// What stands at the port.
    pub found: i64,
    /// In words.
    pub note: String,
}

/// What a segment led to.
#[derive(Clone, Debug)]
pub struct Session {
    /// The pins of every clock.
    pub pins: Vec<Pins>,
    /// Frames whose answers were compared with the untimed values.
    pub frames: usize,
    /// Words of these.
    pub words: usize,
    /// Frames with a word inside saturated or an input outside of the box.
    pub saturated: usize,
    /// Clocks from the first beat of the first frame to its last answer, in continuous flow.
    pub latency: Option<usize>,
    /// Least and greatest distance between answers, in continuous flow.
    pub interval: Option<(usize, usize)>,
    /// Pairs of conditions of the frames that have a row of them.
    pub pairs: Pairs,
    /// For each lane of a register: whether a reset came while it made a difference to it.
    pub reset_lanes: Vec<bool>,
    /// Resets that were driven, the first one aside.
    pub resets: usize,
    /// The first difference.
    pub difference: Option<PinDifference>,
}

/// What the core has to answer to a frame.
fn expectation(design: &Design, frame: &Frame) -> Expected {
    let input = design.input();
    let (inputs, per_beat) = (input.low.len(), design.source().words_per_beat);
    // Words that were not sent take the lower edge of the box.
    let sent = (frame.beats * per_beat).min(inputs);
    let mut codes = input.low.clone();
    codes[..sent].copy_from_slice(&frame.lanes[..sent]);
    let answer = design.net().evaluate(&codes);
    let error = frame.beats != design.source().beats();
    let user = i64::from(answer.saturated || answer.input_clipped) | i64::from(error) << 1;
    Expected {
        codes: answer.codes,
        user,
        taken_at: None,
        frame: 0,
        idle: 0,
        stalled: 0,
    }
}

/// Drives a segment through the model and checks its answers.
pub fn run(design: &Design, segment: &Segment) -> Session {
    let mut driver = Driver::new(design, segment);
    let rounds = segment.resets.planned().len();
    let patience = PATIENCE
        + (1 + rounds) * (segment.frames.len() * 40 * design.interval_cycles())
        + segment
            .resets
            .planned()
            .iter()
            .map(|r| r.after)
            .sum::<usize>();
    while !driver.finished() && driver.session.difference.is_none() {
        driver.clock();
        if driver.session.pins.len() > patience {
            driver.differ("m_axis_tvalid", 0, (1, 0), "no answer comes any more");
        }
    }
    // A few clocks more, so that nothing comes that nobody asked for.
    for _ in 0..design.latency_cycles() + 4 {
        if driver.session.difference.is_none() {
            driver.clock();
        }
    }
    driver.session
}

struct Driver<'a> {
    design: &'a Design,
    segment: &'a Segment,
    rng: ChaCha8Rng,
    model: Model,
    session: Session,
    /// Frame and beat to be sent next.
    frame: usize,
    beat: usize,
    /// The beat is offered, and stays so until it is taken.
    offered: bool,
    /// Answers that are still to come.
    expected: VecDeque<Expected>,
    /// Beats of the present answer that came.
    answered: usize,
    /// The beat that stood at the port and was not taken.
    held: Option<(Vec<i64>, i64, bool)>,
    /// Probabilities of the present phase: that a beat is offered, that an answer is taken.
    offer: f64,
    take: f64,
    phase_left: usize,
    reset_left: usize,
    /// Random resets still to come, and cycles to the next one.
    resets: usize,
    until_reset: usize,
    /// The next one of the planned resets, and cycles since the last reset ended.
    round: usize,
    since_reset: usize,
    /// Frames that were dropped by a reset on purpose.
    dropped: Vec<usize>,
    /// Cycles to the reset that drops the last frame that was sent, where one does.
    until_drop: Option<usize>,
    /// Idle cycles that are still to come before this beat of the present frame, and those that came.
    pause: Option<(usize, usize)>,
    idle: usize,
    /// Cycles that the present output is still to wait, once it is there.
    stall: Option<usize>,
    first_beat_at: Option<usize>,
    last_answer_at: Option<usize>,
    /// Whether latency and interval are those of continuous flow.
    measures: bool,
}

impl<'a> Driver<'a> {
    fn new(design: &'a Design, segment: &'a Segment) -> Self {
        let whole = |f: &Frame| f.beats == design.source().beats();
        Self {
            measures: segment.flow == Flow::Continuous && segment.frames.iter().all(whole),
            design,
            segment,
            rng: ChaCha8Rng::seed_from_u64(segment.seed),
            model: Model::new(design),
            session: Session {
                pins: Vec::new(),
                frames: 0,
                words: 0,
                saturated: 0,
                latency: None,
                interval: None,
                pairs: Pairs::default(),
                reset_lanes: Vec::new(),
                resets: 0,
                difference: None,
            },
            frame: 0,
            beat: 0,
            offered: false,
            expected: VecDeque::new(),
            answered: 0,
            held: None,
            offer: 1.0,
            take: 1.0,
            phase_left: 0,
            reset_left: RESET_CYCLES,
            resets: match segment.resets {
                Resets::Random => RESETS,
                _ => 0,
            },
            until_reset: 0,
            round: 0,
            since_reset: 0,
            dropped: Vec::new(),
            until_drop: None,
            pause: None,
            idle: 0,
            stall: None,
            first_beat_at: None,
            last_answer_at: None,
        }
    }

    fn finished(&self) -> bool {
        self.round == self.segment.resets.planned().len()
            && self.frame == self.segment.frames.len()
            && self.expected.is_empty()
    }

    /// Counts down to the next reset.
    ///
    /// One half of them come while the core fills, the other half while answers leave: a reset
    /// that comes before the first answer can't show whether the way out forgets what it holds.
    fn reset(&mut self) {
        if let Some(next) = self.segment.resets.planned().get(self.round) {
            if self.since_reset >= next.after {
                self.reset_left = next.cycles;
                self.round += 1;
                self.frame = self.expected.len();
            }
            return;
        }
        if let Some(left) = self.until_drop {
            self.until_drop = left.checked_sub(1);
            if left == 0 {
                self.reset_left = self.rng.random_range(1..=8);
            }
            return;
        }
        if self.resets == 0 {
            return;
        }
        if self.until_reset > 0 {
            self.until_reset -= 1;
            if self.until_reset == 0 {
                self.reset_left = self.rng.random_range(1..=8);
                self.resets -= 1;
            }
            return;
        }
        let (latency, interval) = (self.design.latency_cycles(), self.design.interval_cycles());
        self.until_reset = if self.resets.is_multiple_of(2) {
            latency + self.rng.random_range(1..=4 * interval + 8)
        } else {
            self.rng.random_range(1..=latency)
        };
    }

    /// Draws new probabilities now and then.
    fn phase(&mut self) {
        if self.phase_left > 0 {
            self.phase_left -= 1;
            return;
        }
        let interval = self.design.interval_cycles();
        self.phase_left = self.rng.random_range(1..=4 * interval + 8);
        // Beats that keep up with the interval, a burst, or a trickle.
        let dense = self.rng.random_range(0.3..1.0);
        let pace = [1.0, dense, 0.05][self.rng.random_range(0..3)];
        match self.segment.flow {
            Flow::Continuous | Flow::Crossed => {}
            Flow::Idle => self.offer = pace,
            Flow::BackPressure => self.take = pace,
            Flow::Mixed | Flow::Reset => {
                (self.offer, self.take) = (pace, self.rng.random_range(0.2..=1.0));
            }
        }
    }

    fn pins(&mut self) -> Pins {
        let reset_n = self.reset_left == 0;
        let wants = self.frame < self.segment.frames.len();
        // A master holds TVALID low in reset and never takes an offer back.
        // A planned reset meets the pins that would have been without it.
        let planned = matches!(self.segment.resets, Resets::At(_));
        self.offered = (reset_n || planned) && wants && (self.offered || self.offers());
        let per_beat = self.design.source().words_per_beat;
        // Pins that do not count carry noise: nothing may depend on them.
        let noise = lane_format(self.design);
        let mut s_last = self.rng.random();
        let pattern = self.rng.random_range(0..4);
        let mut s_data: Vec<i64> = (0..per_beat)
            .map(|lane| match pattern {
                0 => 0,
                1 => -1,
                // A word that could be one of a frame.
                2 => self.design.input().high[lane % self.design.input().high.len()],
                _ => self.rng.random_range(noise.min_code()..=noise.max_code()),
            })
            .collect();
        if self.offered {
            let frame = &self.segment.frames[self.frame];
            s_last = self.beat + 1 == frame.beats;
            s_data.copy_from_slice(&frame.lanes[self.beat * per_beat..(self.beat + 1) * per_beat]);
        }
        let m_ready = self.takes();
        Pins {
            reset_n,
            s_valid: if reset_n || planned {
                self.offered
            } else {
                self.rng.random()
            },
            s_last,
            s_data,
            m_ready,
        }
    }

    fn clock(&mut self) {
        if self.reset_left == 0 {
            self.phase();
            self.reset();
        }
        let pins = self.pins();
        self.note_resets(&pins);
        let now = self.session.pins.len();
        if pins.reset_n {
            self.since_reset += 1;
            self.idle += usize::from(!pins.s_valid && self.frame < self.segment.frames.len());
            self.check_output(now, pins.m_ready);
            if pins.s_valid && self.model.ready() {
                self.beat_taken(now);
            }
        } else {
            // All that is under way is lost: it is sent once more, from the oldest frame on.
            self.count_dropped();
            self.frame -= self.expected.len();
            (self.since_reset, self.idle) = (0, 0);
            (self.pause, self.stall, self.until_drop) = (None, None, None);
            (self.beat, self.offered, self.answered, self.held) = (0, false, 0, None);
            self.expected.clear();
            (self.first_beat_at, self.last_answer_at) = (None, None);
            self.reset_left -= 1;
            if self.reset_left == 0 && matches!(self.segment.resets, Resets::At(_)) {
                // Each round sends the same in the same way.
                self.rng = ChaCha8Rng::seed_from_u64(self.segment.seed);
                self.phase_left = 0;
            }
        }
        self.model.step(&pins);
        self.session.pins.push(pins);
    }

    /// Whether a beat is offered in this cycle that was not offered before.
    fn offers(&mut self) -> bool {
        let frame = &self.segment.frames[self.frame];
        let Some(row) = &frame.row else {
            return self.rng.random_bool(self.offer);
        };
        if self.pause.is_none() {
            let cycles = match row[2] {
                LongIdle => LONG,
                Idle => self.rng.random_range(1..=6),
                _ => 0,
            };
            self.pause = Some((self.rng.random_range(0..frame.beats), cycles));
        }
        match &mut self.pause {
            Some((beat, cycles)) if *beat == self.beat && *cycles > 0 => {
                *cycles -= 1;
                false
            }
            _ => true,
        }
    }

    /// Whether an output beat is taken in this cycle, if there is one.
    fn takes(&mut self) -> bool {
        if self.segment.flow != Flow::Crossed {
            return self.rng.random_bool(self.take);
        }
        let row = self
            .expected
            .front()
            .and_then(|e| self.segment.frames[e.frame].row);
        let (Some(row), true) = (row, self.model.output().is_some()) else {
            return self.rng.random();
        };
        let left = match self.stall {
            Some(left) => left,
            None => match row[3] {
                LongStall => LONG,
                Stall => self.rng.random_range(1..=6),
                _ => 0,
            },
        };
        self.stall = Some(left.saturating_sub(1));
        left == 0
    }

    /// The present output waits in this cycle.
    fn stalled(&mut self) {
        let Some(head) = self.expected.front_mut() else {
            return;
        };
        head.stalled += 1;
        let (frame, stalled) = (head.frame, head.stalled);
        if (stalled == 1 && self.is_to_drop(frame, Stall))
            || (stalled == HUNDREDS && self.is_to_drop(frame, LongStall))
        {
            self.until_drop = Some(0);
        }
    }

    /// Whether a frame is one that a reset drops, with this wait of its output before it.
    fn is_to_drop(&self, frame: usize, stall: Condition) -> bool {
        let row = self.segment.frames[frame].row;
        row.is_some_and(|row| row[4] == Reset && row[3] == stall) && !self.dropped.contains(&frame)
    }

    /// A reset begins: frames that were to be dropped are.
    fn count_dropped(&mut self) {
        for expected in std::mem::take(&mut self.expected) {
            let row = self.segment.frames[expected.frame].row;
            if row.is_some_and(|row| row[4] == Reset) && !self.dropped.contains(&expected.frame) {
                self.count_pairs(&expected, Reset);
                // A reset that another frame had coming may be too early for this one.
                let waited = match row.map(|row| row[3]) {
                    Some(Stall) => expected.stalled > 0,
                    Some(LongStall) => expected.stalled >= HUNDREDS,
                    _ => true,
                };
                if waited {
                    self.dropped.push(expected.frame);
                }
            }
            self.expected.push_back(expected);
        }
    }

    /// Counts the pairs of a frame: its own conditions as it was made, those of its way as they were.
    fn count_pairs(&mut self, expected: &Expected, reset: Condition) {
        let Some(mut row) = self.segment.frames[expected.frame].row else {
            return;
        };
        let class = |cycles, none, some, hundreds| match cycles {
            0 => none,
            1..HUNDREDS => some,
            _ => hundreds,
        };
        row[2] = class(expected.idle, NoIdle, Idle, LongIdle);
        row[3] = class(expected.stalled, NoStall, Stall, LongStall);
        row[4] = reset;
        self.session.pairs.count(&row);
    }

    /// Notes which lanes a reset that is on its way changes at this edge.
    fn note_resets(&mut self, pins: &Pins) {
        if self.session.pins.len() < RESET_CYCLES + 3 {
            return;
        }
        self.session.resets += usize::from(!pins.reset_n && self.since_reset > 0);
        if pins.reset_n && self.since_reset >= 3 {
            return;
        }
        let lanes = reset_lanes(&self.model, pins);
        let noted = &mut self.session.reset_lanes;
        noted.resize(lanes.len(), false);
        for (noted, now) in noted.iter_mut().zip(lanes) {
            *noted |= now;
        }
    }

    fn beat_taken(&mut self, now: usize) {
        self.offered = false;
        let frame = &self.segment.frames[self.frame];
        if self.beat == 0 {
            self.first_beat_at = Some(now);
        }
        self.beat += 1;
        if self.beat == frame.beats {
            let mut expected = expectation(self.design, frame);
            expected.taken_at = self.first_beat_at;
            (expected.frame, expected.idle) = (self.frame, self.idle);
            self.expected.push_back(expected);
            (self.pause, self.idle) = (None, 0);
            if self.is_to_drop(self.frame, NoStall) {
                let least = self
                    .design
                    .latency_cycles()
                    .saturating_sub(self.design.source().beats());
                let drop = self.rng.random_range(0..least.max(2));
                self.until_drop = Some(self.until_drop.map_or(drop, |before| before.min(drop)));
            }
            (self.frame, self.beat) = (self.frame + 1, 0);
        }
    }

    fn check_output(&mut self, now: usize, ready: bool) {
        let beat = self
            .model
            .output()
            .map(|b| (b.data.to_vec(), b.user, b.last));
        if let Some(held) = self.held.take()
            && beat.as_ref() != Some(&held)
        {
            self.differ(
                "m_axis_tvalid",
                0,
                (1, 0),
                "a beat changed before it was taken",
            );
            return;
        }
        let Some((data, user, last)) = beat else {
            return;
        };
        if !ready {
            self.stalled();
            self.held = Some((data, user, last));
            return;
        }
        let Some(expected) = self.expected.front().cloned() else {
            self.differ(
                "m_axis_tvalid",
                0,
                (0, 1),
                "an answer that no frame asked for",
            );
            return;
        };
        let sink = self.design.sink();
        for (lane, found) in data.iter().enumerate() {
            let word = self.answered * sink.words_per_beat + lane;
            let code = expected.codes.get(word).copied().unwrap_or(0);
            if *found != code {
                self.differ(
                    "m_axis_tdata",
                    lane,
                    (code, *found),
                    "not the untimed value",
                );
                return;
            }
        }
        let ends = self.answered + 1 == sink.beats();
        if last != ends {
            let pair = (i64::from(ends), i64::from(last));
            self.differ("m_axis_tlast", 0, pair, "TLAST is not on the last beat");
        } else if user != expected.user {
            self.differ(
                "m_axis_tuser",
                0,
                (expected.user, user),
                "not the untimed flags",
            );
        } else if ends {
            self.frame_answered(now, &expected);
        } else {
            self.answered += 1;
        }
    }

    fn frame_answered(&mut self, now: usize, expected: &Expected) {
        self.count_pairs(expected, NoReset);
        self.expected.pop_front();
        (self.answered, self.stall) = (0, None);
        self.session.frames += 1;
        self.session.words += expected.codes.len();
        self.session.saturated += usize::from(expected.user & 1 == 1);
        if !self.measures {
            return;
        }
        match self.last_answer_at {
            None => self.session.latency = expected.taken_at.map(|at| now - at),
            Some(before) => {
                let distance = now - before;
                let (least, most) = self.session.interval.unwrap_or((distance, distance));
                self.session.interval = Some((least.min(distance), most.max(distance)));
            }
        }
        self.last_answer_at = Some(now);
    }

    fn differ(
        &mut self,
        signal: &'static str,
        lane: usize,
        (expected, found): (i64, i64),
        note: &str,
    ) {
        let clock = self.session.pins.len();
        let note = note.to_owned();
        self.session.difference = Some(PinDifference {
            clock,
            signal,
            lane,
            expected,
            found,
            note,
        });
    }
}

/// The pins as the replaying bench reads them: one hexadecimal word a clock.
pub fn stimulus_text(design: &Design, pins: &[Pins]) -> String {
    let source = design.source();
    let lane = usize::try_from(source.lane_bits).expect("a small number");
    let digits = (4 + source.data_bits()).div_ceil(4);
    let mut text = String::with_capacity(pins.len() * (digits + 1));
    let mut nibbles = vec![0u8; digits];
    for pins in pins {
        nibbles.fill(0);
        let mut set = |bit: usize, on: bool| nibbles[bit / 4] |= u8::from(on) << (bit % 4);
        for (i, code) in pins.s_data.iter().enumerate() {
            let bits = to_bits(*code, source.lane_bits);
            (0..lane).for_each(|bit| set(i * lane + bit, bits >> bit & 1 == 1));
        }
        let top = source.data_bits();
        set(top, pins.m_ready);
        set(top + 1, pins.s_last);
        set(top + 2, pins.s_valid);
        set(top + 3, pins.reset_n);
        for nibble in nibbles.iter().rev() {
            write!(text, "{nibble:x}").expect("a string takes all");
        }
        text.push('\n');
    }
    text
}
