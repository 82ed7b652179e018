//! Scene files: reading, writing, and the designs' own.
//!
//! What is refused stands in `tests/errors/scenes`, which the command line's tests read.

mod support;

use hwgen_pose::camera_file;
use hwgen_pose::sample::{NoiseShape, Sampler};
use hwgen_pose::scene::{Distortion, Scene};
use hwgen_pose::scene_file::{read, write};
use proptest::prelude::*;
use support::{landing, landing_draft};

const LANDING: &str = include_str!("../../designs/landing/scene.toml");

fn no_file(name: &str) -> Result<Vec<u8>, String> {
    Err(format!("no {name}"))
}

fn scene(text: &str) -> Scene {
    match read(text.as_bytes(), no_file) {
        Ok(file) => file.into_scene(),
        Err(error) => panic!("{error}\n{text}"),
    }
}

#[test]
fn the_landing_scene_is_the_canonical_one() {
    assert_eq!(scene(LANDING), landing());
}

#[test]
fn most_poses_of_the_designs_are_in_view() {
    let texts = [
        ("landing", LANDING),
        (
            "flat_deck_8",
            include_str!("../../designs/scenes/flat-deck-8.toml"),
        ),
        ("quad_4", include_str!("../../designs/scenes/quad-4.toml")),
    ];
    for (name, text) in texts {
        let scene = scene(text);
        assert_eq!(scene.name(), name);
        let sampler = Sampler::new(&scene, NoiseShape::Gaussian, 1).unwrap();
        let drawn: u32 = (0..1000).map(|i| sampler.draw(i).drawn).sum();
        assert!(drawn < 2000, "{name}: 1000 of {drawn} in view");
        // The six parameters can be told apart from the pixels anywhere in the box.
        for i in 0..100 {
            let (_, jacobian) = scene.linearize(&sampler.draw(i).parameters).unwrap();
            let weakest = jacobian.svd(false, false).singular_values.min();
            assert!(weakest > 1e-2, "{name}: {weakest}");
        }
    }
}

#[test]
fn distortion_and_two_focal_lengths_are_optional() {
    let text = LANDING.replace(
        "focal_px = 1000.0",
        "focal_px = [990, 1010]\ndistortion = { k1 = -0.28, p2 = -5e-4 }",
    );
    let camera = *scene(&text).camera();
    assert_eq!((camera.focal_u_px, camera.focal_v_px), (990.0, 1010.0));
    let expected = Distortion {
        radial: [-0.28, 0.0, 0.0],
        tangential: [0.0, -5e-4],
    };
    assert_eq!(camera.distortion, expected);
}

/// The landing scene, its camera's numbers replaced by a line.
fn with_camera_file(line: &str) -> String {
    let intrinsic = [
        "width_px",
        "height_px",
        "focal_px",
        "center_u_px",
        "center_v_px",
    ];
    let kept = LANDING
        .lines()
        .filter(|l| !intrinsic.iter().any(|key| l.starts_with(key)))
        .map(|l| {
            if l == "[camera]" {
                format!("[camera]\n{line}")
            } else {
                l.to_owned()
            }
        });
    kept.collect::<Vec<_>>().join("\n")
}

#[test]
fn a_calibration_stands_for_the_cameras_numbers() {
    let file = include_bytes!("data/cameras/ros.yaml");
    let text = with_camera_file("calibration = \"camera.yaml\"");
    let given = |name: &str| {
        assert_eq!(name, "camera.yaml");
        Ok(file.to_vec())
    };
    let camera = *read(text.as_bytes(), given).unwrap().scene().camera();
    let calibration = camera_file::read(file).unwrap();
    let mount = camera_file::Mount {
        mount_rad: camera.mount_rad,
        offset_m: camera.offset_m,
    };
    assert_eq!(camera, calibration.camera((1280.0, 720.0), mount));
    assert_eq!(camera.mount_rad, (-2.5f64).to_radians());
    // The record of it needs no file.
    let record = write(read(text.as_bytes(), given).unwrap().scene());
    assert_eq!(*scene(&record).camera(), camera);
}

#[test]
fn a_calibration_without_a_size_takes_the_scenes() {
    let file = include_str!("data/cameras/ros.yaml");
    let file = file.split_once("camera_name").unwrap().1;
    let file = format!("camera_name{file}");
    let given = |_: &str| Ok(file.clone().into_bytes());
    let text = with_camera_file("calibration = \"c.yaml\"\nwidth_px = 1280\nheight_px = 720");
    let scene = read(text.as_bytes(), given).unwrap().into_scene();
    assert_eq!(scene.camera().center_u_px, 720.0 - 355.0);
    let text = with_camera_file("calibration = \"c.yaml\"");
    let error = read(text.as_bytes(), given).unwrap_err();
    assert!(
        error
            .to_string()
            .starts_with("camera: the key width_px expected"),
        "{error}"
    );
}

#[test]
fn landmarks_never_in_view_are_told_at_the_pose_box() {
    let text = LANDING.replace("mount_deg = -2.5", "mount_deg = 60.0");
    let file = read(text.as_bytes(), no_file).unwrap();
    let error = Sampler::new(file.scene(), NoiseShape::Gaussian, 1).unwrap_err();
    let error = file.never_in_view(&error);
    let line = 1 + text.lines().position(|l| l.starts_with("[poses]")).unwrap();
    assert_eq!((error.fault().line, error.fault().column), (line, 1));
    assert!(
        error
            .to_string()
            .starts_with("poses: all landmarks in view"),
        "{error}"
    );
}

#[test]
fn damaged_files_do_not_panic() {
    let bytes = LANDING.as_bytes();
    for end in 0..bytes.len() {
        let _ = read(&bytes[..end], no_file);
        for byte in *b"'=[\xff" {
            let mut damaged = bytes.to_vec();
            damaged[end] = byte;
            let _ = read(&damaged, no_file);
        }
    }
    let deep = format!("name = {}", "[".repeat(100_000));
    assert!(read(deep.as_bytes(), no_file).is_err());
}

proptest! {
    #[test]
    fn a_written_scene_is_read_as_the_same(
        degrees in prop::array::uniform6(0.0..5.0f64),
        numbers in prop::array::uniform6(-1.0..1.0f64),
        square in any::<bool>(),
        bent in any::<bool>(),
    ) {
        let mut draft = landing_draft();
        for (i, d) in degrees.iter().enumerate().skip(1) {
            draft.poses.upper[i] = d.to_radians();
        }
        draft.camera.mount_rad = (-degrees[0]).to_radians();
        draft.camera.offset_m = numbers[0];
        draft.camera.center_u_px += numbers[1];
        draft.landmarks_m[1].x = numbers[2];
        draft.margin_px = degrees[1];
        if !square {
            draft.camera.focal_u_px += numbers[3];
        }
        if bent {
            draft.camera.distortion.radial = [numbers[4], 1e-9 * numbers[5], 0.0];
            draft.camera.distortion.tangential = [0.0, numbers[3] * 1e-20];
        }
        let written = Scene::new(draft).unwrap();
        prop_assert_eq!(scene(&write(&written)), written);
    }
}
