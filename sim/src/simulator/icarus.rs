//! Icarus Verilog: `iverilog` compiles, `vvp` runs.

use std::ffi::OsString;

use super::{BuildPlan, Built, Simulator, absolute};
use crate::error::ToolError;
use crate::tool::run::{io, remove};
use crate::tool::{ICARUS, Invocation, Toolbox, VVP, run};

pub(super) fn version(tools: &Toolbox) -> Result<String, ToolError> {
    tools.find(&VVP)?;
    Ok(tools.find(&ICARUS)?.version.to_string())
}

pub(super) fn build(tools: &Toolbox, plan: &BuildPlan) -> Result<Built, ToolError> {
    let compiler = tools.find(&ICARUS)?;
    let runtime = tools.find(&VVP)?;
    let directory = std::path::absolute(&plan.work_dir).map_err(io(&plan.work_dir))?;
    let image = directory.join("icarus.vvp");
    remove(&image)?;

    let mut arguments: Vec<OsString> = [
        "-g2005",
        "-Wall",
        // Cells that are synthesised carry no `timescale; only the bench has delays.
        "-Wno-timescale",
        "-s",
    ]
    .map(OsString::from)
    .into();
    arguments.push(format!("{}_tb_icarus", plan.design).into());
    arguments.push("-o".into());
    arguments.push(image.clone().into());
    arguments.extend(absolute(&plan.sources)?);
    arguments.extend(absolute(&[plan.bench.clone(), plan.bench_icarus.clone()])?);
    let run = run(&Invocation {
        tool: compiler.name.clone(),
        version: compiler.version.to_string(),
        program: compiler.path,
        arguments,
        directory,
        label: "icarus-build".to_owned(),
        timeout: plan.timeout,
    })?;
    if std::fs::metadata(&image).map_or(0, |m| m.len()) == 0 {
        return Err(run.no_verdict(&compiler.name, "a compiled design"));
    }
    Ok(Built {
        simulator: Simulator::Icarus,
        version: compiler.version.to_string(),
        program: runtime.path,
        image: Some(image),
        cached: false,
    })
}
