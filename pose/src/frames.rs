//! Frames and rotations: the deck N, the body B and the camera C.
//!
//! All three are X forward, Y up, Z right.
//! N is fixed to the ship, with its origin at the landing site.
//! C is B turned by the mount angle about Z and moved by the camera's offset along the body's X.

use nalgebra::{Matrix3, Rotation3, Vector3};

/// Roll, pitch and yaw of the body against the deck.
///
/// # Units
/// rad
///
/// # Source
/// Equation 1 of the method: yaw about Y, then pitch about Z, then roll about X.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attitude {
    /// About X, forward.
    pub roll_rad: f64,
    /// About Z, right.
    pub pitch_rad: f64,
    /// About Y, up.
    pub yaw_rad: f64,
}

impl Attitude {
    /// `C_N^B`, which turns coordinates in N into coordinates in B.
    pub fn body_from_deck(self) -> Rotation3<f64> {
        let (sg, cg) = self.roll_rad.sin_cos();
        let (st, ct) = self.pitch_rad.sin_cos();
        let (ss, cs) = self.yaw_rad.sin_cos();
        #[rustfmt::skip]
        let matrix = Matrix3::new(
            cs * ct,                st,       -ss * ct,
            ss * sg - cs * st * cg, ct * cg,  cs * sg + ss * st * cg,
            ss * cg + cs * st * sg, -ct * sg, cs * cg - ss * st * sg,
        );
        Rotation3::from_matrix_unchecked(matrix)
    }

    /// The angles of `C_N^B`, pitch within a quarter turn.
    ///
    /// At a pitch of a quarter turn roll and yaw are not told apart, and the roll is put at zero.
    pub fn of(body_from_deck: &Rotation3<f64>) -> Self {
        let c = body_from_deck.matrix();
        let pitch_rad = c[(0, 1)].clamp(-1.0, 1.0).asin();
        if c[(0, 1)].abs() > 1.0 - 1e-12 {
            // C = C(pitch) C(yaw) up to a roll that cannot be told apart.
            return Self {
                roll_rad: 0.0,
                pitch_rad,
                yaw_rad: c[(2, 0)].atan2(c[(2, 2)]),
            };
        }
        Self {
            roll_rad: (-c[(2, 1)]).atan2(c[(1, 1)]),
            pitch_rad,
            yaw_rad: (-c[(0, 2)]).atan2(c[(0, 0)]),
        }
    }
}

/// `C_B^C`, the camera's mount: a turn by the angle about Z, negative looks down.
pub fn camera_from_body(mount_rad: f64) -> Rotation3<f64> {
    let (sa, ca) = mount_rad.sin_cos();
    #[rustfmt::skip]
    let matrix = Matrix3::new(
        ca,  sa,  0.0,
        -sa, ca,  0.0,
        0.0, 0.0, 1.0,
    );
    Rotation3::from_matrix_unchecked(matrix)
}

/// Where the camera is and how the body is turned: what the networks estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// The camera's position in N.
    ///
    /// # Units
    /// m
    pub position_m: Vector3<f64>,
    /// `C_B^N`, which turns coordinates in B into coordinates in N.
    pub deck_from_body: Rotation3<f64>,
}

impl Pose {
    /// The pose from its six numbers: position and Rodrigues vector, `exp([r]x) = C_B^N`.
    ///
    /// # Units
    /// m and rad
    pub fn new(position_m: Vector3<f64>, rodrigues_rad: Vector3<f64>) -> Self {
        Self {
            position_m,
            deck_from_body: Rotation3::new(rodrigues_rad),
        }
    }

    /// The Rodrigues vector of the body's attitude, of length at most pi.
    ///
    /// # Units
    /// rad
    pub fn rodrigues_rad(&self) -> Vector3<f64> {
        rodrigues(&self.deck_from_body)
    }

    /// The body's position in N: the camera stands `offset_m` ahead of it.
    pub fn body_position_m(&self, offset_m: f64) -> Vector3<f64> {
        self.position_m - self.deck_from_body * Vector3::new(offset_m, 0.0, 0.0)
    }
}

/// The rotation vector of a rotation, exact to rounding from zero to half a turn.
///
/// # Source
/// O. Rodrigues, 1840; through the quaternion of the largest component, as S. W. Shepperd, 1978.
pub fn rodrigues(rotation: &Rotation3<f64>) -> Vector3<f64> {
    let m = rotation.matrix();
    let trace = m.trace();
    // Four times the squares of w, x, y, z; the largest is at least one.
    let squares = [
        1.0 + trace,
        1.0 + 2.0 * m[(0, 0)] - trace,
        1.0 + 2.0 * m[(1, 1)] - trace,
        1.0 + 2.0 * m[(2, 2)] - trace,
    ];
    let largest = (0..4).fold(
        0,
        |best, i| if squares[i] > squares[best] { i } else { best },
    );
    let skew = Vector3::new(
        m[(2, 1)] - m[(1, 2)],
        m[(0, 2)] - m[(2, 0)],
        m[(1, 0)] - m[(0, 1)],
    );
    // w and the vector part, both times twice the root of the largest square.
    let (mut w, mut v) = if largest == 0 {
        (squares[0], skew)
    } else {
        let axis = largest - 1;
        let v = Vector3::from_fn(|i, _| {
            if i == axis {
                squares[largest]
            } else {
                m[(i, axis)] + m[(axis, i)]
            }
        });
        (skew[axis], v)
    };
    if w < 0.0 {
        (w, v) = (-w, -v);
    }
    let length = v.norm();
    if length == 0.0 {
        return Vector3::zeros();
    }
    v * (2.0 * length.atan2(w) / length)
}
