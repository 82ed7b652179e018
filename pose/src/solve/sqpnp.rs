//! SQPnP: the pose as a quadratic program over rotations, started from many sides.

use nalgebra::{Matrix3, SMatrix, SVector, Vector2, Vector3};

use super::Estimator;
use super::placement::{Placement, middle, nearest_rotation, rays};
use crate::frames::Pose;
use crate::scene::Scene;

type Matrix9 = SMatrix<f64, 9, 9>;
type Vector9 = SVector<f64, 9>;

/// Least squares of the landmarks' distances from their lines of sight, as multiples of depth.
///
/// # Source
/// G. Terzakis and M. Lourakis, "A consistently fast and globally optimal solution to the
/// perspective-n-point problem", 2020.
#[derive(Clone, Copy, Debug)]
pub struct SqPnp<'a> {
    scene: &'a Scene,
}

impl<'a> SqPnp<'a> {
    /// The estimator of a scene.
    pub fn new(scene: &'a Scene) -> Self {
        Self { scene }
    }
}

impl Estimator for SqPnp<'_> {
    fn name(&self) -> &'static str {
        "sqpnp"
    }

    fn estimate(&self, pixels: &[f64]) -> Option<Pose> {
        let rays = rays(self.scene, pixels)?;
        Some(solve(self.scene.landmarks_m(), &rays)?.pose(self.scene))
    }
}

/// Eigenvalues below this fraction of the largest are zero.
const RANK: f64 = 1e-7;

fn solve(landmarks_m: &[Vector3<f64>], rays: &[Vector2<f64>]) -> Option<Placement> {
    let problem = Problem::new(landmarks_m, rays)?;
    let eigen = problem.cost.symmetric_eigen();
    let mut order: Vec<usize> = (0..9).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    let largest = eigen.eigenvalues[order[8]];
    let null = order
        .iter()
        .filter(|&&i| eigen.eigenvalues[i] <= RANK * largest)
        .count()
        .max(1);
    let mut best: Option<(f64, Placement)> = None;
    for (rank, &i) in order.iter().enumerate() {
        // A rotation has length sqrt 3, and its cost along further directions is at least this.
        let least = 3.0 * eigen.eigenvalues[i];
        if rank >= null && best.is_some_and(|(cost, _)| cost <= least) {
            break;
        }
        for sign in [1.0, -1.0] {
            let direction = eigen.eigenvectors.column(i) * (sign * 3f64.sqrt());
            let found = problem.descend(&direction);
            if let Some((cost, placement)) = found
                && best.is_none_or(|(least, _)| cost < least)
                && landmarks_m.iter().all(|l| placement.point(l).x > 0.0)
            {
                best = Some((cost, placement));
            }
        }
    }
    best.map(|(_, placement)| placement)
}

/// The quadratic form of a rotation's nine entries, row by row.
struct Problem {
    cost: Matrix9,
    shift_by_turn: SMatrix<f64, 3, 9>,
    center_m: Vector3<f64>,
}

impl Problem {
    /// The best translation is linear in the rotation, and is put in.
    fn new(landmarks_m: &[Vector3<f64>], rays: &[Vector2<f64>]) -> Option<Self> {
        let center_m = middle(landmarks_m);
        let mut weights = Matrix3::zeros();
        let mut mixed = SMatrix::<f64, 3, 9>::zeros();
        let mut cost = Matrix9::zeros();
        for (landmark, ray) in landmarks_m.iter().zip(rays) {
            // The miss is (y - up x, z - right x).
            let miss = SMatrix::<f64, 2, 3>::new(-ray.x, 1.0, 0.0, -ray.y, 0.0, 1.0);
            let weight = miss.transpose() * miss;
            let arm = arms(&(landmark - center_m));
            weights += weight;
            mixed += weight * arm;
            cost += arm.transpose() * weight * arm;
        }
        let shift_by_turn = -weights.try_inverse()? * mixed;
        cost += mixed.transpose() * shift_by_turn;
        cost = (cost + cost.transpose()) / 2.0;
        cost.iter().all(|x| x.is_finite()).then_some(Self {
            cost,
            shift_by_turn,
            center_m,
        })
    }

    /// Sequential quadratic programming from the rotation nearest to a direction: each step
    /// minimises the cost under the linearised constraints that the rows are orthonormal.
    fn descend(&self, direction: &Vector9) -> Option<(f64, Placement)> {
        const STEPS: usize = 30;
        const STILL: f64 = 1e-28;
        let scale = self.cost.trace().max(f64::MIN_POSITIVE);
        let mut r = entries(&nearest_rotation(&matrix(direction))?);
        for _ in 0..STEPS {
            let (misfit, slopes) = constraints(&r);
            let mut saddle = SMatrix::<f64, 15, 15>::zeros();
            saddle
                .fixed_view_mut::<9, 9>(0, 0)
                .copy_from(&(self.cost / scale));
            saddle.fixed_view_mut::<6, 9>(9, 0).copy_from(&slopes);
            saddle
                .fixed_view_mut::<9, 6>(0, 9)
                .copy_from(&slopes.transpose());
            let mut right = SVector::<f64, 15>::zeros();
            right
                .fixed_rows_mut::<9>(0)
                .copy_from(&(self.cost * r / -scale));
            right.fixed_rows_mut::<6>(9).copy_from(&-misfit);
            let step = saddle.lu().solve(&right)?;
            let step = step.fixed_rows::<9>(0);
            r += step;
            if step.norm_squared() < STILL {
                break;
            }
        }
        let turn = nearest_rotation(&matrix(&r))?;
        let r = entries(&turn);
        let placement = Placement {
            turn,
            shift_m: self.shift_by_turn * r - turn * self.center_m,
        };
        Some(((r.transpose() * self.cost * r).x, placement))
    }
}

/// `arms(x) r` is the rotation of `x`.
fn arms(x: &Vector3<f64>) -> SMatrix<f64, 3, 9> {
    let mut arms = SMatrix::<f64, 3, 9>::zeros();
    for row in 0..3 {
        arms.fixed_view_mut::<1, 3>(row, 3 * row)
            .copy_from(&x.transpose());
    }
    arms
}

fn matrix(r: &Vector9) -> Matrix3<f64> {
    Matrix3::from_row_slice(r.as_slice())
}

fn entries(matrix: &Matrix3<f64>) -> Vector9 {
    Vector9::from_column_slice(matrix.transpose().as_slice())
}

/// How far the rows are from orthonormal, and the derivative of that.
fn constraints(r: &Vector9) -> (SVector<f64, 6>, SMatrix<f64, 6, 9>) {
    const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
    let rows = [0, 3, 6].map(|at| r.fixed_rows::<3>(at).into_owned());
    let mut misfit = SVector::zeros();
    let mut slopes = SMatrix::<f64, 6, 9>::zeros();
    for (k, (a, b)) in PAIRS.into_iter().enumerate() {
        misfit[k] = rows[a].dot(&rows[b]) - if a == b { 1.0 } else { 0.0 };
        for i in 0..3 {
            slopes[(k, 3 * a + i)] += rows[b][i];
            slopes[(k, 3 * b + i)] += rows[a][i];
        }
    }
    (misfit, slopes)
}
