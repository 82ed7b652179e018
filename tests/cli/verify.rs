//! `hwgen verify` with real simulators, and what goes to terminals only.

use super::harness::Place;

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
        ran.stdout.contains("note: 1 row of the vectors outside"),
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
    assert_eq!(json["error_vs_float"][0]["frames"], 1);
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

#[test]
fn an_error_that_was_not_measured_is_not_said_to_be_zero() {
    let place = Place::with_bundle();
    place.write("outside.csv", "a,b,c\n0,0,9\n");
    for inputs in [["--random", "0"], ["--vectors", "outside.csv"]] {
        let arguments = [
            &["verify", "build/tiny", "--simulators", "icarus"],
            &inputs[..],
        ]
        .concat();
        let ran = place.run(&arguments);
        ran.exits(0);
        let line = ran.stdout.lines().find(|l| l.contains("net.x"));
        let words: Vec<&str> = line.expect("a line").split_whitespace().collect();
        let expected = ["net.x", "0", "not", "measured", "not", "measured", "m"];
        assert_eq!(words, expected);
        let (_, json) = place.json(&arguments);
        let error = &json["error_vs_float"][0];
        assert_eq!(error["frames"], 0);
        assert!(error["max"].is_null() && error["rms"].is_null(), "{error}");
    }
    // Random points are real numbers: the error holds the rounding of the inputs.
    let text = r#"{"format": "hwgen-weights/1", "name": "same",
        "inputs": {"min": [-1], "max": [1], "resolution": 0.25},
        "networks": [{"name": "n", "layers": [{"activation": "linear", "weights": [[1]]}]}]}"#;
    place.write("same.json", text);
    place.run(&["emit", "--weights", "same.json"]).exits(0);
    let (_, json) = place.json(&["verify", "build/same", "--simulators", "icarus"]);
    let error = &json["error_vs_float"][0];
    assert_eq!(error["frames"], 64);
    let greatest = error["max"].as_f64().expect("measured");
    assert!((0.1..=0.126).contains(&greatest), "{greatest}");
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
        2,
        "error: build/tiny/rtl/tiny.v:1: a core that reads no other file expected, `\u{60}include` \
         found\nhelp: emit the bundle again: its core is the files of its manifest\n",
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
