//! Maximum likelihood: the pose whose pixels are nearest to those seen.

use nalgebra::{Matrix3, Vector3};

use super::Estimator;
use super::epnp::EPnp;
use super::fit::{Sightings, stepped};
use super::placement::{Placement, middle, principal_axes};
use super::sqpnp::SqPnp;
use crate::frames::Pose;
use crate::scene::Scene;

/// Least squares in the image, which is maximum likelihood under Gaussian noise, to convergence.
///
/// It starts from [`SqPnp`], or [`EPnp`] where that has no answer, and from the mirror image of
/// the start: what is nearly flat and far fits its own reflection almost as well, and the better
/// of the two minima is the answer.
///
/// # Source
/// D. W. Marquardt, 1963; the ambiguity as G. Schweighofer and A. Pinz, 2006.
#[derive(Clone, Copy, Debug)]
pub struct Ml<'a> {
    scene: &'a Scene,
    flattest: Vector3<f64>,
    center_m: Vector3<f64>,
}

impl<'a> Ml<'a> {
    /// The estimator of a scene.
    pub fn new(scene: &'a Scene) -> Self {
        let (axes, _) = principal_axes(scene.landmarks_m());
        Self {
            scene,
            flattest: axes.column(2).into_owned(),
            center_m: middle(scene.landmarks_m()),
        }
    }

    /// The pose under which the landmarks' image is the same when seen from far: their depths
    /// along the line of sight change sign, and with them the side of their flattest plane.
    fn mirrored(&self, pose: &Pose) -> Pose {
        let seen = Placement::of(pose, self.scene);
        let center = seen.point(&self.center_m);
        let turn = reflection(&center.normalize()) * seen.turn * reflection(&self.flattest);
        let mirrored = Placement {
            turn,
            shift_m: center - turn * self.center_m,
        };
        mirrored.pose(self.scene)
    }
}

impl Estimator for Ml<'_> {
    fn name(&self) -> &'static str {
        "ml"
    }

    fn estimate(&self, pixels: &[f64]) -> Option<Pose> {
        let sightings = Sightings::of(self.scene, pixels);
        let start = SqPnp::new(self.scene)
            .estimate(pixels)
            .or_else(|| EPnp::new(self.scene).estimate(pixels))?;
        let near = refine(&sightings, start);
        let from = near.map_or(start, |fit| fit.pose);
        let far = refine(&sightings, self.mirrored(&from));
        let best = match (near, far) {
            (Some(near), Some(far)) if far.square_px < near.square_px => Some(far),
            (near, far) => near.or(far),
        };
        best.map(|fit| fit.pose)
    }
}

/// The reflection across the plane of a unit normal.
fn reflection(normal: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::identity() - 2.0 * normal * normal.transpose()
}

/// A pose and the sum of squared distances in the image that it leaves.
#[derive(Clone, Copy, Debug)]
pub struct Fit {
    /// The pose.
    pub pose: Pose,
    /// Sum of squares.
    ///
    /// # Units
    /// px^2
    pub square_px: f64,
}

/// Most steps, taken or refused.
const MAX_STEPS: usize = 200;

/// The iteration has converged when a step moves the landmarks in the image by less than the root
/// of this together.
///
/// # Units
/// px^2
const STILL_PX2: f64 = 1e-18;

/// The pose of least squares near a start, by damped Gauss-Newton steps.
///
/// `None` if the start has a landmark that is not ahead of the camera.
pub(super) fn refine(sightings: &Sightings, start: Pose) -> Option<Fit> {
    const GENTLEST: f64 = 1e-12;
    const HARSHEST: f64 = 1e12;
    let mut pose = start;
    let mut normal = sightings.normal(&pose)?;
    let mut damping = 1e-4;
    for _ in 0..MAX_STEPS {
        let mut damped = normal.information;
        for i in 0..6 {
            damped[(i, i)] *= 1.0 + damping;
        }
        let trial = damped.cholesky().map(|factor| {
            let step = factor.solve(&normal.pull);
            let moved = (step.transpose() * normal.information * step).x;
            let pose = stepped(&pose, &step);
            (moved, pose, sightings.normal(&pose))
        });
        match trial {
            Some((moved, ahead, Some(there))) if there.square_px <= normal.square_px => {
                (pose, normal) = (ahead, there);
                damping = (damping / 10.0).max(GENTLEST);
                if moved < STILL_PX2 {
                    break;
                }
            }
            // Rounding alone decides whether so small a step helps.
            Some((moved, ..)) if moved < STILL_PX2 => break,
            _ if damping > HARSHEST => break,
            _ => damping *= 10.0,
        }
    }
    Some(Fit {
        pose,
        square_px: normal.square_px,
    })
}
