//! Noise in training against noise in use.

use hwgen_pose::evaluate::Method;
use hwgen_pose::train::recipe::Recipe;

use crate::bench::{Result, cell, errors, landing, method, named, noise_head, recipe, train};

const LEVELS_PX: [f64; 6] = [0.0, 0.1, 0.5, 1.0, 3.0, 5.0];

pub fn study() -> Result<()> {
    let scene = landing()?;
    println!("Canonical scene, 64 neurons; mean relative error of position / orientation, %.");
    println!(
        "A user who knows the noise picks a row; one who does not compares with the list's.\n"
    );
    noise_head("trained with", &LEVELS_PX);
    let mut lists: Vec<(String, Vec<f64>)> = [0.0, 0.1, 0.5, 1.0, 3.0, 5.0]
        .map(|level| (format!("{level} px"), vec![level]))
        .into();
    lists.push((
        "the list of the preset `best`".into(),
        Recipe::best().noise_px,
    ));
    for (name, noise_px) in lists {
        let trained = train(
            &scene,
            Recipe {
                noise_px,
                ..recipe(&[64])
            },
        )?;
        named(
            name,
            errors(&scene, &trained.net, &LEVELS_PX)?.iter().map(cell),
        );
    }
    let limit = method(&scene, Method::Bayes, &LEVELS_PX)?;
    named("posterior mean, noise known", limit.iter().map(cell));
    Ok(())
}
