//! What is driven into the core: frames by class, crossed with the manner of their flow.

use hwgen_spec::design::Design;
use hwgen_spec::format::QFormat;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

pub(crate) mod aim;
mod cross;
pub(crate) mod tables;

pub(crate) use cross::LONG;
pub use cross::{Condition, Pairs};

/// Clocks of continuous flow that one segment takes, about.
const PIECE_CLOCKS: usize = 8192;

/// One input frame as it is sent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frame {
    /// Codes of the words that are sent; a well-formed frame has one an input.
    ///
    /// Lanes of the last beat that carry no word are sent too, as they come.
    pub lanes: Vec<i64>,
    /// Beats that are sent, TLAST on the last.
    pub beats: usize,
    /// The conditions that it is made for, where it is one of those that cross them.
    pub(crate) row: Option<cross::Row>,
}

/// How frames are sent and answers taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// A beat whenever the core takes one, answers taken at once.
    Continuous,
    /// Pauses between beats and frames.
    Idle,
    /// Answers taken now and then.
    BackPressure,
    /// Pauses on both sides, and resets in the middle of it all.
    Reset,
    /// Pauses on both sides.
    Mixed,
    /// As the conditions of each frame say.
    Crossed,
}

impl Flow {
    /// Those that every class of frames is driven in.
    pub const ALL: [Self; 4] = [
        Self::Continuous,
        Self::Idle,
        Self::BackPressure,
        Self::Reset,
    ];

    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Continuous => "continuous",
            Self::Idle => "idle",
            Self::BackPressure => "back-pressure",
            Self::Reset => "reset",
            Self::Mixed => "mixed",
            Self::Crossed => "crossed",
        }
    }
}

/// Frames of one class in one flow: one run of the simulators.
#[derive(Clone, Debug)]
pub struct Segment {
    /// `corners x idle`
    pub name: String,
    /// The flow.
    pub flow: Flow,
    /// The frames in order.
    pub frames: Vec<Frame>,
    /// Seed of pauses and resets.
    pub seed: u64,
    /// When resets come.
    pub resets: Resets,
    /// Lanes of registers that its resets have to change.
    pub reset_lanes: Vec<bool>,
    /// Which simulators replay it.
    pub share: Share,
}

/// When resets come.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Resets {
    /// Never.
    None,
    /// At random moments.
    Random,
    /// At these moments, one after the other.
    At(Vec<ResetAt>),
}

/// A reset at a chosen moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ResetAt {
    /// Cycles since the end of the reset before.
    pub after: usize,
    /// Its length in cycles.
    pub cycles: usize,
}

impl Resets {
    /// The chosen moments.
    pub fn planned(&self) -> &[ResetAt] {
        match self {
            Self::At(resets) => resets,
            _ => &[],
        }
    }
}

/// How much is driven.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// Classes of frames in each flow alone, without crossed conditions, aimed resets, the sweep of resets
    /// and the run of hundreds of frames, and the structure is not checked: for a look at many designs, not
    /// for a verdict on one.
    Quick,
    /// What a verdict takes.
    Usual,
    /// And every reset of the sweep in every simulator, at whatever interval.
    Thorough,
}

/// Which simulators replay a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Share {
    /// All of them.
    All,
    /// Those that compile the Verilog: for what would take too long in others.
    Compiled,
    /// Those that compile the Verilog if there is one, else all.
    Fastest,
    /// Those that interpret it: what they have in place of a longer one.
    Interpreted,
}

/// Frames of the run with hundreds of them.
const MANY_FRAMES: usize = 320;

/// Beyond this interval the continuous flow alone has all corners, and the others share them.
///
/// Corners are there for the values, which do not depend on the flow, and at a long interval few
/// frames are under way: a third of the corners, about nine, fill the core many times over. The
/// time of a check grows with the interval, so that the repetitions would be most of it.
const LONG_INTERVAL: usize = 16;

/// The segments of a check: corners, random frames, malformed frames, rows of a file, each in
/// every flow.
///
/// # Shape
/// `vectors`: `[row][in]` in raw units; rows and random frames are spread over the flows.
pub fn segments(
    design: &Design,
    vectors: &[Vec<f64>],
    random: usize,
    seed: u64,
    effort: Effort,
) -> Vec<Segment> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let corners = corners(design, &mut rng);
    let random: Vec<Frame> = (0..random)
        .map(|_| random_frame(design, true, &mut rng))
        .collect();
    let malformed = malformed(design, &mut rng);
    let rows: Vec<Frame> = vectors
        .iter()
        .map(|row| whole(design, design.input().codes(row), &mut rng))
        .collect();
    let tables: Vec<Frame> = match effort {
        Effort::Quick => Vec::new(),
        _ => {
            let inputs = design.input().low.len();
            let known = corners.iter().chain(&random).chain(&rows);
            let known = known.map(|frame| frame.lanes[..inputs].to_vec());
            let chosen = tables::inputs(design, known, &mut rng).into_iter();
            chosen.map(|codes| whole(design, codes, &mut rng)).collect()
        }
    };
    let mut segments = Vec::new();
    // Long runs are cut into pieces whose dumps stay small.
    let piece = (PIECE_CLOCKS / design.interval_cycles()).clamp(16, 1024);
    let mut push = |class: &str, flow: Flow, frames: &[Frame]| {
        let pieces = frames.len().div_ceil(piece);
        for (number, frames) in frames.chunks(piece).enumerate() {
            let seed = rng.random();
            let mut name = format!("{class} x {}", flow.name());
            if pieces > 1 {
                name.push_str(&format!(" {} of {pieces}", number + 1));
            }
            segments.push(Segment {
                name,
                flow,
                frames: frames.to_vec(),
                seed,
                resets: match flow {
                    Flow::Reset => Resets::Random,
                    _ => Resets::None,
                },
                reset_lanes: Vec::new(),
                share: Share::All,
            });
        }
    };
    let long = design.interval_cycles() > LONG_INTERVAL;
    for (i, flow) in Flow::ALL.into_iter().enumerate() {
        if long && i > 0 {
            let others = Flow::ALL.len() - 1;
            let share: Vec<Frame> = corners
                .iter()
                .skip(i - 1)
                .step_by(others)
                .cloned()
                .collect();
            push("corners", flow, &share);
        } else {
            push("corners", flow, &corners);
        }
        push("malformed", flow, &malformed);
        let share = |frames: &[Frame]| -> Vec<Frame> {
            frames
                .iter()
                .skip(i)
                .step_by(Flow::ALL.len())
                .cloned()
                .collect()
        };
        push("random", flow, &share(&random));
        push("file", flow, &share(&rows));
    }
    push("tables", Flow::Continuous, &tables);
    if effort != Effort::Quick {
        segments.extend(crossed(design, &mut rng));
        segments.extend(aim::segments(design, effort, &mut rng));
    }
    segments
}

/// Frames in which all pairs of conditions occur, and hundreds of frames in one run.
fn crossed(design: &Design, rng: &mut ChaCha8Rng) -> Vec<Segment> {
    let many: Vec<Frame> = (0..MANY_FRAMES)
        .map(|_| random_frame(design, true, rng))
        .collect();
    // Hundreds of frames take long where frames are far apart.
    let share = match MANY_FRAMES * design.interval_cycles() {
        0..=PIECE_CLOCKS => Share::All,
        _ => Share::Compiled,
    };
    let mut segment = |name: &str, flow, frames, share| Segment {
        name: format!("{name} x {}", Flow::name(flow)),
        flow,
        frames,
        seed: rng.random(),
        resets: Resets::None,
        reset_lanes: Vec::new(),
        share,
    };
    let mut all = vec![segment("many frames", Flow::Mixed, many, share)];
    let frames = cross::crossed(design, rng);
    all.push(Segment {
        name: "conditions x crossed".into(),
        flow: Flow::Crossed,
        frames,
        seed: rng.random(),
        resets: Resets::None,
        reset_lanes: Vec::new(),
        share: Share::All,
    });
    all
}

/// A frame of the right length; lanes without a word carry noise.
fn whole(design: &Design, mut codes: Vec<i64>, rng: &mut impl Rng) -> Frame {
    let source = design.source();
    let lane = lane_format(design);
    while codes.len() < source.beats() * source.words_per_beat {
        codes.push(rng.random_range(lane.min_code()..=lane.max_code()));
    }
    Frame {
        lanes: codes,
        beats: source.beats(),
        row: None,
    }
}

pub(crate) fn lane_format(design: &Design) -> QFormat {
    QFormat::new(design.source().lane_bits, 0).expect("a lane is a word")
}

/// The corners of the box, its inside, its outside, one input at a time and all together.
fn corners(design: &Design, rng: &mut ChaCha8Rng) -> Vec<Frame> {
    let input = design.input();
    let lane = lane_format(design);
    let inputs = input.low.len();
    let middle: Vec<i64> = input
        .low
        .iter()
        .zip(&input.high)
        .map(|(l, h)| l + (h - l) / 2)
        .collect();
    let step = |codes: &[i64], by: i64| -> Vec<i64> {
        codes.iter().map(|c| lane.saturate(c + by).code).collect()
    };
    let alternating = |first: &[i64], second: &[i64]| -> Vec<i64> {
        (0..inputs)
            .map(|i| if i % 2 == 0 { first[i] } else { second[i] })
            .collect()
    };
    let mut rows = vec![
        input.low.clone(),
        input.high.clone(),
        middle.clone(),
        vec![0; inputs],
        vec![-1; inputs],
        vec![1; inputs],
        alternating(&input.low, &input.high),
        alternating(&input.high, &input.low),
        step(&input.low, -1),
        step(&input.high, 1),
        vec![lane.min_code(); inputs],
        vec![lane.max_code(); inputs],
    ];
    // One input at its edges, the others in the middle; a few of them where there are many.
    for i in (0..inputs).step_by(inputs.div_ceil(6)) {
        for edge in [input.low[i], input.high[i], lane.max_code()] {
            let mut row = middle.clone();
            row[i] = edge;
            rows.push(row);
        }
    }
    for _ in 0..8 {
        rows.push(
            (0..inputs)
                .map(|i| {
                    if rng.random_bool(0.5) {
                        input.low[i]
                    } else {
                        input.high[i]
                    }
                })
                .collect(),
        );
    }
    rows.into_iter()
        .map(|row| whole(design, row, rng))
        .collect()
}

/// Uniform in the box; with `strays`, one frame in sixteen has a word from anywhere in its lane.
fn random_frame(design: &Design, strays: bool, rng: &mut ChaCha8Rng) -> Frame {
    let input = design.input();
    let mut codes: Vec<i64> = input
        .low
        .iter()
        .zip(&input.high)
        .map(|(low, high)| rng.random_range(*low..=*high))
        .collect();
    if strays && rng.random_ratio(1, 16) {
        let lane = lane_format(design);
        let at = rng.random_range(0..codes.len());
        codes[at] = rng.random_range(lane.min_code()..=lane.max_code());
    }
    whole(design, codes, rng)
}

/// Frames that are too short or too long among whole ones.
fn malformed(design: &Design, rng: &mut ChaCha8Rng) -> Vec<Frame> {
    let beats = design.source().beats();
    let mut lengths = vec![beats + 1, beats, 2 * beats + 3, beats];
    if beats > 1 {
        lengths.extend([1, beats, beats - 1, beats.div_ceil(2), beats]);
    }
    lengths.push(beats + 2);
    lengths
        .into_iter()
        .map(|beats| {
            let mut frame = random_frame(design, true, rng);
            let lanes = beats * design.source().words_per_beat;
            while frame.lanes.len() < lanes {
                let filler = frame.lanes[frame.lanes.len() % 3 % frame.lanes.len()];
                frame.lanes.push(filler);
            }
            frame.lanes.truncate(lanes);
            Frame { beats, ..frame }
        })
        .collect()
}
