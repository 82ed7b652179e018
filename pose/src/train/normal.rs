//! The normal matrix of a perceptron: the mean of `w J'J` over a batch, with `J` the derivatives of
//! the outputs by every parameter.

mod one_layer;

use nalgebra::{DMatrix, DMatrixView, DVector};
use rayon::prelude::*;

use super::perceptron::{Batch, Perceptron, Shape};

/// Samples that are summed in single precision, before they join a sum in double precision.
const CHUNK: usize = 1024;

/// Columns of the matrix that are summed at once.
const TILE: usize = 128;

/// Lower triangle of the mean of `w J'J` over the batch.
pub(super) fn normal_matrix(
    shape: &Shape,
    parameters: &DVector<f64>,
    net: &Perceptron,
    batch: &Batch,
) -> DMatrix<f64> {
    match shape.hidden.len() {
        1 => one_layer::normal_matrix(shape, parameters, net, batch),
        _ => any_layers(shape, net, batch),
    }
}

/// The same for any number of layers, from the derivatives themselves.
///
/// Chunks are summed in order, whatever the number of threads.
fn any_layers(shape: &Shape, net: &Perceptron, batch: &Batch) -> DMatrix<f64> {
    let size = shape.parameters();
    let mut tiles: Vec<DMatrix<f64>> = (0..size)
        .step_by(TILE)
        .map(|first| DMatrix::zeros(size - first, TILE.min(size - first)))
        .collect();
    // A sample has a row for each output.
    let samples = CHUNK / shape.outputs.min(CHUNK);
    for first in (0..batch.len()).step_by(samples) {
        let across = derivatives(shape, net, batch, first, samples.min(batch.len() - first));
        let down = across.transpose();
        tiles.par_iter_mut().enumerate().for_each(|(at, tile)| {
            let first = at * TILE;
            let left = down.rows(first, tile.nrows());
            let right = across.columns(first, tile.ncols());
            add_product(tile, &left, &right);
        });
    }
    let mut normal = DMatrix::zeros(size, size);
    for (at, tile) in tiles.into_iter().enumerate() {
        let first = at * TILE;
        let mut view = normal.view_mut((first, first), tile.shape());
        view.copy_from(&(tile / batch.len() as f64));
    }
    normal
}

/// Derivatives of the outputs by every parameter, times the root of the sample's weight.
///
/// # Shape
/// `[outputs, in each the samples][parameters]`
fn derivatives(
    shape: &Shape,
    net: &Perceptron,
    batch: &Batch,
    first: usize,
    count: usize,
) -> DMatrix<f32> {
    let inputs = batch.inputs(first, count);
    let words = net.hidden_words(&inputs);
    let mut all = DMatrix::zeros(shape.outputs * count, shape.parameters());
    for output in 0..shape.outputs {
        let rows = output * count;
        let mut by_reader = DMatrix::from_fn(shape.outputs, count, |k, s| {
            if k == output {
                batch.weight(first + s).sqrt()
            } else {
                0.0
            }
        });
        let weight = by_reader.row(output).transpose();
        let last = words.last().expect("a hidden layer");
        let column = shape.hidden_parameters() + output * shape.last_words();
        for (word, row) in last.row_iter().enumerate() {
            let mut part = all.view_mut((rows, column + word), (count, 1));
            part.zip_zip_apply(&row.transpose(), &weight, |d, a, w| *d = a * w);
        }
        let mut end = shape.hidden_parameters();
        for (layer, weights) in net.hidden.iter().enumerate().rev() {
            by_reader = net.back_to(layer, &by_reader, &words[layer]);
            let by_neuron = by_reader.transpose();
            let from = layer.checked_sub(1).map_or(inputs, |l| words[l].as_view());
            end -= weights.len();
            for (input, row) in from.row_iter().enumerate() {
                let column = end + input * weights.nrows();
                let word = row.transpose();
                let mut part = all.view_mut((rows, column), by_neuron.shape());
                for (mut part, by_neuron) in part.column_iter_mut().zip(by_neuron.column_iter()) {
                    part.zip_zip_apply(&by_neuron, &word, |d, b, a| *d = a * b);
                }
            }
        }
    }
    all
}

/// Adds a product that is made in single precision.
fn add_product(sum: &mut DMatrix<f64>, left: &DMatrixView<'_, f32>, right: &DMatrixView<'_, f32>) {
    let mut product = DMatrix::<f32>::zeros(left.nrows(), right.ncols());
    product.gemm(1.0, left, right, 0.0);
    sum.zip_apply(&product, |sum, p| *sum += f64::from(p));
}

#[cfg(test)]
mod tests {
    use super::*;

    const INPUTS: usize = 3;
    const OUTPUTS: usize = 2;

    /// More samples than a chunk has.
    const SAMPLES: usize = CHUNK + 76;

    fn pattern(rows: usize, step: usize) -> DMatrix<f64> {
        DMatrix::from_fn(rows, SAMPLES, |i, s| {
            ((i * 7 + s * step) % 101) as f64 / 50.0 - 1.0
        })
    }

    /// The outputs' derivatives by every parameter at one sample, by differences.
    fn derivatives_by_differences(
        shape: &Shape,
        at: &DVector<f64>,
        input: &DVector<f64>,
    ) -> DMatrix<f64> {
        let outputs = |at: &DVector<f64>| {
            let mut words = input.clone();
            let mut first = 0;
            for (neurons, inputs) in shape.hidden_layers() {
                let part = &at.as_slice()[first..first + neurons * inputs];
                first += part.len();
                words = (DMatrix::from_column_slice(neurons, inputs, part) * words.push(1.0))
                    .map(f64::tanh);
            }
            let last = &at.as_slice()[first..];
            DMatrix::from_column_slice(shape.last_words(), OUTPUTS, last).transpose()
                * words.push(1.0)
        };
        let step = 1e-5;
        let columns: Vec<_> = (0..at.len())
            .map(|i| {
                let (mut above, mut below) = (at.clone(), at.clone());
                above[i] += step;
                below[i] -= step;
                (outputs(&above) - outputs(&below)) / (2.0 * step)
            })
            .collect();
        DMatrix::from_columns(&columns)
    }

    #[test]
    fn equals_the_sum_over_the_samples() {
        // More neurons than a tile of one layer has, more parameters than one of several.
        for hidden in [&[70][..], &[9, 8], &[4, 5, 6]] {
            let shape = Shape {
                inputs: INPUTS,
                hidden: hidden.to_vec(),
                outputs: OUTPUTS,
            };
            let (inputs, targets) = (pattern(INPUTS, 37), pattern(OUTPUTS, 53));
            let weights: Vec<f64> = (0..SAMPLES).map(|s| 0.5 + (s % 3) as f64 * 0.5).collect();
            let mean = weights.iter().sum::<f64>() / SAMPLES as f64;
            let batch = Batch::new(&inputs, &targets, &weights);
            let mut parameters = shape.random(1);
            let split = shape.hidden_parameters();
            for (at, v) in parameters.as_mut_slice()[split..].iter_mut().enumerate() {
                *v = (at % 13) as f64 / 13.0 - 0.4;
            }
            let net = Perceptron::new(&shape, &parameters);

            let size = shape.parameters();
            let mut expected = DMatrix::<f64>::zeros(size, size);
            for (s, weight) in weights.iter().enumerate() {
                let input = inputs.column(s).into_owned();
                let by = derivatives_by_differences(&shape, &parameters, &input);
                expected.gemm_tr(weight / (mean * SAMPLES as f64), &by, &by, 1.0);
            }
            let found = normal_matrix(&shape, &parameters, &net, &batch);
            let largest = expected.amax();
            for column in 0..size {
                for row in column..size {
                    let miss = (found[(row, column)] - expected[(row, column)]).abs();
                    assert!(
                        miss < 1e-5 * largest,
                        "{hidden:?} ({row}, {column}): {miss}"
                    );
                }
            }
        }
    }
}
