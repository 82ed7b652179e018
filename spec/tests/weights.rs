//! The weights file: the landing network, limits, round trips and damaged files.

use std::path::Path;
use std::time::Instant;

use hwgen_spec::format::QFormat;
use hwgen_spec::network::{Activation, Calibration, FloatLayer, FloatNet, Inputs, LayerFormat};
use hwgen_spec::network::{Network, Outputs};
use hwgen_spec::weights::{self, MAX_BYTES, MAX_DEPTH, MAX_FRAMES, MAX_NETWORKS, MAX_NEURONS};
use proptest::prelude::*;

const TINY: &str = r#"{
  "format": "hwgen-weights/1", "name": "tiny",
  "inputs": {"names": ["u", "v"], "unit": "µm", "min": [-1, -1e0], "max": [1, 1.5],
             "offset": [0, 1], "scale": [1, 0.5], "resolution": 0.25},
  "shared": [{"activation": "relu", "weights": [[1, 0], [0.5, 1]]}],
  "networks": [{
    "name": "sum",
    "layers": [{"activation": "linear", "weights": [[0.5, -1]], "bias": [0.125],
                "format": {"weights": "Q3.12", "bias": "Q-2.24", "activations": "Q0.15"}}],
    "outputs": {"names": ["\u0079"], "unit": "m", "scale": [2], "offset": [-1]}
  }],
  "calibration": {"inputs": [[0, 0.5], [1, -7e-1]], "note": "bench µ"}
}"#;

fn landing(file: &str) -> Vec<u8> {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("../designs/landing");
    std::fs::read(directory.join(file)).unwrap()
}

#[test]
fn landing_has_its_shapes() {
    let net = weights::read(&landing("weights.json")).unwrap();
    assert_eq!(net.name, "landing");
    assert_eq!(net.inputs.names.len(), 10);
    assert_eq!(net.inputs.resolution, Some(1.0 / 64.0));
    let shape = |l: &FloatLayer| (l.activation, l.outputs(), l.inputs());
    let shared: Vec<_> = net.shared.iter().map(shape).collect();
    assert_eq!(shared, [(Activation::Linear, 10, 10)]);
    assert_eq!(net.networks.len(), 2);
    for network in &net.networks {
        let layers: Vec<_> = network.layers.iter().map(shape).collect();
        assert_eq!(
            layers,
            [
                (Activation::Tanh, 48, 10),
                (Activation::Tanh, 32, 48),
                (Activation::Linear, 3, 32)
            ]
        );
    }
    assert_eq!(net.macs(), 4324);
}

/// The outputs are those of another program, printed to 9 digits.
#[test]
fn landing_gives_the_outputs_beside_it() {
    let net = weights::read(&landing("weights.json")).unwrap();
    let text = String::from_utf8(landing("vectors.csv")).unwrap();
    let mut lines = text.lines();
    let header: Vec<_> = lines.next().unwrap().split(',').collect();
    let column = |name: &str| header.iter().position(|h| *h == name).unwrap();
    let inputs: Vec<_> = net.inputs.names.iter().map(|n| column(n)).collect();
    let outputs: Vec<_> = header
        .iter()
        .enumerate()
        .filter_map(|(i, h)| h.starts_with("float_").then_some(i))
        .collect();
    assert_eq!(outputs.len(), 6);
    let mut frames = 0;
    for line in lines {
        let row: Vec<f64> = line.split(',').map(|v| v.parse().unwrap()).collect();
        let raw: Vec<f64> = inputs.iter().map(|i| row[*i]).collect();
        let found = net.forward(&raw);
        for (output, i) in outputs.iter().enumerate() {
            let error = (found[output] - row[*i]).abs();
            assert!(
                error <= 1e-8 * row[*i].abs().max(1.0),
                "{line}: {} {error:e}",
                header[*i]
            );
        }
        frames += 1;
    }
    assert_eq!(frames, 500);
}

/// A file without frames would have its error measured over the box.
#[test]
fn shipped_designs_carry_calibration() {
    let designs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../designs");
    let mut checked = 0;
    for entry in std::fs::read_dir(designs).unwrap() {
        let path = entry.unwrap().path().join("weights.json");
        let Ok(text) = std::fs::read(&path) else {
            continue;
        };
        let net = weights::read(&text).unwrap();
        let calibration = net
            .calibration
            .unwrap_or_else(|| panic!("{}", path.display()));
        assert!(!calibration.note.is_empty(), "{}", path.display());
        assert!(calibration.inputs.len() >= 64, "{}", path.display());
        for row in &calibration.inputs {
            let edges = net.inputs.min.iter().zip(&net.inputs.max);
            for (value, (min, max)) in row.iter().zip(edges) {
                assert!((min..=max).contains(&value), "{}: {row:?}", path.display());
            }
        }
        checked += 1;
    }
    assert!(checked >= 5, "{checked}");
}

#[test]
fn landing_reads_fast() {
    let text = landing("weights.json");
    let best = (0..20)
        .map(|_| {
            let start = Instant::now();
            std::hint::black_box(weights::read(std::hint::black_box(&text)).unwrap());
            start.elapsed()
        })
        .min()
        .unwrap();
    println!("landing read in {best:?}");
    let most_ms = if cfg!(debug_assertions) { 100 } else { 10 };
    assert!(best.as_millis() < most_ms, "{best:?}");
}

#[test]
fn a_refusal_answers_with_its_parts() {
    let text = TINY.replace("\"relu\"", "\"relue\"");
    let error = weights::read(text.as_bytes()).unwrap_err();
    assert_eq!(error.code(), "unknown-activation");
    assert_eq!(error.path(), "shared[0].activation");
    assert_eq!((error.line(), error.column()), (5, 29));
    assert_eq!(
        error.message(),
        "one of tanh, sigmoid, relu, linear expected, \"relue\" found"
    );
    assert_eq!(
        error.to_string(),
        format!("{}: {}", error.path(), error.message())
    );
    assert_eq!(error.help(), Some("did you mean \"relu\"?"));
}

#[test]
fn encodings_other_than_plain_utf8_are_refused() {
    let refused = |text: &[u8]| weights::read(text).unwrap_err().render("w.json");
    let mut latin = TINY.replace("µm", "?m").into_bytes();
    let byte = latin.iter().position(|b| *b == b'?').unwrap();
    latin[byte] = 0xb5;
    assert_eq!(
        refused(&latin),
        format!(
            "error: w.json:3:44: inputs.unit: \
             UTF-8 expected, the byte B5 found at byte offset {byte}\nhelp: save the file as UTF-8"
        )
    );
    assert_eq!(
        refused(b"\xff\xfe{\0}\0"),
        "error: w.json:1:1: UTF-8 expected, the byte FF found at byte offset 0\n\
         help: the file looks like UTF-16; save it as UTF-8"
    );
    assert_eq!(
        refused(b"\xef\xbb\xbf{}"),
        "error: w.json:1:1: JSON without a byte order mark expected, the bytes EF BB BF found\n\
         help: save the file as UTF-8 without a byte order mark"
    );
}

#[test]
fn limits_are_kept() {
    let code = |text: &str| weights::read(text.as_bytes()).unwrap_err().code();
    assert_eq!(code(&" ".repeat(MAX_BYTES)), "syntax");
    assert_eq!(code(&" ".repeat(MAX_BYTES + 1)), "too-large");
    assert_eq!(code(&"[".repeat(MAX_DEPTH)), "syntax");
    assert_eq!(code(&"[".repeat(MAX_BYTES)), "too-deep");
    assert_eq!(code(&r#"{"a":"#.repeat(MAX_DEPTH + 1)), "too-deep");
    let long = format!("{{\"{}\": 1}}", "format".repeat(1 << 20));
    assert_eq!(code(&long), "missing-key");

    let mut net = weights::read(TINY.as_bytes()).unwrap();
    net.networks[0].layers[0].format = LayerFormat::default();
    let verdict = |net: &FloatNet| {
        let read = weights::read(weights::to_json(net).as_bytes());
        read.map_err(|error| (error.code(), error.path().to_owned()))
    };
    let many = FloatNet {
        networks: (0..=MAX_NETWORKS)
            .map(|i| Network {
                name: format!("n{i}"),
                ..net.networks[0].clone()
            })
            .collect(),
        ..net.clone()
    };
    assert_eq!(verdict(&many), Err(("too-many", "networks".to_owned())));
    let calibrated = |frames: usize, note: &str| FloatNet {
        calibration: Some(Calibration {
            inputs: vec![vec![0.5, 2.0]; frames],
            note: note.to_owned(),
        }),
        ..net.clone()
    };
    let place = || "calibration.inputs".to_owned();
    assert!(verdict(&calibrated(MAX_FRAMES, "")).is_ok());
    let many = calibrated(MAX_FRAMES + 1, "");
    assert_eq!(verdict(&many), Err(("too-many", place())));
    assert_eq!(verdict(&calibrated(0, "")), Err(("empty", place())));
    assert!(verdict(&calibrated(1, &"µ".repeat(1000))).is_ok());
    let long = calibrated(1, &"µ".repeat(1001));
    let place = "calibration.note".to_owned();
    assert_eq!(verdict(&long), Err(("bad-note", place)));
    // With one network's own layer there may be 63 shared ones, and no more.
    net.shared = vec![net.shared[0].clone(); 63];
    assert!(verdict(&net).is_ok());
    net.networks[0].layers.insert(0, net.shared[0].clone());
    let place = "networks[0].layers".to_owned();
    assert_eq!(verdict(&net), Err(("too-many", place)));
    let row = "[0, 0],".repeat(MAX_NEURONS) + "[0, 0]";
    let wide = TINY.replace("[1, 0], [0.5, 1]", &row);
    assert_eq!(code(&wide), "too-many");
    let wide = TINY.replace(
        "[-1, -1e0]",
        &format!("[{}]", "0,".repeat(MAX_NEURONS) + "0"),
    );
    assert_eq!(code(&wide), "too-many");
}

#[test]
fn every_keyword_list_guards_every_name_of_a_module() {
    for keyword in ["endmodule", "logic", "downto", "DOWNTO"] {
        let read = |name: &str| {
            let text = TINY.replace(&format!("\"{name}\""), &format!("\"{keyword}\""));
            assert_ne!(text, TINY, "{name}");
            weights::read(text.as_bytes())
        };
        for name in ["tiny", "sum"] {
            assert_eq!(
                read(name).unwrap_err().code(),
                "keyword",
                "{keyword} for {name}"
            );
        }
        // Names of inputs and outputs are columns and comments, never identifiers.
        for name in ["u", "\\u0079"] {
            assert!(read(name).is_ok(), "{keyword} for {name}");
        }
    }
}

#[test]
fn defaults_stand_for_what_is_left_out() {
    let net = weights::read(
        br#"{"format": "hwgen-weights/1", "name": "t", "inputs": {"min": [0, 0], "max": [1, 0]},
            "networks": [{"name": "n", "layers": [{"activation": "sigmoid", "weights": [[1, 2]]}]}]}"#,
    )
    .unwrap();
    let layer = &net.networks[0].layers[0];
    assert_eq!(
        (&*layer.bias, layer.format),
        (&[0.0][..], LayerFormat::default())
    );
    let inputs = Inputs {
        names: vec!["in0".to_owned(), "in1".to_owned()],
        unit: String::new(),
        min: vec![0.0, 0.0],
        max: vec![1.0, 0.0],
        offset: vec![0.0, 0.0],
        scale: vec![1.0, 1.0],
        resolution: None,
    };
    assert_eq!(net.inputs, inputs);
    assert!(net.shared.is_empty());
    assert_eq!(net.calibration, None);
    let outputs = Outputs {
        names: vec!["out0".to_owned()],
        unit: String::new(),
        scale: vec![1.0],
        offset: vec![0.0],
    };
    assert_eq!(net.networks[0].outputs, outputs);
}

#[test]
fn written_files_read_back_the_same() {
    for text in [TINY.as_bytes(), &landing("weights.json")] {
        let net = weights::read(text).unwrap();
        let written = weights::to_json(&net);
        assert_eq!(weights::read(written.as_bytes()).unwrap(), net);
    }
    let net = weights::read(TINY.as_bytes()).unwrap();
    let layer = &net.networks[0].layers[0];
    assert_eq!(layer.format.bias, Some(QFormat::new(23, 24).unwrap()));
    let rows = weights::to_json(&net);
    for lines in [
        "\n        [1.0, 0.0],\n        [0.5, 1.0]\n",
        "\n      [0.0, 0.5],\n      [1.0, -0.7]\n    ],\n    \"note\": \"bench µ\"\n",
    ] {
        assert!(rows.contains(lines), "{rows}");
    }
    let mut net = net;
    for note in ["", "one"] {
        net.calibration.as_mut().expect("frames").note = note.to_owned();
        let written = weights::to_json(&net);
        assert_eq!(weights::read(written.as_bytes()).unwrap(), net);
    }
}

fn finite() -> impl Strategy<Value = f64> {
    any::<f64>().prop_filter("finite", |v| v.is_finite())
}

fn layer(outputs: usize, inputs: usize) -> impl Strategy<Value = FloatLayer> {
    let activation = prop::sample::select(Activation::ALL.to_vec());
    let weights = prop::collection::vec(finite(), outputs * inputs);
    let bias = prop::collection::vec(finite(), outputs);
    (activation, weights, bias).prop_map(move |(activation, weights, bias)| FloatLayer {
        activation,
        weights: nalgebra::DMatrix::from_row_slice(outputs, inputs, &weights),
        bias,
        format: LayerFormat::default(),
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_numbers_survive_a_round_trip(
        shared in layer(4, 2), hidden in layer(3, 4), last in layer(1, 3),
        unit in "[^\\pC]{0,32}", offset in finite(), resolution in proptest::option::of(1e-300..1e300),
        frames in prop::collection::vec(prop::collection::vec(finite(), 2), 1..4),
        note in "[^\\pC]{0,32}",
    ) {
        let mut net = weights::read(TINY.as_bytes()).unwrap();
        net.shared = vec![shared];
        net.networks[0].layers = vec![hidden, last];
        net.networks[0].outputs.offset = vec![offset];
        net.inputs.unit = unit;
        net.inputs.resolution = resolution;
        net.calibration = Some(Calibration { inputs: frames, note });
        let read = weights::read(weights::to_json(&net).as_bytes());
        prop_assert_eq!(read, Ok(net));
    }

    #[test]
    fn damaged_files_are_answered(
        edits in prop::collection::vec((0..TINY.len(), any::<u8>(), 0..3u8), 0..6),
        length in 0..=2 * TINY.len(),
    ) {
        let mut text = TINY.as_bytes().to_vec();
        for (at, byte, edit) in edits {
            match edit {
                0 => text[at] ^= byte,
                1 => text[at] = b"{}[]\",:\\0-.eE+n\nu"[usize::from(byte) % 17],
                _ => text.insert(at, byte),
            }
        }
        text.truncate(length);
        if let Err(error) = weights::read(&text) {
            prop_assert!(error.line() >= 1 && error.column() >= 1);
            prop_assert!(error.message().contains(" expected"), "{error}");
            prop_assert!(error.message().ends_with(" found")
                || error.message().contains(" found: ")
                || error.message().contains(" found at ")
                || error.message().ends_with(" found again"), "{error}");
        }
    }

    #[test]
    fn moved_pieces_are_answered(from in 0..TINY.len(), length in 0..60usize, to in 0..TINY.len()) {
        let text = TINY.as_bytes();
        let piece = &text[from..(from + length).min(text.len())];
        let moved = [&text[..to], piece, &text[to..]].concat();
        let _ = weights::read(&moved);
    }
}
