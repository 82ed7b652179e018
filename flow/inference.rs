//! Inference in software, with the hardware's integers.

use std::time::Instant;

use hwgen_sim::model::{Model, Pins};
use hwgen_sim::record::Recording;
use hwgen_spec::design::Design;
use hwgen_spec::eval::Answer;

use crate::failure::{Exit, Failure};

/// What frames lead to.
#[derive(Clone, Debug)]
pub struct Inference {
    /// One answer a frame.
    pub answers: Vec<Answer>,
    /// Clocks from the edge that takes the first input beat to the one that gives the last output.
    pub cycles: usize,
    /// Frames a second of this computation.
    pub per_second: f64,
}

/// Computes the answers with the untimed model; cycles are what the core is said to take.
pub fn untimed(design: &Design, rows: &[Vec<f64>]) -> Inference {
    let start = Instant::now();
    let codes: Vec<Vec<i64>> = rows.iter().map(|row| design.input().codes(row)).collect();
    let answers = design.net().evaluate_batch(&codes);
    Inference {
        per_second: rate(rows.len(), start),
        answers,
        cycles: stated_cycles(design, rows.len()),
    }
}

/// Clocks that the core is said to take for frames in continuous flow.
pub fn stated_cycles(design: &Design, frames: usize) -> usize {
    match frames {
        0 => 0,
        n => design.latency_cycles() + (n - 1) * design.interval_cycles(),
    }
}

/// Feeds the frames to the cycle-accurate model in continuous flow and counts the clocks;
/// `trace` takes every register after every clock.
///
/// # Errors
/// If the model's words differ from the untimed ones, or it gives too few of them.
pub fn cycle_accurate(
    design: &Design,
    rows: &[Vec<f64>],
    mut trace: Option<&mut Recording>,
) -> Result<Inference, Failure> {
    let answers = untimed(design, rows).answers;
    let start = Instant::now();
    let (source, sink) = (design.source(), design.sink());
    let mut frames = rows.iter();
    let mut beats: Vec<Vec<i64>> = Vec::new();
    let mut core = Model::new(design);
    let mut row = Vec::new();
    let mut step = |core: &mut Model, pins: &Pins| {
        core.step(pins);
        if let Some(trace) = &mut trace {
            row.clear();
            core.values(&mut row);
            trace.push(&row);
        }
    };
    let mut pins = Pins::idle(design);
    // The reset hands out the credits; with the clock after it the core is ready.
    for reset_n in [false, true] {
        pins.reset_n = reset_n;
        step(&mut core, &pins);
    }

    let wanted = rows.len() * sink.beats();
    let limit = 2 * stated_cycles(design, rows.len()) + 1000;
    let mut words = Vec::with_capacity(rows.len() * sink.words);
    let (mut taken_first, mut given, mut given_last) = (None, 0, 0);
    let mut clock = 0;
    while given < wanted && clock < limit {
        if beats.is_empty()
            && let Some(row) = frames.next()
        {
            let codes = design.input().codes(row);
            beats = codes
                .chunks(source.words_per_beat)
                .rev()
                .map(<[_]>::to_vec)
                .collect();
        }
        pins.s_valid = !beats.is_empty();
        pins.s_last = beats.len() == 1;
        if let Some(beat) = beats.last() {
            pins.s_data[..beat.len()].copy_from_slice(beat);
            pins.s_data[beat.len()..].fill(0);
        }
        if let Some(beat) = core.output() {
            let left = sink.words - words.len() % sink.words;
            words.extend_from_slice(&beat.data[..left.min(beat.data.len())]);
            (given, given_last) = (given + 1, clock);
        }
        if pins.s_valid && core.ready() {
            taken_first.get_or_insert(clock);
            beats.pop();
        }
        step(&mut core, &pins);
        clock += 1;
    }
    let expected = || answers.iter().flat_map(|a| &a.codes);
    if given < wanted || !expected().eq(&words) {
        let frame = expected().zip(&words).take_while(|(a, b)| a == b).count() / sink.words.max(1);
        let message =
            format!("the cycle-accurate model parts from the untimed one in frame {frame}");
        return Err(Failure::new(Exit::Difference, "model-differs", message)
            .help("this is a fault of hwgen: please report it with the weights file"));
    }
    Ok(Inference {
        per_second: rate(rows.len(), start),
        answers,
        cycles: given_last - taken_first.unwrap_or(0),
    })
}

fn rate(frames: usize, start: Instant) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "a count far below 2^53")]
    let frames = frames as f64;
    frames / start.elapsed().as_secs_f64().max(1e-9)
}
