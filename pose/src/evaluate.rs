//! The error table: how far every estimator is from the truth at every level of noise.
//!
//! All estimators answer the same poses, and at every level the same noise but for its size, so
//! that rows differ by the estimators alone. What they are measured by is [`PoseError`].

mod method;
mod metric;
mod network;

use std::ops::Range;
use std::time::{Duration, Instant};

use rayon::prelude::*;
use serde::Serialize;

pub use method::{Method, PUBLISHED, Published};
pub use metric::{ErrorSum, PoseError};
pub use network::{FloatEstimator, Misfit, Wiring};

use crate::frames::Pose;
use crate::sample::Sampler;
use crate::scene::Scene;
use crate::solve::Estimator;

/// What one estimator does at one level of noise.
///
/// What is not known is absent: a published row tells no metres, a bound takes no time, a relative
/// error of what is zero is none.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Its name.
    pub estimator: String,
    /// Size of the noise: standard deviation, or amplitude if it is uniform.
    pub noise_px: f64,
    /// Mean relative error of the position.
    pub position_pct: Option<f64>,
    /// Mean relative error of the Rodrigues vector.
    pub orientation_pct: Option<f64>,
    /// Mean distance.
    pub position_m: Option<f64>,
    /// Mean angle between estimated and true attitude.
    pub orientation_deg: Option<f64>,
    /// Time on one thread, a pose.
    pub us_per_pose: Option<f64>,
    /// Poses without an answer; they are not in the means.
    pub failures: Option<usize>,
    /// Mean effective sample size, where the answer is drawn.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effective_samples: Option<f64>,
}

/// An estimator that is asked for many poses at a time.
pub trait BatchEstimator: Sync {
    /// The name that tables show.
    fn name(&self) -> &'static str;

    /// The pose of each frame `[u0, v0, u1, v1, ...]`; `None` where there is no answer.
    fn estimate_all(&self, frames: &[Vec<f64>]) -> Vec<Option<Pose>>;
}

impl<E: Estimator + ?Sized> BatchEstimator for E {
    fn name(&self) -> &'static str {
        Estimator::name(self)
    }

    fn estimate_all(&self, frames: &[Vec<f64>]) -> Vec<Option<Pose>> {
        frames.iter().map(|pixels| self.estimate(pixels)).collect()
    }
}

/// Poses that estimators are asked for.
#[derive(Clone, Copy, Debug)]
pub struct Evaluation<'a> {
    sampler: &'a Sampler<'a>,
    count: u64,
}

/// Some poses in a row, and what is seen of them.
struct Frames {
    /// Index of the first.
    first: u64,
    poses: Vec<Pose>,
    pixels: Vec<Vec<f64>>,
}

/// What came of some frames.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    errors: ErrorSum,
    failures: usize,
    /// Sum over the answers; zero where nothing is drawn.
    effective_samples: f64,
}

impl Tally {
    fn of(answers: impl IntoIterator<Item = Option<PoseError>>) -> Self {
        let mut tally = Self::default();
        for answer in answers {
            match answer {
                Some(error) => tally.errors.add(error),
                None => tally.failures += 1,
            }
        }
        tally
    }

    /// A row with the means, their time not yet measured.
    fn row(&self, estimator: &str, noise_px: f64) -> Row {
        let mean = self.errors.mean();
        let known = |of: fn(PoseError) -> f64| mean.map(of).filter(|value| value.is_finite());
        Row {
            estimator: estimator.to_string(),
            noise_px,
            position_pct: known(|e| e.position_pct),
            orientation_pct: known(|e| e.orientation_pct),
            position_m: known(|e| e.position_m),
            orientation_deg: known(|e| e.orientation_deg),
            us_per_pose: None,
            failures: Some(self.failures),
            effective_samples: None,
        }
    }
}

impl<'a> Evaluation<'a> {
    /// The first `count` samples of a sampler.
    pub fn new(sampler: &'a Sampler<'a>, count: u64) -> Self {
        Self { sampler, count }
    }

    /// The scene.
    pub fn scene(&self) -> &'a Scene {
        self.sampler.scene()
    }

    /// Asks an estimator at a level of noise, and measures its time.
    pub fn measure<E: BatchEstimator + ?Sized>(&self, estimator: &E, noise_px: f64) -> Row {
        let tally = self.tally(noise_px, |frames| {
            let answers = estimator.estimate_all(&frames.pixels);
            Tally::of(answers.iter().zip(&frames.poses).map(|(answer, truth)| {
                answer
                    .filter(is_finite)
                    .map(|pose| PoseError::between(&pose, truth))
            }))
        });
        Row {
            us_per_pose: Some(self.us_per_pose(noise_px, |frames| {
                std::hint::black_box(estimator.estimate_all(&frames.pixels));
            })),
            ..tally.row(estimator.name(), noise_px)
        }
    }

    /// Adds up what comes of all frames: in parallel, but in one order whatever the threads.
    fn tally(&self, noise_px: f64, of: impl Fn(&Frames) -> Tally + Sync) -> Tally {
        const CHUNK: u64 = 256;
        let starts: Vec<u64> = (0..self.count.div_ceil(CHUNK)).map(|i| i * CHUNK).collect();
        let parts: Vec<Tally> = starts
            .into_par_iter()
            .map(|start| of(&self.frames(start..self.count.min(start + CHUNK), noise_px)))
            .collect();
        parts.iter().fold(Tally::default(), |mut sum, part| {
            sum.errors.join(&part.errors);
            sum.failures += part.failures;
            sum.effective_samples += part.effective_samples;
            sum
        })
    }

    fn frames(&self, indices: Range<u64>, noise_px: f64) -> Frames {
        let mut frames = Frames {
            first: indices.start,
            poses: Vec::new(),
            pixels: Vec::new(),
        };
        for index in indices {
            let sample = self.sampler.draw(index);
            frames.pixels.push(sample.noisy_px(noise_px));
            frames.poses.push(sample.pose);
        }
        frames
    }

    /// Time a pose on the thread that calls, which is idle otherwise: the least of some passes
    /// over the same poses, so that what else the machine did counts as little as can be.
    fn us_per_pose(&self, noise_px: f64, pass: impl Fn(&Frames)) -> f64 {
        const POSES: u64 = 256;
        const LEAST_PASSES: usize = 5;
        const LEAST_TIME: Duration = Duration::from_millis(40);
        let frames = self.frames(0..self.count.min(POSES), noise_px);
        let start = Instant::now();
        let mut least = Duration::MAX;
        let mut passes = 0;
        while passes < LEAST_PASSES || start.elapsed() < LEAST_TIME {
            let begun = Instant::now();
            pass(&frames);
            least = least.min(begun.elapsed());
            passes += 1;
        }
        1e6 * least.as_secs_f64() / frames.poses.len() as f64
    }
}

fn is_finite(pose: &Pose) -> bool {
    let numbers = pose.position_m.iter().chain(pose.deck_from_body.matrix());
    numbers.into_iter().all(|number| number.is_finite())
}
