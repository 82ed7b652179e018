//! The three-way check of a bundle: untimed values, cycle model, simulators.

use std::path::PathBuf;
use std::time::Duration;

use hwgen_spec::design::Design;
use hwgen_spec::network::FloatNet;
use serde::Serialize;

use crate::error::SimError;
use crate::simulator::Simulator;
use crate::tool::Toolbox;

/// What is to be checked, with what.
pub struct VerifyPlan<'a> {
    /// Directory of the bundle.
    pub bundle: PathBuf,
    /// Verilog files of the core, below the bundle's directory.
    pub sources: Vec<String>,
    /// The design that the bundle states.
    pub design: &'a Design,
    /// The float reference.
    pub net: &'a FloatNet,
    /// Rows of raw inputs in the order of the design's inputs, empty for none.
    pub vectors: Vec<Vec<f64>>,
    /// Number of random frames in the box.
    pub random: usize,
    /// Seed of random frames, gaps and back-pressure.
    pub seed: u64,
    /// The simulators, at least one.
    pub simulators: Vec<Simulator>,
    /// Where tools are found.
    pub toolbox: &'a Toolbox,
    /// Where logs, stimuli and, after a difference, dumps are left; emptied first.
    pub work_dir: PathBuf,
    /// Where simulator builds are kept.
    pub cache_dir: PathBuf,
    /// How long a build or a replay may take.
    pub timeout: Duration,
}

/// What the check is doing.
#[derive(Clone, Debug)]
pub struct Progress {
    /// In words: `verilator: building`, `icarus: random x back-pressure`.
    pub activity: String,
    /// Steps done.
    pub done: usize,
    /// Steps in all.
    pub total: usize,
}

/// What was promised and what was seen.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Cycles {
    /// By the design.
    pub stated: usize,
    /// At the pins; `None` if nothing could be measured.
    pub measured: Option<usize>,
}

/// The verdict on one simulator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Every register at every edge.
    Equal,
    /// There is a first difference.
    Differs,
}

/// One simulator's part.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SimulatorRun {
    /// `icarus` or `verilator`.
    pub simulator: String,
    /// Its version.
    pub version: String,
    /// Frames whose outputs were compared.
    pub frames: usize,
    /// Rising edges compared.
    pub edges: usize,
    /// Registers compared at each edge.
    pub registers: usize,
    /// Words compared, over all edges.
    pub values_compared: u64,
    /// Equal or not.
    pub verdict: Verdict,
    /// Seconds of building and replaying.
    pub seconds: f64,
}

/// Error of the fixed-point outputs against the float network, over frames inside the box.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OutputError {
    /// `<network>.<output>`
    pub output: String,
    /// Unit of the numbers below.
    pub unit: String,
    /// Greatest absolute error.
    pub max: f64,
    /// Root of the mean square error.
    pub rms: f64,
}

/// Where a simulator parts from the model, or the model from the untimed values.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FirstDifference {
    /// `icarus`, `verilator`, or `model` where the model itself parts from the untimed values.
    pub simulator: String,
    /// The stimulus that showed it, such as `random x back-pressure`.
    pub segment: String,
    /// Rising edge of that stimulus, from 0.
    pub cycle: usize,
    /// Path of the signal from the top module.
    pub signal: String,
    /// Lane of the signal, lowest first.
    pub lane: usize,
    /// Network, if the signal belongs to one.
    pub network: Option<String>,
    /// Layer, if the signal belongs to one.
    pub layer: Option<String>,
    /// Neuron whose value it is, where that can be told.
    pub neuron: Option<usize>,
    /// Input whose weight or operand it is, where that can be told.
    pub input: Option<usize>,
    /// The model's code.
    pub model: i64,
    /// The simulator's code, or its bits if some are unknown.
    pub rtl: String,
    /// The model's value in real units, where the register has a format.
    pub model_real: Option<f64>,
    /// The simulator's value in real units.
    pub rtl_real: Option<f64>,
    /// Values around the first difference, a line a cycle.
    pub window: Vec<String>,
    /// The simulator's dump, the model's, and a GTKWave save file that shows both.
    pub files: Vec<PathBuf>,
}

/// The outcome of a check.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// True if everything was compared and equal.
    pub verified: bool,
    /// One entry a simulator.
    pub runs: Vec<SimulatorRun>,
    /// Latency.
    pub latency_cycles: Cycles,
    /// Interval.
    pub interval_cycles: Cycles,
    /// One entry an output.
    pub error_vs_float: Vec<OutputError>,
    /// Rows of the vectors file that lie outside of the box.
    pub rows_outside_box: usize,
    /// Frames in which a word inside was saturated.
    pub frames_saturated: usize,
    /// The first difference, if there is one.
    pub first_difference: Option<FirstDifference>,
}

/// Checks a bundle.
///
/// # Errors
/// [`SimError`] if nothing can be said: a tool is missing, failed, or printed no verdict.
pub fn verify(
    plan: &VerifyPlan<'_>,
    progress: &mut dyn FnMut(Progress),
) -> Result<Report, SimError> {
    let _ = (plan, progress);
    todo!()
}
