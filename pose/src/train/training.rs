//! A training from the scene to a weights file's content, epoch by epoch.

use hwgen_spec::network::{
    Activation, Calibration, FloatLayer, FloatNet, Inputs, LayerFormat, Network, Outputs,
};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::data::{Conditioning, Dataset, Teacher};
use super::integer::IntegerFront;
use super::learner::{Diverged, Learner};
use super::perceptron::{Batch, Shape, output_part};
use super::recipe::{Front, Recipe, RecipeError, Target, VALIDATION_EVERY};
use crate::sample::Sampler;
use crate::scene::Scene;
use crate::solve::bayes::{Bayes, NoiseLevel};

/// Names of the two networks, their outputs and the unit of these.
pub const NETWORKS: [(&str, [&str; 3], &str); 2] = [
    ("position", ["x", "y", "z"], "m"),
    ("orientation", ["rx", "ry", "rz"], "rad"),
];

/// Step of the pixel coordinates that the hardware is to represent.
///
/// # Units
/// px; the rounding's deviation is this by the root of 12.
pub const RESOLUTION_PX: f64 = 1.0 / 64.0;

/// Smallest noise that the posterior takes into account: finer structure cannot be fitted.
///
/// # Units
/// px
const FINEST_LEVEL_PX: f64 = 0.05;

/// Samples are learnt from this index on, so that no evaluation meets them, whatever its seed.
const FIRST_SAMPLE: u64 = 1 << 40;

/// Most frames of calibration that go into the weights file.
const CALIBRATION_FRAMES: u64 = 256;

/// Steps of their pixels: finer ones would make the file longer and say no more.
const CALIBRATION_STEPS_PER_PX: f64 = 100.0;

/// What a checkpoint holds beside the scene: with the same scene the training goes on as if it had
/// not been interrupted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Checkpoint {
    /// The recipe.
    pub recipe: Recipe,
    /// The seed.
    pub seed: u64,
    /// The two networks.
    pub learners: [Learner; 2],
}

/// A checkpoint whose parts do not belong together.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BadCheckpoint {
    /// Its recipe makes no sense.
    #[error("recipe.{0}")]
    Recipe(#[from] RecipeError),
    /// A network is not the one that scene and recipe lead to.
    #[error(
        "learners[{network}]: a network of {} inputs and {:?} neurons with its state expected, \
         another found",
        shape.inputs,
        shape.hidden
    )]
    Learner {
        /// Which.
        network: usize,
        /// What it should be.
        shape: Shape,
    },
}

/// A training under way.
#[derive(Debug)]
pub struct Training<'a> {
    scene: &'a Scene,
    calibration: Option<Calibration>,
    checkpoint: Checkpoint,
    conditioning: Conditioning,
    tasks: [Task; 2],
}

/// What one network learns.
#[derive(Debug)]
struct Task {
    train: Batch,
    validation: Batch,
    /// Outputs are the targets less this, over the scale.
    mean: DVector<f64>,
    scale: f64,
}

impl<'a> Training<'a> {
    /// Draws the samples and puts random weights into the networks.
    pub fn new(sampler: &Sampler<'a>, recipe: Recipe, seed: u64) -> Self {
        let (conditioning, tasks) = prepare(sampler, &recipe, seed);
        let shape = shape(&conditioning, &recipe);
        let learners = [0, 1].map(|k| {
            let seed = seed.wrapping_add(k as u64);
            Learner::new(&shape, recipe.optimizer, seed, &tasks[k].train)
        });
        Self {
            scene: sampler.scene(),
            calibration: calibration(sampler, &recipe, seed),
            checkpoint: Checkpoint {
                recipe,
                seed,
                learners,
            },
            conditioning,
            tasks,
        }
    }

    /// Goes on from a checkpoint of the same scene and seed; the samples are drawn anew.
    ///
    /// # Errors
    /// If the checkpoint is no whole one.
    pub fn resume(sampler: &Sampler<'a>, checkpoint: Checkpoint) -> Result<Self, BadCheckpoint> {
        checkpoint.recipe.check()?;
        let (conditioning, tasks) = prepare(sampler, &checkpoint.recipe, checkpoint.seed);
        let shape = shape(&conditioning, &checkpoint.recipe);
        let strange = |learner: &Learner| !learner.fits(&shape);
        if let Some(network) = checkpoint.learners.iter().position(strange) {
            return Err(BadCheckpoint::Learner { network, shape });
        }
        Ok(Self {
            scene: sampler.scene(),
            calibration: calibration(sampler, &checkpoint.recipe, checkpoint.seed),
            checkpoint,
            conditioning,
            tasks,
        })
    }

    /// One epoch of both networks at once, but of none that has ended; false if both have.
    ///
    /// # Errors
    /// If the training diverges.
    pub fn epoch(&mut self) -> Result<bool, Diverged> {
        let Checkpoint {
            recipe, learners, ..
        } = &mut self.checkpoint;
        if learners.iter().all(|learner| learner.stop().is_some()) {
            return Ok(false);
        }
        let [first, second] = learners;
        let epoch = |learner: &mut Learner, task: &Task| {
            learner.epoch(recipe, &task.train, &task.validation)
        };
        // What one network does on one thread leaves the other threads to the other.
        let (one, other) = rayon::join(
            || epoch(first, &self.tasks[0]),
            || epoch(second, &self.tasks[1]),
        );
        one.and(other).map(|()| true)
    }

    /// The state, to be kept.
    pub fn checkpoint(&self) -> &Checkpoint {
        &self.checkpoint
    }

    /// The networks as they are best so far, as a weights file says it.
    pub fn net(&self) -> FloatNet {
        let (inputs, shared) = self.front();
        let mut net = FloatNet {
            name: self.scene.name().to_string(),
            inputs,
            shared,
            networks: (0..2).map(|k| self.network(k)).collect(),
            calibration: self.calibration.clone(),
        };
        // What was learnt of whitened pixels is written for sums that are nearly so.
        if let Some(layer) = net.shared.first_mut()
            && let Some(front) = IntegerFront::of(&layer.weights)
        {
            layer.weights = front.matrix;
            for network in &mut net.networks {
                let first = &mut network.layers[0].weights;
                *first = &*first * &front.back;
            }
        }
        net
    }

    fn front(&self) -> (Inputs, Vec<FloatLayer>) {
        let count = self.scene.inputs();
        let features = self.conditioning.matrix.nrows();
        let mean = self.conditioning.mean_px.as_slice().to_vec();
        let (scale, shared) = match self.checkpoint.recipe.front {
            Front::Standardize => {
                let diagonal = self.conditioning.matrix.diagonal();
                (diagonal.as_slice().to_vec(), Vec::new())
            }
            Front::Whiten => {
                let layer = FloatLayer {
                    activation: Activation::Linear,
                    weights: self.conditioning.matrix.clone(),
                    bias: vec![0.0; features],
                    format: LayerFormat::default(),
                };
                (vec![1.0; count], vec![layer])
            }
        };
        let inputs = Inputs {
            names: self.scene.input_names(),
            unit: "px".into(),
            min: vec![0.0; count],
            max: image(self.scene),
            offset: mean,
            scale,
            resolution: Some(RESOLUTION_PX),
        };
        (inputs, shared)
    }

    fn network(&self, k: usize) -> Network {
        let (name, outputs, unit) = NETWORKS[k];
        let learner = &self.checkpoint.learners[k];
        let (shape, parameters) = (learner.shape(), learner.best());
        let mut layers = Vec::new();
        let mut at = 0;
        for (neurons, inputs) in shape.hidden_layers() {
            let part = &parameters.as_slice()[at..at + neurons * inputs];
            at += part.len();
            let all = DMatrix::from_column_slice(neurons, inputs, part);
            layers.push(FloatLayer {
                activation: Activation::Tanh,
                weights: all.columns(0, inputs - 1).into_owned(),
                bias: all.column(inputs - 1).as_slice().to_vec(),
                format: LayerFormat::default(),
            });
        }
        let rows: Vec<_> = (0..shape.outputs)
            .map(|o| output_part(shape, &parameters, o))
            .collect();
        let last = shape.last_words() - 1;
        layers.push(FloatLayer {
            activation: Activation::Linear,
            weights: DMatrix::from_fn(shape.outputs, last, |o, j| rows[o][j]),
            bias: rows.iter().map(|row| row[last]).collect(),
            format: LayerFormat::default(),
        });
        let task = &self.tasks[k];
        Network {
            name: name.into(),
            layers,
            outputs: Outputs {
                names: outputs.map(str::to_string).to_vec(),
                unit: unit.into(),
                scale: vec![task.scale; 3],
                offset: task.mean.as_slice().to_vec(),
            },
        }
    }
}

/// Greatest pixel of each input.
fn image(scene: &Scene) -> Vec<f64> {
    let camera = scene.camera();
    [camera.height_px, camera.width_px].repeat(scene.inputs() / 2)
}

/// The first samples that are learnt from, at the middle one of the levels of noise; those whose
/// noise leads out of the image are left out. `None` if all are.
fn calibration(sampler: &Sampler<'_>, recipe: &Recipe, seed: u64) -> Option<Calibration> {
    let mut levels = recipe.noise_px.clone();
    levels.sort_by(f64::total_cmp);
    let noise_px = levels[levels.len() / 2];
    let greatest = image(sampler.scene());
    let count = CALIBRATION_FRAMES.min(recipe.samples as u64);
    let inputs: Vec<Vec<f64>> = (FIRST_SAMPLE..FIRST_SAMPLE + count)
        .map(|index| {
            let pixels = sampler.draw(index).noisy_px(noise_px).into_iter();
            let rounded = |px: f64| (px * CALIBRATION_STEPS_PER_PX).round();
            pixels
                .map(|px| rounded(px) / CALIBRATION_STEPS_PER_PX)
                .collect()
        })
        .filter(|row: &Vec<f64>| {
            let mut edges = row.iter().zip(&greatest);
            edges.all(|(px, greatest)| (0.0..=*greatest).contains(px))
        })
        .collect();
    (!inputs.is_empty()).then(|| Calibration {
        note: format!(
            "pixels of {} of the samples that were learnt from, seed {seed}, noise {noise_px} px, \
             in steps of 0.01 px",
            inputs.len()
        ),
        inputs,
    })
}

fn shape(conditioning: &Conditioning, recipe: &Recipe) -> Shape {
    Shape {
        inputs: conditioning.matrix.nrows(),
        hidden: recipe.hidden.clone(),
        outputs: 3,
    }
}

/// Draws the samples and shares them out to the networks.
fn prepare(sampler: &Sampler<'_>, recipe: &Recipe, seed: u64) -> (Conditioning, [Task; 2]) {
    let data = draw(sampler, recipe, seed);
    let conditioning = match recipe.front {
        Front::Standardize => Conditioning::standardizing(&data.pixels),
        Front::Whiten => Conditioning::whitening(&data.pixels, RESOLUTION_PX / 12f64.sqrt()),
    };
    let features = conditioning.apply(&data.pixels);
    let tasks = [0, 1].map(|k| Task::new(recipe, &data, &features, k));
    (conditioning, tasks)
}

fn draw(sampler: &Sampler<'_>, recipe: &Recipe, seed: u64) -> Dataset {
    let mut levels: Vec<NoiseLevel> = Vec::new();
    for level in &recipe.noise_px {
        let sigma_px = level.max(FINEST_LEVEL_PX);
        match levels.iter_mut().find(|known| known.sigma_px == sigma_px) {
            Some(known) => known.probability += 1.0,
            None => levels.push(NoiseLevel {
                sigma_px,
                probability: 1.0,
            }),
        }
    }
    let bayes = Bayes::new(sampler.scene(), &levels, recipe.posterior_draws, seed);
    let teacher = match recipe.target {
        Target::Truth => Teacher::Truth,
        Target::Posterior => Teacher::Posterior(&bayes),
    };
    let samples = FIRST_SAMPLE..FIRST_SAMPLE + recipe.samples as u64;
    Dataset::draw(sampler, teacher, &recipe.noise_px, samples)
}

impl Task {
    fn new(recipe: &Recipe, data: &Dataset, features: &DMatrix<f64>, k: usize) -> Self {
        let mut targets = data.targets[k].clone();
        let mean = targets.column_mean();
        for mut column in targets.column_iter_mut() {
            column -= &mean;
        }
        let scale = (targets.norm_squared() / targets.len() as f64).sqrt();
        targets /= scale;
        let weights: Vec<f64> = data.relative[k]
            .iter()
            .zip(&data.noise_px)
            .map(|(relative, noise)| {
                if recipe.relative {
                    relative * recipe.noise_weight(*noise)
                } else {
                    1.0
                }
            })
            .collect();
        // Levels follow one another, so a whole run of them is kept back at a time.
        let levels = recipe.noise_px.len();
        let (kept, learnt): (Vec<usize>, Vec<usize>) =
            (0..data.len()).partition(|i| (i / levels) % VALIDATION_EVERY == VALIDATION_EVERY - 1);
        let part = |at: &[usize]| {
            let weights: Vec<f64> = at.iter().map(|i| weights[*i]).collect();
            Batch::new(
                &features.select_columns(at),
                &targets.select_columns(at),
                &weights,
            )
        };
        Self {
            train: part(&learnt),
            validation: part(&kept),
            mean,
            scale,
        }
    }
}
