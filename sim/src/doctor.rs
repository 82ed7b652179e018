//! Which external tools there are, found out by running them.

use std::path::PathBuf;

use serde::Serialize;

use crate::error::ToolError;
use crate::tool::{TOOLS, Tool, Toolbox};

/// What came of looking for a tool.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Health {
    /// Runs, and is new enough.
    Ok,
    /// Runs, but is too old.
    TooOld,
    /// Not there.
    Missing,
    /// There, but it does not run as itself.
    Broken,
}

/// One line of the table.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ToolStatus {
    /// The name people know it by.
    pub name: &'static str,
    /// What came of looking for it.
    pub health: Health,
    /// Where it is, if it runs.
    pub path: Option<PathBuf>,
    /// Its version, if it runs.
    pub version: Option<String>,
    /// The oldest version that is supported.
    pub minimum: &'static str,
    /// What works once it is there.
    pub enables: &'static str,
    /// The command that installs it.
    pub install: &'static str,
    /// What was found and refused, and why.
    pub refused: Vec<String>,
}

/// Looks for every tool, in the order in which they are needed.
pub fn examine(tools: &Toolbox) -> Vec<ToolStatus> {
    TOOLS.iter().map(|tool| status(tools, tool)).collect()
}

/// Looks for one tool.
pub fn status(tools: &Toolbox, tool: &Tool) -> ToolStatus {
    let mut status = ToolStatus {
        name: tool.name,
        health: Health::Missing,
        path: None,
        version: None,
        minimum: tool.minimum,
        enables: tool.enables,
        install: tool.install,
        refused: Vec::new(),
    };
    match tools.find(tool) {
        Ok(found) => {
            status.health = Health::Ok;
            status.path = Some(found.path);
            status.version = Some(found.version.to_string()).filter(|version| !version.is_empty());
        }
        Err(ToolError::TooOld { path, found, .. }) => {
            status.health = Health::TooOld;
            status.path = Some(path);
            status.version = Some(found);
        }
        Err(ToolError::Missing { tried, .. }) => {
            if !tried.is_empty() {
                status.health = Health::Broken;
            }
            status.refused = tried;
        }
        Err(other) => {
            status.health = Health::Broken;
            status.refused.push(other.to_string());
        }
    }
    status
}
