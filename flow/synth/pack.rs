//! Makes bitstreams of what is routed.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use hwgen_sim::error::ToolError;
use hwgen_sim::tool::{self, ECPPACK, FoundTool, ICEPACK, Invocation, Toolbox};
use hwgen_spec::device::PlaceTool;

use super::{SynthError, io};

/// The program that makes them for a family.
#[derive(Debug)]
pub(super) struct Packer {
    pub tool: FoundTool,
    arguments: &'static [&'static str],
    /// nextpnr's option for what a bitstream is made of.
    pub option: &'static str,
    /// How the names of that and of bitstreams end.
    ends: [&'static str; 2],
    timeout: Duration,
}

impl Packer {
    /// Finds the program.
    ///
    /// # Errors
    /// If it is not there.
    pub fn new(place: PlaceTool, toolbox: &Toolbox, timeout: Duration) -> Result<Self, ToolError> {
        let (tool, arguments, option, ends): (_, &'static [_], _, _) = match place {
            PlaceTool::Ecp5 => (&ECPPACK, &["--compress"], "--textcfg", ["config", "bit"]),
            PlaceTool::Ice40 => (&ICEPACK, &[], "--asc", ["asc", "bin"]),
            PlaceTool::Nexus | PlaceTool::Gowin => unreachable!("no board has such a device"),
        };
        Ok(Self {
            tool: toolbox.find(tool)?,
            arguments,
            option,
            ends,
            timeout,
        })
    }

    /// What bitstreams depend on.
    pub fn key(&self) -> String {
        format!("{} {}", self.tool.name, self.tool.version)
    }

    /// What a bitstream of a route is made of.
    pub fn configuration(&self, label: &str) -> String {
        format!("{label}.{}", self.ends[0])
    }

    /// Makes a bitstream, if that has not been done.
    ///
    /// # Errors
    /// If the program fails, takes too long or writes nothing.
    pub fn pack(&self, configuration: &Path) -> Result<PathBuf, SynthError> {
        let bitstream = configuration.with_extension(self.ends[1]);
        if bitstream.exists() {
            return Ok(bitstream);
        }
        let name = |path: &Path| {
            let name = path.file_name().and_then(|name| name.to_str());
            name.expect("a plain name").to_owned()
        };
        let part = bitstream.with_extension(format!("part.{}", self.ends[1]));
        if part.exists() {
            fs::remove_file(&part).map_err(io(&part))?;
        }
        let own = [name(configuration), name(&part)];
        let arguments = self.arguments.iter().map(Into::into);
        let run = tool::run(&Invocation {
            tool: self.tool.name.clone(),
            version: self.tool.version.to_string(),
            program: self.tool.path.clone(),
            arguments: arguments.chain(own.map(Into::into)).collect(),
            directory: configuration.parent().expect("one of results").to_owned(),
            label: format!("{}-{}", name(configuration), self.tool.name),
            timeout: self.timeout,
        })?;
        if !part.exists() {
            return Err(run.no_verdict(&self.tool.name, "a bitstream").into());
        }
        fs::rename(&part, &bitstream).map_err(io(&part))?;
        Ok(bitstream)
    }
}
