//! The perceptron stage: layers, their gathering, the answers' queues.

use askama::Template;
use hwgen_spec::design::{Design, Layer, Perceptron};

use crate::bundle::File;
use crate::layer::{self, table_module};
use crate::rom;
use crate::text::finish;
use crate::{Header, address_width, bits, range};

#[derive(Template)]
#[template(path = "mlp.v", syntax = "verilog")]
struct StageContext<'a> {
    module: String,
    prefix: &'a str,
    provenance: String,
    shared_note: String,
    network_notes: Vec<String>,
    x_format: String,
    lane_bits: usize,
    latency: usize,
    interval: usize,
    credits: usize,
    fifo_depth: usize,
    frame_range: String,
    out_range: String,
    layers: Vec<LayerContext>,
    networks: Vec<NetworkContext>,
}

struct LayerContext {
    name: String,
    /// Wire that tells a clock ahead that a beat comes.
    next: String,
    module: String,
    note: String,
    inputs: usize,
    outputs: usize,
    activation: &'static str,
    whole: bool,
    gathered: bool,
    hop: bool,
    starts: usize,
    starts_range: String,
    lanes: usize,
    width: usize,
    words_range: String,
    vector_range: String,
    start: String,
    flag: String,
    vector: String,
}

struct NetworkContext {
    name: String,
    last: String,
    format: String,
    words: usize,
    width: usize,
    fifo_width: usize,
    /// Bits of the count of answers that wait.
    known_range: String,
    range: String,
    first: usize,
    signs: usize,
}

pub(crate) fn files(design: &Design, stage: &Perceptron, header: &Header) -> Vec<File> {
    let mut files = vec![stage_module(design, stage, header)];
    let mut tables: Vec<String> = Vec::new();
    for layer in stage.layers() {
        files.extend(layer::files(layer, header));
        if let (Some(module), Some(table)) =
            (table_module(layer, header), layer.quant.table.as_deref())
            && !tables.contains(&module)
        {
            files.push(rom::segments(&module, table, header));
            tables.push(module);
        }
    }
    files
}

fn stage_module(design: &Design, stage: &Perceptron, header: &Header) -> File {
    let module = header.module("mlp");
    let schedule = design.schedule();
    let lane = bits(design.sink().lane_bits);
    let mut layers = Vec::new();
    for (i, layer) in stage.shared.iter().enumerate() {
        let before = i.checked_sub(1).map(|i| &stage.shared[i]);
        let readers: Vec<&Layer> = match stage.shared.get(i + 1) {
            Some(next) => vec![next],
            None => stage.networks.iter().map(|n| &n.layers[0]).collect(),
        };
        let start = (0, layer.start_copies());
        layers.push(layer_context(layer, before, start, &readers, header));
    }
    let mut networks = Vec::new();
    let mut first = 0;
    // Copies of the shared vector's start: those that networks before took, and all.
    let fronts: Vec<&Layer> = stage.networks.iter().map(|n| &n.layers[0]).collect();
    let (mut taken, all) = (0, Layer::gather_starts(&fronts));
    for network in &stage.networks {
        for (i, layer) in network.layers.iter().enumerate() {
            let before = i
                .checked_sub(1)
                .map_or(stage.shared.last(), |i| Some(&network.layers[i]));
            let readers: Vec<&Layer> = network.layers.get(i + 1).into_iter().collect();
            let start = match i {
                0 => (taken, all),
                _ => (0, layer.start_copies()),
            };
            layers.push(layer_context(layer, before, start, &readers, header));
        }
        taken += Layer::gather_starts(&[&network.layers[0]]);
        let last = &network.last().quant;
        let width = bits(last.output.width());
        networks.push(NetworkContext {
            name: network.name.clone(),
            last: last.name.clone(),
            format: format!("{}{}", last.output, unit(&network.unit)),
            words: last.outputs(),
            width,
            fifo_width: 1 + last.outputs() * width,
            known_range: range(address_width(schedule.fifo_depth + 1)),
            range: range(last.outputs() * width),
            first,
            signs: lane - width + 1,
        });
        first += last.outputs();
    }
    let sizes = |layers: &[Layer]| {
        layers
            .iter()
            .map(|l| format!("{} {}", l.quant.outputs(), l.quant.activation.name()))
            .collect::<Vec<_>>()
            .join(", ")
    };
    let context = StageContext {
        module: module.clone(),
        prefix: header.prefix,
        provenance: header.provenance(),
        shared_note: if stage.shared.is_empty() {
            "every network reads the input frame:".to_owned()
        } else {
            format!(
                "every network reads the words of the shared layers ({}):",
                sizes(&stage.shared)
            )
        },
        network_notes: stage
            .networks
            .iter()
            .map(|n| format!("  {}: {}", n.name, sizes(&n.layers)))
            .collect(),
        x_format: design.input().format.to_string(),
        lane_bits: lane,
        latency: schedule.latency - design.sink().beats() - design.source().beats() - 4,
        interval: schedule.interval,
        credits: schedule.credits,
        fifo_depth: schedule.fifo_depth,
        frame_range: range(design.source().words * bits(design.input().format.width())),
        out_range: range(design.sink().words * lane),
        layers,
        networks,
    };
    header.rtl(&module, finish(context.render()))
}

/// `first_start` and `all_starts`: where this layer's copies of the start of the vector before it
/// begin, and how many there are; `readers`: who reads the layer's words, nobody if they are answers.
fn layer_context(
    layer: &Layer,
    before: Option<&Layer>,
    (first_start, all_starts): (usize, usize),
    readers: &[&Layer],
    header: &Header,
) -> LayerContext {
    let quant = &layer.quant;
    let whole = layer.reads_whole();
    let copies = layer.start_copies();
    let starts = Layer::gather_starts(readers);
    let (start, flag, vector) = match (before, whole) {
        (None, _) => (
            if copies == 1 {
                "start_q".to_owned()
            } else {
                format!("{{{copies}{{start_q}}}}")
            },
            "1'b0".to_owned(),
            "frame_i".to_owned(),
        ),
        (Some(before), true) => {
            let name = &before.quant.name;
            (
                if all_starts == 1 {
                    format!("{name}_start")
                } else {
                    format!("{name}_start[{first_start} +: {copies}]")
                },
                format!("{name}_clipped"),
                format!("{name}_vector"),
            )
        }
        (Some(before), false) => {
            let name = &before.quant.name;
            (
                format!("{name}_valid"),
                format!("{name}_flag"),
                format!("{name}_words"),
            )
        }
    };
    let width = bits(quant.output.width());
    LayerContext {
        module: header.module(&quant.name),
        note: match layer.adders() {
            Some(sums) => format!(", {} adders", sums.adders.len()),
            None => format!(
                ", {} x {} multiplier{} for {} clocks",
                layer.fold.pe,
                layer.fold.simd,
                crate::plural(layer.multipliers()),
                layer.folds()
            ),
        },
        next: format!(
            "{}{}_next",
            if starts > 0 { "" } else { "unused_" },
            quant.name
        ),
        name: quant.name.clone(),
        inputs: quant.inputs(),
        outputs: quant.outputs(),
        activation: quant.activation.name(),
        whole,
        gathered: starts > 0,
        hop: layer.gather_latency > 1,
        starts,
        starts_range: wire_range(starts),
        lanes: layer.lanes,
        width,
        words_range: range(layer.lanes * width),
        vector_range: range(quant.outputs() * width),
        start,
        flag,
        vector,
    }
}

/// The range of a vector of wires, with a space behind; nothing for one wire.
pub(crate) fn wire_range(wires: usize) -> String {
    if wires == 1 {
        String::new()
    } else {
        format!("{} ", range(wires))
    }
}

/// A unit behind a number, in words.
pub(crate) fn unit(unit: &str) -> String {
    if unit.is_empty() {
        String::new()
    } else {
        format!(" in {unit}")
    }
}
