//! What is learnt from: noisy pixels, and the answer that they allow.

use nalgebra::{DMatrix, DVector, SymmetricEigen, Vector3};
use rayon::prelude::*;

use crate::sample::Sampler;
use crate::solve::bayes::{Bayes, LEAST_RODRIGUES_RAD};

/// What a sample's target is.
#[derive(Clone, Copy, Debug)]
pub enum Teacher<'a> {
    /// The pose that the sample was drawn from.
    Truth,
    /// The mean over all poses that the noisy pixels may come from.
    ///
    /// The network that fits it is the same as with the truth and endless samples; but the target
    /// is a smooth function of the pixels, so that far fewer samples do, and no noise is fitted.
    Posterior(&'a Bayes<'a>),
}

/// Samples with their targets.
#[derive(Clone, Debug)]
pub struct Dataset {
    /// # Shape
    /// `[2n][samples]`
    pub pixels: DMatrix<f64>,
    /// Targets for the position, m, then for the Rodrigues vector, rad.
    ///
    /// # Shape
    /// `[3][samples]` each
    pub targets: [DMatrix<f64>; 2],
    /// How much a squared error counts, so that the sum comes near to that of relative errors:
    /// one over the length of what is sought, and over the error to be expected there, which grows
    /// with the distance for the position and does not depend on the Rodrigues vector.
    ///
    /// # Shape
    /// `[samples]` each
    pub relative: [Vec<f64>; 2],
    /// Noise of each sample.
    pub noise_px: Vec<f64>,
}

impl Dataset {
    /// Samples from an index on; sample `i` gets level `i` of the list, again and again.
    ///
    /// # Panics
    /// If there are no levels.
    pub fn draw(
        sampler: &Sampler<'_>,
        teacher: Teacher<'_>,
        levels_px: &[f64],
        samples: std::ops::Range<u64>,
    ) -> Self {
        let rows: Vec<Row> = samples
            .into_par_iter()
            .map(|index| {
                let level =
                    usize::try_from(index % levels_px.len() as u64).expect("a list's index");
                Row::draw(sampler, teacher, levels_px[level], index)
            })
            .collect();
        let columns = |of: fn(&Row) -> &[f64]| {
            let height = of(&rows[0]).len();
            DMatrix::from_iterator(
                height,
                rows.len(),
                rows.iter().flat_map(|r| of(r).iter().copied()),
            )
        };
        Self {
            pixels: columns(|row| &row.pixels),
            targets: [
                columns(|row| row.targets[0].as_slice()),
                columns(|row| row.targets[1].as_slice()),
            ],
            relative: [0, 1].map(|k| rows.iter().map(|row| row.relative[k]).collect()),
            noise_px: rows.iter().map(|row| row.noise_px).collect(),
        }
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.noise_px.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

struct Row {
    pixels: Vec<f64>,
    targets: [Vector3<f64>; 2],
    relative: [f64; 2],
    noise_px: f64,
}

impl Row {
    fn draw(sampler: &Sampler<'_>, teacher: Teacher<'_>, noise_px: f64, index: u64) -> Self {
        let sample = sampler.draw(index);
        let pixels = sample.noisy_px(noise_px);
        let posterior = match teacher {
            // Without noise the truth is the answer.
            Teacher::Posterior(bayes) if noise_px > 0.0 => {
                bayes.posterior(&pixels, index, Some(&sample.parameters))
            }
            _ => None,
        };
        let (targets, relative) = match posterior {
            Some(found) if found.effective_samples >= LEAST_SAMPLES => (
                [found.relative_position_m, found.relative_rodrigues_rad],
                [found.position_weight.powi(2), found.rodrigues_weight],
            ),
            // The truth is a draw from the posterior: right on average, if less exact.
            _ => {
                let (p, r) = (sample.pose.position_m, sample.pose.rodrigues_rad());
                (
                    [p, r],
                    [
                        1.0 / p.norm_squared(),
                        1.0 / r.norm().max(LEAST_RODRIGUES_RAD),
                    ],
                )
            }
        };
        Self {
            pixels,
            targets,
            relative,
            noise_px,
        }
    }
}

/// A posterior mean of fewer effective draws says less than the truth does.
const LEAST_SAMPLES: f64 = 4.0;

/// Most principal axes that are kept.
///
/// A pose has six numbers, however many landmarks show it. What lies along the axes of least
/// variance is noise, and without a limit the cost would grow with the square of the landmarks.
pub const MOST_FEATURES: usize = 16;

/// The linear layer in front: pixels to uncorrelated numbers of mean zero and variance one.
#[derive(Clone, Debug, PartialEq)]
pub struct Conditioning {
    /// # Shape
    /// `[2n]`, px
    pub mean_px: DVector<f64>,
    /// # Shape
    /// `[features][2n]`, 1/px
    pub matrix: DMatrix<f64>,
}

impl Conditioning {
    /// Each pixel coordinate by itself.
    pub fn standardizing(pixels: &DMatrix<f64>) -> Self {
        let mean_px = pixels.column_mean();
        let matrix = DMatrix::from_diagonal(&pixels.column_variance().map(|v| 1.0 / v.sqrt()));
        Self { mean_px, matrix }
    }

    /// Along the principal axes of the pixels, the first [`MOST_FEATURES`] of them, without those
    /// along which the pixels differ by less than a deviation: there is nothing to be seen.
    pub fn whitening(pixels: &DMatrix<f64>, least_px: f64) -> Self {
        let mean_px = pixels.column_mean();
        let mut centred = pixels.clone();
        for mut column in centred.column_iter_mut() {
            column -= &mean_px;
        }
        let covariance = &centred * centred.transpose() / pixels.ncols() as f64;
        let axes = SymmetricEigen::new(covariance);
        let mut order: Vec<usize> = (0..axes.eigenvalues.len()).collect();
        order.sort_by(|a, b| axes.eigenvalues[*b].total_cmp(&axes.eigenvalues[*a]));
        order.retain(|i| axes.eigenvalues[*i] > least_px * least_px);
        order.truncate(MOST_FEATURES);
        let matrix = DMatrix::from_fn(order.len(), pixels.nrows(), |i, j| {
            axes.eigenvectors[(j, order[i])] / axes.eigenvalues[order[i]].sqrt()
        });
        Self { mean_px, matrix }
    }

    /// The features of samples.
    ///
    /// # Shape
    /// `[2n][samples]` to `[features][samples]`
    pub fn apply(&self, pixels: &DMatrix<f64>) -> DMatrix<f64> {
        let offset = &self.matrix * &self.mean_px;
        let mut features = &self.matrix * pixels;
        for mut column in features.column_iter_mut() {
            column -= &offset;
        }
        features
    }
}
