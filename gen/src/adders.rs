//! The module that takes the place of an array: shifts and adders.

use askama::Template;
use hwgen_spec::adders::{Adder, Adders, Source, Term};
use hwgen_spec::design::Layer;

use crate::bundle::File;
use crate::text::finish;
use crate::{Header, bits, plural, range};

#[derive(Template)]
#[template(path = "adders.v", syntax = "verilog")]
struct AddersContext<'a> {
    module: &'a str,
    prefix: &'a str,
    layer: &'a str,
    provenance: String,
    x_format: String,
    w_format: String,
    shift_note: &'static str,
    levels: usize,
    levels_s: &'static str,
    adders_s: &'static str,
    vector_range: String,
    sums_range: String,
    sum_width: usize,
    word_range: String,
    word_width: usize,
    inputs: Vec<Input>,
    adders: Vec<AdderContext>,
    waits: Vec<Wait>,
    sums: Vec<Sum>,
}

/// A word of the vector.
struct Input {
    name: String,
    low: usize,
}

struct AdderContext {
    number: usize,
    name: String,
    range: String,
    width: u32,
    note: String,
    subtract: u32,
    a: Operand,
    b: Operand,
}

struct Operand {
    name: String,
    width: u32,
    shift: u32,
}

/// A register in which a word waits.
struct Wait {
    /// With spaces behind, as long as the longest.
    name: String,
    range: String,
    width: u32,
    source: String,
}

struct Sum {
    low: usize,
    value: String,
}

/// Name of a word so many clocks after it came.
fn word(source: Source, age: usize) -> String {
    let name = match source {
        Source::Input(i) => format!("x{i}"),
        Source::Adder(k) => format!("sum{k}"),
    };
    match age {
        0 => name,
        1 => format!("{name}_q"),
        _ => format!("{name}_q{age}"),
    }
}

/// A weighted sum as it is written by hand.
fn expression(weights: &[i64]) -> String {
    let mut text = String::new();
    // A positive term first.
    let terms = weights.iter().enumerate().filter(|(_, w)| **w != 0);
    let (plus, minus): (Vec<_>, Vec<_>) = terms.partition(|(_, w)| **w > 0);
    for (i, weight) in plus.into_iter().chain(minus) {
        let sign = match (text.is_empty(), *weight > 0) {
            (true, true) => "",
            (true, false) => "-",
            (false, true) => " + ",
            (false, false) => " - ",
        };
        let factor = match weight.unsigned_abs() {
            1 => String::new(),
            other => format!("{other} "),
        };
        text += &format!("{sign}{factor}x{i}");
    }
    text
}

pub(crate) fn file(module: &str, layer: &Layer, adders: &Adders, header: &Header) -> File {
    let quant = &layer.quant;
    let (x, sum_width) = (quant.input.width(), bits(quant.sum_width));
    let level = |source: Source| match source {
        Source::Input(_) => 0,
        Source::Adder(k) => adders.adders[k].level,
    };
    let width = |source: Source| match source {
        Source::Input(_) => x,
        Source::Adder(k) => adders.adders[k].width,
    };
    let operand = |adder: &Adder, term: Option<Term>| match term {
        Some(term) => Operand {
            name: word(term.source, adder.level - 1 - level(term.source)),
            width: width(term.source),
            shift: term.shift,
        },
        None => Operand {
            name: "2'b0".into(),
            width: 2,
            shift: 0,
        },
    };
    let waiting = |source: Source, clocks: usize| {
        (1..=clocks).map(move |age| Wait {
            name: word(source, age),
            range: range(bits(width(source))),
            width: width(source),
            source: word(source, age - 1),
        })
    };
    let inputs = adders.input_waits.iter().enumerate();
    let sums = adders.adder_waits.iter().enumerate();
    let mut waits: Vec<Wait> = inputs
        .flat_map(|(i, clocks)| waiting(Source::Input(i), *clocks))
        .chain(sums.flat_map(|(k, clocks)| waiting(Source::Adder(k), *clocks)))
        .collect();
    let longest = waits.iter().map(|wait| wait.name.len()).max();
    for wait in &mut waits {
        wait.name = format!("{:<1$}", wait.name, longest.unwrap_or(0));
    }
    let read = |i: usize| quant.weights.iter().any(|row| row[i] != 0);
    let value = |term: &Option<Term>| {
        let Some(term) = term else {
            return format!("{sum_width}'d0");
        };
        let name = word(term.source, adders.levels - level(term.source));
        let top = bits(width(term.source)) - 1;
        let signs = sum_width - top - bits(term.shift);
        let zeros = match term.shift {
            0 => String::new(),
            places => format!(", {places}'d0"),
        };
        format!(
            "{{{{{signs}{{{name}[{top}]}}}}, {name}[{}:0]{zeros}}}",
            top - 1
        )
    };
    let context = AddersContext {
        module,
        prefix: header.prefix,
        layer: &quant.name,
        provenance: header.provenance(),
        x_format: quant.input.to_string(),
        w_format: quant.weight_format.to_string(),
        shift_note: if quant.max_extra_shift() > 0 {
            " (finer where a neuron has a shift of its own)"
        } else {
            ""
        },
        levels: adders.levels,
        levels_s: plural(adders.levels),
        adders_s: plural(adders.adders.len()),
        vector_range: range(quant.inputs() * bits(x)),
        sums_range: range(quant.outputs() * sum_width),
        sum_width,
        word_range: range(bits(x)),
        word_width: bits(x),
        inputs: (0..quant.inputs())
            .map(|i| Input {
                name: format!("{}x{i}", if read(i) { "" } else { "unused_" }),
                low: i * bits(x),
            })
            .collect(),
        adders: adders
            .adders
            .iter()
            .enumerate()
            .map(|(number, adder)| AdderContext {
                number,
                name: word(Source::Adder(number), 0),
                range: range(bits(adder.width)),
                width: adder.width,
                note: expression(&adder.weights),
                subtract: u32::from(adder.subtract),
                a: operand(adder, adder.a),
                b: operand(adder, Some(adder.b)),
            })
            .collect(),
        waits,
        sums: adders
            .outputs
            .iter()
            .enumerate()
            .map(|(n, term)| Sum {
                low: n * sum_width,
                value: value(term),
            })
            .collect(),
    };
    header.rtl(module, finish(context.render()))
}
