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
/// One mode of each level is sampled: in a box wide enough for the mirror image of a flat scene,
/// that of the better start.
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
    /// Of the position, weighted by `1/|p|`, which comes near to the least mean relative error
    /// (`examples/limits.rs`: with the noise known, 2 % less for the Rodrigues vector at 3 px).
    pub relative_position_m: Vector3<f64>,
    /// Of the Rodrigues vector, weighted by `1/max(|r|, 0.01)`.
    pub relative_rodrigues_rad: Vector3<f64>,
    /// Of `1/|p|`.
    pub position_weight: f64,
    /// Of `1/max(|r|, 0.01)`.
    pub rodrigues_weight: f64,
    /// How many independent draws from the posterior would say as much.
    pub effective_samples: f64,
}

/// The Rodrigues vector's length in its weight is at least this.
///
/// # Units
/// rad
pub const LEAST_RODRIGUES_RAD: f64 = 0.01;

/// Levels whose evidence is below that of the best by more than this logarithm do not matter.
const NEGLIGIBLE: f64 = 9.0;

/// Fewer effective samples than this share of a level's samples call for draws within the box.
const POOR: f64 = 0.1;

/// How many times as many samples these are.
const MORE: usize = 4;

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
        let levels = self.modes(&sightings, start)?;
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(index);
        let draws = draw_all(&levels, self.samples, |mode, count| {
            self.prior.draw(&sightings, mode, count, &mut rng)
        });
        let plain = Posterior::of(&draws);
        let effective = |of: &Option<Posterior>| of.map_or(0.0, |p| p.effective_samples);
        if effective(&plain) >= POOR * self.samples as f64 {
            return plain;
        }
        let draws = draw_all(&levels, MORE * self.samples, |mode, count| {
            self.prior.draw_within(&sightings, mode, count, &mut rng)
        });
        let within = Posterior::of(&draws);
        if effective(&within) > effective(&plain) {
            within
        } else {
            plain
        }
    }

    /// The modes of the levels that matter, with the logarithms of their probabilities.
    fn modes(&self, sightings: &Sightings, start: Whitened) -> Option<Vec<(f64, Mode)>> {
        // The finest noise leads to the best fit, and its expansion says which levels matter.
        let start = self.prior.place(sightings, start)?;
        let finest = self.levels.first()?.sigma_px;
        let mut place = self.prior.climb(sightings, finest, start);
        let guesses = self.levels.iter().filter_map(|level| {
            let log_probability = level.probability.ln();
            let mode = place.mode(level.sigma_px)?;
            Some((
                log_probability,
                mode.log_evidence + log_probability,
                level.sigma_px,
            ))
        });
        let guesses: Vec<_> = guesses.collect();
        let most = guesses
            .iter()
            .map(|(_, evidence, _)| *evidence)
            .fold(f64::NEG_INFINITY, f64::max);
        let mut modes = Vec::with_capacity(guesses.len());
        for (log_probability, evidence, sigma_px) in guesses {
            if evidence >= most - NEGLIGIBLE {
                place = self.prior.climb(sightings, sigma_px, place);
                modes.push((log_probability, place.mode(sigma_px)?));
            }
        }
        Some(modes)
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

/// Draws of all levels, weighed against each other: at most `samples` of each, and fewer of those
/// with less evidence.
fn draw_all(
    levels: &[(f64, Mode)],
    samples: usize,
    mut draw: impl FnMut(&Mode, usize) -> Vec<Draw>,
) -> Vec<Draw> {
    const FEWEST: f64 = 4.0;
    let evidence = levels
        .iter()
        .map(|(log_probability, mode)| log_probability + mode.log_evidence);
    let most = evidence.clone().fold(f64::NEG_INFINITY, f64::max);
    let mut draws = Vec::new();
    for ((log_probability, mode), evidence) in levels.iter().zip(evidence) {
        // Between equal numbers and numbers by evidence, which would trust a rough value of it.
        let share = ((evidence - most) / 2.0).exp();
        let count = (share * samples as f64).max(FEWEST).min(samples as f64);
        draws.extend(draw(mode, count as usize).into_iter().map(|draw| Draw {
            log_weight: draw.log_weight + log_probability,
            ..draw
        }));
    }
    draws
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
