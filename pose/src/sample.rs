//! Samples: poses drawn from the scene's box, what the camera sees of them, and noise.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

use crate::frames::Pose;
use crate::scene::{Parameters, Scene, pose_of};

/// The kind of noise on each pixel coordinate, independent of the others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NoiseShape {
    /// Normal with the given standard deviation.
    #[default]
    Gaussian,
    /// Uniform between plus and minus the given amplitude.
    Uniform,
}

impl NoiseShape {
    /// The standard deviation of noise of a size.
    ///
    /// # Units
    /// px
    pub fn deviation(self, noise_px: f64) -> f64 {
        match self {
            Self::Gaussian => noise_px,
            Self::Uniform => noise_px / 3f64.sqrt(),
        }
    }
}

/// One pose and what is seen of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// The drawn parameters.
    pub parameters: Parameters,
    /// The pose that they stand for.
    pub pose: Pose,
    /// Pixels without noise, `[u0, v0, ...]`.
    pub clean_px: Vec<f64>,
    /// Noise of unit size, to be scaled and added.
    pub unit_noise: Vec<f64>,
    /// How many poses were drawn until this one was in view.
    pub drawn: u32,
}

impl Sample {
    /// Pixels with noise of a size: standard deviation or amplitude.
    ///
    /// # Units
    /// px
    pub fn noisy_px(&self, noise_px: f64) -> Vec<f64> {
        self.clean_px
            .iter()
            .zip(&self.unit_noise)
            .map(|(clean, noise)| clean + noise_px * noise)
            .collect()
    }
}

/// Draws samples by index: sample `i` of a seed is the same whoever draws it and when.
#[derive(Clone, Debug)]
pub struct Sampler<'a> {
    scene: &'a Scene,
    shape: NoiseShape,
    seed: u64,
}

/// The landmarks of a scene are never, or almost never, all in view.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "poses: all landmarks in view for at least {least} of the poses expected, \
     {in_view} of {tried} found"
)]
pub struct NeverInView {
    /// Poses in view.
    pub in_view: u32,
    /// Poses tried.
    pub tried: u32,
    /// The fraction below which a scene is refused.
    pub least: f64,
}

/// The least fraction of poses that must be in view.
pub const LEAST_IN_VIEW: f64 = 0.01;

/// Poses that the fraction in view is estimated from.
const TRIAL: u32 = 10_000;

/// Poses that are drawn for one sample before the drawing is taken to be broken: with at least
/// one in a hundred in view, this many in vain do not happen.
const MAX_DRAWN: u32 = 100_000;

impl<'a> Sampler<'a> {
    /// A sampler whose poses are known to be in view often enough.
    ///
    /// # Errors
    /// If fewer than one in a hundred poses of the box show all landmarks.
    pub fn new(scene: &'a Scene, shape: NoiseShape, seed: u64) -> Result<Self, NeverInView> {
        let sampler = Self { scene, shape, seed };
        let mut rng = sampler.stream(u64::MAX);
        let mut pixels = vec![0.0; scene.inputs()];
        let in_view = (0..TRIAL)
            .filter(|_| sampler.try_draw(&mut rng, &mut pixels).is_some())
            .count();
        let in_view = u32::try_from(in_view).expect("at most the number tried");
        if f64::from(in_view) < LEAST_IN_VIEW * f64::from(TRIAL) {
            return Err(NeverInView {
                in_view,
                tried: TRIAL,
                least: LEAST_IN_VIEW,
            });
        }
        Ok(sampler)
    }

    /// The scene.
    pub fn scene(&self) -> &'a Scene {
        self.scene
    }

    /// The shape of the noise.
    pub fn shape(&self) -> NoiseShape {
        self.shape
    }

    /// The sample of an index.
    ///
    /// The same index gives the same pose and the same unit noise at every noise level.
    pub fn draw(&self, index: u64) -> Sample {
        let mut rng = self.stream(index);
        let mut clean_px = vec![0.0; self.scene.inputs()];
        let mut drawn = 1;
        let (parameters, pose) = loop {
            if let Some(found) = self.try_draw(&mut rng, &mut clean_px) {
                break found;
            }
            drawn += 1;
            assert!(
                drawn < MAX_DRAWN,
                "a scene in view never shows its landmarks"
            );
        };
        let unit_noise = (0..clean_px.len())
            .map(|_| match self.shape {
                NoiseShape::Gaussian => StandardNormal.sample(&mut rng),
                NoiseShape::Uniform => rng.random_range(-1.0..=1.0),
            })
            .collect();
        Sample {
            parameters,
            pose,
            clean_px,
            unit_noise,
            drawn,
        }
    }

    fn stream(&self, index: u64) -> ChaCha8Rng {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(index);
        rng
    }

    /// A pose of the box, if it is in view.
    fn try_draw(&self, rng: &mut ChaCha8Rng, pixels: &mut [f64]) -> Option<(Parameters, Pose)> {
        let poses = self.scene.poses();
        let widths = poses.widths();
        let parameters =
            Parameters::from_fn(|i, _| poses.lower[i] + widths[i] * rng.random::<f64>());
        let pose = pose_of(&parameters);
        (self.scene.project_into(&pose, pixels) && self.scene.in_view(pixels))
            .then_some((parameters, pose))
    }
}
