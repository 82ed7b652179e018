//! `hwgen sample`

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use super::harness::Place;

const LANDING: &str = include_str!("../../designs/landing/scene.toml");

fn place() -> Place {
    let place = Place::new();
    place.write("scene.toml", LANDING);
    place
}

fn rows(text: &str) -> Vec<Vec<f64>> {
    let lines = text.lines().skip(1);
    let cells = |l: &str| l.split(',').map(|c| c.parse().expect(c)).collect();
    lines.map(cells).collect()
}

fn arguments(rest: &str) -> Vec<&str> {
    let all = ["sample", "--scene", "scene.toml"].into_iter();
    all.chain(rest.split_whitespace()).collect()
}

#[test]
fn a_table_goes_to_standard_output_and_the_summary_beside_it() {
    let place = place();
    let ran = place.run(&arguments("--count 1500 --noise 1 --seed 7"));
    ran.exits(0);
    let header = "u0,v0,u1,v1,u2,v2,u3,v3,u4,v4,x_m,y_m,z_m,rx_rad,ry_rad,rz_rad";
    assert_eq!(ran.stdout.lines().next(), Some(header));
    let table = rows(&ran.stdout);
    assert_eq!(table.len(), 1500);
    assert!(table.iter().all(|row| row.len() == 16 && row[10] < -9.9));
    assert!(
        ran.stderr.contains("1500 samples of the scene landing"),
        "{}",
        ran.stderr
    );
    let quiet = place.run(&arguments("--count 1500 --noise 1 --seed 7 --quiet"));
    assert_eq!((quiet.stdout, quiet.stderr.as_str()), (ran.stdout, ""));
}

#[test]
fn rows_do_not_depend_on_threads_nor_on_how_many_follow() {
    let place = place();
    let all = place.run(&arguments("--count 20000 --noise 0.5"));
    for threads in ["1", "3"] {
        let mut command = place.command(&arguments("--count 20000 --noise 0.5"));
        let output = command.env("RAYON_NUM_THREADS", threads).output();
        assert_eq!(output.expect("starts").stdout, all.stdout.as_bytes());
    }
    let few = place.run(&arguments("--count 700 --noise 0.5"));
    assert!(all.stdout.starts_with(&few.stdout));
    let other = place.run(&arguments("--count 700 --noise 0.5 --seed 2"));
    assert_ne!(other.stdout, few.stdout);
}

#[test]
fn noise_is_added_to_the_same_poses() {
    let place = place();
    let clean = rows(&place.run(&arguments("--count 4000 --noise 0")).stdout);
    for (shape, deviation) in [("gaussian", 2.0), ("uniform", 2.0 / 3f64.sqrt())] {
        let options = format!("--count 4000 --noise 2 --noise-shape {shape}");
        let noisy = rows(&place.run(&arguments(&options)).stdout);
        let mut squares = 0.0;
        for (clean, noisy) in clean.iter().zip(&noisy) {
            assert_eq!(clean[10..], noisy[10..]);
            let pixels = clean[..10].iter().zip(&noisy[..10]);
            squares += pixels.map(|(a, b)| (a - b).powi(2)).sum::<f64>();
        }
        let found = (squares / 40_000.0).sqrt();
        assert!((found / deviation - 1.0).abs() < 0.02, "{shape}: {found}");
    }
}

#[test]
fn an_object_tells_what_was_drawn() {
    let place = place();
    let (ran, json) = place.json(&arguments("--count 40 --noise 1 --seed 3 -q"));
    ran.exits(0);
    assert_eq!(ran.stderr, "");
    assert_eq!((&json["count"], &json["seed"]), (&40.into(), &3.into()));
    assert_eq!(json["noise_px"], 1.0);
    assert_eq!(json["noise_shape"], "gaussian");
    let accepted = json["accepted_fraction"].as_f64().expect("a fraction");
    assert!((0.5..=1.0).contains(&accepted), "{accepted}");
    let text = place.run(&arguments("--count 40 --noise 1 --seed 3"));
    let cells = |row: &serde_json::Value| -> Vec<f64> {
        let cells = row.as_array().expect("a row").iter();
        cells.map(|c| c.as_f64().expect("a number")).collect()
    };
    let table: Vec<_> = json["rows"]
        .as_array()
        .expect("rows")
        .iter()
        .map(cells)
        .collect();
    let expected = rows(&text.stdout);
    assert_eq!(table.len(), expected.len());
    // The reader of JSON in this test is off by a rounding.
    let near = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-14 * b.abs();
    let pairs = table.iter().flatten().zip(expected.iter().flatten());
    assert_eq!(pairs.filter(|pair| !near(*pair)).count(), 0);

    let (ran, json) = place.json(&arguments("--count 40 --noise 1 --seed 3 --out new/t.csv"));
    ran.exits(0);
    assert!(json.get("rows").is_none());
    assert_eq!(json["out"], "new/t.csv");
    assert_eq!(place.read("new/t.csv"), text.stdout);
    let left = fs::read_dir(place.path("new"))
        .expect("a directory")
        .count();
    assert_eq!(left, 1, "nothing but the result is left");
}

#[test]
fn a_file_that_is_there_is_kept() {
    let place = place();
    place.write("t.csv", "mine\n");
    let ran = place.run(&arguments("--count 5 --noise 1 --out t.csv"));
    ran.fails(
        2,
        "error: t.csv: a new file expected, an existing one found\n\
         help: write to another file, or replace this one with --force\n",
    );
    assert_eq!(place.read("t.csv"), "mine\n");
    let ran = place.run(&arguments("--count 5 --noise 1 --out t.csv --force"));
    ran.exits(0);
    assert_eq!(place.read("t.csv").lines().count(), 6);
    let ran = place.run(&arguments("--count 5 --noise 1 --out ./scene.toml --force"));
    ran.exits(2);
    assert_eq!(place.read("scene.toml"), LANDING);
}

#[test]
fn a_reader_that_leaves_ends_the_drawing() {
    use std::io::Read;
    let place = place();
    let mut child = place
        .command(&arguments("--count 1000000000 --noise 1"))
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::null())
        .spawn()
        .expect("starts");
    let mut first = [0; 100];
    let mut stdout = child.stdout.take().expect("a pipe");
    stdout.read_exact(&mut first).expect("a header");
    drop(stdout);
    assert!(child.wait().expect("ends").success());
}

fn cases(extension: &str) -> Vec<PathBuf> {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/errors/scenes");
    let entries = fs::read_dir(directory).expect("cases");
    let mut paths: Vec<_> = entries
        .map(|entry| entry.expect("a case").path())
        .filter(|path| path.extension().is_some_and(|e| e == extension))
        .collect();
    paths.sort();
    paths
}

/// Adding a case is adding a file: write the `.toml`, run with `BLESS=1`, read the `.txt`.
///
/// A first line `# options: ...` stands for `--count 10 --noise 1`; camera files stand beside.
#[test]
fn refused_scenes_give_the_message_beside_them() {
    let bless = std::env::var_os("BLESS").is_some_and(|v| v == "1");
    let scenes = cases("toml");
    assert!(scenes.len() > 60, "only {} cases", scenes.len());
    let mut wrong = Vec::new();
    for path in &scenes {
        let name = path.file_name().and_then(|n| n.to_str()).expect("a name");
        let text = fs::read_to_string(path).expect("a scene");
        let found = refusal(name, &text);
        let expected = path.with_extension("txt");
        if bless {
            fs::write(&expected, &found).expect("written");
        }
        match fs::read_to_string(&expected) {
            Ok(expected) if expected == found => {}
            Ok(expected) => wrong.push(format!("{name}\nexpected: {expected}found:    {found}")),
            Err(_) => wrong.push(format!("{name} has no .txt; found: {found}")),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    for text in cases("txt") {
        assert!(text.with_extension("toml").exists(), "{}", text.display());
    }
}

/// Standard error and exit code, the same with and without `--json`, and nothing written.
fn refusal(name: &str, text: &str) -> String {
    let place = Place::new();
    place.write(name, text);
    for camera in ["yaml", "xml"].into_iter().flat_map(cases) {
        let name = camera.file_name().expect("a name");
        fs::copy(&camera, place.path("").join(name)).expect("copied");
    }
    let files = || -> BTreeSet<_> {
        let entries = fs::read_dir(place.path("")).expect("a directory");
        entries.map(|e| e.expect("a file").file_name()).collect()
    };
    let before = files();
    let options = text
        .lines()
        .next()
        .and_then(|l| l.strip_prefix("# options: "));
    let mut arguments = vec!["sample", "--scene", name, "--out", "new/out.csv"];
    arguments.extend(options.unwrap_or("--count 10 --noise 1").split_whitespace());
    let ran = place.run(&arguments);
    assert_eq!(ran.stdout, "", "{name}");
    assert!(!ran.stderr.contains("panicked"), "{name}: {}", ran.stderr);
    let (json_ran, json) = place.json(&arguments);
    assert_eq!(json_ran.code, ran.code, "{name}");
    assert_eq!(json["ok"], false, "{name}");
    for key in ["code", "message", "help"] {
        assert!(json["error"][key].is_string(), "{name}: {key}: {json}");
    }
    assert_eq!(files(), before, "{name}");
    let code = ran.code.expect("an exit code");
    format!("{}exit code: {code}\n", ran.stderr)
}
