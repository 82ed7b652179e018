//! The rows of the table that need no trained network.

use super::{Evaluation, PoseError, Row, Tally};
use crate::frames::Pose;
use crate::solve::Estimator;
use crate::solve::bayes::{Bayes, NoiseLevel};
use crate::solve::crb::Bound;
use crate::solve::epnp::EPnp;
use crate::solve::ml::Ml;
use crate::solve::ransac::{Ransac, RansacOptions};
use crate::solve::sqpnp::SqPnp;

/// What answers or limits a scene without having been trained for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// What was published of the method, [`PUBLISHED`].
    Paper,
    /// The Cramér-Rao bound: the expected error of an unbiased estimate, at best.
    Crb,
    /// Maximum likelihood.
    Ml,
    /// The posterior mean under the pose box and the noise, whose size it knows; each pose of
    /// the posterior weighs as much as its error does in the relative error.
    Bayes,
    /// EPnP.
    Epnp,
    /// SQPnP.
    Sqpnp,
    /// P3P in RANSAC, refined on the inliers.
    P3pRansac,
}

/// A cell of the published table, in percent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Published {
    /// Noise of the pixels.
    pub noise_px: f64,
    /// Mean relative error of the position.
    pub position_pct: f64,
    /// Mean relative error of the orientation.
    pub orientation_pct: f64,
}

const fn published(noise_px: f64, position_pct: f64, orientation_pct: f64) -> Published {
    Published {
        noise_px,
        position_pct,
        orientation_pct,
    }
}

/// What was published of the method: one network each for position and orientation, five
/// landmarks, 256 neurons. Its scene and its definition of the error are not given.
///
/// # Source
/// Table 2 of the paper that describes the method.
pub const PUBLISHED: [Published; 4] = [
    published(0.0, 2.6, 3.4),
    published(0.1, 2.61, 4.2),
    published(1.0, 2.8, 20.0),
    published(3.0, 3.2, 51.0),
];

/// Draws from the posterior of a pose: some tenths of a percent above the error of endlessly many.
const BAYES_DRAWS: usize = 400;
const SEED: u64 = 1;

/// A landmark nearer to its place than this many deviations of the noise agrees with a pose.
const INLIER_SIGMAS: f64 = 5.0;
/// It does within this distance whatever the noise.
const LEAST_INLIER_PX: f64 = 1.0;
const TRIPLES: usize = 100;

impl Method {
    /// All, in the order of the table.
    pub const ALL: [Self; 7] = [
        Self::Paper,
        Self::Crb,
        Self::Ml,
        Self::Bayes,
        Self::Epnp,
        Self::Sqpnp,
        Self::P3pRansac,
    ];

    /// The name of its rows.
    pub fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Crb => "crb",
            Self::Ml => "ml",
            Self::Bayes => "bayes",
            Self::Epnp => "epnp",
            Self::Sqpnp => "sqpnp",
            Self::P3pRansac => "p3p-ransac",
        }
    }
}

impl Evaluation<'_> {
    /// The row of a method at a level of noise; `None` where nothing was published of it.
    pub fn row(&self, method: Method, noise_px: f64) -> Option<Row> {
        let scene = self.scene();
        let sigma_px = self.sampler.shape().deviation(noise_px);
        let solved = |estimator: &dyn Estimator| Row {
            estimator: method.name().to_string(),
            ..self.measure(estimator, noise_px)
        };
        match method {
            Method::Paper => PUBLISHED
                .iter()
                .find(|cell| cell.noise_px == noise_px)
                .map(Published::row),
            Method::Crb => Some(self.bound(noise_px, sigma_px)),
            Method::Bayes => Some(self.posterior(noise_px, sigma_px)),
            Method::Ml => Some(solved(&Ml::new(scene))),
            Method::Epnp => Some(solved(&EPnp::new(scene))),
            Method::Sqpnp => Some(solved(&SqPnp::new(scene))),
            Method::P3pRansac => {
                let options = RansacOptions {
                    inlier_px: LEAST_INLIER_PX.max(INLIER_SIGMAS * sigma_px),
                    triples: TRIPLES,
                    seed: SEED,
                };
                Some(solved(&Ransac::new(scene, options)))
            }
        }
    }

    fn bound(&self, noise_px: f64, sigma_px: f64) -> Row {
        let scene = self.scene();
        let tally = self.tally(noise_px, |frames| {
            Tally::of(frames.poses.iter().map(|pose| {
                let bound = Bound::at(scene, pose, sigma_px)?;
                let position_m = bound.position_error_m();
                let rodrigues_rad = bound.rodrigues_error_rad();
                Some(PoseError {
                    position_pct: 100.0 * position_m / pose.position_m.norm(),
                    orientation_pct: 100.0 * rodrigues_rad / pose.rodrigues_rad().norm(),
                    position_m,
                    orientation_deg: bound.turn_error_rad().to_degrees(),
                })
            }))
        });
        tally.row(Method::Crb.name(), noise_px)
    }

    fn posterior(&self, noise_px: f64, sigma_px: f64) -> Row {
        let level = NoiseLevel {
            sigma_px,
            probability: 1.0,
        };
        let bayes = Bayes::new(self.scene(), &[level], BAYES_DRAWS, SEED);
        let answer = |pixels: &[f64], index| {
            let posterior = bayes.posterior(pixels, index, None)?;
            let pose = Pose::new(
                posterior.relative_position_m,
                posterior.relative_rodrigues_rad,
            );
            Some((pose, posterior.effective_samples))
        };
        let tally = self.tally(noise_px, |frames| {
            let mut effective_samples = 0.0;
            let answers = (frames.first..).zip(frames.pixels.iter().zip(&frames.poses));
            let tally = Tally::of(answers.map(|(index, (pixels, truth))| {
                let (pose, effective) = answer(pixels, index)?;
                effective_samples += effective;
                Some(PoseError::between(&pose, truth))
            }));
            Tally {
                effective_samples,
                ..tally
            }
        });
        let us_per_pose = self.us_per_pose(noise_px, |frames| {
            for (index, pixels) in (frames.first..).zip(&frames.pixels) {
                std::hint::black_box(answer(pixels, index));
            }
        });
        let answered = tally.errors.count();
        Row {
            us_per_pose: Some(us_per_pose),
            effective_samples: (answered > 0).then(|| tally.effective_samples / answered as f64),
            ..tally.row(Method::Bayes.name(), noise_px)
        }
    }
}

impl Published {
    fn row(&self) -> Row {
        Row {
            estimator: Method::Paper.name().to_string(),
            noise_px: self.noise_px,
            position_pct: Some(self.position_pct),
            orientation_pct: Some(self.orientation_pct),
            position_m: None,
            orientation_deg: None,
            us_per_pose: None,
            failures: None,
            effective_samples: None,
        }
    }
}
