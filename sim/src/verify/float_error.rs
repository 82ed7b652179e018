//! How far the fixed-point outputs are from those of the float network.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{OutputError, VerifyPlan};

/// Stream of the generator, apart from the one that draws the stimuli.
const STREAM: u64 = 1;

/// Rows of the file, or random points of the box if there is none, against the float network.
///
/// The points are drawn as real numbers and not taken from the stimuli, which are codes: their
/// inputs are rounded already, and that part of the error would be missing.
pub(super) fn measure(plan: &VerifyPlan<'_>) -> Vec<OutputError> {
    let mut sums = vec![Sum::default(); plan.net.output_columns().len()];
    if plan.vectors.is_empty() {
        let mut rng = ChaCha8Rng::seed_from_u64(plan.seed);
        rng.set_stream(STREAM);
        let inputs = &plan.net.inputs;
        for _ in 0..plan.random {
            let edges = inputs.min.iter().zip(&inputs.max);
            let row: Vec<f64> = edges
                .map(|(min, max)| {
                    let part: f64 = rng.random();
                    (min * (1.0 - part) + max * part).clamp(*min, *max)
                })
                .collect();
            add(plan, &row, &mut sums);
        }
    } else {
        plan.vectors
            .iter()
            .for_each(|row| add(plan, row, &mut sums));
    }
    let networks = plan.net.networks.iter();
    let units = networks.flat_map(|n| n.outputs.names.iter().map(|_| &n.outputs.unit));
    let columns = plan.net.output_columns().into_iter();
    columns
        .zip(units)
        .zip(sums)
        .map(|((output, unit), sum)| {
            #[expect(clippy::cast_precision_loss, reason = "a count of frames")]
            let mean = (sum.frames > 0).then(|| sum.squares / sum.frames as f64);
            OutputError {
                output,
                unit: unit.clone(),
                frames: sum.frames,
                max: mean.map(|_| sum.max),
                rms: mean.map(f64::sqrt),
            }
        })
        .collect()
}

#[derive(Clone, Copy, Default)]
struct Sum {
    frames: usize,
    max: f64,
    squares: f64,
}

/// Adds the errors of one frame, if it is inside of the box.
fn add(plan: &VerifyPlan<'_>, row: &[f64], sums: &mut [Sum]) {
    let (input, net) = (plan.design.input(), plan.design.net());
    if input.outside(row) {
        return;
    }
    let fixed = net.real_outputs(&net.evaluate(&input.codes(row)).codes);
    let float = plan.net.forward(row);
    for ((sum, fixed), float) in sums.iter_mut().zip(fixed).zip(float) {
        let error = fixed - float;
        sum.frames += 1;
        sum.max = sum.max.max(error.abs());
        sum.squares += error * error;
    }
}
