//! One layer: its feed, its array, what comes behind the sums.

use hwgen_spec::design::{Feed, Layer};
use hwgen_spec::schedule::{ACTIVATION_LATENCY, MULTIPLIER_LATENCY, ROM_LATENCY};

use super::array::{Array, Drain, Group};
use super::feed::{Beats, Control, Replay};
use super::finish::{Pwl, Requant};
use super::probe::{Probe, within};

/// A beat on a stream inside the stage.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beat<'a> {
    pub(super) valid: bool,
    pub(super) flag: bool,
    pub(super) words: &'a [i64],
}

#[derive(Clone, Debug)]
enum Operands {
    Replay(Replay),
    Direct(Beats),
}

/// `<design>_<layer>`.
#[derive(Clone, Debug)]
pub(super) struct LayerModel {
    name: String,
    x_bits: u32,
    feed: Operands,
    operands: Vec<i64>,
    /// Control bits beside the array.
    control: Delay,
    array: Array,
    group: Option<Group>,
    drain: Option<Drain>,
    requant: Requant,
    /// The activation units and the control bits beside them.
    units: Vec<Pwl>,
    unit_control: Option<Delay>,
    words: Vec<i64>,
}

impl LayerModel {
    pub(super) fn new(layer: &Layer) -> Self {
        let bits = layer.quant.input.width();
        let (simd, synapse_folds) = (layer.fold.simd, layer.synapse_folds());
        let units: Vec<Pwl> = (0..layer.lanes).filter_map(|_| Pwl::new(layer)).collect();
        let drains = layer.drain_beats() > 1;
        Self {
            name: layer.quant.name.clone(),
            x_bits: bits,
            feed: match layer.feed {
                Feed::Replay => {
                    Operands::Replay(Replay::new(simd, synapse_folds, layer.neuron_folds(), bits))
                }
                Feed::Direct => Operands::Direct(Beats::new(synapse_folds)),
            },
            operands: vec![0; simd],
            control: Delay::new(
                if layer.accumulates() { 4 } else { 2 },
                ROM_LATENCY + MULTIPLIER_LATENCY + layer.tree_levels(),
            ),
            array: Array::new(layer),
            group: layer.accumulates().then(Group::default),
            drain: drains.then(|| Drain::new(layer.fold.pe, layer.lanes, layer.quant.sum_width)),
            requant: Requant::new(layer),
            unit_control: (!units.is_empty()).then(|| Delay::new(2, ACTIVATION_LATENCY)),
            units,
            words: vec![0; layer.lanes],
        }
    }

    /// What stands at the layer's output.
    pub(super) fn beat(&self) -> Beat<'_> {
        match self.unit_control.as_ref().map(Delay::code) {
            Some(control) => Beat {
                valid: control & 2 != 0,
                flag: control & 1 != 0,
                words: &self.words,
            },
            None => Beat {
                valid: self.requant.valid(),
                flag: self.requant.flag(),
                words: self.requant.words(),
            },
        }
    }

    /// `input`: the whole vector with its start bit, or the beat of the layer in front.
    pub(super) fn step(&mut self, reset: bool, input: Beat<'_>) {
        // From the foot to the head, so that every cell still sees its neighbour of before.
        if let Some(control) = &mut self.unit_control {
            let code = u64::from(self.requant.valid()) << 1 | u64::from(self.requant.flag());
            control.step(reset, code);
            for ((unit, z), word) in self
                .units
                .iter_mut()
                .zip(self.requant.words())
                .zip(&mut self.words)
            {
                unit.step(*z);
                *word = unit.word();
            }
        }

        let foot = self.control.code();
        let at_foot = match &self.group {
            Some(_) => Control {
                valid: foot & 8 != 0,
                first: foot & 4 != 0,
                last: foot & 2 != 0,
                flag: foot & 1 != 0,
            },
            None => Control {
                valid: foot & 2 != 0,
                first: true,
                last: true,
                flag: foot & 1 != 0,
            },
        };
        let (done, done_flag) = match &self.group {
            Some(group) => (group.done, group.flag),
            None => (at_foot.valid, at_foot.flag),
        };
        match &mut self.drain {
            Some(drain) => {
                self.requant
                    .step(reset, drain.valid(), drain.flag(), drain.words());
                drain.step(reset, done, done_flag, self.array.sums());
            }
            None => self.requant.step(reset, done, done_flag, self.array.sums()),
        }
        if let Some(group) = &mut self.group {
            group.step(reset, at_foot);
        }

        let (control, address) = match &self.feed {
            Operands::Replay(replay) => (replay.control(), replay.address()),
            Operands::Direct(beats) => (beats.control(input.valid, input.flag), beats.address()),
        };
        self.array
            .step(&self.operands, address, at_foot.valid, at_foot.first);
        let code = if self.group.is_some() {
            u64::from(control.valid) << 3
                | u64::from(control.first) << 2
                | u64::from(control.last) << 1
                | u64::from(control.flag)
        } else {
            u64::from(control.valid) << 1 | u64::from(control.flag)
        };
        self.control.step(reset, code);
        match &mut self.feed {
            Operands::Replay(replay) => {
                self.operands.copy_from_slice(replay.words());
                replay.step(reset, input.valid, input.flag, input.words);
            }
            Operands::Direct(beats) => {
                self.operands.copy_from_slice(input.words);
                beats.step(reset, input.valid);
            }
        }
    }

    pub(super) fn show<P: Probe>(&self, probe: &mut P) {
        within(probe, format_args!("u_{}", self.name), |probe| {
            match &self.feed {
                Operands::Replay(replay) => {
                    within(probe, format_args!("u_replay"), |p| replay.show(p));
                }
                Operands::Direct(beats) => {
                    within(probe, format_args!("u_beats"), |p| beats.show(p));
                }
            }
            probe.words("operands_q", self.x_bits, &self.operands);
            within(probe, format_args!("u_control"), |p| self.control.show(p));
            self.array.show(probe);
            if let Some(group) = &self.group {
                within(probe, format_args!("u_group"), |p| group.show(p));
            }
            if let Some(drain) = &self.drain {
                within(probe, format_args!("u_drain"), |p| drain.show(p));
            }
            self.requant.show(probe);
            if let Some(control) = &self.unit_control {
                within(probe, format_args!("u_act_control"), |p| control.show(p));
            }
            for (i, unit) in self.units.iter().enumerate() {
                within(probe, format_args!("g_act[{i}]"), |p| unit.show(p));
            }
        });
    }
}

/// `hwg_delay`: control bits on their way, the newest in the lowest bits.
#[derive(Clone, Debug)]
struct Delay {
    width: u32,
    depth: u32,
    pipe: u64,
}

impl Delay {
    /// At most 4 bits for 15 clocks: an array of the widest layer.
    fn new(width: u32, depth: usize) -> Self {
        let depth = u32::try_from(depth).expect("a small number");
        assert!(width * depth <= 64, "{width} bits for {depth} clocks");
        Self {
            width,
            depth,
            pipe: 0,
        }
    }

    /// What comes out.
    fn code(&self) -> u64 {
        self.pipe >> (self.width * (self.depth - 1))
    }

    fn step(&mut self, reset: bool, code: u64) {
        let all = u64::MAX >> (64 - self.width * self.depth);
        self.pipe = if reset {
            0
        } else {
            (self.pipe << self.width | code) & all
        };
    }

    fn show<P: Probe>(&self, probe: &mut P) {
        let mask = (1 << self.width) - 1;
        let codes = (0..self.depth).map(|i| (self.pipe >> (i * self.width) & mask).cast_signed());
        probe.words("pipe_q", self.width, &codes.collect::<Vec<_>>());
    }
}
