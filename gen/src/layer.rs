//! One layer's modules: the layer, its processing element, its ROMs.

use askama::Template;
use hwgen_spec::design::{Feed, Layer, bias_rom_width, extra_shift_width};
use hwgen_spec::network::Activation;
use hwgen_spec::schedule::{activation_latency, control_depth};
use hwgen_spec::schedule::{finish_latency, sum_latency};

use crate::adders;
use crate::bundle::File;
use crate::rom;
use crate::stage::wire_range;
use crate::text::finish;
use crate::{Header, address_width, bits, plural, range};

#[derive(Template)]
#[template(path = "layer.v", syntax = "verilog")]
struct LayerContext<'a> {
    module: &'a str,
    prefix: &'a str,
    layer: &'a str,
    provenance: String,
    inputs: usize,
    outputs: usize,
    activation: &'static str,
    array_note: String,
    adders: bool,
    whole: bool,
    pe: usize,
    simd: usize,
    neuron_folds: usize,
    synapse_folds: usize,
    starts: usize,
    starts_range: String,
    /// Copies of the signal that sums are done.
    loads: usize,
    loads_range: String,
    flow: Vec<String>,
    x_format: String,
    w_format: String,
    y_format: String,
    pre_format: String,
    sum_latency: usize,
    finish_latency: usize,
    drain_note: String,
    overflow: String,
    replay: bool,
    hold: bool,
    accumulates: bool,
    drains: bool,
    has_table: bool,
    valid: &'static str,
    flag: &'static str,
    operands: &'static str,
    x_width: usize,
    y_width: usize,
    pre_width: usize,
    vector_range: String,
    words_range: String,
    operands_range: String,
    operands_width: usize,
    address_range: String,
    address_width: usize,
    control_depth: usize,
    sums_range: String,
    sum_width: usize,
    weights_range: String,
    lanes: usize,
    lane_sums_range: String,
    bias_address_range: String,
    bias_address_width: usize,
    bias_copies: usize,
    entries_range: String,
    biased_width: usize,
    product_shift: u32,
    extra_width: u32,
    base_shift: u32,
    saturation: u32,
    array_beats: usize,
    output_beats: usize,
    pre_range: String,
    activation_latency: usize,
    table_latency: usize,
    segment_range: String,
    line_range: String,
    table_module: String,
    magnitude_width: u32,
    segment_width: u32,
    slope_bits: u32,
    table_fraction: u32,
    slope_width: u32,
    distance_width: u32,
    product_width: u32,
    sigmoid: u32,
    in_logic: bool,
}

#[derive(Template)]
#[template(path = "pe.v", syntax = "verilog")]
struct PeContext<'a> {
    module: &'a str,
    prefix: &'a str,
    layer: &'a str,
    provenance: String,
    simd: usize,
    simd_s: &'static str,
    sum_note: &'static str,
    shift_note: &'static str,
    x_format: String,
    w_format: String,
    x_width: usize,
    w_width: usize,
    product_width: usize,
    sum_width: usize,
    latency: usize,
    accumulates: bool,
    turns: usize,
    /// The registers that the operands go through, and what comes out of them.
    operand_registers: Vec<Register>,
    operands: String,
    weight_delay: &'static str,
    operands_range: String,
    operands_width: usize,
    weights_range: String,
    sum_range: String,
    products_range: String,
    levels: Vec<Level>,
    tree: String,
    tree_width: usize,
}

/// A register and what it is fed from.
struct Register {
    name: String,
    source: String,
}

struct Level {
    number: usize,
    inputs: usize,
    width: usize,
    sum_width: usize,
    source: String,
    range: String,
}

/// Name of the module that holds a table's segments.
pub(crate) fn table_module(layer: &Layer, header: &Header) -> Option<String> {
    let table = layer.quant.table.as_ref();
    table.map(|t| header.module(&format!("tanh{}", t.fraction())))
}

/// All modules of a layer but the table, which layers share.
pub(crate) fn files(layer: &Layer, header: &Header) -> Vec<File> {
    let module = header.module(&layer.quant.name);
    if let Some(sums) = layer.adders() {
        return vec![
            layer_module(&module, layer, header),
            adders::file(&format!("{module}_adders"), layer, sums, header),
            rom::biases(&format!("{module}_bias"), layer, header),
        ];
    }
    let mut files = vec![
        layer_module(&module, layer, header),
        pe_module(&module, layer, header),
    ];
    files.extend(
        (0..layer.fold.pe).map(|pe| rom::weights(&format!("{module}_w{pe}"), layer, pe, header)),
    );
    files.push(rom::biases(&format!("{module}_bias"), layer, header));
    files
}

fn layer_module(module: &str, layer: &Layer, header: &Header) -> File {
    let quant = &layer.quant;
    let sums = layer.adders();
    let (replay, hold) = (layer.feed == Feed::Replay, layer.feed == Feed::Hold);
    let whole = layer.reads_whole();
    let (pe, simd, lanes) = (layer.fold.pe, layer.fold.simd, layer.lanes);
    let (x, w, y) = (quant.input, quant.weight_format, quant.output);
    let (sum_width, pre_width) = (bits(quant.sum_width), bits(quant.pre.width()));
    let operands_width = simd * bits(x.width());
    let vector_words = if whole { quant.inputs() } else { simd };
    let address = address_width(layer.folds());
    let bias_address = address_width(layer.array_beats());
    let bias_copies = layer.bias_address_copies(header.device);
    let table = quant.table.as_deref();
    let drains = layer.drain_beats() > 1;
    let mut flow = vec![match (layer.feed, layer.neuron_folds()) {
        (Feed::Replay, 1) => "the vector is held and offered once.".to_owned(),
        (Feed::Replay, n) => {
            format!("the vector is held and offered {n} times, once for each group of neurons.")
        }
        (Feed::Adders, _) => "by shifts and adders, all neurons at once.".to_owned(),
        (Feed::Direct, _) => "the words of the layer before are used as they come.".to_owned(),
        (Feed::Hold, n) => {
            let group = if pe == 1 {
                "neuron"
            } else {
                "group of neurons"
            };
            format!("each beat of the layer before is offered {n} times, once for each {group}.")
        }
    }];
    if layer.accumulates() {
        flow.push(match layer.turns() {
            1 => format!(
                "A sum takes {} clocks and is kept in an accumulator.",
                layer.synapse_folds()
            ),
            n => format!("{n} sums take turns in an accumulator."),
        });
    }
    let activation = quant.activation;
    let context = LayerContext {
        module,
        prefix: header.prefix,
        layer: &quant.name,
        provenance: header.provenance(),
        inputs: quant.inputs(),
        outputs: quant.outputs(),
        activation: activation.name(),
        array_note: if sums.is_some() {
            "no multipliers, a frame a clock".to_owned()
        } else {
            format!(
                "{pe} neuron{} x {simd} input{} a clock, {} clocks a frame",
                plural(pe),
                plural(simd),
                layer.folds()
            )
        },
        adders: sums.is_some(),
        whole,
        pe,
        simd,
        neuron_folds: layer.neuron_folds(),
        synapse_folds: layer.synapse_folds(),
        starts: layer.start_copies(),
        starts_range: wire_range(layer.start_copies()),
        loads: layer.load_copies(),
        loads_range: wire_range(layer.load_copies()),
        flow,
        x_format: x.to_string(),
        w_format: w.to_string(),
        y_format: y.to_string(),
        pre_format: quant.pre.to_string(),
        sum_latency: sum_latency(layer),
        finish_latency: finish_latency(layer),
        drain_note: if drains {
            format!("1 to {} in the drain, ", layer.drain_beats())
        } else {
            String::new()
        },
        overflow: match activation {
            Activation::Tanh | Activation::Sigmoid => format!(
                "the argument is clipped to +-({} - 2^{}), part of {}, and raises no flag.",
                1u64 << quant.pre.integer(),
                -quant.pre.fraction(),
                activation.name()
            ),
            Activation::Relu | Activation::Linear => {
                format!("a word that is clipped to {y} raises flag_o.")
            }
        },
        replay,
        hold,
        accumulates: layer.accumulates(),
        drains,
        has_table: table.is_some(),
        valid: match layer.feed {
            Feed::Replay | Feed::Hold => "valid",
            Feed::Direct => "valid_i",
            Feed::Adders => "start_i",
        },
        flag: if replay || hold { "flag" } else { "flag_i" },
        operands: if replay || hold {
            "operands"
        } else {
            "words_i"
        },
        x_width: bits(x.width()),
        y_width: bits(y.width()),
        pre_width,
        vector_range: range(vector_words * bits(x.width())),
        words_range: range(lanes * bits(y.width())),
        operands_range: range(operands_width),
        operands_width,
        address_range: range(address),
        address_width: address,
        control_depth: control_depth(layer),
        sums_range: range(pe * sum_width),
        sum_width,
        weights_range: range(simd * bits(w.width())),
        lanes,
        lane_sums_range: range(lanes * sum_width),
        bias_address_range: range(bias_copies * bias_address),
        bias_address_width: bias_address,
        bias_copies,
        entries_range: range(lanes * bits(bias_rom_width(quant))),
        biased_width: bits(quant.biased_width),
        product_shift: quant.product_shift,
        extra_width: extra_shift_width(quant),
        base_shift: quant.base_shift,
        saturation: match activation {
            Activation::Linear => 0,
            Activation::Relu => 1,
            Activation::Tanh | Activation::Sigmoid => 2,
        },
        array_beats: layer.array_beats(),
        output_beats: layer.output_beats(),
        pre_range: range(lanes * pre_width),
        activation_latency: activation_latency(layer),
        table_latency: layer.segment_latency,
        segment_range: table.map_or_else(String::new, |t| range(bits(t.segment_bits()))),
        line_range: table.map_or_else(String::new, |t| {
            range(bits(t.offset_width() + t.slope_width()))
        }),
        table_module: table_module(layer, header).unwrap_or_default(),
        magnitude_width: table.map_or(0, |t| t.magnitude_bits()),
        segment_width: table.map_or(0, |t| t.segment_bits()),
        slope_bits: table.map_or(0, |t| t.slope_bits()),
        table_fraction: table.map_or(0, |t| t.fraction()),
        slope_width: table.map_or(1, |t| t.slope_width()),
        distance_width: table.map_or(1, |t| t.distance_bits()),
        product_width: table.map_or(4, |t| t.slope_width() + t.distance_bits() + 2),
        sigmoid: u32::from(activation == Activation::Sigmoid),
        in_logic: layer.activation_in_logic,
    };
    header.rtl(module, finish(context.render()))
}

/// Where operands of so many clocks ago stand in an element.
fn operand_register(age: usize) -> String {
    match age {
        0 => "operands_i".to_owned(),
        1 => "operands_q".to_owned(),
        _ => format!("operands_q{age}"),
    }
}

fn pe_module(layer_module: &str, layer: &Layer, header: &Header) -> File {
    let quant = &layer.quant;
    let module = format!("{layer_module}_pe");
    let (x, w) = (bits(quant.input.width()), bits(quant.weight_format.width()));
    let (simd, sum_width) = (layer.fold.simd, bits(quant.sum_width));
    let mut levels = Vec::new();
    let (mut inputs, mut width, mut source) = (simd, x + w, "products".to_owned());
    for number in 1..=layer.tree_levels() {
        let wider = (width + 1).min(sum_width);
        let sums = inputs.div_ceil(2);
        levels.push(Level {
            number,
            inputs,
            width,
            sum_width: wider,
            source,
            range: range(sums * wider),
        });
        (inputs, width, source) = (sums, wider, format!("level{number}"));
    }
    // Without an accumulator the tree's last level is the sum, as wide as it may become.
    let tree = if layer.accumulates() || width == sum_width {
        source
    } else {
        format!(
            "{{{{{}{{{source}[{}]}}}}, {source}[{}:0]}}",
            sum_width - width + 1,
            width - 1,
            width - 2
        )
    };
    let context = PeContext {
        module: &module,
        prefix: header.prefix,
        layer: &quant.name,
        provenance: header.provenance(),
        simd,
        simd_s: plural(simd),
        sum_note: if layer.accumulates() {
            match layer.feed {
                Feed::Replay | Feed::Direct | Feed::Adders => {
                    ", accumulated over a group of clocks"
                }
                Feed::Hold => ", accumulated over the beats, several neurons in turns",
            }
        } else {
            ""
        },
        shift_note: if quant.max_extra_shift() > 0 {
            " (finer where a neuron has a shift of its own)"
        } else {
            ""
        },
        x_format: quant.input.to_string(),
        w_format: quant.weight_format.to_string(),
        x_width: x,
        w_width: w,
        product_width: x + w,
        sum_width,
        latency: sum_latency(layer) - 1,
        accumulates: layer.accumulates(),
        turns: layer.turns(),
        operands: operand_register(layer.operand_latency()),
        operand_registers: (1..=layer.operand_latency())
            .map(|age| Register {
                name: operand_register(age),
                source: operand_register(age - 1),
            })
            .collect(),
        weight_delay: match layer.operand_latency() {
            0 => "come with",
            1 => "come a clock after",
            2 => "come two clocks after",
            _ => "come three clocks after",
        },
        operands_range: range(simd * x),
        operands_width: simd * x,
        weights_range: range(simd * w),
        sum_range: range(sum_width),
        products_range: range(simd * (x + w)),
        levels,
        tree,
        tree_width: width,
    };
    header.rtl(&module, finish(context.render()))
}
