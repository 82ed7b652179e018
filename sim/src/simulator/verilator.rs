//! Verilator: Verilog to C++, `make` and `g++` to a program, which is kept for the next time.

use std::ffi::OsString;
use std::path::Path;

use sha2::{Digest, Sha256};

use super::{BuildPlan, Built, Purpose, Simulator, absolute};
use crate::error::ToolError;
use crate::tool::run::io;
use crate::tool::{CXX, FoundTool, Invocation, MAKE, Toolbox, VERILATOR, run};

const PROGRAM: &str = "Vtb";
const LABEL: &str = "verilator-build";

pub(super) fn version(tools: &Toolbox) -> Result<String, ToolError> {
    tools.find(&MAKE)?;
    tools.find(&CXX)?;
    Ok(tools.find(&VERILATOR)?.version.to_string())
}

pub(super) fn build(tools: &Toolbox, plan: &BuildPlan) -> Result<Built, ToolError> {
    tools.find(&MAKE)?;
    let compiler = tools.find(&CXX)?;
    let verilator = tools.find(&VERILATOR)?;
    let cache = std::path::absolute(&plan.cache_dir).map_err(io(&plan.cache_dir))?;
    std::fs::create_dir_all(&cache).map_err(io(&cache))?;
    let entry = cache.join(key(plan, &verilator, &compiler)?);

    let cached = entry.join(PROGRAM).is_file();
    if !cached {
        // Aside, and renamed when it is whole: whoever else builds the same never sees half of it.
        let aside = tempfile::Builder::new()
            .prefix(".building-")
            .tempdir_in(&cache)
            .map_err(io(&cache))?;
        compile(plan, &verilator, aside.path())?;
        // What has no program is no build: left by someone who meddled with the cache.
        if entry.is_dir() && !entry.join(PROGRAM).is_file() {
            std::fs::remove_dir_all(&entry).map_err(io(&entry))?;
        }
        match std::fs::rename(aside.path(), &entry) {
            // Renamed away, so there is nothing left to delete.
            Ok(()) => drop(aside.keep()),
            // Another was first; its build is as good.
            Err(_) if entry.join(PROGRAM).is_file() => {}
            Err(error) => return Err(io(&entry)(error)),
        }
    }
    for extension in ["log", "run.json"] {
        let name = format!("{LABEL}.{extension}");
        let (from, to) = (entry.join(&name), plan.work_dir.join(&name));
        std::fs::copy(&from, &to).map_err(io(&from))?;
    }
    Ok(Built {
        simulator: Simulator::Verilator,
        version: verilator.version.to_string(),
        program: entry.join(PROGRAM),
        image: None,
        cached,
    })
}

fn compile(plan: &BuildPlan, verilator: &FoundTool, directory: &Path) -> Result<(), ToolError> {
    let mut arguments: Vec<OsString> = flags(plan).into_iter().map(OsString::from).collect();
    let jobs = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    arguments.extend(["-j".to_owned(), jobs.to_string()].map(OsString::from));
    arguments.extend(["-Mdir", "obj"].map(OsString::from));
    arguments.extend(absolute(std::slice::from_ref(&plan.main_cpp))?);
    arguments.extend(absolute(&plan.sources)?);
    arguments.extend(absolute(std::slice::from_ref(&plan.bench))?);
    let run = run(&Invocation {
        tool: verilator.name.clone(),
        version: verilator.version.to_string(),
        program: verilator.path.clone(),
        arguments,
        directory: directory.to_owned(),
        label: LABEL.to_owned(),
        timeout: plan.timeout,
    })?;
    let objects = directory.join("obj");
    let program = objects.join(PROGRAM);
    if std::fs::metadata(&program).map_or(0, |m| m.len()) == 0 {
        return Err(run.no_verdict(&verilator.name, "a program"));
    }
    let kept = directory.join(PROGRAM);
    std::fs::rename(&program, &kept).map_err(io(&kept))?;
    std::fs::remove_dir_all(&objects).map_err(io(&objects))
}

/// All flags that change what is built.
fn flags(plan: &BuildPlan) -> Vec<String> {
    let top = format!("{}_tb", plan.design);
    let mut flags: Vec<String> = ["--cc", "--exe", "--build", "--top-module", &top]
        .into_iter()
        .chain(["--prefix", PROGRAM, "--timescale", "1ns/1ps"])
        // Lint has its own run, with -Wall; here a warning must not stop the build.
        .chain(["-Wno-fatal"])
        // In pieces, so that a big design is compiled by all cores.
        .chain(["--output-split", "20000"])
        .map(str::to_owned)
        .collect();
    // Not -CFLAGS: the makefile's own -Os would come after it and win.
    let make = match plan.purpose {
        // Measured: -O2 takes 2.3 times as long to build as -O1 and runs no faster with a dump;
        // -O0 takes half as long and runs 9 times slower without one.
        Purpose::Trace => "OPT_FAST=-O1 OPT_SLOW=-O0 OPT_GLOBAL=-O1",
        Purpose::Speed => "OPT_FAST=-O3 OPT_SLOW=-O1 OPT_GLOBAL=-O3",
    };
    flags.extend(["-MAKEFLAGS".to_owned(), make.to_owned()]);
    match plan.purpose {
        // Without the width, vectors of more than 256 bits are silently left out of the dump.
        Purpose::Trace => {
            flags.extend(["--trace", "--trace-max-width", "1000000"].map(str::to_owned))
        }
        Purpose::Speed => flags.push("-O3".to_owned()),
    }
    flags
}

/// Name of the build in the cache: everything that it depends on.
fn key(plan: &BuildPlan, verilator: &FoundTool, compiler: &FoundTool) -> Result<String, ToolError> {
    let mut hash = Sha256::new();
    let mut add = |bytes: &[u8]| {
        hash.update(u64::try_from(bytes.len()).unwrap_or(0).to_le_bytes());
        hash.update(bytes);
    };
    for tool in [verilator, compiler] {
        add(tool.path.as_os_str().as_encoded_bytes());
        add(tool.version.to_string().as_bytes());
    }
    for flag in flags(plan) {
        add(flag.as_bytes());
    }
    let files = plan.sources.iter().chain([&plan.bench, &plan.main_cpp]);
    for path in files {
        add(path.file_name().unwrap_or_default().as_encoded_bytes());
        add(&std::fs::read(path).map_err(io(path))?);
    }
    let digest = hash.finalize();
    Ok(digest.iter().take(16).map(|b| format!("{b:02x}")).collect())
}

/// Reads `hwgen: N clocks in S seconds`.
pub(super) fn seconds(output: &str, clocks: usize) -> Option<f64> {
    let start = format!("hwgen: {clocks} clocks in ");
    let line = output.lines().find_map(|l| l.strip_prefix(&start))?;
    line.strip_suffix(" seconds")?.parse().ok()
}
