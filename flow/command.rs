//! One module a command.

pub mod demo;
pub mod doctor;
pub mod emit;
pub mod estimate;
pub mod evaluate;
mod request;
pub mod run;
pub mod sample;
pub mod schema;
mod sites;
pub mod synth;
pub mod train;
pub mod verify;

use serde::Serialize;
use serde_json::{Map, Value};

use crate::failure::Failure;

/// What a command has to tell.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// For people, on standard output.
    pub text: String,
    /// For programs, beside `command` and `ok`.
    pub json: Map<String, Value>,
    /// For people, on standard error.
    pub remarks: Vec<String>,
    /// Why the exit code is not 0, if it isn't.
    pub failure: Option<Failure>,
}

impl Outcome {
    /// Nothing but a failure.
    pub fn failed(failure: Failure) -> Self {
        Self {
            failure: Some(failure),
            ..Self::default()
        }
    }
}

/// The fields of plain data as a JSON object.
pub(crate) fn fields(data: &impl Serialize) -> Map<String, Value> {
    match serde_json::to_value(data) {
        Ok(Value::Object(map)) => map,
        other => unreachable!("plain data of named fields expected, {other:?} found"),
    }
}
