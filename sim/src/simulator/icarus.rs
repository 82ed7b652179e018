//! Icarus Verilog: `iverilog` compiles, `vvp` runs.

use std::ffi::OsString;

use super::input::{self, Input};
use super::{BuildPlan, Built, Simulator};
use crate::error::ToolError;
use crate::tool::live::Scratch;
use crate::tool::run::{io, remove, run_in};
use crate::tool::{ICARUS, Invocation, Toolbox, VVP};

const IMAGE: &str = "icarus.vvp";

pub(super) fn version(tools: &Toolbox) -> Result<String, ToolError> {
    tools.find(&VVP)?;
    Ok(tools.find(&ICARUS)?.version.to_string())
}

pub(super) fn build(tools: &Toolbox, plan: &BuildPlan) -> Result<Built, ToolError> {
    let mut inputs = input::core(&plan.sources, &plan.others())?;
    inputs.extend(plan.models.iter().map(Input::from));
    inputs.extend([&plan.bench, &plan.bench_icarus].map(Input::from));
    let compiler = tools.find(&ICARUS)?;
    let runtime = tools.find(&VVP)?;
    let directory = std::path::absolute(&plan.work_dir).map_err(io(&plan.work_dir))?;
    let image = directory.join(IMAGE);
    remove(&image)?;

    let temporary = std::env::temp_dir();
    let scratch = Scratch::new("hwgen-icarus-", &temporary).map_err(io(&temporary))?;
    let mut arguments: Vec<OsString> = [
        "-g2005",
        // Else values of parameters have as many bits as they need, unlike in synthesis.
        "-gstrict-expr-width",
        "-Wall",
        // Cells that are synthesised carry no `timescale; only the bench has delays.
        "-Wno-timescale",
        "-s",
    ]
    .map(OsString::from)
    .into();
    arguments.push(format!("{}_tb_icarus", plan.design).into());
    arguments.extend(["-o", IMAGE].map(OsString::from));
    arguments.extend(input::place(&inputs, scratch.path())?);
    let invocation = Invocation {
        tool: compiler.name.clone(),
        version: compiler.version.to_string(),
        program: compiler.path,
        arguments,
        directory,
        label: "icarus-build".to_owned(),
        timeout: plan.timeout,
    };
    let run = run_in(&invocation, scratch.path())?;
    let compiled = scratch.path().join(IMAGE);
    if std::fs::metadata(&compiled).map_or(0, |m| m.len()) == 0 {
        return Err(run.no_verdict(&compiler.name, "a compiled design"));
    }
    std::fs::copy(&compiled, &image).map_err(io(&image))?;
    Ok(Built {
        simulator: Simulator::Icarus,
        version: compiler.version.to_string(),
        program: runtime.path,
        image: Some(image),
        cached: false,
    })
}
