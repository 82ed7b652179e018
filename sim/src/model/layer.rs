//! One layer: its feed, its array, what comes behind the sums.

use hwgen_spec::design::{Feed, Layer};
use hwgen_spec::device::Device;
use hwgen_spec::schedule::{ACTIVATION_LATENCY, control_depth};

use super::array::{Array, Drain, Group, real};
use super::feed::{Beats, Control, Hold, Replay};
use super::finish::{Requant, Units};
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
    Hold(Hold),
}

/// `<design>_<layer>`.
#[derive(Clone, Debug)]
pub(super) struct LayerModel {
    name: String,
    feed: Operands,
    /// Control bits beside the array.
    control: Delay,
    array: Array,
    group: Option<Group>,
    drain: Option<Drain>,
    requant: Requant,
    /// The activation units and the control bits beside them.
    units: Option<(Units, Delay)>,
}

impl LayerModel {
    pub(super) fn new(layer: &Layer, device: &Device) -> Self {
        let bits = layer.quant.input.width();
        let (simd, synapse_folds) = (layer.fold.simd, layer.synapse_folds());
        let drains = layer.drain_beats() > 1;
        Self {
            name: layer.quant.name.clone(),
            feed: match layer.feed {
                Feed::Replay => {
                    Operands::Replay(Replay::new(simd, synapse_folds, layer.neuron_folds(), bits))
                }
                Feed::Direct => Operands::Direct(Beats::new(synapse_folds)),
                Feed::Hold => {
                    Operands::Hold(Hold::new(simd, synapse_folds, layer.neuron_folds(), bits))
                }
            },
            control: Delay::new(
                if layer.accumulates() { 4 } else { 2 },
                control_depth(layer),
            ),
            array: Array::new(layer, device),
            group: layer.accumulates().then(Group::default),
            drain: drains.then(|| Drain::new(layer.fold.pe, layer.lanes, layer.quant.sum_width)),
            requant: Requant::new(layer, device),
            units: Units::new(layer, device)
                .map(|units| (units, Delay::new(2, ACTIVATION_LATENCY))),
        }
    }

    /// What stands at the layer's output.
    #[inline(always)]
    pub(super) fn beat(&self) -> Beat<'_> {
        match &self.units {
            Some((units, control)) => Beat {
                valid: control.code() & 2 != 0,
                flag: control.code() & 1 != 0,
                words: units.words(),
            },
            None => Beat {
                valid: self.requant.valid(),
                flag: self.requant.flag(),
                words: self.requant.words(),
            },
        }
    }

    /// `input`: the whole vector with its start bit, or the beat of the layer in front.
    #[inline]
    pub(super) fn step(&mut self, reset: bool, input: Beat<'_>) {
        // From the foot to the head, so that every cell still sees its neighbour of before.
        if let Some((units, control)) = &mut self.units {
            let code = u64::from(self.requant.valid()) << 1 | u64::from(self.requant.flag());
            control.step(reset, code);
            units.step(self.requant.words());
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
        let array = &self.array;
        match &mut self.drain {
            Some(drain) => {
                let (valid, flag) = (drain.valid(), drain.flag());
                self.requant.step(reset, valid, flag, |sums| {
                    sums.copy_from_slice(drain.words())
                });
                drain.step(reset, done, done_flag, |sums| array.sums(sums));
            }
            None => {
                self.requant
                    .step(reset, done, done_flag, |sums| array.sums(sums));
            }
        }
        if let Some(group) = &mut self.group {
            group.step(reset, at_foot);
        }

        let (enable, first) = (at_foot.valid, at_foot.first);
        let control = match &mut self.feed {
            Operands::Replay(replay) => {
                let control = replay.control();
                let words = replay.words().iter().copied();
                self.array.step(words, replay.address(), enable, first);
                replay.step(reset, input.valid, input.flag, input.words);
                control
            }
            Operands::Direct(beats) => {
                let control = beats.control(input.valid, input.flag);
                let words = input.words.iter().map(|word| real(*word));
                self.array.step(words, beats.address(), enable, first);
                beats.step(reset, input.valid);
                control
            }
            Operands::Hold(hold) => {
                let control = hold.control();
                let words = hold.words().iter().map(|word| real(*word));
                self.array.step(words, hold.address(), enable, first);
                hold.step(reset, input.valid, input.flag, input.words);
                control
            }
        };
        let code = if self.group.is_some() {
            u64::from(control.valid) << 3
                | u64::from(control.first) << 2
                | u64::from(control.last) << 1
                | u64::from(control.flag)
        } else {
            u64::from(control.valid) << 1 | u64::from(control.flag)
        };
        self.control.step(reset, code);
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
                Operands::Hold(hold) => within(probe, format_args!("u_hold"), |p| hold.show(p)),
            }
            self.array.show_operands("operands_q", 0, probe);
            within(probe, format_args!("u_control"), |p| self.control.show(p));
            self.array.show(probe);
            if let Some(group) = &self.group {
                within(probe, format_args!("u_group"), |p| group.show(p));
            }
            if let Some(drain) = &self.drain {
                within(probe, format_args!("u_drain"), |p| drain.show(p));
            }
            self.requant.show(probe);
            if let Some((units, control)) = &self.units {
                within(probe, format_args!("u_act_control"), |p| control.show(p));
                units.show(probe);
            }
        });
    }
}

/// `hwg_delay`: control bits on their way, the newest in the lowest bits.
#[derive(Clone, Debug)]
struct Delay {
    width: u32,
    depth: u32,
    /// Where the oldest entry begins.
    foot: u32,
    /// The bits of all entries.
    all: u128,
    pipe: u128,
}

impl Delay {
    /// At most 4 bits for 17 clocks: an array of the widest layer, with a ROM of several tables.
    fn new(width: u32, depth: usize) -> Self {
        let depth = u32::try_from(depth).expect("a small number");
        assert!(width * depth <= 128, "{width} bits for {depth} clocks");
        Self {
            width,
            depth,
            foot: width * (depth - 1),
            all: u128::MAX >> (128 - width * depth),
            pipe: 0,
        }
    }

    /// What comes out.
    #[inline]
    fn code(&self) -> u64 {
        u64::try_from(self.pipe >> self.foot).expect("one entry")
    }

    #[inline]
    fn step(&mut self, reset: bool, code: u64) {
        self.pipe = if reset {
            0
        } else {
            (self.pipe << self.width | u128::from(code)) & self.all
        };
    }

    fn show<P: Probe>(&self, probe: &mut P) {
        let mask = (1 << self.width) - 1;
        let entry = |i| i64::try_from(self.pipe >> (i * self.width) & mask).expect("one entry");
        let codes = (0..self.depth).map(entry);
        probe.words("pipe_q", self.width, &codes.collect::<Vec<_>>());
    }
}
