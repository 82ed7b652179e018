//! Rays and rigid motions in camera coordinates, which the closed forms have in common.

use nalgebra::{Matrix3, Rotation3, Vector2, Vector3};

use crate::frames::Pose;
use crate::scene::Scene;

/// A rigid motion from N to C: `x_C = turn x_N + shift`.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    /// `C_N^C`.
    pub turn: Matrix3<f64>,
    /// Where the origin of N is in C.
    ///
    /// # Units
    /// m
    pub shift_m: Vector3<f64>,
}

impl Placement {
    /// The motion that a pose makes.
    pub fn of(pose: &Pose, scene: &Scene) -> Self {
        let turn = scene.camera_from_body().matrix() * pose.deck_from_body.matrix().transpose();
        Self {
            turn,
            shift_m: -(turn * pose.position_m),
        }
    }

    /// A point of N in C.
    pub fn point(&self, landmark_m: &Vector3<f64>) -> Vector3<f64> {
        self.turn * landmark_m + self.shift_m
    }

    /// The pose that makes this motion.
    pub fn pose(&self, scene: &Scene) -> Pose {
        let deck_from_camera = self.turn.transpose();
        Pose {
            position_m: -(deck_from_camera * self.shift_m),
            deck_from_body: Rotation3::from_matrix_unchecked(
                deck_from_camera * scene.camera_from_body().matrix(),
            ),
        }
    }

    /// Sum of squared distances between seen and expected rays; `None` if a landmark is not ahead.
    pub fn square_error(&self, landmarks_m: &[Vector3<f64>], rays: &[Vector2<f64>]) -> Option<f64> {
        landmarks_m.iter().zip(rays).try_fold(0.0, |sum, (l, ray)| {
            let point = self.point(l);
            let expected = Vector2::new(point.y, point.z) / point.x;
            (point.x > 0.0).then(|| sum + (expected - ray).norm_squared())
        })
    }

    /// The motion that takes `from` nearest to `to` in the sense of least squares.
    ///
    /// # Source
    /// S. Umeyama, 1991, without scale.
    pub fn between(from: &[Vector3<f64>], to: &[Vector3<f64>]) -> Option<Self> {
        let (from_middle, to_middle) = (middle(from), middle(to));
        let mut moment = Matrix3::zeros();
        for (a, b) in from.iter().zip(to) {
            moment += (b - to_middle) * (a - from_middle).transpose();
        }
        let turn = nearest_rotation(&moment)?;
        Some(Self {
            turn,
            shift_m: to_middle - turn * from_middle,
        })
    }
}

/// The straight rays `(y/x, z/x)` that were seen; `None` where a pixel sees none.
pub fn rays(scene: &Scene, pixels: &[f64]) -> Option<Vec<Vector2<f64>>> {
    debug_assert_eq!(pixels.len(), scene.inputs());
    pixels
        .chunks_exact(2)
        .map(|pixel| scene.camera().ray(Vector2::new(pixel[0], pixel[1])))
        .collect()
}

/// The centroid of some points.
pub fn middle(points: &[Vector3<f64>]) -> Vector3<f64> {
    points.iter().sum::<Vector3<f64>>() / points.len() as f64
}

/// Principal axes of some points about their centroid, the widest first, and the standard
/// deviations along them.
pub fn principal_axes(points: &[Vector3<f64>]) -> (Matrix3<f64>, Vector3<f64>) {
    let center = middle(points);
    let mut moment = Matrix3::zeros();
    for point in points {
        moment += (point - center) * (point - center).transpose();
    }
    let eigen = (moment / points.len() as f64).symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let axes = Matrix3::from_columns(&order.map(|i| eigen.eigenvectors.column(i).into_owned()));
    let deviations = Vector3::from(order.map(|i| eigen.eigenvalues[i].max(0.0).sqrt()));
    (axes, deviations)
}

/// The rotation nearest to a matrix in the Frobenius norm.
///
/// # Source
/// P. H. Schönemann, 1966; the sign as S. Umeyama, 1991.
pub fn nearest_rotation(matrix: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    if !matrix.iter().all(|x| x.is_finite()) {
        return None;
    }
    let svd = matrix.svd(true, true);
    let (u, v_t) = (svd.u?, svd.v_t?);
    let sign = (u.determinant() * v_t.determinant()).signum();
    Some(u * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, sign)) * v_t)
}
