//! `hwgen estimate`

use super::harness::Place;

#[test]
fn cells_are_told_without_a_tool_and_nothing_is_written() {
    let place = Place::new();
    let empty = place.path("no-tools");
    std::fs::create_dir(&empty).unwrap();
    let arguments = ["estimate", "--weights", "w.json", "--device", "ecp5-25k"];
    let ran = place.run_with_path(&empty, &arguments);
    ran.exits(0);
    for told in ["net_l0", "about 165 MHz"] {
        assert!(ran.stdout.contains(told), "{}", ran.stdout);
    }
    assert!(!place.path("build").exists());

    let (ran, json) = place.json(&arguments);
    ran.exits(0);
    let (_, emitted) = place.json(&["emit", "--weights", "w.json", "--device", "ecp5-25k"]);
    for key in ["digest", "latency_cycles", "interval_cycles", "layers"] {
        assert_eq!(json[key], emitted[key], "{key}");
    }
    let count = |of: &str, kind: &str| json[of][kind].as_u64().expect(kind);
    let multipliers = emitted["multipliers"].as_u64().unwrap()
        + emitted["activation_multipliers"].as_u64().unwrap();
    assert_eq!(count("cells", "multipliers"), multipliers);
    assert_eq!(json["fits"], true);
    // A clock as of other cores, and what it comes to.
    let number = |of: &str| json[of].as_f64().expect(of);
    let mhz = number("clock_mhz");
    assert!((100.0..200.0).contains(&mhz));
    assert_eq!(number("latency_ns"), number("latency_cycles") * 1e3 / mhz);
    let rate = mhz * 1e6 / number("interval_cycles");
    assert_eq!(number("inferences_per_second"), rate);
    assert_eq!(count("available", "lut4"), 24288);
    for kind in ["lut4", "ff"] {
        let parts = json["parts"].as_array().expect("parts");
        let sum: u64 = parts.iter().map(|part| part[kind].as_u64().unwrap()).sum();
        assert!(sum > 100);
        assert_eq!(sum, count("cells", kind));
    }
}

#[test]
fn too_much_for_the_device_is_exit_one() {
    let place = Place::new();
    let landing = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/designs/landing-wide/weights.json"
    );
    let arguments = [
        "estimate",
        "--weights",
        landing,
        "--device",
        "ecp5-25k",
        "--interval",
        "60",
    ];
    let (ran, json) = place.json(&arguments);
    ran.exits(1);
    assert_eq!(json["fits"], false);
    assert_eq!(json["error"]["code"], "does-not-fit");
    let message = json["error"]["message"].as_str().unwrap();
    assert!(message.contains("multipliers too few"), "{message}");
}

#[test]
fn a_device_of_unknown_size_is_refused() {
    let place = Place::new();
    place.run(&["estimate", "--weights", "w.json"]).fails(
        2,
        "error: --device: one whose cells are known expected, `generic` found\nhelp: one of 5csema5, ecp5-25k, ecp5-45k, ecp5-85k, gw2a-18, ice40-hx8k, ice40-up5k, nexus-40k, xczu3eg, xc7a35t, xc7a100t, xc7z020, xc7k325t\n",
    );
}
