//! `hwgen run`

use super::harness::Place;

const INPUTS: &str = "note,c,a,b\nfirst,0.5,-0.25,1\nsecond,0,0,0\noutside,0,1.5,0\n";

#[test]
fn results_go_to_standard_output_and_the_summary_beside_them() {
    let place = Place::with_bundle();
    place.write("in.csv", INPUTS);
    let ran = place.run(&["run", "build/tiny", "--inputs", "in.csv", "--raw"]);
    ran.exits(0);
    let lines: Vec<&str> = ran.stdout.lines().collect();
    assert_eq!(
        lines[0],
        "net.x,net.y,net.x#raw,net.y#raw,saturated,outside_box"
    );
    assert_eq!(lines.len(), 4);
    assert!(lines[1].ends_with(",0,0"));
    assert!(lines[3].ends_with(",0,1"));
    // Values are codes times a power of two, in full.
    let cells: Vec<f64> = lines[1]
        .split(',')
        .map(|c| c.parse().expect("a number"))
        .collect();
    let step = cells[0] / cells[2];
    assert_eq!(step.log2().fract(), 0.0);
    assert_eq!(cells[1] / cells[3], step);
    assert!(ran.stderr.contains("3 frames in "), "{}", ran.stderr);
    assert!(
        ran.stderr
            .contains("note: 1 of 3 rows outside of the input box"),
        "{}",
        ran.stderr
    );
    let quiet = place.run(&[
        "run",
        "build/tiny",
        "--inputs",
        "in.csv",
        "--raw",
        "--quiet",
    ]);
    assert_eq!((quiet.stdout, quiet.stderr.as_str()), (ran.stdout, ""));
}

#[test]
fn an_object_holds_the_rows_if_no_file_does() {
    let place = Place::with_bundle();
    place.write("in.csv", INPUTS);
    let (ran, json) = place.json(&["run", "build/tiny", "--inputs", "in.csv", "-q"]);
    ran.exits(0);
    assert_eq!(ran.stderr, "");
    assert_eq!(json["frames"], 3);
    assert_eq!(json["rows_outside_box"], 1);
    assert_eq!(json["rows"].as_array().expect("rows").len(), 3);
    assert_eq!(json["columns"][0], "net.x");
    assert!(json["inferences_per_second"].as_f64().expect("a speed") > 0.0);
    let cycles = json["cycles"].clone();

    let arguments = [
        "run",
        "build/tiny",
        "--inputs",
        "in.csv",
        "--out",
        "new/out.csv",
    ];
    let (ran, json) = place.json(&[&arguments[..], &["--cycle-accurate"]].concat());
    ran.exits(0);
    assert_eq!(json["cycles"], cycles);
    assert!(json.get("rows").is_none());
    assert_eq!(place.read("new/out.csv").lines().count(), 4);
    let left = std::fs::read_dir(place.path("new"))
        .expect("a directory")
        .count();
    assert_eq!(left, 1, "nothing but the result is left");
}

#[test]
fn refused_vectors_are_told_with_their_place() {
    let place = Place::with_bundle();
    let cases = [
        (
            "",
            "csv-empty",
            "in.csv: a header with the names of the columns expected, an empty file found",
        ),
        (
            "a,b,cc\n1,2,3\n",
            "csv-missing-column",
            "in.csv:1: a column `c` expected, none found",
        ),
        (
            "a,b,c\n1,2,x\n",
            "csv-number",
            "in.csv:2:3: column `c`: a finite number expected, `x` found",
        ),
        (
            "a,b,c\n1,2,3\n1,2\n",
            "csv-ragged",
            "in.csv:3: 3 values expected, as many as in the header, 2 found",
        ),
        (
            "a,b,c,a\n1,2,3,4\n",
            "csv-duplicate-column",
            "in.csv:1:4: columns with different names expected, `a` found twice",
        ),
    ];
    for (text, code, message) in cases {
        place.write("in.csv", text);
        for arguments in [
            &[
                "run",
                "build/tiny",
                "--inputs",
                "in.csv",
                "--out",
                "out.csv",
            ][..],
            &["verify", "build/tiny", "--vectors", "in.csv"],
        ] {
            let ran = place.run(arguments);
            ran.exits(2);
            let first = ran.stderr.lines().next();
            assert_eq!(first, Some(format!("error: {message}").as_str()));
            let (_, json) = place.json(arguments);
            assert_eq!(json["error"]["code"], code);
            assert_eq!(json["error"]["path"], "in.csv");
            assert!(!place.path("out.csv").exists());
        }
    }
    place.write("in.csv", "a,b,C\n1,2,3\n");
    let ran = place.run(&["run", "build/tiny", "--inputs", "in.csv"]);
    assert!(
        ran.stderr.contains("the nearest of them are `C`, `a`, `b`"),
        "{}",
        ran.stderr
    );
}

#[test]
fn an_unwritable_result_is_told() {
    let place = Place::with_bundle();
    place.write("in.csv", INPUTS);
    let ran = place.run(&[
        "run",
        "build/tiny",
        "--inputs",
        "in.csv",
        "--out",
        "w.json/out.csv",
    ]);
    ran.exits(2);
    assert!(ran.stderr.starts_with("error: w.json"), "{}", ran.stderr);
    place
        .run(&["run", "build/tiny", "--inputs", "in.csv", "--out", "build"])
        .exits(2);
}

#[test]
fn nothing_is_overwritten_that_may_be_missed() {
    let place = Place::with_bundle();
    place.write("in.csv", INPUTS);
    place.write("old.csv", "precious");
    let run = |out: &[&str]| {
        place.run(&[&["run", "build/tiny", "--inputs", "in.csv", "-q"], out].concat())
    };
    run(&["--out", "old.csv"]).fails(
        2,
        "error: old.csv: a new file expected, an existing one found\n\
         help: write to another file, or replace this one with --force\n",
    );
    assert_eq!(place.read("old.csv"), "precious");
    run(&["--out", "old.csv", "--force"]).exits(0);
    assert_eq!(place.read("old.csv").lines().count(), 4);

    // With or without --force, under whatever name.
    std::os::unix::fs::symlink("in.csv", place.path("link.csv")).expect("linked");
    let manifest = place.read("build/tiny/manifest.json");
    let vcd = ["--cycle-accurate", "--vcd"];
    for (out, message) in [
        ("in.csv", "another file than that of the inputs expected"),
        (
            "new/../in.csv",
            "another file than that of the inputs expected",
        ),
        ("link.csv", "another file than that of the inputs expected"),
        (
            "build/tiny/manifest.json",
            "a file outside of the bundle expected",
        ),
        (
            "build/tiny/new.csv",
            "a file outside of the bundle expected",
        ),
        (
            "new/../build/tiny/rtl/n.v",
            "a file outside of the bundle expected",
        ),
    ] {
        for force in [&[][..], &["--force"]] {
            for option in [&["--out"][..], &vcd] {
                let ran = run(&[option, &[out], force].concat());
                ran.exits(2);
                let first = ran.stderr.lines().next();
                assert_eq!(first, Some(format!("error: {out}: {message}").as_str()));
            }
        }
    }
    assert_eq!(place.read("in.csv"), INPUTS);
    assert_eq!(place.read("build/tiny/manifest.json"), manifest);
    assert!(!place.path("new").exists());
    run(&[&["--out", "same"], &vcd[..], &["./same"]].concat()).exits(2);
    assert!(!place.path("same").exists());
    // A device is no file.
    run(&["--out", "/dev/null"]).exits(0);
}

#[test]
fn the_landing_design_is_as_good_as_in_float() {
    let place = Place::new();
    let root = env!("CARGO_MANIFEST_DIR");
    let weights = format!("{root}/designs/landing/weights.json");
    let vectors = format!("{root}/designs/landing/vectors.csv");
    place.run(&["emit", "--weights", &weights]).exits(0);
    let arguments = [
        "run",
        "build/landing",
        "--inputs",
        &vectors,
        "--out",
        "out.csv",
    ];
    place.run(&arguments).exits(0);
    let truth = std::fs::read_to_string(&vectors).expect("vectors");
    let result = place.read("out.csv");
    let column = |text: &str, name: &str| -> Vec<f64> {
        let mut lines = text.lines();
        let header = lines.next().expect("a header");
        let index = header.split(',').position(|n| n == name).expect(name);
        lines
            .map(|l| {
                l.split(',')
                    .nth(index)
                    .expect(name)
                    .parse()
                    .expect("a number")
            })
            .collect()
    };
    let columns = |text: &str, names: [&str; 3]| names.map(|n| column(text, n));
    let error = |estimate: &[Vec<f64>; 3], truth: &[Vec<f64>; 3], row: usize| {
        let norm = |f: &dyn Fn(usize) -> f64| (0..3).map(|i| f(i).powi(2)).sum::<f64>().sqrt();
        norm(&|i| estimate[i][row] - truth[i][row]) / norm(&|i| truth[i][row])
    };
    let noise = column(&truth, "noise_px");
    for (fixed, float, true_) in [
        (
            ["position.x", "position.y", "position.z"],
            ["float_x_m", "float_y_m", "float_z_m"],
            ["x_m", "y_m", "z_m"],
        ),
        (
            ["orientation.rx", "orientation.ry", "orientation.rz"],
            ["float_rx_rad", "float_ry_rad", "float_rz_rad"],
            ["rx_rad", "ry_rad", "rz_rad"],
        ),
    ] {
        let (fixed, float) = (columns(&result, fixed), columns(&truth, float));
        let true_ = columns(&truth, true_);
        for level in [0.0, 1.0] {
            let rows: Vec<usize> = (0..noise.len()).filter(|i| noise[*i] == level).collect();
            assert!(!rows.is_empty());
            let mean = |estimate| {
                rows.iter()
                    .map(|r| error(estimate, &true_, *r))
                    .sum::<f64>()
            };
            let ratio = mean(&fixed) / mean(&float);
            assert!((0.99..1.01).contains(&ratio), "{level} px: {ratio}");
        }
    }
}
