//! `hwgen doctor`

use std::path::Path;

use hwgen_sim::doctor::{Health, ToolStatus, examine};
use hwgen_sim::simulator::Simulator;
use hwgen_sim::tool::Toolbox;
use serde_json::{Map, json};

use super::Outcome;
use crate::failure::{Exit, Failure};
use crate::layout::{columns, row};

const EXAMPLES: &str = "\
Tools are looked for in .eda/bin below the current directory, in $VIRTUAL_ENV/bin and in $PATH,
and each is run: a name alone is no tool.

Examples:
  hwgen doctor
  hwgen doctor --json

Exit codes: 0 if both simulators work, else 3.";

/// What `doctor` takes.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {}

/// Lists the tools; both simulators must be well.
///
/// # Errors
/// None: what is missing is part of the outcome.
pub fn run(_: &Args) -> Result<Outcome, Failure> {
    let toolbox = Toolbox::new(Path::new("."));
    let tools = examine(&toolbox);
    let sick: Vec<_> = Simulator::ALL
        .iter()
        .filter_map(|s| Some((s.name(), s.version(&toolbox).err()?)))
        .collect();
    let failure = sick.first().map(|(_, error)| {
        let names: Vec<&str> = sick.iter().map(|(name, _)| *name).collect();
        let installs: Vec<&str> = sick.iter().filter_map(|(_, e)| e.install()).collect();
        let message = format!("simulators that do not work: {}", names.join(", "));
        let failure = Failure::new(Exit::Tool, "tool-missing", message);
        match installs[..] {
            [] => failure.help(error.to_string()),
            _ => failure.help(format!("install with `{}`", installs.join(" && "))),
        }
    });
    let mut rows = vec![row![
        "tool",
        "state",
        "version",
        "needed",
        "enables",
        "install with"
    ]];
    rows.extend(tools.iter().map(line));
    let mut text = columns("llllll", &rows);
    for tool in &tools {
        for refused in &tool.refused {
            text.push_str(&format!("note: {}: refused {refused}\n", tool.name));
        }
    }
    Ok(Outcome {
        text,
        json: Map::from_iter([("tools".to_owned(), json!(tools))]),
        failure,
        ..Outcome::default()
    })
}

fn line(tool: &ToolStatus) -> Vec<String> {
    let (state, install) = match tool.health {
        Health::Ok => ("ok", ""),
        Health::TooOld => ("too old", tool.install),
        Health::Missing => ("missing", tool.install),
        _ => ("broken", tool.install),
    };
    let version = tool.version.as_deref().unwrap_or("-");
    row![
        tool.name,
        state,
        version,
        tool.minimum,
        tool.enables,
        install
    ]
}
