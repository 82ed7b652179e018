//! Why a check could not be made.

use std::path::PathBuf;

use crate::work::WorkError;

/// Anything that kept a check from being made: an external tool, a dump, a directory.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SimError {
    /// An external tool.
    #[error(transparent)]
    Tool(#[from] ToolError),
    /// A dump that cannot be read or is not of this run.
    #[error(transparent)]
    Trace(#[from] TraceError),
    /// The directory that a check was to work in.
    #[error(transparent)]
    Work(#[from] WorkError),
}

/// What went wrong with an external tool.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ToolError {
    /// Found under none of its names, or nothing that was found worked.
    #[error("{tool} was not found (looked for {}){}", names.join(", "), list(tried))]
    Missing {
        /// What was wanted.
        tool: String,
        /// The names it was looked for under.
        names: Vec<String>,
        /// The command that installs it.
        install: String,
        /// What was found and refused, and why.
        tried: Vec<String>,
    },
    /// Found, but of an older version than is supported.
    #[error("{tool} {found} is too old: {minimum} or later is needed ({})", path.display())]
    TooOld {
        /// What was wanted.
        tool: String,
        /// Where it is.
        path: PathBuf,
        /// Its version.
        found: String,
        /// The oldest supported version.
        minimum: String,
        /// The command that installs it.
        install: String,
    },
    /// Ended with another exit status than 0.
    #[error("{tool} failed with {status}, see {}:\n{last_lines}", log.display())]
    Failed {
        /// What was run.
        tool: String,
        /// Exit status or signal.
        status: String,
        /// The end of what it printed.
        last_lines: String,
        /// All that it printed.
        log: PathBuf,
    },
    /// Still ran at its time limit, and was killed with its children.
    #[error("{tool} was killed after {seconds} s, see {}", log.display())]
    TimedOut {
        /// What was run.
        tool: String,
        /// The time limit.
        seconds: f64,
        /// What it had printed.
        log: PathBuf,
    },
    /// Ended with exit status 0 but without the line or file that proves it did its work.
    #[error("{tool} ended without {expected}, see {}:\n{last_lines}", log.display())]
    NoVerdict {
        /// What was run.
        tool: String,
        /// What had to be there.
        expected: String,
        /// The end of what it printed.
        last_lines: String,
        /// All that it printed.
        log: PathBuf,
    },
    /// A source of the core has text that simulators and synthesis may read differently, or that
    /// calls the simulator.
    #[error(
        "{}:{line}: expected Verilog that simulators and synthesis read alike, found {found}",
        path.display()
    )]
    Refused {
        /// The source.
        path: PathBuf,
        /// Line in it, from 1.
        line: usize,
        /// What is refused.
        found: String,
    },
    /// A model of a block says that a pin or parameter is not tied as the contract says.
    #[error("{instance}: expected {expected}, found {found}")]
    Contract {
        /// The block's path in the simulation.
        instance: String,
        /// What the contract says.
        expected: String,
        /// What is there.
        found: String,
    },
    /// A file of the run could not be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
}

impl ToolError {
    /// The command that mends it, where one is known.
    pub fn install(&self) -> Option<&str> {
        match self {
            Self::Missing { install, .. } | Self::TooOld { install, .. } => Some(install),
            _ => None,
        }
    }
}

/// Why a dump says nothing about a recording.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TraceError {
    /// Not readable as VCD or FST.
    #[error("{}: no readable dump: {reason}", path.display())]
    Unreadable {
        /// The dump.
        path: PathBuf,
        /// What its reader said.
        reason: String,
    },
    /// There is no instance `u_dut` with a clock `aclk` in it.
    #[error("{}: no instance `u_dut` with a clock `aclk` in the dump", path.display())]
    NoDut {
        /// The dump.
        path: PathBuf,
    },
    /// The dump lacks a register.
    #[error("register `{register}` is not in the dump{}", list(nearest))]
    MissingRegister {
        /// Path of the register from the core down.
        register: String,
        /// Existing paths that resemble it, the most similar first.
        nearest: Vec<String>,
    },
    /// A register has another width in the dump.
    #[error("register `{register}`: expected {expected} bits, found {found} in the dump")]
    Width {
        /// Path of the register.
        register: String,
        /// Bits in the recording.
        expected: u64,
        /// Bits in the dump.
        found: u64,
    },
    /// The dump ends early or goes on: it is of another run.
    #[error("expected {expected} rising edges of the clock, found {found} in the dump")]
    EdgeCount {
        /// Clocks in the recording.
        expected: usize,
        /// Rising edges in the dump.
        found: usize,
    },
    /// An edge at another time than the bench makes it.
    #[error("expected rising edge {clock} at {expected_ps} ps, found it at {found_ps} ps")]
    EdgeTime {
        /// Number of the edge, from 0.
        clock: usize,
        /// Where the bench makes it.
        expected_ps: u64,
        /// Where it is.
        found_ps: u64,
    },
    /// The dump does not contain the number that the run was given: it is of another run.
    #[error("expected nonce {expected:016x} in the dump, found {found}")]
    Nonce {
        /// What the run was given.
        expected: u64,
        /// What the dump has.
        found: String,
    },
    /// No register or no edge to compare: that is not "equal".
    #[error("nothing to compare: {registers} registers, {edges} edges")]
    Nothing {
        /// Registers in the recording.
        registers: usize,
        /// Edges from the first compared one on.
        edges: usize,
    },
}

fn list(items: &[String]) -> String {
    if items.is_empty() {
        String::new()
    } else {
        format!("; there is: {}", items.join(", "))
    }
}
