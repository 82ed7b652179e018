//! Number of hidden neurons, in one layer and in two.

use crate::bench::{Result, cell, errors, head, landing, named, recipe, train};

const LEVELS_PX: [f64; 4] = [0.0, 0.1, 1.0, 3.0];

pub fn study() -> Result<()> {
    let scene = landing()?;
    println!("Canonical scene; mean relative error of position / orientation, %.");
    println!("Multiplications are those of a frame: the shared layer and both networks.\n");
    let columns = [
        "neurons",
        "multiplications",
        "0 px",
        "0.1 px",
        "1 px",
        "3 px",
    ];
    head(&columns.map(str::to_string));
    let sizes: [&[usize]; 10] = [
        &[4],
        &[8],
        &[16],
        &[32],
        &[64],
        &[128],
        &[8, 8],
        &[16, 8],
        &[16, 16],
        &[24, 24],
    ];
    for hidden in sizes {
        let trained = train(&scene, recipe(hidden))?;
        let cost = trained.net.macs().to_string();
        let cells = errors(&scene, &trained.net, &LEVELS_PX)?;
        named(
            hidden
                .iter()
                .map(usize::to_string)
                .collect::<Vec<_>>()
                .join(" + "),
            std::iter::once(cost).chain(cells.iter().map(cell)),
        );
    }
    println!("\nAll with the same 20,000 samples and 40 epochs.");
    println!("More neurons and samples: `designs/landing/README.md`.");
    Ok(())
}
