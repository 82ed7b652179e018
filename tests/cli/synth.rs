//! `synth` with stand-ins for the tools: what is asked of them, and what is made of what they say.

use std::fs;
use std::path::PathBuf;

use super::harness::{Place, Ran, tiny};

/// A netlist of the shell, with so many multipliers.
fn netlist(multipliers: usize) -> String {
    let cell = |i: usize| {
        format!(
            r#""u_core.u_mlp.u_net_l0.u_pe{i}.g_mul[0].u_mul.g_block.u_block": {{"type": "MULT18X18D"}}"#
        )
    };
    let cells: Vec<String> = (0..multipliers).map(cell).collect();
    format!(
        r#"{{"modules": {{"tiny_shell": {{"attributes": {{"top": "1"}}, "cells": {{"drive_q_TRELLIS_FF_Q": {{"type": "TRELLIS_FF"}}, {}}}}}}}}}"#,
        cells.join(", ")
    )
}

/// A report of a clock.
fn report(mhz: f64) -> String {
    let end = |cell: &str| format!(r#"{{"cell": "{cell}", "port": "Q"}}"#);
    // The one between them is the placer's own.
    let (from, added, to) = (
        end("u_core.u_ingress.index_q_TRELLIS_FF_Q"),
        end("$nextpnr_CCU2C_61$CCU2_COMB0"),
        end("u_core.u_mlp.u_net_l0.u_pe0.sum_q_TRELLIS_FF_Q"),
    );
    format!(
        r#"{{"fmax": {{"clk": {{"achieved": {mhz}, "constraint": 200}}}},
            "utilization": {{"TRELLIS_COMB": {{"used": 7, "available": 24288}},
                             "MULT18X18D": {{"used": 2, "available": 28}}}},
            "critical_paths": [
              {{"from": "<async>", "to": "posedge clk", "path": [
                {{"type": "routing", "delay": 9.0, "from": {from}, "to": {to}}}]}},
              {{"from": "posedge clk", "to": "posedge clk", "path": [
                {{"type": "clk-to-q", "delay": 0.5, "from": {from}, "to": {from}}},
                {{"type": "routing", "delay": 1.25, "from": {from}, "to": {added}}},
                {{"type": "routing", "delay": 3.0, "from": {added}, "to": {to}}},
                {{"type": "setup", "delay": 0.25, "from": {to}, "to": {to}}}]}}]}}"#
    )
}

/// A place with a bundle for a device and tools that answer; nextpnr gives seed 1, 2 and so on the
/// clocks of the list, promises so after placing, and comes to no end if it is asked for more.
fn bench(multipliers: usize, clocks: &[f64]) -> Place {
    let place = Place::new();
    place
        .run(&["emit", "--weights", "w.json", "--device", "ecp5-25k"])
        .exits(0);
    place.write("netlist.json", &netlist(multipliers));
    for (i, clock) in clocks.iter().enumerate() {
        place.write(&format!("report-{}.json", i + 1), &report(*clock));
        place.write(&format!("clock-{}", i + 1), &clock.to_string());
    }
    place.write("placed.json", "\"target_freq\": \"150\",\n");
    let here = place.path("").display().to_string();
    place.fake_tool(
        "bin/yosys",
        &format!(
            "[ \"$1\" = -V ] && echo 'Yosys 0.23' && exit\n\
             echo run >> {here}/yosys-runs\n\
             grep -q 'synth_ecp5 -top tiny_shell' synth.ys || exit 9\n\
             cp {here}/netlist.json netlist.part.json"
        ),
    );
    place.fake_tool(
        "bin/nextpnr-ecp5",
        &format!(
            "[ \"$1\" = --version ] && echo '(Version nextpnr-0.11)' && exit\n\
             grep -q clk_i pins.lpf || exit 9\n\
             while [ $# -gt 0 ]; do\n\
               case $1 in --seed) seed=$2;; --freq) freq=$2;; --json) in=$2;; --report) out=$2;;\n\
                 --write) write=$2;; --textcfg) echo routed for $seed > $2;; esac\n\
               shift\n\
             done\n\
             [ -f {here}/full-$seed ] && echo 'ERROR: Unable to find legal placement' >&2 && exit 1\n\
             clock=$(cat {here}/clock-$seed)\n\
             if [ \"$write\" ]; then\n\
               echo $seed >> {here}/seeds\n\
               echo \"Info: Max frequency for clock 'clk': $clock MHz (FAIL at $freq MHz)\"\n\
               cp {here}/placed.json $write\n\
               exit\n\
             fi\n\
             grep -q target_freq $in && exit 9\n\
             echo $seed $freq >> {here}/routes\n\
             if awk \"BEGIN {{ exit !($freq > $clock) }}\"; then\n\
               echo 'Info:     iter=61 wires=9 overused=0 overuse=0 tmgfail=5 archfail=NA'\n\
               sleep 100\n\
             fi\n\
             cp {here}/report-$seed.json $out"
        ),
    );
    place
}

fn synth(place: &Place, arguments: &[&str]) -> Ran {
    let tools = format!("{}:/bin:/usr/bin", place.path("bin").display());
    place.run_with_path(
        &PathBuf::from(tools),
        &[&["synth", "build/tiny"], arguments].concat(),
    )
}

#[test]
fn the_median_of_the_seeds_is_what_counts() {
    let place = bench(2, &[100.0, 300.0, 150.0]);
    let ran = synth(&place, &["--seeds", "3", "--json"]);
    ran.exits(0);
    let json = ran.json();
    assert_eq!(json["fits"], true);
    assert_eq!(json["device"], "ecp5-25k");
    let fmax = &json["fmax_mhz"];
    assert_eq!(
        [&fmax["min"], &fmax["median"], &fmax["max"]],
        [100.0, 150.0, 300.0]
    );
    assert_eq!(fmax["per_seed"][1]["seed"], 2);
    assert_eq!(json["cells"]["multipliers"], 2);
    assert_eq!(json["available"]["lut4"], 24288);
    let clocks = json["latency_cycles"].as_f64().unwrap();
    assert_eq!(json["latency_ns"].as_f64().unwrap(), clocks * 1e3 / 150.0);
    let interval = json["interval_cycles"].as_f64().unwrap();
    assert_eq!(
        json["inferences_per_second"].as_f64().unwrap(),
        150e6 / interval
    );
    let path = &json["critical_paths"][0];
    assert_eq!(path["through"][1], "net_l0/pe");
    assert_eq!(
        (&path["logic_ns"], &path["routing_ns"]),
        (&0.75.into(), &4.25.into())
    );
    // Command line, version and output of every run are kept.
    let kept = PathBuf::from(json["directory"].as_str().unwrap());
    for file in [
        "yosys.run.json",
        "seed-2.run.json",
        "seed-2-at-150-mhz.run.json",
        "rtl/tiny.v",
        "shell.v",
    ] {
        assert!(kept.join(file).exists(), "{file}");
    }
}

#[test]
fn what_is_there_is_not_done_again() {
    let place = bench(2, &[100.0, 200.0]);
    synth(&place, &[]).exits(0);
    synth(&place, &["--seeds", "2"]).exits(0);
    assert_eq!(place.read("yosys-runs"), "run\n");
    assert_eq!(place.read("seeds"), "1\n2\n");
    // The usual clock is too much for the first; none below what the placer promises is asked for.
    let routes = "1 150\n1 141.5\n1 125.9\n1 100\n1 112.2\n1 105.9\n1 102.9\n\
                  2 150\n2 212\n2 205.9\n";
    assert_eq!(place.read("routes"), routes);
    synth(&place, &["--seeds", "2"]).exits(0);
    assert_eq!(place.read("routes"), routes);
    // A clock that is asked for is another route of the same placement, and is enough.
    let ran = synth(&place, &["--freq", "50", "--json"]);
    ran.exits(0);
    assert_eq!(ran.json()["fmax_mhz"]["per_seed"][0]["sought_mhz"], 50.0);
    assert_eq!(place.read("seeds"), "1\n2\n");
    assert_eq!(place.read("routes"), format!("{routes}1 50\n"));
}

#[test]
fn a_clock_that_is_missed_is_no_success() {
    let place = bench(2, &[100.0, 300.0, 150.0]);
    let ran = synth(&place, &["--seeds", "3", "--freq", "160"]);
    ran.exits(1);
    assert!(
        ran.stderr
            .contains("a clock of 160 MHz expected, 150.0 MHz reached (median of 3)"),
        "{}",
        ran.stderr
    );
    assert!(ran.stdout.contains("net_l0/pe"), "{}", ran.stdout);
    synth(&place, &["--seeds", "3", "--freq", "150"]).exits(0);
}

/// The router that is always late, that takes its time above a clock, and that ends a little short.
#[test]
fn a_search_ends_and_keeps_what_it_found() {
    let place = bench(2, &[0.5]);
    let ran = synth(&place, &["--json"]);
    ran.exits(1);
    let message = ran.json()["error"]["message"].to_string();
    assert!(message.contains("no routes for seed 1"), "{message}");
    assert!(place.read("routes").ends_with("1 1\n"));

    let place = bench(2, &[170.0]);
    let tool = place.read("bin/nextpnr-ecp5");
    // It says nothing and goes on.
    place.write("bin/nextpnr-ecp5", &tool.replace("tmgfail=5", "tmgfail=0"));
    let ran = synth(&place, &["--timeout", "2", "--json"]);
    ran.exits(0);
    assert_eq!(ran.json()["fmax_mhz"]["max"], 170.0);
    assert!(!place.read("routes").is_empty());

    // 149.4 of 150 is no reason to give up.
    let place = bench(2, &[170.0]);
    place.write("report-1.json", &report(149.4));
    let tool = place.read("bin/nextpnr-ecp5");
    let short = tool.replace(
        "/report-$seed.json $out",
        "/$([ $freq = 150 ] && echo report-1 || echo better).json $out",
    );
    assert!(short != tool);
    place.write("better.json", &report(158.0));
    place.write("bin/nextpnr-ecp5", &short);
    let ran = synth(&place, &["--freq", "150", "--json"]);
    ran.exits(0);
    assert_eq!(ran.json()["fmax_mhz"]["max"], 158.0);
}

/// The fastest placement becomes a bitstream, if it bears the board's clock.
#[test]
fn a_bitstream_is_made_for_a_board() {
    let place = bench(2, &[100.0, 300.0]);
    let board = [
        "--board",
        "ulx3s-25f",
        "--seeds",
        "2",
        "--jobs",
        "1",
        "--json",
    ];
    let ran = synth(&place, &board);
    ran.exits(3);
    assert!(
        ran.stderr.contains("ecppack was not found"),
        "{}",
        ran.stderr
    );
    place.fake_tool(
        "bin/ecppack",
        "[ \"$1\" = --version ] && echo Version 1.4 && exit\n\
         [ \"$1\" = --compress ] && cat $2 > $3 && echo packed >> $3",
    );
    let ran = synth(&place, &board);
    ran.exits(0);
    let json = ran.json();
    assert_eq!(
        (&json["board"], &json["device"]),
        (&"ulx3s-25f".into(), &"ecp5-25k".into())
    );
    assert_eq!(
        json["tools"][2],
        serde_json::json!({"name": "ecppack", "version": "1.4"})
    );
    let bitstream = PathBuf::from(json["bitstream"].as_str().unwrap());
    assert_eq!(
        fs::read_to_string(&bitstream).unwrap(),
        "routed for 2\npacked\n"
    );
    let pins = fs::read_to_string(bitstream.with_file_name("pins.lpf")).unwrap();
    for pin in [
        r#""clk_i" SITE "G2""#,
        r#""bit_i" SITE "R1""#,
        r#""bit_o" SITE "B2""#,
    ] {
        assert!(pins.contains(pin), "{pins}");
    }
    // The board's clock is enough.
    assert_eq!(place.read("routes"), "1 25\n2 25\n");

    // A clock below the board's does not do away with it.
    let ran = synth(&place, &["--board", "ulx3s-25f", "--freq", "10", "--json"]);
    ran.exits(0);
    assert_eq!(ran.json()["fmax_mhz"]["per_seed"][0]["sought_mhz"], 25.0);

    // A packer that fails loses no clock, and one that writes nothing leaves no older file.
    fs::remove_file(&bitstream).unwrap();
    let version = "[ \"$1\" = --version ] && echo Version 1.4 && exit\n";
    place.fake_tool("bin/ecppack", &format!("{version}exit 9"));
    let ran = synth(&place, &board);
    ran.exits(3);
    let json = ran.json();
    assert_eq!(json["fmax_mhz"]["max"], 300.0);
    assert!(json["bitstream"].is_null());
    fs::write(
        bitstream.with_file_name("seed-2-at-25-mhz.part.bit"),
        "junk",
    )
    .unwrap();
    place.fake_tool("bin/ecppack", &format!("{version}exit 0"));
    synth(&place, &board).exits(3);
    assert!(!bitstream.exists());

    let place = bench(2, &[20.0]);
    place.fake_tool("bin/ecppack", &format!("{version}exit 9"));
    let ran = synth(&place, &["--board", "ulx3s-25f", "--json"]);
    ran.exits(1);
    let json = ran.json();
    assert_eq!(json["error"]["code"], "too-slow");
    assert!(json["bitstream"].is_null());

    let ran = synth(&place, &["--board", "icebreaker"]);
    ran.fails(
        2,
        "error: --board: one of the family of ecp5-25k, which the bundle is made for, expected, ice40-up5k found\n\
         help: emit it with --device ice40-up5k\n",
    );
    let ran = synth(&place, &["--board", "ulx3"]);
    ran.fails(
        2,
        "error: --board: one of icebreaker, ulx3s-25f, ulx3s-85f expected, `ulx3` found\n\
         help: did you mean ulx3s-85f?\n",
    );
}

/// One of the seeds fails: exit 3, and the others are told all the same.
#[test]
fn a_seed_that_fails_takes_none_of_the_others_with_it() {
    let place = bench(2, &[100.0, 200.0, 300.0]);
    fs::remove_file(place.path("report-2.json")).unwrap();
    let ran = synth(&place, &["--seeds", "3", "--json"]);
    ran.exits(3);
    let json = ran.json();
    let message = json["error"]["message"].as_str().unwrap();
    assert!(
        message.starts_with("seed 2: nextpnr-ecp5 failed"),
        "{message}"
    );
    let seeds = json["fmax_mhz"]["per_seed"].as_array().unwrap();
    let seeds: Vec<_> = seeds.iter().map(|seed| seed["seed"].as_u64()).collect();
    assert_eq!(seeds, [Some(1), Some(3)]);

    // What the others miss is told beside it.
    let ran = synth(&place, &["--seeds", "3", "--freq", "250"]);
    ran.exits(3);
    let told = "a clock of 250 MHz expected, 200.0 MHz reached (median of 2)";
    assert!(ran.stderr.contains(told), "{}", ran.stderr);
    let ran = synth(&place, &["--seeds", "3", "--freq", "250", "--json"]);
    assert_eq!(ran.json()["missed"], told);

    // Where others found room, it is not the core that doesn't fit.
    place.write("full-2", "");
    let ran = synth(&place, &["--seeds", "3", "--json"]);
    ran.exits(1);
    let json = ran.json();
    assert_eq!(
        (&json["error"]["code"], &json["fits"]),
        (&"no-placement".into(), &true.into())
    );
    let help = json["error"]["help"].as_str().unwrap();
    assert!(help.starts_with("others found room"), "{help}");
    assert_eq!(json["fmax_mhz"]["per_seed"].as_array().unwrap().len(), 2);
}

/// What is not known to take anything is not taken for nothing.
#[test]
fn cells_of_unknown_types_are_told() {
    let place = bench(2, &[200.0]);
    let other = netlist(2).replace("\"TRELLIS_FF\"", "\"TRELLIS_GG\"");
    place.write("netlist.json", &other);
    let ran = synth(&place, &["--json"]);
    ran.exits(0);
    assert_eq!(ran.json()["uncounted"]["TRELLIS_GG"], 1);
    let told = "cells of unknown types are not counted: 1 TRELLIS_GG";
    assert!(ran.stderr.contains(told), "{}", ran.stderr);
}

/// Two at a time would write the same files.
#[test]
fn a_directory_of_results_is_one_runs_at_a_time() {
    let place = bench(2, &[200.0]);
    let ran = synth(&place, &["--json"]);
    let directory = PathBuf::from(ran.json()["directory"].as_str().unwrap());
    let lock = fs::File::create(directory.join("lock")).unwrap();
    lock.lock().unwrap();
    let waiting = std::thread::spawn(move || {
        let ran = synth(&place, &["--json"]);
        ran.exits(0);
        ran.stderr
    });
    std::thread::sleep(std::time::Duration::from_millis(500));
    assert!(!waiting.is_finished());
    lock.unlock().unwrap();
    let stderr = waiting.join().unwrap();
    assert!(stderr.contains("waiting for another run"), "{stderr}");
}

#[test]
fn a_core_that_does_not_fit_is_told_with_what_is_short() {
    let place = bench(31, &[]);
    let ran = synth(&place, &["--json"]);
    ran.exits(1);
    let json = ran.json();
    assert_eq!(json["fits"], false);
    assert_eq!(json["error"]["code"], "does-not-fit");
    let message = json["error"]["message"].as_str().unwrap();
    assert_eq!(
        message,
        "does not fit on ecp5-25k: 3 multipliers too few (31 of 28)"
    );
    assert!(!place.path("seeds").exists());
}

#[test]
fn a_tool_that_dies_or_says_nothing_is_told() {
    let place = bench(2, &[200.0]);
    fs::remove_file(place.path("report-1.json")).unwrap();
    let ran = synth(&place, &[]);
    ran.exits(3);
    assert!(
        ran.stderr
            .contains("nextpnr-ecp5 failed with exit status: 1"),
        "{}",
        ran.stderr
    );
    assert!(
        ran.stderr.contains("seed-1-at-150-mhz.log"),
        "{}",
        ran.stderr
    );
    place.write("report-1.json", "{}");
    let ran = synth(&place, &[]);
    ran.exits(3);
    assert!(
        ran.stderr
            .contains("a report as nextpnr writes it expected"),
        "{}",
        ran.stderr
    );
    place.fake_tool(
        "bin/nextpnr-ecp5",
        "[ \"$1\" = --version ] && echo '(Version nextpnr-0.12)'; exit 0",
    );
    let ran = synth(&place, &[]);
    ran.exits(3);
    assert!(ran.stderr.contains("seed-1.part.json"), "{}", ran.stderr);
    place.fake_tool("bin/yosys", "[ \"$1\" = -V ] && echo 'Yosys 0.24'; exit 0");
    let ran = synth(&place, &[]);
    ran.exits(3);
    assert!(ran.stderr.contains("a netlist"), "{}", ran.stderr);
    let nowhere = place.path("nowhere");
    let ran = place.run_with_path(&nowhere, &["synth", "build/tiny"]);
    ran.exits(3);
    assert!(ran.stderr.contains("Yosys was not found"), "{}", ran.stderr);
}

#[test]
fn a_device_that_cannot_be_is_refused() {
    let place = Place::with_bundle();
    place.run(&["synth", "build/tiny"]).fails(
        2,
        "error: --device: a real one expected, `generic` found\n\
         help: one of 5csema5, ecp5-25k, ecp5-45k, ecp5-85k, gw2a-18, ice40-hx8k, ice40-up5k, nexus-40k, xczu3eg, xc7a35t, xc7a100t, xc7z020, xc7k325t\n",
    );
    let ran = place.run(&["synth", "build/tiny", "--device", "ecp5-85"]);
    ran.exits(2);
    assert!(
        ran.stderr.contains("did you mean ecp5-85k?"),
        "{}",
        ran.stderr
    );
    let own = Place::new();
    own.write("w.json", &tiny());
    own.run(&["emit", "--weights", "w.json", "--device", "ecp5-25k"])
        .exits(0);
    let ran = own.run(&["synth", "build/tiny", "--device", "generic"]);
    ran.exits(2);
    assert!(
        ran.stderr.contains("the family of ecp5-25k"),
        "{}",
        ran.stderr
    );
}

/// Where no open tool places, Yosys alone says what is taken.
#[test]
fn a_device_that_no_open_tool_places_on_is_synthesised() {
    let place = Place::new();
    place
        .run(&["emit", "--weights", "w.json", "--device", "xc7a35t"])
        .exits(0);
    let script = place.read("build/tiny/syn/tiny.vivado.tcl");
    assert!(script.contains("xc7a35tcpg236-1"), "{script}");
    let netlist = netlist(2)
        .replace("MULT18X18D", "DSP48E1")
        .replace("TRELLIS_FF", "FDRE");
    place.write("netlist.json", &netlist);
    let here = place.path("").display().to_string();
    place.fake_tool(
        "bin/yosys",
        &format!(
            "[ \"$1\" = -V ] && echo 'Yosys 0.23' && exit\n\
             grep -q 'synth_xilinx -family xc7 -flatten -top tiny_shell' synth.ys || exit 9\n\
             cp {here}/netlist.json netlist.part.json"
        ),
    );
    let ran = synth(&place, &["--json"]);
    ran.exits(0);
    let json = ran.json();
    assert_eq!(
        (&json["fits"], &json["fmax_mhz"]),
        (&true.into(), &serde_json::Value::Null)
    );
    assert_eq!(
        (&json["cells"]["multipliers"], &json["cells"]["ff"]),
        (&2.into(), &1.into())
    );
    let ran = synth(&place, &[]);
    assert!(
        ran.stdout.contains("LUT6") && ran.stdout.contains("not placed"),
        "{}",
        ran.stdout
    );
    for option in [
        ["--freq", "100"],
        ["--seeds", "3"],
        ["--floorplan", "f.svg"],
    ] {
        let ran = synth(&place, &option);
        ran.exits(2);
        let message = format!(
            "{}: a device that open tools place and route on expected, `xc7a35t` found",
            option[0]
        );
        assert!(ran.stderr.contains(&message), "{}", ran.stderr);
    }
}

/// Multipliers stand side by side as the data goes through them: the elements in turn, each with
/// its multipliers in turn, then the activations, then the next layer.
#[test]
fn multipliers_are_laid_out_in_the_order_of_the_data() {
    let place = bench(2, &[100.0]);
    let layer = |layer: &str, cell: &str| format!("u_core.u_mlp.u_net_{layer}.{cell}.u_block");
    let order = [
        layer("l0", "u_pe0.g_mul[0].u_mul"),
        layer("l0", "u_pe0.g_mul[1].u_mul"),
        layer("l0", "u_pe2.g_mul[0].u_mul"),
        layer("l0", "u_pe10.g_mul[0].u_mul"),
        layer("l0", "g_act[0].u_pwl.u_mul"),
        layer("l1", "u_pe0.g_mul[0].u_mul"),
        "u_core.u_other.u_mul".to_owned(),
    ];
    let cells = order.iter().map(|name| {
        let cell = serde_json::json!({"type": "MULT18X18D", "attributes": {"src": "x"}});
        (name.clone(), cell)
    });
    let cells: serde_json::Map<_, _> = cells.collect();
    let netlist = serde_json::json!({"modules": {"tiny_shell": {"attributes": {"top": "1"}, "cells": cells}}});
    place.write("netlist.json", &netlist.to_string());
    let ran = synth(&place, &["--json"]);
    ran.exits(0);
    let kept = PathBuf::from(ran.json()["directory"].as_str().unwrap()).join("netlist.json");
    let placed: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(kept).unwrap()).unwrap();
    let cells = &placed["modules"]["tiny_shell"]["cells"];
    // Seven of a row of 28, from the eleventh on.
    let columns = [26, 27, 33, 34, 37, 38, 42];
    for (name, column) in order.iter().zip(columns) {
        let site = cells[name]["attributes"]["BEL"].as_str().unwrap();
        assert!(
            site.starts_with(&format!("X{column}/Y13/")),
            "{name}: {site}"
        );
        assert_eq!(cells[name]["attributes"]["src"], "x");
    }
}

#[test]
fn the_picture_shows_the_layers_and_replaces_nothing_unasked() {
    let place = bench(2, &[100.0, 200.0]);
    let cell = |kind: &str, site: &str| serde_json::json!({"type": kind, "attributes": {"NEXTPNR_BEL": site}});
    let placed = serde_json::json!({"modules": {"tiny_shell": {"cells": {
        "u_core.u_mlp.u_net_l0.u_pe0.g_mul[0].u_mul.u_block": cell("MULT18X18D", "X4/Y13/MULT18_0"),
        "u_core.u_mlp.u_net_l0.operands_q_TRELLIS_FF_Q": cell("TRELLIS_FF", "X7/Y13/SLICEA.FF0"),
    }}}});
    place.write("placed.json", &format!("{placed}\n"));
    synth(&place, &["--seeds", "2", "--jobs", "1"]).exits(0);
    let draw = ["--seeds", "2", "--jobs", "1", "--floorplan", "f.svg"];
    synth(&place, &draw).exits(0);
    assert_eq!(place.read("seeds"), "1\n2\n");
    let picture = place.read("f.svg");
    assert!(picture.contains("tiny on ecp5-25k") && picture.contains("net_l0"));
    // A tile in the colour of the first layer, and the multiplier and its place in the legend.
    assert_eq!(picture.matches("fill=\"#e69f00\" fill-opacity").count(), 1);
    assert_eq!(picture.matches("stroke=\"#000000\"").count(), 2);
    let again = synth(&place, &draw);
    again.exits(2);
    assert!(again.stderr.contains("--force"), "{}", again.stderr);
    synth(&place, &[&draw[..], &["--force"]].concat()).exits(0);
    assert_eq!(place.read("seeds"), "1\n2\n");
}

#[test]
fn a_core_that_the_placer_finds_no_room_for_does_not_fit() {
    let place = bench(2, &[100.0]);
    place.fake_tool(
        "bin/nextpnr-ecp5",
        "[ \"$1\" = --version ] && echo '(Version nextpnr-0.11)' && exit\n\
         echo 'Info:     TRELLIS_COMB:   24100/  24288    99%'\n\
         echo 'Info:     MULT18X18D:         2/     28     7%'\n\
         echo 'ERROR: Unable to find legal placement for all cells, design is probably at utilisation limit.' >&2\n\
         exit 1",
    );
    let ran = synth(&place, &["--json"]);
    ran.exits(1);
    let error = &ran.json()["error"];
    assert_eq!(error["code"], "does-not-fit");
    let message = error["message"].as_str().unwrap();
    assert!(message.contains("24100 of 24288 LUT4"), "{message}");
    assert!(message.contains("2 of 28 multipliers"), "{message}");
}

#[test]
fn a_placer_that_fails_otherwise_is_a_tool_that_failed() {
    let place = bench(2, &[100.0]);
    place.fake_tool(
        "bin/nextpnr-ecp5",
        "[ \"$1\" = --version ] && echo '(Version nextpnr-0.11)' && exit\necho 'ERROR: no such pin' >&2\nexit 1",
    );
    let ran = synth(&place, &["--json"]);
    ran.exits(3);
    assert_eq!(ran.json()["error"]["code"], "tool-failed");
}
