//! What a training is made of.

use serde::{Deserialize, Serialize};

use super::data::MOST_FEATURES;
use super::perceptron::Shape;

/// How the weights are sought.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Optimizer {
    /// Resilient propagation over all samples, the method's own.
    Rprop,
    /// Levenberg and Marquardt's second-order steps over all samples.
    Levenberg,
}

/// What stands in front of the perceptrons.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Front {
    /// Each pixel coordinate to mean zero and variance one; folded into the first layer.
    Standardize,
    /// A linear layer that both networks share: pixels along their principal axes, each to
    /// variance one.
    Whiten,
}

/// What a sample is to be answered with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Target {
    /// The pose that it was drawn from.
    Truth,
    /// The mean of the poses that it may come from.
    Posterior,
}

/// A training, but for the scene and the seed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Recipe {
    /// Neurons of each hidden layer of each network.
    pub hidden: Vec<usize>,
    /// Samples, those of the validation set among them.
    pub samples: usize,
    /// Noise of the samples, one level after the other; a level that stands there twice is twice
    /// as probable.
    pub noise_px: Vec<f64>,
    /// How the weights are sought.
    pub optimizer: Optimizer,
    /// What stands in front.
    pub front: Front,
    /// What is learnt.
    pub target: Target,
    /// Draws from the posterior for each noise level and sample.
    pub posterior_draws: usize,
    /// Whether a squared error counts by one over the length of what is sought and over its
    /// noise, so that what is least is near to the relative error against the limit.
    pub relative: bool,
    /// Noise with which a sample's squared error counts half, where `relative`.
    ///
    /// # Units
    /// px
    pub noise_half_px: f64,
    /// Half this times the weights' square is added to the loss.
    pub weight_decay: f64,
    /// Most epochs: passes over all samples.
    pub epochs: usize,
    /// Epochs without a better validation loss after which training stops.
    pub patience: usize,
}

/// Every fifth sample validates, as in the method.
pub const VALIDATION_EVERY: usize = 5;

/// Most neurons of a hidden layer.
pub const MAX_HIDDEN: usize = 4096;

/// Most hidden layers.
pub const MAX_HIDDEN_LAYERS: usize = 4;

/// Most weights and biases of a network that Levenberg-Marquardt seeks: the normal matrix and its
/// factor have their square, 6.4 GB each.
pub const MAX_LEVENBERG: usize = 28_000;

/// Most samples: what 24 GB hold with room to spare.
pub const MAX_SAMPLES: usize = 10_000_000;

/// Most epochs, and most patience.
pub const MAX_EPOCHS: usize = 1_000_000_000;

/// Greatest level of noise: beyond the size of any image.
pub const MAX_NOISE_PX: f64 = 1e5;

/// A recipe that makes no sense.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{field}: {reason}")]
pub struct RecipeError {
    /// The field of [`Recipe`].
    pub field: &'static str,
    /// What was expected, and what was found.
    pub reason: String,
}

impl Recipe {
    /// The method's own recipe: standardised pixels without noise, 10,000 samples, RPROP with
    /// weight decay, a fifth for validation and early stopping.
    pub fn paper() -> Self {
        Self {
            hidden: vec![256],
            samples: 10_000,
            noise_px: vec![0.0],
            optimizer: Optimizer::Rprop,
            front: Front::Standardize,
            target: Target::Truth,
            posterior_draws: 0,
            relative: false,
            noise_half_px: 1.0,
            weight_decay: 1e-7,
            epochs: 5_000,
            patience: 200,
        }
    }

    /// What measures best: whitened pixels with noise of many levels, the posterior mean as the
    /// target, second-order steps.
    pub fn best() -> Self {
        Self {
            hidden: vec![32, 24],
            samples: 40_000,
            noise_px: vec![
                0.0, 0.1, 0.3, 0.6, 1.0, 1.0, 1.0, 1.0, 1.0, 1.6, 2.3, 3.0, 3.0, 3.0, 5.0,
            ],
            optimizer: Optimizer::Levenberg,
            front: Front::Whiten,
            target: Target::Posterior,
            posterior_draws: 64,
            relative: true,
            noise_half_px: 1.0,
            weight_decay: 0.0,
            epochs: 40,
            patience: 10,
        }
    }

    /// The recipe with another optimizer, and as many epochs as that one takes.
    pub fn with_optimizer(self, optimizer: Optimizer) -> Self {
        let (epochs, patience) = match optimizer {
            Optimizer::Rprop => (5_000, 200),
            Optimizer::Levenberg => (40, 10),
        };
        Self {
            optimizer,
            epochs,
            patience,
            ..self
        }
    }

    /// How much a sample's squared error counts for its noise.
    ///
    /// What cannot be known grows with the noise; an error of the network on top of it matters as
    /// far as it is not small against that.
    pub(super) fn noise_weight(&self, noise_px: f64) -> f64 {
        if self.relative {
            1.0 / (1.0 + noise_px / self.noise_half_px)
        } else {
            1.0
        }
    }

    /// Checks what can be checked without the scene.
    ///
    /// # Errors
    /// The first field that makes no sense.
    pub fn check(&self) -> Result<(), RecipeError> {
        let count = |field, value: usize, least: usize, most: usize| {
            if (least..=most).contains(&value) {
                Ok(())
            } else {
                Err(RecipeError {
                    field,
                    reason: format!("a number from {least} to {most} expected, {value} found"),
                })
            }
        };
        let layers = self.hidden.len();
        if !(1..=MAX_HIDDEN_LAYERS).contains(&layers) {
            return Err(RecipeError {
                field: "hidden",
                reason: format!("1 to {MAX_HIDDEN_LAYERS} layers expected, {layers} found"),
            });
        }
        for neurons in &self.hidden {
            count("hidden", *neurons, 1, MAX_HIDDEN)?;
        }
        count("samples", self.samples, 100, MAX_SAMPLES)?;
        count("epochs", self.epochs, 1, MAX_EPOCHS)?;
        count("patience", self.patience, 1, MAX_EPOCHS)?;
        let parameters = Shape {
            inputs: MOST_FEATURES,
            hidden: self.hidden.clone(),
            outputs: 3,
        }
        .parameters();
        if self.optimizer == Optimizer::Levenberg && parameters > MAX_LEVENBERG {
            return Err(RecipeError {
                field: "hidden",
                reason: format!(
                    "at most {MAX_LEVENBERG} weights expected, {parameters} found: \
                     Levenberg-Marquardt needs their square, --optimizer rprop does not"
                ),
            });
        }
        if self.noise_px.is_empty() {
            return Err(RecipeError {
                field: "noise",
                reason: "one level or more expected, none found".into(),
            });
        }
        for level in &self.noise_px {
            if !(0.0..=MAX_NOISE_PX).contains(level) {
                return Err(RecipeError {
                    field: "noise",
                    reason: format!("levels from 0 to {MAX_NOISE_PX} px expected, {level} found"),
                });
            }
        }
        // A run of all levels validates, and the runs before it are learnt from.
        let least = VALIDATION_EVERY * self.noise_px.len();
        if self.samples < least {
            return Err(RecipeError {
                field: "samples",
                reason: format!(
                    "{least} or more expected, {VALIDATION_EVERY} for each of {} levels of noise, \
                     {} found",
                    self.noise_px.len(),
                    self.samples
                ),
            });
        }
        if !(1e-3..=MAX_NOISE_PX).contains(&self.noise_half_px) {
            return Err(RecipeError {
                field: "noise_half",
                reason: format!(
                    "a noise from 0.001 to {MAX_NOISE_PX} px expected, {} found",
                    self.noise_half_px
                ),
            });
        }
        if !(self.weight_decay.is_finite() && self.weight_decay >= 0.0) {
            return Err(RecipeError {
                field: "weight_decay",
                reason: format!("zero or more expected, {} found", self.weight_decay),
            });
        }
        Ok(())
    }
}
