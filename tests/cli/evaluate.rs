//! `hwgen evaluate`

use serde_json::Value;

use super::harness::Place;

const SCENE: &str = include_str!("../../designs/landing/scene.toml");
const WEIGHTS: &str = include_str!("../../designs/landing/weights.json");

fn place() -> Place {
    let place = Place::new();
    place.write("scene.toml", SCENE);
    place.write("landing.json", WEIGHTS);
    place
}

fn arguments(rest: &str) -> Vec<&str> {
    let all = ["evaluate", "--scene", "scene.toml"].into_iter();
    all.chain(rest.split_whitespace()).collect()
}

/// The rows without what a clock measured.
fn untimed(json: &Value) -> Vec<Value> {
    let mut rows = json["rows"].as_array().expect("rows").clone();
    for row in &mut rows {
        let row = row.as_object_mut().expect("a row");
        row.remove("us_per_pose").expect("a time, or none");
    }
    rows
}

fn find<'a>(json: &'a Value, estimator: &str, noise_px: f64) -> &'a Value {
    let rows = json["rows"].as_array().expect("rows");
    let row = rows
        .iter()
        .find(|row| row["estimator"] == estimator && row["noise_px"] == noise_px);
    row.unwrap_or_else(|| panic!("{estimator} at {noise_px} px expected in {json}"))
}

#[test]
fn all_estimators_have_a_row_at_each_level() {
    let place = place();
    let (ran, json) = place.json(&arguments(
        "--weights landing.json --noise 0,1 --count 60 --seed 4 -q",
    ));
    ran.exits(0);
    assert_eq!(ran.stderr, "");
    assert_eq!((&json["count"], &json["seed"]), (&60.into(), &4.into()));
    for estimator in [
        "paper",
        "crb",
        "ml",
        "bayes",
        "epnp",
        "sqpnp",
        "p3p-ransac",
        "network-float",
        "network-fixed",
    ] {
        for noise_px in [0.0, 1.0] {
            let row = find(&json, estimator, noise_px);
            let measured = !["paper", "crb"].contains(&estimator);
            assert_eq!(row["us_per_pose"].is_f64(), measured, "{row}");
            assert_eq!(row["position_m"].is_f64(), estimator != "paper", "{row}");
            assert!(row["position_pct"].is_f64() && row["orientation_pct"].is_f64());
        }
    }
    assert_eq!(json["rows"].as_array().expect("rows").len(), 18);
    assert!(find(&json, "bayes", 1.0)["effective_samples"].as_f64() > Some(50.0));
    // The hardware's arithmetic is as good as the float networks, and not the same.
    let error = |estimator| {
        find(&json, estimator, 1.0)["position_pct"]
            .as_f64()
            .expect("it")
    };
    let ratio = error("network-fixed") / error("network-float");
    assert!(ratio != 1.0 && (0.98..1.02).contains(&ratio), "{ratio}");
    assert_eq!(json["latency_cycles"], 273);
}

#[test]
fn numbers_and_pictures_do_not_depend_on_threads() {
    let place = place();
    let mut runs = Vec::new();
    for threads in ["1", "2"] {
        let mut command = place.command(&arguments(
            "--weights landing.json --count 600 --json --force --noise 0,1 \
             --estimators crb,bayes,p3p-ransac,network-float,network-fixed \
             --picture errors.svg --view view.svg",
        ));
        let output = command.env("RAYON_NUM_THREADS", threads).output();
        let stdout = output.expect("starts").stdout;
        let json: Value = serde_json::from_slice(&stdout).expect("an object");
        runs.push((
            untimed(&json),
            place.read("errors.svg"),
            place.read("view.svg"),
        ));
    }
    assert_eq!(runs[0], runs[1]);
}

#[test]
fn a_bundle_is_what_its_weights_are() {
    let place = place();
    place.run(&["emit", "--weights", "landing.json"]).exits(0);
    let rows = |networks: &str| {
        let rest =
            format!("{networks} --count 50 --noise 0.5 --estimators network-fixed,network-float");
        let (ran, json) = place.json(&arguments(&rest));
        ran.exits(0);
        untimed(&json)
    };
    let from_weights = rows("--weights landing.json");
    assert_eq!(from_weights, rows("--bundle build/landing"));
    // The table's order, whatever that of the option.
    assert_eq!(from_weights[0]["estimator"], "network-float");
}

#[test]
fn wrong_networks_show_wrong_errors() {
    let place = place();
    // The first output's bias is another.
    let mut wrong: serde_json::Value = serde_json::from_str(WEIGHTS).expect("a weights file");
    let bias = &mut wrong["networks"][0]["layers"][1]["bias"][0];
    *bias = (bias.as_f64().expect("a number") + 0.5).into();
    place.write("wrong.json", &wrong.to_string());
    let error = |weights: &str| {
        let rest = format!("--weights {weights} --count 50 --noise 0 --estimators network-fixed");
        let (ran, json) = place.json(&arguments(&rest));
        ran.exits(0);
        find(&json, "network-fixed", 0.0)["position_pct"]
            .as_f64()
            .expect("an error")
    };
    let (right, wrong) = (error("landing.json"), error("wrong.json"));
    assert!(right < 1.0 && wrong > 5.0 * right, "{right} {wrong}");
}

#[test]
fn the_table_for_people_and_the_one_in_the_file() {
    let place = place();
    let ran = place.run(&arguments(
        "--count 30 --noise 0,3 --estimators crb,bayes,ml --csv errors.csv -q",
    ));
    ran.exits(0);
    let stdout = &ran.stdout;
    for expected in [
        "landing: 5 landmarks, 30 poses, gaussian noise, seed 1\n",
        "\nMean relative error: position / orientation, %\n",
        "\nTime of a pose on one thread, us\n",
        "the prior is information",
        "Written to errors.csv.\n",
    ] {
        assert!(
            stdout.contains(expected),
            "`{expected}` expected in {stdout}"
        );
    }
    assert!(!stdout.contains("NaN") && !stdout.contains("without an answer"));
    let csv = place.read("errors.csv");
    assert_eq!(
        csv.lines().next(),
        Some(
            "estimator,noise_px,position_pct,orientation_pct,position_m,orientation_deg,\
             us_per_pose,failures,effective_samples"
        )
    );
    assert_eq!(csv.lines().count(), 7);
    assert!(
        csv.lines()
            .nth(1)
            .is_some_and(|line| line.starts_with("crb,0.0,0.0,0.0,"))
    );
}

#[test]
fn pictures_are_xml_and_show_what_was_measured() {
    let place = place();
    place
        .run(&arguments(
            "--weights landing.json --count 40 --picture out/errors.svg --view out/view.svg",
        ))
        .exits(0);
    for (name, expected) in [
        (
            "errors.svg",
            &[
                "network-fixed",
                "Cramér-Rao",
                "noise on each pixel coordinate, px",
            ][..],
        ),
        (
            "view.svg",
            &["v, px", "u, px", "elevation", "landmark 4", "noise of 5 px"],
        ),
    ] {
        let text = place.read(&format!("out/{name}"));
        let document = roxmltree::Document::parse(&text).expect(name);
        assert_eq!(document.root_element().tag_name().name(), "svg");
        let words: Vec<&str> = document.descendants().filter_map(|n| n.text()).collect();
        for word in expected {
            assert!(
                words.iter().any(|w| w.contains(word)),
                "`{word}` expected in {name}"
            );
        }
        assert!(!text.contains("NaN") && !text.contains("inf"), "{name}");
    }
    let mut view = Vec::new();
    let text = place.read("out/view.svg");
    let document = roxmltree::Document::parse(&text).expect("XML");
    for node in document.descendants().filter(|n| n.has_tag_name("circle")) {
        view.push(node);
    }
    // Five landmarks and a magnified one in each of four images, and one in the legend.
    assert_eq!(view.len(), 4 * 6 + 1);
}

#[test]
fn bad_requests_are_refused() {
    let place = place();
    let four = SCENE.replace("    [4.0, 3.0, 0.0],\n", "");
    assert_ne!(four, SCENE);
    place.write("four.toml", &four);
    place.write("old.csv", "precious");
    for (rest, message) in [
        (
            "--noise -1",
            "a finite number of pixels, zero or more, expected",
        ),
        (
            "--noise 0,nan",
            "a finite number of pixels, zero or more, expected",
        ),
        (
            "--noise 0,,1",
            "a finite number of pixels, zero or more, expected",
        ),
        (
            "--noise 1,1.0",
            "--noise: levels that differ expected, 1 found twice",
        ),
        ("--count 0", "a whole number from 1 to 10000000 expected"),
        ("--count -5", "a whole number from 1 to 10000000 expected"),
        ("--estimators ml,opnp", "invalid value 'opnp'"),
        (
            "--estimators ml,network-float",
            "--weights or --bundle expected",
        ),
        (
            "--weights w.json",
            "w.json: inputs: 10 inputs expected, two for each landmark of the scene landing, 3 found",
        ),
        (
            "--scene four.toml --weights landing.json",
            "the argument '--scene <S.toml>' cannot be used multiple times",
        ),
        ("--weights none.json", "none.json: No such file"),
        ("--bundle none", "none/manifest.json: a manifest"),
        ("--weights w.json --bundle b", "cannot be used with"),
        (
            "--csv scene.toml",
            "scene.toml: another file than that of the inputs expected",
        ),
        (
            "--weights landing.json --picture landing.json --force",
            "landing.json: another file than that of the inputs expected",
        ),
        (
            "--csv old.csv",
            "old.csv: a new file expected, an existing one found",
        ),
        ("--csv a --view ./a", "another file for --view expected"),
    ] {
        let ran = place.run(&arguments(rest));
        ran.exits(2);
        assert!(ran.stderr.contains(message), "`{rest}`: {}", ran.stderr);
        assert_eq!(ran.stdout, "");
        assert!(!place.path("a").exists());
    }
    let fewer = place.run(&[
        "evaluate",
        "--scene",
        "four.toml",
        "--weights",
        "landing.json",
    ]);
    fewer.exits(2);
    assert!(
        fewer.stderr.contains("inputs: 8 inputs expected"),
        "{}",
        fewer.stderr
    );
    assert_eq!(place.read("old.csv"), "precious");
    let (ran, json) = place.json(&arguments("--weights w.json"));
    ran.exits(2);
    assert_eq!(json["error"]["code"], "misfit");
    assert_eq!(json["error"]["path"], "inputs");
}
