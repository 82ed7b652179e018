//! What all studies share: the canonical scene, training, measuring, tables.

use std::error::Error;
use std::time::Instant;

use hwgen_pose::evaluate::{Evaluation, FloatEstimator, Method, Row, Wiring};
use hwgen_pose::sample::{NoiseShape, Sampler};
use hwgen_pose::scene::Scene;
use hwgen_pose::scene_file;
use hwgen_pose::solve::Estimator;
use hwgen_pose::train::recipe::Recipe;
use hwgen_pose::train::{Checkpoint, Training};
use hwgen_spec::network::FloatNet;

pub type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Poses that answers are measured on.
pub const POSES: u64 = 4000;

/// Seed of trainings and of the poses measured on, which never meet.
pub const SEED: u64 = 1;

/// The canonical scene.
pub fn landing() -> Result<Scene> {
    let text = include_bytes!("../../../designs/landing/scene.toml");
    Ok(scene_file::read(text, |name| Err(format!("no file {name}")))?.into_scene())
}

/// The default recipe at a size at which a study of many trainings takes minutes.
pub fn recipe(hidden: &[usize]) -> Recipe {
    Recipe {
        hidden: hidden.to_vec(),
        samples: 20_000,
        // Clear pixels count as much as they did when the pages were written.
        noise_half_px: 0.3,
        epochs: 40,
        ..Recipe::best()
    }
}

/// A training from the start to its end.
pub struct Trained {
    pub net: FloatNet,
    pub checkpoint: Checkpoint,
    /// Without drawing the samples.
    pub seconds: f64,
}

/// Trains the networks of a scene.
pub fn train(scene: &Scene, recipe: Recipe) -> Result<Trained> {
    recipe.check()?;
    let sampler = Sampler::new(scene, NoiseShape::Gaussian, SEED)?;
    let mut training = Training::new(&sampler, recipe, SEED);
    let start = Instant::now();
    while training.epoch()? {}
    Ok(Trained {
        net: training.net(),
        seconds: start.elapsed().as_secs_f64(),
        checkpoint: training.checkpoint().clone(),
    })
}

/// The errors of networks at levels of noise.
pub fn errors(scene: &Scene, net: &FloatNet, noise_px: &[f64]) -> Result<Vec<Row>> {
    let wiring = Wiring::new(net, scene)?;
    measure(scene, &FloatEstimator::new(net, &wiring), noise_px)
}

/// The errors of an estimator at levels of noise.
pub fn measure(scene: &Scene, estimator: &dyn Estimator, noise_px: &[f64]) -> Result<Vec<Row>> {
    let sampler = Sampler::new(scene, NoiseShape::Gaussian, SEED)?;
    let evaluation = Evaluation::new(&sampler, POSES);
    let rows = noise_px.iter().map(|n| evaluation.measure(estimator, *n));
    Ok(rows.collect())
}

/// The errors of a method at levels of noise.
pub fn method(scene: &Scene, method: Method, noise_px: &[f64]) -> Result<Vec<Row>> {
    let sampler = Sampler::new(scene, NoiseShape::Gaussian, SEED)?;
    let evaluation = Evaluation::new(&sampler, POSES);
    let rows = noise_px
        .iter()
        .filter_map(|n| evaluation.row(method, *n))
        .collect();
    Ok(rows)
}

/// Position and orientation of a row, in percent.
pub fn cell(row: &Row) -> String {
    let part = |value: Option<f64>| value.map_or("-".to_string(), percent);
    format!("{} / {}", part(row.position_pct), part(row.orientation_pct))
}

/// Three digits that count.
pub fn percent(value: f64) -> String {
    let digits = match value.abs() {
        v if v < 1.0 => 3,
        v if v < 10.0 => 2,
        v if v < 100.0 => 1,
        _ => 0,
    };
    format!("{value:.digits$}")
}

/// The head of a Markdown table.
pub fn head(columns: &[String]) {
    line(columns);
    line(&vec!["---".to_string(); columns.len()]);
}

/// A line of a Markdown table.
pub fn line(cells: &[String]) {
    println!("| {} |", cells.join(" | "));
}

/// A line that begins with a name.
pub fn named(name: impl Into<String>, cells: impl IntoIterator<Item = String>) {
    let all: Vec<String> = std::iter::once(name.into()).chain(cells).collect();
    line(&all);
}

/// A head whose columns are levels of noise.
pub fn noise_head(first: &str, noise_px: &[f64]) {
    let levels = noise_px.iter().map(|n| format!("{n} px"));
    head(
        &std::iter::once(first.to_string())
            .chain(levels)
            .collect::<Vec<_>>(),
    );
}
