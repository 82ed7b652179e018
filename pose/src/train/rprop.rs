//! Resilient propagation: every weight has a step of its own, and only signs of slopes count.

use nalgebra::DVector;

/// Factor of a step whose slope kept its sign.
const GROW: f64 = 1.2;

/// Factor of a step whose slope changed its sign.
const SHRINK: f64 = 0.5;

/// First step.
const FIRST_STEP: f64 = 0.0125;

/// Greatest step.
const MAX_STEP: f64 = 50.0;

/// Least step.
const MIN_STEP: f64 = 1e-6;

/// The state of iRPROP-.
///
/// # Source
/// M. Riedmiller and H. Braun, 1993; the variant without backtracking that forgets a slope after
/// a change of its sign: C. Igel and M. Huesken, 2000 (iRPROP-).
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Rprop {
    steps: Vec<f64>,
    slopes: Vec<f64>,
}

impl Rprop {
    /// Whether this is the state of so many parameters.
    pub fn fits(&self, parameters: usize) -> bool {
        self.steps.len() == parameters && self.slopes.len() == parameters
    }

    /// A fresh start.
    pub fn new(parameters: usize) -> Self {
        Self {
            steps: vec![FIRST_STEP; parameters],
            slopes: vec![0.0; parameters],
        }
    }

    /// Moves the parameters against the signs of their slopes.
    pub fn step(&mut self, parameters: &mut DVector<f64>, gradient: &DVector<f64>) {
        let state = self.steps.iter_mut().zip(&mut self.slopes);
        for ((parameter, slope), (step, last)) in
            parameters.iter_mut().zip(gradient.iter()).zip(state)
        {
            let agreement = slope * *last;
            *last = *slope;
            if agreement > 0.0 {
                *step = (*step * GROW).min(MAX_STEP);
            } else if agreement < 0.0 {
                *step = (*step * SHRINK).max(MIN_STEP);
                *last = 0.0;
            }
            if *last > 0.0 {
                *parameter -= *step;
            } else if *last < 0.0 {
                *parameter += *step;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four steps by hand: down the slope, faster, over the top (shrunk, and no move), and the
    /// first sign after that counts as new (same step).
    #[test]
    fn follows_a_hand_worked_example() {
        let mut rprop = Rprop::new(2);
        let mut at = DVector::from([1.0, -1.0].to_vec());
        rprop.step(&mut at, &DVector::from(vec![3.0, 0.0]));
        assert_eq!(at.as_slice(), [1.0 - 0.0125, -1.0]);
        rprop.step(&mut at, &DVector::from(vec![0.1, -2.0]));
        assert_eq!(at.as_slice(), [1.0 - 0.0125 - 0.015, -1.0 + 0.0125]);
        rprop.step(&mut at, &DVector::from(vec![-0.1, -2.0]));
        assert_eq!(at.as_slice(), [1.0 - 0.0125 - 0.015, -1.0 + 0.0125 + 0.015]);
        rprop.step(&mut at, &DVector::from(vec![-0.1, 0.0]));
        assert_eq!(
            at.as_slice(),
            [1.0 - 0.0125 - 0.015 + 0.0075, -1.0 + 0.0125 + 0.015]
        );
    }
}
