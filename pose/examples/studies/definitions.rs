//! What the published table may mean by relative error.

use hwgen_pose::evaluate::{FloatEstimator, PUBLISHED, Wiring};
use hwgen_pose::sample::{NoiseShape, Sampler};
use hwgen_pose::solve::Estimator;
use hwgen_pose::train::recipe::Recipe;
use nalgebra::Vector3;

use crate::bench::{POSES, Result, SEED, landing, named, noise_head, percent, train};

type Pair = (Vector3<f64>, Vector3<f64>);

/// A definition on estimates and truths, as a fraction.
type Definition = fn(&[Pair]) -> f64;

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(s, n), v| (s + v, n + 1.0));
    sum / count
}

fn relative(pairs: &[Pair]) -> impl Iterator<Item = f64> {
    pairs.iter().map(|(e, t)| (e - t).norm() / t.norm())
}

const DEFINITIONS: [(&str, Definition); 7] = [
    ("mean of \\|e\\| / \\|t\\|", |pairs| mean(relative(pairs))),
    ("median of \\|e\\| / \\|t\\|", |pairs| {
        let mut all: Vec<f64> = relative(pairs).collect();
        all.sort_by(f64::total_cmp);
        all[all.len() / 2]
    }),
    ("root of the mean of (\\|e\\| / \\|t\\|)²", |pairs| {
        mean(relative(pairs).map(|r| r * r)).sqrt()
    }),
    ("mean of \\|e\\| / mean of \\|t\\|", |pairs| {
        mean(pairs.iter().map(|(e, t)| (e - t).norm())) / mean(pairs.iter().map(|(_, t)| t.norm()))
    }),
    ("root mean square of e / that of t", |pairs| {
        let error = mean(pairs.iter().map(|(e, t)| (e - t).norm_squared()));
        (error / mean(pairs.iter().map(|(_, t)| t.norm_squared()))).sqrt()
    }),
    (
        "mean over the three of mean \\|eᵢ\\| / mean \\|tᵢ\\|",
        |pairs| {
            mean((0..3).map(|i| {
                mean(pairs.iter().map(|(e, t)| (e[i] - t[i]).abs()))
                    / mean(pairs.iter().map(|(_, t)| t[i].abs()))
            }))
        },
    ),
    (
        "mean over the three of mean \\|eᵢ\\| / range of tᵢ",
        |pairs| {
            mean((0..3).map(|i| {
                let (low, high) = pairs
                    .iter()
                    .fold((f64::MAX, f64::MIN), |(low, high), (_, t)| {
                        (low.min(t[i]), high.max(t[i]))
                    });
                mean(pairs.iter().map(|(e, t)| (e[i] - t[i]).abs())) / (high - low)
            }))
        },
    ),
];

pub fn study() -> Result<()> {
    let scene = landing()?;
    println!(
        "The preset `paper` on the canonical scene, by each definition: position / orientation, %."
    );
    println!("e is the error, t the truth; for the orientation both are of Rodrigues vectors.\n");
    let levels_px = PUBLISHED.map(|cell| cell.noise_px);
    noise_head("definition", &levels_px);
    named(
        "published",
        PUBLISHED.map(|c| format!("{} / {}", c.position_pct, c.orientation_pct)),
    );
    let trained = train(&scene, Recipe::paper())?;
    let wiring = Wiring::new(&trained.net, &scene)?;
    let network = FloatEstimator::new(&trained.net, &wiring);
    let sampler = Sampler::new(&scene, NoiseShape::Gaussian, SEED)?;
    let answers = levels_px.map(|noise_px| {
        let mut pairs: [Vec<Pair>; 2] = Default::default();
        for index in 0..POSES {
            let sample = sampler.draw(index);
            if let Some(pose) = network.estimate(&sample.noisy_px(noise_px)) {
                pairs[0].push((pose.position_m, sample.pose.position_m));
                pairs[1].push((pose.rodrigues_rad(), sample.pose.rodrigues_rad()));
            }
        }
        pairs
    });
    for (name, definition) in DEFINITIONS {
        named(
            name,
            answers.each_ref().map(|pairs| {
                let [position, orientation] =
                    pairs.each_ref().map(|p| percent(100.0 * definition(p)));
                format!("{position} / {orientation}")
            }),
        );
    }
    Ok(())
}
