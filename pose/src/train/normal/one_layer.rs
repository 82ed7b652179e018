//! The normal matrix of a perceptron with one hidden layer.
//!
//! The derivative of output `k` by the weight from input `i` to hidden neuron `j` is
//! `v_kj d_j x_i`, with `d = 1 - a^2` the slope of tanh. Two such weights meet in
//! `(sum_k v_kj v_kl) (sum_s w d_j d_l x_i x_m)`, where the second sum stays the same if `i` and
//! `m` change places, or `j` and `l`. So a quarter of them is all that must be summed over the
//! samples, which is where nearly all the time of a training goes.

use std::ops::Range;

use nalgebra::{DMatrix, DMatrixView, DVector};
use rayon::prelude::*;

use super::{CHUNK, add_product};
use crate::train::perceptron::{Batch, Perceptron, Shape, output_part};

/// Neurons of a tile: small enough to leave out most of what symmetry gives, large enough for
/// products of matrices to be fast.
const TILE: usize = 64;

/// Lower triangle of the mean of `w J'J` over the batch.
pub(super) fn normal_matrix(
    shape: &Shape,
    parameters: &DVector<f64>,
    net: &Perceptron,
    batch: &Batch,
) -> DMatrix<f64> {
    let sums = Sums::over(shape, net, batch);
    let split = shape.hidden_parameters();
    let (hidden, words) = (sums.hidden, sums.hidden + 1);
    let output: Vec<_> = (0..shape.outputs)
        .map(|k| output_part(shape, parameters, k))
        .collect();
    // sum over the outputs of v_kj v_kj'
    let influence = DMatrix::from_fn(hidden, hidden, |j, l| {
        output.iter().map(|v| v[j] * v[l]).sum::<f64>()
    });
    let size = shape.parameters();
    let mut normal = DMatrix::zeros(size, size);
    let columns = normal.as_mut_slice()[..split * size].par_chunks_mut(size);
    columns.enumerate().for_each(|(at, column)| {
        let (i, l) = (at / hidden, at % hidden);
        let (by_hidden, by_output) = column.split_at_mut(split);
        for m in i..=shape.inputs {
            for j in 0..hidden {
                by_hidden[m * hidden + j] = influence[(j, l)] * sums.of_slopes(i, m, j, l);
            }
        }
        let with_words = sums.of_slope_and_words(i, l);
        for (part, v) in by_output.chunks_mut(words).zip(&output) {
            for (entry, sum) in part.iter_mut().zip(with_words.iter()) {
                *entry = v[l] * sum;
            }
        }
    });
    for k in 0..shape.outputs {
        let row = split + k * words;
        normal
            .view_mut((row, row), (words, words))
            .copy_from(&sums.words);
    }
    normal
}

/// What the samples have to be summed to, each a mean.
struct Sums {
    hidden: usize,
    /// First by input, then by tile of neurons.
    tiles: Vec<Tile>,
    /// `w a_j a_l`, the constant one being the last of the words.
    words: DMatrix<f64>,
}

/// The sums of one input, and the inputs from it on, for some neurons.
struct Tile {
    input: usize,
    neurons: Range<usize>,
    /// `w d_j x_i x_m d_l`, neurons `l` up to the last of the tile.
    ///
    /// # Shape
    /// `[inputs m from i on, in each the tile's neurons][neurons l]`
    slopes: DMatrix<f64>,
    /// `w a_l x_i d_j`
    ///
    /// # Shape
    /// `[hidden words and one][the tile's neurons]`
    words: DMatrix<f64>,
}

/// What a chunk of samples has in each sum, already with the root of its weight.
struct Chunk<'a> {
    /// # Shape
    /// `[inputs + 1][samples]`
    inputs: DMatrixView<'a, f32>,
    /// # Shape
    /// `[hidden][samples]`
    slopes: DMatrix<f32>,
    /// # Shape
    /// `[samples][hidden]`
    slopes_across: DMatrix<f32>,
    /// # Shape
    /// `[hidden + 1][samples]`
    words: DMatrix<f32>,
}

impl Sums {
    /// Chunks are summed in order, whatever the number of threads.
    fn over(shape: &Shape, net: &Perceptron, batch: &Batch) -> Self {
        let &[hidden] = shape.hidden.as_slice() else {
            panic!("one hidden layer expected");
        };
        let words = hidden + 1;
        let tile = |input: usize, first: usize| {
            let neurons = first..(first + TILE).min(hidden);
            let rows = (shape.inputs + 1 - input) * neurons.len();
            Tile {
                input,
                slopes: DMatrix::zeros(rows, neurons.end),
                words: DMatrix::zeros(words, neurons.len()),
                neurons,
            }
        };
        let mut sums = Self {
            hidden,
            tiles: (0..=shape.inputs)
                .flat_map(|i| (0..hidden).step_by(TILE).map(move |j| tile(i, j)))
                .collect(),
            words: DMatrix::zeros(words, words),
        };
        for first in (0..batch.len()).step_by(CHUNK) {
            let chunk = Chunk::new(net, batch, first, CHUNK.min(batch.len() - first));
            rayon::join(
                || {
                    let across = chunk.words.transpose();
                    add_product(&mut sums.words, &chunk.words.as_view(), &across.as_view());
                },
                || sums.tiles.par_iter_mut().for_each(|tile| tile.add(&chunk)),
            );
        }
        let samples = batch.len() as f64;
        sums.words /= samples;
        for tile in &mut sums.tiles {
            tile.slopes /= samples;
            tile.words /= samples;
        }
        sums
    }

    fn tile(&self, input: usize, neuron: usize) -> &Tile {
        &self.tiles[input * self.hidden.div_ceil(TILE) + neuron / TILE]
    }

    /// Mean of `w d_j d_l x_i x_m`, with `i` no more than `m`.
    fn of_slopes(&self, i: usize, m: usize, j: usize, l: usize) -> f64 {
        let (j, l) = (j.max(l), j.min(l));
        let tile = self.tile(i, j);
        let row = (m - i) * tile.neurons.len() + j - tile.neurons.start;
        tile.slopes[(row, l)]
    }

    /// Means of `w x_i d_l a`.
    fn of_slope_and_words(&self, i: usize, l: usize) -> DMatrixView<'_, f64> {
        let tile = self.tile(i, l);
        let column = l - tile.neurons.start;
        tile.words.columns(column, 1)
    }
}

impl<'a> Chunk<'a> {
    fn new(net: &Perceptron, batch: &'a Batch, first: usize, count: usize) -> Self {
        let inputs = batch.inputs(first, count);
        let mut words = net.hidden_words(&inputs).swap_remove(0);
        let hidden = words.nrows() - 1;
        let mut slopes = DMatrix::zeros(hidden, count);
        let samples = words.column_iter_mut().zip(slopes.column_iter_mut());
        for (sample, (mut words, mut slopes)) in samples.enumerate() {
            let weight = batch.weight(first + sample).sqrt();
            for (d, a) in slopes.as_mut_slice().iter_mut().zip(words.as_slice()) {
                *d = weight * (1.0 - a * a);
            }
            words *= weight;
        }
        Self {
            inputs,
            slopes_across: slopes.transpose(),
            slopes,
            words,
        }
    }
}

impl Tile {
    fn add(&mut self, chunk: &Chunk<'_>) {
        let (count, height) = (chunk.inputs.ncols(), self.neurons.len());
        let mut rows = DMatrix::<f32>::zeros(self.slopes.nrows(), count);
        for (sample, mut column) in rows.column_iter_mut().enumerate() {
            let inputs = &chunk.inputs.column(sample);
            let slopes = chunk.slopes.column(sample);
            let slopes = &slopes.as_slice()[self.neurons.clone()];
            let parts = column.as_mut_slice().chunks_mut(height);
            for (part, x) in parts.zip(&inputs.as_slice()[self.input..]) {
                let factor = inputs[self.input] * x;
                for (entry, d) in part.iter_mut().zip(slopes) {
                    *entry = factor * d;
                }
            }
        }
        let across = chunk.slopes_across.columns(0, self.neurons.end);
        add_product(&mut self.slopes, &rows.as_view(), &across.as_view());
        // The last input is the constant one, so its rows are the slopes times the tile's input.
        let by_input = rows.rows(rows.nrows() - height, height).transpose();
        add_product(&mut self.words, &chunk.words.as_view(), &by_input.as_view());
    }
}
