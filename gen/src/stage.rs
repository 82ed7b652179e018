//! The perceptron stage: layers, their gathering, the answers' queues.

use askama::Template;
use hwgen_spec::design::{Design, Feed, Layer, Perceptron};

use crate::bundle::File;
use crate::layer::{self, table_module};
use crate::rom;
use crate::text::finish;
use crate::{Header, bits, range};

#[derive(Template)]
#[template(path = "mlp.v", syntax = "verilog")]
struct StageContext {
    module: String,
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
    module: String,
    note: String,
    inputs: usize,
    outputs: usize,
    activation: &'static str,
    replay: bool,
    gathered: bool,
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
    range: String,
    first: usize,
    signs: usize,
}

pub(crate) fn files(design: &Design, stage: &Perceptron, header: &Header) -> Vec<File> {
    let mut files = vec![stage_module(design, stage, header)];
    let mut tables: Vec<String> = Vec::new();
    for layer in stage.layers() {
        files.extend(layer::files(layer, header));
        if let (Some(module), Some(table)) = (
            table_module(header.design, layer),
            layer.quant.table.as_deref(),
        ) && !tables.contains(&module)
        {
            files.push(rom::segments(&module, table, header));
            tables.push(module);
        }
    }
    files
}

fn stage_module(design: &Design, stage: &Perceptron, header: &Header) -> File {
    let module = format!("{}_mlp", header.design);
    let schedule = design.schedule();
    let lane = bits(design.sink().lane_bits);
    let mut layers = Vec::new();
    for (i, layer) in stage.shared.iter().enumerate() {
        let before = i.checked_sub(1).map(|i| &stage.shared[i]);
        let direct_consumers = match stage.shared.get(i + 1) {
            Some(next) => vec![next.feed],
            None => stage.networks.iter().map(|n| n.layers[0].feed).collect(),
        };
        layers.push(layer_context(layer, before, &direct_consumers, header));
    }
    let mut networks = Vec::new();
    let mut first = 0;
    for network in &stage.networks {
        for (i, layer) in network.layers.iter().enumerate() {
            let before = i
                .checked_sub(1)
                .map_or(stage.shared.last(), |i| Some(&network.layers[i]));
            let consumers: Vec<Feed> = network
                .layers
                .get(i + 1)
                .map_or(vec![Feed::Replay], |next| vec![next.feed]);
            layers.push(layer_context(layer, before, &consumers, header));
        }
        let last = &network.last().quant;
        let width = bits(last.output.width());
        networks.push(NetworkContext {
            name: network.name.clone(),
            last: last.name.clone(),
            format: format!("{}{}", last.output, unit(&network.unit)),
            words: last.outputs(),
            width,
            fifo_width: 1 + last.outputs() * width,
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
        latency: schedule.latency - design.sink().beats() - design.source().beats() - 3,
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

/// `consumers`: how those who read the layer's words get them.
fn layer_context(
    layer: &Layer,
    before: Option<&Layer>,
    consumers: &[Feed],
    header: &Header,
) -> LayerContext {
    let quant = &layer.quant;
    let replay = layer.feed == Feed::Replay;
    let (start, flag, vector) = match (before, replay) {
        (None, _) => (
            "start_q".to_owned(),
            "1'b0".to_owned(),
            "frame_i".to_owned(),
        ),
        (Some(before), true) => {
            let name = &before.quant.name;
            (
                format!("{name}_start"),
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
        module: format!("{}_{}", header.design, quant.name),
        note: format!(
            ", {} x {} multiplier{} for {} clocks",
            layer.fold.pe,
            layer.fold.simd,
            crate::plural(layer.multipliers()),
            layer.folds()
        ),
        name: quant.name.clone(),
        inputs: quant.inputs(),
        outputs: quant.outputs(),
        activation: quant.activation.name(),
        replay,
        gathered: consumers.contains(&Feed::Replay),
        lanes: layer.lanes,
        width,
        words_range: range(layer.lanes * width),
        vector_range: range(quant.outputs() * width),
        start,
        flag,
        vector,
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
