//! `hwgen schema`

use hwgen_spec::weights::SCHEMA;
use serde_json::{Map, Value};

use super::Outcome;
use crate::failure::{Exit, Failure};

const EXAMPLES: &str = "\
Examples:
  hwgen schema > hwgen-weights.schema.json";

/// What `schema` takes.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {}

/// Prints the schema of the weights file.
///
/// # Errors
/// None, unless the schema itself is broken.
pub fn run(_: &Args) -> Result<Outcome, Failure> {
    let schema: Value = serde_json::from_str(SCHEMA)
        .map_err(|e| Failure::new(Exit::Difference, "schema", e.to_string()))?;
    Ok(Outcome {
        text: format!("{}\n", SCHEMA.trim_end()),
        json: Map::from_iter([("schema".to_owned(), schema)]),
        ..Outcome::default()
    })
}
