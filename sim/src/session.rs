//! One segment driven through the model: the pins of every clock, and what came out.

use hwgen_spec::design::Design;
use hwgen_spec::format::to_bits;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::VecDeque;
use std::fmt::Write as _;

use crate::model::{Model, Pins};
use crate::stimulus::{Flow, Frame, Segment, lane_format};

/// Clocks of reset at the start.
const RESET_CLOCKS: usize = 5;
/// Resets in the flow that has any.
const RESETS: usize = 6;
/// Clocks that a session may take beyond what its frames need, before it counts as hung.
const PATIENCE: usize = 100_000;

/// A frame of answers at the pins.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Expected {
    codes: Vec<i64>,
    user: i64,
    taken_at: Option<usize>,
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
    }
}

/// Drives a segment through the model and checks its answers.
pub fn run(design: &Design, segment: &Segment) -> Session {
    let mut driver = Driver::new(design, segment);
    let patience = PATIENCE + segment.frames.len() * 40 * design.interval_cycles();
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
    /// Resets still to come, and clocks to the next one.
    resets: usize,
    until_reset: usize,
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
            reset_left: RESET_CLOCKS,
            resets: match segment.flow {
                Flow::Reset => RESETS,
                _ => 0,
            },
            until_reset: 0,
            first_beat_at: None,
            last_answer_at: None,
        }
    }

    fn finished(&self) -> bool {
        self.frame == self.segment.frames.len() && self.expected.is_empty()
    }

    /// Counts down to the next reset.
    ///
    /// One half of them come while the core fills, the other half while answers leave: a reset
    /// that comes before the first answer can't show whether the way out forgets what it holds.
    fn reset(&mut self) {
        if self.resets == 0 {
            return;
        }
        if self.until_reset > 0 {
            self.until_reset -= 1;
            if self.until_reset == 0 {
                self.reset_left = self.rng.random_range(3..=5);
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
            Flow::Continuous => {}
            Flow::Idle => self.offer = pace,
            Flow::BackPressure => self.take = pace,
            Flow::Reset => {
                (self.offer, self.take) = (pace, self.rng.random_range(0.2..=1.0));
            }
        }
    }

    fn pins(&mut self) -> Pins {
        let reset_n = self.reset_left == 0;
        let wants = self.frame < self.segment.frames.len();
        // A master holds TVALID low in reset and never takes an offer back.
        self.offered = reset_n && wants && (self.offered || self.rng.random_bool(self.offer));
        let per_beat = self.design.source().words_per_beat;
        // Pins that do not count carry noise: nothing may depend on them.
        let noise = lane_format(self.design);
        let mut s_last = self.rng.random();
        let mut s_data: Vec<i64> = (0..per_beat)
            .map(|_| self.rng.random_range(noise.min_code()..=noise.max_code()))
            .collect();
        if self.offered {
            let frame = &self.segment.frames[self.frame];
            s_last = self.beat + 1 == frame.beats;
            s_data.copy_from_slice(&frame.lanes[self.beat * per_beat..(self.beat + 1) * per_beat]);
        }
        let m_ready = self.rng.random_bool(self.take);
        Pins {
            reset_n,
            s_valid: if reset_n { self.offered } else { self.rng.random() },
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
        let now = self.session.pins.len();
        if pins.reset_n {
            self.check_output(now, pins.m_ready);
            if pins.s_valid && self.model.ready() {
                self.beat_taken(now);
            }
        } else {
            // All that is under way is lost: it is sent once more, from the oldest frame on.
            self.frame -= self.expected.len();
            (self.beat, self.offered, self.answered, self.held) = (0, false, 0, None);
            self.expected.clear();
            (self.first_beat_at, self.last_answer_at) = (None, None);
            self.reset_left -= 1;
        }
        self.model.step(&pins);
        self.session.pins.push(pins);
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
            self.expected.push_back(expected);
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
        self.expected.pop_front();
        self.answered = 0;
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
