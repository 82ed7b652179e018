//! One suite for all solvers: exact without noise, at their limits with it.

mod support;

use hwgen_pose::frames::{Pose, rodrigues};
use hwgen_pose::sample::{NoiseShape, Sample, Sampler};
use hwgen_pose::scene::{Distortion, Parameters, Scene, SceneDraft, parameters_of, pose_of};
use hwgen_pose::solve::Estimator;
use hwgen_pose::solve::bayes::{Bayes, NoiseLevel};
use hwgen_pose::solve::crb::Bound;
use hwgen_pose::solve::epnp::EPnp;
use hwgen_pose::solve::ml::Ml;
use hwgen_pose::solve::ransac::{Ransac, RansacOptions};
use hwgen_pose::solve::sqpnp::SqPnp;
use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rayon::prelude::*;
use support::{landing, landing_draft};

fn with_landmarks(landmarks: &[[f64; 3]]) -> SceneDraft {
    SceneDraft {
        landmarks_m: landmarks.iter().copied().map(Vector3::from).collect(),
        ..landing_draft()
    }
}

/// The capture frame without the mast light: four landmarks in a plane.
fn quad() -> Scene {
    let mut draft = landing_draft();
    draft.landmarks_m.truncate(4);
    Scene::new(draft).unwrap()
}

/// Four landmarks that are in no plane.
fn corner() -> Scene {
    let landmarks = [
        [0.0, 2.0, -4.0],
        [0.0, 2.0, 4.0],
        [0.0, -2.0, -3.0],
        [5.0, -1.0, 2.0],
    ];
    Scene::new(with_landmarks(&landmarks)).unwrap()
}

/// Eight landmarks on a flat deck, seen from above.
fn deck() -> Scene {
    let mut draft = with_landmarks(&[
        [-6.0, 0.0, -5.0],
        [-6.0, 0.0, 4.0],
        [0.0, 0.0, -5.0],
        [0.0, 0.0, 4.0],
        [6.0, 0.0, -5.0],
        [6.0, 0.0, 4.0],
        [12.0, 0.0, -5.0],
        [12.0, 0.0, 4.0],
    ]);
    draft.poses.lower[0] = 20.0;
    draft.poses.lower[1] = 5f64.to_radians();
    draft.poses.upper[1] = 12f64.to_radians();
    Scene::new(draft).unwrap()
}

/// The canonical scene through a lens.
fn bent() -> Scene {
    let mut draft = landing_draft();
    draft.camera.distortion = Distortion {
        radial: [-0.28, 0.07, 0.01],
        tangential: [1e-3, -5e-4],
    };
    Scene::new(draft).unwrap()
}

const RANSAC: RansacOptions = RansacOptions {
    inlier_px: 4.0,
    triples: 100,
    seed: 1,
};

fn level(sigma_px: f64) -> [NoiseLevel; 1] {
    [NoiseLevel {
        sigma_px,
        probability: 1.0,
    }]
}

fn estimators(scene: &Scene) -> Vec<Box<dyn Estimator + '_>> {
    vec![
        Box::new(Ml::new(scene)),
        Box::new(EPnp::new(scene)),
        Box::new(SqPnp::new(scene)),
        Box::new(Ransac::new(scene, RANSAC)),
        Box::new(Bayes::new(scene, &level(0.0), 20, 1)),
    ]
}

fn samples(scene: &Scene, seed: u64, count: u64) -> Vec<Sample> {
    let sampler = Sampler::new(scene, NoiseShape::Gaussian, seed).unwrap();
    (0..count).map(|i| sampler.draw(i)).collect()
}

/// Relative errors of position and Rodrigues vector.
fn errors(found: &Pose, truth: &Pose) -> [f64; 2] {
    let (p, r) = (truth.position_m, truth.rodrigues_rad());
    [
        (found.position_m - p).norm() / p.norm(),
        (found.rodrigues_rad() - r).norm() / r.norm(),
    ]
}

/// A mean and its standard error.
fn mean(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let square = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (mean, (square / count).sqrt())
}

#[test]
fn every_solver_is_exact_without_noise() {
    for (name, scene) in [
        ("landing", landing()),
        ("bent", bent()),
        ("quad", quad()),
        ("corner", corner()),
        ("deck", deck()),
    ] {
        let samples = samples(&scene, 1, 200);
        for estimator in estimators(&scene) {
            for (i, sample) in samples.iter().enumerate() {
                let found = estimator.estimate(&sample.clean_px);
                let [position, turn] = errors(&found.unwrap(), &sample.pose);
                assert!(
                    position < 1e-6 && turn < 1e-6,
                    "{name} {} {i}: {position:e} {turn:e}",
                    estimator.name()
                );
            }
        }
    }
}

#[test]
fn what_is_no_image_has_no_answer() {
    for scene in [landing(), bent(), quad(), deck()] {
        for estimator in estimators(&scene) {
            let mut pixels = samples(&scene, 1, 1)[0].clean_px.clone();
            pixels[3] = f64::NAN;
            assert_eq!(estimator.estimate(&pixels), None, "{}", estimator.name());
        }
    }
}

#[test]
fn maximum_likelihood_is_at_the_bound() {
    let scene = landing();
    let ml = Ml::new(&scene);
    let ratios: Vec<[f64; 3]> = samples(&scene, 2, 4000)
        .par_iter()
        .map(|sample| {
            let found = ml.estimate(&sample.noisy_px(1.0)).unwrap();
            let bound = Bound::at(&scene, &sample.pose, 1.0).unwrap();
            let turn = found
                .deck_from_body
                .rotation_to(&sample.pose.deck_from_body);
            let (p, r) = (sample.pose.position_m, sample.pose.rodrigues_rad());
            [
                (found.position_m - p).norm() / bound.position_error_m(),
                (found.rodrigues_rad() - r).norm() / bound.rodrigues_error_rad(),
                rodrigues(&turn).norm() / bound.turn_error_rad(),
            ]
        })
        .collect();
    for k in 0..3 {
        let (ratio, error) = mean(&ratios.iter().map(|r| r[k]).collect::<Vec<_>>());
        assert!((ratio - 1.0).abs() < 4.0 * error, "{k}: {ratio} +- {error}");
    }
}

#[test]
fn the_bound_holds_for_large_turns() {
    // The camera stands beside the deck and looks at it, upside down.
    let mut q = Parameters::from([30.0, 0.0, 0.0, 2.0, 0.0, 0.0]);
    let scene = landing();
    for roll in [0.0, 1.0, 2.5] {
        q[3] = roll;
        let pose = pose_of(&q);
        let clean = scene.project(&pose).unwrap();
        let bound = Bound::at(&scene, &pose, 0.01).unwrap();
        let ml = Ml::new(&scene);
        let ratios: Vec<f64> = samples(&scene, 3, 2000)
            .par_iter()
            .map(|sample| {
                let noise = sample.unit_noise.iter();
                let seen: Vec<f64> = clean.iter().zip(noise).map(|(z, n)| z + 0.01 * n).collect();
                let found = ml.estimate(&seen).unwrap();
                (found.rodrigues_rad() - pose.rodrigues_rad()).norm() / bound.rodrigues_error_rad()
            })
            .collect();
        let (ratio, error) = mean(&ratios);
        assert!(
            (ratio - 1.0).abs() < 4.0 * error,
            "{roll}: {ratio} +- {error}"
        );
    }
}

#[test]
fn the_bound_is_none_where_nothing_is_seen() {
    let behind = Pose::new(Vector3::new(20.0, 0.0, 0.0), Vector3::zeros());
    assert_eq!(Bound::at(&landing(), &behind, 1.0), None);
}

/// Mean relative errors in % of bound, maximum likelihood and posterior mean: computed before and
/// apart from this crate, the last from 400 poses.
const LIMITS: [(f64, [[f64; 2]; 3]); 4] = [
    (0.1, [[0.137, 1.83], [0.137, 1.82], [0.135, 1.82]]),
    (1.0, [[1.37, 18.3], [1.37, 18.2], [1.25, 17.0]]),
    (3.0, [[4.11, 54.9], [4.10, 54.7], [2.98, 39.5]]),
    (5.0, [[6.85, 91.4], [6.85, 91.3], [4.08, 51.8]]),
];

#[test]
fn limits_are_those_known() {
    const POSES: u64 = 2000;
    const REFERENCE_POSES: [f64; 3] = [4000.0, 4000.0, 400.0];
    let scene = landing();
    let ml = Ml::new(&scene);
    let samples = samples(&scene, 4, POSES);
    for (sigma_px, known) in LIMITS {
        let bayes = Bayes::new(&scene, &level(sigma_px), 100, 1);
        let found: Vec<[[f64; 2]; 3]> = samples
            .par_iter()
            .map(|sample| {
                let bound = Bound::at(&scene, &sample.pose, sigma_px).unwrap();
                let (p, r) = (sample.pose.position_m, sample.pose.rodrigues_rad());
                let seen = sample.noisy_px(sigma_px);
                [
                    [
                        bound.position_error_m() / p.norm(),
                        bound.rodrigues_error_rad() / r.norm(),
                    ],
                    errors(&ml.estimate(&seen).unwrap(), &sample.pose),
                    errors(&bayes.estimate(&seen).unwrap(), &sample.pose),
                ]
            })
            .collect();
        for (row, reference_poses) in REFERENCE_POSES.into_iter().enumerate() {
            for column in 0..2 {
                let percent = found.iter().map(|f| 100.0 * f[row][column]);
                let (value, error) = mean(&percent.collect::<Vec<_>>());
                // Both sides are means over poses.
                let error = error * (1.0 + POSES as f64 / reference_poses).sqrt();
                let miss = (value - known[row][column]).abs();
                assert!(
                    miss < 4.0 * error,
                    "{sigma_px} px, {row}, {column}: {value} +- {error}"
                );
            }
        }
    }
}

/// Six means over the posterior, their deviations, and the effective number of draws: by weighing
/// draws from the whole box.
fn plain_posterior(scene: &Scene, pixels: &[f64], sigma_px: f64) -> ([(f64, f64); 6], f64) {
    const DRAWS: usize = 300_000;
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let widths = scene.poses().widths();
    let mut expected = vec![0.0; pixels.len()];
    let draws: Vec<(f64, [f64; 6])> = (0..DRAWS)
        .map(|_| {
            let q = Parameters::from_fn(|i, _| {
                scene.poses().lower[i] + widths[i] * rng.random::<f64>()
            });
            let pose = pose_of(&q);
            assert!(scene.project_into(&pose, &mut expected));
            let misses = expected.iter().zip(pixels).map(|(a, b)| (a - b).powi(2));
            let exponent = -misses.sum::<f64>() / (2.0 * sigma_px * sigma_px);
            (exponent, six(&pose.position_m, &pose.rodrigues_rad()))
        })
        .collect();
    let most = draws.iter().map(|d| d.0).fold(f64::NEG_INFINITY, f64::max);
    let weights: Vec<f64> = draws.iter().map(|d| (d.0 - most).exp()).collect();
    let total: f64 = weights.iter().sum();
    let squares: f64 = weights.iter().map(|w| w * w).sum();
    let means = std::array::from_fn(|k| {
        let weigh = |f: &dyn Fn(f64) -> f64| {
            let terms = weights.iter().zip(&draws).map(|(w, d)| w * f(d.1[k]));
            terms.sum::<f64>() / total
        };
        let mean = weigh(&|x| x);
        (mean, weigh(&|x| (x - mean).powi(2)).sqrt())
    });
    (means, total * total / squares)
}

fn six(p: &Vector3<f64>, r: &Vector3<f64>) -> [f64; 6] {
    [p.x, p.y, p.z, r.x, r.y, r.z]
}

/// A box so narrow that large noise leaves the posterior cut off on many sides.
fn narrow() -> Scene {
    let mut draft = landing_draft();
    for i in 0..6 {
        let (middle, half) = if i == 0 { (25.0, 2.0) } else { (0.01, 0.01) };
        draft.poses.lower[i] = middle - half;
        draft.poses.upper[i] = middle + half;
    }
    Scene::new(draft).unwrap()
}

#[test]
fn the_posterior_is_that_of_plain_sampling() {
    let scene = narrow();
    let bayes = Bayes::new(&scene, &level(15.0), 2000, 1);
    let samples = samples(&scene, 6, 2);
    let inside = samples.iter().map(|sample| sample.noisy_px(15.0));
    // From beyond the box, where what is likeliest lies on its faces; the last two are drawn
    // within.
    let beyond = [0.1, 0.6, 1.0].into_iter().map(|by| {
        let q = scene.poses().upper + by * scene.poses().widths();
        scene.project(&pose_of(&q)).unwrap()
    });
    for (i, seen) in inside.chain(beyond).enumerate() {
        let found = bayes.posterior(&seen, 1, None).unwrap();
        let (plain, draws) = plain_posterior(&scene, &seen, 15.0);
        assert!(draws > 100.0, "{i}: {draws}");
        assert!(
            found.effective_samples > 200.0,
            "{i}: {}",
            found.effective_samples
        );
        let tolerance = 4.5 * (draws.recip() + found.effective_samples.recip()).sqrt();
        let means = six(&found.position_m, &found.rodrigues_rad);
        for (k, (value, (mean, deviation))) in means.into_iter().zip(plain).enumerate() {
            let miss = (value - mean).abs() / deviation;
            assert!(
                miss < tolerance,
                "{i} {k}: {value}, plain {mean} +- {deviation}"
            );
        }
    }
}

#[test]
fn the_posterior_is_in_the_box_whatever_is_seen() {
    let scene = landing();
    let bayes = Bayes::new(&scene, &level(0.1), 24, 1);
    for sample in samples(&scene, 10, 200) {
        // Fifty times the noise that is told, and then two landmarks swapped.
        let mut seen = sample.noisy_px(5.0);
        for _ in 0..2 {
            let posterior = bayes.posterior(&seen, 1, None).unwrap();
            assert!(posterior.effective_samples >= 1.0);
            let mean = Pose::new(posterior.position_m, posterior.rodrigues_rad);
            let q = parameters_of(&mean);
            let poses = scene.poses();
            let slack = 0.01 * poses.widths();
            assert!(
                (0..6)
                    .all(|i| q[i] > poses.lower[i] - slack[i] && q[i] < poses.upper[i] + slack[i]),
                "{q}"
            );
            seen.swap(0, 2);
            seen.swap(1, 3);
        }
    }
}

#[test]
fn the_posterior_finds_out_how_much_noise_there_is() {
    let scene = landing();
    let sizes = [0.0, 0.1, 1.0, 5.0];
    let levels = sizes.map(|sigma_px| NoiseLevel {
        sigma_px,
        probability: 0.25,
    });
    let mixed = Bayes::new(&scene, &levels, 200, 1);
    let samples = samples(&scene, 7, 500);
    for sigma_px in sizes {
        let told = Bayes::new(&scene, &level(sigma_px), 200, 1);
        let error = |bayes: &Bayes| {
            let errors: Vec<f64> = samples
                .par_iter()
                .map(|s| errors(&bayes.estimate(&s.noisy_px(sigma_px)).unwrap(), &s.pose)[0])
                .collect();
            mean(&errors).0
        };
        let (mixed, told) = (error(&mixed), error(&told));
        assert!(mixed < 1.1 * told + 1e-9, "{sigma_px}: {mixed} {told}");
    }
}

#[test]
fn draws_are_those_of_seed_and_index() {
    let scene = landing();
    let bayes = Bayes::new(&scene, &level(1.0), 24, 1);
    let sample = &samples(&scene, 8, 1)[0];
    let seen = sample.noisy_px(1.0);
    let at = |index| {
        bayes
            .posterior(&seen, index, Some(&sample.parameters))
            .unwrap()
    };
    assert_eq!(at(3), at(3));
    assert_ne!(at(3), at(4));
    // Weighted means lie where the weights say.
    let posterior = at(3);
    let length = posterior.position_m.norm();
    assert!((posterior.position_weight * length - 1.0).abs() < 0.01);
    assert!(posterior.relative_position_m.norm() < posterior.position_m.norm());
}

#[test]
fn swapped_landmarks_are_found_and_left_out() {
    let scene = deck();
    let ransac = Ransac::new(&scene, RANSAC);
    let ml = Ml::new(&scene);
    for (i, sample) in samples(&scene, 9, 56).iter().enumerate() {
        let (a, b) = (i / 7, (i / 7 + 1 + i % 7) % 8);
        let mut seen = sample.noisy_px(0.3);
        for k in 0..2 {
            seen.swap(2 * a + k, 2 * b + k);
        }
        let consensus = ransac.consensus(&seen).unwrap();
        let wrong: Vec<usize> = (0..8).filter(|&k| !consensus.inliers[k]).collect();
        assert_eq!(wrong, [a.min(b), a.max(b)]);
        let [position, _] = errors(&consensus.pose, &sample.pose);
        assert!(position < 0.02, "{i}: {position}");
        // Least squares alone is led astray.
        let [astray, _] = errors(&ml.estimate(&seen).unwrap(), &sample.pose);
        assert!(astray > 2.0 * position, "{i}: {astray} {position}");
    }
}
