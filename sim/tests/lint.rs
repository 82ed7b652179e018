//! The benches and the core of the tests are free of warnings.

use std::path::{Path, PathBuf};
use std::time::Duration;

use hwgen_sim::tool::{ICARUS, Invocation, Tool, Toolbox, VERILATOR, run};

mod support;

fn assert_silent(tool: &Tool, flags: &[&str], files: &[PathBuf], directory: &Path) {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let tools = Toolbox::new(package.parent().expect("a workspace"));
    let found = tools.find(tool).expect("installed");
    let flags = flags.iter().map(|f| (*f).into());
    let run = run(&Invocation {
        tool: found.name.clone(),
        version: found.version.to_string(),
        program: found.path,
        arguments: flags.chain(files.iter().map(Into::into)).collect(),
        directory: directory.to_owned(),
        label: "lint".to_owned(),
        timeout: Duration::from_secs(60),
    })
    .expect("no warning is fatal");
    assert_eq!(run.output, "");
}

#[test]
fn the_benches_have_no_lint() {
    let directory = tempfile::tempdir().expect("a directory");
    let plan = support::plan(directory.path(), directory.path(), |_, text| text);
    let mut files = plan.sources.clone();
    files.extend([plan.bench, plan.bench_icarus].map(|bench| {
        let path = directory.path().join(bench.name);
        std::fs::write(&path, bench.text).expect("written");
        path
    }));
    // The time scale of the option is that of all modules that state none.
    assert_silent(
        &VERILATOR,
        &[
            "--lint-only",
            "-Wall",
            "--timing",
            "--timescale",
            "1ns/1ps",
            "--top-module",
            "echo_tb_icarus",
        ],
        &files,
        directory.path(),
    );
    // The cells that are synthesised carry no time scale, the benches do: no other waiver.
    assert_silent(
        &ICARUS,
        &[
            "-g2005",
            "-Wall",
            "-Wno-timescale",
            "-s",
            "echo_tb_icarus",
            "-o",
            "lint.vvp",
        ],
        &files,
        directory.path(),
    );
}
