//! Errors of pose estimates against the truth.

use serde::Serialize;

/// Position and orientation, three numbers each.
pub type Pose = [f64; 6];

/// Mean errors of an estimator over some poses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PoseError {
    /// Mean of |estimate - truth| / |truth| of the position, in percent.
    pub position_pct: f64,
    /// Mean of |estimate - truth| / |truth| of the rotation vector, in percent.
    pub orientation_pct: f64,
    /// Mean distance, in metres.
    pub position_m: f64,
    /// Mean angle of the rotation between estimate and truth, in degrees.
    pub orientation_deg: f64,
}

/// Mean errors of pairs of estimate and truth.
pub fn mean_error<'a>(pairs: impl Iterator<Item = (&'a Pose, &'a Pose)>) -> PoseError {
    let mut sum = PoseError::default();
    let mut count = 0.0;
    for (estimate, truth) in pairs {
        let part = |pose: &Pose, from: usize| [pose[from], pose[from + 1], pose[from + 2]];
        let distance = |from| norm(difference(part(estimate, from), part(truth, from)));
        sum.position_m += distance(0);
        sum.position_pct += 100.0 * distance(0) / norm(part(truth, 0));
        sum.orientation_pct += 100.0 * distance(3) / norm(part(truth, 3));
        sum.orientation_deg += angle_between(part(estimate, 3), part(truth, 3)).to_degrees();
        count += 1.0;
    }
    PoseError {
        position_pct: sum.position_pct / count,
        orientation_pct: sum.orientation_pct / count,
        position_m: sum.position_m / count,
        orientation_deg: sum.orientation_deg / count,
    }
}

/// Geodesic angle in radians between the rotations of two rotation vectors (axis times angle).
pub fn angle_between(a: [f64; 3], b: [f64; 3]) -> f64 {
    let (wa, va) = quaternion(a);
    let (wb, vb) = quaternion(b);
    // conj(a) * b
    let w = wa * wb + dot(va, vb);
    let cross = [
        va[1] * vb[2] - va[2] * vb[1],
        va[2] * vb[0] - va[0] * vb[2],
        va[0] * vb[1] - va[1] * vb[0],
    ];
    let v: [f64; 3] = std::array::from_fn(|i| wa * vb[i] - wb * va[i] - cross[i]);
    2.0 * norm(v).atan2(w.abs())
}

fn quaternion(r: [f64; 3]) -> (f64, [f64; 3]) {
    let angle = norm(r);
    let factor = if angle < 1e-9 {
        0.5
    } else {
        (angle / 2.0).sin() / angle
    };
    ((angle / 2.0).cos(), r.map(|x| x * factor))
}

fn difference(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn norm(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_between_rotations() {
        let cases = [
            ([0.0; 3], [0.0; 3], 0.0),
            ([0.1, 0.0, 0.0], [0.3, 0.0, 0.0], 0.2),
            (
                [3.0, 0.0, 0.0],
                [-3.0, 0.0, 0.0],
                std::f64::consts::TAU - 6.0,
            ),
            ([0.0, 0.0, 1e-12], [0.0; 3], 1e-12),
            // Two quarter turns about different axes are a third of a turn apart.
            (
                [std::f64::consts::FRAC_PI_2, 0.0, 0.0],
                [0.0, std::f64::consts::FRAC_PI_2, 0.0],
                std::f64::consts::TAU / 3.0,
            ),
        ];
        for (a, b, expected) in cases {
            assert!(
                (angle_between(a, b) - expected).abs() < 1e-12,
                "{a:?} {b:?}"
            );
            assert!(
                (angle_between(b, a) - expected).abs() < 1e-12,
                "{a:?} {b:?}"
            );
        }
    }

    #[test]
    fn errors_are_means_of_norms() {
        let truth: Pose = [-10.0, 0.0, 0.0, 0.0, 0.1, 0.0];
        let estimates = [
            [-10.0, 0.3, 0.4, 0.0, 0.11, 0.0],
            [-10.0, 0.0, 0.0, 0.0, 0.1, 0.0],
        ];
        let error = mean_error(estimates.iter().map(|e| (e, &truth)));
        assert!((error.position_m - 0.25).abs() < 1e-12);
        assert!((error.position_pct - 2.5).abs() < 1e-12);
        assert!((error.orientation_pct - 5.0).abs() < 1e-9);
        assert!((error.orientation_deg - 0.005f64.to_degrees()).abs() < 1e-9);
    }
}
