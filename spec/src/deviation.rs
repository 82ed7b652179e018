//! How far the outputs in fixed point are from those of the float network.
//!
//! The error alone says little: a millimetre is much for an output that moves by a centimetre. It is
//! stated beside the standard deviation of the float output over the same frames, its spread.
//!
//! ```
//! use hwgen_spec::{design::Design, deviation::{self, FrameSource}, options::Options, weights};
//! let file = br#"{"format": "hwgen-weights/1", "name": "sum",
//!   "inputs": {"min": [-1, -1], "max": [1, 1]},
//!   "networks": [{"name": "add", "layers": [
//!     {"activation": "linear", "weights": [[0.5, 0.25]]}]}]}"#;
//! let net = weights::read(file)?;
//! let design = Design::new(&net, &Options::default())?;
//! let found = deviation::measure(&design, &net, &[]);
//! assert_eq!(found.source, FrameSource::Box);
//! assert!(found.outputs[0].rms_over_spread.is_some_and(|share| share < 0.01));
//! assert_eq!(found.within(0.01), None);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use crate::design::Design;
use crate::eval::Batch;
use crate::network::{FloatNet, Inputs};

/// Points of the box, where there are no other frames.
const BOX_FRAMES: usize = 1000;

/// Their seed: a design has the same error wherever it is asked for.
const BOX_SEED: u64 = 1;

/// Frames evaluated at once.
const BLOCK: usize = 1024;

/// A spread below this part of the greatest value is what rounding of doubles leaves of a constant.
const LEAST_SPREAD: f64 = 1e-12;

/// Where frames come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum FrameSource {
    /// A file of frames that the user gave.
    Vectors,
    /// The weights file.
    Calibration,
    /// Independent points of the input box. Real inputs that go together fill a small part of it,
    /// so that neither a small nor a large error says what theirs will be.
    Box,
}

/// The error of every output over some frames, the rounding of the inputs included.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Deviation {
    /// Number of frames, at least one.
    pub frames: usize,
    /// Where they come from.
    pub source: FrameSource,
    /// Frames with an input outside of the box: the core clips it, the float network does not, and
    /// the error holds the difference.
    pub clipped_frames: usize,
    /// One entry an output, in stream order.
    pub outputs: Vec<OutputDeviation>,
}

/// The error of one output.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OutputDeviation {
    /// `<network>.<output>`
    pub output: String,
    /// Unit of `rms` and `max`.
    pub unit: String,
    /// Root of the mean square error.
    pub rms: f64,
    /// Greatest absolute error.
    pub max: f64,
    /// `rms` over the standard deviation of the float output over the same frames. `None` if that
    /// is zero, as it is for a constant output and for a single frame: then no error is a share of
    /// it.
    pub rms_over_spread: Option<f64>,
}

impl OutputDeviation {
    /// Whether there is an error that is no share of a spread.
    pub fn has_no_share(&self) -> bool {
        self.rms_over_spread.is_none() && self.rms != 0.0
    }
}

impl Deviation {
    /// The greatest error as a share of its output's spread, if an output has a spread.
    pub fn greatest_share(&self) -> Option<f64> {
        let shares = self.outputs.iter().filter_map(|o| o.rms_over_spread);
        shares.max_by(f64::total_cmp)
    }

    /// Whether every error is at most this share of its output's spread.
    ///
    /// `None` if that can't be told: points of the box stand for no real inputs, one frame has no
    /// spread, and the error of a constant output is no share of one.
    pub fn within(&self, tolerance: f64) -> Option<bool> {
        if self.source == FrameSource::Box || self.frames < 2 {
            return None;
        }
        if self.greatest_share().is_some_and(|share| share > tolerance) {
            return Some(false);
        }
        let told = !self.outputs.iter().any(OutputDeviation::has_no_share);
        told.then_some(true)
    }
}

/// The error over the vectors, else over the calibration of the weights file, else over points of
/// the box.
pub fn measure(design: &Design, net: &FloatNet, vectors: &[Vec<f64>]) -> Deviation {
    match &net.calibration {
        _ if !vectors.is_empty() => over(design, net, vectors, FrameSource::Vectors),
        Some(calibration) => over(design, net, &calibration.inputs, FrameSource::Calibration),
        None => over(design, net, &points(&net.inputs), FrameSource::Box),
    }
}

/// The error over frames of raw inputs.
///
/// # Shape
/// `frames`: `[frames][in]`
///
/// # Panics
/// If there is no frame: an error that was not measured is not zero.
pub fn over(
    design: &Design,
    net: &FloatNet,
    frames: &[Vec<f64>],
    source: FrameSource,
) -> Deviation {
    assert!(!frames.is_empty(), "an error is that of a frame");
    let columns = net.output_columns();
    let mut sums = vec![Sum::default(); columns.len()];
    let batch = Batch::new(design.net());
    for block in frames.chunks(BLOCK) {
        let codes: Vec<i64> = block
            .iter()
            .flat_map(|row| design.input().codes(row))
            .collect();
        let answers = batch.evaluate(&codes).codes;
        for (row, codes) in block.iter().zip(answers.chunks_exact(columns.len())) {
            let fixed = design.net().real_outputs(codes);
            let float = net.forward(row);
            for (sum, (fixed, float)) in sums.iter_mut().zip(fixed.into_iter().zip(float)) {
                sum.add(fixed, float);
            }
        }
    }
    let networks = net.networks.iter();
    let units = networks.flat_map(|n| n.outputs.names.iter().map(|_| n.outputs.unit.clone()));
    let outside = |row: &&Vec<f64>| design.input().outside(row);
    Deviation {
        frames: frames.len(),
        source,
        clipped_frames: frames.iter().filter(outside).count(),
        outputs: columns
            .into_iter()
            .zip(units)
            .zip(sums)
            .map(|((output, unit), sum)| sum.finish(output, unit))
            .collect(),
    }
}

/// Independent points of the box: real numbers and no codes, which would be rounded already.
fn points(inputs: &Inputs) -> Vec<Vec<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(BOX_SEED);
    let mut point = || {
        let edges = inputs.min.iter().zip(&inputs.max);
        edges
            .map(|(min, max)| {
                let part: f64 = rng.random();
                (min * (1.0 - part) + max * part).clamp(*min, *max)
            })
            .collect()
    };
    (0..BOX_FRAMES).map(|_| point()).collect()
}

/// Moments of one output: those of the float values by Welford's recurrence, which bears a mean far
/// from zero.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    frames: f64,
    error_squares: f64,
    error_max: f64,
    mean: f64,
    squares: f64,
    greatest: f64,
}

impl Sum {
    fn add(&mut self, fixed: f64, float: f64) {
        self.frames += 1.0;
        let error = fixed - float;
        self.error_squares += error * error;
        self.error_max = self.error_max.max(error.abs());
        let step = float - self.mean;
        self.mean += step / self.frames;
        self.squares += step * (float - self.mean);
        self.greatest = self.greatest.max(float.abs());
    }

    fn finish(self, output: String, unit: String) -> OutputDeviation {
        let rms = (self.error_squares / self.frames).sqrt();
        let spread = (self.squares / self.frames).sqrt();
        let share = (spread > LEAST_SPREAD * self.greatest).then(|| rms / spread);
        OutputDeviation {
            output,
            unit,
            rms,
            max: self.error_max,
            rms_over_spread: share.filter(|share| share.is_finite()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::Options;
    use crate::weights;

    fn sums(pairs: &[(f64, f64)]) -> OutputDeviation {
        let mut sum = Sum::default();
        pairs
            .iter()
            .for_each(|(fixed, float)| sum.add(*fixed, *float));
        sum.finish("n.o".into(), "m".into())
    }

    fn deviation(source: FrameSource, outputs: Vec<OutputDeviation>) -> Deviation {
        Deviation {
            frames: 2,
            source,
            clipped_frames: 0,
            outputs,
        }
    }

    #[test]
    fn moments_are_those_of_the_definition() {
        // Errors 0.3 and -0.4, float values 10 and 14: spread 2.
        let found = sums(&[(10.3, 10.0), (13.6, 14.0)]);
        let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
        assert!(near(found.rms, (0.25f64 / 2.0).sqrt()), "{found:?}");
        assert!(near(found.max, 0.4), "{found:?}");
        let share = found.rms_over_spread.expect("a share");
        assert!(near(share, found.rms / 2.0), "{found:?}");
        // A mean far from zero takes nothing of the spread.
        let far = sums(&[(1e9, 1e9), (1e9 + 2.0, 1e9 + 2.0), (1e9, 1e9 + 1.0)]);
        let spread = far.rms / far.rms_over_spread.expect("a share");
        assert!(near(spread, (2.0f64 / 3.0).sqrt()), "{spread}");
    }

    #[test]
    fn an_error_without_a_spread_is_no_share_of_it() {
        let constant = sums(&[(1.5, 1.0), (1.5, 1.0 + 1e-15), (1.5, 1.0)]);
        assert_eq!(constant.rms_over_spread, None);
        assert!(constant.has_no_share() && constant.rms > 0.49);
        let exact = sums(&[(1.0, 1.0), (1.0, 1.0)]);
        assert!(exact.rms_over_spread.is_none() && !exact.has_no_share());
        assert!(sums(&[(0.5, 1.0)]).has_no_share());
        assert!(sums(&[(f64::NAN, 1.0), (0.0, 2.0)]).has_no_share());
    }

    #[test]
    fn what_cannot_be_told_is_neither_missed_nor_met() {
        let small = || sums(&[(0.0, 0.001), (1.0, 1.0)]);
        let large = || sums(&[(0.0, 0.1), (1.0, 1.0)]);
        let constant = || sums(&[(0.1, 0.0), (0.0, 0.0)]);
        let exact = || sums(&[(7.0, 7.0), (7.0, 7.0)]);
        for source in [FrameSource::Vectors, FrameSource::Calibration] {
            let within = |outputs| deviation(source, outputs).within(0.01);
            assert_eq!(within(vec![small(), exact()]), Some(true));
            assert_eq!(within(vec![small(), large()]), Some(false));
            assert_eq!(within(vec![small(), constant()]), None);
            assert_eq!(within(vec![constant(), large()]), Some(false));
        }
        let points = deviation(FrameSource::Box, vec![large()]);
        assert_eq!(points.within(0.01), None);
        let mut one = deviation(FrameSource::Vectors, vec![exact()]);
        one.frames = 1;
        assert_eq!(one.within(0.01), None);
    }

    #[test]
    fn frames_beyond_the_box_are_counted_and_measured() {
        let text = br#"{"format": "hwgen-weights/1", "name": "same",
            "inputs": {"min": [-1], "max": [1], "resolution": 0.25},
            "networks": [{"name": "n", "layers": [{"activation": "linear", "weights": [[1]]}]}],
            "calibration": {"inputs": [[0.5], [-0.5], [0.5], [3]]}}"#;
        let net = weights::read(text).expect("weights");
        let design = Design::new(&net, &Options::default()).expect("a design");
        let found = measure(&design, &net, &[]);
        assert_eq!(found.source, FrameSource::Calibration);
        assert_eq!((found.frames, found.clipped_frames), (4, 1));
        // The core answers 1 where the float network answers 3.
        assert!((found.outputs[0].max - 2.0).abs() < 1e-3, "{found:?}");
        assert!((found.outputs[0].rms - 1.0).abs() < 1e-3, "{found:?}");
        let vectors = measure(&design, &net, &[vec![0.5], vec![0.25]]);
        assert_eq!(vectors.source, FrameSource::Vectors);
        assert_eq!((vectors.frames, vectors.clipped_frames), (2, 0));

        // Points of the box are real numbers: the error holds the rounding of the inputs.
        let net = FloatNet {
            calibration: None,
            ..net
        };
        let found = measure(&design, &net, &[]);
        assert_eq!((found.source, found.frames), (FrameSource::Box, BOX_FRAMES));
        assert_eq!(found.clipped_frames, 0);
        let greatest = found.outputs[0].max;
        assert!((0.12..=0.126).contains(&greatest), "{greatest}");
        assert_eq!(measure(&design, &net, &[]), found);
    }
}
