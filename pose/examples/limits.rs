//! What an estimator can reach that is not told how large the noise is.
//!
//! `cargo run --release --example limits -p hwgen-pose` prints mean relative errors of the
//! posterior mean on the canonical scene (4000 poses, seed 1) for some lists of noise levels:
//! with the plain means and with those weighted by one over the length.

use hwgen_pose::sample::{NoiseShape, Sampler};
use hwgen_pose::scene_file;
use hwgen_pose::solve::bayes::{Bayes, NoiseLevel};
use nalgebra::Vector3;
use rayon::prelude::*;

const POSES: u64 = 4000;
const DRAWS: usize = 200;
const NOISE_PX: [f64; 4] = [0.1, 1.0, 3.0, 5.0];

/// Lists as `hwgen train --noise` takes them; a level that stands there twice is twice as probable.
const LISTS: [(&str, &[f64]); 4] = [
    ("the true level alone", &[]),
    (
        "ten levels, as probable",
        &[0.05, 0.1, 0.3, 0.6, 1.0, 1.6, 2.3, 3.0, 4.0, 5.0],
    ),
    ("0.05, 0.3, 1 twice, 3", &[0.05, 0.3, 1.0, 1.0, 3.0]),
    (
        "that of the preset `best`",
        &[
            0.05, 0.1, 0.3, 0.6, 1.0, 1.0, 1.0, 1.0, 1.0, 1.6, 2.3, 3.0, 3.0, 3.0, 5.0,
        ],
    ),
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let text = include_bytes!("../../designs/landing/scene.toml");
    let scene = scene_file::read(text, |name| Err(format!("no file {name}")))?.into_scene();
    let sampler = Sampler::new(&scene, NoiseShape::Gaussian, 1)?;
    println!("position / orientation, %: plain means; weighted means");
    for (name, list) in LISTS {
        println!("{name}");
        for noise_px in NOISE_PX {
            let list = if list.is_empty() { &[noise_px] } else { list };
            let levels: Vec<NoiseLevel> = list
                .iter()
                .map(|sigma_px| NoiseLevel {
                    sigma_px: *sigma_px,
                    probability: 1.0,
                })
                .collect();
            let bayes = Bayes::new(&scene, &levels, DRAWS, 1);
            let errors: Vec<[f64; 4]> = (0..POSES)
                .into_par_iter()
                .filter_map(|index| {
                    let sample = sampler.draw(index);
                    let found = bayes.posterior(&sample.noisy_px(noise_px), index, None)?;
                    let (p, r) = (sample.pose.position_m, sample.pose.rodrigues_rad());
                    let relative = |a: Vector3<f64>, b: Vector3<f64>| (a - b).norm() / b.norm();
                    Some([
                        relative(found.position_m, p),
                        relative(found.rodrigues_rad, r),
                        relative(found.relative_position_m, p),
                        relative(found.relative_rodrigues_rad, r),
                    ])
                })
                .collect();
            let mean =
                |k: usize| 100.0 * errors.iter().map(|e| e[k]).sum::<f64>() / errors.len() as f64;
            println!(
                "  {noise_px} px: {:.3} / {:.2}; {:.3} / {:.2}  ({} of {POSES} poses)",
                mean(0),
                mean(1),
                mean(2),
                mean(3),
                errors.len(),
            );
        }
    }
    Ok(())
}
