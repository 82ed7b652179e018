//! The Cramér-Rao bound: what no unbiased estimate can pass.

use nalgebra::{Matrix3, SMatrix, Vector3};

use super::fit::Sightings;
use crate::frames::Pose;
use crate::scene::Scene;

/// The least covariances of an unbiased estimate at a pose, and the errors they mean.
///
/// # Units
/// m and rad, squared in the covariances
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    /// Of the position.
    pub position_m2: Matrix3<f64>,
    /// Of the Rodrigues vector.
    pub rodrigues_rad2: Matrix3<f64>,
    /// Of the small turn between estimated and true attitude.
    pub turn_rad2: Matrix3<f64>,
}

impl Bound {
    /// The bound at a pose for Gaussian noise of a standard deviation on each pixel coordinate.
    ///
    /// `None` if a landmark is not ahead of the camera, or the pixels do not fix the pose.
    ///
    /// # Source
    /// H. Cramér, 1946; C. R. Rao, 1945: the inverse of Fisher's information, `J'J / sigma^2`.
    pub fn at(scene: &Scene, pose: &Pose, sigma_px: f64) -> Option<Self> {
        let pixels = scene.project(pose)?;
        let information = Sightings::of(scene, &pixels).normal(pose)?.information;
        // Metres and radians differ in size: the diagonal is scaled to one before inverting.
        let scale = SMatrix::<f64, 6, 6>::from_diagonal(
            &information.diagonal().map(|square| square.sqrt().recip()),
        );
        let factor = (scale * information * scale).cholesky()?;
        let covariance = scale * factor.inverse() * scale * (sigma_px * sigma_px);
        let turn_rad2 = covariance.fixed_view::<3, 3>(3, 3).into_owned();
        let slope = rodrigues_by_turn(&pose.rodrigues_rad());
        Some(Self {
            position_m2: covariance.fixed_view::<3, 3>(0, 0).into_owned(),
            rodrigues_rad2: slope * turn_rad2 * slope.transpose(),
            turn_rad2,
        })
    }

    /// Expected distance of the position from the truth.
    ///
    /// # Units
    /// m
    pub fn position_error_m(&self) -> f64 {
        expected_length(&self.position_m2)
    }

    /// Expected distance of the Rodrigues vector from the truth.
    ///
    /// # Units
    /// rad
    pub fn rodrigues_error_rad(&self) -> f64 {
        expected_length(&self.rodrigues_rad2)
    }

    /// Expected angle between estimated and true attitude.
    ///
    /// # Units
    /// rad
    pub fn turn_error_rad(&self) -> f64 {
        expected_length(&self.turn_rad2)
    }
}

/// Derivative of the Rodrigues vector by a small turn in B: `exp([r]x) exp([w]x)` has the vector
/// `r + M w`.
///
/// # Source
/// The inverse right Jacobian of SO(3): G. S. Chirikjian, 2012, volume 2, page 40.
fn rodrigues_by_turn(r: &Vector3<f64>) -> Matrix3<f64> {
    const SMALL: f64 = 1e-3;
    let cross = r.cross_matrix();
    let angle = r.norm();
    let factor = if angle < SMALL {
        1.0 / 12.0 + angle * angle / 720.0
    } else {
        let half = angle / 2.0;
        (1.0 - half / half.tan()) / (angle * angle)
    };
    Matrix3::identity() + cross / 2.0 + cross * cross * factor
}

/// The expected length of a Gaussian vector of mean zero.
///
/// Its direction and the length of its whitened image are independent: the second has mean
/// `2 sqrt(2/pi)`, and the mean of the stretch over the sphere is Carlson's integral `R_G` of the
/// three variances.
///
/// # Source
/// B. C. Carlson, "Numerical computation of real or complex elliptic integrals", 1995; NIST DLMF
/// 19.16.3 (the sphere) and 19.21.10 (`R_G` by `R_F` and `R_D`).
fn expected_length(covariance: &Matrix3<f64>) -> f64 {
    let mut variances = covariance.symmetric_eigenvalues().map(|v| v.max(0.0));
    variances.as_mut_slice().sort_by(f64::total_cmp);
    let [x, z, y] = variances.into();
    if z <= 0.0 {
        // At most one direction: the mean of a half normal.
        return (2.0 * y / std::f64::consts::PI).sqrt();
    }
    let product = (x - z) * (y - z);
    let stretch =
        (z * carlson_f(x, y, z) - product * carlson_d(x, y, z) / 3.0 + (x * y / z).sqrt()) / 2.0;
    2.0 * (2.0 / std::f64::consts::PI).sqrt() * stretch
}

/// Doublings after which the arguments agree to rounding: their spread falls by four each time.
const DOUBLINGS: usize = 30;

/// Carlson's `R_F` by duplication, NIST DLMF 19.26.18.
fn carlson_f(mut x: f64, mut y: f64, mut z: f64) -> f64 {
    for _ in 0..DOUBLINGS {
        let step = (x * y).sqrt() + (x * z).sqrt() + (y * z).sqrt();
        (x, y, z) = ((x + step) / 4.0, (y + step) / 4.0, (z + step) / 4.0);
    }
    x.sqrt().recip()
}

/// Carlson's `R_D` by duplication, NIST DLMF 19.26.20.
fn carlson_d(mut x: f64, mut y: f64, mut z: f64) -> f64 {
    let mut sum = 0.0;
    let mut quarter = 1.0;
    for _ in 0..DOUBLINGS {
        let step = (x * y).sqrt() + (x * z).sqrt() + (y * z).sqrt();
        sum += 3.0 * quarter / (z.sqrt() * (z + step));
        quarter /= 4.0;
        (x, y, z) = ((x + step) / 4.0, (y + step) / 4.0, (z + step) / 4.0);
    }
    sum + quarter / (x * x.sqrt())
}
