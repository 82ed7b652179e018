//! Poses in the conventions of others: OpenCV, ROS (REP 103), aerospace (front, right, down).
//!
//! Everything here is a change of axes of the one [`Pose`]: nothing is estimated, nothing is lost,
//! and each conversion has its inverse.
//! [`Axes`] says in which axes the deck's frame is wanted: its origin stays the landing site.
//!
//! ```
//! use hwgen_pose::convert::{Axes, BodyPose, CameraPose, RollPitchYaw};
//! use hwgen_pose::frames::{Pose, camera_from_body};
//! use nalgebra::Vector3;
//!
//! // The camera stands 20 m behind the landing site, 3 m above it and 1 m to its right; the body
//! // is yawed by 0.1 rad about the upward axis, which is to the left.
//! let pose = Pose::new(Vector3::new(-20.0, 3.0, 1.0), Vector3::new(0.0, 0.1, 0.0));
//!
//! // ROS: x forward, y left, z up.
//! let body = BodyPose::of(&pose, 0.0, Axes::Rep103);
//! assert_eq!(body.position_m, Vector3::new(-20.0, -1.0, 3.0));
//! assert!((body.wxyz()[3] - 0.05f64.sin()).abs() < 1e-15);
//! assert!((RollPitchYaw::of(&pose, Axes::Rep103).yaw_rad - 0.1).abs() < 1e-15);
//!
//! // Aerospace: x forward, y right, z down, so that a turn to the left is negative.
//! let body = BodyPose::of(&pose, 0.0, Axes::Frd);
//! assert_eq!(body.position_m, Vector3::new(-20.0, 1.0, -3.0));
//! assert!((RollPitchYaw::of(&pose, Axes::Frd).yaw_rad + 0.1).abs() < 1e-15);
//!
//! // OpenCV: where the landing site is, seen from the camera: x right, y down, z ahead.
//! let level = Pose::new(pose.position_m, Vector3::zeros());
//! let mount = camera_from_body(0.0);
//! let camera = CameraPose::of(&level, &mount, Axes::Deck);
//! assert!((camera.tvec_m - Vector3::new(-1.0, 3.0, 20.0)).norm() < 1e-12);
//! let back = camera.pose(&mount, Axes::Deck);
//! assert!((back.position_m - level.position_m).norm() < 1e-12);
//! ```

use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};

use crate::frames::{Attitude, Pose, rodrigues};

/// Axes of the deck's frame, and of the body's with it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Axes {
    /// This crate's N and B: x forward, y up, z right.
    #[default]
    Deck,
    /// ROS: x forward, y left, z up.
    ///
    /// # Source
    /// REP 103, Standard Units of Measure and Coordinate Conventions, 2010.
    Rep103,
    /// Aerospace: x forward, y right, z down; north, east, down for a deck that points north.
    Frd,
}

impl Axes {
    /// The rotation that turns coordinates in [`Axes::Deck`] into coordinates in these axes.
    pub fn from_deck(self) -> Rotation3<f64> {
        #[rustfmt::skip]
        let matrix = match self {
            Self::Deck => Matrix3::identity(),
            Self::Rep103 => Matrix3::new(
                1.0, 0.0,  0.0,
                0.0, 0.0, -1.0,
                0.0, 1.0,  0.0,
            ),
            Self::Frd => Matrix3::new(
                1.0,  0.0, 0.0,
                0.0,  0.0, 1.0,
                0.0, -1.0, 0.0,
            ),
        };
        Rotation3::from_matrix_unchecked(matrix)
    }
}

/// OpenCV's camera axes, x right, y down, z ahead, from this crate's C.
fn optical_from_camera() -> Rotation3<f64> {
    #[rustfmt::skip]
    let matrix = Matrix3::new(
        0.0,  0.0, 1.0,
        0.0, -1.0, 0.0,
        1.0,  0.0, 0.0,
    );
    Rotation3::from_matrix_unchecked(matrix)
}

/// A pose as `solvePnP` returns and `projectPoints` takes it: the camera's optical frame from the
/// deck's, `x_optical = exp([rvec]x) x_deck + tvec`.
///
/// It says where the deck is, seen from the camera; the camera is at `-R^T tvec`.
/// With [`Axes::Rep103`] it is the transform of tf2 from the deck to an `_optical_frame`.
///
/// # Units
/// rad and m
///
/// # Source
/// OpenCV 4, Perspective-n-Point (PnP) pose computation.
///
/// ```
/// use hwgen_pose::convert::{Axes, CameraPose};
/// use hwgen_pose::frames::{Pose, camera_from_body};
/// use nalgebra::Vector3;
///
/// // 10 m behind the landing site, level: the deck's up is against OpenCV's y, its forward is z.
/// let pose = Pose::new(Vector3::new(-10.0, 0.0, 0.0), Vector3::zeros());
/// let camera = CameraPose::of(&pose, &camera_from_body(0.0), Axes::Deck);
/// assert!((camera.tvec_m - Vector3::new(0.0, 0.0, 10.0)).norm() < 1e-12);
/// // Half a turn about the line between x and z.
/// let half = std::f64::consts::PI / 2f64.sqrt();
/// assert!((camera.rvec_rad - Vector3::new(half, 0.0, half)).norm() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraPose {
    /// Rotation vector, of length at most pi.
    pub rvec_rad: Vector3<f64>,
    /// The deck's origin in the optical frame.
    pub tvec_m: Vector3<f64>,
}

impl CameraPose {
    /// The pose of a camera that is mounted by `camera_from_body` (`Scene::camera_from_body`).
    pub fn of(pose: &Pose, camera_from_body: &Rotation3<f64>, axes: Axes) -> Self {
        let optical_from_deck =
            optical_from_camera() * camera_from_body * pose.deck_from_body.inverse();
        Self {
            rvec_rad: rodrigues(&(optical_from_deck * axes.from_deck().inverse())),
            tvec_m: -(optical_from_deck * pose.position_m),
        }
    }

    /// The pose that this is; the inverse of [`of`](Self::of).
    pub fn pose(&self, camera_from_body: &Rotation3<f64>, axes: Axes) -> Pose {
        let optical_from_deck = Rotation3::new(self.rvec_rad) * axes.from_deck();
        Pose {
            position_m: -(optical_from_deck.inverse() * self.tvec_m),
            deck_from_body: optical_from_deck.inverse() * optical_from_camera() * camera_from_body,
        }
    }
}

/// Where the body is and how it is turned, both in the deck's frame: what a `PoseStamped` holds.
///
/// # Units
/// m
///
/// ```
/// use hwgen_pose::convert::{Axes, BodyPose};
/// use hwgen_pose::frames::Pose;
/// use nalgebra::Vector3;
///
/// // The camera stands half a metre ahead of the body, which is rolled by 0.2 rad to the right.
/// let pose = Pose::new(Vector3::new(-10.0, 2.0, 0.0), Vector3::new(0.2, 0.0, 0.0));
/// let body = BodyPose::of(&pose, 0.5, Axes::Rep103);
/// assert!((body.position_m - Vector3::new(-10.5, 0.0, 2.0)).norm() < 1e-12);
/// let [w, x, y, z] = body.wxyz();
/// assert!((w - 0.1f64.cos()).abs() < 1e-15 && (x - 0.1f64.sin()).abs() < 1e-15);
/// assert_eq!((y, z), (0.0, 0.0));
///
/// let again = BodyPose::from_wxyz(body.position_m, [w, x, y, z]).unwrap();
/// assert!((again.pose(0.5, Axes::Rep103).position_m - pose.position_m).norm() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyPose {
    /// The body's origin in the deck's frame.
    pub position_m: Vector3<f64>,
    /// Turns coordinates in the body into coordinates on the deck.
    pub deck_from_body: UnitQuaternion<f64>,
}

impl BodyPose {
    /// The body's pose, its camera `offset_m` ahead of it (`Camera::offset_m`).
    pub fn of(pose: &Pose, offset_m: f64, axes: Axes) -> Self {
        let from_deck = axes.from_deck();
        let turned = from_deck * pose.deck_from_body * from_deck.inverse();
        Self {
            position_m: from_deck * pose.body_position_m(offset_m),
            deck_from_body: UnitQuaternion::from_scaled_axis(rodrigues(&turned)),
        }
    }

    /// A pose from a quaternion (w, x, y, z) of any length but zero.
    pub fn from_wxyz(position_m: Vector3<f64>, [w, x, y, z]: [f64; 4]) -> Option<Self> {
        let quaternion = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), f64::MIN_POSITIVE)?;
        Some(Self {
            position_m,
            deck_from_body: quaternion,
        })
    }

    /// The quaternion's parts w, x, y, z; of the two that mean the same, that with w >= 0.
    ///
    /// ROS messages and Eigen's storage have w last.
    pub fn wxyz(&self) -> [f64; 4] {
        let q = self.deck_from_body.quaternion();
        let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
        [q.w, q.i, q.j, q.k].map(|part| sign * part)
    }

    /// The camera's pose that this is; the inverse of [`of`](Self::of).
    pub fn pose(&self, offset_m: f64, axes: Axes) -> Pose {
        let from_deck = axes.from_deck();
        let deck_from_body =
            from_deck.inverse() * self.deck_from_body.to_rotation_matrix() * from_deck;
        let ahead = deck_from_body * Vector3::new(offset_m, 0.0, 0.0);
        Pose {
            position_m: from_deck.inverse() * self.position_m + ahead,
            deck_from_body,
        }
    }
}

/// Roll, pitch and yaw: yaw about the vertical axis first, then pitch about the sideways axis that
/// yaw has turned, then roll about the body's forward axis.
///
/// Each is a right-handed turn about the axis as it points in the wanted [`Axes`]: in
/// [`Axes::Rep103`] pitch is about left and lowers the nose and yaw is to the left, in
/// [`Axes::Frd`] pitch raises the nose and yaw is to the right. Roll is to the right in all.
/// In both it is the sequence Z, Y, X: `R = Rz(yaw) Ry(pitch) Rx(roll)`.
///
/// # Units
/// rad, pitch within a quarter turn
///
/// ```
/// use hwgen_pose::convert::{Axes, RollPitchYaw};
/// use hwgen_pose::frames::Pose;
/// use nalgebra::Vector3;
///
/// // Nose up by 0.1 rad: about the axis that points right.
/// let pose = Pose::new(Vector3::zeros(), Vector3::new(0.0, 0.0, 0.1));
/// assert!((RollPitchYaw::of(&pose, Axes::Frd).pitch_rad - 0.1).abs() < 1e-15);
/// assert!((RollPitchYaw::of(&pose, Axes::Rep103).pitch_rad + 0.1).abs() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RollPitchYaw {
    /// About the forward axis.
    pub roll_rad: f64,
    /// About the sideways axis.
    pub pitch_rad: f64,
    /// About the vertical axis.
    pub yaw_rad: f64,
}

impl RollPitchYaw {
    /// The angles of the body.
    ///
    /// At a pitch of a quarter turn roll and yaw are not told apart, and the roll is put at zero.
    pub fn of(pose: &Pose, axes: Axes) -> Self {
        let Attitude {
            roll_rad,
            pitch_rad,
            yaw_rad,
        } = Attitude::of(&pose.deck_from_body.inverse());
        Self {
            roll_rad,
            pitch_rad,
            yaw_rad,
        }
        .signed(axes)
    }

    /// The attitude that this is, `C_B^N`; the inverse of [`of`](Self::of).
    pub fn deck_from_body(self, axes: Axes) -> Rotation3<f64> {
        let Self {
            roll_rad,
            pitch_rad,
            yaw_rad,
        } = self.signed(axes);
        Attitude {
            roll_rad,
            pitch_rad,
            yaw_rad,
        }
        .body_from_deck()
        .inverse()
    }

    /// From or to [`Axes::Deck`], whose vertical axis points up and whose sideways axis right.
    fn signed(self, axes: Axes) -> Self {
        match axes {
            Axes::Deck => self,
            Axes::Rep103 => Self {
                pitch_rad: -self.pitch_rad,
                ..self
            },
            Axes::Frd => Self {
                yaw_rad: -self.yaw_rad,
                ..self
            },
        }
    }
}
