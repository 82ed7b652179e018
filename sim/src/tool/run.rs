//! Runs one command, and leaves behind what was run and what came of it.

use std::ffi::OsString;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use super::live::Running;
use crate::error::ToolError;

/// A command to be run.
#[derive(Clone, Debug)]
pub struct Invocation {
    /// The name people know the tool by.
    pub tool: String,
    /// Its version, for the record.
    pub version: String,
    /// The executable.
    pub program: PathBuf,
    /// Its arguments.
    pub arguments: Vec<OsString>,
    /// Where it runs and where its log is left.
    pub directory: PathBuf,
    /// Stem of the log's name: `<label>.log` and `<label>.run.json`.
    pub label: String,
    /// How long it may run.
    pub timeout: Duration,
}

/// A command that ended with exit status 0.
#[derive(Clone, Debug)]
pub struct Run {
    /// All that it printed, on either stream.
    pub output: String,
    /// The file that holds the same.
    pub log: PathBuf,
    /// How long it ran.
    pub duration: Duration,
}

impl Run {
    /// Whether a line of the output is exactly this.
    pub fn says(&self, line: &str) -> bool {
        self.output.lines().any(|l| l.trim_end() == line)
    }

    /// The error that the verdict is missing.
    pub fn no_verdict(&self, tool: &str, expected: impl Into<String>) -> ToolError {
        ToolError::NoVerdict {
            tool: tool.to_owned(),
            expected: expected.into(),
            last_lines: last_lines(&self.output),
            log: self.log.clone(),
        }
    }
}

/// Lines of the log that an error shows.
const LAST_LINES: usize = 12;

/// Runs a command to its end.
///
/// Command line, version, exit status and duration are left in `<label>.run.json`, standard output
/// and error in `<label>.log`. Both are deleted first.
///
/// # Errors
/// If it cannot be started, fails, or is still running after its time limit; then it is killed
/// with all the processes it started.
pub fn run(invocation: &Invocation) -> Result<Run, ToolError> {
    run_in(invocation, &invocation.directory)
}

/// The same in another directory than the one that log and record are left in; the command's
/// temporary files go there as well, and with it.
pub(crate) fn run_in(invocation: &Invocation, current: &Path) -> Result<Run, ToolError> {
    watch(invocation, current, None).map(|run| run.expect("nobody watches it"))
}

/// Runs a command to its end, or until what it has written into its log is enough; then it is killed, and
/// there is no run.
///
/// # Errors
/// As [`run`].
pub fn run_until(
    invocation: &Invocation,
    enough: impl Fn(&Path) -> bool,
) -> Result<Option<Run>, ToolError> {
    watch(invocation, &invocation.directory, Some(&enough))
}

/// How often a log is looked at.
const LOOK: Duration = Duration::from_millis(200);

fn watch(
    invocation: &Invocation,
    current: &Path,
    enough: Option<&dyn Fn(&Path) -> bool>,
) -> Result<Option<Run>, ToolError> {
    let directory = &invocation.directory;
    let log = directory.join(format!("{}.log", invocation.label));
    let record = directory.join(format!("{}.run.json", invocation.label));
    std::fs::create_dir_all(directory).map_err(io(directory))?;
    remove(&record)?;
    remove(&log)?;

    // Both streams go to one file and not through pipes: a grandchild that keeps a pipe open
    // could hold us up for ever.
    let output = File::create(&log).map_err(io(&log))?;
    let error = output.try_clone().map_err(io(&log))?;
    let start = Instant::now();
    let mut command = Command::new(&invocation.program);
    command
        .args(&invocation.arguments)
        .current_dir(current)
        .stdin(Stdio::null())
        .stdout(output)
        .stderr(error);
    if current != directory {
        command.env("TMPDIR", current);
    }
    let child = Running::start(&mut command).map_err(io(&invocation.program))?;
    let enough = enough.map(|enough| || enough(&log));
    let ended = wait(child, start + invocation.timeout, enough).map_err(io(&invocation.program))?;
    let duration = start.elapsed();

    let text = std::fs::read(&log).map_err(io(&log))?;
    let text = String::from_utf8_lossy(&text).into_owned();
    let status = match ended {
        Ended::Itself(status) => status.to_string(),
        Ended::Enough => "stopped: its log says enough".to_owned(),
        Ended::TooLong => format!("killed after {} s", invocation.timeout.as_secs_f64()),
    };
    let json = serde_json::json!({
        "tool": invocation.tool,
        "version": invocation.version,
        "program": invocation.program.to_string_lossy(),
        "arguments": invocation.arguments.iter().map(|a| a.to_string_lossy()).collect::<Vec<_>>(),
        "status": status,
        "seconds": duration.as_secs_f64(),
        "log": log.file_name().map(|name| name.to_string_lossy()),
    });
    std::fs::write(&record, format!("{json:#}\n")).map_err(io(&record))?;

    match ended {
        Ended::Itself(status) if status.success() => Ok(Some(Run {
            output: text,
            log,
            duration,
        })),
        Ended::Enough => Ok(None),
        Ended::Itself(_) => Err(ToolError::Failed {
            tool: invocation.tool.clone(),
            status,
            last_lines: last_lines(&text),
            log,
        }),
        Ended::TooLong => Err(ToolError::TimedOut {
            tool: invocation.tool.clone(),
            seconds: invocation.timeout.as_secs_f64(),
            log,
        }),
    }
}

/// Why a command is over.
enum Ended {
    Itself(ExitStatus),
    Enough,
    TooLong,
}

/// Waits for the end, and brings it about if it is due.
fn wait(
    mut child: Running,
    deadline: Instant,
    enough: Option<impl Fn() -> bool>,
) -> std::io::Result<Ended> {
    let mut pause = Duration::from_micros(200);
    let mut look = Instant::now() + LOOK;
    loop {
        if let Some(status) = child.poll()? {
            return Ok(Ended::Itself(status));
        }
        let now = Instant::now();
        if now >= deadline {
            return child.kill().map(|()| Ended::TooLong);
        }
        if let Some(enough) = enough.as_ref().filter(|_| now >= look) {
            if enough() {
                return child.kill().map(|()| Ended::Enough);
            }
            look = now + LOOK;
        }
        std::thread::sleep(pause.min(deadline - now));
        pause = (pause * 2).min(Duration::from_millis(20));
    }
}

/// Deletes a file that need not exist.
pub(crate) fn remove(path: &Path) -> Result<(), ToolError> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(io(path)(error)),
        _ => Ok(()),
    }
}

/// Names the file in an error.
pub(crate) fn io(path: &Path) -> impl FnOnce(std::io::Error) -> ToolError + '_ {
    move |source| ToolError::Io {
        path: path.to_owned(),
        source,
    }
}

fn last_lines(text: &str) -> String {
    let lines: Vec<&str> = text.lines().collect();
    lines[lines.len().saturating_sub(LAST_LINES)..].join("\n")
}
