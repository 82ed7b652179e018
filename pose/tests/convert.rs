//! Conversions against OpenCV and SciPy, and against their inverses.

mod support;

use hwgen_pose::camera_file;
use hwgen_pose::convert::{Axes, BodyPose, CameraPose, RollPitchYaw};
use hwgen_pose::frames::{Attitude, Pose, camera_from_body};
use hwgen_pose::scene::Scene;
use nalgebra::{Rotation3, Vector3};
use proptest::prelude::*;
use serde_json::Value;
use support::landing;

const AXES: [(Axes, &str); 2] = [(Axes::Rep103, "rep103"), (Axes::Frd, "frd")];

/// `data/conversions.json`, which `data/conversions.py` wrote.
fn independent() -> Value {
    serde_json::from_str(include_str!("data/conversions.json")).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    let items = value.as_array().unwrap().iter();
    items.map(|v| v.as_f64().unwrap()).collect()
}

fn vector(value: &Value) -> Vector3<f64> {
    Vector3::from_vec(numbers(value))
}

fn pose_of(case: &Value) -> Pose {
    Pose::new(vector(&case["position_m"]), vector(&case["rodrigues_rad"]))
}

#[track_caller]
fn close(found: &[f64], expected: &[f64]) {
    let near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-9;
    let same = found.len() == expected.len() && found.iter().zip(expected).all(near);
    assert!(same, "{found:?}\n{expected:?}");
}

#[test]
fn poses_are_those_of_opencv_and_scipy() {
    let data = independent();
    let mount = camera_from_body(data["mount_deg"].as_f64().unwrap().to_radians());
    let offset_m = data["offset_m"].as_f64().unwrap();
    let cases = data["cases"].as_array().unwrap();
    assert!(cases.len() > 20);
    for case in cases {
        let pose = pose_of(case);
        for (axes, key) in [(Axes::Deck, "opencv_deck"), (Axes::Rep103, "opencv_rep103")] {
            let camera = CameraPose::of(&pose, &mount, axes);
            close(camera.rvec_rad.as_slice(), &numbers(&case[key]["rvec"]));
            close(camera.tvec_m.as_slice(), &numbers(&case[key]["tvec"]));
        }
        for (axes, key) in AXES {
            let body = BodyPose::of(&pose, offset_m, axes);
            close(body.position_m.as_slice(), &numbers(&case[key]["position"]));
            close(&body.wxyz(), &numbers(&case[key]["wxyz"]));
            let angles = RollPitchYaw::of(&pose, axes);
            let angles = [angles.roll_rad, angles.pitch_rad, angles.yaw_rad];
            close(&angles, &numbers(&case[key]["rpy"]));
        }
    }
}

#[test]
fn poses_come_back_from_those_of_opencv_and_scipy() {
    let data = independent();
    let mount = camera_from_body(data["mount_deg"].as_f64().unwrap().to_radians());
    let offset_m = data["offset_m"].as_f64().unwrap();
    for case in data["cases"].as_array().unwrap() {
        let pose = pose_of(case);
        for (axes, key) in [(Axes::Deck, "opencv_deck"), (Axes::Rep103, "opencv_rep103")] {
            let camera = CameraPose {
                rvec_rad: vector(&case[key]["rvec"]),
                tvec_m: vector(&case[key]["tvec"]),
            };
            same(&camera.pose(&mount, axes), &pose);
        }
        for (axes, key) in AXES {
            let wxyz = numbers(&case[key]["wxyz"]).try_into().unwrap();
            let body = BodyPose::from_wxyz(vector(&case[key]["position"]), wxyz).unwrap();
            same(&body.pose(offset_m, axes), &pose);
            let [roll_rad, pitch_rad, yaw_rad] = numbers(&case[key]["rpy"]).try_into().unwrap();
            let angles = RollPitchYaw {
                roll_rad,
                pitch_rad,
                yaw_rad,
            };
            let turned = angles.deck_from_body(axes);
            assert!((turned.matrix() - pose.deck_from_body.matrix()).norm() < 1e-9);
        }
    }
}

#[track_caller]
fn same(found: &Pose, expected: &Pose) {
    assert!((found.position_m - expected.position_m).norm() < 1e-9);
    let turned = found.deck_from_body.matrix() - expected.deck_from_body.matrix();
    assert!(turned.norm() < 1e-9, "{turned}");
}

#[test]
fn pixels_are_those_of_opencv_with_the_camera_file_that_it_wrote() {
    let data = independent();
    let calibration = camera_file::read(include_bytes!("data/cameras/opencv4.yaml")).unwrap();
    let mut draft = landing().draft().clone();
    let mount = camera_file::Mount {
        mount_rad: data["mount_deg"].as_f64().unwrap().to_radians(),
        offset_m: data["offset_m"].as_f64().unwrap(),
    };
    draft.camera = calibration.camera(calibration.size_px.unwrap(), mount);
    let landmarks = data["landmarks_m"].as_array().unwrap();
    draft.landmarks_m = landmarks.iter().map(vector).collect();
    let scene = Scene::new(draft).unwrap();
    let seen: Vec<&Value> = data["cases"].as_array().unwrap().iter().collect();
    let seen: Vec<_> = seen.iter().filter(|c| !c["pixels_xy"].is_null()).collect();
    assert!(seen.len() > 10);
    for case in seen {
        let pixels = scene.project(&pose_of(case)).unwrap();
        let found: Vec<f64> = pixels
            .chunks_exact(2)
            .flat_map(|uv| [uv[1], scene.camera().height_px - uv[0]])
            .collect();
        let expected = case["pixels_xy"].as_array().unwrap().iter();
        let expected: Vec<f64> = expected.flat_map(numbers).collect();
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found - expected).abs() < 1e-6, "{found} {expected}");
        }
    }
}

#[test]
fn a_quaternion_of_length_zero_is_none() {
    assert_eq!(BodyPose::from_wxyz(Vector3::zeros(), [0.0; 4]), None);
    let turned = BodyPose::from_wxyz(Vector3::zeros(), [-2.0, 0.0, 0.0, -2.0]).unwrap();
    close(&turned.wxyz(), &[0.5f64.sqrt(), 0.0, 0.0, 0.5f64.sqrt()]);
}

fn any_axes() -> impl Strategy<Value = Axes> {
    prop::sample::select(vec![Axes::Deck, Axes::Rep103, Axes::Frd])
}

/// Rotation vectors of all lengths from zero to pi, many of them near the ends.
fn any_turn() -> impl Strategy<Value = Vector3<f64>> {
    let axis = (-1.0..1.0, -1.0..1.0, -1.0..1.0);
    let axis = axis.prop_map(|(x, y, z)| Vector3::new(x, y, z));
    let axis = axis.prop_filter("an axis", |a| a.norm() > 1e-3);
    let pi = std::f64::consts::PI;
    let angle = prop_oneof![
        Just(0.0),
        Just(pi),
        (-14.0..0.4f64).prop_map(|e| 10f64.powf(e)),
        (-14.0..0.0f64).prop_map(move |e| pi - 10f64.powf(e)),
    ];
    (axis, angle).prop_map(|(axis, angle)| axis.normalize() * angle)
}

fn any_place() -> impl Strategy<Value = Vector3<f64>> {
    (-50.0..50.0, -50.0..50.0, -50.0..50.0).prop_map(|(x, y, z)| Vector3::new(x, y, z))
}

proptest! {
    #[test]
    fn every_conversion_has_its_inverse(
        place in any_place(),
        turn in any_turn(),
        mount in -1.5..1.5,
        offset_m in -2.0..2.0,
        axes in any_axes(),
    ) {
        let pose = Pose::new(place, turn);
        let mount = camera_from_body(mount);
        let near = |found: &Pose| {
            let turned = found.deck_from_body.matrix() - pose.deck_from_body.matrix();
            (found.position_m - place).norm() < 1e-9 && turned.norm() < 1e-9
        };
        prop_assert!(near(&CameraPose::of(&pose, &mount, axes).pose(&mount, axes)));
        let body = BodyPose::of(&pose, offset_m, axes);
        prop_assert!(near(&body.pose(offset_m, axes)));
        let again = BodyPose::from_wxyz(body.position_m, body.wxyz()).unwrap();
        prop_assert!(near(&again.pose(offset_m, axes)));
        prop_assert!(CameraPose::of(&pose, &mount, axes).rvec_rad.norm() <= std::f64::consts::PI + 1e-12);
        prop_assert!(body.wxyz()[0] >= 0.0);
    }

    #[test]
    fn angles_have_their_inverse(
        roll_rad in -3.1..3.1,
        pitch_rad in -1.57..1.57,
        yaw_rad in -3.1..3.1,
        axes in any_axes(),
    ) {
        let angles = RollPitchYaw { roll_rad, pitch_rad, yaw_rad };
        let pose = Pose { position_m: Vector3::zeros(), deck_from_body: angles.deck_from_body(axes) };
        let back = RollPitchYaw::of(&pose, axes).deck_from_body(axes);
        prop_assert!((back.matrix() - pose.deck_from_body.matrix()).norm() < 1e-9);
    }

    #[test]
    fn both_angles_are_the_sequence_zyx(
        roll_rad in -3.1..3.1,
        pitch_rad in -1.5..1.5,
        yaw_rad in -3.1..3.1,
        axes in prop::sample::select(vec![Axes::Rep103, Axes::Frd]),
    ) {
        let angles = RollPitchYaw { roll_rad, pitch_rad, yaw_rad };
        let about = |axis, angle| Rotation3::from_axis_angle(&axis, angle);
        let zyx = about(Vector3::z_axis(), yaw_rad)
            * about(Vector3::y_axis(), pitch_rad)
            * about(Vector3::x_axis(), roll_rad);
        let from_deck = axes.from_deck();
        let turned = from_deck * angles.deck_from_body(axes) * from_deck.inverse();
        prop_assert!((turned.matrix() - zyx.matrix()).norm() < 1e-12);
    }
}

#[test]
fn at_a_quarter_turn_of_pitch_the_attitude_is_kept() {
    for pitch_rad in [1.0, -1.0].map(|sign| sign * std::f64::consts::FRAC_PI_2) {
        let attitude = Attitude {
            roll_rad: 0.3,
            pitch_rad,
            yaw_rad: -0.4,
        };
        let pose = Pose {
            position_m: Vector3::zeros(),
            deck_from_body: attitude.body_from_deck().inverse(),
        };
        for axes in [Axes::Deck, Axes::Rep103, Axes::Frd] {
            let angles = RollPitchYaw::of(&pose, axes);
            assert_eq!(angles.roll_rad, 0.0);
            let back = angles.deck_from_body(axes);
            assert!((back.matrix() - pose.deck_from_body.matrix()).norm() < 1e-7);
        }
    }
}
