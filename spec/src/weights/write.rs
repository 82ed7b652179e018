//! Writing a weights file.

use std::fmt::Write as _;

use serde_json::to_string;

use super::FORMAT;
use crate::network::{Calibration, FloatLayer, FloatNet, Inputs, Network, Outputs};

/// Writes a network as a weights file, one matrix row and one frame a line.
///
/// Numbers are the shortest decimals that read back as the same doubles, so that
/// `read(to_json(net).as_bytes())` gives `net` again.
/// A net that breaks a rule of the format, such as a NaN, gives a text that
/// [`read`](super::read) refuses.
pub fn to_json(net: &FloatNet) -> String {
    let mut text = String::new();
    put(&mut text, 0, "{");
    put(&mut text, 1, &format!("\"format\": {},", quoted(FORMAT)));
    put(&mut text, 1, &format!("\"name\": {},", quoted(&net.name)));
    put_inputs(&mut text, &net.inputs);
    if !net.shared.is_empty() {
        put_layers(&mut text, 1, "shared", &net.shared);
    }
    put(&mut text, 1, "\"networks\": [");
    for (i, network) in net.networks.iter().enumerate() {
        put_network(&mut text, network);
        let comma = comma(i, net.networks.len());
        put(&mut text, 2, &format!("}}{comma}"));
    }
    match &net.calibration {
        None => put(&mut text, 1, "]"),
        Some(calibration) => {
            put(&mut text, 1, "],");
            put_calibration(&mut text, calibration);
        }
    }
    put(&mut text, 0, "}");
    text
}

fn put_inputs(text: &mut String, inputs: &Inputs) {
    put(text, 1, "\"inputs\": {");
    put(text, 2, &format!("\"names\": {},", names(&inputs.names)));
    put(text, 2, &format!("\"unit\": {},", quoted(&inputs.unit)));
    put(text, 2, &format!("\"min\": {},", numbers(&inputs.min)));
    put(text, 2, &format!("\"max\": {},", numbers(&inputs.max)));
    put(
        text,
        2,
        &format!("\"offset\": {},", numbers(&inputs.offset)),
    );
    match inputs.resolution {
        None => put(text, 2, &format!("\"scale\": {}", numbers(&inputs.scale))),
        Some(resolution) => {
            put(text, 2, &format!("\"scale\": {},", numbers(&inputs.scale)));
            put(text, 2, &format!("\"resolution\": {resolution:?}"));
        }
    }
    put(text, 1, "},");
}

fn put_calibration(text: &mut String, calibration: &Calibration) {
    let Calibration { inputs, note } = calibration;
    put(text, 1, "\"calibration\": {");
    put(text, 2, "\"inputs\": [");
    for (i, row) in inputs.iter().enumerate() {
        put(
            text,
            3,
            &format!("{}{}", numbers(row), comma(i, inputs.len())),
        );
    }
    if note.is_empty() {
        put(text, 2, "]");
    } else {
        put(text, 2, "],");
        put(text, 2, &format!("\"note\": {}", quoted(note)));
    }
    put(text, 1, "}");
}

fn put_network(text: &mut String, network: &Network) {
    let Outputs {
        names: output_names,
        unit,
        scale,
        offset,
    } = &network.outputs;
    put(text, 2, "{");
    put(text, 3, &format!("\"name\": {},", quoted(&network.name)));
    put_layers(text, 3, "layers", &network.layers);
    put(text, 3, "\"outputs\": {");
    put(text, 4, &format!("\"names\": {},", names(output_names)));
    put(text, 4, &format!("\"unit\": {},", quoted(unit)));
    put(text, 4, &format!("\"scale\": {},", numbers(scale)));
    put(text, 4, &format!("\"offset\": {}", numbers(offset)));
    put(text, 3, "}");
}

/// A list of layers under a key, with a comma behind it.
fn put_layers(text: &mut String, depth: usize, key: &str, layers: &[FloatLayer]) {
    put(text, depth, &format!("\"{key}\": ["));
    for (i, layer) in layers.iter().enumerate() {
        put(text, depth + 1, "{");
        put_layer(text, depth + 2, layer);
        let comma = comma(i, layers.len());
        put(text, depth + 1, &format!("}}{comma}"));
    }
    put(text, depth, "],");
}

fn put_layer(text: &mut String, depth: usize, layer: &FloatLayer) {
    let activation = quoted(layer.activation.name());
    put(text, depth, &format!("\"activation\": {activation},"));
    put(text, depth, "\"weights\": [");
    for (i, row) in layer.weights.row_iter().enumerate() {
        let comma = comma(i, layer.weights.nrows());
        put(text, depth + 1, &format!("{}{comma}", numbers(row.iter())));
    }
    put(text, depth, "],");
    let format: Vec<String> = [
        ("weights", layer.format.weights),
        ("bias", layer.format.bias),
        ("activations", layer.format.activations),
    ]
    .into_iter()
    .filter_map(|(key, format)| format.map(|format| format!("\"{key}\": \"{format}\"")))
    .collect();
    if format.is_empty() {
        put(text, depth, &format!("\"bias\": {}", numbers(&layer.bias)));
    } else {
        put(text, depth, &format!("\"bias\": {},", numbers(&layer.bias)));
        put(
            text,
            depth,
            &format!("\"format\": {{{}}}", format.join(", ")),
        );
    }
}

/// What stands between elements: nothing behind the last of `count`.
fn comma(index: usize, count: usize) -> &'static str {
    if index + 1 == count { "" } else { "," }
}

fn put(text: &mut String, depth: usize, line: &str) {
    writeln!(text, "{:1$}{line}", "", 2 * depth).expect("a String takes all that is written");
}

fn numbers<'a>(values: impl IntoIterator<Item = &'a f64>) -> String {
    let values: Vec<String> = values.into_iter().map(|v| format!("{v:?}")).collect();
    format!("[{}]", values.join(", "))
}

fn names(names: &[String]) -> String {
    let names: Vec<String> = names.iter().map(|name| quoted(name)).collect();
    format!("[{}]", names.join(", "))
}

fn quoted(text: &str) -> String {
    to_string(text).expect("a string is always JSON")
}
