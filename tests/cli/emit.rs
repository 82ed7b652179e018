//! `hwgen emit`, `hwgen schema`, usage.

use super::harness::{Place, frames, scales};

#[test]
fn weights_alone_lead_to_a_bundle_in_build() {
    let place = Place::new();
    let ran = place.run(&["emit", "--weights", "w.json"]);
    ran.exits(0);
    assert_eq!(ran.stderr, "");
    for text in [
        "net_l0",
        "3 x 7",
        "sigmoid",
        "Written to build/tiny: ",
        "Next: hwgen verify build/tiny --random 200\n",
    ] {
        assert!(ran.stdout.contains(text), "{text}: {}", ran.stdout);
    }
    assert!(place.path("build/tiny/manifest.json").is_file());
    assert!(place.path("build/tiny/rtl/tiny.v").is_file());
}

#[test]
fn the_object_holds_what_a_program_wants() {
    let place = Place::new();
    let (ran, json) = place.json(&[
        "emit",
        "--weights",
        "w.json",
        "--out",
        "o",
        "--interval",
        "8",
    ]);
    ran.exits(0);
    assert_eq!(ran.stdout.lines().count(), 1);
    assert_eq!(json["command"], "emit");
    assert_eq!(json["ok"], true);
    assert_eq!(json["design"], "tiny");
    assert_eq!(json["out"], "o");
    // The first layer takes none: its weights are few eighths.
    assert_eq!(json["macs"], 14);
    assert!(json["interval_cycles"].as_u64().expect("a number") <= 8);
    for key in [
        "latency_cycles",
        "multipliers",
        "activation_multipliers",
        "rom_bits",
    ] {
        assert!(json[key].as_u64().expect(key) > 0, "{key}");
    }
    assert!(json["mac_utilization"].as_f64().expect("a share") <= 1.0);
    assert_eq!(json["digest"].as_str().expect("a digest").len(), 64);
    assert_eq!(json["layers"].as_array().expect("layers").len(), 2);
    let files = json["files"].as_array().expect("files");
    for file in files {
        let path = file["path"].as_str().expect("a path");
        assert!(place.path("o").join(path).is_file(), "{path}");
        assert_eq!(file["sha256"].as_str().expect("a digest").len(), 64);
    }
    assert!(files.iter().any(|f| f["path"] == "manifest.json"));
}

#[test]
fn a_bundle_is_replaced_only_if_that_is_asked_for() {
    let place = Place::with_bundle();
    let before = place.read("build/tiny/manifest.json");
    let arguments = ["emit", "--weights", "w.json", "--weight-bits", "10"];
    place.run(&arguments).fails(
        2,
        "error: build/tiny: a new directory expected, an existing one found\n\
         help: choose another --out, or replace it with --force\n",
    );
    assert_eq!(place.read("build/tiny/manifest.json"), before);
    place.run(&[&arguments[..], &["--force"]].concat()).exits(0);
    assert_ne!(place.read("build/tiny/manifest.json"), before);
    place.write("mine/notes.txt", "not a bundle");
    let ran = place.run(&["emit", "--weights", "w.json", "--out", "mine", "--force"]);
    ran.exits(2);
    assert_eq!(place.read("mine/notes.txt"), "not a bundle");
}

#[test]
fn a_file_in_the_way_is_told() {
    let place = Place::new();
    place.write("taken", "");
    let ran = place.run(&["emit", "--weights", "w.json", "--out", "taken/deeper/out"]);
    ran.exits(2);
    assert!(ran.stderr.starts_with("error: taken"), "{}", ran.stderr);
    assert!(ran.stderr.contains("\nhelp: "), "{}", ran.stderr);
}

#[test]
fn options_that_cannot_be_met_are_refused() {
    let place = Place::new();
    let cases: [(&[&str], &str, &str); 6] = [
        (
            &["--interval", "0"],
            "budget",
            "interval: at least 1 expected, 0 found",
        ),
        (
            &["--multipliers", "1"],
            "budget",
            "multipliers: at least 2 expected, 1 found",
        ),
        (
            &["--weight-bits", "nowhere_l0=12"],
            "unknown-layer",
            "option weight-bits: a layer of net_l0, net_l1 expected, `nowhere_l0` found",
        ),
        (
            &["--weight-bits", "2"],
            "width",
            "weight-bits: 3 to 24 bits expected, 2 found",
        ),
        (
            &["--output-bits", "99"],
            "width",
            "output-bits: 4 to 32 bits expected, 99 found",
        ),
        (
            &["--device", "ecp6-85k"],
            "unknown-device",
            "device: one of 5csema5, ecp5-25k, ecp5-45k, ecp5-85k, generic, gw2a-18, ice40-hx8k, ice40-up5k, nexus-40k, xczu3eg, xc7a35t, xc7a100t, xc7z020, xc7k325t expected, `ecp6-85k` found",
        ),
    ];
    for (options, code, message) in cases {
        let arguments = [&["emit", "--weights", "w.json"], options].concat();
        let ran = place.run(&arguments);
        ran.exits(2);
        let first = ran.stderr.lines().next();
        assert_eq!(first, Some(format!("error: {message}").as_str()));
        assert!(ran.stderr.contains("\nhelp: "), "{}", ran.stderr);
        let (ran, json) = place.json(&arguments);
        ran.exits(2);
        assert_eq!(json["ok"], false);
        assert_eq!(json["error"]["code"], code);
        assert_eq!(json["error"]["message"], message);
        assert!(!place.path("build").exists());
    }
}

/// The name is the design's from then on: top module, directory, manifest, package, benches.
#[test]
fn a_design_may_have_another_name_and_prefix() {
    let place = Place::new();
    let arguments = ["emit", "--weights", "w.json", "--name", "second"];
    let ran = place.run(&arguments);
    ran.exits(0);
    assert!(ran.stdout.contains("Written to build/second: "));
    for path in [
        "rtl/second.v",
        "rtl/second__mlp.v",
        "rtl/second__hwg_slice.v",
        "tb/second_tb.v",
        "syn/second.ys",
        "second.core",
        "constraints/second.sdc",
    ] {
        assert!(place.path("build/second").join(path).is_file(), "{path}");
    }
    let weights = place.read("build/second/weights.json");
    assert!(weights.contains("\"name\": \"second\""), "{weights}");
    for path in ["rtl/second.v", "second.core", "manifest.json"] {
        let text = place.read(&format!("build/second/{path}"));
        assert!(!text.contains("tiny"), "{path}: {text}");
    }
    let verify = [
        "verify",
        "build/second",
        "--random",
        "2",
        "--simulators",
        "icarus",
    ];
    place.run(&verify).exits(0);

    let (ran, json) = place.json(&[&arguments[..], &["--prefix", "nn", "--out", "o"]].concat());
    ran.exits(0);
    assert_eq!(json["design"], "second");
    assert_eq!(json["options"]["prefix"], "nn");
    for path in ["rtl/second.v", "rtl/nn__mlp.v", "rtl/nn__hwg_slice.v"] {
        assert!(place.path("o").join(path).is_file(), "{path}");
    }
    assert!(!place.path("o/rtl/second__mlp.v").exists());
    assert!(place.read("o/rtl/second.v").contains("nn__mlp u_mlp ("));
    place
        .run(&["verify", "o", "--random", "2", "--simulators", "icarus"])
        .exits(0);
    // Without one the manifest says nothing of a prefix.
    assert!(!place.read("build/second/manifest.json").contains("prefix"));
}

#[test]
fn names_and_prefixes_that_could_clash_are_refused() {
    let place = Place::new();
    for option in ["name", "prefix"] {
        for (name, found) in [
            (
                "2nd",
                "a name [A-Za-z_][A-Za-z0-9_]{0,62} expected, \"2nd\" found",
            ),
            (
                "module",
                "a name expected, the Verilog/SystemVerilog keyword \"module\" found",
            ),
            (
                "a__b",
                "expected a name without __ and without _ at its end, found \"a__b\"",
            ),
            (
                "a_",
                "expected a name without __ and without _ at its end, found \"a_\"",
            ),
            (
                "",
                "a name [A-Za-z_][A-Za-z0-9_]{0,62} expected, an empty one found",
            ),
        ] {
            let given = format!("--{option}={name}");
            let arguments = ["emit", "--weights", "w.json", &given];
            let ran = place.run(&arguments);
            ran.exits(2);
            let expected = format!("error: {option}: {found} (");
            assert!(ran.stderr.starts_with(&expected), "{}", ran.stderr);
            let help = format!("\nhelp: choose another --{option}\n");
            assert!(ran.stderr.ends_with(&help), "{}", ran.stderr);
            let (_, json) = place.json(&arguments);
            assert_eq!(json["error"]["code"], "name");
        }
    }
    assert!(!place.path("build").exists());
    // What only emits is asked of `emit` alone.
    let estimate = ["estimate", "--weights", "w.json", "--device", "ecp5-25k"];
    place
        .run(&[&estimate[..], &["--name", "a"]].concat())
        .exits(2);
}

#[test]
fn narrow_words_are_noted() {
    let place = Place::new();
    // Only the next layer's tanh makes it pointless to hold all of the first one's range.
    let text = r#"{"format": "hwgen-weights/1", "name": "cut",
        "inputs": {"min": [-100], "max": [100]}, "networks": [{"name": "n", "layers": [
        {"activation": "linear", "weights": [[8]]}, {"activation": "tanh", "weights": [[1]]},
        {"activation": "linear", "weights": [[1]]}]}]}"#;
    place.write("cut.json", text);
    let ran = place.run(&["emit", "--weights", "cut.json"]);
    ran.exits(0);
    assert!(
        ran.stdout.contains("\nnote: n_l0: words of "),
        "{}",
        ran.stdout
    );
    let (_, json) = place.json(&["emit", "--weights", "cut.json", "--force"]);
    assert_eq!(json["notes"].as_array().expect("notes").len(), 1);
}

#[test]
fn usage_errors_are_objects_too() {
    let place = Place::new();
    place.run(&["emit"]).exits(2);
    place.run(&[]).exits(2);
    place.run(&["emit", "--help"]).exits(0);
    place.run(&["--version"]).exits(0);
    let (ran, json) = place.json(&["emit", "--weights", "w.json", "--interval", "many"]);
    ran.exits(2);
    assert_eq!(ran.stderr, "");
    assert_eq!(json["command"], "emit");
    assert_eq!(json["ok"], false);
    assert_eq!(json["error"]["code"], "usage");
    let message = json["error"]["message"].as_str().expect("a message");
    assert!(
        message.contains("invalid value 'many' for '--interval"),
        "{message}"
    );
    let both = [
        "emit",
        "--weights",
        "w.json",
        "--interval",
        "8",
        "--multipliers",
        "9",
    ];
    place.run(&both).exits(2);
}

#[test]
fn every_command_has_help_with_examples() {
    let place = Place::new();
    for command in ["emit", "verify", "run", "doctor", "schema", "demo"] {
        let ran = place.run(&[command, "--help"]);
        ran.exits(0);
        assert!(ran.stdout.contains("Examples:\n  hwgen "), "{command}");
        assert!(!ran.stdout.contains('\x1b'), "{command}");
    }
}

#[test]
fn the_schema_is_printed() {
    let place = Place::new();
    let ran = place.run(&["schema"]);
    ran.exits(0);
    assert_eq!(
        ran.json()["properties"]["format"]["const"],
        "hwgen-weights/1"
    );
    let (_, json) = place.json(&["schema"]);
    assert_eq!(json["schema"], ran.json());
}

#[test]
fn a_reader_that_goes_away_is_no_fault() {
    use std::process::Stdio;
    let place = Place::new();
    let mut command = place.command(&["schema"]);
    let mut child = command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("starts");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("ends");
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
    assert_eq!(output.status.code(), Some(0));
}

#[test]
fn a_full_disk_is_one() {
    let place = Place::new();
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full");
    let Ok(full) = full else { return };
    let output = place
        .command(&["schema"])
        .stdout(full)
        .output()
        .expect("runs");
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn inputs_of_few_codes_and_without_effect_are_noted() {
    let place = Place::new();
    let weights = r#"{"format": "hwgen-weights/1", "name": "few",
      "inputs": {"min": [0, 0], "max": [1000, 1], "resolution": 0.25},
      "networks": [{"name": "net", "layers": [
        {"activation": "linear", "weights": [[1, 1e-9]]}]}]}"#;
    place.write("few.json", weights);
    let (ran, json) = place.json(&["emit", "--weights", "few.json"]);
    ran.exits(0);
    let notes = json["notes"].as_array().expect("notes");
    let notes: Vec<&str> = notes.iter().filter_map(|n| n.as_str()).collect();
    assert!(
        notes[0].starts_with("input in1: its box has 5 codes only, in steps of 0.25"),
        "{notes:?}"
    );
    assert!(
        notes[1].starts_with("net_l0: all weights of input 1 round to zero"),
        "{notes:?}"
    );
}

#[test]
fn a_manifest_that_says_something_else_is_bad_input() {
    let place = Place::with_bundle();
    let manifest = place.read("build/tiny/manifest.json");
    let wrong = manifest.replacen("\"latency_cycles\": ", "\"latency_cycles\": 1", 1);
    place.write("build/tiny/manifest.json", &wrong);
    let ran = place.run(&["verify", "build/tiny"]);
    ran.exits(2);
    assert!(
        ran.stderr
            .starts_with("error: build/tiny/manifest.json: latency_cycles: "),
        "{}",
        ran.stderr
    );
}

/// The weights file that the README shows is the one that is shipped, but for the frames of
/// calibration, and its CSV fits.
#[test]
fn the_example_of_the_readme_is_shipped() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let read = |file: &str| std::fs::read_to_string(root.join(file)).expect(file);
    let weights = read("designs/tiny/weights.json");
    let (shown, frames) = weights.split_once(",\n  \"calibration\"").expect("frames");
    assert!(read("README.md").contains(&format!("{shown} }}\n```\n")));
    assert!(frames.lines().count() > 64);
    let place = Place::new();
    place.write("example.json", &weights);
    place.write("inputs.csv", &read("designs/tiny/inputs.csv"));
    let emit = ["emit", "--weights", "example.json", "--out", "example"];
    place.run(&emit).exits(0);
    let ran = place.run(&["run", "example", "--inputs", "inputs.csv"]);
    ran.exits(0);
    assert_eq!(ran.stdout.lines().count(), 6);
}

/// What the box says is neither a warning nor a pass.
#[test]
fn an_error_over_the_box_is_labelled_and_not_judged() {
    let place = Place::new();
    place.write("scales.json", &scales(&[]));
    let emit = ["emit", "--weights", "scales.json", "--strict", "--force"];
    let ran = place.run(&emit);
    ran.exits(0);
    assert_eq!(ran.stderr, "");
    for text in [
        "Error against float, box: 1000 independent points\n",
        "rms, % of spread",
        "n.small",
        "\nbox: independent points of the input box; they say little about correlated inputs\n",
    ] {
        assert!(ran.stdout.contains(text), "{text}: {}", ran.stdout);
    }
    let (ran, json) = place.json(&emit);
    ran.exits(0);
    let error = &json["error"];
    assert_eq!(error["source"], "box");
    assert_eq!(error["frames"], 1000);
    assert_eq!(error["clipped_frames"], 0);
    assert!(error["within_tolerance"].is_null(), "{error}");
    let small = &error["outputs"][1];
    assert_eq!(small["output"], "n.small");
    assert_eq!(small["unit"], "m");
    assert!(small["rms_over_spread"].as_f64().expect("a share") > 0.01);
    assert!(small["max"].as_f64() > small["rms"].as_f64());
}

#[test]
fn an_error_beyond_the_tolerance_is_a_warning() {
    let place = Place::new();
    place.write("scales.json", &scales(&frames(200)));
    let emit = ["emit", "--weights", "scales.json", "--out", "o"];
    let ran = place.run(&emit);
    ran.exits(0);
    let warning = "warning: output n.small: rms error ";
    let end = " % of its spread over 200 calibration frames, expected at most 1 %\n";
    assert!(ran.stderr.starts_with(warning), "{}", ran.stderr);
    assert!(ran.stderr.ends_with(end), "{}", ran.stderr);
    assert_eq!(ran.stderr.lines().count(), 1, "{}", ran.stderr);
    assert!(
        ran.stdout
            .contains("Error against float, 200 calibration frames\n"),
        "{}",
        ran.stdout
    );
    assert!(!ran.stdout.contains("box:"), "{}", ran.stdout);

    // The figures are those of the outputs that `run` gives, beside the float network's.
    let (ran, json) = place.json(&[&emit[..], &["--force"]].concat());
    ran.exits(0);
    let error = &json["error"];
    assert_eq!(error["source"], "calibration");
    assert_eq!(error["within_tolerance"], false);
    place.write("in.csv", &super::harness::csv(&frames(200)));
    let ran = place.run(&["run", "o", "--inputs", "in.csv"]);
    let float = |row: &[f64; 2]| {
        let [a, b] = *row;
        let hidden = [a + 0.5 * b, b - 0.5 * a, 0.25 * a - 0.75 * b].map(f64::tanh);
        0.1 * (0.5 * hidden[0] + hidden[1] - hidden[2])
    };
    let float: Vec<f64> = frames(200).iter().map(float).collect();
    let fixed = ran.stdout.lines().skip(1).map(|line| {
        let cell = line.split(',').nth(1).expect("n.small");
        cell.parse::<f64>().expect("a number")
    });
    let errors: Vec<f64> = fixed.zip(&float).map(|(x, y)| x - y).collect();
    assert_eq!(errors.len(), 200);
    let root_mean_square =
        |values: &[f64]| (values.iter().map(|v| v * v).sum::<f64>() / 200.0).sqrt();
    let mean = float.iter().sum::<f64>() / 200.0;
    let deviations: Vec<f64> = float.iter().map(|v| v - mean).collect();
    let rms = root_mean_square(&errors);
    let greatest = errors.iter().fold(0.0, |most: f64, e| most.max(e.abs()));
    for (key, expected) in [
        ("rms", rms),
        ("max", greatest),
        ("rms_over_spread", rms / root_mean_square(&deviations)),
    ] {
        let found = error["outputs"][1][key].as_f64().expect(key);
        assert!(
            (found / expected - 1.0).abs() < 1e-9,
            "{key}: {found} {expected}"
        );
    }
}

#[test]
fn a_tolerance_can_be_set_and_kept() {
    let place = Place::new();
    place.write("scales.json", &scales(&frames(200)));
    let emit = |options: &str| {
        let rest = options.split_whitespace();
        let arguments: Vec<&str> = ["emit", "--weights", "scales.json"]
            .into_iter()
            .chain(rest)
            .collect();
        place.run(&arguments)
    };
    let ran = emit("--strict");
    ran.exits(1);
    assert!(!place.path("build").exists());
    for text in [
        "warning: output n.small: rms error ",
        "error: fixed point against float: at most ",
        ", expected at most 1 % (rms, 200 calibration frames)\nhelp: nothing was written; ",
    ] {
        assert!(ran.stderr.contains(text), "{text}: {}", ran.stderr);
    }
    assert!(!ran.stdout.contains("Written"), "{}", ran.stdout);
    // The failure's fields stand beside the figures.
    let ran = emit("--strict --json");
    ran.exits(1);
    let json = ran.json();
    assert_eq!(json["ok"], false);
    assert_eq!(json["error"]["code"], "tolerance");
    assert_eq!(json["error"]["within_tolerance"], false);
    assert_eq!(json["error"]["outputs"][1]["output"], "n.small");

    let ran = emit("--strict --tolerance 10000 --json");
    ran.exits(0);
    assert_eq!(ran.stderr, "");
    assert_eq!(ran.json()["error"]["within_tolerance"], true);
    for wrong in ["-1", "nan", "inf", "1%"] {
        let ran = emit(&format!("--tolerance={wrong}"));
        ran.exits(2);
        let expected = "a number of per cent from 0 on expected";
        assert!(ran.stderr.contains(expected), "{}", ran.stderr);
    }
}

#[test]
fn an_output_that_is_constant_has_no_share_of_a_spread() {
    let place = Place::new();
    let text = r#"{"format": "hwgen-weights/1", "name": "still",
        "inputs": {"min": [-1], "max": [1]}, "networks": [{"name": "n", "layers": [
        {"activation": "linear", "weights": [[1], [0]], "bias": [0, 0.3]}]}],
        "calibration": {"inputs": [[0.5], [-0.5], [0.25], [4]]}}"#;
    place.write("still.json", text);
    let ran = place.run(&["emit", "--weights", "still.json", "--out", "o"]);
    ran.exits(0);
    let warning = "warning: output n.out1: constant in float over 4 calibration frames, so that \
                   its rms error of ";
    assert!(ran.stderr.contains(warning), "{}", ran.stderr);
    let clipped = "\nnote: 1 of 4 frames outside of the input box; the core clips the inputs";
    assert!(ran.stdout.contains(clipped), "{}", ran.stdout);
    let (_, json) = place.json(&["emit", "--weights", "still.json"]);
    assert_eq!(json["error"]["clipped_frames"], 1);
    assert!(json["error"]["outputs"][1]["rms_over_spread"].is_null());
}

/// Weights, frames of calibration among them, are the bundle's.
#[test]
fn a_bundle_holds_the_calibration() {
    let place = Place::new();
    place.write("scales.json", &scales(&frames(3)));
    place.run(&["emit", "--weights", "scales.json"]).exits(0);
    let read = |text: String| {
        let net = hwgen_spec::weights::read(text.as_bytes()).expect("weights");
        net.calibration.expect("frames").inputs
    };
    assert_eq!(read(place.read("build/scales/weights.json")), frames(3));
}

#[test]
fn inputs_that_are_too_fine_for_the_multipliers_are_told() {
    let place = Place::new();
    let landing = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/designs/landing-wide/weights.json"
    );
    let emit = |device: &str| {
        let ran = place.run(&[
            "emit",
            "--weights",
            landing,
            "--device",
            device,
            "--out",
            device,
            "--json",
        ]);
        ran.exits(0);
        ran.json()["notes"].to_string()
    };
    let told = "inputs are in steps of 0.06250 (format Q11.4), 2 bits coarser";
    assert!(emit("ice40-up5k").contains(told));
    assert!(!emit("ecp5-85k").contains("coarser"));
}
