//! Consensus: the pose that most landmarks agree on, where some are taken for others.

use nalgebra::{Vector2, Vector3};
use rand::seq::index;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use super::Estimator;
use super::fit::Sightings;
use super::ml::refine;
use super::p3p;
use super::placement::rays;
use crate::frames::Pose;
use crate::scene::{MIN_LANDMARKS, Scene};

/// How consensus is sought.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RansacOptions {
    /// How far in the image a landmark may be from where a pose expects it.
    pub inlier_px: f64,
    /// Most triples that are tried; all of them, if there are no more.
    pub triples: usize,
    /// Seed of the triples.
    pub seed: u64,
}

/// Poses of triples of landmarks, scored by all of them; the best is refined on its inliers.
///
/// # Source
/// M. Fischler and R. Bolles, 1981; the score as P. Torr and A. Zisserman, 2000 (MSAC).
#[derive(Clone, Debug)]
pub struct Ransac<'a> {
    scene: &'a Scene,
    inlier_px: f64,
    triples: Vec<[usize; 3]>,
}

/// A pose and the landmarks that agree with it.
#[derive(Clone, Debug, PartialEq)]
pub struct Consensus {
    /// The pose of least squares on the inliers.
    pub pose: Pose,
    /// For each landmark whether it agrees.
    pub inliers: Vec<bool>,
}

impl<'a> Ransac<'a> {
    /// The estimator of a scene.
    pub fn new(scene: &'a Scene, options: RansacOptions) -> Self {
        let count = scene.landmarks_m().len();
        let possible = count * (count - 1) * (count - 2) / 6;
        let triples = if possible <= options.triples {
            (2..count)
                .flat_map(|i| (1..i).flat_map(move |j| (0..j).map(move |k| [i, j, k])))
                .collect()
        } else {
            let mut rng = ChaCha8Rng::seed_from_u64(options.seed);
            (0..options.triples)
                .map(|_| {
                    let drawn = index::sample(&mut rng, count, 3);
                    [drawn.index(0), drawn.index(1), drawn.index(2)]
                })
                .collect()
        };
        Self {
            scene,
            inlier_px: options.inlier_px,
            triples,
        }
    }

    /// The pose that most landmarks agree on; `None` if fewer than four agree on any.
    ///
    /// # Shape
    /// `[2n]`
    ///
    /// # Units
    /// px
    pub fn consensus(&self, pixels: &[f64]) -> Option<Consensus> {
        const ROUNDS: usize = 5;
        let mut pose = self.best_of_triples(pixels)?;
        let mut inliers = self.inliers(&pose, pixels);
        for _ in 0..ROUNDS {
            pose = self.refined(pose, pixels, &inliers)?;
            let again = self.inliers(&pose, pixels);
            if again == inliers {
                break;
            }
            inliers = again;
        }
        let agree = inliers.iter().filter(|agrees| **agrees).count();
        (agree >= MIN_LANDMARKS).then_some(Consensus { pose, inliers })
    }

    fn best_of_triples(&self, pixels: &[f64]) -> Option<Pose> {
        let landmarks = self.scene.landmarks_m();
        let rays = rays(self.scene, pixels)?;
        let mut best: Option<(f64, Pose)> = None;
        for triple in &self.triples {
            for placement in
                p3p::placements(&triple.map(|i| landmarks[i]), &triple.map(|i| rays[i]))
            {
                let pose = placement.pose(self.scene);
                let score = self
                    .squares_px(&pose, pixels)
                    .map(|square| square.min(self.inlier_px * self.inlier_px))
                    .sum();
                if best.is_none_or(|(least, _)| score < least) {
                    best = Some((score, pose));
                }
            }
        }
        best.map(|(_, pose)| pose)
    }

    fn inliers(&self, pose: &Pose, pixels: &[f64]) -> Vec<bool> {
        self.squares_px(pose, pixels)
            .map(|square| square <= self.inlier_px * self.inlier_px)
            .collect()
    }

    /// Squared distance in the image of each landmark; infinite if it is not ahead.
    fn squares_px(&self, pose: &Pose, pixels: &[f64]) -> impl Iterator<Item = f64> {
        let turn =
            self.scene.camera_from_body().matrix() * pose.deck_from_body.matrix().transpose();
        let position = pose.position_m;
        let landmarks = self.scene.landmarks_m().iter();
        landmarks
            .zip(pixels.chunks_exact(2))
            .map(move |(landmark, seen)| {
                let expected = self.scene.camera().pixel(&(turn * (landmark - position)));
                expected.map_or(f64::INFINITY, |expected| {
                    (expected - Vector2::new(seen[0], seen[1])).norm_squared()
                })
            })
    }

    fn refined(&self, pose: Pose, pixels: &[f64], inliers: &[bool]) -> Option<Pose> {
        let landmarks = self.scene.landmarks_m().iter();
        let (landmarks, seen): (Vec<Vector3<f64>>, Vec<[f64; 2]>) = landmarks
            .zip(pixels.chunks_exact(2))
            .zip(inliers)
            .filter(|(_, agrees)| **agrees)
            .map(|((landmark, seen), _)| (*landmark, [seen[0], seen[1]]))
            .unzip();
        let sightings = Sightings {
            landmarks_m: &landmarks,
            pixels: seen.as_flattened(),
            ..Sightings::of(self.scene, pixels)
        };
        (landmarks.len() >= MIN_LANDMARKS)
            .then(|| refine(&sightings, pose))?
            .map(|fit| fit.pose)
    }
}

impl Estimator for Ransac<'_> {
    fn name(&self) -> &'static str {
        "p3p+ransac"
    }

    fn estimate(&self, pixels: &[f64]) -> Option<Pose> {
        Some(self.consensus(pixels)?.pose)
    }
}
