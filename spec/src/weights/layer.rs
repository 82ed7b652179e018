//! Layers: matrices that fit each other, and numbers that fit their formats.

use nalgebra::DMatrix;

use super::{Front, MAX_NEURONS, MAX_WORD_BITS, MIN_WORD_BITS, check_count, check_length};
use crate::format::{FormatError, MAX_WIDTH, QFormat, Rounding};
use crate::json::{Fault, Node, nearest};
use crate::network::{Activation, FloatLayer, LayerFormat};

pub(super) const LAYER_KEYS: &[&str] = &["activation", "weights", "bias", "format"];
pub(super) const FORMAT_KEYS: &[&str] = &["weights", "bias", "activations"];

/// Reads a layer that follows `front`.
pub(super) fn read(node: Node<'_>, front: &Front) -> Result<FloatLayer, Fault> {
    let object = node.object()?;
    object.only(LAYER_KEYS)?;
    let activation = activation(object.required("activation", "\"tanh\"")?)?;
    let weights_node = object.required("weights", "[[...], ...], one row a neuron")?;
    let (weights, neurons) = matrix(weights_node, front)?;
    let bias_node = object.optional("bias");
    let bias = match bias_node {
        None => vec![0.0; neurons],
        Some(node) => bias(node, neurons)?,
    };
    let format = match object.optional("format") {
        None => LayerFormat::default(),
        Some(node) => layer_format(node)?,
    };
    if let Some(format) = format.weights
        && let Some(i) = stray(&weights, format)
    {
        let row = weights_node.array()?[i / front.width];
        let node = row.array()?[i % front.width];
        return Err(not_a_code(node, format, weights[i]));
    }
    if let Some((format, node)) = format.bias.zip(bias_node)
        && let Some(i) = stray(&bias, format)
    {
        return Err(not_a_code(node.array()?[i], format, bias[i]));
    }
    Ok(FloatLayer {
        activation,
        weights: DMatrix::from_row_slice(neurons, front.width, &weights),
        bias,
        format,
    })
}

fn activation(node: Node<'_>) -> Result<Activation, Fault> {
    // What is no string is no activation either, and the list says more than its type.
    let text = node.string().unwrap_or_default();
    if let Some(known) = Activation::ALL.into_iter().find(|a| a.name() == text) {
        return Ok(known);
    }
    let names = Activation::ALL.map(Activation::name);
    let fault = node.fault(
        "unknown-activation",
        format!(
            "one of {} expected, {} found",
            names.join(", "),
            node.excerpt()
        ),
    );
    Err(match nearest(&text, &names) {
        Some(near) => fault.help(format!("did you mean \"{near}\"?")),
        None => fault.help("the generator has no hardware for other functions"),
    })
}

/// Weights in row order, and the number of rows.
fn matrix(node: Node<'_>, front: &Front) -> Result<(Vec<f64>, usize), Fault> {
    let rows = node.array()?;
    check_count(node, "rows (one a neuron)", rows.len(), 1..=MAX_NEURONS)?;
    let mut weights = Vec::new();
    let mut lengths = Vec::with_capacity(rows.len());
    for row in &rows {
        let values = row.numbers().map_err(|fault| {
            if fault.code == "wrong-type" && fault.path == row.path() {
                fault.help("weights are a list of rows [out][in], one row a neuron")
            } else {
                fault
            }
        })?;
        lengths.push(values.len());
        weights.extend(values);
    }
    let Some(odd) = lengths.iter().position(|length| *length != front.width) else {
        return Ok((weights, rows.len()));
    };
    let (expected, each) = (front.width, &front.each);
    if lengths.iter().any(|length| *length != lengths[0]) {
        let found = lengths[odd];
        let message = format!("{expected} values expected, one for each {each}, {found} found");
        return Err(rows[odd]
            .fault("ragged-matrix", message)
            .help("a row holds the weights of one neuron; all rows are equally long"));
    }
    let fault = node.fault(
        "layer-inputs",
        format!(
            "{} values expected for [{}][{expected}], {} found: rows of {}",
            rows.len() * expected,
            rows.len(),
            weights.len(),
            lengths[0]
        ),
    );
    let rule = format!("a row has one weight for each {each}, that is {expected}");
    Err(if rows.len() == expected {
        fault.help(format!("{rule}; the matrix looks transposed"))
    } else {
        fault.help(rule)
    })
}

fn bias(node: Node<'_>, neurons: usize) -> Result<Vec<f64>, Fault> {
    let values = node.numbers()?;
    check_length(
        node,
        "value",
        values.len(),
        neurons,
        "one for each row of weights",
    )?;
    Ok(values)
}

fn layer_format(node: Node<'_>) -> Result<LayerFormat, Fault> {
    let object = node.object()?;
    object.only(FORMAT_KEYS)?;
    let field = |key: &str, narrowest: u32, widest: u32| {
        let node = object.optional(key);
        node.map(|node| q_format(node, narrowest, widest))
            .transpose()
    };
    Ok(LayerFormat {
        weights: field("weights", MIN_WORD_BITS, MAX_WORD_BITS)?,
        bias: field("bias", 1, MAX_WIDTH)?,
        activations: field("activations", MIN_WORD_BITS, MAX_WORD_BITS)?,
    })
}

fn q_format(node: Node<'_>, narrowest: u32, widest: u32) -> Result<QFormat, Fault> {
    let text = node.string()?;
    let width = match text.parse::<QFormat>() {
        Ok(format) if !(narrowest..=widest).contains(&format.width()) => i64::from(format.width()),
        // `Q03.+12` and the like have another spelling.
        Ok(format) if format.to_string() == text => return Ok(format),
        // The width is in range, so the fraction was not.
        Err(FormatError::Width(width)) if !(1..=i64::from(MAX_WIDTH)).contains(&width) => width,
        Ok(_) | Err(_) => {
            let message = format!(
                "a format Qm.n such as \"Q3.12\" expected, n from -1000 to 1000, {} found",
                node.excerpt()
            );
            return Err(node.fault("bad-format", message).help(
                "Qm.n is a signed word of 1 + m + n bits, n of them behind the binary point",
            ));
        }
    };
    let message = format!("a word of {narrowest} to {widest} bits expected, {width} found");
    Err(node.fault("format-width", message).help(format!(
        "the width of {text} is 1 + m + n; choose another m or n"
    )))
}

/// Index of the first number that is no code of a format.
fn stray(values: &[f64], format: QFormat) -> Option<usize> {
    values
        .iter()
        .position(|value| format.exact_code(*value).is_none())
}

fn not_a_code(node: Node<'_>, format: QFormat, value: f64) -> Fault {
    let (low, high) = (
        number_text(format, format.min_code()),
        number_text(format, format.max_code()),
    );
    let nearest = format.quantize(value, Rounding::HalfUp);
    let fault = if nearest.clipped {
        node.fault(
            "out-of-range",
            format!(
                "{low} to {high} expected for {format}, {} found",
                node.excerpt()
            ),
        )
    } else {
        let step = -i64::from(format.fraction());
        node.fault(
            "not-a-multiple",
            format!(
                "a multiple of 2^{step} expected for {format}, {} found",
                node.excerpt()
            ),
        )
    };
    let near = number_text(format, nearest.code);
    fault.help(format!(
        "the nearest number of {format} is {near}; \
         without `format` the numbers are floats and the quantizer rounds them"
    ))
}

/// The number that a code stands for, in the digits that a weights file would have.
fn number_text(format: QFormat, code: i64) -> String {
    let value = format.to_f64(code);
    let text = value.to_string();
    if text.len() <= 24 {
        text
    } else {
        format!("{value:e}")
    }
}
