//! `hwgen train`

use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

use super::harness::Place;

const LANDING: &str = include_str!("../../designs/landing/scene.toml");

fn place() -> Place {
    let place = Place::new();
    place.write("scene.toml", LANDING);
    place
}

fn arguments(rest: &str) -> Vec<&str> {
    let all = ["train", "--scene", "scene.toml"].into_iter();
    all.chain(rest.split_whitespace()).collect()
}

const SMALL: &str = "--hidden 4 --samples 300 --epochs 5 --out t.json";

#[test]
fn weights_come_out_ready_for_emit_and_the_same_for_a_seed() {
    let place = place();
    let (ran, json) = place.json(&arguments(SMALL));
    ran.exits(0);
    assert_eq!(json["networks"][0]["name"], "position");
    assert_eq!(json["networks"][1]["epochs"], 5);
    assert_eq!(json["networks"][1]["stopped_by"], "epochs");
    for mse in ["train_mse", "validation_mse"] {
        let mse = json["networks"][0][mse].as_f64().expect("a number");
        assert!(mse > 0.0 && mse < 1.0, "{mse}");
    }
    assert!(!place.path("t.json.checkpoint").exists());
    let weights = place.read("t.json");
    let net = hwgen_spec::weights::read(weights.as_bytes()).expect("weights");
    let calibration = net.calibration.expect("frames");
    assert_eq!(
        calibration.note,
        "pixels of 256 of the samples that were learnt from, seed 1, noise 1 px, in steps of 0.01 px"
    );
    assert_eq!(calibration.inputs.len(), 256);
    for px in calibration.inputs.iter().flatten() {
        assert!(
            (0.0..=1280.0).contains(px) && format!("{px}").len() <= 7,
            "{px}"
        );
    }
    let (ran, json) = place.json(&["emit", "--weights", "t.json"]);
    ran.exits(0);
    assert_eq!(json["error"]["source"], "calibration");
    assert_eq!(json["error"]["frames"], 256);
    assert_eq!(json["error"]["clipped_frames"], 0);

    for (threads, seed, same) in [("1", "1", true), ("2", "2", false)] {
        let mut command = place.command(&arguments(SMALL));
        command.args(["--force", "--seed", seed]);
        let status = command.env("RAYON_NUM_THREADS", threads).output();
        assert!(status.expect("starts").status.success());
        assert_eq!(place.read("t.json") == weights, same, "{threads} {seed}");
    }
}

#[test]
fn the_methods_own_recipe_is_a_preset() {
    let place = place();
    let rest = "--preset paper --hidden 4 --samples 300 --epochs 5 --out paper.json --curve c.svg";
    let (ran, json) = place.json(&arguments(rest));
    ran.exits(0);
    let recipe = &json["recipe"];
    assert_eq!(recipe["optimizer"], "rprop");
    assert_eq!(recipe["front"], "standardize");
    assert_eq!(recipe["target"], "truth");
    assert_eq!(recipe["noise_px"], serde_json::json!([0.0]));
    let curve = place.read("c.svg");
    assert!(
        curve.starts_with("<svg") && curve.contains("orientation"),
        "{curve}"
    );
}

#[test]
fn what_makes_no_sense_is_refused_before_anything_is_done() {
    let place = place();
    for (rest, expected) in [
        (
            "--hidden 0",
            "--hidden: a number from 1 to 4096 expected, 0 found",
        ),
        (
            "--hidden 1,2,3,4,5",
            "--hidden: 1 to 4 layers expected, 5 found",
        ),
        (
            "--hidden 200,200",
            "--hidden: at most 28000 weights expected, 44203 found: Levenberg-Marquardt needs their \
             square, --optimizer rprop does not",
        ),
        (
            "--samples 3",
            "--samples: a number from 100 to 10000000 expected, 3 found",
        ),
        (
            "--noise -1",
            "--noise: levels from 0 to 100000 px expected, -1 found",
        ),
        (
            "--noise 0,nan",
            "--noise: levels from 0 to 100000 px expected, NaN found",
        ),
        (
            "--noise 1e6",
            "--noise: levels from 0 to 100000 px expected, 1000000 found",
        ),
        (
            "--samples 100 --noise 1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16,17,18,19,20,21",
            "--samples: 105 or more expected, 5 for each of 21 levels of noise, 100 found",
        ),
        (
            "--noise-half 0",
            "--noise-half: a noise from 0.001 to 100000 px expected, 0 found",
        ),
        (
            "--weight-decay inf",
            "--weight-decay: zero or more expected, inf found",
        ),
    ] {
        let ran = place.run(&[&arguments("--out t.json")[..], &arguments(rest)[3..]].concat());
        let help = "help: `hwgen train --help` lists the defaults\n";
        ran.fails(2, &format!("error: {expected}\n{help}"));
    }
    std::fs::create_dir(place.path("directory")).expect("a directory");
    place.run(&arguments("--out directory")).fails(
        2,
        "error: directory: a file expected, a directory found\n\
         help: name a file, in that directory for example\n",
    );
    place.run(&arguments("--out t.json --curve t.json")).fails(
        2,
        "error: t.json: --curve: another file than that of --out expected, the same found\n\
         help: give --out and --curve a file each\n",
    );
    place.write("t.json", "mine");
    place.run(&arguments(SMALL)).fails(
        2,
        "error: t.json: a new file expected, an existing one found\n\
         help: write to another file, or replace this one with --force\n",
    );
    place.run(&arguments("--out scene.toml --force")).exits(2);
    assert_eq!(place.read("scene.toml"), LANDING);
    assert_eq!(place.read("t.json"), "mine");
}

#[test]
fn an_interrupted_training_keeps_its_best_and_goes_on_as_if_nothing_had_happened() {
    let place = place();
    let rest = "--hidden 8,5 --samples 2000 --epochs 300 --patience 300 --optimizer rprop";
    place
        .run(&arguments(&format!("{rest} --out whole.json")))
        .exits(0);

    let mut child = place
        .command(&arguments(&format!("{rest} --out part.json --json")))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("starts");
    let mut lines = BufReader::new(child.stderr.take().expect("a pipe")).lines();
    let trains = |line: &std::io::Result<String>| line.as_ref().is_ok_and(|l| l.contains("epoch"));
    assert!(lines.any(|line| trains(&line)), "no epoch was told");
    let kill = format!("kill -INT {}", child.id());
    assert!(
        Command::new("sh")
            .args(["-c", &kill])
            .status()
            .expect("a shell")
            .success()
    );
    let output = child.wait_with_output().expect("ends");
    assert!(output.status.success());
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("an object");
    assert_eq!(json["interrupted"], true);
    assert_eq!(json["networks"][1]["stopped_by"], "interrupt");
    place.run(&["emit", "--weights", "part.json"]).exits(0);

    // It is neither overwritten unasked nor taken for that of another scene.
    place
        .run(&arguments(&format!("{rest} --out part.json")))
        .exits(2);
    place.write(
        "other.toml",
        &LANDING.replace("offset_m = 0.5", "offset_m = 0.25"),
    );
    let other = [
        "train",
        "--scene",
        "other.toml",
        "--out",
        "part.json",
        "--resume",
    ];
    let ran = place.run(&other);
    assert!(
        ran.exits(2)
            .stderr
            .contains("a training on this scene expected"),
        "{}",
        ran.stderr
    );

    // A checkpoint that lost something is refused, whatever it lost.
    let whole = place.read("part.json.checkpoint");
    for damage in ["hidden", "parameters", "noise_px"] {
        let mut kept: serde_json::Value = serde_json::from_str(&whole).expect("an object");
        match damage {
            "hidden" => kept["learners"][0]["shape"]["hidden"] = serde_json::json!([7]),
            "parameters" => kept["learners"][1]["parameters"] = serde_json::json!([1.0]),
            _ => kept["recipe"]["noise_px"] = serde_json::json!([]),
        }
        place.write("part.json.checkpoint", &kept.to_string());
        let ran = place.run(&arguments("--out part.json --resume"));
        let said = &ran.exits(2).stderr;
        assert!(said.contains("begin anew without --resume"), "{said}");
    }
    place.write("part.json.checkpoint", &whole);

    place.run(&arguments("--out part.json --resume")).exits(0);
    assert!(place.read("part.json") == place.read("whole.json"));
    assert!(!place.path("part.json.checkpoint").exists());
}
