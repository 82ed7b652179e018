//! A small core placed and routed: nextpnr finds what the netlist promises.
//!
//! Needs Yosys and nextpnr-ecp5 (`tools/setup --place`); without them these tests fail.

#[path = "cli/harness.rs"]
#[expect(dead_code, reason = "the other tests use the rest")]
mod harness;

use harness::Place;
use serde_json::Value;

#[test]
fn a_small_core_is_placed_and_routed() {
    let place = Place::new();
    place
        .run(&["emit", "--weights", "w.json", "--device", "ecp5-25k"])
        .exits(0);
    let manifest: Value = serde_json::from_str(&place.read("build/tiny/manifest.json")).unwrap();
    let mut command = place.command(&["synth", "build/tiny", "--seeds", "2", "--json"]);
    // The environment that `tools/setup --place` makes.
    let output = command
        .env("VIRTUAL_ENV", concat!(env!("CARGO_MANIFEST_DIR"), "/.eda"))
        .output()
        .unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{text}");
    let json: Value = serde_json::from_str(&text).unwrap();
    let count = |of: &str, kind: &str| json[of][kind].as_u64().unwrap();
    let multipliers = ["multipliers", "activation_multipliers"]
        .map(|kind| manifest[kind].as_u64().unwrap())
        .iter()
        .sum::<u64>();
    assert_eq!(count("netlist", "multipliers"), multipliers);
    assert_eq!(count("cells", "multipliers"), multipliers);
    assert_eq!(count("cells", "ff"), count("netlist", "ff"));
    let estimate = place.run(&[
        "estimate",
        "--weights",
        "w.json",
        "--device",
        "ecp5-25k",
        "--json",
    ]);
    let estimate = estimate.json();
    for (kind, most) in [("lut4", 0.15), ("ff", 0.15), ("multipliers", 0.0)] {
        let estimated = estimate["cells"][kind].as_f64().unwrap();
        let found = count("netlist", kind) as f64;
        assert!(
            (estimated - found).abs() <= most * found,
            "{kind}: {estimated} estimated, {found} found"
        );
    }
    // The placer adds tables where chains begin and end, of which multipliers of logic have many.
    let (before, after) = (count("netlist", "lut4"), count("cells", "lut4"));
    assert!(
        before <= after && after <= before + before / 8 + 20,
        "{before} {after}"
    );
    let sum: u64 = json["parts"]
        .as_array()
        .unwrap()
        .iter()
        .map(|part| part["ff"].as_u64().unwrap())
        .sum();
    assert_eq!(sum, count("netlist", "ff"));
    let median = json["fmax_mhz"]["median"].as_f64().unwrap();
    assert!((50.0..450.0).contains(&median), "{median}");
    for path in json["critical_paths"].as_array().unwrap() {
        let through = path["through"].as_array().unwrap();
        assert!(
            !through.is_empty() && through.iter().all(|part| part != "shell"),
            "{path}"
        );
        let time = path["logic_ns"].as_f64().unwrap() + path["routing_ns"].as_f64().unwrap();
        assert!(time > 0.0);
    }
}
