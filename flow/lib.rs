//! The `hwgen` command: arguments, files, what is printed, exit codes.
//!
//! It picks paths and prints; what is computed is computed by the crates `hwgen-spec`, `hwgen-gen`,
//! `hwgen-sim` and `hwgen-pose`. Results go to standard output, messages and progress to standard
//! error, and with `--json` standard output carries exactly one object.
//!
//! ```
//! use std::process::ExitCode;
//! let code = hwgen::run(["hwgen", "--quiet", "schema"].map(Into::into));
//! assert_eq!(format!("{code:?}"), format!("{:?}", ExitCode::SUCCESS));
//! ```

pub mod aside;
pub mod cache;
pub mod cli;
pub mod command;
pub mod destination;
pub mod deviation;
pub mod estimate;
pub mod failure;
pub mod fixed;
pub mod harness;
pub mod inference;
pub mod interrupt;
pub mod layout;
pub mod output;
pub mod picture;
pub mod scene;
pub mod synth;
pub mod table;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::Parser;
use clap::error::ErrorKind;
use serde_json::{Map, Value, json};

use cli::Cli;
use command::Outcome;
use failure::{Exit, Failure};
use output::Output;

/// Runs the command line and prints what came of it. The first argument is the program's name.
pub fn run(args: impl IntoIterator<Item = OsString>) -> ExitCode {
    let args: Vec<OsString> = args.into_iter().collect();
    let cli = match Cli::try_parse_from(&args) {
        Ok(cli) => cli,
        Err(error) => return refuse(&args, &error).into(),
    };
    let output = Output::new(&cli.global);
    let name = cli.command.name();
    let outcome = cli.command.run(&output).unwrap_or_else(Outcome::failed);
    report(&output, name, outcome).into()
}

/// Prints text and object, remarks and failure, and says how the process ends.
fn report(output: &Output, command: &str, outcome: Outcome) -> Exit {
    let exit = outcome.failure.as_ref().map_or(Exit::Done, |f| f.exit);
    let printed = if output.json() {
        let mut object = Map::new();
        object.insert("command".into(), command.into());
        object.insert("ok".into(), (exit == Exit::Done).into());
        object.extend(outcome.json);
        if let Some(failure) = &outcome.failure {
            put_error(&mut object, failure.to_json());
        }
        output.object(&Value::Object(object))
    } else {
        output.text(&outcome.text)
    };
    for remark in &outcome.remarks {
        output.remark(remark);
    }
    if let Some(failure) = &outcome.failure {
        output.failure(failure);
    }
    match printed {
        Ok(()) => exit,
        Err(error) => {
            let failure = Failure::input("output", error.to_string()).file("standard output");
            output.failure(&failure);
            failure.exit
        }
    }
}

/// Adds a failure; its fields stand beside the figures that a command has under the same key.
fn put_error(object: &mut Map<String, Value>, failure: Value) {
    match (object.get_mut("error"), failure) {
        (Some(Value::Object(figures)), Value::Object(failure)) => figures.extend(failure),
        (_, failure) => {
            object.insert("error".into(), failure);
        }
    }
}

/// Prints help, version or a usage error.
fn refuse(args: &[OsString], error: &clap::Error) -> Exit {
    let asked = matches!(
        error.kind(),
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion
    );
    let json = args.iter().any(|a| a == "--json");
    if json && !asked {
        let rendered = error.render().to_string();
        let usage = |line: &&str| !line.trim().is_empty() && !line.starts_with("Usage:");
        let lines: Vec<&str> = rendered
            .lines()
            .take_while(|l| !l.starts_with("Usage:"))
            .filter(usage)
            .map(str::trim)
            .collect();
        let message = lines.join(" ");
        let command = args.iter().skip(1).find_map(|a| {
            let name = a.to_str()?;
            cli::names().find(|known| known == name)
        });
        let help = match &command {
            Some(name) => format!("see `hwgen {name} --help`"),
            None => "see `hwgen --help`".into(),
        };
        let failure = Failure::input("usage", message.trim_start_matches("error: ")).help(help);
        let object = json!({
            "command": command.as_deref().unwrap_or("hwgen"),
            "ok": false,
            "error": failure.to_json(),
        });
        // Nobody is left to be told if this fails.
        let _ = Output::plain().object(&object);
    } else {
        let _ = error.print();
    }
    if asked { Exit::Done } else { Exit::Input }
}
