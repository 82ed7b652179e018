//! The posterior mean: the best that the pixels, the noise and the pose box together allow.

use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use super::Estimator;
use super::fit::Sightings;
use super::prior::{Draw, Mode, Prior, Whitened};
use super::sqpnp::SqPnp;
use crate::frames::Pose;
use crate::scene::{Parameters, Scene, parameters_of};

/// A size of pixel noise and how probable it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseLevel {
    /// Standard deviation; zero is taken as [`FINEST_PX`].
    pub sigma_px: f64,
    /// Probability, up to a factor that all levels share.
    pub probability: f64,
}

/// The noise that stands for none: far below any camera's step, and far above rounding.
///
/// # Units
/// px
pub const FINEST_PX: f64 = 1e-6;

/// The posterior mean under poses uniform in the scene's box and Gaussian noise of one of some
/// levels, by importance sampling around the mode of each level.
///
/// # Source
/// T. Kloek and H. K. van Dijk, 1978; J. Geweke, 1989 (opposite draws, effective sample size).
#[derive(Clone, Debug)]
pub struct Bayes<'a> {
    scene: &'a Scene,
    prior: Prior,
    levels: Vec<NoiseLevel>,
    samples: usize,
    seed: u64,
}

/// Means over the posterior.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Posterior {
    /// Of the position.
    ///
    /// # Units
    /// m
    pub position_m: Vector3<f64>,
    /// Of the Rodrigues vector.
    ///
    /// # Units
    /// rad
    pub rodrigues_rad: Vector3<f64>,
    /// Of the position, weighted by `1/|p|^2`: least mean square of the relative error.
    pub relative_position_m: Vector3<f64>,
    /// Of the Rodrigues vector, weighted by `1/max(|r|, 0.01)^2`.
    pub relative_rodrigues_rad: Vector3<f64>,
    /// Of `1/|p|^2`.
    pub position_weight: f64,
    /// Of `1/max(|r|, 0.01)^2`.
    pub rodrigues_weight: f64,
    /// How many independent draws from the posterior would say as much.
    pub effective_samples: f64,
}

/// The Rodrigues vector's length in its weight is at least this.
///
/// # Units
/// rad
pub const LEAST_RODRIGUES_RAD: f64 = 0.01;

/// Levels whose evidence is below that of the best by this logarithm are passed over.
const NEGLIGIBLE: f64 = 9.0;

impl<'a> Bayes<'a> {
    /// The estimator of a scene for some noise levels, with a number of samples for each.
    pub fn new(scene: &'a Scene, levels: &[NoiseLevel], samples: usize, seed: u64) -> Self {
        let mut levels: Vec<NoiseLevel> = levels
            .iter()
            .filter(|level| level.probability > 0.0)
            .map(|level| NoiseLevel {
                sigma_px: level.sigma_px.max(FINEST_PX),
                ..*level
            })
            .collect();
        levels.sort_by(|a, b| a.sigma_px.total_cmp(&b.sigma_px));
        Self {
            scene,
            prior: Prior::new(scene),
            levels,
            samples,
            seed,
        }
    }

    /// Means over the posterior of pixels; the same seed and index give the same draws.
    ///
    /// `start` is where the search for the modes begins; without it, at [`SqPnp`]'s answer or in
    /// the middle of the box.
    /// `None` if no pose of the box can be drawn.
    pub fn posterior(
        &self,
        pixels: &[f64],
        index: u64,
        start: Option<&Parameters>,
    ) -> Option<Posterior> {
        let sightings = Sightings::of(self.scene, pixels);
        let start = start.map_or_else(|| self.start(pixels), |q| self.prior.nearest(q));
        let modes = self.modes(&sightings, start);
        let most = modes
            .iter()
            .map(|(_, evidence)| *evidence)
            .fold(f64::NEG_INFINITY, f64::max);
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(index);
        let mut draws = Vec::with_capacity(modes.len() * (self.samples + 1));
        for (mode, evidence) in &modes {
            if *evidence >= most - NEGLIGIBLE {
                let drawn = self.prior.draw(&sightings, mode, self.samples, &mut rng);
                let log_probability = evidence - mode.log_evidence;
                draws.extend(drawn.into_iter().map(|draw| Draw {
                    log_weight: draw.log_weight + log_probability,
                    ..draw
                }));
            }
        }
        Posterior::of(&draws)
    }

    /// The mode of each level, each sought from that of the level below, and the logarithm of its
    /// evidence with the level's probability.
    fn modes(&self, sightings: &Sightings, mut start: Whitened) -> Vec<(Mode, f64)> {
        let mut modes = Vec::with_capacity(self.levels.len());
        for level in &self.levels {
            if let Some(mode) = self.prior.mode(sightings, level.sigma_px, start) {
                start = mode.at;
                let evidence = mode.log_evidence + level.probability.ln();
                modes.push((mode, evidence));
            }
        }
        modes
    }

    fn start(&self, pixels: &[f64]) -> Whitened {
        SqPnp::new(self.scene)
            .estimate(pixels)
            .map_or_else(Whitened::zeros, |pose| {
                self.prior.nearest(&parameters_of(&pose))
            })
    }
}

impl Estimator for Bayes<'_> {
    fn name(&self) -> &'static str {
        "bayes"
    }

    /// The draws are those of an index that the pixels make.
    fn estimate(&self, pixels: &[f64]) -> Option<Pose> {
        let posterior = self.posterior(pixels, fingerprint(pixels), None)?;
        Some(Pose::new(posterior.position_m, posterior.rodrigues_rad))
    }
}

/// FNV-1a over the words of some numbers.
fn fingerprint(numbers: &[f64]) -> u64 {
    numbers.iter().fold(0xcbf2_9ce4_8422_2325, |hash, number| {
        (hash ^ number.to_bits()).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

impl Posterior {
    fn of(draws: &[Draw]) -> Option<Self> {
        let most = draws
            .iter()
            .map(|draw| draw.log_weight)
            .fold(f64::NEG_INFINITY, f64::max);
        let mut sums = Self {
            position_m: Vector3::zeros(),
            rodrigues_rad: Vector3::zeros(),
            relative_position_m: Vector3::zeros(),
            relative_rodrigues_rad: Vector3::zeros(),
            position_weight: 0.0,
            rodrigues_weight: 0.0,
            effective_samples: 0.0,
        };
        let (mut total, mut squares) = (0.0, 0.0);
        for draw in draws {
            let weight = (draw.log_weight - most).exp();
            let (p, r) = (draw.pose.position_m, draw.pose.rodrigues_rad());
            let by_p = weight / p.norm();
            let by_r = weight / r.norm().max(LEAST_RODRIGUES_RAD);
            total += weight;
            squares += weight * weight;
            sums.position_m += p * weight;
            sums.rodrigues_rad += r * weight;
            sums.relative_position_m += p * by_p;
            sums.relative_rodrigues_rad += r * by_r;
            sums.position_weight += by_p;
            sums.rodrigues_weight += by_r;
        }
        (total > 0.0).then(|| Self {
            position_m: sums.position_m / total,
            rodrigues_rad: sums.rodrigues_rad / total,
            relative_position_m: sums.relative_position_m / sums.position_weight,
            relative_rodrigues_rad: sums.relative_rodrigues_rad / sums.rodrigues_weight,
            position_weight: sums.position_weight / total,
            rodrigues_weight: sums.rodrigues_weight / total,
            effective_samples: total * total / squares,
        })
    }
}
