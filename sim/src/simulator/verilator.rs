//! Verilator: Verilog to C++, `make` and `g++` to a program, which is kept for the next time.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use sha2::{Digest, Sha256};

use super::input::{self, Input};
use super::{BuildPlan, Built, Purpose, Simulator};
use crate::error::ToolError;
use crate::tool::live::{Scratch, copy_program};
use crate::tool::run::{io, run_in};
use crate::tool::{CXX, FoundTool, Invocation, MAKE, Toolbox, VERILATOR};

const PROGRAM: &str = "Vtb";
/// Digest of the entry's name and of its program, beside it.
const DIGEST: &str = "Vtb.sha256";
const LABEL: &str = "verilator-build";
/// Prefix of an entry of the cache that is not whole yet.
const ASIDE: &str = ".building-";
/// After this time nobody writes such an entry any more.
const STALE: Duration = Duration::from_secs(3600);
/// An entry that was not used for so long is deleted.
const UNUSED: Duration = Duration::from_secs(30 * 24 * 3600);

pub(super) fn version(tools: &Toolbox) -> Result<String, ToolError> {
    tools.find(&MAKE)?;
    tools.find(&CXX)?;
    Ok(tools.find(&VERILATOR)?.version.to_string())
}

pub(super) fn build(tools: &Toolbox, plan: &BuildPlan) -> Result<Built, ToolError> {
    let mut inputs = input::core(&plan.sources, &plan.others())?;
    inputs.extend(plan.models.iter().map(Input::from));
    inputs.extend([&plan.bench, &plan.main_cpp].map(Input::from));
    tools.find(&MAKE)?;
    let compiler = tools.find(&CXX)?;
    let verilator = tools.find(&VERILATOR)?;
    let cache = std::path::absolute(&plan.cache_dir).map_err(io(&plan.cache_dir))?;
    std::fs::create_dir_all(&cache).map_err(io(&cache))?;
    sweep(&cache)?;
    let key = key(plan, &inputs, [&verilator, &compiler]);
    let entry = cache.join(&key);

    let work = std::path::absolute(&plan.work_dir).map_err(io(&plan.work_dir))?;
    let cached = is_whole(&entry, &key)?;
    if cached {
        touch(&entry)?;
        copy_logs(&entry, &work)?;
    } else {
        let scratch = compile(plan, &inputs, &verilator, &work)?;
        let program = scratch.path().join("obj").join(PROGRAM);
        // Aside, and renamed when it is whole: whoever else builds the same never sees half of it.
        let aside = Scratch::new(ASIDE, &cache).map_err(io(&cache))?;
        copy_logs(&work, aside.path())?;
        copy_program(&program, &aside.path().join(PROGRAM)).map_err(io(&program))?;
        let digest = aside.path().join(DIGEST);
        std::fs::write(&digest, digest_of(&program, &key)?).map_err(io(&digest))?;
        // No build, or not of this design: left by someone who meddled with the cache.
        if entry.is_dir() && !is_whole(&entry, &key)? {
            std::fs::remove_dir_all(&entry).map_err(io(&entry))?;
        }
        match std::fs::rename(aside.path(), &entry) {
            Ok(()) => {}
            // Another was first; its build is as good.
            Err(_) if is_whole(&entry, &key)? => {}
            Err(error) => return Err(io(&entry)(error)),
        }
    }
    Ok(Built {
        simulator: Simulator::Verilator,
        version: verilator.version.to_string(),
        program: entry.join(PROGRAM),
        image: None,
        cached,
    })
}

/// Whether an entry of the cache has a program, and the one that was put there under this name.
fn is_whole(entry: &Path, key: &str) -> Result<bool, ToolError> {
    let program = entry.join(PROGRAM);
    if !program.is_file() {
        return Ok(false);
    }
    let stated = std::fs::read_to_string(entry.join(DIGEST)).unwrap_or_default();
    Ok(digest_of(&program, key)? == stated)
}

fn digest_of(program: &Path, key: &str) -> Result<String, ToolError> {
    let mut hash = Sha256::new();
    hash.update(key);
    hash.update(std::fs::read(program).map_err(io(program))?);
    let digest = hash.finalize();
    Ok(digest.iter().map(|b| format!("{b:02x}")).collect())
}

/// Notes that an entry was used now.
fn touch(entry: &Path) -> Result<(), ToolError> {
    let path = entry.join(DIGEST);
    let file = std::fs::File::options().append(true).open(&path);
    file.and_then(|file| file.set_modified(SystemTime::now()))
        .map_err(io(&path))
}

/// Deletes what builds that were killed have left in the cache, and what nobody has used for long.
fn sweep(cache: &Path) -> Result<(), ToolError> {
    let now = SystemTime::now();
    for entry in std::fs::read_dir(cache).map_err(io(cache))? {
        let entry = entry.map_err(io(cache))?;
        let aside = entry.file_name().to_string_lossy().starts_with(ASIDE);
        let (changing, limit) = match aside {
            true => (entry.path(), STALE),
            false => (entry.path().join(DIGEST), UNUSED),
        };
        // None where another has just renamed or deleted it.
        let changed = std::fs::metadata(&changing).and_then(|m| m.modified()).ok();
        let age = changed.and_then(|changed| now.duration_since(changed).ok());
        if age.is_some_and(|age| age > limit) {
            let _ = std::fs::remove_dir_all(entry.path());
        }
    }
    Ok(())
}

fn copy_logs(from: &Path, to: &Path) -> Result<(), ToolError> {
    for extension in ["log", "run.json"] {
        let name = format!("{LABEL}.{extension}");
        let from = from.join(&name);
        std::fs::copy(&from, to.join(&name)).map_err(io(&from))?;
    }
    Ok(())
}

/// Leaves the program in `obj` of a directory of its own; log and record are left in `work`.
fn compile(
    plan: &BuildPlan,
    inputs: &[Input],
    verilator: &FoundTool,
    work: &Path,
) -> Result<Scratch, ToolError> {
    let temporary = plain_directory();
    let scratch = Scratch::new("hwgen-verilator-", &temporary).map_err(io(&temporary))?;
    let mut arguments: Vec<OsString> = flags(plan).into_iter().map(OsString::from).collect();
    let jobs = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    arguments.extend(["-j".to_owned(), jobs.to_string()].map(OsString::from));
    arguments.extend(["-Mdir", "obj"].map(OsString::from));
    arguments.extend(input::place(inputs, scratch.path())?);
    let invocation = Invocation {
        tool: verilator.name.clone(),
        version: verilator.version.to_string(),
        program: verilator.path.clone(),
        arguments,
        directory: work.to_owned(),
        label: LABEL.to_owned(),
        timeout: plan.timeout,
    };
    let run = run_in(&invocation, scratch.path())?;
    let program = scratch.path().join("obj").join(PROGRAM);
    if std::fs::metadata(&program).map_or(0, |m| m.len()) == 0 {
        return Err(run.no_verdict(&verilator.name, "a program"));
    }
    Ok(scratch)
}

/// For temporary files, with a path that make can build in: it refuses spaces, and a shell may
/// read quotes.
fn plain_directory() -> PathBuf {
    let plain = |path: &Path| {
        let plain = |c: char| c.is_alphanumeric() || "/._-+".contains(c);
        path.to_str().is_some_and(|path| path.chars().all(plain))
    };
    let temporary = std::env::temp_dir();
    if plain(&temporary) {
        temporary
    } else {
        PathBuf::from("/var/tmp")
    }
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
fn key(plan: &BuildPlan, inputs: &[Input], tools: [&FoundTool; 2]) -> String {
    let mut hash = Sha256::new();
    let mut add = |bytes: &[u8]| {
        hash.update(u64::try_from(bytes.len()).unwrap_or(0).to_le_bytes());
        hash.update(bytes);
    };
    for tool in tools {
        add(tool.path.as_os_str().as_encoded_bytes());
        add(tool.version.to_string().as_bytes());
    }
    for flag in flags(plan) {
        add(flag.as_bytes());
    }
    for input in inputs {
        add(input.name.as_encoded_bytes());
        add(&input.text);
    }
    let digest = hash.finalize();
    digest.iter().take(16).map(|b| format!("{b:02x}")).collect()
}

/// Reads `hwgen: N clocks in S seconds`.
pub(super) fn seconds(output: &str, clocks: usize) -> Option<f64> {
    let start = format!("hwgen: {clocks} clocks in ");
    let line = output.lines().find_map(|l| l.strip_prefix(&start))?;
    line.strip_suffix(" seconds")?.parse().ok()
}
