//! What went wrong, as it is printed, and with which exit code the process ends.

use std::error::Error;
use std::fmt;
use std::io;
use std::ops::{Deref, DerefMut};
use std::path::Path;
use std::process::ExitCode;

use hwgen_gen::BundleError;
use hwgen_sim::error::{SimError, ToolError};
use hwgen_sim::work::WorkError;
use hwgen_spec::design::DesignError;
use hwgen_spec::quantize::QuantizeError;
use hwgen_spec::weights::WeightsError;
use serde_json::{Map, Value};

use crate::synth::SynthError;

/// How the process ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// 0: done, and true.
    Done,
    /// 1: a check found a difference, or a target was missed.
    Difference,
    /// 2: bad usage or bad input.
    Input,
    /// 3: an external tool is missing, failed or ran out of time.
    Tool,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(match exit {
            Exit::Done => 0,
            Exit::Difference => 1,
            Exit::Input => 2,
            Exit::Tool => 3,
        })
    }
}

/// An error for the user, small enough to be returned everywhere.
///
/// Displayed as `<file>:<line>:<column>: <path>: <message>`, as far as these are known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure(Box<Details>);

/// What is known of an error.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Details {
    /// How the process ends.
    pub exit: Exit,
    /// Short stable name of the kind of failure, such as `bundle-changed`.
    pub code: &'static str,
    /// What was expected and what was found.
    pub message: String,
    /// The file, if it is about one.
    pub file: Option<String>,
    /// JSON path in a weights file, empty at its root.
    pub path: Option<String>,
    /// Line in the file, from 1.
    pub line: Option<usize>,
    /// Column in the file, from 1: characters in JSON, fields in CSV.
    pub column: Option<usize>,
    /// What led to it, the nearest cause first.
    pub causes: Vec<String>,
    /// How to mend it.
    pub help: Option<String>,
}

impl Deref for Failure {
    type Target = Details;

    fn deref(&self) -> &Details {
        &self.0
    }
}

impl DerefMut for Failure {
    fn deref_mut(&mut self) -> &mut Details {
        &mut self.0
    }
}

impl Failure {
    /// A failure of any kind.
    pub fn new(exit: Exit, code: &'static str, message: impl Into<String>) -> Self {
        Self(Box::new(Details {
            exit,
            code,
            message: message.into(),
            file: None,
            path: None,
            line: None,
            column: None,
            causes: Vec::new(),
            help: None,
        }))
    }

    /// Bad usage or input: exit code 2.
    pub fn input(code: &'static str, message: impl Into<String>) -> Self {
        Self::new(Exit::Input, code, message)
    }

    /// The system refused a file: exit code 2.
    pub fn io(file: &Path, error: &io::Error) -> Self {
        Self::input("io", error.to_string())
            .file(file.display().to_string())
            .help("check that the path exists and that you may use it")
    }

    /// A refused weights file.
    pub fn weights(file: &Path, error: &WeightsError) -> Self {
        let mut failure =
            Self::input(error.code(), error.message()).file(file.display().to_string());
        failure.path = Some(error.path().to_owned());
        failure.line = Some(error.line());
        failure.column = Some(error.column());
        failure.help = error.help().map(str::to_owned);
        failure
    }

    /// The same about a file.
    #[must_use]
    pub fn file(mut self, file: impl Into<String>) -> Self {
        self.file = Some(file.into());
        self
    }

    /// The same at a place in its file.
    #[must_use]
    pub fn at(mut self, line: usize, column: Option<usize>) -> Self {
        self.line = Some(line);
        self.column = column;
        self
    }

    /// The same with a line that says how to mend it.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// The same with those causes that the message does not tell yet.
    fn caused_by(mut self, error: &dyn Error) -> Self {
        let mut cause = error.source();
        while let Some(error) = cause {
            let text = error.to_string();
            if !self.message.contains(&text) {
                self.causes.push(text);
            }
            cause = error.source();
        }
        self
    }

    /// `{code, message, path?, file?, line?, column?, causes?, help?}`; `path` is the JSON path in
    /// a weights file, else the file.
    pub fn to_json(&self) -> Value {
        let mut object = Map::new();
        let mut put = |key: &str, value: Option<Value>| {
            value.map(|value| object.insert(key.into(), value));
        };
        put("code", Some(self.code.into()));
        put("message", Some(self.message.as_str().into()));
        let path = self.path.as_deref().or(self.file.as_deref());
        put("path", path.map(Into::into));
        put("file", self.file.as_deref().map(Into::into));
        put("line", self.line.map(Into::into));
        put("column", self.column.map(Into::into));
        let causes = (!self.causes.is_empty()).then(|| self.causes.clone().into());
        put("causes", causes);
        put("help", self.help.as_deref().map(Into::into));
        Value::Object(object)
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(file) = &self.file {
            write!(f, "{file}:")?;
            if let Some(line) = self.line {
                write!(f, "{line}:")?;
            }
            if let Some(column) = self.column {
                write!(f, "{column}:")?;
            }
            f.write_str(" ")?;
        }
        match self.path.as_deref() {
            Some("") | None => {}
            Some(path) => write!(f, "{path}: ")?,
        }
        f.write_str(&self.message)
    }
}

impl From<DesignError> for Failure {
    fn from(error: DesignError) -> Self {
        let code = match &error {
            DesignError::Budget { .. } => "budget",
            DesignError::UnknownDevice(_) => "unknown-device",
            DesignError::TooSmall { .. } => "device-too-small",
            DesignError::Name { .. } => "name",
            DesignError::Quantize(e) => match e {
                QuantizeError::UnknownLayer { .. } => "unknown-layer",
                QuantizeError::Width { .. } => "width",
                QuantizeError::Segments { .. } => "segments",
                QuantizeError::ActivationFormat { .. } => "activation-format",
                QuantizeError::SumWidth { .. } => "sum-width",
                QuantizeError::Idle { .. } => "idle-option",
                QuantizeError::OneCode { .. } => "one-code",
                QuantizeError::Magnitude { .. } => "magnitude",
                _ => "quantize",
            },
            _ => "design",
        };
        Self::input(code, error.to_string()).help(error.help())
    }
}

impl From<BundleError> for Failure {
    fn from(error: BundleError) -> Self {
        let (code, path) = match &error {
            BundleError::Exists { path } => ("exists", path),
            BundleError::NotABundle { path } => ("not-a-bundle", path),
            BundleError::Foreign { path, .. } => ("foreign-files", path),
            BundleError::NoName { path } => ("no-name", path),
            BundleError::Io { path, .. } | BundleError::Parked { path, .. } => ("io", path),
            BundleError::Altered { path, .. } => ("manifest-differs", path),
            BundleError::Unlisted { path } => ("bundle-unlisted", path),
            BundleError::Manifest { path, .. } => ("no-manifest", path),
            BundleError::Changed { path, .. } => ("bundle-changed", path),
            BundleError::Differs { path, .. } => ("bundle-differs", path),
            BundleError::Stale { path, .. } => ("bundle-stale", path),
            BundleError::Weights { path, source } => return Self::weights(path, source),
            BundleError::Design(_) => {
                let help = error.help();
                return match error {
                    BundleError::Design(e) => (*e).into(),
                    other => Self::input("bundle", other.to_string()).help(help),
                };
            }
            other => return Self::input("bundle", other.to_string()).help(other.help()),
        };
        Self::input(code, about(path, &error))
            .file(path.display().to_string())
            .help(error.help())
            .caused_by(&error)
    }
}

impl From<SimError> for Failure {
    fn from(error: SimError) -> Self {
        match error {
            SimError::Tool(error) => error.into(),
            SimError::Work(error) => error.into(),
            other => Self::new(Exit::Tool, "trace", other.to_string()).caused_by(&other),
        }
    }
}

impl From<WorkError> for Failure {
    fn from(error: WorkError) -> Self {
        let (code, path, help) = match &error {
            WorkError::Busy { path } => (
                "work-busy",
                path,
                "wait for its end, or choose another --work",
            ),
            WorkError::Io { path, source } => return Self::io(path, source),
            WorkError::Foreign { path } => {
                let help = "choose another --work: it is emptied before the check";
                ("work", path, help)
            }
            other => return Self::input("work", other.to_string()),
        };
        Self::input(code, about(path, &error))
            .file(path.display().to_string())
            .help(help)
    }
}

/// What an error says of a file, without the file's name at its front.
fn about(path: &Path, error: &dyn Error) -> String {
    let text = error.to_string();
    let rest = text.strip_prefix(&format!("{}: ", path.display()));
    rest.map_or(text.clone(), str::to_owned)
}

impl From<SynthError> for Failure {
    fn from(error: SynthError) -> Self {
        match error {
            SynthError::Tool(error) => error.into(),
            SynthError::Io { path, source } => Self::io(&path, &source),
            SynthError::NoRoom { .. } => {
                Self::new(Exit::Difference, "does-not-fit", error.to_string())
                    .help("emit it with a longer --interval or fewer bits, or take a larger device")
            }
            SynthError::NoRoutes { .. } => {
                Self::new(Exit::Difference, "no-routes", error.to_string())
                    .help("another seed may have routes; a longer --interval takes fewer of them")
            }
            SynthError::Strange { .. } => {
                Self::new(Exit::Tool, "tool-no-verdict", error.to_string())
                    .help("delete the file's directory, so that the tools run again")
            }
        }
    }
}

impl From<ToolError> for Failure {
    fn from(error: ToolError) -> Self {
        if let ToolError::Refused { path, line, found } = &error {
            let message =
                format!("expected Verilog that simulators and synthesis read alike, found {found}");
            return Self::new(Exit::Difference, "refused-text", message)
                .file(path.display().to_string())
                .at(*line, None)
                .help("emit the bundle again: no core that hwgen emits contains it");
        }
        let code = match &error {
            ToolError::Missing { .. } => "tool-missing",
            ToolError::TooOld { .. } => "tool-too-old",
            ToolError::Failed { .. } => "tool-failed",
            ToolError::TimedOut { .. } => "tool-timed-out",
            ToolError::NoVerdict { .. } => "tool-no-verdict",
            _ => "tool",
        };
        let mut failure = Self::new(Exit::Tool, code, error.to_string()).caused_by(&error);
        failure.help = match (&error, error.install()) {
            (_, Some(install)) => Some(format!("install it with `{install}`")),
            (ToolError::TimedOut { .. }, None) => Some("give more time with --timeout".into()),
            (_, None) => Some("`hwgen doctor` shows whether the tool works at all".into()),
        };
        failure
    }
}
