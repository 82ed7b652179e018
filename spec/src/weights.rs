//! The weights file `hwgen-weights/1`: what a trainer hands to the generator.
//!
//! [`read`] takes a file's bytes and gives a [`FloatNet`] that keeps every promise of its fields,
//! or the first error with its place. Nothing is repaired: what is refused has to be mended.
//! [`to_json`] writes a file, [`SCHEMA`] describes it to other tools.
//!
//! Optional are `inputs.names` (default `in0`, `in1`, ...), `inputs.unit`, `inputs.offset` (0),
//! `inputs.scale` (1), `inputs.resolution`, `shared`, `outputs` and each of its fields (names
//! `out0`, ..., scale 1, offset 0), `bias` (0), `format` and each of its fields, `calibration` and
//! its `note`.
//!
//! # Format
//! Words of `format.weights` and `format.activations` have [`MIN_WORD_BITS`] to [`MAX_WORD_BITS`]
//! bits, those of `format.bias` up to [`format::MAX_WIDTH`](crate::format::MAX_WIDTH).
//!
//! ```
//! let net = hwgen_spec::weights::read(br#"{
//!     "format": "hwgen-weights/1",
//!     "name": "sum",
//!     "inputs": {"min": [-1, -1], "max": [1, 1]},
//!     "networks": [{"name": "add", "layers": [{"activation": "linear", "weights": [[1, 1]]}]}]
//! }"#)?;
//! assert_eq!(net.forward(&[0.25, 0.5]), [0.75]);
//! assert_eq!(net.output_columns(), ["add.out0"]);
//! # Ok::<(), hwgen_spec::weights::WeightsError>(())
//! ```

use std::ops::RangeInclusive;

use crate::json::{self, Fault, Node, Object};
use crate::network::{Calibration, FloatLayer, FloatNet, Inputs, Network, Outputs};

mod layer;
mod name;
mod write;

pub use name::check_name;
pub use write::to_json;

/// What stands under `format` in a file of this version.
pub const FORMAT: &str = "hwgen-weights/1";

/// The format as a JSON Schema, draft 2020-12.
///
/// A file that the schema refuses is refused by [`read`]; what a schema cannot say (matching
/// lengths, exact multiples, keywords) is refused by [`read`] only.
pub const SCHEMA: &str = include_str!("weights.schema.json");

/// Longest file, in bytes: 64 MiB.
pub const MAX_BYTES: usize = 64 << 20;

/// Deepest nesting of arrays and objects.
pub const MAX_DEPTH: usize = 32;

/// Most inputs of a file, and most neurons of a layer.
pub const MAX_NEURONS: usize = 4096;

/// Most layers in a row, the shared ones and a network's own together.
pub const MAX_LAYERS: usize = 64;

/// Most networks in a file.
pub const MAX_NETWORKS: usize = 64;

/// Longest unit, in characters.
pub const MAX_UNIT_CHARS: usize = 32;

/// Most frames of calibration.
pub const MAX_FRAMES: usize = 4096;

/// Longest note, in characters.
pub const MAX_NOTE_CHARS: usize = 1000;

/// Narrowest word of weights and activations that a layer's `format` may fix.
pub const MIN_WORD_BITS: u32 = 2;

/// Widest word of weights and activations that a layer's `format` may fix.
pub const MAX_WORD_BITS: u32 = 24;

const LIMITS: json::Limits = json::Limits {
    bytes: MAX_BYTES,
    depth: MAX_DEPTH,
};

const ROOT_KEYS: &[&str] = &[
    "format",
    "name",
    "inputs",
    "shared",
    "networks",
    "calibration",
];
const INPUT_KEYS: &[&str] = &[
    "names",
    "unit",
    "min",
    "max",
    "offset",
    "scale",
    "resolution",
];
const NETWORK_KEYS: &[&str] = &["name", "layers", "outputs"];
const OUTPUT_KEYS: &[&str] = &["names", "unit", "scale", "offset"];
const CALIBRATION_KEYS: &[&str] = &["inputs", "note"];

/// Why a weights file was refused, and where it has to be mended.
///
/// Displayed as `<path>: <what was expected>, <what was found>`.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(transparent)]
pub struct WeightsError(#[from] Fault);

impl WeightsError {
    /// Short stable name of the kind of error, such as `ragged-matrix`.
    pub fn code(&self) -> &'static str {
        self.0.code
    }

    /// What was expected and what was found, without the path.
    pub fn message(&self) -> &str {
        &self.0.message
    }

    /// JSON path such as `networks[0].layers[1].weights[2][7]`; empty at the root.
    pub fn path(&self) -> &str {
        &self.0.path
    }

    /// Line, from 1.
    pub fn line(&self) -> usize {
        self.0.line
    }

    /// Column in characters, from 1.
    pub fn column(&self) -> usize {
        self.0.column
    }

    /// How to mend it.
    pub fn help(&self) -> Option<&str> {
        self.0.help.as_deref()
    }

    /// The error as the command line prints it, without a newline at the end.
    ///
    /// `error: <file>:<line>:<column>: <path>: <expected>, <found>` and, if there is one,
    /// a second line `help: ...`.
    pub fn render(&self, file: &str) -> String {
        let mut text = format!("error: {file}:{}:{}: {self}", self.line(), self.column());
        if let Some(help) = self.help() {
            text.push_str("\nhelp: ");
            text.push_str(help);
        }
        text
    }
}

/// Reads a weights file.
///
/// # Errors
/// The first [`WeightsError`] found: limits and encoding, then syntax, then the content.
pub fn read(text: &[u8]) -> Result<FloatNet, WeightsError> {
    Ok(net(json::parse(text, LIMITS)?)?)
}

fn net(root: Node<'_>) -> Result<FloatNet, Fault> {
    let root = root.object()?;
    // The version comes first: without it, or with another one, other keys may be right.
    if !root.misspells("format") {
        version(root.required("format", "\"hwgen-weights/1\"")?)?;
    }
    root.only(ROOT_KEYS)?;
    let name = name::design(root.required("name", "\"my_design\"")?)?;
    let inputs = inputs(
        &root
            .required("inputs", "{\"min\": [...], \"max\": [...]}")?
            .object()?,
    )?;

    let mut front = Front {
        width: inputs.min.len(),
        each: "input".to_owned(),
    };
    let shared_nodes = match root.optional("shared") {
        Some(node) => counted(node, "shared layers", 0..=MAX_LAYERS - 1)?,
        None => Vec::new(),
    };
    let shared = layers(&shared_nodes, &mut front)?;
    let network_nodes = counted(
        root.required("networks", "[{\"name\": ..., \"layers\": [...]}]")?,
        "networks",
        1..=MAX_NETWORKS,
    )?;
    let mut names: Vec<(String, Node<'_>)> = Vec::with_capacity(network_nodes.len());
    let mut networks = Vec::with_capacity(network_nodes.len());
    for node in network_nodes {
        networks.push(network(node, &front, shared.len(), &mut names)?);
    }
    let calibration = match root.optional("calibration") {
        None => None,
        Some(node) => Some(calibration(&node.object()?, inputs.min.len())?),
    };
    Ok(FloatNet {
        name,
        inputs,
        shared,
        networks,
        calibration,
    })
}

fn version(node: Node<'_>) -> Result<(), Fault> {
    if node.string().is_ok_and(|version| version == FORMAT) {
        return Ok(());
    }
    let fault = node.fault(
        "wrong-version",
        format!("\"{FORMAT}\" expected, {} found", node.excerpt()),
    );
    Err(fault.help("this is no weights file, or one of a version that this program cannot read"))
}

/// What the next layer reads.
#[derive(Clone)]
struct Front {
    /// Number of values.
    width: usize,
    /// What one of them is: `input`, or `neuron of networks[0].layers[0]`.
    each: String,
}

fn layers(nodes: &[Node<'_>], front: &mut Front) -> Result<Vec<FloatLayer>, Fault> {
    let mut layers = Vec::with_capacity(nodes.len());
    for node in nodes {
        let layer = layer::read(*node, front)?;
        *front = Front {
            width: layer.outputs(),
            each: format!("neuron of {}", node.path()),
        };
        layers.push(layer);
    }
    Ok(layers)
}

fn network<'a>(
    node: Node<'a>,
    front: &Front,
    shared: usize,
    names: &mut Vec<(String, Node<'a>)>,
) -> Result<Network, Fault> {
    let object = node.object()?;
    object.only(NETWORK_KEYS)?;
    let name = name::network(object.required("name", "\"my_network\"")?, names)?;
    let most = MAX_LAYERS - shared;
    let layer_nodes = counted(
        object.required("layers", "[{\"activation\": ..., \"weights\": [...]}]")?,
        "layers",
        1..=most,
    )?;
    let mut front = front.clone();
    let layers = layers(&layer_nodes, &mut front)?;
    let outputs = outputs(object.optional("outputs"), &front)?;
    Ok(Network {
        name,
        layers,
        outputs,
    })
}

fn inputs(object: &Object<'_>) -> Result<Inputs, Fault> {
    object.only(INPUT_KEYS)?;
    let min_node = object.required("min", "[...], the lower edge of each raw input")?;
    let max_node = object.required("max", "[...], the upper edge of each raw input")?;
    let min = min_node.numbers()?;
    let count = min.len();
    check_count(min_node, "inputs", count, 1..=MAX_NEURONS)?;
    let because = "as many as in inputs.min";
    let max = list(max_node, count, because)?;
    if let Some(i) = (0..count).find(|i| min[*i] > max[*i]) {
        let fault = min_node.array()?[i].fault(
            "min-above-max",
            format!(
                "at most inputs.max[{i}] = {} expected, {} found",
                max[i], min[i]
            ),
        );
        return Err(fault.help("min and max are the lower and upper edge of the raw input"));
    }
    let resolution = match object.optional("resolution") {
        None => None,
        Some(node) => Some(resolution(node)?),
    };
    Ok(Inputs {
        names: name::ports(object.optional("names"), "in", count, because)?,
        unit: unit(object)?,
        offset: list_or(object.optional("offset"), 0.0, count, because)?,
        scale: scale(object, count, because)?,
        resolution,
        min,
        max,
    })
}

fn outputs(node: Option<Node<'_>>, front: &Front) -> Result<Outputs, Fault> {
    let count = front.width;
    let because = format!("one for each {}", front.each);
    let Some(node) = node else {
        return Ok(Outputs {
            names: name::ports(None, "out", count, &because)?,
            unit: String::new(),
            scale: vec![1.0; count],
            offset: vec![0.0; count],
        });
    };
    let object = node.object()?;
    object.only(OUTPUT_KEYS)?;
    Ok(Outputs {
        names: name::ports(object.optional("names"), "out", count, &because)?,
        unit: unit(&object)?,
        scale: scale(&object, count, &because)?,
        offset: list_or(object.optional("offset"), 0.0, count, &because)?,
    })
}

fn calibration(object: &Object<'_>, count: usize) -> Result<Calibration, Fault> {
    object.only(CALIBRATION_KEYS)?;
    let frames = object.required("inputs", "[[...], ...], one row of raw inputs a frame")?;
    let rows = counted(frames, "frames", 1..=MAX_FRAMES).map_err(|fault| match fault.code {
        "too-many" => fault.help("keep some hundred of them, spread over all that occurs"),
        "empty" => fault.help("leave the calibration out if there are no frames"),
        _ => fault,
    })?;
    let row = |node: Node<'_>| {
        list(node, count, "as many as in inputs.min").map_err(|fault| match fault.code {
            "wrong-length" => fault.help("a row holds the raw inputs of one frame"),
            _ => fault,
        })
    };
    Ok(Calibration {
        inputs: rows.into_iter().map(row).collect::<Result<_, _>>()?,
        note: note(object)?,
    })
}

fn note(object: &Object<'_>) -> Result<String, Fault> {
    let Some(node) = object.optional("note") else {
        return Ok(String::new());
    };
    let note = node.string()?;
    if note.chars().count() <= MAX_NOTE_CHARS && !note.chars().any(char::is_control) {
        return Ok(note);
    }
    let message = format!(
        "at most {MAX_NOTE_CHARS} characters without control characters expected, {} found",
        node.excerpt()
    );
    Err(node
        .fault("bad-note", message)
        .help("the note says in a line where the frames come from"))
}

fn resolution(node: Node<'_>) -> Result<f64, Fault> {
    let value = node.number()?;
    if value > 0.0 {
        return Ok(value);
    }
    let message = format!("a step above 0 expected, {} found", node.excerpt());
    Err(node
        .fault("bad-resolution", message)
        .help("give the least raw step that matters, or leave the key out"))
}

fn scale(object: &Object<'_>, count: usize, because: &str) -> Result<Vec<f64>, Fault> {
    let node = object.optional("scale");
    let scale = list_or(node, 1.0, count, because)?;
    let zero = scale.iter().position(|s| *s == 0.0);
    match node.zip(zero) {
        None => Ok(scale),
        Some((node, i)) => Err(node.array()?[i]
            .fault("zero-scale", "a factor other than 0 expected, 0 found")
            .help("a factor of 0 cuts the value off; remove the input or output instead")),
    }
}

fn unit(object: &Object<'_>) -> Result<String, Fault> {
    let Some(node) = object.optional("unit") else {
        return Ok(String::new());
    };
    let unit = node.string()?;
    if unit.chars().count() <= MAX_UNIT_CHARS && !unit.chars().any(char::is_control) {
        return Ok(unit);
    }
    let message = format!(
        "at most {MAX_UNIT_CHARS} characters without control characters expected, {} found",
        node.excerpt()
    );
    Err(node
        .fault("bad-unit", message)
        .help("the unit is for people, such as \"px\" or \"rad\""))
}

fn list_or(
    node: Option<Node<'_>>,
    default: f64,
    count: usize,
    because: &str,
) -> Result<Vec<f64>, Fault> {
    match node {
        None => Ok(vec![default; count]),
        Some(node) => list(node, count, because),
    }
}

fn list(node: Node<'_>, count: usize, because: &str) -> Result<Vec<f64>, Fault> {
    let values = node.numbers()?;
    check_length(node, "value", values.len(), count, because)?;
    Ok(values)
}

fn check_length(
    node: Node<'_>,
    noun: &str,
    found: usize,
    expected: usize,
    because: &str,
) -> Result<(), Fault> {
    if found == expected {
        return Ok(());
    }
    let plural = if expected == 1 { "" } else { "s" };
    Err(node.fault(
        "wrong-length",
        format!("{expected} {noun}{plural} expected, {because}, {found} found"),
    ))
}

/// The elements of an array whose number must lie in a range.
fn counted<'a>(
    node: Node<'a>,
    noun: &str,
    range: RangeInclusive<usize>,
) -> Result<Vec<Node<'a>>, Fault> {
    let elements = node.array()?;
    check_count(node, noun, elements.len(), range)?;
    Ok(elements)
}

fn check_count(
    node: Node<'_>,
    noun: &str,
    found: usize,
    range: RangeInclusive<usize>,
) -> Result<(), Fault> {
    if range.contains(&found) {
        return Ok(());
    }
    let (code, found) = match found {
        0 => ("empty", "none".to_owned()),
        n => ("too-many", n.to_string()),
    };
    Err(node.fault(
        code,
        format!(
            "{} to {} {noun} expected, {found} found",
            range.start(),
            range.end()
        ),
    ))
}

#[cfg(test)]
mod tests {
    use super::layer::{FORMAT_KEYS, LAYER_KEYS};
    use super::*;
    use serde_json::Value;

    fn keys(object: &Value) -> Vec<&str> {
        let mut keys: Vec<_> = object.as_object().unwrap().keys().map(|k| &**k).collect();
        keys.sort_unstable();
        keys
    }

    #[test]
    fn the_schema_knows_the_keys_and_limits_of_the_reader() {
        let schema: Value = serde_json::from_str(SCHEMA).unwrap();
        let defs = &schema["$defs"];
        for (object, known) in [
            (&schema, ROOT_KEYS),
            (&defs["inputs"], INPUT_KEYS),
            (&defs["network"], NETWORK_KEYS),
            (&defs["outputs"], OUTPUT_KEYS),
            (&defs["layer"], LAYER_KEYS),
            (&defs["format"], FORMAT_KEYS),
            (&defs["calibration"], CALIBRATION_KEYS),
        ] {
            let mut known = known.to_vec();
            known.sort_unstable();
            assert_eq!(keys(&object["properties"]), known);
            assert_eq!(object["additionalProperties"], false);
        }
        assert_eq!(schema["properties"]["format"]["const"], FORMAT);
        assert_eq!(schema["properties"]["networks"]["maxItems"], MAX_NETWORKS);
        let layers = &defs["network"]["properties"]["layers"];
        assert_eq!(layers["maxItems"], MAX_LAYERS);
        assert_eq!(defs["numbers"]["maxItems"], MAX_NEURONS);
        assert_eq!(defs["unit"]["maxLength"], MAX_UNIT_CHARS);
        let calibration = &defs["calibration"]["properties"];
        assert_eq!(calibration["inputs"]["maxItems"], MAX_FRAMES);
        assert_eq!(calibration["note"]["maxLength"], MAX_NOTE_CHARS);
        let activations = crate::network::Activation::ALL.map(|a| a.name());
        assert_eq!(
            defs["layer"]["properties"]["activation"]["enum"],
            Value::from(activations.to_vec())
        );
    }
}
