//! The cycle-accurate model: every architectural register a field, one step a rising edge.
//!
//! It is written from the contract (`docs/microarchitecture.md`), not from the generator, and
//! agrees with the RTL in every register after every edge, from power-up on, at which all
//! registers are zero but for the copies of the reset.

mod adders;
mod array;
mod feed;
mod finish;
mod layer;
mod probe;
mod stage;
mod stream;

use std::fmt::{self, Write as _};

use hwgen_spec::design::Design;

use crate::record::Register;
use probe::{Probe, within};
use stage::{Entry, StageModel};
use stream::{Egress, Ingress};

/// The input pins in one clock, sampled by its rising edge.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pins {
    /// `aresetn`: false resets.
    pub reset_n: bool,
    /// `s_axis_tvalid`
    pub s_valid: bool,
    /// `s_axis_tlast`
    pub s_last: bool,
    /// `s_axis_tdata`, one code a lane.
    pub s_data: Vec<i64>,
    /// `m_axis_tready`
    pub m_ready: bool,
}

impl Pins {
    /// Reset is released, nothing is offered, outputs are taken.
    pub fn idle(design: &Design) -> Self {
        Self {
            reset_n: true,
            s_valid: false,
            s_last: false,
            s_data: vec![0; design.source().words_per_beat],
            m_ready: true,
        }
    }
}

/// A beat at `m_axis` while `m_axis_tvalid` is high.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutputBeat<'a> {
    /// One code a lane.
    pub data: &'a [i64],
    /// `m_axis_tuser`: bit 0 saturated, bit 1 frame error.
    pub user: i64,
    /// `m_axis_tlast`
    pub last: bool,
}

/// The core.
///
/// ```
/// use hwgen_sim::model::{Model, Pins};
/// use hwgen_spec::{design::Design, options::Options, weights};
/// let net = weights::read(br#"{"format": "hwgen-weights/1", "name": "tiny",
///   "inputs": {"min": [-1], "max": [1]},
///   "networks": [{"name": "net", "layers": [
///     {"activation": "linear", "weights": [[0.5]]}]}]}"#)?;
/// let design = Design::new(&net, &Options::default())?;
/// let mut core = Model::new(&design);
/// let mut pins = Pins::idle(&design);
/// while !core.ready() {
///     core.step(&pins); // in reset from power-up on, for two clocks
/// }
/// (pins.s_valid, pins.s_last, pins.s_data) = (true, true, design.input().codes(&[0.5]));
/// core.step(&pins);
/// pins.s_valid = false;
/// let mut clocks = 1;
/// while core.output().is_none() {
///     core.step(&pins);
///     clocks += 1;
/// }
/// assert_eq!(clocks, design.latency_cycles());
/// assert_eq!(design.net().real_outputs(core.output().unwrap().data), [0.25]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Model {
    /// `rst_nq`, low, and its copies `rst_q2`, high: the reset on its way.
    resets: [bool; 2],
    ingress: Ingress,
    stage: StageModel,
    egress: Egress,
}

impl Model {
    /// The core as it is after power-up.
    pub fn new(design: &Design) -> Self {
        let (source, sink) = (design.source(), design.sink());
        Self {
            resets: [true; 2],
            ingress: Ingress::new(design.input(), source.words_per_beat, source.lane_bits),
            stage: StageModel::new(design.perceptron(), design.schedule(), design.device()),
            egress: Egress::new(sink, design.sink_is_eager()),
        }
    }

    /// The same core, had no reset been on its way.
    pub fn without_reset(&self) -> Self {
        Self {
            resets: [false; 2],
            ..self.clone()
        }
    }

    /// `s_axis_tready`
    pub fn ready(&self) -> bool {
        self.ingress.ready()
    }

    /// The beat at `m_axis`, if `m_axis_tvalid` is high.
    pub fn output(&self) -> Option<OutputBeat<'_>> {
        self.egress
            .beat()
            .map(|(data, user, last)| OutputBeat { data, user, last })
    }

    /// One rising edge of `aclk`.
    pub fn step(&mut self, pins: &Pins) {
        let [first, reset] = self.resets;
        self.resets = [!pins.reset_n, first];
        let resets = (reset, !pins.reset_n || first);
        let leaves = self.leaves();
        let frame_ready = self.stage.ready();
        let user = if leaves { self.stage.user() } else { 0 };
        let stage = &self.stage;
        self.egress
            .step(resets, leaves, user, pins.m_ready, |words| {
                stage.answer(words)
            });
        let entry = Entry {
            valid: self.ingress.full(),
            words: self.ingress.words(),
            clipped: self.ingress.clipped(),
            error: self.ingress.error(),
        };
        self.stage.step(reset, entry, leaves);
        self.ingress.step(
            resets,
            (pins.s_valid, pins.s_last, &pins.s_data),
            frame_ready,
        );
    }

    /// Whether an answer goes from the stage to the egress in this clock.
    fn leaves(&self) -> bool {
        self.stage.valid() && self.egress.ready()
    }

    /// Names and widths of all registers, in the order of [`values`](Self::values).
    ///
    /// The output ports of the core stand behind its registers: they come out of registers, so
    /// that they too have one value after each edge.
    pub fn registers(&self) -> Vec<Register> {
        self.names().registers
    }

    /// Registers that the Verilog may have besides, inside multipliers: their values are not modelled,
    /// the result that they lead to is.
    pub fn interior(&self) -> Vec<Register> {
        self.names().interior
    }

    fn names(&self) -> Names {
        let mut names = Names {
            path: String::new(),
            ends: Vec::new(),
            registers: Vec::new(),
            interior: Vec::new(),
        };
        self.show(&mut names);
        names
    }

    /// Appends the values of all registers, lane by lane.
    pub fn values(&self, row: &mut Vec<i64>) {
        self.show(&mut Values(row));
    }

    fn show<P: Probe>(&self, probe: &mut P) {
        let [first, reset] = self.resets;
        probe.bit("rst_nq", !first);
        probe.bit("ingress_rst_q2", reset);
        probe.bit("egress_rst_q2", reset);
        within(probe, format_args!("u_ingress"), |p| {
            self.ingress.show(self.stage.ready(), p);
        });
        // The core decides a clock ahead and keeps the decision in registers.
        let (starts, leaves) = (self.ingress.full() && self.stage.ready(), self.leaves());
        within(probe, format_args!("u_mlp"), |p| {
            self.stage.show(reset, starts, leaves, p)
        });
        within(probe, format_args!("u_egress"), |p| {
            self.egress.show(leaves, p)
        });
        // The ports last: where a register differs too, it is the one to be named.
        probe.bit("s_axis_tready", self.ingress.ready());
        self.egress.show_port(probe);
    }
}

struct Names {
    path: String,
    ends: Vec<usize>,
    registers: Vec<Register>,
    interior: Vec<Register>,
}

impl Probe for Names {
    fn enter(&mut self, scope: fmt::Arguments<'_>) {
        self.ends.push(self.path.len());
        write!(self.path, "{scope}.").expect("a string takes all");
    }

    fn leave(&mut self) {
        self.path.truncate(self.ends.pop().expect("entered before"));
    }

    #[inline]
    fn words(&mut self, name: &str, bits: u32, values: &[i64]) {
        self.fields(name, &vec![bits; values.len()], values);
    }

    fn interior(&mut self, name: &str, bits: u32) {
        let path = format!("{}{name}", self.path);
        self.interior.push(Register::uniform(path, bits, 1));
    }

    fn fields(&mut self, name: &str, bits: &[u32], _: &[i64]) {
        self.registers.push(Register {
            path: format!("{}{name}", self.path),
            lanes: bits.to_vec(),
        });
    }
}

struct Values<'a>(&'a mut Vec<i64>);

impl Probe for Values<'_> {
    fn enter(&mut self, _: fmt::Arguments<'_>) {}

    fn leave(&mut self) {}

    #[inline]
    fn words(&mut self, _: &str, _: u32, values: &[i64]) {
        self.0.extend_from_slice(values);
    }

    fn fields(&mut self, _: &str, _: &[u32], values: &[i64]) {
        self.0.extend_from_slice(values);
    }
}
