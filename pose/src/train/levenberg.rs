//! Levenberg and Marquardt's method for a perceptron with one hidden layer.
//!
//! The normal matrix of all samples is one product: the derivative of output `k` by the hidden
//! weight from input `i` to neuron `j` is `v_kj (1 - a_j^2) x_i`, so that with the samples'
//! columns `g = [(1 - a^2) x', a, 1]` the matrix `sum g g'` holds every block up to factors `v`.

use nalgebra::{DMatrix, DMatrixViewMut, DVector};
use rayon::prelude::*;

use super::cholesky;
use super::perceptron::{Batch, Perceptron, Shape, Slope, output_part};

/// Samples whose columns are multiplied at once.
const CHUNK: usize = 2048;

/// Rows and columns of the tiles that the product is shared out in.
const TILE: usize = 512;

/// The damping of a fresh start, as a fraction of the normal matrix's diagonal.
const FIRST_DAMPING: f64 = 1e-2;

/// Least damping: below it single precision carries nothing.
const MIN_DAMPING: f64 = 1e-7;

/// Damping beyond which no step is worth trying.
const MAX_DAMPING: f64 = 1e6;

/// What the damping is multiplied by after a step, and where none was found; the latter by twice as
/// much at every further try.
const LOWER: f64 = 0.3;
const RAISE: f64 = 3.0;

/// Most that the path may bend: twice the length of its second derivative, half of which is added,
/// over that of the step.
const MOST_BOW: f64 = 1.0;

/// Most steps that are taken with one normal matrix, which costs more than all else.
const STEPS: usize = 4;

/// The state of the method: how far it trusts the quadratic model.
///
/// # Source
/// K. Levenberg, 1944; D. W. Marquardt, 1963 (damping in proportion to the diagonal); for
/// perceptrons M. T. Hagan and M. B. Menhaj, 1994. The step follows the bend of its path, which
/// lets it take the narrow curved valleys of such losses: M. K. Transtrum and J. P. Sethna, 2012
/// (geodesic acceleration). Further steps with the same matrix: J. Fan, 2012 (modified
/// Levenberg-Marquardt method).
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Levenberg {
    damping: f64,
}

impl Default for Levenberg {
    fn default() -> Self {
        Self {
            damping: FIRST_DAMPING,
        }
    }
}

impl Levenberg {
    /// One step down: moves the parameters and gives the loss there, or `None` where no step
    /// leads down any more; a loss that is no number is given as it is.
    ///
    /// The loss is that of the batch plus half the decay times the parameters' square.
    pub fn step(
        &mut self,
        shape: Shape,
        parameters: &mut DVector<f64>,
        batch: &Batch,
        decay: f64,
    ) -> Option<f64> {
        let net = Perceptron::new(shape, parameters);
        let Slope { loss, gradient } = batch.slope(&net);
        let before = loss + 0.5 * decay * parameters.norm_squared();
        if !before.is_finite() {
            return Some(before);
        }
        let gradient = gradient + &*parameters * decay;
        let mut normal = normal_matrix(shape, parameters, &net, batch);
        for i in 0..normal.nrows() {
            normal[(i, i)] += decay;
        }
        let diagonal = normal.diagonal();
        // A neuron without influence would leave its weights undamped.
        let floor = 1e-6 * diagonal.mean();
        // Lengths are measured by the curve that the loss has along each parameter.
        let length = |step: &DVector<f64>| -> f64 {
            let squares = step.iter().zip(&diagonal).map(|(s, d)| s * s * (d + floor));
            squares.sum::<f64>().sqrt()
        };
        let mut damped = DMatrix::zeros(normal.nrows(), normal.ncols());
        let mut raise = RAISE;
        while self.damping <= MAX_DAMPING {
            damped.copy_from(&normal);
            for (i, d) in diagonal.iter().enumerate() {
                damped[(i, i)] += self.damping * (d + floor);
            }
            if cholesky::factor(&mut damped) {
                let step = -cholesky::solve(&damped, &gradient);
                let bend = batch.bend(&net, &Perceptron::new(shape, &step));
                let bow = -cholesky::solve(&damped, &bend);
                if 2.0 * length(&bow) <= MOST_BOW * length(&step) {
                    let trial = &*parameters + step + 0.5 * bow;
                    let after = batch.loss(&Perceptron::new(shape, &trial))
                        + 0.5 * decay * trial.norm_squared();
                    if after < before {
                        *parameters = trial;
                        self.damping = (self.damping * LOWER).max(MIN_DAMPING);
                        return Some(further(shape, parameters, batch, decay, &damped, after));
                    }
                }
            }
            self.damping *= raise;
            raise *= 2.0;
        }
        None
    }
}

/// Steps from where one led, with the same factor of the normal matrix, as long as they lead down.
fn further(
    shape: Shape,
    parameters: &mut DVector<f64>,
    batch: &Batch,
    decay: f64,
    factor: &DMatrix<f64>,
    mut loss: f64,
) -> f64 {
    for _ in 1..STEPS {
        let Slope { gradient, .. } = batch.slope(&Perceptron::new(shape, parameters));
        let gradient = gradient + &*parameters * decay;
        let trial = &*parameters - cholesky::solve(factor, &gradient);
        let after =
            batch.loss(&Perceptron::new(shape, &trial)) + 0.5 * decay * trial.norm_squared();
        if after >= loss || after.is_nan() {
            break;
        }
        *parameters = trial;
        loss = after;
    }
    loss
}

/// Lower triangle of the mean of `w J'J` over the batch.
fn normal_matrix(
    shape: Shape,
    parameters: &DVector<f64>,
    net: &Perceptron,
    batch: &Batch,
) -> DMatrix<f64> {
    let products = products(shape, net, batch);
    let split = shape.hidden_parameters();
    let (hidden, words) = (shape.hidden, shape.hidden + 1);
    let output: Vec<_> = (0..shape.outputs)
        .map(|k| output_part(shape, parameters, k))
        .collect();
    // sum over the outputs of v_kj v_kj'
    let influence = DMatrix::from_fn(hidden, hidden, |j, l| {
        output.iter().map(|v| v[j] * v[l]).sum::<f64>()
    });
    let size = shape.parameters();
    let mut normal = DMatrix::zeros(size, size);
    // The columns of an input, for all neurons.
    let by_input = normal.as_mut_slice()[..split * size].par_chunks_mut(hidden * size);
    by_input.enumerate().for_each(|(block, columns)| {
        let mut columns = DMatrixViewMut::from_slice(columns, size, hidden);
        for below in block..=shape.inputs {
            let mut part = columns.view_mut((below * hidden, 0), (hidden, hidden));
            part.copy_from(&products.view((below * hidden, block * hidden), (hidden, hidden)));
            part.component_mul_assign(&influence);
        }
        for (k, v) in output.iter().enumerate() {
            for j in 0..hidden {
                let mut part = columns.view_mut((split + k * words, j), (words, 1));
                part.copy_from(&products.view((split, block * hidden + j), (words, 1)));
                part *= v[j];
            }
        }
    });
    for k in 0..shape.outputs {
        let row = split + k * words;
        normal
            .view_mut((row, row), (words, words))
            .copy_from(&products.view((split, split), (words, words)));
    }
    normal
}

/// Lower triangle of the mean of `w g g'` over the batch.
///
/// Tiles are summed over the chunks in order, whatever the number of threads.
fn products(shape: Shape, net: &Perceptron, batch: &Batch) -> DMatrix<f64> {
    let size = shape.hidden_parameters() + shape.hidden + 1;
    let edges: Vec<usize> = (0..size).step_by(TILE).chain([size]).collect();
    let mut tiles: Vec<(usize, usize, DMatrix<f64>)> = (0..edges.len() - 1)
        .flat_map(|row| (0..=row).map(move |column| (row, column)))
        .map(|(row, column)| {
            let rows = edges[row + 1] - edges[row];
            let columns = edges[column + 1] - edges[column];
            (row, column, DMatrix::zeros(rows, columns))
        })
        .collect();
    for first in (0..batch.len()).step_by(CHUNK) {
        let count = CHUNK.min(batch.len() - first);
        let columns = sample_columns(shape, net, batch, first, count);
        let rows: Vec<DMatrix<f32>> = edges
            .par_windows(2)
            .map(|edge| columns.rows_range(edge[0]..edge[1]).transpose())
            .collect();
        tiles.par_iter_mut().for_each(|(row, column, tile)| {
            let mut part = DMatrix::<f32>::zeros(tile.nrows(), tile.ncols());
            part.gemm(
                1.0,
                &columns.rows(edges[*row], tile.nrows()),
                &rows[*column],
                0.0,
            );
            tile.zip_apply(&part, |sum, p| *sum += f64::from(p));
        });
    }
    let mut products = DMatrix::zeros(size, size);
    let samples = batch.len() as f64;
    for (row, column, tile) in tiles {
        products
            .view_mut((edges[row], edges[column]), tile.shape())
            .copy_from(&(tile / samples));
    }
    products
}

/// The columns `sqrt(w) g` of a chunk of samples.
fn sample_columns(
    shape: Shape,
    net: &Perceptron,
    batch: &Batch,
    first: usize,
    count: usize,
) -> DMatrix<f32> {
    let hidden = shape.hidden;
    let inputs = batch.inputs(first, count);
    let words = net.hidden_words(&inputs);
    let size = shape.hidden_parameters() + hidden + 1;
    let mut columns = DMatrix::zeros(size, count);
    columns
        .as_mut_slice()
        .par_chunks_mut(size)
        .enumerate()
        .for_each(|(sample, column)| {
            let weight = batch.weight(first + sample).sqrt();
            let words = words.column(sample);
            let (by_hidden, by_output) = column.split_at_mut(shape.hidden_parameters());
            for (part, x) in by_hidden
                .chunks_mut(hidden)
                .zip(inputs.column(sample).iter())
            {
                let factor = weight * x;
                for (g, a) in part.iter_mut().zip(words.as_slice()) {
                    *g = factor * (1.0 - a * a);
                }
            }
            for (g, a) in by_output.iter_mut().zip(words.as_slice()) {
                *g = weight * a;
            }
        });
    columns
}
