//! What is printed: results on standard output, messages and progress on standard error.

use std::io::{self, IsTerminal, Write};

use serde_json::Value;

use crate::cli::Global;
use crate::failure::Failure;

/// Where and how to print.
#[derive(Clone, Debug)]
pub struct Output {
    json: bool,
    quiet: bool,
    verbose: bool,
    colour: bool,
    terminal: bool,
}

impl Output {
    /// As the options ask, and as the standard streams can show it.
    pub fn new(global: &Global) -> Self {
        let set = |name| std::env::var_os(name).is_some_and(|v: std::ffi::OsString| !v.is_empty());
        let terminal =
            io::stderr().is_terminal() && std::env::var_os("TERM").is_none_or(|t| t != "dumb");
        Self {
            json: global.json,
            quiet: global.quiet,
            verbose: global.verbose,
            colour: terminal && !set("NO_COLOR"),
            terminal,
        }
    }

    /// Without colour and progress.
    pub fn plain() -> Self {
        Self {
            json: false,
            quiet: true,
            verbose: false,
            colour: false,
            terminal: false,
        }
    }

    /// Whether the result is a JSON object.
    pub fn json(&self) -> bool {
        self.json
    }

    /// Whether more is to be told.
    pub fn verbose(&self) -> bool {
        self.verbose
    }

    /// Whether progress is one line that changes in its place.
    pub fn in_place(&self) -> bool {
        self.terminal && !self.verbose && !self.quiet
    }

    /// Prints a result for people.
    ///
    /// # Errors
    /// If it can't be written. A reader that went away is none.
    pub fn text(&self, text: &str) -> io::Result<()> {
        match self.write(text) {
            Err(e) if e.kind() == io::ErrorKind::BrokenPipe => Ok(()),
            other => other,
        }
    }

    /// Prints a piece of a long result for people.
    ///
    /// # Errors
    /// If it can't be written, or its reader went away.
    pub fn write(&self, text: &str) -> io::Result<()> {
        let mut stdout = io::stdout().lock();
        stdout.write_all(text.as_bytes())?;
        stdout.flush()
    }

    /// Prints a result for programs, one object on one line.
    ///
    /// # Errors
    /// As [`text`](Self::text).
    pub fn object(&self, object: &Value) -> io::Result<()> {
        self.text(&format!("{object}\n"))
    }

    /// Prints a message, unless quiet.
    pub fn remark(&self, text: &str) {
        if !self.quiet {
            self.message(text);
        }
    }

    /// Prints a message that concerns the details, if they are asked for.
    pub fn detail(&self, text: &str) {
        if self.verbose {
            self.message(text);
        }
    }

    /// Prints a failure: `error: ...`, its causes, and how to mend it.
    pub fn failure(&self, failure: &Failure) {
        let mut text = format!("{} {failure}", self.painted("31", "error:"));
        for cause in &failure.causes {
            text.push_str(&format!("\n  because: {cause}"));
        }
        if let Some(help) = &failure.help {
            text.push_str(&format!("\n{} {help}", self.painted("36", "help:")));
        }
        self.message(&text);
    }

    /// Shows how far a long task is.
    pub fn progress(&self) -> Progress<'_> {
        Progress {
            output: self,
            last: String::new(),
        }
    }

    fn message(&self, text: &str) {
        // Standard error is the last place to complain at.
        let _ = writeln!(io::stderr().lock(), "{text}");
    }

    fn painted(&self, colour: &str, text: &str) -> String {
        if self.colour {
            format!("\x1b[1;{colour}m{text}\x1b[0m")
        } else {
            text.to_owned()
        }
    }
}

/// A line in place on a terminal, a line for each activity elsewhere, nothing if quiet.
#[derive(Debug)]
pub struct Progress<'a> {
    output: &'a Output,
    last: String,
}

impl Progress<'_> {
    /// Shows what is being done, and that `done` of `total` steps are behind.
    pub fn show(&mut self, activity: &str, done: usize, total: usize) {
        if self.output.quiet {
            return;
        }
        let in_place = self.output.in_place();
        if in_place {
            let _ = write!(io::stderr().lock(), "\r\x1b[K[{done}/{total}] {activity}");
        } else if activity != self.last {
            self.output.message(&format!("[{done}/{total}] {activity}"));
        }
        activity.clone_into(&mut self.last);
    }
}

impl Drop for Progress<'_> {
    fn drop(&mut self) {
        if self.output.terminal && !self.output.verbose && !self.last.is_empty() {
            let _ = write!(io::stderr().lock(), "\r\x1b[K");
        }
    }
}
