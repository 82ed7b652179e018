//! The scene: landmarks on the ship, the camera, and the box that poses come from.

use nalgebra::{Rotation3, SVector, Vector3};

use crate::error::{Field, SceneError};
use crate::frames::{Attitude, Pose, camera_from_body};

/// The six numbers that poses are drawn by: distance, elevation, azimuth, roll, pitch, yaw.
///
/// The position is `(-D, D tan(elevation), D tan(azimuth))`.
/// The prior is uniform in these numbers, which is why the estimators search in them.
///
/// # Units
/// m, then rad
pub type Parameters = SVector<f64, 6>;

/// Names of the parameters as a scene file spells them, without the unit.
pub const PARAMETER_NAMES: [&str; 6] = ["distance", "elevation", "azimuth", "roll", "pitch", "yaw"];

/// Lens distortion of Brown and Conrady, as OpenCV's `plumb_bob`: radial k1, k2, k3, tangential
/// p1, p2.
///
/// Coordinates are those of OpenCV: x right, y down, both divided by the depth.
///
/// # Source
/// D. C. Brown, 1966; OpenCV's camera calibration, equation of `projectPoints`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Distortion {
    /// Radial coefficients k1, k2, k3.
    pub radial: [f64; 3],
    /// Tangential coefficients p1, p2.
    pub tangential: [f64; 2],
}

/// A pinhole camera on the body.
///
/// The image axis u points up, v points right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Extent along v.
    pub width_px: f64,
    /// Extent along u.
    pub height_px: f64,
    /// Focal length along u.
    pub focal_u_px: f64,
    /// Focal length along v.
    pub focal_v_px: f64,
    /// Principal point.
    pub center_u_px: f64,
    /// Principal point.
    pub center_v_px: f64,
    /// Mount angle about the body's Z; negative looks down.
    pub mount_rad: f64,
    /// How far the camera stands ahead of the body's origin.
    pub offset_m: f64,
    /// Lens distortion, all zero for a pinhole.
    pub distortion: Distortion,
}

/// The box that the parameters of poses come from, uniform and independent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseBox {
    /// Lower edge.
    pub lower: Parameters,
    /// Upper edge.
    pub upper: Parameters,
}

impl PoseBox {
    /// Whether the parameters lie within the box.
    pub fn contains(&self, q: &Parameters) -> bool {
        (0..6).all(|i| self.lower[i] <= q[i] && q[i] <= self.upper[i])
    }

    /// The middle of the box.
    pub fn middle(&self) -> Parameters {
        (self.lower + self.upper) / 2.0
    }

    /// Edge lengths.
    pub fn widths(&self) -> Parameters {
        self.upper - self.lower
    }
}

/// The pose that the parameters stand for.
pub fn pose_of(q: &Parameters) -> Pose {
    let attitude = Attitude {
        roll_rad: q[3],
        pitch_rad: q[4],
        yaw_rad: q[5],
    };
    Pose {
        position_m: Vector3::new(-q[0], q[0] * q[1].tan(), q[0] * q[2].tan()),
        deck_from_body: attitude.body_from_deck().inverse(),
    }
}

/// The parameters of a pose ahead of the deck (negative x); the inverse of [`pose_of`].
pub fn parameters_of(pose: &Pose) -> Parameters {
    let attitude = Attitude::of(&pose.deck_from_body.inverse());
    let p = pose.position_m;
    Parameters::from([
        -p.x,
        p.y.atan2(-p.x),
        p.z.atan2(-p.x),
        attitude.roll_rad,
        attitude.pitch_rad,
        attitude.yaw_rad,
    ])
}

/// What a scene is made of, not yet checked.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneDraft {
    /// A Verilog identifier; the trained design gets this name.
    pub name: String,
    /// Landmarks in N, in the order of the network's inputs.
    ///
    /// # Units
    /// m
    pub landmarks_m: Vec<Vector3<f64>>,
    /// The camera.
    pub camera: Camera,
    /// Where poses come from.
    pub poses: PoseBox,
    /// A pose counts when every landmark is at least this far inside the image.
    pub margin_px: f64,
}

/// A scene that can be observed: checked, with the mount's rotation at hand.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    draft: SceneDraft,
    camera_from_body: Rotation3<f64>,
}

/// Fewest landmarks that fix a pose: three leave up to four poses.
pub const MIN_LANDMARKS: usize = 4;

/// Most landmarks that are taken.
pub const MAX_LANDMARKS: usize = 256;

/// Landmarks closer than this fraction of the constellation's extent are one.
const COINCIDENT: f64 = 1e-6;

impl Scene {
    /// Checks a draft.
    ///
    /// # Errors
    /// A number that is not finite, fewer than four landmarks, coincident or collinear ones, an
    /// impossible camera, an empty or impossible pose box; each names its field.
    pub fn new(draft: SceneDraft) -> Result<Self, SceneError> {
        hwgen_spec::weights::check_name(&draft.name)
            .map_err(|reason| SceneError::new(Field::Name, reason))?;
        check_camera(&draft.camera)?;
        check_landmarks(&draft.landmarks_m)?;
        check_poses(&draft.poses)?;
        check_margin(&draft)?;
        let camera_from_body = camera_from_body(draft.camera.mount_rad);
        Ok(Self {
            draft,
            camera_from_body,
        })
    }

    /// The scene's name.
    pub fn name(&self) -> &str {
        &self.draft.name
    }

    /// Landmarks in N, in the order of the network's inputs.
    pub fn landmarks_m(&self) -> &[Vector3<f64>] {
        &self.draft.landmarks_m
    }

    /// The camera.
    pub fn camera(&self) -> &Camera {
        &self.draft.camera
    }

    /// Where poses come from.
    pub fn poses(&self) -> &PoseBox {
        &self.draft.poses
    }

    /// How far inside the image every landmark must be.
    pub fn margin_px(&self) -> f64 {
        self.draft.margin_px
    }

    /// `C_B^C`.
    pub fn camera_from_body(&self) -> &Rotation3<f64> {
        &self.camera_from_body
    }

    /// The draft that the scene was checked from.
    pub fn draft(&self) -> &SceneDraft {
        &self.draft
    }

    /// Names of the pixel coordinates in input order: `u0`, `v0`, `u1`, ...
    pub fn input_names(&self) -> Vec<String> {
        (0..self.landmarks_m().len())
            .flat_map(|i| [format!("u{i}"), format!("v{i}")])
            .collect()
    }
}

fn finite(field: Field, value: f64) -> Result<(), SceneError> {
    if value.is_finite() {
        Ok(())
    } else {
        Err(SceneError::new(
            field,
            format!("a finite number expected, {value} found"),
        ))
    }
}

fn positive(field: Field, value: f64) -> Result<(), SceneError> {
    finite(field, value)?;
    if value > 0.0 {
        Ok(())
    } else {
        Err(SceneError::new(
            field,
            format!("a number above zero expected, {value} found"),
        ))
    }
}

fn check_camera(camera: &Camera) -> Result<(), SceneError> {
    positive(Field::Camera("width_px"), camera.width_px)?;
    positive(Field::Camera("height_px"), camera.height_px)?;
    positive(Field::Camera("focal_px"), camera.focal_u_px)?;
    positive(Field::Camera("focal_px"), camera.focal_v_px)?;
    finite(Field::Camera("center_u_px"), camera.center_u_px)?;
    finite(Field::Camera("center_v_px"), camera.center_v_px)?;
    finite(Field::Camera("mount_deg"), camera.mount_rad)?;
    finite(Field::Camera("offset_m"), camera.offset_m)?;
    let Distortion { radial, tangential } = camera.distortion;
    for k in radial.into_iter().chain(tangential) {
        finite(Field::Camera("distortion"), k)?;
    }
    Ok(())
}

fn check_landmarks(landmarks: &[Vector3<f64>]) -> Result<(), SceneError> {
    let count = landmarks.len();
    if !(MIN_LANDMARKS..=MAX_LANDMARKS).contains(&count) {
        return Err(SceneError::new(
            Field::Landmarks,
            format!("{MIN_LANDMARKS} to {MAX_LANDMARKS} landmarks expected, {count} found"),
        ));
    }
    for (i, landmark) in landmarks.iter().enumerate() {
        for value in landmark {
            finite(Field::Landmark(i), *value)?;
        }
    }
    let extent = landmarks
        .iter()
        .map(|l| (l - landmarks[0]).norm())
        .fold(0.0, f64::max);
    for (i, a) in landmarks.iter().enumerate() {
        for (j, b) in landmarks[..i].iter().enumerate() {
            if (a - b).norm() <= COINCIDENT * extent {
                return Err(SceneError::new(
                    Field::Landmark(i),
                    format!("a place of its own expected, that of landmark {j} found"),
                ));
            }
        }
    }
    let first = (landmarks[1] - landmarks[0]).normalize();
    let spread = landmarks
        .iter()
        .map(|l| (l - landmarks[0]).cross(&first).norm())
        .fold(0.0, f64::max);
    if spread <= COINCIDENT * extent {
        return Err(SceneError::new(
            Field::Landmarks,
            "landmarks off one line expected, all of them found on it".to_string(),
        ));
    }
    Ok(())
}

fn check_poses(poses: &PoseBox) -> Result<(), SceneError> {
    let right_angle = std::f64::consts::FRAC_PI_2;
    for (i, name) in PARAMETER_NAMES.into_iter().enumerate() {
        let (lower, upper) = (poses.lower[i], poses.upper[i]);
        finite(Field::Poses(i), lower)?;
        finite(Field::Poses(i), upper)?;
        if lower > upper {
            return Err(SceneError::new(
                Field::Poses(i),
                "the lower end first expected, the upper end found first".to_string(),
            ));
        }
        let (least, most) = match i {
            0 => (0.0, f64::INFINITY),
            3 => (-2.0 * right_angle, 2.0 * right_angle),
            5 => (-2.0 * right_angle, 2.0 * right_angle),
            _ => (-right_angle, right_angle),
        };
        if lower <= least || upper >= most {
            let bounds = if i == 0 {
                "a distance above zero".to_string()
            } else {
                format!(
                    "an angle between {:.0} and {:.0} degrees",
                    least.to_degrees(),
                    most.to_degrees()
                )
            };
            return Err(SceneError::new(
                Field::Poses(i),
                format!("{bounds} expected for the {name}, one outside found"),
            ));
        }
    }
    Ok(())
}

fn check_margin(draft: &SceneDraft) -> Result<(), SceneError> {
    finite(Field::Margin, draft.margin_px)?;
    let half = draft.camera.width_px.min(draft.camera.height_px) / 2.0;
    if draft.margin_px < 0.0 || draft.margin_px >= half {
        return Err(SceneError::new(
            Field::Margin,
            format!(
                "a margin from 0 to less than half the image ({half} px) expected, {} found",
                draft.margin_px
            ),
        ));
    }
    Ok(())
}
