//! Mutants: faults put into emitted Verilog, each of which `verify` must find.
//!
//! A check that can't fail proves nothing. Every row of the table is one edit of one file of a
//! bundle; the control is the same bundle without an edit.

mod support;

use std::fs;
use std::path::{Path, PathBuf};

use hwgen_gen::Source;
use hwgen_sim::model::Model;
use hwgen_sim::session;
use hwgen_sim::simulator::Simulator;
use hwgen_sim::stimulus::segments;
use hwgen_sim::verify::FirstDifference;
use hwgen_spec::design::{Design, Feed, Layer, bias_rom_width};
use hwgen_spec::format::{QFormat, Rounding};
use hwgen_spec::network::{
    Activation, FloatLayer, FloatNet, Inputs, LayerFormat, Network, Outputs,
};
use hwgen_spec::options::{Budget, Options, WidthSetting};
use nalgebra::DMatrix;
use support::{Check, assert_verified, axes, check, check_source, emit, in_parallel};

/// Random frames of each check.
const RANDOM: usize = 12;
const SEED: u64 = 1;

const ICARUS: Check<'static> = Check {
    random: RANDOM,
    seed: SEED,
    simulators: &[Simulator::Icarus],
};

/// A fault, and the register or port at which it shows first.
struct Mutant {
    name: &'static str,
    file: &'static str,
    /// Occurs once in the file.
    find: &'static str,
    replace: &'static str,
    /// Path of the first difference, from the top module.
    signal: &'static str,
}

/// Weights between -1 and 1 without a pattern, the same on every machine.
fn layer(
    activation: Activation,
    outputs: usize,
    inputs: usize,
    weight: impl Fn(usize, usize) -> Option<f64>,
) -> FloatLayer {
    let noise = |i: usize, j: usize| {
        let mixed = (i * 31 + j * 17 + outputs * 7 + inputs) * 2_654_435_761 % 4_294_967_296;
        f64::from(u32::try_from(mixed).expect("32 bits")) / 2_147_483_648.0 - 1.0
    };
    FloatLayer {
        activation,
        weights: DMatrix::from_fn(outputs, inputs, |i, j| {
            weight(i, j).unwrap_or_else(|| noise(i, j))
        }),
        bias: (0..outputs).map(|i| noise(i, 99) / 2.0).collect(),
        format: LayerFormat::default(),
    }
}

/// Rounds what a format is fixed for.
fn to_format(layer: &mut FloatLayer) {
    let round = |format: Option<QFormat>, v: &mut f64| {
        if let Some(format) = format {
            *v = format.to_f64(format.quantize(*v, Rounding::HalfUp).code);
        }
    };
    let format = layer.format;
    layer
        .weights
        .iter_mut()
        .for_each(|w| round(format.weights, w));
    layer.bias.iter_mut().for_each(|b| round(format.bias, b));
}

/// Small, and with every feature that the array has.
///
/// Some words are cut short by a format, so that saturation is reached inside the box, and one
/// neuron meets the lowest code of an argument exactly.
fn fixture() -> (FloatNet, Options) {
    let words = |bits, fraction| LayerFormat {
        activations: Some(QFormat::new(bits, fraction).expect("legal")),
        ..LayerFormat::default()
    };
    // Neuron 0 puts out its input, up to 2 exactly; the others go beyond 4.
    let mut shared = layer(Activation::Relu, 6, 5, |i, j| match (i, j) {
        (0, 0) => Some(1.0),
        (0, _) => Some(0.0),
        (4, _) => None,
        (_, 0) => Some(1.75),
        _ => None,
    });
    shared.bias[0] = 0.0;
    shared.format = words(11, 8);
    // Neuron 0 is -4 exactly where its input is 2; neuron 2 is small and has a shift of its own.
    let mut tanh = layer(Activation::Tanh, 7, 6, |i, j| match (i, j) {
        (0, 0) => Some(-2.0),
        (0, _) => Some(0.0),
        (2 | 5, _) => Some(0.003 * ((i + 2 * j) % 5) as f64 - 0.005),
        _ => None,
    });
    tanh.bias[0] = 0.0;
    let mut linear = layer(Activation::Linear, 3, 7, |_, _| None);
    // Cut to [-1, 1), and the map of the outputs becomes a layer of its own.
    linear.format = words(10, 9);
    // Biases finer than products, and weights that the trainer fixed.
    let mut sigmoid = layer(Activation::Sigmoid, 4, 6, |_, _| None);
    sigmoid.format.bias = QFormat::new(20, 18).ok();
    to_format(&mut sigmoid);
    let mut relu = layer(Activation::Relu, 2, 4, |_, _| None);
    relu.format.weights = QFormat::new(8, 6).ok();
    relu.format.bias = QFormat::new(10, 8).ok();
    to_format(&mut relu);
    let outputs = |count: usize, scale: f64| Outputs {
        names: (0..count).map(|o| format!("out{o}")).collect(),
        unit: "m".into(),
        scale: vec![scale; count],
        offset: vec![0.0; count],
    };
    let net = FloatNet {
        name: "mutant".into(),
        inputs: Inputs {
            names: (0..5).map(|i| format!("in{i}")).collect(),
            unit: "V".into(),
            min: vec![-2.0, -1.0, -1.5, -3.0, -1.0],
            max: vec![2.0, 1.0, 1.0, 3.0, 2.0],
            offset: vec![0.0; 5],
            scale: vec![1.0; 5],
            resolution: Some(1.0 / 64.0),
        },
        shared: vec![shared],
        networks: vec![
            Network {
                name: "a".into(),
                layers: vec![tanh, linear],
                outputs: outputs(3, 3.0),
            },
            Network {
                name: "b".into(),
                layers: vec![sigmoid, relu],
                outputs: outputs(2, 1.0),
            },
        ],
    };
    let any = |bits| vec![WidthSetting { layer: None, bits }];
    let options = Options {
        budget: Budget::Interval(4),
        weight_bits: any(6),
        activation_bits: any(10),
        output_bits: Some(16),
        segments: None,
    };
    (net, options)
}

/// The faults.
const MUTANTS: &[Mutant] = &[
    Mutant {
        name: "product register bypassed",
        file: "rtl/hwg_mul.v",
        find: "assign p_o = p_q;",
        replace: "assign p_o = a_q * b_q;",
        signal: "mutant.u_mlp.u_a_l0.g_act[1].u_pwl.sum_q",
    },
    Mutant {
        name: "operand registers bypassed",
        file: "rtl/hwg_mul.v",
        find: "p_q <= a_q * b_q;",
        replace: "p_q <= a_i * b_i;",
        signal: "mutant.u_mlp.u_b_l1.u_pe0.g_mul[0].u_mul.p_q",
    },
    Mutant {
        name: "unsigned operand",
        file: "rtl/hwg_mul.v",
        find: "reg signed [B_WIDTH-1:0]         b_q",
        replace: "reg [B_WIDTH-1:0] b_q",
        signal: "mutant.u_mlp.u_b_l1.u_pe0.g_mul[0].u_mul.p_q",
    },
    Mutant {
        name: "adder tree level combinational",
        file: "rtl/hwg_tree_level.v",
        find: "always @(posedge clk_i) begin",
        replace: "always @* begin",
        signal: "mutant.u_mlp.u_shared_l0.u_pe0.u_level1.sum_q",
    },
    Mutant {
        name: "odd word of a tree level lost",
        file: "rtl/hwg_tree_level.v",
        find: "if (SUMS > PAIRS)",
        replace: "if (1'b0)",
        signal: "mutant.u_mlp.u_shared_l0.u_pe1.u_level1.sum_q",
    },
    Mutant {
        name: "no sign extension in the tree",
        file: "rtl/hwg_tree_level.v",
        find: "{{SIGNS{words_i[2*i*WIDTH+WIDTH-1]}}",
        replace: "{{SIGNS{1'b0}}",
        signal: "mutant.u_mlp.u_shared_l0.u_pe0.u_level1.sum_q",
    },
    Mutant {
        name: "accumulator not cleared",
        file: "rtl/hwg_accumulator.v",
        find: "(first_i ? {SUM_WIDTH{1'b0}} : sum_q)",
        replace: "sum_q",
        signal: "mutant.u_mlp.u_shared_l0.u_pe0.u_acc.sum_q",
    },
    Mutant {
        name: "accumulator always enabled",
        file: "rtl/hwg_accumulator.v",
        find: "if (enable_i) sum_q",
        replace: "sum_q",
        signal: "mutant.u_mlp.u_b_l1.u_pe0.u_acc.sum_q",
    },
    Mutant {
        name: "group's flag never cleared",
        file: "rtl/hwg_group.v",
        find: "(flag_q & ~first_i) | flag_i",
        replace: "flag_q | flag_i",
        signal: "mutant.u_mlp.u_b_l1.u_group.flag_q",
    },
    Mutant {
        name: "group done at its first word",
        file: "rtl/hwg_group.v",
        find: "done_q <= valid_i & last_i",
        replace: "done_q <= valid_i & first_i",
        signal: "mutant.u_mlp.u_shared_l0.u_group.done_q",
    },
    Mutant {
        name: "drain turned round",
        file: "rtl/hwg_drain.v",
        find: "for (i = 0; i < WORDS - LANES; i = i + 1)",
        replace: "for (i = WORDS; i < WORDS; i = i + 1)",
        signal: "mutant.u_mlp.u_b_l1.u_drain.word_q",
    },
    Mutant {
        name: "drain a beat short",
        file: "rtl/hwg_drain.v",
        find: "BEATS[LEFT_WIDTH-1:0];",
        replace: "BEATS[LEFT_WIDTH-1:0] - 1'b1;",
        signal: "mutant.u_mlp.u_b_l1.u_drain.left_q",
    },
    Mutant {
        name: "word rounded toward zero",
        file: "rtl/hwg_requant.v",
        find: "value    = all_bits[BIASED_WIDTH-1:SHIFT];",
        replace: "value    = all_bits[BIASED_WIDTH-1:SHIFT] + {{(VALUE_WIDTH-1){1'b0}}, all_bits[BIASED_WIDTH-1]};",
        signal: "mutant.u_mlp.u_a_l0.u_requant.g_lane[1].word_q",
    },
    Mutant {
        name: "ties to even",
        file: "rtl/hwg_requant.v",
        find: "value    = all_bits[BIASED_WIDTH-1:SHIFT];",
        replace: "value    = all_bits[BIASED_WIDTH-1:SHIFT] & ~{{(VALUE_WIDTH-1){1'b0}}, SHIFT > 0 && all_bits << (BIASED_WIDTH - SHIFT) == {BIASED_WIDTH{1'b0}}};",
        signal: "mutant.u_mlp.u_shared_l0.u_requant.g_lane[2].word_q",
    },
    Mutant {
        name: "own shift without sign",
        file: "rtl/hwg_requant.v",
        find: "$signed(biased_q) >>> extra_q",
        replace: "biased_q >> extra_q",
        signal: "mutant.u_mlp.u_a_l0.u_requant.g_lane[1].g_extra.shifted_q",
    },
    Mutant {
        name: "own shift left out",
        file: "rtl/hwg_requant.v",
        find: "$signed(biased_q) >>> extra_q",
        replace: "$signed(biased_q)",
        signal: "mutant.u_mlp.u_a_l0.u_requant.g_lane[1].g_extra.shifted_q",
    },
    Mutant {
        name: "linear word not saturated",
        file: "rtl/hwg_requant.v",
        find: "word_q <= beyond ? {negative, {(WIDTH-1){~negative}}} : value[WIDTH-1:0];",
        replace: "word_q <= value[WIDTH-1:0];",
        signal: "mutant.u_mlp.u_a_l1.u_requant.g_lane[0].word_q",
    },
    Mutant {
        name: "ReLU without clipping at zero",
        file: "rtl/hwg_requant.v",
        find: "word_q <= negative ? {WIDTH{1'b0}} : beyond",
        replace: "word_q <= beyond",
        signal: "mutant.u_mlp.u_b_l1.u_requant.g_lane[0].word_q",
    },
    Mutant {
        name: "ReLU without clipping above",
        file: "rtl/hwg_requant.v",
        find: "beyond ? {1'b0, {(WIDTH-1){1'b1}}} : value[WIDTH-1:0];",
        replace: "value[WIDTH-1:0];",
        signal: "mutant.u_mlp.u_shared_l0.u_requant.g_lane[2].word_q",
    },
    Mutant {
        name: "argument not saturated",
        file: "rtl/hwg_requant.v",
        find: "beyond | lowest ?",
        replace: "lowest ?",
        signal: "mutant.u_mlp.u_a_l0.u_requant.g_lane[0].word_q",
    },
    Mutant {
        name: "lowest argument not made odd",
        file: "rtl/hwg_requant.v",
        find: "beyond | lowest ?",
        replace: "beyond ?",
        signal: "mutant.u_mlp.u_a_l0.u_requant.g_lane[0].word_q",
    },
    Mutant {
        name: "clipping raises no flag",
        file: "rtl/hwg_requant.v",
        find: "{flag_q[STAGES-2] | (|clipped),",
        replace: "{flag_q[STAGES-2],",
        signal: "mutant.u_mlp.u_shared_l0.u_requant.flag_q",
    },
    Mutant {
        name: "clipping to zero by a ReLU raises the flag",
        file: "rtl/hwg_requant.v",
        find: "beyond & ~negative",
        replace: "beyond | negative",
        signal: "mutant.u_mlp.u_b_l1.u_requant.flag_q",
    },
    Mutant {
        name: "valid words of a layer survive a reset",
        file: "rtl/hwg_requant.v",
        find: "      valid_q <= {STAGES{1'b0}};",
        replace: "      valid_q <= valid_q;",
        signal: "mutant.u_mlp.u_shared_l0.u_requant.valid_q",
    },
    Mutant {
        name: "beat counter survives a reset",
        file: "rtl/hwg_requant.v",
        find: "      beat_q  <= {ADDRESS_WIDTH{1'b0}};",
        replace: "      beat_q  <= beat_q;",
        signal: "mutant.u_mlp.u_a_l0.u_requant.beat_q",
    },
    Mutant {
        name: "product not moved up",
        file: "rtl/hwg_requant.v",
        find: "if (PRODUCT_SHIFT > 0) begin : g_up",
        replace: "if (PRODUCT_SHIFT < 0) begin : g_up",
        signal: "mutant.u_mlp.u_b_l0.u_requant.g_lane[0].biased_q",
    },
    Mutant {
        name: "control pipeline survives a reset",
        file: "rtl/hwg_delay.v",
        find: "if (!rst_ni) begin",
        replace: "if (1'b0) begin",
        signal: "mutant.u_mlp.u_shared_l0.u_control.pipe_q",
    },
    Mutant {
        name: "sign of tanh a clock early",
        file: "rtl/hwg_pwl.v",
        find: "negative_q[4] ?",
        replace: "negative_q[3] ?",
        signal: "mutant.u_mlp.u_a_l0.g_act[1].u_pwl.y_q",
    },
    Mutant {
        name: "magnitude by ones' complement",
        file: "rtl/hwg_pwl.v",
        find: "negative ? -low_bits",
        replace: "negative ? ~low_bits",
        signal: "mutant.u_mlp.u_a_l0.g_act[1].u_pwl.magnitude_q",
    },
    Mutant {
        name: "offset a clock early",
        file: "rtl/hwg_pwl.v",
        find: "offset_q[OFFSET_WIDTH +: OFFSET_WIDTH];",
        replace: "offset_q[0 +: OFFSET_WIDTH];",
        signal: "mutant.u_mlp.u_b_l0.g_act[0].u_pwl.sum_q",
    },
    Mutant {
        name: "sigmoid without its one",
        file: "rtl/hwg_pwl.v",
        find: "one = SIGMOID != 0 ?",
        replace: "one = SIGMOID > 1 ?",
        signal: "mutant.u_mlp.u_b_l0.g_act[0].u_pwl.y_q",
    },
    Mutant {
        name: "activation rounded twice",
        file: "rtl/hwg_pwl.v",
        find: "sum_q[SUM_WIDTH-1:SLOPE_BITS]};",
        replace: "sum_q[SUM_WIDTH-1:SLOPE_BITS]} + {{(WIDTH-1){1'b0}}, sum_q[SLOPE_BITS-1]};",
        signal: "mutant.u_mlp.u_b_l0.g_act[0].u_pwl.y_q",
    },
    Mutant {
        name: "input not clipped below",
        file: "rtl/hwg_ingress.v",
        find: "below ? low[WIDTH-1:0] :",
        replace: "1'b0 ? low[WIDTH-1:0] :",
        signal: "mutant.u_ingress.word_q",
    },
    Mutant {
        name: "input not clipped above",
        file: "rtl/hwg_ingress.v",
        find: "above ? high[WIDTH-1:0] :",
        replace: "1'b0 ? high[WIDTH-1:0] :",
        signal: "mutant.u_ingress.word_q",
    },
    Mutant {
        name: "input compared without sign",
        file: "rtl/hwg_ingress.v",
        find: "wire signed [LANE_WIDTH-1:0] value",
        replace: "wire [LANE_WIDTH-1:0] value",
        signal: "mutant.u_ingress.word_q",
    },
    Mutant {
        name: "lanes without a word are compared",
        file: "rtl/hwg_ingress.v",
        find: "outside[j] = used &",
        replace: "outside[j] =",
        signal: "mutant.u_ingress.clipped_q",
    },
    Mutant {
        name: "missing words keep the frame before",
        file: "rtl/hwg_ingress.v",
        find: "else if (first)",
        replace: "else if (1'b0)",
        signal: "mutant.u_ingress.word_q",
    },
    Mutant {
        name: "clipping sticks to the next frame",
        file: "rtl/hwg_ingress.v",
        find: "(clipped_q & ~first)",
        replace: "clipped_q",
        signal: "mutant.u_ingress.clipped_q",
    },
    Mutant {
        name: "clipping seen in the last beat only",
        file: "rtl/hwg_ingress.v",
        find: "(clipped_q & ~first) | (|outside)",
        replace: "|outside",
        signal: "mutant.u_ingress.clipped_q",
    },
    Mutant {
        name: "short frames raise no error",
        file: "rtl/hwg_ingress.v",
        find: "error_q   <= index_q != LAST[INDEX_WIDTH-1:0];",
        replace: "error_q   <= index_q == BEATS[INDEX_WIDTH-1:0];",
        signal: "mutant.u_ingress.error_q",
    },
    Mutant {
        name: "long frames wrap",
        file: "rtl/hwg_ingress.v",
        find: "else if (index_q != BEATS[INDEX_WIDTH-1:0]) index_q",
        replace: "else index_q",
        signal: "mutant.u_ingress.index_q",
    },
    Mutant {
        name: "half a frame survives a reset",
        file: "rtl/hwg_ingress.v",
        find: "      index_q <= {INDEX_WIDTH{1'b0}};\n      full_q",
        replace: "      full_q",
        signal: "mutant.u_ingress.index_q",
    },
    Mutant {
        name: "whole frame survives a reset",
        file: "rtl/hwg_ingress.v",
        find: "      full_q  <= 1'b0;\n    end else",
        replace: "    end else",
        signal: "mutant.u_ingress.full_q",
    },
    Mutant {
        name: "TREADY stuck high",
        file: "rtl/hwg_ingress.v",
        find: "  assign frame_valid_o = full_q;",
        replace: "  assign (supply1, supply0) tready_o = 1'b1;\n  assign frame_valid_o = full_q;",
        signal: "mutant.s_axis_tready",
    },
    Mutant {
        name: "FIFO never full",
        file: "rtl/hwg_fifo.v",
        find: "ready_q <= count_d != DEPTH[COUNT_WIDTH-1:0];",
        replace: "ready_q <= 1'b1;",
        signal: "mutant.u_ingress.u_slice.ready_q",
    },
    Mutant {
        name: "FIFO a word shorter",
        file: "rtl/hwg_fifo.v",
        find: "ready_q <= count_d != DEPTH[COUNT_WIDTH-1:0];",
        replace: "ready_q <= count_d + 1'b1 < DEPTH[COUNT_WIDTH-1:0];",
        signal: "mutant.u_ingress.u_slice.ready_q",
    },
    Mutant {
        name: "FIFO puts behind the one that leaves",
        file: "rtl/hwg_fifo.v",
        find: "tail    = pop ? count_q - 1'b1 : count_q;",
        replace: "tail    = count_q;",
        signal: "mutant.u_ingress.u_slice.slot_q",
    },
    Mutant {
        name: "FIFO keeps its words in a reset",
        file: "rtl/hwg_fifo.v",
        find: "      valid_q <= 1'b0;",
        replace: "      valid_q <= valid_q;",
        signal: "mutant.u_ingress.u_slice.valid_q",
    },
    Mutant {
        name: "FIFO valid without a word",
        file: "rtl/hwg_fifo.v",
        find: "assign valid_o = valid_q;",
        replace: "assign valid_o = 1'b1;",
        signal: "mutant.u_ingress.word_q",
    },
    Mutant {
        name: "interval one short",
        file: "rtl/hwg_admit.v",
        find: "INTERVAL - 1;",
        replace: "INTERVAL - 2;",
        signal: "mutant.u_mlp.u_admit.gap_q",
    },
    Mutant {
        name: "interval one long",
        file: "rtl/hwg_admit.v",
        find: "INTERVAL - 1;",
        replace: "INTERVAL;",
        signal: "mutant.u_mlp.u_admit.gap_q",
    },
    Mutant {
        name: "credits not looked at",
        file: "rtl/hwg_admit.v",
        find: " && credit_d != {CREDIT_WIDTH{1'b0}};",
        replace: ";",
        signal: "mutant.u_mlp.u_admit.ready_q",
    },
    Mutant {
        name: "credits not given back",
        file: "rtl/hwg_admit.v",
        find: "release_i & ~start ? credit_q + 1'b1 :",
        replace: "1'b0 ? credit_q + 1'b1 :",
        signal: "mutant.u_mlp.u_admit.credit_q",
    },
    Mutant {
        name: "TLAST inverted",
        file: "rtl/hwg_egress.v",
        find: "{beat_last, user_q,",
        replace: "{~beat_last, user_q,",
        signal: "mutant.u_egress.u_slice.slot_q",
    },
    Mutant {
        name: "TLAST on the first beat",
        file: "rtl/hwg_egress.v",
        find: "{beat_last, user_q,",
        replace: "{left_q == BEATS[LEFT_WIDTH-1:0], user_q,",
        signal: "mutant.u_egress.u_slice.slot_q",
    },
    Mutant {
        name: "TUSER bits swapped",
        file: "rtl/hwg_egress.v",
        find: "{error_i, saturated_i}",
        replace: "{saturated_i, error_i}",
        signal: "mutant.u_egress.user_q",
    },
    Mutant {
        name: "lanes without a word not zero",
        file: "rtl/hwg_egress.v",
        find: "<= {LANE_WIDTH{1'b0}};",
        replace: "<= {LANE_WIDTH{1'b1}};",
        signal: "mutant.u_egress.slot_q",
    },
    Mutant {
        name: "frame overwritten under back-pressure",
        file: "rtl/hwg_egress.v",
        find: "~beat_valid | (beat_last & beat_ready)",
        replace: "~beat_valid | beat_last",
        signal: "mutant.u_mlp.u_admit.credit_q",
    },
    Mutant {
        name: "half an answer survives a reset",
        file: "rtl/hwg_egress.v",
        find: "left_q <= {LEFT_WIDTH{1'b0}};\n    else if",
        replace: "left_q <= left_q;\n    else if",
        signal: "mutant.u_egress.left_q",
    },
    Mutant {
        name: "flag of the last beat only",
        file: "rtl/hwg_gather.v",
        find: "(flag_q & ~first) | flag_i",
        replace: "flag_i",
        signal: "mutant.u_mlp.u_a_l1_gather.flag_q",
    },
    Mutant {
        name: "vector called whole at its first beat",
        file: "rtl/hwg_gather.v",
        find: "valid_i & last;",
        replace: "valid_i & first;",
        signal: "mutant.u_mlp.u_shared_l0_gather.start_q",
    },
    Mutant {
        name: "vector fills from the bottom",
        file: "rtl/hwg_gather.v",
        find: "slot_q[(SLOTS-LANES)*WIDTH +: LANES*WIDTH] <= data_i;",
        replace: "slot_q[0 +: LANES*WIDTH] <= data_i;",
        signal: "mutant.u_mlp.u_shared_l0_gather.slot_q",
    },
    Mutant {
        name: "replay turns by one word",
        file: "rtl/hwg_replay.v",
        find: "((i + SIMD) % SLOTS)",
        replace: "((i + 1) % SLOTS)",
        signal: "mutant.u_mlp.u_shared_l0.u_replay.slot_q",
    },
    Mutant {
        name: "ROM addresses in the wrong order",
        file: "rtl/hwg_replay.v",
        find: "{ADDRESS_WIDTH{1'b0}} : address_q + 1'b1;",
        replace: "{ADDRESS_WIDTH{1'b0}} : address_q - 1'b1;",
        signal: "mutant.u_mlp.u_shared_l0.u_replay.address_q",
    },
    Mutant {
        name: "replay does not stop",
        file: "rtl/hwg_replay.v",
        find: "busy_q    <= ~last;",
        replace: "busy_q    <= 1'b1;",
        signal: "mutant.u_mlp.u_a_out.u_replay.busy_q",
    },
    Mutant {
        name: "replay goes on in a reset",
        file: "rtl/hwg_replay.v",
        find: "      busy_q    <= 1'b0;",
        replace: "      busy_q    <= busy_q;",
        signal: "mutant.u_mlp.u_shared_l0.u_replay.busy_q",
    },
    Mutant {
        name: "beats of a frame counted on in a reset",
        file: "rtl/hwg_beats.v",
        find: "if (!rst_ni)      address_q <= {ADDRESS_WIDTH{1'b0}};\n    else if",
        replace: "if",
        signal: "mutant.u_mlp.u_a_l1.u_beats.address_q",
    },
    Mutant {
        name: "operands a clock early",
        file: "rtl/mutant_b_l0.v",
        find: ".operands_i(operands_q)",
        replace: ".operands_i(operands)",
        signal: "mutant.u_mlp.u_b_l0.u_pe0.g_mul[3].u_mul.a_q",
    },
    Mutant {
        name: "operands of two multipliers swapped",
        file: "rtl/mutant_a_l0_pe.v",
        find: "operands_i[i*",
        replace: "operands_i[(5-i)*",
        signal: "mutant.u_mlp.u_a_l0.u_pe0.g_mul[1].u_mul.a_q",
    },
    Mutant {
        name: "box of another word",
        file: "rtl/mutant.v",
        find: ".high_i       (HIGH)",
        replace: ".high_i       (LOW)",
        signal: "mutant.u_ingress.word_q",
    },
    Mutant {
        name: "clipping of the inputs forgotten",
        file: "rtl/mutant_mlp.v",
        find: "assign saturated_o   = clipped |",
        replace: "assign saturated_o   =",
        signal: "mutant.u_egress.user_q",
    },
    Mutant {
        name: "clipping in one network forgotten",
        file: "rtl/mutant_mlp.v",
        find: "= clipped | a_saturated |",
        replace: "= clipped |",
        signal: "mutant.u_egress.user_q",
    },
    Mutant {
        name: "does not wait for the slower network",
        file: "rtl/mutant_mlp.v",
        find: " & a_known",
        replace: "",
        signal: "mutant.u_mlp.u_admit.credit_q",
    },
    Mutant {
        name: "credit given back while the answer waits",
        file: "rtl/mutant_mlp.v",
        find: ".release_i    (leave)",
        replace: ".release_i    (frame_valid_o)",
        signal: "mutant.u_mlp.u_admit.credit_q",
    },
    Mutant {
        name: "answer without its sign",
        file: "rtl/mutant_mlp.v",
        find: "a_answer[i*16+15]",
        replace: "1'b0",
        signal: "mutant.u_egress.slot_q",
    },
    Mutant {
        name: "TLAST and TUSER exchanged at the pins",
        file: "rtl/hwg_egress.v",
        find: "({tlast_o, tuser_o, tdata_o})",
        replace: "({tuser_o, tlast_o, tdata_o})",
        signal: "mutant.m_axis_tuser",
    },
    Mutant {
        name: "m_axis_tdata not connected",
        file: "rtl/mutant.v",
        find: ".tdata_o      (m_axis_tdata)",
        replace: ".tdata_o      ()",
        signal: "mutant.m_axis_tdata",
    },
    Mutant {
        name: "m_axis_tuser not connected",
        file: "rtl/mutant.v",
        find: ".tuser_o      (m_axis_tuser)",
        replace: ".tuser_o      ()",
        signal: "mutant.m_axis_tuser",
    },
    Mutant {
        name: "register without a first value",
        file: "rtl/hwg_ingress.v",
        find: "word_q    = {WORDS*WIDTH{1'b0}};",
        replace: "word_q;",
        signal: "mutant.u_ingress.word_q",
    },
    Mutant {
        name: "sums at high impedance",
        file: "rtl/hwg_tree_level.v",
        find: "assign sums_o = sum_q;",
        replace: "assign sums_o = {SUMS*SUM_WIDTH{1'bz}};",
        signal: "mutant.u_mlp.u_shared_l0.u_pe0.u_level2.sum_q",
    },
    Mutant {
        name: "unknown bit in a sum",
        file: "rtl/hwg_accumulator.v",
        find: "assign sum_o = sum_q;",
        replace: "assign sum_o = {sum_q[SUM_WIDTH-1:1], 1'bx};",
        signal: "mutant.u_mlp.u_shared_l0.u_requant.sum_q",
    },
];

/// The bundle of the fixture in a directory of its own.
fn bundle(directory: &Path, name: &str) -> (PathBuf, Source) {
    let (net, options) = fixture();
    let bundle = emit(&net, &options, &directory.join(name));
    let source = Source::read(&bundle).expect("a bundle as it was emitted");
    (bundle, source)
}

/// Puts `replace` in the place of the only `find`.
fn edit(path: &Path, find: &str, replace: &str) {
    let text = fs::read_to_string(path).expect("an emitted file");
    assert_eq!(text.matches(find).count(), 1, "{}: {find}", path.display());
    fs::write(path, text.replace(find, replace)).expect("written");
}

/// Rewrites the digits of word `address` of a ROM.
fn edit_rom(path: &Path, address: usize, edit: impl FnOnce(&mut Vec<u8>)) {
    let text = fs::read_to_string(path).expect("an emitted ROM");
    let mut edit = Some(edit);
    let lines: Vec<String> = text
        .lines()
        .map(|line| {
            let number = line.split_once("'d").and_then(|(_, rest)| {
                let (number, rest) = rest.split_once(':')?;
                rest.starts_with(" data_q <= ").then(|| number.trim())
            });
            if number != Some(&address.to_string()) {
                return line.to_owned();
            }
            let (head, rest) = line.split_once("'h").expect("a literal");
            let (digits, rest) = rest.split_once(';').expect("a statement");
            let mut digits: Vec<u8> = digits.bytes().collect();
            edit.take().expect("one such word")(&mut digits);
            let digits = String::from_utf8(digits).expect("digits");
            format!("{head}'h{digits};{rest}")
        })
        .collect();
    assert!(edit.is_none(), "{}: no word {address}", path.display());
    fs::write(path, lines.join("\n") + "\n").expect("written");
}

/// Flips one bit of word `address` of a ROM.
fn flip(path: &Path, address: usize, bit: u32) {
    edit_rom(path, address, |digits| {
        let bit = usize::try_from(bit).expect("a bit");
        let at = digits.len() - 1 - bit / 4;
        let digit = char::from(digits[at]).to_digit(16).expect("a digit");
        let flipped = char::from_digit(digit ^ 1 << (bit % 4), 16).expect("a digit");
        digits[at] = u8::try_from(flipped).expect("ASCII");
    });
}

/// The first difference, which there must be.
fn first_difference(bundle: &Path, source: &Source, what: &str) -> FirstDifference {
    let report = check_source(bundle, source, &ICARUS).expect(what);
    assert!(!report.verified, "{what}: survived");
    report.first_difference.expect(what)
}

/// The first clock at which a ROM shows word `address`: one behind its counter.
fn first_read(design: &Design, counter: &str, address: usize) -> usize {
    let pins = &segments(design, &[], RANDOM, SEED)[0];
    let pins = session::run(design, pins).pins;
    let mut model = Model::new(design);
    let at: usize = {
        let registers = model.registers();
        let register = registers.iter().position(|r| r.path == counter);
        let register = register.expect(counter);
        registers[..register].iter().map(|r| r.lanes.len()).sum()
    };
    let address = i64::try_from(address).expect("an address");
    // At power-up every counter is zero.
    let mut before = 0;
    for (clock, pins) in pins.iter().enumerate() {
        if before == address {
            return clock;
        }
        model.step(pins);
        let mut row = Vec::new();
        model.values(&mut row);
        before = row[at];
    }
    panic!("{counter} never shows {address}");
}

fn layer_of<'a>(design: &'a Design, name: &str) -> &'a Layer {
    let mut layers = design.perceptron().layers();
    layers.find(|l| l.quant.name == name).expect(name)
}

#[test]
fn the_fixture_has_what_mutants_need() {
    let (net, options) = fixture();
    let design = Design::new(&net, &options).expect("legal");
    let axes = axes(&net, &design);
    for axis in [
        "tanh",
        "sigmoid",
        "relu",
        "linear",
        "shared layers",
        "several networks",
        "replay feed",
        "direct feed",
        "accumulators",
        "no accumulators",
        "drain",
        "odd adder trees",
        "three levels of a tree",
        "shifts per neuron",
        "product shifts",
        "several words a beat",
        "lanes without a word",
        "PE does not divide the outputs",
        "SIMD does not divide the inputs",
        "fixed weights",
        "fixed biases",
        "fixed words",
        "_out",
    ] {
        assert!(
            axes.contains(axis),
            "{axis}: {axes:?} {:#?}",
            design.perceptron()
        );
    }
}

#[test]
fn the_bundle_without_an_edit_is_verified() {
    let directory = tempfile::tempdir().expect("a directory");
    let (bundle, _) = bundle(directory.path(), "control");
    let report = check(&bundle, &ICARUS).expect("Icarus runs");
    assert_verified(&report, "control");
    // Saturation is reached, and so is the absence of it.
    assert!(report.frames_saturated > 0 && report.frames_saturated < report.runs[0].frames);
}

#[test]
fn every_mutant_is_found() {
    let directory = tempfile::tempdir().expect("a directory");
    let outcomes = in_parallel(MUTANTS, |mutant| {
        let place = mutant.name.replace(|c: char| !c.is_alphanumeric(), "_");
        let (bundle, source) = bundle(directory.path(), &place);
        edit(&bundle.join(mutant.file), mutant.find, mutant.replace);
        let report = match check_source(&bundle, &source, &ICARUS) {
            Ok(report) => report,
            Err(error) => return Some(format!("{}: {error} {error:?}", mutant.name)),
        };
        let found = report.first_difference;
        match found {
            Some(found) if !report.verified && found.signal == mutant.signal => None,
            Some(found) => Some(format!(
                "{}: found at {} (cycle {} of {}), not at {}",
                mutant.name, found.signal, found.cycle, found.segment, mutant.signal
            )),
            None => Some(format!("{}: survived", mutant.name)),
        }
    });
    let failures: Vec<String> = outcomes.into_iter().flatten().collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn a_weight_bit_is_named_by_layer_neuron_input_and_cycle() {
    let directory = tempfile::tempdir().expect("a directory");
    let (net, options) = fixture();
    let design = Design::new(&net, &options).expect("legal");
    let layers: Vec<&Layer> = design.perceptron().layers().collect();
    in_parallel(&layers, |layer| {
        let name = &layer.quant.name;
        let (bundle, source) = bundle(directory.path(), name);
        let design = &source.design;
        // The last neuron and input that have a weight of their own.
        let (neuron, input) = (layer.quant.outputs() - 1, layer.quant.inputs() - 1);
        let pe = neuron % layer.fold.pe;
        let group = neuron / layer.fold.pe * layer.synapse_folds();
        let address = group + input / layer.fold.simd;
        let simd = input % layer.fold.simd;
        let bits = layer.quant.weight_format.width();
        let bit = u32::try_from(simd).expect("small") * bits + 2;
        flip(
            &bundle.join(format!("rtl/mutant_{name}_w{pe}.v")),
            address,
            bit,
        );

        let found = first_difference(&bundle, &source, name);
        let feed = match layer.feed {
            Feed::Replay => "u_replay",
            Feed::Direct => "u_beats",
        };
        let counter = format!("u_mlp.u_{name}.{feed}.address_q");
        assert_eq!(
            found.signal,
            format!("mutant.u_mlp.u_{name}.u_w{pe}.data_q")
        );
        assert_eq!(found.simulator, "icarus");
        assert_eq!(found.segment, "corners x continuous");
        assert_eq!(found.cycle, first_read(design, &counter, address), "{name}");
        assert_eq!(found.network.as_deref(), Some(layer.quant.network.as_str()));
        assert_eq!(found.layer.as_ref(), Some(name));
        assert_eq!(
            (found.neuron, found.input),
            (Some(neuron), Some(input)),
            "{name}"
        );
        assert_eq!(found.lane, simd);
        let weight = layer.quant.weights[neuron][input];
        assert_eq!(found.model, weight, "{name}");
        assert_eq!(found.rtl, (weight ^ 4).to_string(), "{name}");
        let fraction =
            layer.quant.weight_format.fraction() + layer.quant.extra_shift[neuron].cast_signed();
        assert_eq!(
            found.model_real,
            Some((weight as f64) * 2f64.powi(-fraction))
        );
        the_files_are_there(&found);
        the_window_is_right(&found);
    });
}

/// A dump of the simulator, one of the model, and a save file that shows the signal.
fn the_files_are_there(found: &FirstDifference) {
    let [dump, model, save] = &found.files[..] else {
        panic!("three files: {:?}", found.files);
    };
    assert!(fs::metadata(dump).expect("a dump").len() > 0);
    let model = fs::read_to_string(model).expect("the model's dump");
    let name = found.signal.rsplit('.').next().expect("a name");
    assert!(model.contains("$enddefinitions"));
    assert!(model.contains(&format!(" {name} ")), "{name}");
    let save = fs::read_to_string(save).expect("a save file");
    let dump = dump.file_name().expect("a name").to_string_lossy();
    assert!(save.contains(&*dump), "{save}");
    let path = found.signal.split_once('.').expect("a path").1;
    assert!(
        save.contains(&format!("mutant_tb_icarus.u_tb.u_dut.{path}")),
        "{save}"
    );
    // The marker stands on the rising edge.
    let marker = 5_000 + 10_000 * found.cycle;
    assert!(save.contains(&format!(" {marker} ")), "{save}");
}

/// A line a cycle; equal before the one that is marked.
fn the_window_is_right(found: &FirstDifference) {
    let first = found.cycle.saturating_sub(6);
    for (i, line) in found.window.iter().enumerate() {
        let cycle = first + i;
        let mark = if cycle == found.cycle { '>' } else { ' ' };
        let values = line.strip_prefix(&format!("{mark} cycle {cycle}: model "));
        let (model, rtl) = values
            .and_then(|v| v.split_once(", icarus "))
            .unwrap_or_else(|| panic!("cycle {cycle}: {line}"));
        if cycle < found.cycle {
            assert_eq!(model, rtl, "{line}");
        }
        if cycle == found.cycle {
            assert_eq!((model, rtl), (&*found.model.to_string(), &*found.rtl));
        }
    }
    assert_eq!(found.window.len(), found.cycle - first + 7);
}

#[test]
fn a_bias_bit_a_shift_bit_and_a_missing_half_are_named() {
    let directory = tempfile::tempdir().expect("a directory");
    let (net, options) = fixture();
    let design = Design::new(&net, &options).expect("legal");
    // Layer, neuron, and the bit of its entry.
    let tanh = layer_of(&design, "a_l0");
    let shifted = tanh.quant.extra_shift.iter().rposition(|s| *s > 0);
    let shifted = shifted.expect("a neuron with a shift");
    let faults = [
        ("bias", "a_l0", 3, 5),
        ("bias", "b_l0", 2, 0),
        ("bias", "a_l1", 2, 1),
        ("half", "shared_l0", 4, 0),
        ("half", "b_l1", 1, 0),
        ("shift", "a_l0", shifted, tanh.quant.biased_width),
    ];
    in_parallel(&faults, |(kind, name, neuron, bit)| {
        let (bundle, source) = bundle(directory.path(), &format!("{kind}_{name}"));
        let layer = layer_of(&design, name);
        let entry = bias_rom_width(&layer.quant);
        let (address, lane) = (neuron / layer.lanes, neuron % layer.lanes);
        let lowest = u32::try_from(lane).expect("small") * entry;
        let rom = bundle.join(format!("rtl/mutant_{name}_bias.v"));
        if *kind == "half" {
            // A word that is cut instead of rounded: its half is not in the bias.
            let shift = layer.quant.base_shift + layer.quant.extra_shift[*neuron];
            edit_rom(&rom, address, |digits| {
                let text = std::str::from_utf8(digits).expect("digits");
                let word = u128::from_str_radix(text, 16).expect("a word");
                let field = (1u128 << layer.quant.biased_width) - 1;
                let old = word >> lowest & field;
                let half = 1u128 << (shift - 1);
                let new = old.wrapping_sub(half) & field;
                let word = word & !(field << lowest) | new << lowest;
                *digits = format!("{word:0>width$x}", width = digits.len()).into_bytes();
            });
        } else {
            flip(&rom, address, lowest + bit);
        }
        let what = format!("{kind} {name}");
        let found = first_difference(&bundle, &source, &what);
        let counter = format!("u_mlp.u_{name}.u_requant.beat_q");
        assert_eq!(found.signal, format!("mutant.u_mlp.u_{name}.u_bias.data_q"));
        assert_eq!(
            found.cycle,
            first_read(&design, &counter, address),
            "{what}"
        );
        assert_eq!(found.layer.as_deref(), Some(*name));
        assert_eq!(found.neuron, Some(*neuron), "{what}");
        the_window_is_right(&found);
    });
}

#[test]
fn a_bit_of_a_segment_is_named() {
    let directory = tempfile::tempdir().expect("a directory");
    let (bundle, source) = bundle(directory.path(), "segment");
    let table = layer_of(&source.design, "a_l0").quant.table.clone();
    let table = table.expect("a table");
    let rom = format!("rtl/mutant_tanh{}.v", table.fraction());
    flip(&bundle.join(rom), 2, 0);
    let found = first_difference(&bundle, &source, "segment");
    // The lane whose argument comes first to that segment.
    let path = found.signal.strip_prefix("mutant.u_mlp.u_a_l0.g_act[");
    let path = path.unwrap_or_else(|| panic!("{}", found.signal));
    assert!(path.ends_with("].u_segments.data_q"), "{path}");
    assert_eq!(found.layer.as_deref(), Some("a_l0"));
    assert!(found.neuron.is_some());
    the_window_is_right(&found);
}

/// Runs the binary and returns what it printed as JSON.
fn hwgen(place: &Path, arguments: &[&str]) -> (Option<i32>, serde_json::Value) {
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_hwgen"))
        .args(arguments)
        .arg("--json")
        .current_dir(place)
        .output()
        .expect("starts");
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    let value = serde_json::from_str(&text).unwrap_or_else(|e| panic!("{e}: {text}"));
    (output.status.code(), value)
}

/// As a user would do it: emit, flip one bit of one ROM word, renew its digest, verify.
#[test]
fn a_weight_bit_of_the_landing_design_is_named_on_the_command_line() {
    let directory = tempfile::tempdir().expect("a directory");
    let place = directory.path();
    let weights = Path::new(env!("CARGO_MANIFEST_DIR")).join("designs/landing/weights.json");
    let weights = weights.to_str().expect("UTF-8");
    let (code, _) = hwgen(place, &["emit", "--weights", weights, "--out", "landing"]);
    assert_eq!(code, Some(0));

    // Neuron 4 * 62 + 3 is computed by element 3 in clock 62 of a frame; 16 bits a weight.
    let (neuron, input, element, clock) = (251, 7, 3, 62);
    let name = format!("rtl/landing_position_l0_w{element}.v");
    let rom = place.join("landing").join(&name);
    let old = hwgen_gen::sha256(&fs::read_to_string(&rom).expect("a ROM"));
    flip(&rom, clock, 16 * input + 9);
    let new = hwgen_gen::sha256(&fs::read_to_string(&rom).expect("a ROM"));
    let verify = [
        "verify",
        "landing",
        "--random",
        "0",
        "--simulators",
        "icarus",
    ];
    let (code, json) = hwgen(place, &verify);
    assert_eq!((code, &json["ok"]), (Some(2), &false.into()), "{json}");

    edit(&place.join("landing/manifest.json"), &old, &new);
    let (code, json) = hwgen(place, &verify);
    assert_eq!(code, Some(1), "{json}");
    assert_eq!(json["verified"], false);
    assert_eq!(json["error"]["code"], "difference");
    let found = &json["first_difference"];
    let signal = format!("landing.u_mlp.u_position_l0.u_w{element}.data_q");
    assert_eq!(found["signal"], signal);
    assert_eq!(found["network"], "position");
    assert_eq!(found["layer"], "position_l0");
    assert_eq!(found["neuron"], neuron);
    assert_eq!(found["input"], input);
    // Three clocks of reset and one until the core is ready; the array's first operand 71 clocks
    // after the first beat (docs/microarchitecture.md, worked example), its weight one later.
    assert_eq!(found["cycle"], 4 + 71 + clock + 1);
    assert_eq!(found["segment"], "corners x continuous");
    let files = found["files"].as_array().expect("files");
    assert_eq!(files.len(), 3);
    for file in files {
        assert!(
            place.join(file.as_str().expect("a path")).is_file(),
            "{file}"
        );
    }
}
