//! The canonical scene, as a draft that tests may change.

use hwgen_pose::scene::{Camera, Distortion, Parameters, PoseBox, Scene, SceneDraft};
use nalgebra::Vector3;

/// The canonical scene: a capture frame and a mast light behind it.
pub fn landing_draft() -> SceneDraft {
    let degrees = |numbers: [f64; 6]| {
        Parameters::from_fn(|i, _| {
            if i == 0 {
                numbers[0]
            } else {
                numbers[i].to_radians()
            }
        })
    };
    SceneDraft {
        name: "landing".into(),
        landmarks_m: vec![
            Vector3::new(0.0, 2.0, -4.0),
            Vector3::new(0.0, 2.0, 4.0),
            Vector3::new(0.0, -2.0, -4.0),
            Vector3::new(0.0, -2.0, 4.0),
            Vector3::new(4.0, 3.0, 0.0),
        ],
        camera: Camera {
            width_px: 1280.0,
            height_px: 720.0,
            focal_u_px: 1000.0,
            focal_v_px: 1000.0,
            center_u_px: 360.0,
            center_v_px: 640.0,
            mount_rad: (-2.5f64).to_radians(),
            offset_m: 0.5,
            distortion: Distortion::default(),
        },
        poses: PoseBox {
            lower: degrees([10.0, -5.0, -8.0, -5.0, -5.0, -5.0]),
            upper: degrees([50.0, 10.0, 8.0, 5.0, 5.0, 5.0]),
        },
        margin_px: 10.0,
    }
}

/// The canonical scene, checked.
pub fn landing() -> Scene {
    Scene::new(landing_draft()).unwrap()
}
