//! `hwgen verify` with real simulators, and what goes to terminals only.

use super::harness::{Place, csv, frames, scales};

#[test]
fn a_bundle_is_confirmed() {
    let place = Place::with_bundle();
    place.write("in.csv", "c,b,a\n0.5,-0.25,1\n0,0,9\n");
    let before = place.read("build/tiny/manifest.json");
    let arguments = [
        "verify",
        "build/tiny",
        "--vectors",
        "in.csv",
        "--random",
        "5",
    ];
    let icarus = ["--simulators", "icarus"];
    let ran = place.run(&[&arguments[..], &icarus].concat());
    ran.exits(0);
    for text in [
        "icarus",
        "equal",
        "latency",
        "interval",
        "net.x",
        "\nverified: ",
    ] {
        assert!(ran.stdout.contains(text), "{text}: {}", ran.stdout);
    }
    assert!(
        ran.stdout
            .contains("note: 1 row of the vectors outside of the input box; the core clips"),
        "{}",
        ran.stdout
    );
    assert!(!ran.stdout.contains('\x1b') && !ran.stderr.contains('\x1b'));
    assert!(!ran.stderr.contains('\r'));

    let (ran, json) = place.json(&[&arguments[..], &icarus].concat());
    ran.exits(0);
    assert_eq!(json["command"], "verify");
    assert_eq!(json["ok"], true);
    assert_eq!(json["verified"], true);
    let run = &json["runs"][0];
    assert_eq!(run["simulator"], "icarus");
    assert_eq!(run["verdict"], "equal");
    for key in ["frames", "edges", "registers", "values_compared"] {
        assert!(run[key].as_u64().expect(key) > 0, "{key}");
    }
    for key in ["latency_cycles", "interval_cycles"] {
        assert_eq!(json[key]["stated"], json[key]["measured"]);
    }
    assert_eq!(json["rows_outside_box"], 1);
    assert_eq!(json["error_vs_float"][0]["output"], "net.x");
    assert_eq!(json["error_vs_float"][0]["unit"], "m");
    assert_eq!(json["error_vs_float"][0]["frames"], 2);
    assert_eq!(json["error"]["source"], "vectors");
    assert_eq!(json["error"]["clipped_frames"], 1);
    assert_eq!(json["error"]["outputs"][0]["output"], "net.x");
    assert!(json["first_difference"].is_null());

    assert_eq!(place.read("build/tiny/manifest.json"), before);
    assert!(place.path("build/.verify/tiny").is_dir());
}

#[test]
fn a_wrong_bit_is_found_and_named() {
    let place = Place::with_bundle();
    let manifest = place.read("build/tiny/manifest.json");
    // The same core with one bit of one weight flipped, its digest renewed.
    let rom = place.path("build/tiny/rtl/tiny__net_l1_w0.v");
    let text = std::fs::read_to_string(&rom).expect("a text");
    let at = text.find("'h").expect("a literal") + 2;
    let digits = text[at..]
        .find(|c: char| !c.is_ascii_hexdigit())
        .expect("an end");
    let last = at + digits - 1;
    let flipped = if &text[last..=last] == "0" { "1" } else { "0" };
    let changed = format!("{}{flipped}{}", &text[..last], &text[last + 1..]);
    std::fs::write(&rom, &changed).expect("written");
    let (old, new) = (hwgen_gen::sha256(&text), hwgen_gen::sha256(&changed));
    assert!(manifest.contains(&old));
    place.write("build/tiny/manifest.json", &manifest.replace(&old, &new));

    let arguments = [
        "verify",
        "build/tiny",
        "--random",
        "5",
        "--simulators",
        "icarus",
    ];
    let ran = place.run(&arguments);
    ran.exits(1);
    assert!(ran.stdout.contains("first difference"), "{}", ran.stdout);
    assert!(!ran.stdout.contains("\nverified"), "{}", ran.stdout);
    assert!(
        ran.stderr.contains("error: icarus differs in "),
        "{}",
        ran.stderr
    );
    let (ran, json) = place.json(&arguments);
    ran.exits(1);
    assert_eq!(json["ok"], false);
    assert_eq!(json["verified"], false);
    assert_eq!(json["error"]["code"], "difference");
    assert_eq!(json["first_difference"]["simulator"], "icarus");
    assert_eq!(json["first_difference"]["layer"], "net_l1");
}

#[test]
fn a_work_directory_of_others_is_not_emptied() {
    let place = Place::with_bundle();
    place.write("mine/notes.txt", "precious");
    let ran = place.run(&["verify", "build/tiny", "--work", "mine"]);
    ran.exits(2);
    assert!(
        ran.stderr
            .starts_with("error: mine: a new or empty directory"),
        "{}",
        ran.stderr
    );
    assert_eq!(place.read("mine/notes.txt"), "precious");
    for work in ["build/tiny/work", "build/tiny", "build", "."] {
        let ran = place.run(&["verify", "build/tiny", "--work", work]);
        ran.exits(2);
        let expected = format!("error: {work}: a directory outside of the bundle expected");
        assert!(ran.stderr.starts_with(&expected), "{}", ran.stderr);
    }
    assert!(!place.path("build/tiny/work").exists());
    // Not even the one that hwgen would have taken.
    place.write("build/.verify/tiny/notes.txt", "precious");
    let ran = place.run(&["verify", "build/tiny"]);
    ran.exits(2);
    let expected = "error: build/.verify/tiny: a new or empty directory";
    assert!(ran.stderr.starts_with(expected), "{}", ran.stderr);
    assert_eq!(place.read("build/.verify/tiny/notes.txt"), "precious");
}

/// "verified" says nothing of the error against float: it never stands without it.
#[test]
fn the_verdict_holds_the_error_and_where_its_frames_come_from() {
    let place = Place::new();
    place.write("plain.json", &scales(&[]));
    place.write("held.json", &scales(&frames(200)));
    place.write("in.csv", &csv(&frames(150)));
    place.write("one.csv", &csv(&frames(1)));
    for name in ["plain", "held"] {
        let weights = format!("{name}.json");
        place
            .run(&["emit", "--weights", &weights, "--out", name])
            .exits(0);
    }
    let verify = |bundle: &str, rest: &str| {
        let fixed = ["verify", bundle, "--simulators", "icarus", "--random"];
        let arguments: Vec<&str> = fixed.into_iter().chain(rest.split_whitespace()).collect();
        let ran = place.run(&arguments);
        ran.exits(0);
        let (_, json) = place.json(&arguments);
        assert_eq!(json["verified"], true);
        let verdict = ran.stdout.lines().last().expect("a line").to_owned();
        (verdict, ran, json)
    };
    let beyond = "warning: output n.small: rms error ";
    // Vectors come first, then the calibration, then the box, whatever the number of random frames.
    let cases = [
        (
            "held",
            "2 --vectors in.csv",
            "vectors",
            "150 frames of the vectors",
        ),
        (
            "plain",
            "0 --vectors in.csv",
            "vectors",
            "150 frames of the vectors",
        ),
        ("held", "0", "calibration", "200 calibration frames"),
        ("plain", "0", "box", "box: 1000 independent points"),
        ("plain", "7 --seed 3", "box", "box: 1000 independent points"),
    ];
    for (bundle, rest, source, frames) in cases {
        let (verdict, ran, json) = verify(bundle, rest);
        let start = "verified: model and RTL are equal in every register at every cycle that was driven, \
                     in icarus alone; the RTL has no other register or memory; fixed point against \
                     float: at most ";
        assert!(verdict.starts_with(start), "{verdict}");
        assert!(verdict.contains(" % of an output's spread"), "{verdict}");
        assert!(
            verdict.ends_with(&format!(" (rms, {frames}).")),
            "{verdict}"
        );
        let label = format!("Error against float, {frames}\n");
        assert!(ran.stdout.contains(&label), "{}", ran.stdout);
        let error = &json["error"];
        assert_eq!(error["source"], source);
        assert_eq!(json["error_vs_float"][1]["frames"], error["frames"]);
        for key in ["output", "unit", "rms", "max", "rms_over_spread"] {
            let figure = &json["error_vs_float"][1][key];
            assert!(
                !figure.is_null() && *figure == error["outputs"][1][key],
                "{key}"
            );
        }
        let judged = source != "box";
        assert_eq!(ran.stderr.contains(beyond), judged, "{}", ran.stderr);
        assert_eq!(
            verdict.contains(", expected at most 1 % ("),
            judged,
            "{verdict}"
        );
        assert_eq!(ran.stdout.contains("\nbox: independent"), !judged);
        if judged {
            assert_eq!(error["within_tolerance"], false);
        } else {
            assert!(error["within_tolerance"].is_null(), "{error}");
        }
    }
    // The figure of the box is that of `emit`.
    let (_, emitted) = place.json(&["emit", "--weights", "plain.json", "--out", "again"]);
    assert_eq!(verify("plain", "5 --seed 9").2["error"], emitted["error"]);

    // One frame has no spread: the error is stated for what it is.
    let (verdict, ran, json) = verify("plain", "2 --vectors one.csv");
    assert!(
        verdict.contains(" m in n.small, without a spread (rms, 1 frame of"),
        "{verdict}"
    );
    let warning = "warning: at least 2 frames expected for a spread of the outputs, 1 frame of";
    assert!(ran.stderr.contains(warning), "{}", ran.stderr);
    assert!(json["error"]["within_tolerance"].is_null());
    assert!(json["error_vs_float"][0]["rms_over_spread"].is_null());
}

#[test]
fn more_random_frames_than_can_be_are_refused() {
    let place = Place::with_bundle();
    for count in ["1000001", "18446744073709551615"] {
        let ran = place.run(&["verify", "build/tiny", "--random", count]);
        ran.exits(2);
        assert!(ran.stderr.contains("0..=1000000"), "{}", ran.stderr);
    }
}

#[test]
fn a_core_that_reads_other_files_is_refused() {
    let place = Place::with_bundle();
    let (path, manifest) = ("build/tiny/rtl/tiny.v", "build/tiny/manifest.json");
    let text = place.read(path);
    let changed = format!("`include \"other.vh\"\n{text}");
    place.write(path, &changed);
    let renewed = place
        .read(manifest)
        .replace(&hwgen_gen::sha256(&text), &hwgen_gen::sha256(&changed));
    place.write(manifest, &renewed);
    let ran = place.run(&["verify", "build/tiny", "-q"]);
    ran.fails(
        1,
        "error: build/tiny/rtl/tiny.v:1: expected Verilog that simulators and synthesis read alike, \
         found \u{60}include\nhelp: emit the bundle again: no core that hwgen emits contains it\n",
    );
}

#[test]
fn unknown_simulators_are_refused() {
    let place = Place::with_bundle();
    let ran = place.run(&["verify", "build/tiny", "--simulators", "icarus,modelsim"]);
    ran.exits(2);
    assert!(
        ran.stderr.contains("one of icarus, verilator expected"),
        "{}",
        ran.stderr
    );
}

#[test]
fn doctor_lists_the_tools() {
    let place = Place::new();
    let (ran, json) = place.json(&["doctor"]);
    ran.exits(0);
    assert_eq!(json["ok"], true);
    let tools = json["tools"].as_array().expect("tools");
    let icarus = tools
        .iter()
        .find(|t| t["name"] == "Icarus Verilog")
        .expect("Icarus");
    assert_eq!(icarus["health"], "ok");
    assert!(icarus["version"].is_string());
    let ran = place.run(&["doctor"]);
    assert!(ran.stdout.contains("Icarus Verilog"), "{}", ran.stdout);
}
