//! The scene file: TOML to [`Scene`] and back.
//!
//! [`read`] gives a scene that keeps its promises, or the first error with its place.
//! Nothing is repaired, and no key is skipped.
//!
//! All keys are required but two of `[camera]`.
//! `distortion` gives coefficients of [`Distortion`]; those left out are zero.
//! `calibration` names a [camera file](crate::camera_file) in place of `focal_px`, `center_u_px`,
//! `center_v_px` and `distortion`; of `width_px` and `height_px` too if it knows them.
//! `focal_px` is a number, or `[focal_u, focal_v]` where pixels are not square.
//!
//! ```
//! let text = r#"
//! name = "quad"
//! landmarks = [[0, 2, -3], [0, 2, 3], [0, -1, 0], [3, 3, 0]] # m, X forward, Y up, Z right
//! [camera]
//! width_px = 640      # extent of v, to the right
//! height_px = 480     # extent of u, up
//! focal_px = 500
//! center_u_px = 240
//! center_v_px = 320
//! mount_deg = -5      # negative looks down
//! offset_m = 0.2      # ahead of the body's origin
//! [poses]             # uniform and independent
//! distance_m = [10, 30]
//! elevation_deg = [0, 8]
//! azimuth_deg = [-5, 5]
//! roll_deg = [-5, 5]
//! pitch_deg = [-5, 5]
//! yaw_deg = [-5, 5]
//! margin_px = 5
//! "#;
//! let no_files = |name: &str| Err(format!("no file {name}"));
//! let scene = hwgen_pose::scene_file::read(text.as_bytes(), no_files)?.into_scene();
//! assert_eq!(scene.landmarks_m().len(), 4);
//!
//! let again = hwgen_pose::scene_file::write(&scene);
//! assert_eq!(hwgen_pose::scene_file::read(again.as_bytes(), no_files)?.scene(), &scene);
//!
//! let error = hwgen_pose::scene_file::read(text.replace("500", "0").as_bytes(), no_files);
//! let error = error.unwrap_err();
//! assert_eq!(error.to_string(), "camera.focal_px: a number above zero expected, 0 found");
//! assert_eq!((error.fault().line, error.fault().column), (7, 12));
//! # Ok::<(), hwgen_pose::error::FileError>(())
//! ```

use hwgen_spec::json::Fault;
use nalgebra::Vector3;

use crate::camera_file::{self, Calibration, Mount};
use crate::document::{At, Document, Table};
use crate::error::{FileError, SceneError};
use crate::sample::NeverInView;
use crate::scene::{Camera, Distortion, PARAMETER_NAMES, Parameters, PoseBox, Scene, SceneDraft};

mod write;

pub use write::write;

/// Longest scene or camera file, in bytes: 1 MiB.
pub const MAX_BYTES: usize = crate::document::MAX_BYTES;

const ROOT_KEYS: &[&str] = &["name", "landmarks", "camera", "poses"];
const CAMERA_KEYS: &[&str] = &[
    "width_px",
    "height_px",
    "focal_px",
    "center_u_px",
    "center_v_px",
    "mount_deg",
    "offset_m",
    "distortion",
    "calibration",
];
/// Keys whose values a calibration gives.
const CALIBRATED_KEYS: &[&str] = &["focal_px", "center_u_px", "center_v_px", "distortion"];
const POSES_KEYS: &[&str] = &[
    "distance_m",
    "elevation_deg",
    "azimuth_deg",
    "roll_deg",
    "pitch_deg",
    "yaw_deg",
    "margin_px",
];
const DISTORTION_KEYS: &[&str] = &["k1", "k2", "p1", "p2", "k3"];

/// A scene, and where its fields stand in the file.
#[derive(Clone, Debug)]
pub struct SceneFile {
    scene: Scene,
    document: Document,
}

/// Reads a scene file.
///
/// `calibration` gives the bytes of the camera file of a name, relative to the scene file, or says
/// why it can't.
///
/// # Errors
/// The first fault with its place: syntax, an unknown, missing or doubled key, a wrong type, a
/// number that is not finite, a refused camera file, or a scene that cannot be.
pub fn read(
    text: &[u8],
    calibration: impl FnOnce(&str) -> Result<Vec<u8>, String>,
) -> Result<SceneFile, FileError> {
    let document = Document::toml(text)?;
    let draft = draft(document.root(), calibration)?;
    match Scene::new(draft) {
        Ok(scene) => Ok(SceneFile { scene, document }),
        Err(error) => Err(refused(&document, &error).into()),
    }
}

impl SceneFile {
    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The scene alone.
    pub fn into_scene(self) -> Scene {
        self.scene
    }

    /// That its landmarks are never in view, at the place of the pose box.
    pub fn never_in_view(&self, error: &NeverInView) -> FileError {
        let told = error.to_string();
        let message = told.strip_prefix("poses: ").unwrap_or(&told);
        let at = self.document.nearest_to("poses");
        at.fault("never-in-view", message)
            .help("look at the mount and at the sizes of box, image and constellation")
            .into()
    }
}

/// The error at its place.
fn refused(document: &Document, error: &SceneError) -> Fault {
    let path = error.field.to_string();
    let at = document.nearest_to(&path);
    let mut fault = at.fault(error.field.code(), error.reason.as_str());
    fault.path = path;
    fault.help(error.field.help())
}

fn draft(
    root: At<'_>,
    calibration: impl FnOnce(&str) -> Result<Vec<u8>, String>,
) -> Result<SceneDraft, FileError> {
    let root = root.table("key = value")?;
    root.only(ROOT_KEYS)?;
    let name = root.required("name", "name = \"landing\"")?.text()?;
    let example = "landmarks = [[0.0, 2.0, -4.0], ...], in metres";
    let landmarks = root
        .required("landmarks", example)?
        .array("[[x, y, z], ...]")?;
    let landmarks_m = landmarks
        .map(|landmark| Ok(landmark.numbers::<3>("[x, y, z] in metres")?.into()))
        .collect::<Result<Vec<Vector3<f64>>, Fault>>()?;
    let camera = root
        .required("camera", "the table [camera]")?
        .table("[camera] and its keys below")?;
    let camera = camera_of(camera, calibration)?;
    let poses = root
        .required("poses", "the table [poses]")?
        .table("[poses] and its keys below")?;
    let (poses, margin_px) = poses_of(poses)?;
    Ok(SceneDraft {
        name: name.to_owned(),
        landmarks_m,
        camera,
        poses,
        margin_px,
    })
}

fn camera_of(
    table: Table<'_>,
    resolve: impl FnOnce(&str) -> Result<Vec<u8>, String>,
) -> Result<Camera, FileError> {
    table.only(CAMERA_KEYS)?;
    let number = |key: &str, example: &str| table.required(key, example)?.number();
    let mount = Mount {
        mount_rad: number("mount_deg", "mount_deg = 0.0, negative if it looks down")?.to_radians(),
        offset_m: number(
            "offset_m",
            "offset_m = 0.0, how far ahead of the body's origin",
        )?,
    };
    if let Some(at) = table.optional("calibration") {
        let name = at.text()?;
        let text = resolve(name).map_err(|reason| {
            let message = format!("a camera file expected, none found: {reason}");
            at.fault("calibration", message)
                .help("name a file that stands beside the scene file")
        })?;
        let calibration = camera_file::read(&text).map_err(|e| e.in_file(name))?;
        return Ok(calibrated(table, &calibration, mount)?);
    }
    let length = |key: &str, example: &str| table.required(key, example)?.positive();
    let (focal_u_px, focal_v_px) = focal(table.required("focal_px", "focal_px = 1000.0")?)?;
    let distortion = table.optional("distortion").map(distortion).transpose()?;
    Ok(Camera {
        width_px: length("width_px", "width_px = 1280")?,
        height_px: length("height_px", "height_px = 720")?,
        focal_u_px,
        focal_v_px,
        center_u_px: number("center_u_px", "center_u_px = 360.0, half the height")?,
        center_v_px: number("center_v_px", "center_v_px = 640.0, half the width")?,
        mount_rad: mount.mount_rad,
        offset_m: mount.offset_m,
        distortion: distortion.unwrap_or_default(),
    })
}

/// The camera of a calibration, on the body of the scene file.
fn calibrated(table: Table<'_>, calibration: &Calibration, mount: Mount) -> Result<Camera, Fault> {
    let refuse = |keys: &[&str]| match table.first_of(keys) {
        Some(at) => Err(at
            .fault(
                "calibrated",
                "nothing beside calibration expected, a value found",
            )
            .help("the camera file says it; remove one of the two")),
        None => Ok(()),
    };
    refuse(CALIBRATED_KEYS)?;
    let size_px = match calibration.size_px {
        Some(size) => {
            refuse(&["width_px", "height_px"])?;
            size
        }
        None => {
            let length = |key: &str, example: &str| {
                let why = ", which the camera file does not tell";
                table.required(key, &format!("{example}{why}"))?.positive()
            };
            (
                length("width_px", "width_px = 1280")?,
                length("height_px", "height_px = 720")?,
            )
        }
    };
    Ok(calibration.camera(size_px, mount))
}

fn focal(at: At<'_>) -> Result<(f64, f64), Fault> {
    let Some(items) = at.as_array() else {
        let focal = at.positive()?;
        return Ok((focal, focal));
    };
    at.numbers::<2>("focal_px = 1000.0 or [focal_u, focal_v]")?;
    let lengths: Vec<f64> = items.map(At::positive).collect::<Result<_, _>>()?;
    Ok((lengths[0], lengths[1]))
}

fn distortion(at: At<'_>) -> Result<Distortion, Fault> {
    let table = at.table("distortion = { k1 = -0.1, k2 = 0.01, p1 = 0, p2 = 0, k3 = 0 }")?;
    table.only(DISTORTION_KEYS)?;
    let number = |key| table.optional(key).map_or(Ok(0.0), At::number);
    Ok(Distortion {
        radial: [number("k1")?, number("k2")?, number("k3")?],
        tangential: [number("p1")?, number("p2")?],
    })
}

fn poses_of(table: Table<'_>) -> Result<(PoseBox, f64), Fault> {
    table.only(POSES_KEYS)?;
    let mut poses = PoseBox {
        lower: Parameters::zeros(),
        upper: Parameters::zeros(),
    };
    for (i, key) in POSES_KEYS[..PARAMETER_NAMES.len()].iter().enumerate() {
        let example = if i == 0 {
            "[10.0, 50.0]"
        } else {
            "[-5.0, 5.0]"
        };
        let range = table.required(key, &format!("{key} = {example}"))?;
        let range = range.numbers::<2>(&format!("{key} = {example}"))?;
        let [lower, upper] = if i == 0 {
            range
        } else {
            range.map(f64::to_radians)
        };
        (poses.lower[i], poses.upper[i]) = (lower, upper);
    }
    let margin_px = table.required("margin_px", "margin_px = 10.0")?.number()?;
    Ok((poses, margin_px))
}
