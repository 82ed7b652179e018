//! Resets at chosen moments: at every cycle of one frame, and wherever a reset changes a register.

use hwgen_spec::design::Design;
use rand::{RngExt, seq::SliceRandom};
use rand_chacha::ChaCha8Rng;

use super::{Flow, Frame, PIECE_CLOCKS, ResetAt, Resets, Segment, Share, random_frame};
use crate::model::{Model, Pins};
use crate::session;

/// Cycles of a check that the sweep of resets may take, unless it is to be thorough.
const SWEEP_CYCLES: usize = 65_536;
/// Of how many resets of the sweep an interpreting simulator has one.
const INTERPRETED_PART: usize = 8;
/// The sweep has so many moments at least, at whatever interval.
const LEAST_MOMENTS: usize = 16;
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

/// Lanes that a reset of one cycle changes on its way, if it comes with these pins.
fn lanes_of_a_reset(model: &Model, pins: &Pins) -> Vec<bool> {
    let mut model = model.clone();
    let mut lanes: Vec<bool> = Vec::new();
    for cycle in 0..3 {
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

/// Moments at which a reset changes lanes, so that each lane that any of them changes is changed by
/// one that is chosen; and these lanes.
fn aim(design: &Design, run: &Segment) -> (Vec<usize>, Vec<bool>) {
    let pins = session::run(design, run).pins;
    let most = 2 * design.latency_cycles() + 4 * design.interval_cycles() + SEARCH_CYCLES;
    let mut model = Model::new(design);
    let mut moments: Vec<(usize, Vec<bool>)> = Vec::new();
    let mut since = 0;
    for pins in pins.iter().take(most) {
        if pins.reset_n {
            moments.push((since, lanes_of_a_reset(&model, pins)));
            since += 1;
        }
        model.step(pins);
    }
    // The first cycles after power-up are those of the reset that came before.
    moments.drain(..moments.len().min(3));
    let lanes = moments.first().map_or(0, |(_, lanes)| lanes.len());
    let mut left = vec![false; lanes];
    for (_, moment) in &moments {
        for (left, lane) in left.iter_mut().zip(moment) {
            *left |= lane;
        }
    }
    let all = left.clone();
    let mut chosen = Vec::new();
    while left.contains(&true) {
        let new = |moment: &[bool]| moment.iter().zip(&left).filter(|(m, l)| **m && **l).count();
        // Where several are as good, the earliest is the shortest.
        let best = moments
            .iter()
            .max_by_key(|(at, moment)| (new(moment), std::cmp::Reverse(*at)));
        let Some((at, moment)) = best else { break };
        chosen.push(*at);
        for (left, lane) in left.iter_mut().zip(moment) {
            *left &= !lane;
        }
    }
    (chosen, all)
}

/// Aimed resets, and the sweep over one interval of the full core.
pub(super) fn segments(design: &Design, thorough: bool, rng: &mut ChaCha8Rng) -> Vec<Segment> {
    let mut run = search_run(design, rng);
    let (chosen, lanes) = aim(design, &run);
    run.reset_lanes = lanes;
    let lengths = |(i, after): (usize, usize)| ResetAt {
        after,
        cycles: 1 + i % 8,
    };
    run.resets = Resets::At(chosen.into_iter().enumerate().map(lengths).collect());
    let mut all = vec![run];

    let interval = design.interval_cycles();
    let full = design.latency_cycles() + 2 * interval;
    let moments = interval.max(LEAST_MOMENTS);
    let count = (full + moments) / interval + 3;
    let frames: Vec<Frame> = (0..count)
        .map(|_| random_frame(design, true, rng))
        .collect();
    let most = match thorough {
        true => moments,
        false => (SWEEP_CYCLES / (full + moments)).clamp(LEAST_MOMENTS, moments),
    };
    let mut sweep: Vec<usize> = (0..moments).collect();
    sweep.shuffle(rng);
    sweep.truncate(most);
    let mut push = |mut moments: Vec<usize>, share| {
        moments.sort_unstable();
        let piece = (PIECE_CLOCKS / (full + interval)).max(1);
        let pieces = moments.len().div_ceil(piece);
        for (number, moments) in moments.chunks(piece).enumerate() {
            let resets = moments.iter().map(|moment| ResetAt {
                after: full + moment,
                cycles: 1 + (moment + number) % 8,
            });
            let part = match pieces {
                1 => String::new(),
                _ => format!(" {} of {pieces}", number + 1),
            };
            all.push(Segment {
                name: format!("sweep x reset{part}"),
                flow: Flow::Continuous,
                frames: frames.clone(),
                seed: rng.random(),
                resets: Resets::At(resets.collect()),
                reset_lanes: Vec::new(),
                share,
            });
        }
    };
    if thorough {
        push(sweep, Share::All);
    } else {
        let part = sweep.len().div_ceil(INTERPRETED_PART);
        push(sweep[..part].to_vec(), Share::Interpreted);
        push(sweep, Share::Compiled);
    }
    all
}
