//! Mutants: faults put into emitted Verilog, each of which `verify` must find.
//!
//! A check that can't fail proves nothing. Every row of the table is one edit of one file of a
//! bundle; the control is the same bundle without an edit.

mod blind;
mod far;
mod fixture;
mod places;
mod short;
#[path = "../support/mod.rs"]
mod support;
mod table;

use std::fs;
use std::path::{Path, PathBuf};

use hwgen_gen::Source;
use hwgen_sim::simulator::Simulator;
use hwgen_sim::stimulus::Effort;
use hwgen_spec::design::Design;

use fixture::fixture;
use support::{Check, assert_verified, axes, check, check_source, emit, in_parallel};
use table::{MUTANTS, Mutant};

/// Random frames of each check.
const RANDOM: usize = 12;
const SEED: u64 = 1;

const ICARUS: Check<'static> = Check {
    random: RANDOM,
    seed: SEED,
    simulators: &[Simulator::Icarus],
    effort: Effort::Quick,
};

/// The bundle of the fixture in a directory of its own.
fn bundle(directory: &Path, name: &str) -> (PathBuf, Source) {
    let (net, options) = fixture();
    let bundle = emit(&net, &options, &directory.join(name));
    let source = Source::read(&bundle).expect("a bundle as it was emitted");
    (bundle, source)
}

/// Puts `replace` in the place of the only `find`.
fn edit(path: &Path, find: &str, replace: &str) {
    let text = fs::read_to_string(path).expect("an emitted file");
    assert_eq!(text.matches(find).count(), 1, "{}: {find}", path.display());
    fs::write(path, text.replace(find, replace)).expect("written");
}

/// A file of a bundle; that of a cell is called as in `rtl/lib`, without the prefix.
fn emitted(bundle: &Path, source: &Source, file: &str) -> PathBuf {
    bundle.join(match file.strip_prefix("rtl/hwg_") {
        Some(cell) => format!("rtl/{}__hwg_{cell}", source.design.prefix()),
        None => file.to_owned(),
    })
}

#[test]
fn the_fixture_has_what_mutants_need() {
    let (net, options) = fixture();
    let design = Design::new(&net, &options).expect("legal");
    let axes = axes(&net, &design);
    for axis in [
        "tanh",
        "sigmoid",
        "relu",
        "linear",
        "shared layers",
        "several networks",
        "replay feed",
        "direct feed",
        "hold feed",
        "neurons that take turns",
        "accumulators",
        "no accumulators",
        "drain",
        "odd adder trees",
        "three levels of a tree",
        "shifts per neuron",
        "product shifts",
        "several words a beat",
        "lanes without a word",
        "PE does not divide the outputs",
        "SIMD does not divide the inputs",
        "fixed weights",
        "fixed biases",
        "fixed words",
        "_out",
    ] {
        assert!(
            axes.contains(axis),
            "{axis}: {axes:?} {:#?}",
            design.perceptron()
        );
    }
}

#[test]
fn the_bundle_without_an_edit_is_verified() {
    let directory = tempfile::tempdir().expect("a directory");
    let (bundle, _) = bundle(directory.path(), "control");
    let report = check(&bundle, &ICARUS).expect("Icarus runs");
    assert_verified(&report, "control");
    // Saturation is reached, and so is the absence of it.
    assert!(report.frames_saturated > 0 && report.frames_saturated < report.runs[0].frames);
}

#[test]
fn every_mutant_is_found() {
    hunt(MUTANTS, bundle);
}

/// Checks a bundle with each of the faults, of which none may go unseen.
fn hunt(mutants: &[Mutant], bundle: fn(&Path, &str) -> (PathBuf, Source)) {
    hunt_with(&ICARUS, mutants, bundle);
}

fn hunt_with(how: &Check<'_>, mutants: &[Mutant], bundle: fn(&Path, &str) -> (PathBuf, Source)) {
    let directory = tempfile::tempdir().expect("a directory");
    let outcomes = in_parallel(mutants, |mutant| {
        let place = mutant.name.replace(|c: char| !c.is_alphanumeric(), "_");
        let (bundle, source) = bundle(directory.path(), &place);
        edit(
            &emitted(&bundle, &source, mutant.file),
            mutant.find,
            mutant.replace,
        );
        let report = match check_source(&bundle, &source, how) {
            Ok(report) => report,
            Err(error) => return Some(format!("{}: {error} {error:?}", mutant.name)),
        };
        let found = report.first_difference;
        match found {
            Some(found) if !report.verified && found.signal == mutant.signal => None,
            Some(found) => Some(format!(
                "{}: found at {} (cycle {} of {}), not at {}",
                mutant.name, found.signal, found.cycle, found.segment, mutant.signal
            )),
            None => Some(format!("{}: survived", mutant.name)),
        }
    });
    let failures: Vec<String> = outcomes.into_iter().flatten().collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
