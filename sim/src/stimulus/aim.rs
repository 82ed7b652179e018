//! Resets at chosen moments: at every cycle of one frame, and wherever a reset changes a register.

use hwgen_spec::design::Design;
use rand::{RngExt, seq::SliceRandom};
use rand_chacha::ChaCha8Rng;

use super::{Effort, Flow, Frame, PIECE_CLOCKS, ResetAt, Resets, Segment, Share, random_frame};
use crate::model::{Model, Pins};
use crate::session;

/// Cycles of a check that the sweep of resets may take, unless it is to be thorough.
const SWEEP_CYCLES: usize = 65_536;
/// Of how many resets of the sweep an interpreting simulator has one.
const INTERPRETED_PART: usize = 8;
/// The longest reset of the sweep; a thorough one has each length at each moment.
const MOST_CYCLES: usize = 8;
/// The sweep has so many moments at least, at whatever interval.
const LEAST_MOMENTS: usize = 16;
/// How often resets are added for lanes that those before have not changed.
const MOST_PASSES: usize = 12;
/// Cycles of the run in which moments for aimed resets are looked for, beyond latency and intervals.
const SEARCH_CYCLES: usize = 256;

/// For each lane of all registers: whether the reset, where it is now, changes what the next edge
/// brings.
pub(crate) fn reset_lanes(model: &Model, pins: &Pins) -> Vec<bool> {
    let after = |mut model: Model, pins: &Pins| {
        model.step(pins);
        let mut row = Vec::new();
        model.values(&mut row);
        row
    };
    let released = Pins {
        reset_n: true,
        ..pins.clone()
    };
    let with = after(model.clone(), pins);
    let without = after(model.without_reset(), &released);
    with.iter().zip(&without).map(|(a, b)| a != b).collect()
}

/// Lanes that a reset of one cycle changes on its way, with the pins of its cycle and of the next two.
fn lanes_of_a_reset(model: &Model, pins: [&Pins; 3]) -> Vec<bool> {
    let mut model = model.clone();
    let mut lanes: Vec<bool> = Vec::new();
    for (cycle, pins) in pins.into_iter().enumerate() {
        let pins = Pins {
            reset_n: cycle > 0,
            ..pins.clone()
        };
        let now = reset_lanes(&model, &pins);
        lanes.resize(now.len(), false);
        for (lane, now) in lanes.iter_mut().zip(now) {
            *lane |= now;
        }
        model.step(&pins);
    }
    lanes
}

/// The run in which moments for aimed resets are looked for: without a reset of its own.
fn search_run(design: &Design, rng: &mut ChaCha8Rng) -> Segment {
    let count = 8 + 2 * design.latency_cycles() / design.interval_cycles();
    Segment {
        name: "aimed x reset".into(),
        flow: Flow::Mixed,
        frames: (0..count)
            .map(|_| random_frame(design, true, rng))
            .collect(),
        seed: rng.random(),
        resets: Resets::At(Vec::new()),
        reset_lanes: Vec::new(),
        share: Share::Fastest,
    }
}

/// A moment, in cycles since the last reset, and the lanes that a reset changes there.
type Candidate = (usize, Vec<bool>);

/// All moments of a run at which a reset may come.
fn candidates(design: &Design, run: &Segment) -> Vec<Candidate> {
    let most = 2 * design.latency_cycles() + 4 * design.interval_cycles() + SEARCH_CYCLES;
    // The second of two rounds: at power-up there are zeros where later there is data.
    let two = Segment {
        resets: Resets::At(vec![ResetAt {
            after: most,
            cycles: 1,
        }]),
        ..run.clone()
    };
    let pins = session::run(design, &two).pins;
    let first = pins
        .iter()
        .rposition(|pins| !pins.reset_n)
        .map_or(0, |at| at + 1);
    let pins_of_round = &pins[first..];
    let mut model = Model::new(design);
    let mut moments = Vec::new();
    for (cycle, pins) in pins.iter().enumerate().take(first + most) {
        if cycle >= first {
            // Behind the reset the next round begins, as this one has.
            let pins = [pins, &pins_of_round[0], &pins_of_round[1]];
            moments.push((moments.len(), lanes_of_a_reset(&model, pins)));
        }
        model.step(pins);
    }
    // In the first cycles the reset before is still on its way.
    moments.drain(..moments.len().min(3));
    moments
}

/// Takes moments out of the candidates that together change all lanes that are left.
fn choose(candidates: &mut Vec<Candidate>, mut left: Vec<bool>) -> Vec<usize> {
    let mut chosen = Vec::new();
    while left.contains(&true) {
        let new = |lanes: &[bool]| lanes.iter().zip(&left).filter(|(m, l)| **m && **l).count();
        // Where several are as good, the earliest is the shortest.
        let gain = |(at, lanes): &Candidate| (new(lanes), std::cmp::Reverse(*at));
        let Some(best) = (0..candidates.len()).max_by_key(|i| gain(&candidates[*i])) else {
            break;
        };
        if new(&candidates[best].1) == 0 {
            break;
        }
        let (at, lanes) = candidates.swap_remove(best);
        chosen.push(at);
        for (left, lane) in left.iter_mut().zip(lanes) {
            *left &= !lane;
        }
    }
    chosen
}

/// Resets so that each lane that a reset changes at any moment of a run is changed by one of them.
fn aimed(design: &Design, rng: &mut ChaCha8Rng) -> Segment {
    let mut run = search_run(design, rng);
    let mut candidates = candidates(design, &run);
    let lanes = candidates.first().map_or(0, |(_, lanes)| lanes.len());
    let changed = |lane: usize| candidates.iter().any(|(_, lanes)| lanes[lane]);
    run.reset_lanes = (0..lanes).map(changed).collect();
    let mut left = run.reset_lanes.clone();
    let mut resets: Vec<ResetAt> = Vec::new();
    // Data that is not reset differs from round to round, so the run itself is asked.
    for _ in 0..MOST_PASSES {
        for after in choose(&mut candidates, left.clone()) {
            // The shortest, which is the hardest; the sweep has the others.
            resets.push(ResetAt { after, cycles: 1 });
        }
        run.resets = Resets::At(resets.clone());
        let done = session::run(design, &run).reset_lanes;
        left = run.reset_lanes.clone();
        for (left, done) in left.iter_mut().zip(done) {
            *left &= !done;
        }
        if !left.contains(&true) {
            break;
        }
    }
    run
}

/// Aimed resets, and the sweep over one interval of the full core.
pub(super) fn segments(design: &Design, effort: Effort, rng: &mut ChaCha8Rng) -> Vec<Segment> {
    let mut all = vec![aimed(design, rng)];

    let interval = design.interval_cycles();
    let full = design.latency_cycles() + 2 * interval;
    let moments = interval.max(LEAST_MOMENTS);
    let count = (full + moments) / interval + 3;
    let frames: Vec<Frame> = (0..count)
        .map(|_| random_frame(design, true, rng))
        .collect();
    let thorough = effort == Effort::Thorough;
    let most = match thorough {
        true => moments,
        false => (SWEEP_CYCLES / (full + moments)).clamp(LEAST_MOMENTS, moments),
    };
    let mut sweep: Vec<usize> = (0..moments).collect();
    sweep.shuffle(rng);
    sweep.truncate(most);
    let mut push = |moments: &[usize], share| {
        let mut resets: Vec<ResetAt> = moments
            .iter()
            .flat_map(|moment| {
                let lengths = match thorough {
                    true => 1..=MOST_CYCLES,
                    false => 1 + moment % MOST_CYCLES..=1 + moment % MOST_CYCLES,
                };
                lengths.map(move |cycles| ResetAt {
                    after: full + moment,
                    cycles,
                })
            })
            .collect();
        resets.sort_unstable_by_key(|reset| (reset.after, reset.cycles));
        let piece = (PIECE_CLOCKS / (full + interval)).max(1);
        let pieces = resets.len().div_ceil(piece);
        for (number, resets) in resets.chunks(piece).enumerate() {
            let part = match pieces {
                1 => String::new(),
                _ => format!(" {} of {pieces}", number + 1),
            };
            all.push(Segment {
                name: format!("sweep x reset{part}"),
                flow: Flow::Continuous,
                frames: frames.clone(),
                seed: rng.random(),
                resets: Resets::At(resets.to_vec()),
                reset_lanes: Vec::new(),
                share,
            });
        }
    };
    if thorough {
        push(&sweep, Share::All);
    } else {
        let part = sweep.len().div_ceil(INTERPRETED_PART);
        push(&sweep[..part], Share::Interpreted);
        push(&sweep, Share::Compiled);
    }
    all
}
