//! Bad files, and tools that are missing or no tools.

use super::harness::Place;

#[test]
fn a_refused_weights_file_is_told_with_its_place() {
    let place = Place::new();
    let text = include_str!("../errors/weights/activation-far.json");
    place.write("bad.json", text);
    let ran = place.run(&["emit", "--weights", "bad.json"]);
    ran.exits(2);
    let expected = "error: bad.json:8:22: networks[0].layers[0].activation: ";
    assert!(ran.stderr.starts_with(expected), "{}", ran.stderr);
    assert_eq!(ran.stderr.lines().count(), 2, "{}", ran.stderr);
    let (ran, json) = place.json(&["emit", "--weights", "bad.json"]);
    ran.exits(2);
    let error = &json["error"];
    assert_eq!(error["path"], "networks[0].layers[0].activation");
    assert_eq!(error["file"], "bad.json");
    assert_eq!((&error["line"], &error["column"]), (&8.into(), &22.into()));
    for key in ["code", "message", "help"] {
        assert!(error[key].is_string(), "{key}: {error}");
    }
    assert!(!place.path("build").exists());
}

#[test]
fn a_weights_file_that_is_none_is_told() {
    let place = Place::new();
    place.run(&["emit", "--weights", "none.json"]).fails(
        2,
        "error: none.json: No such file or directory (os error 2)\n\
         help: check that the path exists and that you may use it\n",
    );
    place.run(&["emit", "--weights", "."]).exits(2);
}

#[test]
fn a_changed_bundle_is_refused() {
    let place = Place::with_bundle();
    place.write("in.csv", "a,b,c\n0,0,0\n");
    let path = "build/tiny/rtl/tiny.v";
    place.write(path, &place.read(path).replacen("aclk", "aclk ", 1));
    for arguments in [
        &["verify", "build/tiny"][..],
        &["run", "build/tiny", "--inputs", "in.csv"],
    ] {
        let ran = place.run(arguments);
        ran.exits(2);
        let expected = "error: build/tiny/rtl/tiny.v: a file of digest ";
        assert!(ran.stderr.starts_with(expected), "{}", ran.stderr);
        let (ran, json) = place.json(arguments);
        ran.exits(2);
        assert_eq!(json["error"]["code"], "bundle-changed");
        assert_eq!(json["error"]["path"], path);
    }
}

#[test]
fn a_directory_without_manifest_is_no_bundle() {
    let place = Place::new();
    place.run(&["verify", "."]).fails(
        2,
        "error: ./manifest.json: a manifest of the format hwgen-bundle/1 expected, none found\n\
         help: give the directory that `hwgen emit` wrote\n",
    );
    place.run(&["verify", "nowhere"]).exits(2);
}

#[test]
fn without_simulators_nothing_is_confirmed() {
    let place = Place::with_bundle();
    let empty = place.path("empty");
    for arguments in [
        &["verify", "build/tiny"][..],
        &["verify", "build/tiny", "--simulators", "icarus"],
        &[
            "verify",
            "build/tiny",
            "--simulators",
            "verilator",
            "--json",
        ],
        &["doctor"],
    ] {
        let ran = place.run_with_path(&empty, arguments);
        ran.exits(3);
        assert!(!ran.stdout.contains("verified"), "{}", ran.stdout);
        assert!(ran.stderr.contains("apt-get install"), "{}", ran.stderr);
    }
    let ran = place.run_with_path(&empty, &["verify", "build/tiny", "--json"]);
    assert_eq!(ran.json()["error"]["code"], "tool-missing");
}

#[test]
fn a_tool_that_does_nothing_confirms_nothing() {
    let place = Place::with_bundle();
    place.fake_tool("bin/iverilog", "exit 0");
    place.fake_tool("bin/vvp", "exit 0");
    let ran = place.run_with_path(&place.path("bin"), &["verify", "build/tiny"]);
    ran.exits(3);
    assert!(!ran.stdout.contains("verified"), "{}", ran.stdout);
    assert!(ran.stderr.contains("printed no version"), "{}", ran.stderr);
}

#[test]
fn a_tool_with_a_version_and_no_work_confirms_nothing() {
    let place = Place::with_bundle();
    place.fake_tool(
        "bin/iverilog",
        "echo 'Icarus Verilog version 12.0 (stable)'",
    );
    place.fake_tool(
        "bin/vvp",
        "echo 'Icarus Verilog runtime version 12.0 (stable)'",
    );
    let ran = place.run_with_path(&place.path("bin"), &["verify", "build/tiny"]);
    ran.exits(3);
    assert!(!ran.stdout.contains("verified"), "{}", ran.stdout);
}

#[test]
fn a_hanging_simulator_is_ended() {
    let place = Place::with_bundle();
    let version = |text: &str| {
        format!("if [ \"$1\" = -V ]; then echo '{text} version 12.0'; else exec /bin/sleep 60; fi")
    };
    place.fake_tool("bin/iverilog", &version("Icarus Verilog"));
    place.fake_tool("bin/vvp", &version("Icarus Verilog runtime"));
    let arguments = ["verify", "build/tiny", "--timeout", "1", "--json"];
    let ran = place.run_with_path(&place.path("bin"), &arguments);
    ran.exits(3);
    assert_eq!(ran.json()["error"]["code"], "tool-timed-out");
}

#[test]
fn the_demo_does_what_it_can_without_simulators() {
    let place = Place::new();
    let ran = place.run_with_path(&place.path("empty"), &["demo"]);
    ran.exits(3);
    for text in [
        "Built in build/demo",
        "agree in 100 frames",
        "orientation, deg",
        "Error against float, 500 frames of the vectors\n",
    ] {
        assert!(ran.stdout.contains(text), "{text}: {}", ran.stdout);
    }
    assert!(!ran.stdout.contains("verified"), "{}", ran.stdout);
    assert!(ran.stderr.contains("apt-get install"), "{}", ran.stderr);
    let ran = place.run_with_path(&place.path("empty"), &["demo", "--json"]);
    ran.exits(3);
    let json = ran.json();
    assert_eq!(json["ok"], false);
    assert!(json.get("verified").is_none());
    assert_eq!(json["error"]["code"], "tool-missing");
    assert_eq!(json["error"]["source"], "vectors");
    assert_eq!(json["error"]["within_tolerance"], true);
    let row = &json["accuracy"][0];
    assert_eq!(row["noise_px"], 0.0);
    let metres = row["fixed"]["position_m"].as_f64().expect("metres");
    assert!((0.05..0.5).contains(&metres), "{metres}");
    let degrees = row["fixed"]["orientation_deg"].as_f64().expect("degrees");
    assert!((0.05..0.5).contains(&degrees), "{degrees}");
    assert_eq!(
        json["latency_cycles"]["stated"],
        json["latency_cycles"]["measured"]
    );
    assert_eq!(
        json["interval_cycles"]["stated"],
        json["interval_cycles"]["measured"]
    );
}
