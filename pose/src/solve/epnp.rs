//! EPnP: landmarks as weighted sums of a few control points, whose places are sought.

use nalgebra::{DMatrix, DVector, Vector2, Vector3};

use super::Estimator;
use super::placement::{Placement, middle, principal_axes, rays};
use crate::frames::Pose;
use crate::scene::Scene;

/// The closed form for many landmarks, with Gauss-Newton on its few weights and nothing after it.
///
/// Flat landmarks are taken as sums of three control points, others of four.
/// Every number of kernel directions is tried, and where the method as published has more unknowns
/// than equations, from several starts; the best fit is taken.
///
/// # Source
/// V. Lepetit, F. Moreno-Noguer and P. Fua, "EPnP: an accurate O(n) solution to the PnP problem",
/// 2009.
#[derive(Clone, Debug)]
pub struct EPnp<'a> {
    scene: &'a Scene,
    controls: Controls,
}

impl<'a> EPnp<'a> {
    /// The estimator of a scene.
    pub fn new(scene: &'a Scene) -> Self {
        Self {
            scene,
            controls: Controls::new(scene.landmarks_m()),
        }
    }
}

impl Estimator for EPnp<'_> {
    fn name(&self) -> &'static str {
        "epnp"
    }

    fn estimate(&self, pixels: &[f64]) -> Option<Pose> {
        let rays = rays(self.scene, pixels)?;
        let placement = self.controls.solve(self.scene.landmarks_m(), &rays)?;
        Some(placement.pose(self.scene))
    }
}

/// Landmarks whose least extent is below this fraction of their largest are flat.
const FLAT: f64 = 1e-6;

/// Control points, and the landmarks as sums of them.
#[derive(Clone, Debug)]
struct Controls {
    points_m: Vec<Vector3<f64>>,
    /// `[n][points]`, rows sum to one.
    weights: DMatrix<f64>,
}

/// Differences of control points in each direction of the kernel: `[pairs][directions]`.
type Differences = Vec<Vec<Vector3<f64>>>;

impl Controls {
    /// The centroid, and a standard deviation along each principal axis from it.
    fn new(landmarks_m: &[Vector3<f64>]) -> Self {
        let center = middle(landmarks_m);
        let (axes, deviations) = principal_axes(landmarks_m);
        let dimensions = if deviations[2] <= FLAT * deviations[0] {
            2
        } else {
            3
        };
        let mut points_m = vec![center];
        let mut weights = DMatrix::zeros(landmarks_m.len(), dimensions + 1);
        for k in 0..dimensions {
            points_m.push(center + axes.column(k) * deviations[k]);
            for (i, landmark) in landmarks_m.iter().enumerate() {
                weights[(i, k + 1)] = axes.column(k).dot(&(landmark - center)) / deviations[k];
            }
        }
        for mut row in weights.row_iter_mut() {
            row[0] = 1.0 - row.sum();
        }
        Self { points_m, weights }
    }

    /// The best of the solutions with one, two, ... directions of the kernel.
    fn solve(&self, landmarks_m: &[Vector3<f64>], rays: &[Vector2<f64>]) -> Option<Placement> {
        let kernel = self.kernel(rays)?;
        let (differences, squares) = self.distances(&kernel);
        let mut best: Option<(f64, Placement)> = None;
        for count in 1..=self.points_m.len() {
            for betas in first_betas(&differences, &squares, count) {
                let placed = polish(&differences, &squares, betas)
                    .and_then(|betas| self.place(landmarks_m, &kernel, &betas));
                if let Some(placement) = placed
                    && let Some(error) = placement.square_error(landmarks_m, rays)
                    && best.is_none_or(|(least, _)| error < least)
                {
                    best = Some((error, placement));
                }
            }
        }
        best.map(|(_, placement)| placement)
    }

    /// The kernel of `M`: directions in which the control points may lie, the likeliest first.
    ///
    /// # Shape
    /// As many columns as control points, of three coordinates for each of them.
    fn kernel(&self, rays: &[Vector2<f64>]) -> Option<DMatrix<f64>> {
        let controls = self.points_m.len();
        let columns = 3 * controls;
        // Rows of zeros give the decomposition the directions that no landmark speaks of.
        let mut system = DMatrix::zeros((2 * rays.len()).max(columns), columns);
        for (i, ray) in rays.iter().enumerate() {
            for j in 0..controls {
                let weight = self.weights[(i, j)];
                // y - up x = 0 and z - right x = 0.
                system[(2 * i, 3 * j)] = -weight * ray.x;
                system[(2 * i, 3 * j + 1)] = weight;
                system[(2 * i + 1, 3 * j)] = -weight * ray.y;
                system[(2 * i + 1, 3 * j + 2)] = weight;
            }
        }
        if !system.iter().all(|x| x.is_finite()) {
            return None;
        }
        let rows = system.svd(false, true).v_t?;
        Some(DMatrix::from_fn(columns, controls, |i, k| {
            rows[(columns - 1 - k, i)]
        }))
    }

    /// Differences of all pairs of control points in the kernel, and their squared distances.
    fn distances(&self, kernel: &DMatrix<f64>) -> (Differences, Vec<f64>) {
        let controls = self.points_m.len();
        let at = |k: usize, i: usize| kernel.fixed_view::<3, 1>(3 * i, k).into_owned();
        (0..controls)
            .flat_map(|i| (0..i).map(move |j| (i, j)))
            .map(|(i, j)| {
                let differences = (0..controls).map(|k| at(k, i) - at(k, j)).collect();
                let square = (self.points_m[i] - self.points_m[j]).norm_squared();
                (differences, square)
            })
            .unzip()
    }

    /// The motion that takes the landmarks nearest to where the control points put them.
    fn place(
        &self,
        landmarks_m: &[Vector3<f64>],
        kernel: &DMatrix<f64>,
        betas: &DVector<f64>,
    ) -> Option<Placement> {
        let controls = kernel.columns(0, betas.len()) * betas;
        let mut seen: Vec<Vector3<f64>> = self
            .weights
            .row_iter()
            .map(|row| {
                (0..row.len())
                    .map(|j| row[j] * controls.fixed_rows::<3>(3 * j))
                    .sum()
            })
            .collect();
        // The kernel has no sign: the landmarks are ahead.
        if middle(&seen).x < 0.0 {
            seen.iter_mut().for_each(|point| *point = -*point);
        }
        Placement::between(landmarks_m, &seen)
    }
}

/// The weights of `count` directions from their products, taken as unknowns of their own.
///
/// Where these outnumber the distances, from those with one of the weights, for each in turn.
fn first_betas(differences: &Differences, squares: &[f64], count: usize) -> Vec<DVector<f64>> {
    let all: Vec<(usize, usize)> = (0..count)
        .flat_map(|a| (a..count).map(move |b| (a, b)))
        .collect();
    let choices = if all.len() <= squares.len() {
        vec![all]
    } else {
        (0..count)
            .map(|a| (0..count).map(|b| (a, b)).collect())
            .collect()
    };
    choices
        .iter()
        .filter_map(|products| betas_of(products, differences, squares, count))
        .collect()
}

fn betas_of(
    products: &[(usize, usize)],
    differences: &Differences,
    squares: &[f64],
    count: usize,
) -> Option<DVector<f64>> {
    let system = DMatrix::from_fn(squares.len(), products.len(), |row, column| {
        let (a, b) = products[column];
        let twice = if a == b { 1.0 } else { 2.0 };
        twice * differences[row][a].dot(&differences[row][b])
    });
    let found = least_squares(system, &DVector::from_column_slice(squares))?;
    // The column of the largest square among the products, over that square's root.
    let mut table = DMatrix::zeros(count, count);
    for (&(a, b), &product) in products.iter().zip(&found) {
        table[(a, b)] = product;
        table[(b, a)] = product;
    }
    let largest = table.diagonal().iamax();
    let root = table[(largest, largest)].abs().sqrt();
    (root > 0.0).then(|| table.column(largest) / root)
}

/// Gauss-Newton on the weights, so that the control points keep their distances.
fn polish(
    differences: &Differences,
    squares: &[f64],
    mut betas: DVector<f64>,
) -> Option<DVector<f64>> {
    const STEPS: usize = 10;
    for _ in 0..STEPS {
        let sums: Vec<Vector3<f64>> = differences
            .iter()
            .map(|pair| pair.iter().zip(&betas).map(|(d, beta)| d * *beta).sum())
            .collect();
        let slopes = DMatrix::from_fn(squares.len(), betas.len(), |row, k| {
            2.0 * differences[row][k].dot(&sums[row])
        });
        let misses = DVector::from_fn(squares.len(), |row, _| {
            squares[row] - sums[row].norm_squared()
        });
        betas += least_squares(slopes, &misses)?;
    }
    Some(betas)
}

fn least_squares(system: DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
    const RANK: f64 = 1e-12;
    if !system.iter().all(|x| x.is_finite()) {
        return None;
    }
    let svd = system.svd(true, true);
    let least = RANK * svd.singular_values.max();
    svd.solve(right, least).ok()
}
