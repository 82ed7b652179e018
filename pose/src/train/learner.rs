//! One network on its way: weights, the optimiser's state, the losses so far.

use nalgebra::DVector;
use serde::{Deserialize, Serialize};

use super::levenberg::Levenberg;
use super::perceptron::{Batch, Perceptron, Shape};
use super::recipe::{Optimizer, Recipe};
use super::rprop::Rprop;

/// Losses after an epoch: half the weighted mean square of the standardised errors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Losses {
    /// On the samples that are learnt from, without the weight decay's part.
    pub train: f64,
    /// On the samples that are kept back.
    pub validation: f64,
}

/// Why a training ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Stop {
    /// All epochs are done.
    Epochs,
    /// The validation loss was no better for as long as the recipe's patience.
    Patience,
    /// No step leads down any more.
    Minimum,
}

impl Stop {
    /// The word for it in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Epochs => "epochs",
            Self::Patience => "patience",
            Self::Minimum => "minimum",
        }
    }
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum State {
    Rprop(Rprop),
    Levenberg(Levenberg),
}

/// A network in training, all of it: what a checkpoint holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Learner {
    shape: Shape,
    parameters: Vec<f64>,
    state: State,
    best: Vec<f64>,
    best_epoch: usize,
    curve: Vec<Losses>,
    stop: Option<Stop>,
}

/// The loss of a training is no number any more.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("the loss is {loss} after epoch {epoch}: the training diverged")]
pub struct Diverged {
    /// The epoch, from 1.
    pub epoch: usize,
    /// The loss.
    pub loss: f64,
}

impl Learner {
    /// A network with random weights that is to learn from a batch.
    pub fn new(shape: &Shape, optimizer: Optimizer, seed: u64, train: &Batch) -> Self {
        let mut parameters = shape.random(seed);
        train.center(shape, &mut parameters);
        let parameters = parameters.as_slice().to_vec();
        Self {
            shape: shape.clone(),
            state: match optimizer {
                Optimizer::Rprop => State::Rprop(Rprop::new(parameters.len())),
                Optimizer::Levenberg => State::Levenberg(Levenberg::default()),
            },
            best: parameters.clone(),
            parameters,
            best_epoch: 0,
            curve: Vec::new(),
            stop: None,
        }
    }

    /// Whether all parts of a learner that was read are those of a shape.
    pub fn fits(&self, shape: &Shape) -> bool {
        let count = shape.parameters();
        let state = match &self.state {
            State::Rprop(rprop) => rprop.fits(count),
            State::Levenberg(_) => true,
        };
        state
            && self.shape == *shape
            && self.parameters.len() == count
            && self.best.len() == count
            && self.best_epoch <= self.curve.len()
    }

    /// Shape of the network.
    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// Why the training ended, if it did.
    pub fn stop(&self) -> Option<Stop> {
        self.stop
    }

    /// Losses after each epoch.
    pub fn curve(&self) -> &[Losses] {
        &self.curve
    }

    /// The epoch with the least validation loss, from 1; 0 before the first.
    pub fn best_epoch(&self) -> usize {
        self.best_epoch
    }

    /// Losses of the best epoch.
    pub fn best_losses(&self) -> Option<Losses> {
        self.curve.get(self.best_epoch.checked_sub(1)?).copied()
    }

    /// The weights of the best epoch.
    pub fn best(&self) -> DVector<f64> {
        DVector::from_column_slice(&self.best)
    }

    /// One pass over all samples, unless the training has ended.
    ///
    /// # Errors
    /// If the loss is no number any more.
    pub fn epoch(
        &mut self,
        recipe: &Recipe,
        train: &Batch,
        validation: &Batch,
    ) -> Result<(), Diverged> {
        if self.stop.is_some() {
            return Ok(());
        }
        let mut parameters = DVector::from_column_slice(&self.parameters);
        let loss = match &mut self.state {
            State::Rprop(rprop) => {
                let slope = train.slope(&Perceptron::new(&self.shape, &parameters));
                let gradient = slope.gradient + &parameters * recipe.weight_decay;
                rprop.step(&mut parameters, &gradient);
                slope.loss
            }
            State::Levenberg(levenberg) => {
                match levenberg.step(&self.shape, &mut parameters, train, recipe.weight_decay) {
                    Some(loss) => loss - 0.5 * recipe.weight_decay * parameters.norm_squared(),
                    None => {
                        self.stop = Some(Stop::Minimum);
                        return Ok(());
                    }
                }
            }
        };
        let losses = Losses {
            train: loss,
            validation: validation.loss(&Perceptron::new(&self.shape, &parameters)),
        };
        self.parameters.copy_from_slice(parameters.as_slice());
        self.note(losses)?;
        let epoch = self.curve.len();
        if epoch - self.best_epoch >= recipe.patience {
            self.stop = Some(Stop::Patience);
        } else if epoch >= recipe.epochs {
            self.stop = Some(Stop::Epochs);
        }
        Ok(())
    }

    fn note(&mut self, losses: Losses) -> Result<(), Diverged> {
        let best = self.best_losses().map_or(f64::INFINITY, |b| b.validation);
        self.curve.push(losses);
        let epoch = self.curve.len();
        for loss in [losses.train, losses.validation] {
            if !loss.is_finite() {
                return Err(Diverged { epoch, loss });
            }
        }
        if losses.validation < best {
            self.best_epoch = epoch;
            self.best.clone_from(&self.parameters);
        }
        Ok(())
    }
}
