//! Missing, swapped and outlying landmarks.

use hwgen_pose::evaluate::{ErrorSum, FloatEstimator, PoseError, Wiring};
use hwgen_pose::frames::Pose;
use hwgen_pose::sample::{NoiseShape, Sampler};
use hwgen_pose::scene::Scene;
use hwgen_pose::solve::Estimator;
use hwgen_pose::solve::fit::{Sightings, stepped};
use hwgen_pose::solve::ml::Ml;
use hwgen_pose::solve::ransac::{Ransac, RansacOptions};
use rayon::prelude::*;

use crate::bench::{POSES, Result, SEED, head, landing, named, percent, recipe, train};

const NOISE_PX: f64 = 1.0;

/// Frames without a fault that the thresholds come from, and the share of them that may exceed it.
const CLEAN: u64 = 20_000;
const FALSE_ALARMS: f64 = 1e-3;

/// What happens to a frame `[u0, v0, u1, v1, ...]`; the landmark concerned goes round by the index.
type Fault = fn(&mut [f64], usize);

const FAULTS: [(&str, Fault); 7] = [
    ("none", |_, _| {}),
    ("one missing, zeros in its place", |pixels, k| {
        pixels[2 * k] = 0.0;
        pixels[2 * k + 1] = 0.0;
    }),
    (
        "one missing, the mean of the others in its place",
        |pixels, k| {
            let others = (pixels.len() / 2 - 1) as f64;
            for axis in 0..2 {
                let sum: f64 = pixels.iter().skip(axis).step_by(2).sum();
                pixels[2 * k + axis] = (sum - pixels[2 * k + axis]) / others;
            }
        },
    ),
    ("two swapped", |pixels, k| {
        let next = (k + 1) % (pixels.len() / 2);
        pixels.swap(2 * k, 2 * next);
        pixels.swap(2 * k + 1, 2 * next + 1);
    }),
    ("one 10 px off", |pixels, k| pixels[2 * k] += 10.0),
    ("one 20 px off", |pixels, k| pixels[2 * k] += 20.0),
    ("one 50 px off", |pixels, k| pixels[2 * k] += 50.0),
];

/// Estimators in the order of the columns, and what their answers leave unexplained.
struct Panel<'a> {
    scene: &'a Scene,
    network: FloatEstimator<'a>,
    ml: Ml<'a>,
    ransac: Ransac<'a>,
}

impl Panel<'_> {
    /// Network; network and one Gauss-Newton step; maximum likelihood; P3P and RANSAC.
    fn answers(&self, pixels: &[f64]) -> [Option<Pose>; 4] {
        let network = self.network.estimate(pixels);
        let step = network.and_then(|pose| {
            let normal = Sightings::of(self.scene, pixels).normal(&pose)?;
            let step = normal.information.cholesky()?.solve(&normal.pull);
            Some(stepped(&pose, &step))
        });
        [
            network,
            step,
            self.ml.estimate(pixels),
            self.ransac.estimate(pixels),
        ]
    }

    /// Root mean square of the pixels' distance from where an answer would have them.
    fn residual_px(&self, pixels: &[f64], pose: Option<&Pose>) -> f64 {
        let square = pose.and_then(|pose| Sightings::of(self.scene, pixels).square_px(pose));
        square.map_or(f64::INFINITY, |s| (s / pixels.len() as f64).sqrt())
    }
}

pub fn study() -> Result<()> {
    let scene = landing()?;
    let trained = train(&scene, recipe(&[64]))?;
    let wiring = Wiring::new(&trained.net, &scene)?;
    let panel = Panel {
        scene: &scene,
        network: FloatEstimator::new(&trained.net, &wiring),
        ml: Ml::new(&scene),
        ransac: Ransac::new(
            &scene,
            RansacOptions {
                inlier_px: 5.0 * NOISE_PX,
                triples: 100,
                seed: SEED,
            },
        ),
    };
    let sampler = Sampler::new(&scene, NoiseShape::Gaussian, SEED)?;
    let thresholds = thresholds(&panel, &sampler);
    println!("Canonical scene, {NOISE_PX} px of noise, 64 neurons.");
    println!("Left: mean relative error of position / orientation, %.");
    println!(
        "Right: share of the frames whose pixels lie farther from where the answer would have"
    );
    println!(
        "them than in {} % of {CLEAN} frames without a fault,",
        100.0 * (1.0 - FALSE_ALARMS)
    );
    println!(
        "which the root mean square tells: {:.1} px after the network, {:.1} px after one",
        thresholds[0], thresholds[1]
    );
    println!(
        "Gauss-Newton step, {:.1} px after maximum likelihood.\n",
        thresholds[2]
    );
    let columns = [
        "fault",
        "network",
        "maximum likelihood",
        "P3P, RANSAC",
        "seen after the network",
        "after one step",
        "after maximum likelihood",
    ];
    head(&columns.map(str::to_string));
    for (name, fault) in FAULTS {
        let landmarks = scene.landmarks_m().len();
        let rows: Vec<([Option<PoseError>; 4], [bool; 3])> = (0..POSES)
            .into_par_iter()
            .map(|index| {
                let sample = sampler.draw(index);
                let mut pixels = sample.noisy_px(NOISE_PX);
                fault(&mut pixels, index as usize % landmarks);
                let answers = panel.answers(&pixels);
                let seen = [0, 1, 2]
                    .map(|k| panel.residual_px(&pixels, answers[k].as_ref()) > thresholds[k]);
                (
                    answers.map(|a| a.map(|pose| PoseError::between(&pose, &sample.pose))),
                    seen,
                )
            })
            .collect();
        let error = |k: usize| {
            let mut sum = ErrorSum::default();
            sum.extend(rows.iter().filter_map(|(errors, _)| errors[k]));
            let Some(mean) = sum.mean() else {
                return "no answer".into();
            };
            let [position, orientation] = [mean.position_pct, mean.orientation_pct].map(percent);
            let answered = 100.0 * sum.count() as f64 / rows.len() as f64;
            let share = if sum.count() < rows.len() {
                format!(" ({answered:.1} % answered)")
            } else {
                String::new()
            };
            format!("{position} / {orientation}{share}")
        };
        let share = |k: usize| {
            let seen = rows.iter().filter(|(_, seen)| seen[k]).count();
            format!("{:.1} %", 100.0 * seen as f64 / rows.len() as f64)
        };
        named(
            name,
            [error(0), error(2), error(3), share(0), share(1), share(2)],
        );
    }
    Ok(())
}

/// Residuals that the allowed share of frames without a fault exceeds.
fn thresholds(panel: &Panel<'_>, sampler: &Sampler<'_>) -> [f64; 3] {
    let residuals: Vec<[f64; 3]> = (POSES..POSES + CLEAN)
        .into_par_iter()
        .map(|index| {
            let pixels = sampler.draw(index).noisy_px(NOISE_PX);
            let answers = panel.answers(&pixels);
            [0, 1, 2].map(|k| panel.residual_px(&pixels, answers[k].as_ref()))
        })
        .collect();
    let rank = ((1.0 - FALSE_ALARMS) * CLEAN as f64) as usize;
    [0, 1, 2].map(|k| {
        let mut all: Vec<f64> = residuals.iter().map(|r| r[k]).collect();
        all.sort_by(f64::total_cmp);
        all[rank]
    })
}
