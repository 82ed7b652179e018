//! The perceptron that is trained: one hidden layer of tanh neurons and a linear output layer.

use nalgebra::{DMatrix, DVector, DVectorView};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rayon::prelude::*;

use super::tanh::tanh;

/// How many inputs, hidden neurons and outputs a perceptron has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Shape {
    /// Inputs, the constant one not counted.
    pub inputs: usize,
    /// Hidden neurons.
    pub hidden: usize,
    /// Outputs.
    pub outputs: usize,
}

impl Shape {
    /// Number of weights and biases of the hidden layer.
    pub fn hidden_parameters(self) -> usize {
        self.hidden * (self.inputs + 1)
    }

    /// Number of all weights and biases.
    pub fn parameters(self) -> usize {
        self.hidden_parameters() + self.outputs * (self.hidden + 1)
    }

    /// Random weights: normal, so that a hidden neuron's argument has unit variance on inputs of
    /// unit variance; the outputs start at zero.
    pub fn random(self, seed: u64) -> DVector<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let spread = 1.0 / (self.inputs as f64).sqrt();
        let mut parameters = DVector::zeros(self.parameters());
        for weight in parameters.rows_mut(0, self.hidden_parameters()).iter_mut() {
            *weight = spread * rng.sample::<f64, _>(rand_distr::StandardNormal);
        }
        parameters
    }
}

/// Weights as single-precision matrices, the form in which they meet the samples.
///
/// All parameters in one vector stand in this order: the hidden matrix column by column, then the
/// transposed output matrix column by column.
#[derive(Clone, Debug)]
pub struct Perceptron {
    /// # Shape
    /// `[hidden][inputs + 1]`, the bias last.
    pub hidden: DMatrix<f32>,
    /// # Shape
    /// `[hidden + 1][outputs]`, the bias last.
    pub output: DMatrix<f32>,
}

impl Perceptron {
    /// The perceptron of a parameter vector.
    pub fn new(shape: Shape, parameters: &DVector<f64>) -> Self {
        let split = shape.hidden_parameters();
        let narrow =
            |from: usize, to: usize| parameters.as_slice()[from..to].iter().map(|p| *p as f32);
        Self {
            hidden: DMatrix::from_iterator(shape.hidden, shape.inputs + 1, narrow(0, split)),
            output: DMatrix::from_iterator(
                shape.hidden + 1,
                shape.outputs,
                narrow(split, shape.parameters()),
            ),
        }
    }

    /// Hidden words of a block of samples with a row of ones below.
    ///
    /// # Shape
    /// `inputs`: `[inputs + 1][samples]`; result: `[hidden + 1][samples]`
    pub fn hidden_words(&self, inputs: &nalgebra::DMatrixView<'_, f32>) -> DMatrix<f32> {
        let hidden = self.hidden.nrows();
        let mut words = DMatrix::from_element(hidden + 1, inputs.ncols(), 1.0);
        words
            .rows_mut(0, hidden)
            .gemm(1.0, &self.hidden, inputs, 0.0);
        for mut column in words.column_iter_mut() {
            for word in &mut column.as_mut_slice()[..hidden] {
                *word = tanh(*word);
            }
        }
        words
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

    /// Moves the biases of the hidden layer so that neuron `j` is zero at sample `j`: all neurons
    /// then bend where there are samples.
    pub fn center(&self, shape: Shape, parameters: &mut DVector<f64>) {
        let mut hidden = nalgebra::DMatrixViewMut::from_slice(
            &mut parameters.as_mut_slice()[..shape.hidden_parameters()],
            shape.hidden,
            shape.inputs + 1,
        );
        for j in 0..shape.hidden {
            let sample = self.inputs.column(j % self.len());
            let argument: f64 = (0..shape.inputs)
                .map(|i| hidden[(j, i)] * f64::from(sample[i]))
                .sum();
            hidden[(j, shape.inputs)] = -argument;
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
    pub(super) fn inputs(&self, first: usize, count: usize) -> nalgebra::DMatrixView<'_, f32> {
        self.inputs.columns(first, count)
    }

    /// Weight of a sample.
    pub(super) fn weight(&self, sample: usize) -> f32 {
        self.weights[sample]
    }

    /// Errors of a block, outputs less targets.
    fn errors(&self, net: &Perceptron, words: &DMatrix<f32>, first: usize) -> DMatrix<f32> {
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
        words: &DMatrix<f32>,
        errors: &DMatrix<f32>,
        first: usize,
    ) -> DVector<f32> {
        let (hidden, fan_in) = net.hidden.shape();
        let count = errors.ncols();
        let mut gradient = DVector::zeros(hidden * fan_in + net.output.len());
        let (by_hidden, by_output) = gradient.as_mut_slice().split_at_mut(hidden * fan_in);
        let mut by_output =
            nalgebra::DMatrixViewMut::from_slice(by_output, hidden + 1, net.output.ncols());
        by_output.gemm(1.0, words, &errors.transpose(), 0.0);
        // Back through the output layer and the slope of tanh.
        let mut back = DMatrix::zeros(hidden, count);
        back.gemm(1.0, &net.output.rows(0, hidden), errors, 0.0);
        for (mut back, words) in back.column_iter_mut().zip(words.column_iter()) {
            let words = words.as_slice();
            for (back, word) in back.as_mut_slice().iter_mut().zip(words) {
                *back *= 1.0 - word * word;
            }
        }
        let mut by_hidden = nalgebra::DMatrixViewMut::from_slice(by_hidden, hidden, fan_in);
        by_hidden.gemm(1.0, &back, &self.inputs_transposed.rows(first, count), 0.0);
        gradient
    }

    /// Weighted mean of `J'f''`, with `f''` the second derivative of the outputs when the
    /// parameters move along a direction, itself given as a perceptron.
    pub fn bend(&self, net: &Perceptron, direction: &Perceptron) -> DVector<f64> {
        let hidden = net.hidden.nrows();
        let parts: Vec<DVector<f32>> = self
            .blocks(BLOCK)
            .into_par_iter()
            .map(|(first, count)| {
                let inputs = self.inputs(first, count);
                let words = net.hidden_words(&inputs);
                let moved = &direction.hidden * inputs;
                // First and second derivative of the hidden words.
                let slope = moved.zip_map(&words.rows(0, hidden), |m, a| m * (1.0 - a * a));
                let mut second = slope.clone();
                second.zip_zip_apply(&moved, &words.rows(0, hidden), |s, m, a| *s *= -2.0 * a * m);
                let mut bend = net.output.rows(0, hidden).transpose() * second;
                bend.gemm(
                    2.0,
                    &direction.output.rows(0, hidden).transpose(),
                    &slope,
                    1.0,
                );
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

/// The part of a parameter vector that belongs to output `k`, and that of the hidden layer.
pub(super) fn output_part(
    shape: Shape,
    parameters: &DVector<f64>,
    k: usize,
) -> DVectorView<'_, f64> {
    let size = shape.hidden + 1;
    parameters.rows(shape.hidden_parameters() + k * size, size)
}
