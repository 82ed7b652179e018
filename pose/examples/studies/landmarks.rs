//! Number of landmarks.

use hwgen_pose::evaluate::Method;
use hwgen_pose::scene::{Scene, SceneDraft};
use nalgebra::Vector3;

use crate::bench::{Result, cell, errors, head, landing, method, named, recipe, train};

const HIDDEN: usize = 32;

/// Canonical landmarks, the mast's fourth, then more within the same space, evenly (the fractional
/// parts of the powers of the plastic number's relative in three dimensions).
fn landmarks_m(canonical: &[Vector3<f64>], count: usize) -> Vec<Vector3<f64>> {
    const STEP: [f64; 3] = [0.819_172_5, 0.671_043_6, 0.549_700_5];
    let first = [0, 1, 2, 4, 3].map(|i| canonical[i]);
    let more = (1..).map(|i| {
        let part = |k: usize| (f64::from(i) * STEP[k]).fract();
        Vector3::new(4.0 * part(0), 5.0 * part(1) - 2.0, 8.0 * part(2) - 4.0)
    });
    first.into_iter().chain(more).take(count).collect()
}

pub fn study() -> Result<()> {
    let landing = landing()?;
    println!("Camera and poses of the canonical scene, {HIDDEN} neurons, 1 px of noise in use;");
    println!("mean relative error of position / orientation, %.");
    println!(
        "The shared layer keeps 16 principal axes at most: from 8 landmarks on each further one"
    );
    println!("costs 32 multiplications a frame, and the rest of the networks stays as it is.\n");
    let columns = [
        "landmarks",
        "multiplications",
        "of them in the shared layer",
        "posterior mean, noise known",
        "network",
        "over the limit",
    ];
    head(&columns.map(str::to_string));
    for count in [4, 5, 6, 8, 12, 16, 24, 32] {
        let scene = Scene::new(SceneDraft {
            landmarks_m: landmarks_m(landing.landmarks_m(), count),
            ..landing.draft().clone()
        })?;
        let limit = method(&scene, Method::Bayes, &[1.0])?.remove(0);
        let trained = train(&scene, recipe(&[HIDDEN]))?;
        let found = errors(&scene, &trained.net, &[1.0])?.remove(0);
        let over = |found: Option<f64>, limit: Option<f64>| {
            found
                .zip(limit)
                .map_or("-".into(), |(f, l)| format!("{:.2}", f / l))
        };
        let shared: usize = trained.net.shared.iter().map(|l| l.weights.len()).sum();
        named(
            count.to_string(),
            [
                trained.net.macs().to_string(),
                shared.to_string(),
                cell(&limit),
                cell(&found),
                format!(
                    "{} / {}",
                    over(found.position_pct, limit.position_pct),
                    over(found.orientation_pct, limit.orientation_pct)
                ),
            ],
        );
    }
    Ok(())
}
