//! Faults in what takes the place of multipliers: adders of short weights, activations' multipliers
//! of logic.

use std::path::{Path, PathBuf};

use hwgen_gen::Source;
use hwgen_spec::design::Design;
use hwgen_spec::network::{
    Activation, FloatLayer, FloatNet, Inputs, LayerFormat, Network, Outputs,
};
use hwgen_spec::options::{Budget, Options};
use nalgebra::{DMatrix, dmatrix};

use super::support::{assert_verified, axes, check, emit};
use super::table::Mutant;
use super::{ICARUS, hunt};

/// More multipliers than the device has: those of the activations are made of logic.
fn fixture() -> (FloatNet, Options) {
    let layer = |activation, weights: DMatrix<f64>| FloatLayer {
        activation,
        bias: vec![0.125; weights.nrows()],
        weights,
        format: LayerFormat::default(),
    };
    // Terms that two sums share, a word that waits for them, a sum of one word turned, one of nothing.
    let shared = dmatrix![
        1.0, 2.0, 0.0, -1.0;
        1.0, 2.0, 4.0, 0.0;
        0.0, 0.0, -0.5, 0.0;
        0.0, 0.0, 0.0, 0.0;
        0.0, 0.5, 0.0, -0.25
    ];
    let noise = |i: usize, j: usize| ((7 * i + 5 * j) % 11) as f64 / 11.0 - 0.45;
    let net = FloatNet {
        name: "short".into(),
        inputs: Inputs {
            names: (0..4).map(|i| format!("in{i}")).collect(),
            unit: "V".into(),
            min: vec![-1.0; 4],
            max: vec![1.0; 4],
            offset: vec![0.0; 4],
            scale: vec![1.0; 4],
            resolution: Some(1.0 / 64.0),
        },
        shared: vec![layer(Activation::Linear, shared)],
        networks: vec![Network {
            name: "net".into(),
            layers: vec![
                layer(Activation::Tanh, DMatrix::from_fn(5, 5, noise)),
                layer(Activation::Linear, DMatrix::from_fn(2, 5, noise)),
            ],
            outputs: Outputs {
                names: vec!["out0".into(), "out1".into()],
                unit: "m".into(),
                scale: vec![1.0; 2],
                offset: vec![0.0; 2],
            },
        }],
        calibration: None,
    };
    let options = Options {
        device: Some("ecp5-25k".into()),
        budget: Budget::Interval(1),
        ..Options::default()
    };
    (net, options)
}

fn bundle(directory: &Path, name: &str) -> (PathBuf, Source) {
    let (net, options) = fixture();
    let bundle = emit(&net, &options, &directory.join(name));
    let source = Source::read(&bundle).expect("a bundle as it was emitted");
    (bundle, source)
}

const ADDERS: &str = "rtl/short__shared_l0_adders.v";

const MUTANTS: &[Mutant] = &[
    Mutant {
        name: "difference the other way round",
        file: "rtl/hwg_add.v",
        find: "SUBTRACT != 0 ? a - b",
        replace: "SUBTRACT != 0 ? b - a",
        signal: "short.u_mlp.u_shared_l0.u_adders.u_add3.sum_q",
    },
    Mutant {
        name: "difference added",
        file: "rtl/hwg_add.v",
        find: "SUBTRACT != 0 ? a - b",
        replace: "SUBTRACT > 1 ? a - b",
        signal: "short.u_mlp.u_shared_l0.u_adders.u_add3.sum_q",
    },
    Mutant {
        name: "word not moved up",
        file: "rtl/hwg_add.v",
        find: "b_i} << B_SHIFT",
        replace: "b_i}",
        signal: "short.u_mlp.u_shared_l0.u_adders.u_add0.sum_q",
    },
    Mutant {
        name: "word without its sign",
        file: "rtl/hwg_add.v",
        find: "{{WIDTH{b_i[B_WIDTH-1]}}, b_i}",
        replace: "{{WIDTH{1'b0}}, b_i}",
        signal: "short.u_mlp.u_shared_l0.u_adders.u_add0.sum_q",
    },
    Mutant {
        name: "word that does not wait",
        file: ADDERS,
        find: "x3_q   <= x3;",
        replace: "x3_q   <= x2;",
        signal: "short.u_mlp.u_shared_l0.u_adders.x3_q",
    },
    Mutant {
        name: "sum that comes a clock early",
        file: ADDERS,
        find: "{{5{sum3_q[8]}}, sum3_q[7:0]",
        replace: "{{5{sum3[8]}}, sum3[7:0]",
        signal: "short.u_mlp.u_shared_l0.u_requant.sum_q",
    },
    Mutant {
        name: "sum of another neuron",
        file: ADDERS,
        find: "sums_o[0 +:",
        replace: "sums_o[1 +:",
        signal: "short.u_mlp.u_shared_l0.u_requant.sum_q",
    },
    Mutant {
        name: "upper bit of a pair lost",
        file: "rtl/hwg_mul_logic.v",
        find: "assign b = b_i[2*i +: 2];",
        replace: "assign b = {1'b0, b_i[2*i]};",
        signal: "short.u_mlp.u_net_l0.g_act[0].u_mul.g_pair[0].sum_q",
    },
    Mutant {
        name: "upper pair not moved up",
        file: "rtl/hwg_mul_logic.v",
        find: "{g_pair[2*i+1].sum_q, 2'b0}",
        replace: "{2'b0, g_pair[2*i+1].sum_q}",
        signal: "short.u_mlp.u_net_l0.g_act[0].u_mul.g_quad[0].sum_q",
    },
    Mutant {
        name: "upper quad not moved up",
        file: "rtl/hwg_mul_logic.v",
        find: "+ quads[j*QUAD_WIDTH",
        replace: "+ quads[0*QUAD_WIDTH",
        signal: "short.u_mlp.u_net_l0.g_act[0].u_mul.p_q",
    },
    Mutant {
        name: "table of a carry chain",
        file: "rtl/hwg_pair.v",
        find: ".INIT1    (16'h7888)",
        replace: ".INIT1    (16'hf888)",
        signal: "short.u_mlp.u_net_l0.g_act[0].u_mul.g_pair[0].sum_q",
    },
];

#[test]
fn the_fixture_has_what_mutants_of_short_weights_need() {
    let (net, options) = fixture();
    let axes = axes(&net, &Design::new(&net, &options).expect("legal"));
    for axis in [
        "sums by adders",
        "adders in levels",
        "sums of nothing",
        "activations' multipliers in logic",
    ] {
        assert!(axes.contains(axis), "{axis}: {axes:?}");
    }
    let directory = tempfile::tempdir().expect("a directory");
    let (bundle, _) = bundle(directory.path(), "control");
    assert_verified(&check(&bundle, &ICARUS).expect("Icarus runs"), "control");
}

#[test]
fn every_mutant_of_short_weights_is_found() {
    hunt(MUTANTS, bundle);
}
