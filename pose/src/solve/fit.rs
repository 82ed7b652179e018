//! The fit of a pose to pixels, and its derivatives: what iteration and bounds are made of.

use nalgebra::{Matrix3, Rotation3, SMatrix, SVector, Vector2, Vector3};

use crate::frames::Pose;
use crate::scene::{Camera, Scene};

/// Landmarks and where in the image they were seen.
#[derive(Clone, Copy, Debug)]
pub struct Sightings<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// `C_B^C`.
    pub camera_from_body: &'a Matrix3<f64>,
    /// Landmarks in N.
    pub landmarks_m: &'a [Vector3<f64>],
    /// `[u0, v0, ...]`.
    pub pixels: &'a [f64],
}

/// The normal equations of a fit in the six numbers (move of the camera in N, turn in B).
///
/// A step `d` moves the position by its first three numbers and multiplies `C_B^N` from the right
/// by the rotation of its last three; these hold for any pose.
///
/// # Units
/// m, rad, px
#[derive(Clone, Debug)]
pub struct Normal {
    /// `J'J`.
    pub information: SMatrix<f64, 6, 6>,
    /// `J'(seen - expected)`.
    pub pull: SVector<f64, 6>,
    /// `|seen - expected|^2`.
    pub square_px: f64,
}

impl<'a> Sightings<'a> {
    /// All landmarks of a scene.
    pub fn of(scene: &'a Scene, pixels: &'a [f64]) -> Self {
        debug_assert_eq!(pixels.len(), scene.inputs());
        Self {
            camera: scene.camera(),
            camera_from_body: scene.camera_from_body().matrix(),
            landmarks_m: scene.landmarks_m(),
            pixels,
        }
    }

    fn pairs(&self) -> impl Iterator<Item = (&'a Vector3<f64>, Vector2<f64>)> {
        let pixels = self.pixels.chunks_exact(2);
        self.landmarks_m
            .iter()
            .zip(pixels.map(|pixel| Vector2::new(pixel[0], pixel[1])))
    }

    /// Sum of squared distances in the image; `None` if a landmark is not ahead of the camera.
    ///
    /// # Units
    /// px^2
    pub fn square_px(&self, pose: &Pose) -> Option<f64> {
        let turn = self.camera_from_body * pose.deck_from_body.matrix().transpose();
        let shift = turn * pose.position_m;
        self.pairs().try_fold(0.0, |sum, (landmark, seen)| {
            let expected = self.camera.pixel(&(turn * landmark - shift))?;
            Some(sum + (seen - expected).norm_squared())
        })
    }

    /// The normal equations at a pose; `None` if a landmark is not ahead of the camera.
    ///
    /// # Source
    /// `x_C = C_B^C C_N^B (x_P - p)`, so that a move by `dp` moves `x_C` by `-C_B^C C_N^B dp` and
    /// a turn by `w` by `C_B^C [C_N^B (x_P - p)]x w`.
    pub fn normal(&self, pose: &Pose) -> Option<Normal> {
        let body_from_deck = pose.deck_from_body.matrix().transpose();
        let mut normal = Normal {
            information: SMatrix::zeros(),
            pull: SVector::zeros(),
            square_px: 0.0,
        };
        for (landmark, seen) in self.pairs() {
            let arm = body_from_deck * (landmark - pose.position_m);
            let point = self.camera_from_body * arm;
            let miss = seen - self.camera.pixel(&point)?;
            let by_arm = self.camera.pixel_derivative(&point) * self.camera_from_body;
            let mut jacobian = SMatrix::<f64, 2, 6>::zeros();
            jacobian
                .fixed_columns_mut::<3>(0)
                .copy_from(&-(by_arm * body_from_deck));
            jacobian
                .fixed_columns_mut::<3>(3)
                .copy_from(&(by_arm * arm.cross_matrix()));
            normal.information += jacobian.transpose() * jacobian;
            normal.pull += jacobian.transpose() * miss;
            normal.square_px += miss.norm_squared();
        }
        Some(normal)
    }
}

/// The pose after a step in the six numbers of [`Normal`].
pub fn stepped(pose: &Pose, step: &SVector<f64, 6>) -> Pose {
    let turn = Rotation3::new(step.fixed_rows::<3>(3).into_owned());
    let mut deck_from_body = pose.deck_from_body * turn;
    deck_from_body.renormalize();
    Pose {
        position_m: pose.position_m + step.fixed_rows::<3>(0),
        deck_from_body,
    }
}
