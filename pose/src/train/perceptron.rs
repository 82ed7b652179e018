//! The perceptron that is trained: layers of tanh neurons and a linear output layer.

use nalgebra::{DMatrix, DMatrixView, DMatrixViewMut, DVector, DVectorView};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rayon::prelude::*;

use super::tanh::tanh;

/// How many inputs, hidden neurons and outputs a perceptron has.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Shape {
    /// Inputs, the constant one not counted.
    pub inputs: usize,
    /// Neurons of each hidden layer, one layer or more.
    pub hidden: Vec<usize>,
    /// Outputs.
    pub outputs: usize,
}

/// Mean square of a hidden word whose argument has unit variance.
const MEAN_SQUARE_WORD: f64 = 0.4;

impl Shape {
    /// Neurons and inputs of each hidden layer, the constant one among the inputs.
    pub fn hidden_layers(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let fan_in = std::iter::once(&self.inputs).chain(&self.hidden);
        self.hidden.iter().zip(fan_in).map(|(n, i)| (*n, i + 1))
    }

    /// Number of weights and biases of the hidden layers.
    pub fn hidden_parameters(&self) -> usize {
        self.hidden_layers().map(|(n, i)| n * i).sum()
    }

    /// Words that the output layer reads, the constant one among them.
    pub fn last_words(&self) -> usize {
        self.hidden.last().expect("a hidden layer") + 1
    }

    /// Number of all weights and biases.
    pub fn parameters(&self) -> usize {
        self.hidden_parameters() + self.outputs * self.last_words()
    }

    /// Random weights: normal, so that a hidden neuron's argument has unit variance on inputs of
    /// unit variance; the outputs start at zero.
    pub fn random(&self, seed: u64) -> DVector<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut parameters = DVector::zeros(self.parameters());
        let (mut at, mut mean_square) = (0, 1.0);
        for (neurons, inputs) in self.hidden_layers() {
            let spread = 1.0 / ((inputs - 1) as f64 * mean_square).sqrt();
            for weight in parameters.rows_mut(at, neurons * inputs).iter_mut() {
                *weight = spread * rng.sample::<f64, _>(rand_distr::StandardNormal);
            }
            at += neurons * inputs;
            mean_square = MEAN_SQUARE_WORD;
        }
        parameters
    }
}

/// Weights as single-precision matrices, the form in which they meet the samples.
///
/// All parameters in one vector stand in this order: the hidden matrices one after the other, each
/// column by column, then the transposed output matrix column by column.
#[derive(Clone, Debug)]
pub struct Perceptron {
    /// # Shape
    /// `[neurons][inputs + 1]` each, the bias last.
    pub hidden: Vec<DMatrix<f32>>,
    /// # Shape
    /// `[neurons of the last hidden layer + 1][outputs]`, the bias last.
    pub output: DMatrix<f32>,
}

impl Perceptron {
    /// The perceptron of a parameter vector.
    pub fn new(shape: &Shape, parameters: &DVector<f64>) -> Self {
        let mut rest = parameters.iter().map(|p| *p as f32);
        let mut matrix = |rows, columns| {
            DMatrix::from_iterator(rows, columns, rest.by_ref().take(rows * columns))
        };
        Self {
            hidden: shape.hidden_layers().map(|(n, i)| matrix(n, i)).collect(),
            output: matrix(shape.last_words(), shape.outputs),
        }
    }

    /// Words of each hidden layer for a block of samples, with a row of ones below.
    ///
    /// # Shape
    /// `inputs`: `[inputs + 1][samples]`; result: `[neurons + 1][samples]` each
    pub fn hidden_words(&self, inputs: &DMatrixView<'_, f32>) -> Vec<DMatrix<f32>> {
        let mut layers: Vec<DMatrix<f32>> = Vec::with_capacity(self.hidden.len());
        for weights in &self.hidden {
            let neurons = weights.nrows();
            let mut words = DMatrix::from_element(neurons + 1, inputs.ncols(), 1.0);
            let from = layers.last().map_or(*inputs, |words| words.as_view());
            words.rows_mut(0, neurons).gemm(1.0, weights, &from, 0.0);
            for mut column in words.column_iter_mut() {
                for word in &mut column.as_mut_slice()[..neurons] {
                    *word = tanh(*word);
                }
            }
            layers.push(words);
        }
        layers
    }

    /// Derivatives by the arguments of a layer's neurons, from those by the arguments of the layer
    /// that reads them, or by the outputs for the last.
    ///
    /// # Shape
    /// `by_reader`: `[readers][samples]`, `words`: the layer's, result: `[neurons][samples]`
    pub(super) fn back_to(
        &self,
        layer: usize,
        by_reader: &DMatrix<f32>,
        words: &DMatrix<f32>,
    ) -> DMatrix<f32> {
        let neurons = self.hidden[layer].nrows();
        let mut back = match self.hidden.get(layer + 1) {
            Some(reader) => reader.columns(0, neurons).transpose() * by_reader,
            None => self.output.rows(0, neurons) * by_reader,
        };
        for (mut back, words) in back.column_iter_mut().zip(words.column_iter()) {
            for (back, word) in back.as_mut_slice().iter_mut().zip(words.as_slice()) {
                *back *= 1.0 - word * word;
            }
        }
        back
    }
}

/// Samples to learn from.
#[derive(Clone, Debug)]
pub struct Batch {
    /// # Shape
    /// `[inputs + 1][samples]`, the last row is one.
    inputs: DMatrix<f32>,
    /// # Shape
    /// `[samples][inputs + 1]`
    inputs_transposed: DMatrix<f32>,
    /// # Shape
    /// `[outputs][samples]`
    targets: DMatrix<f32>,
    /// Weights of the squared errors, of mean one.
    weights: DVector<f32>,
}

/// Samples that are taken through the network at once: their hidden words stay in the cache.
const BLOCK: usize = 256;

/// Half the weighted mean of squared errors, and its derivative.
#[derive(Clone, Debug)]
pub struct Slope {
    /// Half the weighted mean of squared errors.
    pub loss: f64,
    /// Its derivative by every parameter.
    pub gradient: DVector<f64>,
}

impl Batch {
    /// A batch of samples; the weights are scaled to a mean of one.
    ///
    /// # Shape
    /// `inputs`: `[inputs][samples]`, `targets`: `[outputs][samples]`, `weights`: `[samples]`
    pub fn new(inputs: &DMatrix<f64>, targets: &DMatrix<f64>, weights: &[f64]) -> Self {
        let mean = weights.iter().sum::<f64>() / weights.len() as f64;
        let inputs = inputs.map(|x| x as f32).insert_row(inputs.nrows(), 1.0);
        Self {
            inputs_transposed: inputs.transpose(),
            inputs,
            targets: targets.map(|t| t as f32),
            weights: DVector::from_iterator(
                weights.len(),
                weights.iter().map(|w| (w / mean) as f32),
            ),
        }
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.inputs.ncols()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Moves the biases of the hidden layers so that neuron `j`, counted through all of them, is
    /// zero at sample `j`: all neurons then bend where there are samples.
    pub fn center(&self, shape: &Shape, parameters: &mut DVector<f64>) {
        let (mut at, mut neuron) = (0, 0);
        for (layer, (neurons, inputs)) in shape.hidden_layers().enumerate() {
            // What a layer reads does not depend on its own biases.
            let net = Perceptron::new(shape, parameters);
            for j in 0..neurons {
                let sample = self.inputs((neuron + j) % self.len(), 1);
                let words = net.hidden_words(&sample);
                let from = layer.checked_sub(1).map_or(sample, |l| words[l].as_view());
                let weights = &mut parameters.as_mut_slice()[at..at + neurons * inputs];
                let mut weights = DMatrixViewMut::from_slice(weights, neurons, inputs);
                let argument: f64 = (0..inputs - 1)
                    .map(|i| weights[(j, i)] * f64::from(from[i]))
                    .sum();
                weights[(j, inputs - 1)] = -argument;
            }
            at += neurons * inputs;
            neuron += neurons;
        }
    }

    /// The blocks that the samples are taken in: first sample and number.
    fn blocks(&self, size: usize) -> Vec<(usize, usize)> {
        (0..self.len())
            .step_by(size)
            .map(|first| (first, size.min(self.len() - first)))
            .collect()
    }

    /// Inputs of a range of samples.
    pub(super) fn inputs(&self, first: usize, count: usize) -> DMatrixView<'_, f32> {
        self.inputs.columns(first, count)
    }

    /// Weight of a sample.
    pub(super) fn weight(&self, sample: usize) -> f32 {
        self.weights[sample]
    }

    /// Errors of a block, outputs less targets.
    pub(super) fn errors(
        &self,
        net: &Perceptron,
        words: &[DMatrix<f32>],
        first: usize,
    ) -> DMatrix<f32> {
        let words = words.last().expect("a hidden layer");
        let mut errors = self.targets.columns(first, words.ncols()).into_owned();
        // A few long dot products: too few rows for a product of matrices to be fast.
        errors.gemm_tr(1.0, &net.output, words, -1.0);
        errors
    }

    /// Half the weighted mean of squared errors.
    pub fn loss(&self, net: &Perceptron) -> f64 {
        let sums: Vec<f64> = self
            .blocks(BLOCK)
            .into_par_iter()
            .map(|(first, count)| {
                let words = net.hidden_words(&self.inputs(first, count));
                let errors = self.errors(net, &words, first);
                self.squares(&errors, first)
            })
            .collect();
        sums.into_iter().sum::<f64>() / (2.0 * self.len() as f64)
    }

    /// Weighted sum of the squares of a block's errors.
    fn squares(&self, errors: &DMatrix<f32>, first: usize) -> f64 {
        errors
            .column_iter()
            .enumerate()
            .map(|(i, e)| f64::from(self.weights[first + i] * e.norm_squared()))
            .sum()
    }

    /// Loss and gradient; the same whatever the number of threads.
    pub fn slope(&self, net: &Perceptron) -> Slope {
        let parts: Vec<(f64, DVector<f32>)> = self
            .blocks(BLOCK)
            .into_par_iter()
            .map(|(first, count)| self.block_slope(net, first, count))
            .collect();
        let mut loss = 0.0;
        let mut gradient = DVector::<f64>::zeros(parts[0].1.len());
        for (squares, part) in parts {
            loss += squares;
            gradient.zip_apply(&part, |sum, g| *sum += f64::from(g));
        }
        let samples = self.len() as f64;
        Slope {
            loss: loss / (2.0 * samples),
            gradient: gradient / samples,
        }
    }

    fn block_slope(&self, net: &Perceptron, first: usize, count: usize) -> (f64, DVector<f32>) {
        let words = net.hidden_words(&self.inputs(first, count));
        let mut errors = self.errors(net, &words, first);
        let squares = self.squares(&errors, first);
        self.weigh(&mut errors, first);
        (squares, self.propagate_back(net, &words, &errors, first))
    }

    /// Multiplies the columns of a block by the samples' weights.
    fn weigh(&self, errors: &mut DMatrix<f32>, first: usize) {
        for (i, mut error) in errors.column_iter_mut().enumerate() {
            error *= self.weights[first + i];
        }
    }

    /// Sum over a block of `J'e`, with `J` the outputs' derivatives by every parameter.
    fn propagate_back(
        &self,
        net: &Perceptron,
        words: &[DMatrix<f32>],
        errors: &DMatrix<f32>,
        first: usize,
    ) -> DVector<f32> {
        let hidden: usize = net.hidden.iter().map(|weights| weights.len()).sum();
        let mut gradient = DVector::zeros(hidden + net.output.len());
        let (mut rest, by_output) = gradient.as_mut_slice().split_at_mut(hidden);
        let (rows, columns) = net.output.shape();
        let mut by_output = DMatrixViewMut::from_slice(by_output, rows, columns);
        by_output.gemm(
            1.0,
            words.last().expect("a layer"),
            &errors.transpose(),
            0.0,
        );
        let mut back = errors.clone_owned();
        for (layer, weights) in net.hidden.iter().enumerate().rev() {
            back = net.back_to(layer, &back, &words[layer]);
            let (before, part) = rest.split_at_mut(rest.len() - weights.len());
            rest = before;
            let mut part = DMatrixViewMut::from_slice(part, weights.nrows(), weights.ncols());
            match layer.checked_sub(1) {
                None => {
                    let inputs = self.inputs_transposed.rows(first, errors.ncols());
                    part.gemm(1.0, &back, &inputs, 0.0);
                }
                Some(below) => part.gemm(1.0, &back, &words[below].transpose(), 0.0),
            }
        }
        gradient
    }

    /// Weighted mean of `J'f''`, with `f''` the second derivative of the outputs when the
    /// parameters move along a direction, itself given as a perceptron.
    pub fn bend(&self, net: &Perceptron, direction: &Perceptron) -> DVector<f64> {
        let parts: Vec<DVector<f32>> = self
            .blocks(BLOCK)
            .into_par_iter()
            .map(|(first, count)| {
                let inputs = self.inputs(first, count);
                let words = net.hidden_words(&inputs);
                let mut bend = second_derivative(net, direction, &inputs, &words);
                self.weigh(&mut bend, first);
                self.propagate_back(net, &words, &bend, first)
            })
            .collect();
        let mut sum = DVector::<f64>::zeros(parts[0].len());
        for part in parts {
            sum.zip_apply(&part, |sum, g| *sum += f64::from(g));
        }
        sum / self.len() as f64
    }
}

/// Second derivative of the outputs when the parameters move along a direction.
///
/// # Shape
/// `[outputs][samples]`
fn second_derivative(
    net: &Perceptron,
    direction: &Perceptron,
    inputs: &DMatrixView<'_, f32>,
    words: &[DMatrix<f32>],
) -> DMatrix<f32> {
    // First and second derivative of the words below, which the inputs do not have.
    let mut below: Option<(DMatrix<f32>, DMatrix<f32>)> = None;
    for (layer, (weights, moved)) in net.hidden.iter().zip(&direction.hidden).enumerate() {
        let from = layer.checked_sub(1).map_or(*inputs, |l| words[l].as_view());
        let mut first = moved * from;
        let mut second = DMatrix::zeros(first.nrows(), first.ncols());
        if let Some((slope, curve)) = &below {
            let fan_in = slope.nrows();
            first.gemm(1.0, &weights.columns(0, fan_in), slope, 1.0);
            second.gemm(2.0, &moved.columns(0, fan_in), slope, 0.0);
            second.gemm(1.0, &weights.columns(0, fan_in), curve, 1.0);
        }
        // tanh' = 1 - a^2, tanh'' = -2 a (1 - a^2)
        let words = words[layer].rows(0, weights.nrows());
        second.zip_zip_apply(&first, &words, |s, f, a| {
            *s = (1.0 - a * a) * (*s - 2.0 * a * f * f);
        });
        first.zip_apply(&words, |f, a| *f *= 1.0 - a * a);
        below = Some((first, second));
    }
    let (slope, curve) = below.expect("a hidden layer");
    let rows = slope.nrows();
    let mut bend = net.output.rows(0, rows).transpose() * curve;
    let moved = direction.output.rows(0, rows).transpose();
    bend.gemm(2.0, &moved, &slope, 1.0);
    bend
}

/// The part of a parameter vector that belongs to output `k`: first its weights, then its bias.
pub(super) fn output_part<'a>(
    shape: &Shape,
    parameters: &'a DVector<f64>,
    k: usize,
) -> DVectorView<'a, f64> {
    let size = shape.last_words();
    parameters.rows(shape.hidden_parameters() + k * size, size)
}
