//! A recording, Icarus and Verilator on a hand-written core: equal, and different where it must be.
//!
//! A missing simulator fails these tests.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Duration;

use hwgen_sim::compare::{Comparison, compare};
use hwgen_sim::error::ToolError;
use hwgen_sim::simulator::{BuildPlan, Built, Purpose, ReplayPlan, Simulator, Text};
use hwgen_sim::tool::Toolbox;
use hwgen_sim::trace::{Dump, RtlValue};

/// What each run is given, and its dump must contain.
const NONCE: u64 = 0x0123_4567_89ab_cdef;

#[path = "support/echo.rs"]
mod echo;
mod support;

const CLOCKS: usize = 200;

/// A directory that compilers, makefiles and dumps may stumble over.
const ODD: &str = "a b'c\"d $e #f";

fn toolbox() -> Toolbox {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    Toolbox::new(package.parent().expect("a workspace"))
}

fn build(simulator: Simulator, plan: &BuildPlan) -> Built {
    simulator.build(&toolbox(), plan).expect("builds")
}

fn simulate(built: &Built, directory: &Path, dump: &str, first_clock: usize) -> Comparison {
    let pins = echo::pins(CLOCKS);
    let stimulus = directory.join("stimulus.hex");
    std::fs::write(&stimulus, echo::stimulus(&pins)).expect("written");
    let replay = built
        .replay(&ReplayPlan {
            stimulus,
            clocks: CLOCKS,
            nonce: NONCE,
            dump: directory.join(dump),
            timeout: Duration::from_secs(60),
        })
        .expect("replays");
    assert_eq!(replay.clocks, CLOCKS);
    let mut dump = Dump::open(&replay.dump).expect("a dump");
    compare(&echo::record(&pins), &mut dump, first_clock).expect("comparable")
}

fn assert_equal(comparison: &Comparison) {
    assert_eq!(comparison.first_difference, None);
    assert_eq!(comparison.registers, 7);
    assert_eq!(comparison.edges, CLOCKS);
    assert_eq!(comparison.values_compared, 26 * 200);
}

/// Lane 13 gets a wrong weight, in the simulators only.
fn wrong_weight(name: &str, text: String) -> String {
    let right = "(i[23:0] + 24'd1)";
    if name == "echo_sums.v" {
        assert!(text.contains(right));
        text.replace(right, "((i == 13) ? 24'd13 : i[23:0] + 24'd1)")
    } else {
        text
    }
}

fn assert_wrong_weight(comparison: &Comparison) {
    let pins = echo::pins(CLOCKS);
    let record = echo::record(&pins);
    // The first word that is taken after reset and is not 0.
    let clock = (0..CLOCKS)
        .find(|c| record.values(*c, 3)[13] != 0)
        .expect("a word");
    let model = record.values(clock, 3)[13];
    let found = comparison.first_difference.as_ref().expect("a difference");
    assert_eq!(
        (found.clock, found.path.as_str(), found.lane),
        (clock, "u_sums.acc_q", 13)
    );
    assert_eq!(found.model, model);
    assert_eq!(found.rtl, RtlValue::Known(model / 14 * 13));
}

#[test]
fn icarus_equals_the_recording_in_both_formats() {
    let directory = tempfile::tempdir().expect("a directory");
    let place = directory.path().join(ODD);
    std::fs::create_dir_all(&place).expect("a directory");
    let plan = support::plan(&place, &place, |_, text| text);
    let built = build(Simulator::Icarus, &plan);
    for dump in ["icarus.vcd", "icarus.fst"] {
        assert_equal(&simulate(&built, &place, dump, 0));
    }
    for file in ["icarus-build", "icarus"] {
        let record = place.join(format!("{file}.run.json"));
        let text = std::fs::read_to_string(record).expect("a record of the run");
        assert!(text.contains("\"status\": \"exit status: 0\""), "{text}");
        assert!(place.join(format!("{file}.log")).is_file());
    }
}

#[test]
fn icarus_differs_at_the_wrong_weight() {
    let directory = tempfile::tempdir().expect("a directory");
    let plan = support::plan(directory.path(), directory.path(), wrong_weight);
    let built = build(Simulator::Icarus, &plan);
    for dump in ["icarus.vcd", "icarus.fst"] {
        assert_wrong_weight(&simulate(&built, directory.path(), dump, 0));
    }
}

#[test]
fn an_unknown_bit_is_a_difference() {
    let directory = tempfile::tempdir().expect("a directory");
    let plan = support::plan(directory.path(), directory.path(), |name, text| {
        if name == "echo_pe.v" {
            // A register that nothing sets, a wire that nothing drives.
            text.replace(
                "acc_q <= 8'sd0;",
                "acc_q <= {4'b0001, never_q, 1'b0, open, 1'b1};",
            )
            .replace(
                "  always @(posedge",
                "  reg never_q;\n  wire open;\n\n  always @(posedge",
            )
        } else {
            text
        }
    });
    let built = build(Simulator::Icarus, &plan);
    for dump in ["icarus.vcd", "icarus.fst"] {
        let comparison = simulate(&built, directory.path(), dump, 0);
        let found = comparison.first_difference.expect("a difference");
        assert_eq!(found.clock, 0);
        assert_eq!(found.path, "u_sums.g_pe[0].u_pe.acc_q");
        assert_eq!(found.rtl, RtlValue::Unknown("0001x0z1".to_owned()));
    }
}

#[test]
fn verilator_equals_the_recording_and_differs_at_the_wrong_weight() {
    let directory = tempfile::tempdir().expect("a directory");
    let place = directory.path().join(ODD);
    let [cache, right, other, wrong] =
        ["cache", "right", "other", "wrong"].map(|name| place.join(name));
    for directory in [&right, &other, &wrong] {
        std::fs::create_dir_all(directory).expect("a directory");
    }
    let right_plan = support::plan(&right, &cache, |_, text| text);
    let other_plan = support::plan(&other, &cache, |_, text| text);
    let wrong_plan = support::plan(&wrong, &cache, wrong_weight);

    // Two builders of the same design at once, in one cache.
    let (first, second) = std::thread::scope(|scope| {
        let first = scope.spawn(|| build(Simulator::Verilator, &right_plan));
        let second = build(Simulator::Verilator, &other_plan);
        (first.join().expect("built"), second)
    });
    assert_equal(&simulate(&first, &right, "verilator.vcd", 0));
    assert_equal(&simulate(&second, &other, "verilator.vcd", 0));
    let again = build(Simulator::Verilator, &right_plan);
    assert!(again.cached());
    assert!(right.join("verilator-build.log").is_file());
    let left: Vec<_> = std::fs::read_dir(&cache)
        .expect("a cache")
        .map(|entry| entry.expect("an entry").file_name())
        .collect();
    assert_eq!(left.len(), 1, "{left:?}");

    let different = build(Simulator::Verilator, &wrong_plan);
    assert!(!different.cached());
    assert_wrong_weight(&simulate(&different, &wrong, "verilator.vcd", 0));
}

/// What is in the cache under a design's name is run only if it was built under this name.
#[test]
fn a_program_of_another_core_is_not_believed() {
    let directory = tempfile::tempdir().expect("a directory");
    let [cache, right, wrong] = ["cache", "right", "wrong"].map(|name| directory.path().join(name));
    for directory in [&right, &wrong] {
        std::fs::create_dir_all(directory).expect("a directory");
    }
    let right_plan = support::plan(&right, &cache, |_, text| text);
    let wrong_plan = support::plan(&wrong, &cache, wrong_weight);
    let entries = || -> BTreeSet<PathBuf> {
        let entries = std::fs::read_dir(&cache).expect("a cache");
        entries.map(|e| e.expect("an entry").path()).collect()
    };
    build(Simulator::Verilator, &right_plan);
    let of_right = entries();
    build(Simulator::Verilator, &wrong_plan);
    let all = entries();
    let good = of_right.first().expect("an entry");
    let bad = all.difference(&of_right).next().expect("an entry");
    // The program alone, then with all that lies beside it.
    for files in [
        &["Vtb"][..],
        &["Vtb", "Vtb.sha256", "verilator-build.run.json"],
    ] {
        for file in files {
            std::fs::copy(good.join(file), bad.join(file)).expect(file);
        }
        let built = build(Simulator::Verilator, &wrong_plan);
        assert!(!built.cached());
        assert_wrong_weight(&simulate(&built, &wrong, "verilator.vcd", 0));
    }
    assert!(build(Simulator::Verilator, &wrong_plan).cached());
}

/// The emitted bench with a digest of the core's outputs.
fn with_digest(bench: &mut Text) {
    let text = bench.text.clone();
    let edits = [
        (
            "  // The first line has",
            "  reg [31:0] digest_q = 0;
  always @(posedge clk_i)
    if (m_axis_tvalid) digest_q <= {digest_q[30:0], digest_q[31]} ^ {8'b0, m_axis_tdata};
  // The first line has",
        ),
        (
            "$display(\"hwgen: replayed %0d clocks\", clocks_q + 1);",
            "$display(\"hwgen: replayed %0d clocks\", clocks_q + 1);
        $display(\"hwgen: digest %h\", digest_q);",
        ),
    ];
    let text = edits.iter().fold(text, |text, (find, replace)| {
        assert_eq!(text.matches(find).count(), 1, "{find}");
        text.replace(find, replace)
    });
    bench.text = text;
}

#[test]
fn verilator_measures_its_speed() {
    const CLOCKS: usize = 5_000;
    let directory = tempfile::tempdir().expect("a directory");
    let mut plan = support::plan(directory.path(), directory.path(), |_, text| text);
    plan.purpose = Purpose::Speed;
    let stimulus = directory.path().join("stimulus.hex");
    std::fs::write(&stimulus, echo::stimulus(&echo::pins(CLOCKS))).expect("written");
    let limit = Duration::from_secs(60);

    // The emitted bench looks at no output, so there is nothing behind it to be measured.
    let built = build(Simulator::Verilator, &plan);
    let error = built
        .measure_speed(&stimulus, CLOCKS, directory.path(), limit)
        .unwrap_err();
    let text = error.to_string();
    assert!(text.contains("without a digest of the outputs"), "{text}");

    with_digest(&mut plan.bench);
    let [verilator, icarus] = [Simulator::Verilator, Simulator::Icarus].map(|simulator| {
        build(simulator, &plan)
            .measure_speed(&stimulus, CLOCKS, directory.path(), limit)
            .expect("measured")
    });
    assert_eq!(verilator.clocks, CLOCKS);
    assert!(verilator.seconds > 0.0);
    assert_eq!(verilator.digest, icarus.digest);
    // A build without a dump says so, and an absent dump is no success.
    let error = built
        .replay(&ReplayPlan {
            stimulus,
            clocks: CLOCKS,
            nonce: NONCE,
            dump: directory.path().join("none.vcd"),
            timeout: limit,
        })
        .unwrap_err();
    assert!(matches!(error, ToolError::Failed { .. }), "{error}");
}

#[test]
fn a_stimulus_that_is_not_what_was_announced_is_no_success() {
    let directory = tempfile::tempdir().expect("a directory");
    let plan = support::plan(directory.path(), directory.path(), |_, text| text);
    let built = build(Simulator::Icarus, &plan);
    let stimulus = directory.path().join("stimulus.hex");
    let whole = echo::stimulus(&echo::pins(10));
    let cases = [
        ("", "has no first line"),
        (&whole[..whole.len() - 6], "hwgen: replayed 9 clocks"),
        (&whole.replacen('8', "q", 1), "is no hexadecimal word"),
    ];
    for (text, says) in cases {
        std::fs::write(&stimulus, text).expect("written");
        let error = built
            .replay(&ReplayPlan {
                stimulus: stimulus.clone(),
                clocks: 10,
                nonce: NONCE,
                dump: directory.path().join("icarus.fst"),
                timeout: Duration::from_secs(60),
            })
            .unwrap_err();
        let ToolError::NoVerdict { last_lines, .. } = &error else {
            panic!("{error}");
        };
        assert!(last_lines.contains(says), "{error}");
    }
}
