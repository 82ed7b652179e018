//! What the camera sees: projection, view test, and the derivatives of both stages.

use nalgebra::{DVector, Matrix3, OMatrix, SMatrix, Vector2, Vector3};

use crate::frames::{Attitude, Pose};
use crate::scene::{Camera, Distortion, Parameters, Scene};

/// Pixel coordinates `[u0, v0, u1, v1, ...]` against the six parameters.
///
/// # Shape
/// `[2n][6]`
pub type Jacobian = OMatrix<f64, nalgebra::Dyn, nalgebra::U6>;

impl Camera {
    /// The pixel `(u, v)` of a point in camera coordinates, if it is ahead of the camera.
    ///
    /// # Units
    /// m to px
    ///
    /// # Source
    /// Equations 4 and 5 of the method: `u = f y/x + u_C`, `v = f z/x + v_C`.
    pub fn pixel(&self, point_m: &Vector3<f64>) -> Option<Vector2<f64>> {
        if point_m.x <= 0.0 {
            return None;
        }
        let ray = Vector2::new(point_m.y / point_m.x, point_m.z / point_m.x);
        let [up, right] = self.distortion.bend(ray).into();
        Some(Vector2::new(
            self.focal_u_px * up + self.center_u_px,
            self.focal_v_px * right + self.center_v_px,
        ))
    }

    /// The direction `(y/x, z/x)` that a pixel sees, its distortion undone.
    ///
    /// `None` where no direction is seen there, as beyond the fold of a strong distortion.
    pub fn ray(&self, pixel: Vector2<f64>) -> Option<Vector2<f64>> {
        self.distortion.straighten(Vector2::new(
            (pixel.x - self.center_u_px) / self.focal_u_px,
            (pixel.y - self.center_v_px) / self.focal_v_px,
        ))
    }

    /// Whether a pixel is at least a margin inside the image.
    pub fn sees(&self, pixel: Vector2<f64>, margin_px: f64) -> bool {
        let inside = |at: f64, extent: f64| at >= margin_px && at <= extent - margin_px;
        inside(pixel.x, self.height_px) && inside(pixel.y, self.width_px)
    }
}

impl Distortion {
    /// Whether there is none.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// Where a straight ray `(up, right)` appears.
    ///
    /// In OpenCV's coordinates x is right and y is down, so the tangential terms that are odd in
    /// y change their sign here.
    pub fn bend(&self, ray: Vector2<f64>) -> Vector2<f64> {
        if self.is_none() {
            return ray;
        }
        let [k1, k2, k3] = self.radial;
        let [p1, p2] = self.tangential;
        let (x, y) = (ray.y, -ray.x);
        let square = x * x + y * y;
        let radial = 1.0 + square * (k1 + square * (k2 + square * k3));
        let bent_x = x * radial + 2.0 * p1 * x * y + p2 * (square + 2.0 * x * x);
        let bent_y = y * radial + p1 * (square + 2.0 * y * y) + 2.0 * p2 * x * y;
        Vector2::new(-bent_y, bent_x)
    }

    /// The straight ray that appears at `bent`: the inverse of [`bend`](Self::bend), by Newton's
    /// method.
    pub fn straighten(&self, bent: Vector2<f64>) -> Option<Vector2<f64>> {
        const STEPS: usize = 30;
        const CLOSE: f64 = 1e-13;
        let mut ray = bent;
        for _ in 0..STEPS {
            let miss = self.bend(ray) - bent;
            if miss.norm() <= CLOSE * (1.0 + bent.norm()) {
                return Some(ray);
            }
            ray -= self.bend_derivative(ray).try_inverse()? * miss;
        }
        None
    }

    /// Derivative of [`bend`](Self::bend): rows (up, right) bent, columns (up, right) straight.
    fn bend_derivative(&self, ray: Vector2<f64>) -> SMatrix<f64, 2, 2> {
        let [k1, k2, k3] = self.radial;
        let [p1, p2] = self.tangential;
        let (x, y) = (ray.y, -ray.x);
        let square = x * x + y * y;
        let radial = 1.0 + square * (k1 + square * (k2 + square * k3));
        let slope = k1 + square * (2.0 * k2 + square * 3.0 * k3);
        let xx = radial + 2.0 * x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x;
        let xy = 2.0 * x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y;
        let yy = radial + 2.0 * y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x;
        SMatrix::<f64, 2, 2>::new(yy, -xy, -xy, xx)
    }
}

impl Scene {
    /// Number of inputs of a network: two a landmark.
    pub fn inputs(&self) -> usize {
        2 * self.landmarks_m().len()
    }

    /// The pixels of all landmarks, `[u0, v0, u1, v1, ...]`, if all are ahead of the camera.
    ///
    /// # Units
    /// px
    pub fn project(&self, pose: &Pose) -> Option<Vec<f64>> {
        let mut pixels = vec![0.0; self.inputs()];
        self.project_into(pose, &mut pixels).then_some(pixels)
    }

    /// [`project`](Self::project) into a buffer of `2n` numbers; false if a landmark is not ahead.
    pub fn project_into(&self, pose: &Pose, pixels: &mut [f64]) -> bool {
        let turn = self.camera_from_body().matrix() * pose.deck_from_body.matrix().transpose();
        for (landmark, pixel) in self.landmarks_m().iter().zip(pixels.chunks_exact_mut(2)) {
            let Some(seen) = self.camera().pixel(&(turn * (landmark - pose.position_m))) else {
                return false;
            };
            pixel.copy_from_slice(seen.as_slice());
        }
        true
    }

    /// Whether all the pixels are inside the image by the scene's margin.
    pub fn in_view(&self, pixels: &[f64]) -> bool {
        pixels.chunks_exact(2).all(|pixel| {
            self.camera()
                .sees(Vector2::new(pixel[0], pixel[1]), self.margin_px())
        })
    }

    /// Pixels of all landmarks and their derivatives by the six parameters.
    ///
    /// # Shape
    /// `[2n]` and `[2n][6]`
    pub fn linearize(&self, q: &Parameters) -> Option<(DVector<f64>, Jacobian)> {
        let count = self.inputs();
        let mut pixels = DVector::zeros(count);
        let mut jacobian = Jacobian::zeros(count);
        let camera = self.camera();
        let body_from_deck = Attitude {
            roll_rad: q[3],
            pitch_rad: q[4],
            yaw_rad: q[5],
        }
        .body_from_deck();
        let body_from_deck = body_from_deck.matrix();
        let mount = self.camera_from_body().matrix();
        let position = crate::scene::pose_of(q).position_m;
        let moves = position_derivative(q);
        // Axes of the three turns, in B: roll about X, pitch about the Z that roll has turned,
        // yaw about the deck's Y.
        let (sg, cg) = q[3].sin_cos();
        let axes = [
            Vector3::x(),
            Vector3::new(0.0, sg, cg),
            body_from_deck.column(1).into_owned(),
        ];
        for (i, landmark) in self.landmarks_m().iter().enumerate() {
            let arm = body_from_deck * (landmark - position);
            let point = mount * arm;
            let pixel = camera.pixel(&point)?;
            pixels[2 * i] = pixel.x;
            pixels[2 * i + 1] = pixel.y;
            let by_point = camera.pixel_derivative(&point) * mount;
            for (k, axis) in axes.iter().enumerate() {
                let by_position = -(by_point * (body_from_deck * moves.column(k)));
                let by_turn = -(by_point * axis.cross(&arm));
                jacobian
                    .fixed_view_mut::<2, 1>(2 * i, k)
                    .copy_from(&by_position);
                jacobian
                    .fixed_view_mut::<2, 1>(2 * i, k + 3)
                    .copy_from(&by_turn);
            }
        }
        Some((pixels, jacobian))
    }
}

impl Camera {
    /// Derivative of [`pixel`](Self::pixel): rows u and v, columns x, y and z in C.
    pub(crate) fn pixel_derivative(&self, point: &Vector3<f64>) -> SMatrix<f64, 2, 3> {
        let depth = point.x;
        let ray = Vector2::new(point.y / depth, point.z / depth);
        let by_point = SMatrix::<f64, 2, 3>::new(
            -ray.x / depth,
            1.0 / depth,
            0.0,
            -ray.y / depth,
            0.0,
            1.0 / depth,
        );
        let bent = if self.distortion.is_none() {
            by_point
        } else {
            self.distortion.bend_derivative(ray) * by_point
        };
        SMatrix::<f64, 2, 2>::new(self.focal_u_px, 0.0, 0.0, self.focal_v_px) * bent
    }
}

/// Derivative of the position by distance, elevation and azimuth.
///
/// # Shape
/// `[3][3]`
pub fn position_derivative(q: &Parameters) -> Matrix3<f64> {
    let (elevation, azimuth) = (q[1].tan(), q[2].tan());
    Matrix3::new(
        -1.0,
        0.0,
        0.0,
        elevation,
        q[0] * (1.0 + elevation * elevation),
        0.0,
        azimuth,
        0.0,
        q[0] * (1.0 + azimuth * azimuth),
    )
}
