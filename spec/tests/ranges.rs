//! Inputs of very different magnitude, and hidden words that not all of their readers need alike.

use hwgen_spec::design::Design;
use hwgen_spec::network::FloatNet;
use hwgen_spec::options::{Options, WidthSetting};
use hwgen_spec::quantize::{QuantizeError, quantize};
use hwgen_spec::weights;

/// A design with inputs of these boxes and these networks' layers, in JSON.
fn net(min: &[f64], max: &[f64], layers: &str) -> FloatNet {
    let text = format!(
        r#"{{"format": "hwgen-weights/1", "name": "ranges",
          "inputs": {{"min": {min:?}, "max": {max:?}}},
          "networks": [{{"name": "net", "layers": [{layers}]}}]}}"#
    );
    weights::read(text.as_bytes()).expect("a weights file")
}

fn design(net: &FloatNet) -> Result<Design, QuantizeError> {
    Design::new(net, &Options::default()).map_err(|e| match e {
        hwgen_spec::design::DesignError::Quantize(e) => e,
        other => panic!("{other}"),
    })
}

/// Greatest difference from the float network over a grid of the box, in parts of the output's
/// range, inputs other than `varied` in the middle of theirs.
fn error(net: &FloatNet, varied: usize) -> f64 {
    let design = design(net).expect("a design");
    let (mut worst, mut low, mut high) = (0.0f64, f64::MAX, f64::MIN);
    for step in 0..=1000 {
        let edges = net.inputs.min.iter().zip(&net.inputs.max);
        let mut raw: Vec<f64> = edges.map(|(a, b)| f64::midpoint(*a, *b)).collect();
        let (from, to) = (net.inputs.min[varied], net.inputs.max[varied]);
        raw[varied] = from + (to - from) * f64::from(step) / 1000.0;
        let answer = design.net().evaluate(&design.input().codes(&raw));
        let found = design.net().real_outputs(&answer.codes)[0];
        let float = net.forward(&raw)[0];
        worst = worst.max((found - float).abs());
        (low, high) = (low.min(float), high.max(float));
    }
    worst / (high - low)
}

#[test]
fn every_input_has_its_own_binary_point() {
    for (large, small) in [(10_000.0, 1.0), (100_000.0, 0.1), (1000.0, 0.01)] {
        // Both inputs count alike.
        let layers = format!(
            r#"{{"activation": "tanh", "weights": [[{}, {}]], "bias": [-1]}},
               {{"activation": "linear", "weights": [[1]]}}"#,
            1.0 / large,
            1.0 / small
        );
        for flipped in [false, true] {
            let mut max = [large, small];
            let mut layers = layers.clone();
            if flipped {
                max.reverse();
                layers = layers.replace(
                    &format!("[[{}, {}]]", 1.0 / large, 1.0 / small),
                    &format!("[[{}, {}]]", 1.0 / small, 1.0 / large),
                );
            }
            let net = net(&[0.0, 0.0], &max, &layers);
            let design = design(&net).expect("a design");
            for (i, format) in design.input().formats.iter().enumerate() {
                assert_eq!(format.width(), 16);
                let codes = design.input().high[i] - design.input().low[i];
                assert!(codes > 1 << 13, "{max:?}: {codes} codes of input {i}");
            }
            for varied in 0..2 {
                let error = error(&net, varied);
                assert!(error < 1e-3, "{max:?}, input {varied}: {error}");
            }
        }
    }
}

#[test]
fn a_resolution_holds_for_all_inputs() {
    let mut net = net(
        &[0.0, 0.0],
        &[1000.0, 1.0],
        r#"{"activation": "linear", "weights": [[1, 1]]}"#,
    );
    net.inputs.resolution = Some(0.25);
    let formats = design(&net).expect("a design").input().formats.clone();
    assert_eq!(formats[0], formats[1]);
    assert_eq!(formats[0].fraction(), 2);
    net.inputs.resolution = Some(4.0);
    let refused = design(&net).expect_err("one code");
    assert!(
        matches!(&refused, QuantizeError::OneCode { input, .. } if input == "in1"),
        "{refused}"
    );
}

/// The code of the greatest edge, 65535, has 17 bits; without one it rounds to 32768, which has 17 as
/// well, so that a second one goes.
#[test]
fn inputs_are_no_wider_than_the_multipliers_of_the_device() {
    let mut net = net(
        &[0.0],
        &[1023.99],
        r#"{"activation": "linear", "weights": [[1]]}"#,
    );
    net.inputs.resolution = Some(1.0 / 64.0);
    let input = |device: Option<&str>| {
        let options = Options {
            device: device.map(str::to_owned),
            ..Options::default()
        };
        let input = quantize(&net, &options).expect("a design").input;
        (input.format.width(), input.dropped_bits)
    };
    assert_eq!(input(None), (17, 0));
    assert_eq!(input(Some("ecp5-25k")), (17, 0));
    assert_eq!(input(Some("ice40-up5k")), (16, 2));
}

#[test]
fn weights_that_were_fixed_keep_one_format() {
    let layers = r#"{"activation": "linear", "weights": [[1, 1]], "format": {"weights": "Q1.6"}}"#;
    let fixed = net(&[0.0, 0.0], &[1000.0, 1.0], layers);
    let design_of_fixed = design(&fixed).expect("a design");
    let formats = &design_of_fixed.input().formats;
    assert_eq!(formats[0], formats[1]);
    let collapsed = net(&[0.0, 0.0], &[100_000.0, 0.1], layers);
    assert!(matches!(
        design(&collapsed),
        Err(QuantizeError::OneCode { .. })
    ));
    // With a scale there is a layer before them that takes the powers of two.
    let mut scaled = collapsed;
    scaled.inputs.scale = vec![1e-5, 10.0];
    for varied in 0..2 {
        let error = error(&scaled, varied);
        assert!(error < 1e-3, "input {varied}: {error}");
    }
}

#[test]
fn inputs_that_round_away_are_named() {
    let layers = r#"{"activation": "linear", "weights": [[1, 0, 0.3]]}"#;
    let design = design(&net(&[0.0; 3], &[1e6, 1e6, 0.01], layers)).expect("a design");
    assert_eq!(design.net().networks[0].layers[0].unread, [2]);
}

#[test]
fn hidden_words_are_cut_behind_every_reader_only() {
    // A bias moves where a reader saturates.
    let biased = net(
        &[0.0],
        &[20.0],
        r#"{"activation": "relu", "weights": [[1]]},
           {"activation": "sigmoid", "weights": [[10]], "bias": [-100]}"#,
    );
    // Of four readers one is not saturated early.
    let spread = net(
        &[-20.0],
        &[20.0],
        r#"{"activation": "linear", "weights": [[1]]},
           {"activation": "tanh", "weights": [[0.05], [10], [10], [10]]}"#,
    );
    // Of two words one is read with small weights.
    let columns = net(
        &[-1.0, -1000.0],
        &[1.0, 1000.0],
        r#"{"activation": "linear", "weights": [[1, 0], [0, 1]]},
           {"activation": "tanh", "weights": [[0.1, 0.001]]}"#,
    );
    assert!(error(&biased, 0) < 0.01, "{}", error(&biased, 0));
    assert!(error(&spread, 0) < 0.01, "{}", error(&spread, 0));
    assert!(error(&columns, 1) < 0.01, "{}", error(&columns, 1));
    // Where all saturate, the word stays narrow.
    let design = design(&net(
        &[-1000.0],
        &[1000.0],
        r#"{"activation": "linear", "weights": [[1]]}, {"activation": "tanh", "weights": [[1]]}"#,
    ))
    .expect("a design");
    assert_eq!(design.net().networks[0].layers[0].output.integer(), 2);
}

#[test]
fn numbers_out_of_all_proportion_are_refused_as_such() {
    let tanh =
        |weight: f64| format!(r#"{{"activation": "tanh", "weights": [[{weight:e}, {weight:e}]]}}"#);
    for weight in [1e-300, 5e-324, 1e-30, 1e30, 1.7e308] {
        let refused = design(&net(&[-1.0; 2], &[1.0; 2], &tanh(weight))).expect_err("far off");
        let QuantizeError::Magnitude { what, .. } = &refused else {
            panic!("{weight:e}: {refused}");
        };
        assert!(what.starts_with("net_l0: "), "{what}");
    }
    let refused = design(&net(&[0.0; 2], &[1e-300; 2], &tanh(1.0))).expect_err("a tiny box");
    assert!(
        matches!(refused, QuantizeError::Magnitude { .. }),
        "{refused}"
    );
    let mut fine = net(&[0.0; 2], &[1.0; 2], &tanh(1.0));
    fine.inputs.resolution = Some(1e-300);
    let refused = design(&fine).expect_err("a fine step").to_string();
    assert_eq!(
        refused,
        "inputs: words for the box at this resolution: 3 to 24 bits expected, 999 found"
    );
    fine.inputs.resolution = Some(5e-324);
    let refused = design(&fine).expect_err("a finer step");
    assert!(
        matches!(refused, QuantizeError::Magnitude { .. }),
        "{refused}"
    );
}

#[test]
fn options_without_effect_are_refused() {
    let linear = r#"{"activation": "linear", "weights": [[1]]}"#;
    let tanh = r#"{"activation": "tanh", "weights": [[1]]}"#;
    let fixed = r#"{"activation": "tanh", "weights": [[1]],
                    "format": {"weights": "Q1.6", "activations": "Q0.9"}}"#;
    let named = |bits, layer: &str| {
        let layer = Some(layer.to_owned());
        vec![WidthSetting { layer, bits }]
    };
    let none = Options::default;
    let cases = [
        (
            tanh,
            Options {
                output_bits: Some(32),
                ..none()
            },
            "output-bits 32: a last layer that is linear or relu without `format.activations` \
             expected, net_l0, tanh found",
        ),
        (
            linear,
            Options {
                activation_bits: named(20, "net_l0"),
                ..none()
            },
            "activation-bits net_l0=20: a hidden, tanh or sigmoid layer (see output-bits) \
             expected, the last layer, linear found",
        ),
        (
            fixed,
            Options {
                weight_bits: named(5, "net_l0"),
                ..none()
            },
            "weight-bits net_l0=5: a layer without `format.weights` expected, one of Q1.6 found",
        ),
        (
            fixed,
            Options {
                activation_bits: named(5, "net_l0"),
                ..none()
            },
            "activation-bits net_l0=5: a layer without `format.activations` expected, one of \
             Q0.9 found",
        ),
        (
            linear,
            Options {
                segments: Some(8),
                ..none()
            },
            "segments 8: a tanh or sigmoid layer expected, only linear found",
        ),
        (
            linear,
            Options {
                segments: Some(7),
                ..none()
            },
            "segments: a power of two from 4 to 4096 expected, 7 found",
        ),
    ];
    for (layer, options, expected) in cases {
        let net = net(&[-1.0], &[1.0], layer);
        let refused = Design::new(&net, &options).expect_err(expected);
        assert_eq!(refused.to_string(), expected);
    }
    // A setting for all layers applies where it can.
    let all = Options {
        weight_bits: vec![WidthSetting {
            layer: None,
            bits: 5,
        }],
        activation_bits: vec![WidthSetting {
            layer: None,
            bits: 9,
        }],
        ..none()
    };
    assert!(Design::new(&net(&[-1.0], &[1.0], fixed), &all).is_ok());
}

#[test]
fn words_and_weights_of_deep_networks_are_wider() {
    let tanh = r#"{"activation": "tanh", "weights": [[1]]}"#;
    let linear = r#"{"activation": "linear", "weights": [[1]]}"#;
    // A last layer is none that another one magnifies.
    for (layers, width) in [
        (vec![tanh, linear], 13),
        (vec![tanh, tanh], 13),
        (vec![tanh, tanh, linear], 14),
        (vec![tanh, linear, tanh, linear], 14),
    ] {
        let net = net(&[-1.0], &[1.0], &layers.join(","));
        let design = design(&net).expect("a design");
        let first = &design.net().networks[0].layers[0];
        assert_eq!(first.output.width(), width, "{layers:?}");
        let weights = if width == 14 { 18 } else { 16 };
        assert_eq!(first.weight_format.width(), weights, "{layers:?}");
    }
}
