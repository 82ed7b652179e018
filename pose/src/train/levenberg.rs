//! Levenberg and Marquardt's method for perceptrons.

use nalgebra::{DMatrix, DVector};

use super::cholesky;
use super::normal::normal_matrix;
use super::perceptron::{Batch, Perceptron, Shape, Slope};

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
        shape: &Shape,
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
    shape: &Shape,
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
