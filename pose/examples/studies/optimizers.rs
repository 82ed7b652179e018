//! The optimisers side by side.

use hwgen_pose::train::recipe::{Optimizer, Recipe};

use crate::bench::{Result, cell, errors, head, landing, named, percent, recipe, train};

const LEVELS_PX: [f64; 3] = [0.0, 1.0, 3.0];

pub fn study() -> Result<()> {
    let scene = landing()?;
    println!(
        "Canonical scene, 64 neurons, 20,000 samples; losses of position / orientation are half"
    );
    println!("the mean squares of the standardised errors on the samples kept back, in 1e-6;");
    println!(
        "errors are mean relative ones in %; seconds are those of both networks on this machine."
    );
    println!("The best epoch of each counts; nothing stops early.\n");
    let columns = [
        "samples and targets",
        "optimizer",
        "epochs",
        "seconds",
        "validation loss",
        "0 px",
        "1 px",
        "3 px",
    ];
    head(&columns.map(str::to_string));
    let published = Recipe {
        hidden: vec![64],
        samples: 20_000,
        ..Recipe::paper()
    };
    for (name, base) in [
        ("preset `paper`", published),
        ("preset `best`", recipe(&[64])),
    ] {
        for (optimizer, epochs) in [
            (Optimizer::Rprop, 300),
            (Optimizer::Rprop, 3000),
            (Optimizer::Levenberg, 40),
        ] {
            let trained = train(
                &scene,
                Recipe {
                    optimizer,
                    epochs,
                    patience: epochs,
                    ..base.clone()
                },
            )?;
            let loss = trained.checkpoint.learners.each_ref().map(|learner| {
                let losses = learner.best_losses().expect("an epoch");
                percent(1e6 * losses.validation)
            });
            let spelt = match optimizer {
                Optimizer::Rprop => "rprop",
                Optimizer::Levenberg => "levenberg",
            };
            let rows = errors(&scene, &trained.net, &LEVELS_PX)?;
            let cells = [
                spelt.to_string(),
                epochs.to_string(),
                format!("{:.0}", trained.seconds),
                loss.join(" / "),
            ];
            named(name, cells.into_iter().chain(rows.iter().map(cell)));
        }
    }
    Ok(())
}
