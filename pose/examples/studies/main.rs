//! Studies of the landing problem: what errors depend on.
//!
//! `cargo run --release --example studies -p hwgen-pose -- NAME` trains and measures what a study
//! needs and prints it as Markdown; `docs/studies/NAME.md` holds what came of it. Every number
//! but the seconds is the same each time.

mod bench;
mod definitions;
mod faults;
mod landmarks;
mod noise;
mod optimizers;
mod plane;
mod size;

type Study = fn() -> Result<(), Box<dyn std::error::Error>>;

const STUDIES: [(&str, &str, Study); 7] = [
    (
        "definitions",
        "What may the published table mean by relative error?",
        definitions::study,
    ),
    (
        "faults",
        "Missing, swapped and outlying landmarks",
        faults::study,
    ),
    (
        "landmarks",
        "Number of landmarks, 4 to 32: error and cost",
        landmarks::study,
    ),
    (
        "noise",
        "Noise in training against noise in use",
        noise::study,
    ),
    (
        "optimizers",
        "RPROP and Levenberg-Marquardt side by side",
        optimizers::study,
    ),
    (
        "plane",
        "Landmarks in a plane, and one out of it",
        plane::study,
    ),
    ("size", "Number of hidden neurons", size::study),
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let wanted = std::env::args().nth(1);
    let found = STUDIES
        .iter()
        .find(|(name, ..)| wanted.as_deref() == Some(name));
    let Some((name, title, study)) = found else {
        eprintln!("the name of a study expected:");
        for (name, title, _) in STUDIES {
            eprintln!("  {name:12} {title}");
        }
        std::process::exit(2);
    };
    println!("# {title}\n");
    println!("`cargo run --release --example studies -p hwgen-pose -- {name}`\n");
    study()
}
