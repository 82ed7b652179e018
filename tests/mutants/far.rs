//! Faults in what distance asks for: words that take a clock to a copy on their way into a long vector,
//! segments in several tables of which one is chosen a clock later.

use std::path::{Path, PathBuf};

use hwgen_gen::Source;
use hwgen_spec::design::Design;
use hwgen_spec::network::{
    Activation, FloatLayer, FloatNet, Inputs, LayerFormat, Network, Outputs,
};
use hwgen_spec::options::{Budget, Options};
use nalgebra::DMatrix;

use super::support::{assert_verified, axes, check, check_source, emit};
use super::table::Mutant;
use super::{ICARUS, edit, hunt};

/// Ten beats of a vector, and 128 segments on a device whose tables have 64 words.
fn fixture() -> (FloatNet, Options) {
    let layer = |activation, outputs: usize, inputs: usize| FloatLayer {
        activation,
        weights: DMatrix::from_fn(outputs, inputs, |i, j| {
            ((7 * i + 5 * j) % 11) as f64 / 2.2 - 2.3
        }),
        bias: vec![0.125; outputs],
        format: LayerFormat::default(),
    };
    let net = FloatNet {
        name: "far".into(),
        inputs: Inputs {
            names: (0..2).map(|i| format!("in{i}")).collect(),
            unit: "V".into(),
            min: vec![-1.0; 2],
            max: vec![1.0; 2],
            offset: vec![0.0; 2],
            scale: vec![1.0; 2],
            resolution: Some(1.0 / 64.0),
        },
        shared: Vec::new(),
        networks: vec![Network {
            name: "net".into(),
            layers: vec![
                layer(Activation::Tanh, 10, 2),
                layer(Activation::Linear, 10, 10),
            ],
            outputs: Outputs {
                names: (0..10).map(|o| format!("out{o}")).collect(),
                unit: "m".into(),
                scale: vec![1.0; 10],
                offset: vec![0.0; 10],
            },
        }],
        calibration: None,
    };
    let options = Options {
        device: Some("ecp5-25k".into()),
        budget: Budget::Interval(20),
        segments: Some(128),
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

const MUTANTS: &[Mutant] = &[
    Mutant {
        name: "word on its way to another beat's place",
        file: "rtl/hwg_gather.v",
        find: "assign data = data_q;",
        replace: "assign data = data_i;",
        signal: "far.u_mlp.u_net_l0_gather.slot_q",
    },
    Mutant {
        name: "beat told a clock before its copy",
        file: "rtl/hwg_gather.v",
        find: "assign next = valid_i;",
        replace: "assign next = next_i;",
        signal: "far.u_mlp.u_net_l0_gather.place_q",
    },
    Mutant {
        name: "segment of the other table",
        file: "rtl/far__tanh12.v",
        find: "above_q[0 +: 1] < 1'd1 ? table0_q",
        replace: "above_q[0 +: 1] < 1'd1 ? table1_q",
        signal: "far.u_mlp.u_net_l0.g_act[0].u_segments.data_q",
    },
    Mutant {
        name: "table chosen by the complement of a segment",
        file: "rtl/far__tanh12.v",
        find: "above_q <= address_i",
        replace: "above_q <= ~address_i",
        signal: "far.u_mlp.u_net_l0.g_act[0].u_segments.above_q",
    },
    Mutant {
        name: "distance of the segment that follows",
        file: "rtl/hwg_pwl.v",
        find: "distance_q[(TABLE-1)*DISTANCE_WIDTH +: DISTANCE_WIDTH];",
        replace: "distance_q[0 +: DISTANCE_WIDTH];",
        signal: "far.u_mlp.u_net_l0.g_act[0].u_mul.a_q",
    },
];

#[test]
fn the_fixture_has_what_mutants_of_distance_need() {
    let (net, options) = fixture();
    let axes = axes(&net, &Design::new(&net, &options).expect("legal"));
    for axis in ["words by way of a copy", "segments in several tables"] {
        assert!(axes.contains(axis), "{axis}: {axes:?}");
    }
    let directory = tempfile::tempdir().expect("a directory");
    let (bundle, _) = bundle(directory.path(), "control");
    assert_verified(&check(&bundle, &ICARUS).expect("Icarus runs"), "control");
}

#[test]
fn every_mutant_of_distance_is_found() {
    hunt(MUTANTS, bundle);
}

/// A line of the upper table gone wrong where it leaves the ROM, and four clocks later: the neuron is the
/// same, and so are the words between.
#[test]
fn a_neuron_behind_several_tables_is_named() {
    let directory = tempfile::tempdir().expect("a directory");
    let (net, options) = fixture();
    let design = Design::new(&net, &options).expect("legal");
    let layer = &design.perceptron().networks[0].layers[0];
    let table = layer.quant.table.as_ref().expect("a table");
    let offset = table.line_of(70).0;
    assert_eq!(table.lines().filter(|line| line.0 == offset).count(), 1);
    let slope = table.slope_width();
    let find = |file: &str, find: &str, replace: String| {
        let (bundle, source) = bundle(directory.path(), &file.replace('.', "_"));
        edit(&bundle.join("rtl").join(file), find, &replace);
        let report = check_source(&bundle, &source, &ICARUS).expect("Icarus runs");
        report.first_difference.expect("a difference")
    };
    let early = find(
        "far__tanh12.v",
        "      table1_q;",
        format!("      table1_q ^ (table1_q >> {slope} == {offset});"),
    );
    let late = find(
        "far__hwg_pwl.v",
        "<= base + ",
        format!("<= (base ^ (old_offset == {offset})) + "),
    );
    assert!(
        early.signal.ends_with("].u_segments.data_q"),
        "{}",
        early.signal
    );
    assert!(late.signal.ends_with("].u_pwl.sum_q"), "{}", late.signal);
    assert_eq!(late.cycle, early.cycle + 4);
    assert!(early.neuron.is_some());
    assert_eq!(late.neuron, early.neuron);
}
