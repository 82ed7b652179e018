//! The top module, and what surrounds the RTL: bench, scripts, constraints.

use askama::Template;
use hwgen_spec::design::{Design, Port};
use hwgen_spec::format::QFormat;

use crate::bundle::File;
use crate::manifest::RESET_CONTRACT;
use crate::rom::literal;
use crate::stage::unit;
use crate::text::finish;
use crate::{Header, bits, range};

#[derive(Template)]
#[template(path = "top.v", syntax = "verilog")]
struct TopContext<'a> {
    module: &'a str,
    prefix: &'a str,
    purpose: String,
    provenance: String,
    x_format: String,
    x_width: usize,
    source_words: usize,
    source_lane: u32,
    source_per_beat: usize,
    source_beats: usize,
    source_notes: Vec<String>,
    source_range: String,
    sink_words: usize,
    sink_lane: u32,
    sink_eager: u32,
    sink_per_beat: usize,
    sink_beats: usize,
    sink_notes: Vec<String>,
    sink_range: String,
    user_range: String,
    box_range: String,
    out_range: String,
    low: Vec<String>,
    high: Vec<String>,
    latency: usize,
    interval: usize,
    reset_notes: Vec<String>,
}

#[derive(Template)]
#[template(path = "tb.v", syntax = "verilog")]
struct BenchContext<'a> {
    design: &'a str,
    s_data_bits: usize,
    m_data_bits: usize,
    m_user_bits: usize,
}

#[derive(Template)]
#[template(path = "tb_icarus.v", syntax = "verilog")]
struct IcarusBenchContext<'a> {
    design: &'a str,
}

#[derive(Template)]
#[template(path = "fusesoc.core", syntax = "verilog")]
struct CoreContext<'a> {
    module: &'a str,
    purpose: String,
    sources: Vec<&'a str>,
    models: Vec<&'a str>,
}

#[derive(Template)]
#[template(path = "generic/clock.sdc", syntax = "verilog")]
struct ClockContext<'a> {
    module: &'a str,
}

/// Bits of TUSER: saturated, frame error.
pub(crate) const USER_BITS: usize = 2;

fn purpose(design: &Design) -> String {
    let networks = &design.perceptron().networks;
    let names: Vec<&str> = networks.iter().map(|n| n.name.as_str()).collect();
    format!(
        "{} inputs to {} outputs through {} network{} ({})",
        design.source().words,
        design.sink().words,
        names.len(),
        crate::plural(names.len()),
        names.join(", ")
    )
}

/// `0 u0, 1 v0, ...` in lines that fit.
fn wrap(words: impl Iterator<Item = String>) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in words {
        let line = lines.last_mut().expect("there is a line");
        if !line.is_empty() && line.len() + word.len() > 78 {
            lines.push(word);
        } else {
            if !line.is_empty() {
                line.push_str(", ");
            }
            line.push_str(&word);
        }
    }
    lines
}

/// A sentence in lines that fit.
fn fill(sentence: &str) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in sentence.split_whitespace() {
        let line = lines.last_mut().expect("there is a line");
        if line.len() + word.len() > 90 {
            lines.push(word.to_owned());
        } else {
            if !line.is_empty() {
                line.push(' ');
            }
            line.push_str(word);
        }
    }
    lines
}

pub(crate) fn rtl(design: &Design, header: &Header) -> Vec<File> {
    let module = design.name();
    let (source, sink): (&Port, &Port) = (design.source(), design.sink());
    let format: QFormat = design.input().format;
    let width = bits(format.width());
    let bounds = |codes: &[i64]| -> Vec<String> {
        let last = codes.len() - 1;
        codes
            .iter()
            .enumerate()
            .rev()
            .map(|(i, code)| {
                let comma = if i == 0 { "" } else { "," };
                let word = literal(&[(*code, format.width())], width);
                format!(
                    "{word}{comma}  // {}: {}",
                    design.input_names()[i],
                    design.input().formats[i].to_f64(*code)
                )
            })
            .take(last + 1)
            .collect()
    };
    let outputs = design.perceptron().networks.iter().flat_map(|n| {
        let shape = format!("{}{}", n.last().quant.output, unit(&n.unit));
        n.output_names
            .iter()
            .map(move |o| format!("{}.{o} {shape}", n.name))
    });
    let one_format = design.input().formats.iter().all(|f| *f == format);
    let words = design.input_names().iter().zip(&design.input().formats);
    let inputs = words.map(|(name, format)| {
        if one_format {
            name.clone()
        } else {
            format!("{name} {format}")
        }
    });
    let context = TopContext {
        module,
        prefix: header.prefix,
        purpose: format!("{}.", purpose(design)),
        provenance: header.provenance(),
        x_format: if one_format {
            format!(" of {format}{}", unit(design.input_unit()))
        } else {
            unit(design.input_unit())
        },
        x_width: width,
        source_words: source.words,
        source_lane: source.lane_bits,
        source_per_beat: source.words_per_beat,
        source_beats: source.beats(),
        source_notes: wrap(inputs),
        source_range: range(source.data_bits()),
        sink_words: sink.words,
        sink_lane: sink.lane_bits,
        sink_eager: u32::from(design.sink_is_eager()),
        sink_per_beat: sink.words_per_beat,
        sink_beats: sink.beats(),
        sink_notes: wrap(outputs),
        sink_range: range(sink.data_bits()),
        user_range: range(USER_BITS),
        box_range: range(source.words * width),
        out_range: range(sink.words * bits(sink.lane_bits)),
        low: bounds(&design.input().low),
        high: bounds(&design.input().high),
        latency: design.latency_cycles(),
        reset_notes: fill(RESET_CONTRACT),
        interval: design.interval_cycles(),
    };
    vec![header.rtl(module, finish(context.render()))]
}

/// Bench, synthesis script, package description and clock constraint for the RTL files.
pub(crate) fn around(design: &Design, header: &Header, rtl: &[File], models: &[File]) -> Vec<File> {
    let name = header.design;
    let sources: Vec<&str> = rtl.iter().map(|f| f.path.as_str()).collect();
    let models: Vec<&str> = models.iter().map(|f| f.path.as_str()).collect();
    let bench = BenchContext {
        design: name,
        s_data_bits: design.source().data_bits(),
        m_data_bits: design.sink().data_bits(),
        m_user_bits: USER_BITS,
    };
    let core = CoreContext {
        module: name,
        purpose: purpose(design),
        sources: sources.clone(),
        models: models.clone(),
    };
    let file = |path: String, text: String| File { path, text };
    let mut files = vec![
        file(format!("tb/{name}_tb.v"), finish(bench.render())),
        file(
            format!("tb/{name}_tb_icarus.v"),
            finish(IcarusBenchContext { design: name }.render()),
        ),
        file(
            "tb/sim_main.cpp".into(),
            include_str!("../../rtl/tb/sim_main.cpp").to_owned(),
        ),
        file(format!("{name}.core"), finish(core.render())),
        file(
            format!("constraints/{name}.sdc"),
            finish(ClockContext { module: name }.render()),
        ),
    ];
    files.extend(crate::scripts::all(
        name,
        design.device(),
        &sources,
        &models,
    ));
    files
}
