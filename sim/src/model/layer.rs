//! One layer: its feed, its array, what comes behind the sums.

use hwgen_spec::design::{Feed, Layer};
use hwgen_spec::device::Device;
use hwgen_spec::schedule::{activation_latency, control_depth};

use super::adders::Sums;
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

/// Where the sums come from.
#[derive(Clone, Debug)]
enum Front {
    Array(Operands, Box<Array>),
    Adders(Sums),
}

impl Front {
    #[inline]
    fn sums(&self, sums: &mut [i64]) {
        match self {
            Self::Array(_, array) => array.sums(sums),
            Self::Adders(adders) => adders.sums(sums),
        }
    }
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
    front: Front,
    /// Control bits beside the array.
    control: Delay,
    group: Option<Group>,
    drain: Option<Drain>,
    requant: Requant,
    /// The activation units, the control bits beside them, and those that come out.
    units: Option<(Units, Delay, u64)>,
}

impl LayerModel {
    pub(super) fn new(layer: &Layer, device: &Device) -> Self {
        let bits = layer.quant.input.width();
        let (simd, synapse_folds) = (layer.fold.simd, layer.synapse_folds());
        let drains = layer.drain_beats() > 1;
        Self {
            name: layer.quant.name.clone(),
            front: match (Sums::new(layer), layer.feed) {
                (Some(sums), _) => Front::Adders(sums),
                (None, feed) => {
                    let folds = layer.neuron_folds();
                    let operands = match feed {
                        Feed::Direct => Operands::Direct(Beats::new(synapse_folds)),
                        Feed::Hold => Operands::Hold(Hold::new(simd, synapse_folds, folds, bits)),
                        Feed::Replay | Feed::Adders => {
                            Operands::Replay(Replay::new(simd, synapse_folds, folds, bits))
                        }
                    };
                    Front::Array(operands, Box::new(Array::new(layer, device)))
                }
            },
            control: Delay::new(
                if layer.accumulates() { 4 } else { 2 },
                control_depth(layer),
            ),
            group: layer.accumulates().then(|| Group::new(layer.load_copies())),
            drain: drains.then(|| Drain::new(layer.fold.pe, layer.lanes, layer.quant.sum_width)),
            requant: Requant::new(layer, device),
            units: Units::new(layer, device)
                .map(|units| (units, Delay::new(2, activation_latency(layer) - 1), 0)),
        }
    }

    /// What stands at the layer's output.
    #[inline(always)]
    pub(super) fn beat(&self) -> Beat<'_> {
        match &self.units {
            Some((units, _, control)) => Beat {
                valid: control & 2 != 0,
                flag: control & 1 != 0,
                words: units.words(),
            },
            None => Beat {
                valid: self.requant.valid(),
                flag: self.requant.flag(),
                words: self.requant.words(),
            },
        }
    }

    /// Whether a beat comes after the next edge, unless there is a reset.
    #[inline]
    pub(super) fn next(&self) -> bool {
        match &self.units {
            Some((_, control, _)) => control.code() & 2 != 0,
            None => self.requant.next(),
        }
    }

    /// `input`: the whole vector with its start bit, or the beat of the layer in front.
    #[inline]
    pub(super) fn step(&mut self, reset: bool, input: Beat<'_>) {
        // From the foot to the head, so that every cell still sees its neighbour of before.
        if let Some((units, control, out)) = &mut self.units {
            *out = if reset { 0 } else { control.code() };
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
        let front = &self.front;
        match &mut self.drain {
            Some(drain) => {
                let (valid, flag) = (drain.valid(), drain.flag());
                self.requant.step(reset, valid, flag, |sums| {
                    sums.copy_from_slice(drain.words())
                });
                drain.step(reset, done, done_flag, |sums| front.sums(sums));
            }
            None => {
                self.requant
                    .step(reset, done, done_flag, |sums| front.sums(sums));
            }
        }
        if let Some(group) = &mut self.group {
            group.step(reset, at_foot);
        }

        let (enable, first) = (at_foot.valid, at_foot.first);
        let control = match &mut self.front {
            Front::Adders(adders) => {
                adders.step(input.words);
                Control {
                    valid: input.valid,
                    first: true,
                    last: true,
                    flag: input.flag,
                }
            }
            Front::Array(Operands::Replay(replay), array) => {
                let control = replay.control();
                let words = replay.words().iter().copied();
                array.step(words, replay.address(), enable, first);
                replay.step(reset, input.valid, input.flag, input.words);
                control
            }
            Front::Array(Operands::Direct(beats), array) => {
                let control = beats.control(input.valid, input.flag);
                let words = input.words.iter().map(|word| real(*word));
                array.step(words, beats.address(), enable, first);
                beats.step(reset, input.valid);
                control
            }
            Front::Array(Operands::Hold(hold), array) => {
                let control = hold.control();
                let words = hold.words().iter().map(|word| real(*word));
                array.step(words, hold.address(), enable, first);
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
            within(probe, format_args!("u_control"), |p| self.control.show(p));
            match &self.front {
                Front::Adders(adders) => adders.show(probe),
                Front::Array(operands, array) => {
                    match operands {
                        Operands::Replay(replay) => {
                            within(probe, format_args!("u_replay"), |p| replay.show(p));
                        }
                        Operands::Direct(beats) => {
                            within(probe, format_args!("u_beats"), |p| beats.show(p));
                        }
                        Operands::Hold(hold) => {
                            within(probe, format_args!("u_hold"), |p| hold.show(p));
                        }
                    }
                    array.show_operands("operands_q", 0, probe);
                    array.show(probe);
                }
            }
            if let Some(group) = &self.group {
                within(probe, format_args!("u_group"), |p| group.show(p));
            }
            if let Some(drain) = &self.drain {
                within(probe, format_args!("u_drain"), |p| drain.show(p));
            }
            self.requant.show(probe);
            if let Some((units, control, out)) = &self.units {
                within(probe, format_args!("u_act_control"), |p| control.show(p));
                probe.bit("valid_q", out & 2 != 0);
                probe.bit("flag_q", out & 1 != 0);
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
