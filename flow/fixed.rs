//! Networks as the hardware computes them, as an estimator of a scene.

use hwgen_pose::evaluate::{BatchEstimator, Wiring};
use hwgen_pose::frames::Pose;
use hwgen_spec::design::Design;
use hwgen_spec::eval::Batch;

/// A design's integer arithmetic.
#[derive(Clone, Debug)]
pub struct FixedEstimator<'a> {
    design: &'a Design,
    batch: Batch<'a>,
    wiring: &'a Wiring,
}

impl<'a> FixedEstimator<'a> {
    /// The design, wired to a scene.
    pub fn new(design: &'a Design, wiring: &'a Wiring) -> Self {
        Self {
            design,
            batch: Batch::new(design.net()),
            wiring,
        }
    }
}

impl BatchEstimator for FixedEstimator<'_> {
    fn name(&self) -> &'static str {
        "network-fixed"
    }

    fn estimate_all(&self, frames: &[Vec<f64>]) -> Vec<Option<Pose>> {
        let codes: Vec<i64> = frames
            .iter()
            .flat_map(|pixels| self.design.input().codes(&self.wiring.inputs(pixels)))
            .collect();
        let outputs = self.design.sink().words;
        self.batch
            .evaluate(&codes)
            .codes
            .chunks_exact(outputs)
            .map(|codes| self.wiring.pose(&self.design.net().real_outputs(codes)))
            .collect()
    }
}
