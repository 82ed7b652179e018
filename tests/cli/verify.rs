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
    assert!(json["first_difference"].is_null());

    assert_eq!(place.read("build/tiny/manifest.json"), before);
    assert!(place.path("build/.verify/tiny").is_dir());
}

#[test]
fn a_wrong_bit_is_found_and_named() {
    let place = Place::with_bundle();
    let manifest = place.read("build/tiny/manifest.json");
    // The same core with one bit of one weight flipped, its digest renewed.
    let rom = place.path("build/tiny/rtl/tiny_net_l1_w0.v");
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
    let ran = place.run(&["verify", "build/tiny", "--work", "build/tiny/work"]);
    ran.exits(2);
    assert!(!place.path("build/tiny/work").exists());
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
