//! What a check has found.

use std::path::PathBuf;

use hwgen_spec::design::Design;
use hwgen_spec::deviation::Deviation;
use serde::Serialize;

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
    /// Seconds of building and replaying, replays that ran side by side added up.
    pub seconds: f64,
}

impl FirstDifference {
    /// One that is not a value, or not yet.
    pub(super) fn at(simulator: &str, segment: &str, design: &Design, path: &str) -> Self {
        Self {
            simulator: simulator.to_owned(),
            segment: segment.to_owned(),
            cycle: 0,
            signal: format!("{}.{path}", design.name()),
            lane: 0,
            network: None,
            layer: None,
            neuron: None,
            input: None,
            model: 0,
            rtl: String::new(),
            model_real: None,
            rtl_real: None,
            note: None,
            window: Vec::new(),
            files: Vec::new(),
        }
    }
}

/// What was driven, in figures.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Stimulus {
    /// Pairs of conditions of a frame that occurred: as malformed and clipped at once.
    pub pairs: usize,
    /// How often the rarest of them occurred.
    pub least_of_a_pair: usize,
    /// Resets, those at the start aside.
    pub resets: usize,
    /// Words of registers that an aimed reset changed: all that one changes at any moment that was
    /// tried.
    pub words_reset: usize,
    /// Segments of the activations' tables that a frame read, and all of them; a search among thousands
    /// of frames found none for the others.
    pub segments_read: usize,
    /// All segments.
    pub segments: usize,
    /// What should have occurred and did not: then nothing is verified.
    pub missing: Vec<String>,
}

/// The comparison of registers and memories with those of the model.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct StructureReport {
    /// False where there is no tool that reads the Verilog.
    pub checked: bool,
    /// The tool and its version.
    pub tool: Option<String>,
    /// Registers of the Verilog, all of which the model has.
    pub registers: usize,
    /// Memories likewise.
    pub memories: usize,
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
    /// What differs, where it is not a value.
    pub note: Option<String>,
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
    /// How far fixed point is from float. It is always measured: registers that are equal say
    /// nothing of it.
    pub error: Deviation,
    /// Rows of the vectors file that lie outside of the box.
    pub rows_outside_box: usize,
    /// Frames with an input outside of the box or a word inside saturated, whatever their class.
    pub frames_saturated: usize,
    /// What was driven.
    pub stimulus: Stimulus,
    /// Registers and memories beside the model's.
    pub structure: StructureReport,
    /// The first difference, if there is one.
    pub first_difference: Option<FirstDifference>,
}
