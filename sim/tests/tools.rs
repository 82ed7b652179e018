//! Tools that are missing, too old, fake, failing or hanging are errors, never successes.

use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::time::{Duration, Instant};

use hwgen_sim::doctor::{Health, examine, status};
use hwgen_sim::error::ToolError;
use hwgen_sim::simulator::{ReplayPlan, Simulator};
use hwgen_sim::tool::{ICARUS, ICEPACK, Invocation, TOOLS, Toolbox, VERILATOR, run};

/// What each run is given, and its dump must contain.
const NONCE: u64 = 0x0123_4567_89ab_cdef;

mod support;

const ICARUS_VERSION: &str =
    "[ \"$1\" = -V ] && echo 'Icarus Verilog version 11.0 (stable)' && exit";
const VVP_VERSION: &str =
    "[ \"$1\" = -V ] && echo 'Icarus Verilog runtime version 11.0 (stable)' && exit";

fn fake(directory: &Path, name: &str, script: &str) {
    std::fs::create_dir_all(directory).expect("a directory");
    let path = directory.join(name);
    let text = directory.join(format!("{name}.txt"));
    std::fs::write(&text, format!("#!/bin/sh\n{script}\n")).expect("written");
    // Copied by another process: what this one has open for writing, even in a thread that is just
    // starting a child, cannot be executed.
    let copied = std::process::Command::new("cp")
        .arg(&text)
        .arg(&path)
        .status();
    assert!(copied.expect("cp").success());
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).expect("executable");
}

fn toolbox(directory: &Path) -> Toolbox {
    Toolbox::with_directories(vec![directory.to_owned()]).with_trial_time(Duration::from_secs(1))
}

#[test]
fn every_tool_that_ci_needs_is_there() {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let tools = Toolbox::new(package.parent().expect("a workspace"));
    let table = examine(&tools);
    assert_eq!(table.len(), TOOLS.len());
    for name in [
        "Icarus Verilog",
        "Icarus Verilog runtime",
        "Verilator",
        "g++",
        "GNU Make",
    ] {
        let line = table.iter().find(|line| line.name == name).expect(name);
        assert_eq!(line.health, Health::Ok, "{line:?}");
        assert!(line.version.is_some() && line.path.is_some());
    }
    let json = serde_json::to_value(&table).expect("serializes");
    assert_eq!(json[0]["health"], "ok");
}

#[test]
fn a_missing_tool_is_named_with_the_command_that_installs_it() {
    let directory = tempfile::tempdir().expect("a directory");
    let error = toolbox(directory.path()).find(&VERILATOR).unwrap_err();
    assert_eq!(
        error.to_string(),
        "Verilator was not found (looked for verilator, verilator-cli)"
    );
    assert_eq!(
        error.install(),
        Some("apt-get install -y verilator g++ make")
    );
}

#[test]
fn a_tool_that_prints_no_version_is_refused() {
    let directory = tempfile::tempdir().expect("a directory");
    for (script, reason) in [
        ("exit 0", "ran, but printed no version"),
        ("echo version 12.0", "ran, but printed no version"),
        ("exit 7", "failed with exit status: 7"),
        ("sleep 60", "printed no version in 1 s"),
    ] {
        fake(directory.path(), "iverilog", script);
        let tools = toolbox(directory.path());
        let error = tools.find(&ICARUS).unwrap_err();
        assert!(matches!(error, ToolError::Missing { .. }), "{error}");
        assert!(error.to_string().contains(reason), "{error}");
        assert_eq!(status(&tools, &ICARUS).health, Health::Broken);
    }
}

#[test]
fn a_tool_without_a_version_is_known_by_how_it_is_used() {
    let directory = tempfile::tempdir().expect("a directory");
    for (script, refused) in [
        ("echo Usage: icepack [options]; exit 1", None),
        ("echo Usage: icepack [options]", None),
        ("exit 127", Some("failed with exit status: 127")),
        ("echo other", Some("ran, but did not say how it is used")),
        ("sleep 60", Some("printed no version in 1 s")),
    ] {
        fake(directory.path(), "icepack", script);
        let tools = toolbox(directory.path());
        match (tools.find(&ICEPACK), refused) {
            (Ok(found), None) => assert_eq!(found.version.to_string(), ""),
            (Err(error), Some(reason)) => assert!(error.to_string().contains(reason), "{error}"),
            (found, _) => panic!("{script}: {found:?}"),
        }
    }
}

#[test]
fn an_old_tool_is_refused_and_a_later_directory_is_searched() {
    let (old, new) = (
        tempfile::tempdir().expect("a"),
        tempfile::tempdir().expect("b"),
    );
    fake(old.path(), "verilator", "echo Verilator 4.038 2020-07-11");
    let error = toolbox(old.path()).find(&VERILATOR).unwrap_err();
    assert!(matches!(error, ToolError::TooOld { .. }), "{error}");
    assert!(
        error
            .to_string()
            .contains("4.038 is too old: 5.006 or later"),
        "{error}"
    );

    fake(
        new.path(),
        "verilator-cli",
        "echo Verilator 5.048 2026-01-01",
    );
    let both = vec![old.path().to_owned(), new.path().to_owned()];
    let found = Toolbox::with_directories(both)
        .find(&VERILATOR)
        .expect("found");
    assert_eq!(found.path, new.path().join("verilator-cli"));
    assert_eq!(found.version.to_string(), "5.048");
}

#[test]
fn a_compiler_that_does_nothing_is_an_error() {
    let directory = tempfile::tempdir().expect("a directory");
    let bin = directory.path().join("bin");
    fake(&bin, "iverilog", &format!("{ICARUS_VERSION}\nexit 0"));
    fake(&bin, "vvp", VVP_VERSION);
    let plan = support::plan(directory.path(), directory.path(), |_, text| text);
    // What an earlier run left must not be taken for the result of this one.
    std::fs::write(directory.path().join("icarus.vvp"), "stale").expect("written");
    let error = Simulator::Icarus.build(&toolbox(&bin), &plan).unwrap_err();
    assert!(matches!(error, ToolError::NoVerdict { .. }), "{error}");

    fake(
        &bin,
        "verilator",
        "[ \"$1\" = --version ] && echo Verilator 5.006",
    );
    fake(&bin, "g++", "echo 'g++ (Debian) 12.2.0'");
    fake(&bin, "make", "echo GNU Make 4.3");
    let error = Simulator::Verilator
        .build(&toolbox(&bin), &plan)
        .unwrap_err();
    assert!(matches!(error, ToolError::Failed { .. }), "{error}");
    fake(&bin, "verilator", "echo Verilator 5.006");
    let error = Simulator::Verilator
        .build(&toolbox(&bin), &plan)
        .unwrap_err();
    assert!(matches!(error, ToolError::NoVerdict { .. }), "{error}");
}

#[test]
fn a_build_that_fails_leaves_its_log_and_nothing_else() {
    let directory = tempfile::tempdir().expect("a directory");
    let (bin, work) = (directory.path().join("bin"), directory.path().join("work"));
    let script = "[ \"$1\" = --version ] && echo Verilator 5.006 && exit\npwd; exit 9";
    fake(&bin, "verilator", script);
    fake(&bin, "g++", "echo 'g++ (Debian) 12.2.0'");
    fake(&bin, "make", "echo GNU Make 4.3");
    let cache = directory.path().join("cache");
    let mut plan = support::plan(directory.path(), &cache, |_, text| text);
    plan.work_dir = work.clone();
    // What killed builds have left: an old one, and one that may still be written.
    let (old, young) = (cache.join(".building-old"), cache.join(".building-young"));
    std::fs::create_dir_all(old.join("obj")).expect("created");
    std::fs::create_dir_all(&young).expect("created");
    let hours_ago = std::time::SystemTime::now() - Duration::from_secs(7200);
    std::fs::File::open(&old)
        .and_then(|directory| directory.set_modified(hours_ago))
        .expect("aged");

    let error = Simulator::Verilator
        .build(&toolbox(&bin), &plan)
        .unwrap_err();
    let ToolError::Failed {
        last_lines, log, ..
    } = &error
    else {
        panic!("{error}");
    };
    assert_eq!(log, &work.join("verilator-build.log"));
    assert_eq!(
        &std::fs::read_to_string(log).expect("a log").trim(),
        last_lines
    );
    assert!(work.join("verilator-build.run.json").is_file());
    assert!(!Path::new(last_lines).exists(), "{last_lines} was left");
    assert!(!old.exists() && young.exists());
}

#[test]
fn a_core_that_reads_other_files_is_not_built() {
    let directory = tempfile::tempdir().expect("a directory");
    for (line, word) in [
        ("`include \"other.vh\"", "`include"),
        ("initial $readmemh(\"rom.hex\", acc_q);", "`$readmemh`"),
    ] {
        let plan = support::plan(directory.path(), directory.path(), |name, text| {
            if name == "echo_pe.v" {
                format!("{line}\n{text}")
            } else {
                text
            }
        });
        for simulator in Simulator::ALL {
            let error = simulator
                .build(&toolbox(directory.path()), &plan)
                .unwrap_err();
            let path = directory.path().join("echo_pe.v");
            let expected = format!(
                "{}:1: expected Verilog that simulators and synthesis read alike, found {word}",
                path.display()
            );
            assert_eq!(error.to_string(), expected);
        }
    }
}

#[test]
fn a_simulator_that_does_nothing_or_lies_or_hangs_is_an_error() {
    let directory = tempfile::tempdir().expect("a directory");
    let bin = directory.path().join("bin");
    let stimulus = directory.path().join("stimulus.hex");
    std::fs::write(&stimulus, "00000\n").expect("written");
    let dump = directory.path().join("icarus.fst");
    let replay = |script: &str| {
        fake(
            &bin,
            "iverilog",
            &format!("{ICARUS_VERSION}\necho design > icarus.vvp"),
        );
        fake(&bin, "vvp", &format!("{VVP_VERSION}\n{script}"));
        let plan = support::plan(directory.path(), directory.path(), |_, text| text);
        let built = Simulator::Icarus
            .build(&toolbox(&bin), &plan)
            .expect("builds");
        // A dump of an earlier run.
        std::fs::write(&dump, "stale").expect("written");
        built.replay(&ReplayPlan {
            stimulus: stimulus.clone(),
            clocks: 1,
            nonce: NONCE,
            dump: dump.clone(),
            timeout: Duration::from_secs(1),
        })
    };

    let error = replay("exit 0").unwrap_err();
    assert!(
        error
            .to_string()
            .contains("without `hwgen: replayed 1 clocks`"),
        "{error}"
    );
    let error = replay("echo 'hwgen: replayed 1 clocks'").unwrap_err();
    assert!(error.to_string().contains("without a dump"), "{error}");
    assert!(!dump.exists());
    let error = replay("echo 'hwgen: replayed 1 clocks'; : > icarus.fst").unwrap_err();
    assert!(error.to_string().contains("without a dump"), "{error}");
    let error = replay("echo boom >&2; exit 3").unwrap_err();
    let ToolError::Failed {
        status,
        last_lines,
        log,
        ..
    } = error
    else {
        panic!("{error}");
    };
    assert_eq!(
        (status.as_str(), last_lines.as_str()),
        ("exit status: 3", "boom")
    );
    assert!(log.is_file());
    let error = replay("sleep 60").unwrap_err();
    assert!(matches!(error, ToolError::TimedOut { .. }), "{error}");
}

#[test]
fn children_are_killed_with_the_tool() {
    let directory = tempfile::tempdir().expect("a directory");
    let mark = directory.path().join("mark");
    fake(
        directory.path(),
        "tool",
        "(sleep 2; echo late > mark) &\nsleep 60",
    );
    let start = Instant::now();
    let error = run(&Invocation {
        tool: "tool".to_owned(),
        version: "1".to_owned(),
        program: directory.path().join("tool"),
        arguments: Vec::new(),
        directory: directory.path().to_owned(),
        label: "tool".to_owned(),
        timeout: Duration::from_millis(500),
    })
    .unwrap_err();
    assert!(matches!(error, ToolError::TimedOut { .. }), "{error}");
    assert!(start.elapsed() < Duration::from_secs(2));
    std::thread::sleep(Duration::from_millis(2_500));
    assert!(!mark.exists(), "a child lived on");
    let record = std::fs::read_to_string(directory.path().join("tool.run.json")).expect("a record");
    assert!(record.contains("killed after 0.5 s"), "{record}");
}
