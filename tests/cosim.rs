//! Emitted cores against the cycle model and the untimed values, in the simulators.

mod support;

use hwgen_sim::simulator::Simulator;
use hwgen_spec::options::Options;
use hwgen_spec::weights;
use support::{Check, assert_verified, check, emit, random_design};

/// Random designs that Icarus checks; the seeds are their names.
const DESIGNS: u64 = 64;

/// Of these, how many Verilator checks as well.
const DESIGNS_IN_VERILATOR: u64 = 3;

#[test]
fn random_designs_are_equal_in_icarus() {
    let directory = tempfile::tempdir().expect("a directory");
    let failures: Vec<String> = (0..DESIGNS)
        .filter_map(|seed| {
            let (net, options) = random_design(seed);
            let bundle = emit(&net, &options, directory.path());
            let plan = Check {
                random: 12,
                seed,
                simulators: &[Simulator::Icarus],
            };
            match check(&bundle, &plan) {
                Ok(report) if report.verified => None,
                Ok(report) => Some(format!("{seed}: {report:#?}")),
                Err(error) => Some(format!("{seed}: {error} {error:?}")),
            }
        })
        .collect();
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
            random: 12,
            seed,
            simulators: &Simulator::ALL,
        };
        let report = check(&bundle, &plan).expect("the simulators run");
        assert_verified(&report, &format!("design {}", 1000 + seed));
    }
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
    };
    let start = std::time::Instant::now();
    let report = check(&bundle, &plan).expect("Icarus runs");
    eprintln!("{:?} {report:#?}", start.elapsed());
    assert_verified(&report, "landing");
}
