//! Landmarks in a plane, and one out of it.

use hwgen_pose::evaluate::Method;
use hwgen_pose::scene::{Scene, SceneDraft};

use crate::bench::{Result, cell, errors, head, landing, method, named, recipe, train};

pub fn study() -> Result<()> {
    let landing = landing()?;
    println!(
        "The canonical scene with the mast light at a depth behind the frame's plane; 1 px of"
    );
    println!("noise, 64 neurons; mean relative error of position / orientation, %.");
    println!("What stands out of the plane decides what can be known of the attitude.");
    println!("An estimate below the Cramér-Rao bound knows the pose box, the bound does not.\n");
    let methods = [Method::Crb, Method::Bayes, Method::Ml, Method::Epnp];
    let columns = [
        "depth, m",
        "bound",
        "posterior mean",
        "maximum likelihood",
        "EPnP",
        "network",
    ];
    head(&columns.map(str::to_string));
    for depth_m in [0.0, 0.5, 1.0, 2.0, 4.0, 8.0] {
        let mut landmarks_m = landing.landmarks_m().to_vec();
        landmarks_m[4].x = depth_m;
        let scene = Scene::new(SceneDraft {
            landmarks_m,
            ..landing.draft().clone()
        })?;
        let mut cells = Vec::new();
        for wanted in methods {
            cells.push(cell(&method(&scene, wanted, &[1.0])?[0]));
        }
        let trained = train(&scene, recipe(&[64]))?;
        cells.push(cell(&errors(&scene, &trained.net, &[1.0])?[0]));
        named(format!("{depth_m}"), cells);
    }
    Ok(())
}
