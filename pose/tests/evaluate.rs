//! The error table: against its limits, and against estimators that are known to be bad.

use hwgen_pose::evaluate::{Evaluation, FloatEstimator, Method, Misfit, PUBLISHED, Row, Wiring};
use hwgen_pose::frames::Pose;
use hwgen_pose::sample::{NoiseShape, Sampler};
use hwgen_pose::scene::Scene;
use hwgen_pose::solve::Estimator;
use hwgen_pose::solve::ml::Ml;
use hwgen_spec::network::FloatNet;
use hwgen_spec::weights;
use nalgebra::Vector3;

mod support;
use support::landing;

fn with<T>(count: u64, run: impl FnOnce(Evaluation<'_>) -> T) -> T {
    let scene = landing();
    let sampler = Sampler::new(&scene, NoiseShape::Gaussian, 3).unwrap();
    run(Evaluation::new(&sampler, count))
}

fn percents(row: &Row) -> [f64; 2] {
    [row.position_pct.unwrap(), row.orientation_pct.unwrap()]
}

/// Maximum likelihood, moved and turned, and without an answer now and then.
struct Bad<'a> {
    ml: Ml<'a>,
    shift_m: f64,
    fails_beyond_m: f64,
}

impl Estimator for Bad<'_> {
    fn name(&self) -> &'static str {
        "bad"
    }

    fn estimate(&self, pixels: &[f64]) -> Option<Pose> {
        let mut pose = self.ml.estimate(pixels)?;
        let answered = pose.position_m.norm() < self.fails_beyond_m;
        pose.position_m.x += self.shift_m;
        answered.then_some(pose)
    }
}

#[test]
fn a_wrong_answer_shows_its_error() {
    with(300, |evaluation| {
        let bad = |shift_m, fails_beyond_m| Bad {
            ml: Ml::new(evaluation.scene()),
            shift_m,
            fails_beyond_m,
        };
        let row = evaluation.measure(&bad(0.25, 1e9), 0.0);
        assert_eq!((row.estimator.as_str(), row.failures), ("bad", Some(0)));
        assert!((row.position_m.unwrap() - 0.25).abs() < 1e-6);
        assert!(row.orientation_deg.unwrap() < 1e-6);
        // Distances are 10 to 51 m: the mean of 25/D %.
        assert!((25.0 / 51.0..25.0 / 10.0).contains(&row.position_pct.unwrap()));

        // Failures are counted, and are not in the means.
        let some = evaluation.measure(&bad(0.25, 30.0), 0.0);
        assert!((60..240).contains(&some.failures.unwrap()));
        assert!((some.position_m.unwrap() - 0.25).abs() < 1e-6);
        assert!(some.position_pct.unwrap() > row.position_pct.unwrap());

        let none = evaluation.measure(&bad(0.0, 0.0), 0.0);
        assert_eq!((none.position_pct, none.failures), (None, Some(300)));
        let not_a_number = evaluation.measure(&bad(f64::NAN, 1e9), 0.0);
        assert_eq!(not_a_number.failures, Some(300));
    });
}

#[test]
fn the_limits_are_those_of_the_scene() {
    // 2000 poses: a standard error of about 2 %.
    with(2000, |evaluation| {
        for (method, noise_px, expected) in [
            (Method::Crb, 1.0, [1.37, 18.3]),
            (Method::Ml, 1.0, [1.37, 18.2]),
            (Method::Bayes, 1.0, [1.25, 17.0]),
            (Method::Bayes, 5.0, [4.08, 51.8]),
        ] {
            let row = evaluation.row(method, noise_px).unwrap();
            for (found, expected) in percents(&row).into_iter().zip(expected) {
                let ratio = found / expected;
                assert!(
                    (0.93..1.07).contains(&ratio),
                    "{row:?}: {expected} expected"
                );
            }
            assert_eq!(row.failures, Some(0));
            assert_eq!(row.us_per_pose.is_some(), method != Method::Crb);
            assert_eq!(row.effective_samples.is_some(), method == Method::Bayes);
        }
    });
}

#[test]
fn every_method_is_exact_without_noise() {
    with(50, |evaluation| {
        for method in Method::ALL {
            let row = evaluation.row(method, 0.0).unwrap();
            assert_eq!(row.estimator, method.name());
            if method != Method::Paper {
                assert!(percents(&row).iter().all(|e| *e < 1e-3), "{row:?}");
            }
        }
    });
}

#[test]
fn published_rows_stand_at_their_levels_alone() {
    with(1, |evaluation| {
        for cell in PUBLISHED {
            let row = evaluation.row(Method::Paper, cell.noise_px).unwrap();
            assert_eq!(percents(&row), [cell.position_pct, cell.orientation_pct]);
            assert_eq!((row.position_m, row.failures), (None, None));
        }
        assert_eq!(evaluation.row(Method::Paper, 5.0), None);
    });
}

#[test]
fn uniform_noise_counts_by_its_deviation() {
    let scene = landing();
    let bound = |shape, noise_px| {
        let sampler = Sampler::new(&scene, shape, 3).unwrap();
        let row = Evaluation::new(&sampler, 10).row(Method::Crb, noise_px);
        row.unwrap().position_m.unwrap()
    };
    let gaussian = bound(NoiseShape::Gaussian, 1.0);
    let uniform = bound(NoiseShape::Uniform, 3f64.sqrt());
    assert!((gaussian - uniform).abs() < 1e-9 * gaussian);
}

#[test]
fn a_relative_error_of_nothing_is_none() {
    let mut draft = support::landing_draft();
    for i in 3..6 {
        (draft.poses.lower[i], draft.poses.upper[i]) = (0.0, 0.0);
    }
    let scene = Scene::new(draft).unwrap();
    let sampler = Sampler::new(&scene, NoiseShape::Gaussian, 3).unwrap();
    let row = Evaluation::new(&sampler, 20).row(Method::Ml, 1.0).unwrap();
    assert_eq!(row.orientation_pct, None);
    assert!(row.orientation_deg.unwrap() > 0.0 && row.position_pct.is_some());
}

/// Networks without a hidden layer whose position is a constant; inputs in another order.
fn still(edit: impl Fn(String) -> String) -> FloatNet {
    let names: Vec<String> = (0..5)
        .rev()
        .flat_map(|i| [format!("\"v{i}\""), format!("\"u{i}\"")])
        .collect();
    let zeros = ["0"; 10].join(",");
    let text = format!(
        r#"{{"format": "hwgen-weights/1", "name": "still",
          "inputs": {{"names": [{}], "unit": "px", "min": [{zeros}], "max": [{}]}},
          "networks": [
            {{"name": "orientation", "layers": [{{"activation": "linear",
              "weights": [[{zeros}], [{zeros}], [{zeros}]], "bias": [0, 0, 0]}}],
              "outputs": {{"names": ["rz", "ry", "rx"], "unit": "rad"}}}},
            {{"name": "position", "layers": [{{"activation": "linear",
              "weights": [[{zeros}], [{zeros}], [1, {}]], "bias": [-30, 1, 0]}}],
              "outputs": {{"names": ["x", "y", "z"], "unit": "m"}}}}]}}"#,
        names.join(","),
        ["1280"; 10].join(","),
        ["0"; 9].join(","),
    );
    weights::read(edit(text).as_bytes()).unwrap()
}

#[test]
fn networks_are_wired_by_name() {
    let scene = landing();
    let net = still(|text| text);
    let wiring = Wiring::new(&net, &scene).unwrap();
    let pixels: Vec<f64> = (0..10).map(f64::from).collect();
    assert_eq!(
        wiring.inputs(&pixels),
        [9.0, 8.0, 7.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0, 0.0]
    );
    let pose = FloatEstimator::new(&net, &wiring)
        .estimate(&pixels)
        .unwrap();
    assert_eq!(pose.position_m, Vector3::new(-30.0, 1.0, 9.0));
    let turned = wiring.pose(&[3.0, 2.0, 1.0, 0.0, 0.0, 0.0]).unwrap();
    let r = turned.rodrigues_rad();
    assert!(r.x < r.y && r.y < r.z, "{r}");
    assert_eq!(wiring.pose(&[0.0, f64::INFINITY, 0.0, 0.0, 0.0, 0.0]), None);

    // Useless networks are seen to be useless.
    with(100, |evaluation| {
        let row = evaluation.measure(&FloatEstimator::new(&net, &wiring), 0.0);
        assert_eq!(row.orientation_pct, Some(100.0));
        assert!(row.position_pct.unwrap() > 100.0);
    });
}

#[test]
fn networks_that_do_not_fit_are_named() {
    let scene = landing();
    let misfit = |from: &str, to: &str| -> Misfit {
        let net = still(|text| text.replace(from, to));
        Wiring::new(&net, &scene).unwrap_err()
    };
    let told = |misfit: &Misfit| format!("{}: {misfit}", misfit.path());
    assert_eq!(
        told(&misfit("\"u3\"", "\"w3\"")),
        "inputs.names: an input `u3` expected, v4, u4, v3, w3, v2, u2, v1, u1, v0, u0 found"
    );
    assert_eq!(
        told(&misfit("\"rx\"", "\"roll\"")),
        "networks: an output `orientation.rx` expected, orientation.rz, orientation.ry, \
         orientation.roll, position.x, position.y, position.z found"
    );
    assert_eq!(
        told(&misfit("\"rad\"", "\"deg\"")),
        "networks[0].outputs.unit: the unit rad expected, `deg` found"
    );
    assert_eq!(
        told(&misfit("\"px\"", "\"mm\"")),
        "inputs.unit: the unit px expected, `mm` found"
    );
    let mut draft = support::landing_draft();
    draft.landmarks_m.pop();
    draft.name = "four".into();
    let four = Scene::new(draft).unwrap();
    assert_eq!(
        told(&Wiring::new(&still(|text| text), &four).unwrap_err()),
        "inputs: 8 inputs expected, two for each landmark of the scene four, 10 found"
    );
}
