//! Emitted cores against the cycle model and the untimed values, in the simulators.

#[path = "support/random.rs"]
mod random;
mod support;

use std::collections::BTreeMap;

use hwgen_sim::simulator::Simulator;
use hwgen_sim::stimulus::Effort;
use hwgen_spec::design::Design;
use hwgen_spec::options::{Budget, Options};
use hwgen_spec::weights;
use random::random_design;
use support::{Check, assert_verified, axes, check, emit, in_parallel};

/// Seeds of the random designs that Icarus checks: they have all of the axes.
const DESIGNS: std::ops::Range<u64> = 16..64;
/// Of these, one in so many with all that a verdict takes.
const FULLY: u64 = 7;

/// Random frames of each check, spread over the four flows.
const RANDOM: usize = 12;

/// Of these, how many Verilator checks as well.
const DESIGNS_IN_VERILATOR: u64 = 3;

/// Axes of the matrix, and how many of the designs that Icarus checks have them at least.
///
/// A design has many of them, one here, another there: seeds draw sizes from 1 to 17, 1 to 3
/// networks behind 0 to 2 shared layers, widths, intervals from 1 to 200, activations and formats.
const AXES: &[(&str, usize)] = &[
    ("tanh", 20),
    ("sigmoid", 20),
    ("relu", 20),
    ("linear", 20),
    ("replay feed", 20),
    ("direct feed", 20),
    ("hold feed", 10),
    ("sums by adders", 10),
    ("adders in levels", 8),
    ("sums of nothing", 3),
    ("activations' multipliers in logic", 3),
    ("words by way of a copy", 3),
    ("segments in several tables", 1),
    ("neurons that take turns", 5),
    ("accumulators", 20),
    ("no accumulators", 20),
    ("drain", 15),
    ("beats of padding", 5),
    ("odd adder trees", 15),
    ("three levels of a tree", 15),
    ("several networks", 20),
    ("shared layers", 20),
    ("no shared layer", 15),
    ("1-wide layers", 20),
    ("prime sizes", 20),
    ("PE does not divide the outputs", 15),
    ("SIMD does not divide the inputs", 15),
    ("shifts per neuron", 15),
    ("product shifts", 15),
    ("the device's multipliers", 4),
    ("some multipliers", 3),
    ("interval 1", 3),
    ("a word a beat", 15),
    ("several words a beat", 15),
    ("lanes without a word", 15),
    ("fixed weights", 10),
    ("fixed biases", 10),
    ("fixed words", 8),
    ("shared_in", 5),
    ("_out", 10),
    ("multipliers in blocks", 20),
    ("multipliers left to synthesis", 15),
    ("multipliers that show their result alone", 10),
    ("no copies of operands", 10),
    ("registered tables of a ROM", 1),
];

#[test]
fn the_matrix_covers_its_axes() {
    let mut found: BTreeMap<&str, usize> = BTreeMap::new();
    for seed in DESIGNS {
        let (net, options) = random_design(seed);
        let design = Design::new(&net, &options).expect("a legal design");
        for axis in axes(&net, &design) {
            *found.entry(axis).or_default() += 1;
        }
    }
    for (axis, least) in AXES {
        let found = found.get(axis).copied().unwrap_or(0);
        assert!(found >= *least, "{axis}: {found} designs, {least} wanted");
    }
}

#[test]
fn random_designs_are_equal_in_icarus() {
    let directory = tempfile::tempdir().expect("a directory");
    // Several at a time: while one is read, modelled or compiled, another one simulates.
    let seeds: Vec<u64> = DESIGNS.collect();
    let outcomes = in_parallel(&seeds, |seed| {
        let (net, options) = random_design(*seed);
        let bundle = emit(&net, &options, directory.path());
        let plan = Check {
            random: RANDOM,
            seed: *seed,
            simulators: &[Simulator::Icarus],
            effort: match seed % FULLY {
                3 => Effort::Usual,
                _ => Effort::Quick,
            },
        };
        match check(&bundle, &plan) {
            Ok(report) if report.verified => None,
            Ok(report) => Some(format!("{seed}: {report:#?}")),
            Err(error) => Some(format!("{seed}: {error} {error:?}")),
        }
    });
    let failures: Vec<String> = outcomes.into_iter().flatten().collect();
    assert!(
        failures.is_empty(),
        "{} failed: {}",
        failures.len(),
        failures.join("\n")
    );
}

#[test]
fn some_random_designs_are_equal_in_verilator() {
    let directory = tempfile::tempdir().expect("a directory");
    for seed in 0..DESIGNS_IN_VERILATOR {
        let (net, options) = random_design(1000 + seed);
        let bundle = emit(&net, &options, directory.path());
        let plan = Check {
            random: RANDOM,
            seed,
            simulators: &Simulator::ALL,
            effort: Effort::Usual,
        };
        let report = check(&bundle, &plan).expect("the simulators run");
        assert_verified(&report, &format!("design {}", 1000 + seed));
    }
}

/// 600 words of weights stand in two memories, one of 512 words and one of 256.
#[test]
fn a_rom_of_several_memories_is_equal_in_both_simulators() {
    let directory = tempfile::tempdir().expect("a directory");
    let weight = |i: usize| format!("{:.3}", (i * 37 % 101) as f64 / 50.5 - 1.0);
    let row = |n: usize, inputs: usize| {
        let weights: Vec<String> = (0..inputs).map(|i| weight(n * inputs + i)).collect();
        format!("[{}]", weights.join(","))
    };
    let rows = |outputs: usize, inputs: usize| {
        let rows: Vec<String> = (0..outputs).map(|n| row(n, inputs)).collect();
        rows.join(",")
    };
    let text = format!(
        r#"{{"format": "hwgen-weights/1", "name": "deep",
          "inputs": {{"min": {0}, "max": {1}}},
          "networks": [{{"name": "net", "layers": [
            {{"activation": "tanh", "weights": [{2}]}},
            {{"activation": "linear", "weights": [{3}]}}]}}]}}"#,
        format_args!("[{}]", ["-1"; 10].join(",")),
        format_args!("[{}]", ["1"; 10].join(",")),
        rows(60, 10),
        rows(3, 60),
    );
    let net = weights::read(text.as_bytes()).expect("readable");
    let options = Options {
        device: Some("ice40-up5k".into()),
        budget: Budget::Interval(600),
        ..Options::default()
    };
    let design = Design::new(&net, &options).expect("a legal design");
    assert!(axes(&net, &design).contains("several memories of a ROM"));
    let bundle = emit(&net, &options, directory.path());
    let plan = Check {
        random: 4,
        seed: 1,
        simulators: &Simulator::ALL,
        effort: Effort::Quick,
    };
    let report = check(&bundle, &plan).expect("the simulators run");
    assert_verified(&report, "deep");
}

#[test]
fn the_landing_design_is_equal_in_icarus() {
    let directory = tempfile::tempdir().expect("a directory");
    let net = weights::read(include_bytes!("../designs/landing/weights.json")).expect("readable");
    let bundle = emit(&net, &Options::default(), directory.path());
    let plan = Check {
        random: 8,
        seed: 1,
        simulators: &[Simulator::Icarus],
        effort: Effort::Quick,
    };
    let start = std::time::Instant::now();
    let report = check(&bundle, &plan).expect("Icarus runs");
    eprintln!("{:?} {report:#?}", start.elapsed());
    assert_verified(&report, "landing");
}
