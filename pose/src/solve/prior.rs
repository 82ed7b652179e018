//! The pose box as a prior: its coordinates, the likeliest pose in them, and draws around it.

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use rand::RngExt;
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

/// The fit at a place of the box: what all noise levels have in common there.
#[derive(Clone, Debug)]
pub struct Place {
    at: Whitened,
    /// `J'J` by the whitened coordinates.
    information: SMatrix<f64, 6, 6>,
    /// `J'(seen - expected)`.
    pull: Whitened,
    square_px: f64,
    /// Number of pixel coordinates.
    count: f64,
}

/// The posterior of one noise level, as a Gaussian expanded at a place of the box.
///
/// The prior in it is the Gaussian of the box's moments.
#[derive(Clone, Debug)]
pub struct Mode {
    /// Logarithm of the integral of likelihood and prior, up to a constant of the scene.
    pub log_evidence: f64,
    /// Where the Gaussian is centered: beyond the box if the posterior rises towards an edge.
    center: Whitened,
    /// `L` of the precision `L L'`.
    root: SMatrix<f64, 6, 6>,
    /// The inverse of `L'`.
    spread: SMatrix<f64, 6, 6>,
    /// Logarithm of the likelihood's and the Gaussian's constant factors.
    log_constant: f64,
    sigma_px: f64,
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

    /// The fit at a place; `None` if a landmark is not ahead of the camera there.
    pub fn place(&self, sightings: &Sightings, at: Whitened) -> Option<Place> {
        let q = self.parameters(&at);
        let normal = sightings.normal(&pose_of(&q))?;
        let mut slopes = SMatrix::<f64, 6, 6>::zeros();
        slopes
            .fixed_view_mut::<3, 3>(0, 0)
            .copy_from(&position_derivative(&q));
        slopes
            .fixed_view_mut::<3, 3>(3, 3)
            .copy_from(&turn_derivative(&q));
        for k in 0..6 {
            let mut column = slopes.column_mut(k);
            column *= self.scale[k];
        }
        Some(Place {
            at,
            information: slopes.transpose() * normal.information * slopes,
            pull: slopes.transpose() * normal.pull,
            square_px: normal.square_px,
            count: sightings.pixels.len() as f64,
        })
    }

    /// The likeliest place of the box near another, by damped Gauss-Newton steps in the box.
    ///
    /// It need not be exact: the draws around it are weighed by what they are.
    pub fn climb(&self, sightings: &Sightings, sigma_px: f64, start: Place) -> Place {
        const STEPS: usize = 50;
        const STILL: f64 = 1e-3;
        const HARSHEST: f64 = 1e12;
        let mut place = start;
        let mut damping = 0.0;
        for _ in 0..STEPS {
            let slope = place.slope(sigma_px);
            let Some(step) = slope.step_within(&place.at, damping) else {
                break;
            };
            // Twice what the logarithm gains in the linear model, if the step is not cut off.
            if step.dot(&slope.pull) * (1.0 + damping) < STILL {
                break;
            }
            match self.place(sightings, place.at + step) {
                Some(ahead) if ahead.slope(sigma_px).misfit <= slope.misfit => {
                    place = ahead;
                    damping /= 10.0;
                }
                _ if damping > HARSHEST => break,
                _ => damping = (damping * 10.0).max(STILL),
            }
        }
        place
    }

    /// Up to `count` poses of the box, drawn from the mode's Gaussian in pairs on both sides of
    /// its center.
    ///
    /// Draws outside of the box are dropped, and their number counts in the weights.
    pub fn draw(
        &self,
        sightings: &Sightings,
        mode: &Mode,
        count: usize,
        rng: &mut ChaCha8Rng,
    ) -> Vec<Draw> {
        const TRIES: usize = 8;
        let mut draws = Vec::with_capacity(count + 1);
        let mut tried = 0;
        while draws.len() < count && tried < TRIES * count {
            let normal = Whitened::from_fn(|_, _| StandardNormal.sample(rng));
            let offset = mode.spread * normal;
            let log_density = -normal.norm_squared() / 2.0;
            for s in [mode.center + offset, mode.center - offset] {
                tried += 1;
                if s.amax() <= EDGE {
                    draws.extend(self.weighed(sightings, mode, &s, log_density));
                }
            }
        }
        let share = (tried as f64).ln();
        for draw in &mut draws {
            draw.log_weight -= share;
        }
        draws
    }

    /// `count` poses drawn from the mode's Gaussian within the box, one coordinate after the
    /// other: slower than [`draw`](Self::draw), and never in vain.
    ///
    /// # Source
    /// J. Geweke, 1991; V. Hajivassiliou and D. McFadden, 1998; M. Keane, 1994 (the GHK simulator).
    pub fn draw_within(
        &self,
        sightings: &Sightings,
        mode: &Mode,
        count: usize,
        rng: &mut ChaCha8Rng,
    ) -> Vec<Draw> {
        let share = (count as f64).ln();
        (0..count)
            .filter_map(|_| {
                let mut s = Whitened::zeros();
                let mut log_density = -mode.root.diagonal().map(f64::ln).sum();
                // The exponent is |L'(s - center)|^2, so that the last coordinate stands alone.
                for i in (0..6).rev() {
                    let pivot = mode.root[(i, i)];
                    let above: f64 = (i + 1..6)
                        .map(|j| mode.root[(j, i)] * (s[j] - mode.center[j]))
                        .sum();
                    let histogram = Histogram::new(mode.center[i] - above / pivot, pivot.recip());
                    let (at, log_at) = histogram.draw(rng);
                    s[i] = at;
                    log_density += log_at;
                }
                let draw = self.weighed(sightings, mode, &s, log_density)?;
                Some(Draw {
                    log_weight: draw.log_weight - share,
                    ..draw
                })
            })
            .collect()
    }

    /// A pose with its weight; the density is that of the whitened draw under `|L| = 1`.
    fn weighed(
        &self,
        sightings: &Sightings,
        mode: &Mode,
        s: &Whitened,
        log_density: f64,
    ) -> Option<Draw> {
        let pose = self.pose(s);
        let square_px = sightings.square_px(&pose)?;
        let misfit = square_px / (mode.sigma_px * mode.sigma_px);
        Some(Draw {
            log_weight: mode.log_constant - misfit / 2.0 - log_density,
            pose,
        })
    }
}

impl Place {
    fn slope(&self, sigma_px: f64) -> Slope {
        let per_square = 1.0 / (sigma_px * sigma_px);
        Slope {
            precision: self.information * per_square + SMatrix::identity(),
            pull: self.pull * per_square - self.at,
            misfit: self.square_px * per_square + self.at.norm_squared(),
        }
    }

    /// The posterior under a noise level, expanded here.
    pub fn mode(&self, sigma_px: f64) -> Option<Mode> {
        let slope = self.slope(sigma_px);
        let factor = slope.precision.cholesky()?;
        let step = factor.solve(&slope.pull);
        let root = factor.unpack();
        let spread = root
            .solve_lower_triangular(&SMatrix::<f64, 6, 6>::identity())?
            .transpose();
        let log_constant = -root.diagonal().map(f64::ln).sum() - self.count * sigma_px.ln();
        Some(Mode {
            log_evidence: log_constant - (slope.misfit - step.dot(&slope.pull)) / 2.0,
            center: self.at + step,
            root,
            spread,
            log_constant,
            sigma_px,
        })
    }
}

/// Twice the negative logarithm of the Gaussian posterior, with its derivatives.
struct Slope {
    precision: SMatrix<f64, 6, 6>,
    pull: Whitened,
    misfit: f64,
}

impl Slope {
    /// The damped Gauss-Newton step, cut off at the box.
    ///
    /// Coordinates at an edge that are pulled outwards are held.
    fn step_within(&self, at: &Whitened, damping: f64) -> Option<Whitened> {
        let mut damped = self.precision;
        let mut pull = self.pull;
        for i in 0..6 {
            if at[i].abs() >= EDGE && at[i] * pull[i] > 0.0 {
                damped.row_mut(i).fill(0.0);
                damped.column_mut(i).fill(0.0);
                damped[(i, i)] = 1.0;
                pull[i] = 0.0;
            }
            damped[(i, i)] *= 1.0 + damping;
        }
        let step = damped.cholesky()?.solve(&pull);
        Some((at + step).map(|s| s.clamp(-EDGE, EDGE)) - at)
    }
}

/// A Gaussian within the box's extent along one coordinate, in cells of constant density.
struct Histogram {
    first: f64,
    cell: f64,
    /// Sums of the cells' masses up to and with each.
    sums: [f64; CELLS],
}

const CELLS: usize = 32;

impl Histogram {
    /// The cells span where the density is within `e^-18` of its greatest in the box.
    fn new(mean: f64, deviation: f64) -> Self {
        const DEPTH: f64 = 36.0;
        let top = mean.clamp(-EDGE, EDGE);
        let beyond = (mean - top).abs();
        let reach = DEPTH * deviation * deviation
            / (beyond + (beyond * beyond + DEPTH * deviation * deviation).sqrt());
        let first = (top - reach).max(-EDGE);
        let last = (top + reach).min(EDGE);
        let cell = (last - first) / CELLS as f64;
        let mut total = 0.0;
        let sums = std::array::from_fn(|i| {
            let miss = (first + cell * (i as f64 + 0.5) - mean) / deviation;
            // Against the greatest density, so that a far tail does not vanish.
            let best = (top - mean) / deviation;
            total += ((best * best - miss * miss) / 2.0).exp();
            total
        });
        Self { first, cell, sums }
    }

    /// A draw and the logarithm of its density, less that of `sqrt(2 pi)`'s inverse.
    fn draw(&self, rng: &mut ChaCha8Rng) -> (f64, f64) {
        let total = self.sums[CELLS - 1];
        let wanted = rng.random::<f64>() * total;
        let i = self
            .sums
            .partition_point(|sum| *sum <= wanted)
            .min(CELLS - 1);
        let below = if i == 0 { 0.0 } else { self.sums[i - 1] };
        let at = self.first + self.cell * (i as f64 + rng.random::<f64>());
        let density = (self.sums[i] - below) / (total * self.cell);
        (at, (density * std::f64::consts::TAU.sqrt()).ln())
    }
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
