//! The untimed model for many frames at once: the same integers as [`QuantNet::evaluate`].
//!
//! Sums of products have at most 52 bits, so a double holds each of them exactly and a matrix
//! product of doubles gives them in whatever order it adds. The weights are scaled by the power of
//! two that the requantization drops, and the bias is a weight of a constant input, so that the
//! product is the requantized word but for its fraction.

use std::sync::Arc;

use nalgebra::DMatrix;

use super::Answer;
use crate::activation::OddTable;
use crate::format::half;
use crate::network::Activation;
use crate::quantize::{QuantLayer, QuantNet};

/// Frames of one matrix product: its sums stay in the second-level cache.
const BLOCK: usize = 64;

/// Narrower products are left to slower loops by the linear algebra.
const LEAST_COLUMNS: usize = 6;

/// Half-integers below this are exact in a double.
const EXACT_LIMIT: i128 = 1 << 52;

/// Added to a double, it rounds it to the nearest integer, which stands in the lowest bits then.
const TO_INTEGER: f64 = 1.5 * (1u64 << 52) as f64;

/// A network prepared for batches.
///
/// ```
/// use hwgen_spec::{design::Design, eval::Batch, options::Options, weights};
/// let file = br#"{"format": "hwgen-weights/1", "name": "sum",
///   "inputs": {"min": [-1, -1], "max": [1, 1]},
///   "networks": [{"name": "add", "layers": [
///     {"activation": "linear", "weights": [[0.5, 0.25]]}]}]}"#;
/// let design = Design::new(&weights::read(file)?, &Options::default())?;
/// let answers = Batch::new(design.net()).evaluate(&[100, 200, -300, 400]);
/// assert_eq!(answers.codes.len(), 2);
/// assert_eq!(answers.codes[1], design.net().evaluate(&[-300, 400]).codes[0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Batch<'a> {
    net: &'a QuantNet,
    /// Absent if a sum with its bias would not be exact; then frames are evaluated one by one.
    plan: Option<Plan>,
}

/// What the frames of a batch lead to.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BatchAnswers {
    /// Output codes.
    ///
    /// # Shape
    /// `[frames][outputs of all networks]`, flat.
    pub codes: Vec<i64>,
    /// For each frame: an input was outside the box and was clipped to it.
    pub input_clipped: Vec<bool>,
    /// For each frame: a word inside was beyond its format and was saturated.
    pub saturated: Vec<bool>,
}

#[derive(Clone, Debug)]
struct Plan {
    shared: Vec<Step>,
    networks: Vec<Vec<Step>>,
}

/// One layer.
#[derive(Clone, Debug)]
struct Step {
    /// Scaled weights, `[in + 1][columns]`, the last row that of the constant 1.
    weights: DMatrix<f64>,
    outputs: usize,
    finish: Finish,
}

/// What happens to a word before its fraction is dropped.
#[derive(Clone, Debug)]
enum Finish {
    /// Clipped to `-limit ..= limit`, then looked up.
    Lookup { limit: f64, results: Results },
    /// Saturated; below `floor` silently.
    Saturate { floor: f64, low: f64, high: f64 },
}

/// Results of an activation for every argument, as short as they can be: short words stay in the
/// cache.
#[derive(Clone, Debug)]
enum Results {
    Narrow(Arc<[i16]>),
    Wide(Arc<[i32]>),
}

/// Words of a block in flight, one column an input, the constant 1 behind the last.
struct Words {
    matrix: DMatrix<f64>,
    used: usize,
}

impl Words {
    fn new(used: usize) -> Self {
        let columns = (used + 1).max(LEAST_COLUMNS);
        Self {
            matrix: DMatrix::from_element(BLOCK, columns, 1.0),
            used,
        }
    }
}

impl<'a> Batch<'a> {
    /// Prepares a network.
    pub fn new(net: &'a QuantNet) -> Self {
        let mut tables = Vec::new();
        let mut steps = |layers: &[QuantLayer]| -> Option<Vec<Step>> {
            layers.iter().map(|l| Step::of(l, &mut tables)).collect()
        };
        let shared = steps(&net.shared);
        let networks = net.networks.iter().map(|n| steps(&n.layers)).collect();
        let plan = shared
            .zip(networks)
            .map(|(shared, networks)| Plan { shared, networks });
        Self { net, plan }
    }

    /// Evaluates frames of input codes, exactly as [`QuantNet::evaluate`] does one by one.
    ///
    /// # Shape
    /// `codes`: `[frames][in]`, flat.
    ///
    /// # Panics
    /// If there is a broken frame at the end of `codes`.
    pub fn evaluate(&self, codes: &[i64]) -> BatchAnswers {
        let inputs = self.net.input.low.len();
        assert!(
            codes.len().is_multiple_of(inputs),
            "frames of {inputs} words expected, {} words found",
            codes.len()
        );
        let mut answers = BatchAnswers::default();
        match &self.plan {
            Some(plan) => plan.run(self.net, codes, &mut answers),
            None => {
                for frame in codes.chunks_exact(inputs) {
                    let answer = self.net.evaluate(frame);
                    answers.codes.extend(answer.codes);
                    answers.input_clipped.push(answer.input_clipped);
                    answers.saturated.push(answer.saturated);
                }
            }
        }
        answers
    }
}

impl QuantNet {
    /// Evaluates many frames, exactly as [`evaluate`](Self::evaluate) does one by one.
    ///
    /// [`Batch`] does the same without a vector for each frame.
    ///
    /// # Shape
    /// `frames`: `[frames][in]`; answers: one a frame.
    pub fn evaluate_batch(&self, frames: &[Vec<i64>]) -> Vec<Answer> {
        let answers = Batch::new(self).evaluate(&frames.concat());
        let outputs = answers.codes.len() / frames.len().max(1);
        let flags = answers.input_clipped.into_iter().zip(answers.saturated);
        answers
            .codes
            .chunks_exact(outputs.max(1))
            .zip(flags)
            .map(|(codes, (input_clipped, saturated))| Answer {
                codes: codes.to_vec(),
                input_clipped,
                saturated,
            })
            .collect()
    }
}

/// Tables that several layers may share, with their results.
type Lookups = Vec<(Arc<OddTable>, Activation, Results)>;

impl Step {
    fn of(layer: &QuantLayer, lookups: &mut Lookups) -> Option<Self> {
        let (inputs, outputs) = (layer.inputs(), layer.outputs());
        let mut weights = DMatrix::zeros(inputs + 1, outputs.max(LEAST_COLUMNS));
        for (i, row) in layer.weights.iter().enumerate() {
            let shift = layer.base_shift + layer.extra_shift[i];
            // Shifting rounds down, the sum below rounds to the nearest: half a word less, and
            // half a unit of the sum more so that there is never a tie.
            let bias = layer.bias[i] - half(shift);
            let magnitude: i128 = row.iter().map(|w| i128::from(w.abs())).sum();
            let sum_bound =
                (magnitude << (layer.input.width() - 1)).checked_shl(layer.product_shift)?;
            if sum_bound + i128::from(bias.abs()) + 1 >= EXACT_LIMIT {
                return None;
            }
            let guard = if shift == 0 { 0.0 } else { 0.5 };
            let place = -shift.cast_signed();
            for (k, w) in row.iter().enumerate() {
                let up = layer.product_shift.cast_signed();
                weights[(k, i)] = libm::ldexp(to_real(*w), up + place);
            }
            weights[(inputs, i)] = libm::ldexp(to_real(bias) + guard, place);
        }
        let finish = match (&layer.table, layer.activation) {
            (Some(table), activation) => Finish::Lookup {
                limit: to_real(table_limit(table)),
                results: results(table, activation, lookups),
            },
            (None, activation) => Finish::Saturate {
                floor: if activation == Activation::Relu {
                    0.0
                } else {
                    f64::NEG_INFINITY
                },
                low: to_real(layer.pre.min_code()),
                high: to_real(layer.pre.max_code()),
            },
        };
        Some(Self {
            weights,
            outputs,
            finish,
        })
    }

    /// `y = act(W x + b)` for a block; `beyond` grows where a word is saturated.
    fn run(&self, x: &Words, y: &mut Words, beyond: &mut [f64; BLOCK]) {
        let columns = self.weights.ncols();
        y.matrix.columns_mut(0, columns).gemm(
            1.0,
            &x.matrix.columns(0, x.used + 1),
            &self.weights,
            0.0,
        );
        let (words, rest) = y.matrix.as_mut_slice().split_at_mut(self.outputs * BLOCK);
        rest[..BLOCK].fill(1.0);
        match &self.finish {
            Finish::Lookup { limit, results } => match results {
                Results::Narrow(results) => look_up(words, *limit, results),
                Results::Wide(results) => look_up(words, *limit, results),
            },
            Finish::Saturate { floor, low, high } => {
                for column in words.chunks_exact_mut(BLOCK) {
                    for (word, beyond) in column.iter_mut().zip(beyond.iter_mut()) {
                        let z = greatest((*word + TO_INTEGER) - TO_INTEGER, *floor);
                        *word = least(greatest(z, *low), *high);
                        *beyond += (z - *word).abs();
                    }
                }
            }
        }
    }
}

impl Plan {
    fn run(&self, net: &QuantNet, codes: &[i64], answers: &mut BatchAnswers) {
        let inputs = net.input.low.len();
        let buffers = |steps: &[Step]| -> Vec<Words> {
            steps.iter().map(|s| Words::new(s.outputs)).collect()
        };
        let mut input = Words::new(inputs);
        let mut shared = buffers(&self.shared);
        let mut networks: Vec<Vec<Words>> = self.networks.iter().map(|n| buffers(n)).collect();
        let mut clipped = [false; BLOCK];
        for block in codes.chunks(BLOCK * inputs) {
            let frames = block.len() / inputs;
            clipped.fill(false);
            for (word, column) in input
                .matrix
                .as_mut_slice()
                .chunks_exact_mut(BLOCK)
                .take(inputs)
                .enumerate()
            {
                let (low, high) = (net.input.low[word], net.input.high[word]);
                for (frame, (x, clipped)) in column.iter_mut().zip(&mut clipped).enumerate() {
                    // Behind the last frame of the last block stands what was there before.
                    let Some(code) = block.get(frame * inputs + word) else {
                        break;
                    };
                    let inside = (*code).clamp(low, high);
                    *clipped |= inside != *code;
                    *x = to_real(inside);
                }
            }
            let mut beyond = [0.0; BLOCK];
            run_steps(&self.shared, &input, &mut shared, &mut beyond);
            let x = shared.last().unwrap_or(&input);
            for (steps, words) in self.networks.iter().zip(&mut networks) {
                run_steps(steps, x, words, &mut beyond);
            }
            for frame in 0..frames {
                for words in &networks {
                    let last = words.last().expect("a network has a layer");
                    let row = (0..last.used).map(|i| to_code(last.matrix[(frame, i)]));
                    answers.codes.extend(row);
                }
            }
            answers.input_clipped.extend(&clipped[..frames]);
            let saturated = beyond[..frames].iter().map(|b| *b != 0.0);
            answers.saturated.extend(saturated);
        }
    }
}

fn run_steps(steps: &[Step], x: &Words, words: &mut [Words], beyond: &mut [f64; BLOCK]) {
    for (i, step) in steps.iter().enumerate() {
        let (before, behind) = words.split_at_mut(i);
        step.run(before.last().unwrap_or(x), &mut behind[0], beyond);
    }
}

/// The greatest argument of a table.
fn table_limit(table: &OddTable) -> i64 {
    (1i64 << table.magnitude_bits()) - 1
}

/// The results for every argument, the least first.
fn results(table: &Arc<OddTable>, activation: Activation, made: &mut Lookups) -> Results {
    let same = |(t, a, _): &&(Arc<OddTable>, _, _)| Arc::ptr_eq(t, table) && *a == activation;
    if let Some((_, _, results)) = made.iter().find(same) {
        return results.clone();
    }
    let one = match activation {
        Activation::Sigmoid => 1i64 << table.fraction(),
        _ => 0,
    };
    let limit = table_limit(table);
    let all = || (-limit..=limit).map(|z| one + table.apply(z));
    let narrow: Option<Vec<i16>> = all().map(|y| i16::try_from(y).ok()).collect();
    let results = match narrow {
        Some(narrow) => Results::Narrow(narrow.into()),
        None => {
            let wide = all().map(|y| i32::try_from(y).expect("a word of 24 bits at most"));
            Results::Wide(wide.collect())
        }
    };
    made.push((Arc::clone(table), activation, results.clone()));
    results
}

/// Activation of words whose fraction is still to be dropped.
fn look_up<T: Copy + Into<f64>>(words: &mut [f64], limit: f64, results: &[T]) {
    let to_index = TO_INTEGER + limit;
    for column in words.chunks_exact_mut(BLOCK) {
        // Two loops, because the first one is done several words at a time.
        for word in column.iter_mut() {
            *word = least(greatest(*word, -limit), limit) + to_index;
        }
        for word in column {
            *word = results[low_bits(*word)].into();
        }
    }
}

// Written so that each is one instruction: `f64::min` takes care of NaN, of which there is none.
fn least(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

fn greatest(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The integer that a sum with [`TO_INTEGER`] leads to, below 2^32.
fn low_bits(sum: f64) -> usize {
    usize::try_from(sum.to_bits() & 0xffff_ffff).expect("usize has at least 32 bits")
}

#[expect(clippy::cast_precision_loss, reason = "codes here are below 2^53")]
fn to_real(code: i64) -> f64 {
    code as f64
}

#[expect(clippy::cast_possible_truncation, reason = "the value is a code")]
fn to_code(value: f64) -> i64 {
    value as i64
}
