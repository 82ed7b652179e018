//! How far answers are from the truth.

use nalgebra::Vector3;
use serde::Serialize;

use crate::frames::{Pose, rodrigues};

/// Errors of an answer, or their means over some answers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PoseError {
    /// `|estimate - truth| / |truth|` of the position, in percent.
    pub position_pct: f64,
    /// `|estimate - truth| / |truth|` of the Rodrigues vector, in percent.
    pub orientation_pct: f64,
    /// Distance, in metres.
    pub position_m: f64,
    /// Angle of the rotation between estimate and truth, in degrees.
    pub orientation_deg: f64,
}

impl PoseError {
    /// The errors of one answer; a relative one is infinite or no number where the truth is zero.
    pub fn between(estimate: &Pose, truth: &Pose) -> Self {
        let relative = |estimate: Vector3<f64>, truth: Vector3<f64>| {
            100.0 * (estimate - truth).norm() / truth.norm()
        };
        let turn = truth.deck_from_body.inverse() * estimate.deck_from_body;
        Self {
            position_pct: relative(estimate.position_m, truth.position_m),
            orientation_pct: relative(estimate.rodrigues_rad(), truth.rodrigues_rad()),
            position_m: (estimate.position_m - truth.position_m).norm(),
            orientation_deg: rodrigues(&turn).norm().to_degrees(),
        }
    }

    /// The same operation on each of the four.
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self {
            position_pct: f(self.position_pct, other.position_pct),
            orientation_pct: f(self.orientation_pct, other.orientation_pct),
            position_m: f(self.position_m, other.position_m),
            orientation_deg: f(self.orientation_deg, other.orientation_deg),
        }
    }
}

/// Errors added up, to be divided by their number.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ErrorSum {
    sum: PoseError,
    count: usize,
}

impl ErrorSum {
    /// Adds the errors of one answer.
    pub fn add(&mut self, error: PoseError) {
        self.sum = self.sum.zip(error, |a, b| a + b);
        self.count += 1;
    }

    /// Adds the errors of other answers.
    pub fn join(&mut self, other: &Self) {
        self.sum = self.sum.zip(other.sum, |a, b| a + b);
        self.count += other.count;
    }

    /// How many answers there were.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Means over the answers, if there were any.
    pub fn mean(&self) -> Option<PoseError> {
        let count = self.count as f64;
        (self.count > 0).then(|| self.sum.zip(self.sum, |sum, _| sum / count))
    }
}

impl Extend<PoseError> for ErrorSum {
    fn extend<I: IntoIterator<Item = PoseError>>(&mut self, errors: I) {
        errors.into_iter().for_each(|error| self.add(error));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose(numbers: [f64; 6]) -> Pose {
        let [x, y, z, rx, ry, rz] = numbers;
        Pose::new(Vector3::new(x, y, z), Vector3::new(rx, ry, rz))
    }

    #[test]
    fn angles_between_rotations() {
        use std::f64::consts::{FRAC_PI_2, TAU};
        let cases = [
            ([0.0; 3], [0.0; 3], 0.0),
            ([0.1, 0.0, 0.0], [0.3, 0.0, 0.0], 0.2),
            ([3.0, 0.0, 0.0], [-3.0, 0.0, 0.0], TAU - 6.0),
            ([0.0, 0.0, 1e-12], [0.0; 3], 1e-12),
            // Two quarter turns about different axes are a third of a turn apart.
            ([FRAC_PI_2, 0.0, 0.0], [0.0, FRAC_PI_2, 0.0], TAU / 3.0),
        ];
        for (a, b, expected) in cases {
            let turned = |[x, y, z]: [f64; 3]| pose([1.0, 0.0, 0.0, x, y, z]);
            for (a, b) in [(a, b), (b, a)] {
                let angle_deg = PoseError::between(&turned(a), &turned(b)).orientation_deg;
                assert!(
                    (angle_deg.to_radians() - expected).abs() < 1e-12,
                    "{a:?} {b:?}"
                );
            }
        }
    }

    #[test]
    fn errors_are_means_of_norms() {
        let truth = pose([-10.0, 0.0, 0.0, 0.0, 0.1, 0.0]);
        let mut sum = ErrorSum::default();
        sum.extend([
            // 0.5 m off at 10 m, and 0.01 rad off at 0.1 rad.
            PoseError::between(&pose([-10.0, 0.3, 0.4, 0.0, 0.11, 0.0]), &truth),
            PoseError::between(&truth, &truth),
        ]);
        let error = sum.mean().unwrap();
        assert!((error.position_m - 0.25).abs() < 1e-12);
        assert!((error.position_pct - 2.5).abs() < 1e-12);
        assert!((error.orientation_pct - 5.0).abs() < 1e-9);
        assert!((error.orientation_deg - 0.005f64.to_degrees()).abs() < 1e-9);
    }

    #[test]
    fn no_answers_have_no_mean() {
        assert_eq!(ErrorSum::default().mean(), None);
    }
}
