//! Frames, projection and its derivatives, the view test, and samples.

mod support;

use hwgen_pose::frames::{Attitude, Pose, rodrigues};
use hwgen_pose::sample::{NoiseShape, Sampler};
use hwgen_pose::scene::{Distortion, Parameters, Scene, parameters_of, pose_of};
use nalgebra::{Rotation3, UnitQuaternion, Vector2, Vector3};
use proptest::prelude::*;
use support::{landing, landing_draft};

#[test]
fn level_flight_sees_the_deck_ahead() {
    let mut draft = landing_draft();
    draft.camera.mount_rad = 0.0;
    let scene = Scene::new(draft).unwrap();
    let pose = Pose::new(Vector3::new(-20.0, 0.0, 0.0), Vector3::zeros());
    let pixels = scene.project(&pose).unwrap();
    // Landmark 0 is 20 m ahead, 2 m up, 4 m to the left.
    assert_eq!(pixels[..2], [360.0 + 100.0, 640.0 - 200.0]);
    // The mast light is 24 m ahead, 3 m up.
    assert_eq!(pixels[8..], [360.0 + 125.0, 640.0]);
}

#[test]
fn a_mount_that_looks_down_moves_the_image_up() {
    let scene = landing();
    let pose = Pose::new(Vector3::new(-20.0, 0.0, 0.0), Vector3::zeros());
    let pixels = scene.project(&pose).unwrap();
    assert!(pixels[0] > 460.0 && pixels[8] > 485.0);
}

#[test]
fn what_lies_behind_is_not_seen() {
    let scene = landing();
    assert_eq!(
        scene.project(&Pose::new(Vector3::new(1.0, 0.0, 0.0), Vector3::zeros())),
        None
    );
}

#[test]
fn the_body_is_behind_its_camera() {
    let q = Parameters::from([20.0, 0.05, -0.02, 0.03, 0.2, -0.1]);
    let pose = pose_of(&q);
    let back = pose.position_m - pose.body_position_m(0.5);
    assert!((back.norm() - 0.5).abs() < 1e-12);
    // Equation 3: x_B = p - C_B^N (L, 0, 0)'.
    assert!((pose.deck_from_body.inverse() * back - Vector3::new(0.5, 0.0, 0.0)).norm() < 1e-12);
}

fn angle() -> impl Strategy<Value = f64> {
    -3.1..3.1
}

proptest! {
    #[test]
    fn attitude_and_matrix_say_the_same(roll in angle(), pitch in -1.5..1.5, yaw in angle()) {
        let attitude = Attitude { roll_rad: roll, pitch_rad: pitch, yaw_rad: yaw };
        let turned = Attitude::of(&attitude.body_from_deck());
        prop_assert!((turned.roll_rad - roll).abs() < 1e-9);
        prop_assert!((turned.pitch_rad - pitch).abs() < 1e-9);
        prop_assert!((turned.yaw_rad - yaw).abs() < 1e-9);
    }

    #[test]
    fn rodrigues_vectors_are_exact_from_zero_to_pi(
        axis in (-1.0..1.0, -1.0..1.0, -1.0..1.0),
        exponent in -12.0..0.0,
        near_pi in any::<bool>(),
    ) {
        let axis = Vector3::new(axis.0, axis.1, axis.2);
        prop_assume!(axis.norm() > 1e-3);
        let small = 10f64.powf(exponent) * std::f64::consts::PI;
        let angle = if near_pi { std::f64::consts::PI - small } else { small };
        let quaternion = UnitQuaternion::from_axis_angle(&nalgebra::Unit::new_normalize(axis), angle);
        let found = rodrigues(&quaternion.to_rotation_matrix());
        prop_assert!((found - axis.normalize() * angle).norm() < 1e-9, "{found} {angle}");
        let back = Rotation3::new(found);
        prop_assert!((back.matrix() - quaternion.to_rotation_matrix().matrix()).norm() < 1e-12);
    }

    #[test]
    fn parameters_and_poses_say_the_same(unit in prop::array::uniform6(0.0..1.0)) {
        let scene = landing();
        let widths = scene.poses().widths();
        let q = Parameters::from_fn(|i, _| scene.poses().lower[i] + widths[i] * unit[i]);
        prop_assert!((parameters_of(&pose_of(&q)) - q).norm() < 1e-9);
    }

    #[test]
    fn derivatives_are_those_of_finite_differences(
        unit in prop::array::uniform6(0.0..1.0),
        bent in any::<bool>(),
    ) {
        let mut draft = landing_draft();
        if bent {
            draft.camera.distortion = Distortion {
                radial: [-0.28, 0.07, 0.01],
                tangential: [1e-3, -5e-4],
            };
        }
        let scene = Scene::new(draft).unwrap();
        let widths = scene.poses().widths();
        let q = Parameters::from_fn(|i, _| scene.poses().lower[i] + widths[i] * unit[i]);
        let (pixels, jacobian) = scene.linearize(&q).unwrap();
        let seen = nalgebra::DVector::from(scene.project(&pose_of(&q)).unwrap());
        prop_assert!((pixels - seen).norm() < 1e-9);
        for k in 0..6 {
            let step = 1e-5 * q[k].abs().max(0.1);
            let at = |by: f64| {
                let mut moved = q;
                moved[k] += by;
                scene.project(&pose_of(&moved)).unwrap()
            };
            let (ahead, behind) = (at(step), at(-step));
            for row in 0..scene.inputs() {
                let difference = (ahead[row] - behind[row]) / (2.0 * step);
                let error = (difference - jacobian[(row, k)]).abs();
                prop_assert!(error < 1e-5 * (1.0 + difference.abs()), "{row} {k}: {error}");
            }
        }
    }

    #[test]
    fn straightening_undoes_bending(up in -0.4..0.4, right in -0.6..0.6) {
        let distortion = Distortion { radial: [-0.28, 0.07, 0.0], tangential: [1e-3, -5e-4] };
        let ray = Vector2::new(up, right);
        let back = distortion.straighten(distortion.bend(ray)).unwrap();
        prop_assert!((back - ray).norm() < 1e-10);
    }
}

#[test]
fn samples_do_not_depend_on_order_and_are_in_view() {
    let scene = landing();
    let sampler = Sampler::new(&scene, NoiseShape::Gaussian, 7).unwrap();
    let ahead: Vec<_> = (0..100).map(|i| sampler.draw(i)).collect();
    for i in (0..100).rev() {
        let sample = sampler.draw(i);
        assert_eq!(sample, ahead[usize::try_from(i).unwrap()]);
        assert!(scene.in_view(&sample.clean_px));
        assert!(scene.poses().contains(&sample.parameters));
    }
    let other = Sampler::new(&scene, NoiseShape::Gaussian, 8).unwrap();
    assert_ne!(other.draw(0), ahead[0]);
}

#[test]
fn noise_has_the_moments_that_its_name_says() {
    let scene = landing();
    for (shape, deviation) in [
        (NoiseShape::Gaussian, 1.0),
        (NoiseShape::Uniform, 1.0 / 3f64.sqrt()),
    ] {
        let sampler = Sampler::new(&scene, shape, 1).unwrap();
        let noise: Vec<f64> = (0..2000).flat_map(|i| sampler.draw(i).unit_noise).collect();
        let count = 20_000.0;
        let mean = noise.iter().sum::<f64>() / count;
        let square = noise.iter().map(|n| n * n).sum::<f64>() / count;
        assert!(mean.abs() < 5.0 * deviation / count.sqrt(), "{mean}");
        assert!((square.sqrt() / deviation - 1.0).abs() < 0.03, "{square}");
    }
}

#[test]
fn landmarks_that_are_never_in_view_are_told() {
    let mut draft = landing_draft();
    draft.camera.mount_rad = 1.2;
    let scene = Scene::new(draft).unwrap();
    let error = Sampler::new(&scene, NoiseShape::Gaussian, 1).unwrap_err();
    assert_eq!(error.in_view, 0);
}
