//! The pose box as a prior: its coordinates, the likeliest pose in them, and draws around it.

use nalgebra::{Cholesky, Matrix3, SMatrix, SVector, U6, Vector3};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::fit::Sightings;
use crate::frames::{Attitude, Pose};
use crate::observe::position_derivative;
use crate::scene::{Parameters, Scene, pose_of};

/// Parameters less the middle of the box, over the standard deviation of a uniform draw from it.
///
/// A box of no width in some parameter holds that parameter at its middle.
pub type Whitened = SVector<f64, 6>;

/// The box is where no whitened coordinate is beyond this, the root of 3.
const EDGE: f64 = 1.732_050_807_568_877_2;

/// A scene's pose box.
#[derive(Clone, Debug)]
pub struct Prior {
    middle: Parameters,
    scale: Parameters,
}

/// Where the posterior under a Gaussian of the box's moments is highest, and its shape there.
#[derive(Clone, Debug)]
pub struct Mode {
    /// The place.
    pub at: Whitened,
    /// Standard deviation of the pixel noise.
    pub sigma_px: f64,
    /// Root of the inverse covariance.
    factor: Cholesky<f64, U6>,
    /// Logarithm of the integral of likelihood and prior, up to a constant of the scene.
    pub log_evidence: f64,
}

/// A pose of the box, and the logarithm of its importance up to a constant of the scene.
#[derive(Clone, Copy, Debug)]
pub struct Draw {
    /// Logarithm of likelihood over density of drawing.
    pub log_weight: f64,
    /// The pose.
    pub pose: Pose,
}

impl Prior {
    /// The prior of a scene.
    pub fn new(scene: &Scene) -> Self {
        Self {
            middle: scene.poses().middle(),
            scale: scene.poses().widths() / 12f64.sqrt(),
        }
    }

    /// The point of the box that is nearest to some parameters.
    pub fn nearest(&self, q: &Parameters) -> Whitened {
        Whitened::from_fn(|i, _| {
            if self.scale[i] == 0.0 {
                0.0
            } else {
                ((q[i] - self.middle[i]) / self.scale[i]).clamp(-EDGE, EDGE)
            }
        })
    }

    /// The pose of whitened coordinates.
    pub fn pose(&self, s: &Whitened) -> Pose {
        pose_of(&self.parameters(s))
    }

    fn parameters(&self, s: &Whitened) -> Parameters {
        self.middle + self.scale.component_mul(s)
    }

    /// The mode near a start, by damped Gauss-Newton steps.
    ///
    /// It need not be exact: the draws around it are weighed by what they are.
    /// `None` if the start has a landmark that is not ahead of the camera.
    pub fn mode(&self, sightings: &Sightings, sigma_px: f64, start: Whitened) -> Option<Mode> {
        const STEPS: usize = 50;
        const STILL: f64 = 1e-3;
        const HARSHEST: f64 = 1e12;
        let mut at = start;
        let mut slope = self.slope(sightings, sigma_px, &at)?;
        let mut damping = 0.0;
        for _ in 0..STEPS {
            let mut damped = slope.precision;
            for i in 0..6 {
                damped[(i, i)] *= 1.0 + damping;
            }
            let Some(factor) = damped.cholesky() else {
                break;
            };
            let step = factor.solve(&slope.pull);
            let ahead = at + step;
            match self.slope(sightings, sigma_px, &ahead) {
                Some(there) if there.misfit <= slope.misfit => {
                    (at, slope) = (ahead, there);
                    damping /= 10.0;
                    if step.dot(&slope.pull).abs() < STILL && damping < STILL {
                        break;
                    }
                }
                _ if damping > HARSHEST || step.dot(&slope.pull) < STILL => break,
                _ => damping = (damping * 10.0).max(STILL),
            }
        }
        let factor = slope.precision.cholesky()?;
        let spread = -factor.l_dirty().diagonal().map(f64::ln).sum();
        Some(Mode {
            at,
            sigma_px,
            log_evidence: spread
                - slope.misfit / 2.0
                - sightings.pixels.len() as f64 * sigma_px.ln(),
            factor,
        })
    }

    /// Up to `count` poses of the box, drawn in pairs on both sides of a mode.
    ///
    /// Poses outside of the box are dropped, and their number counts in the weights.
    pub fn draw(
        &self,
        sightings: &Sightings,
        mode: &Mode,
        count: usize,
        rng: &mut ChaCha8Rng,
    ) -> Vec<Draw> {
        const TRIES: usize = 16;
        let per_square = -0.5 / (mode.sigma_px * mode.sigma_px);
        let root = mode.factor.l_dirty();
        let constant = -root.diagonal().map(f64::ln).sum()
            - sightings.pixels.len() as f64 * mode.sigma_px.ln();
        let mut draws = Vec::with_capacity(count + 1);
        let mut tried = 0;
        while draws.len() < count && tried < TRIES * count {
            let normal = Whitened::from_fn(|_, _| StandardNormal.sample(rng));
            let offset = root
                .tr_solve_lower_triangular(&normal)
                .expect("a Cholesky factor");
            for s in [mode.at + offset, mode.at - offset] {
                tried += 1;
                if s.amax() > EDGE {
                    continue;
                }
                let pose = self.pose(&s);
                if let Some(square_px) = sightings.square_px(&pose) {
                    draws.push(Draw {
                        log_weight: constant + square_px * per_square + normal.norm_squared() / 2.0,
                        pose,
                    });
                }
            }
        }
        let share = (tried as f64).ln();
        for draw in &mut draws {
            draw.log_weight -= share;
        }
        draws
    }

    fn slope(&self, sightings: &Sightings, sigma_px: f64, s: &Whitened) -> Option<Slope> {
        let q = self.parameters(s);
        let pose = pose_of(&q);
        let normal = sightings.normal(&pose)?;
        let mut by_s = SMatrix::<f64, 6, 6>::zeros();
        by_s.fixed_view_mut::<3, 3>(0, 0)
            .copy_from(&position_derivative(&q));
        by_s.fixed_view_mut::<3, 3>(3, 3)
            .copy_from(&turn_derivative(&q));
        for k in 0..6 {
            let mut column = by_s.column_mut(k);
            column *= self.scale[k] / sigma_px;
        }
        let misfit = normal.square_px / (sigma_px * sigma_px) + s.norm_squared();
        Some(Slope {
            precision: by_s.transpose() * normal.information * by_s + SMatrix::identity(),
            pull: by_s.transpose() * normal.pull / sigma_px - s,
            misfit,
        })
    }
}

/// Twice the negative logarithm of the Gaussian posterior, with its derivatives.
struct Slope {
    precision: SMatrix<f64, 6, 6>,
    pull: Whitened,
    misfit: f64,
}

/// The turn in B by roll, pitch and yaw: about X, the Z that roll has turned, and the deck's Y.
fn turn_derivative(q: &Parameters) -> Matrix3<f64> {
    let attitude = Attitude {
        roll_rad: q[3],
        pitch_rad: q[4],
        yaw_rad: q[5],
    };
    let (sg, cg) = q[3].sin_cos();
    Matrix3::from_columns(&[
        Vector3::x(),
        Vector3::new(0.0, sg, cg),
        attitude.body_from_deck().matrix().column(1).into_owned(),
    ])
}
