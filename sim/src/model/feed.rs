//! The cells that bring operands to an array: gather, replay, beats, hold.

use hwgen_spec::design::Layer;

use super::array::{code, real};
use super::probe::{Probe, address_bits, counter_bits, within};

/// `hwg_gather`.
#[derive(Clone, Debug)]
pub(super) struct Gather {
    bits: u32,
    words: usize,
    lanes: usize,
    beats: usize,
    starts: usize,
    slots: Vec<i64>,
    /// Where the next beat goes.
    place: usize,
    /// Where the beat of this clock goes.
    put: Option<usize>,
    /// The beat's copy, where it takes a clock to one: flag and words.
    hop: Option<(bool, Vec<i64>)>,
    start: bool,
    flag: bool,
}

impl Gather {
    pub(super) fn new(layer: &Layer, starts: usize) -> Self {
        let (words, lanes) = (layer.quant.outputs(), layer.lanes);
        let beats = words.div_ceil(lanes);
        let slots = vec![0; beats * lanes];
        Self {
            bits: layer.quant.output.width(),
            words,
            lanes,
            beats,
            starts,
            slots,
            place: 0,
            put: None,
            hop: (layer.gather_latency > 1).then(|| (false, vec![0; lanes])),
            start: false,
            flag: false,
        }
    }

    #[inline]
    pub(super) fn start(&self) -> bool {
        self.start
    }

    #[inline]
    pub(super) fn flag(&self) -> bool {
        self.flag
    }

    /// The words, without the padding of the last beat.
    #[inline]
    pub(super) fn vector(&self) -> &[i64] {
        &self.slots[..self.words]
    }

    /// `next`: whether a beat comes after this edge, unless there is a reset.
    #[inline]
    pub(super) fn step(
        &mut self,
        reset: bool,
        next: bool,
        (valid, flag, data): (bool, bool, &[i64]),
    ) {
        let (flag_now, words) = match &self.hop {
            Some((flag, words)) => (*flag, &words[..]),
            None => (flag, data),
        };
        if let Some(beat) = self.put {
            self.flag = (self.flag && beat != 0) || flag_now;
            self.slots[beat * self.lanes..][..self.lanes].copy_from_slice(words);
        }
        self.start = !reset && self.complete();
        let next = if self.hop.is_some() { valid } else { next };
        self.put = (!reset && next).then_some(self.place);
        if reset {
            self.place = 0;
        } else if next {
            self.place = (self.place + 1) % self.beats;
        }
        if let Some((held, words)) = &mut self.hop {
            *held = flag;
            words.copy_from_slice(data);
        }
    }

    /// Whether the last beat is here.
    #[inline]
    fn complete(&self) -> bool {
        self.put == Some(self.beats - 1)
    }

    pub(super) fn show<P: Probe>(&self, probe: &mut P) {
        probe.words("slot_q", self.bits, &self.slots);
        let one_at = |place| -> Vec<i64> {
            let beats = (0..self.beats).map(Some);
            beats.map(|b| i64::from(b == place)).collect()
        };
        probe.words("place_q", 1, &one_at(Some(self.place)));
        probe.words("put_q", 1, &one_at(self.put));
        probe.bit("valid_q", self.put.is_some());
        probe.bit("flag_q", self.flag);
        probe.bit("complete_q", self.complete());
        if let Some((flag, words)) = &self.hop {
            within(probe, format_args!("g_hop"), |probe| {
                probe.bit("hop_q", *flag);
                probe.words("data_q", self.bits, words);
            });
        }
        for copy in 0..self.starts {
            within(probe, format_args!("g_copy[{copy}]"), |probe| {
                probe.bit("start_q", self.start);
            });
        }
    }
}

/// Control bits that go with the operands of a clock.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Control {
    pub(super) valid: bool,
    pub(super) first: bool,
    pub(super) last: bool,
    pub(super) flag: bool,
}

/// `hwg_replay`.
///
/// The ring is kept still and the place of its head moves. Its words are real numbers, for the
/// array.
#[derive(Clone, Debug)]
pub(super) struct Replay {
    bits: u32,
    simd: usize,
    synapse_folds: usize,
    folds: usize,
    slots: Vec<f64>,
    head: usize,
    address: usize,
    step: usize,
    busy: bool,
    flag: bool,
}

impl Replay {
    pub(super) fn new(simd: usize, synapse_folds: usize, neuron_folds: usize, bits: u32) -> Self {
        Self {
            bits,
            simd,
            synapse_folds,
            folds: synapse_folds * neuron_folds,
            slots: vec![0.0; simd * synapse_folds],
            head: 0,
            address: 0,
            step: 0,
            busy: false,
            flag: false,
        }
    }

    #[inline]
    pub(super) fn control(&self) -> Control {
        Control {
            valid: self.busy,
            first: self.step == 0,
            last: self.step == self.synapse_folds - 1,
            flag: self.flag,
        }
    }

    #[inline]
    pub(super) fn words(&self) -> &[f64] {
        &self.slots[self.head..self.head + self.simd]
    }

    #[inline]
    pub(super) fn address(&self) -> usize {
        self.address
    }

    #[inline]
    pub(super) fn step(&mut self, reset: bool, start: bool, flag: bool, vector: &[i64]) {
        let last = self.address == self.folds - 1;
        if start {
            let (words, padding) = self.slots.split_at_mut(vector.len());
            for (word, code) in words.iter_mut().zip(vector) {
                *word = real(*code);
            }
            padding.fill(0.0);
            self.head = 0;
            self.flag = flag;
        } else {
            let next = self.head + self.simd;
            self.head = if next == self.slots.len() { 0 } else { next };
        }
        if reset || start {
            (self.busy, self.address, self.step) = (!reset, 0, 0);
        } else if self.busy {
            self.busy = !last;
            self.address = if last { 0 } else { self.address + 1 };
            self.step = if self.step == self.synapse_folds - 1 {
                0
            } else {
                self.step + 1
            };
        }
    }

    pub(super) fn show<P: Probe>(&self, probe: &mut P) {
        let (behind, before) = self.slots.split_at(self.head);
        let words: Vec<i64> = [before, behind].concat().into_iter().map(code).collect();
        probe.words("slot_q", self.bits, &words);
        probe.count("address_q", address_bits(self.folds), self.address);
        probe.count("step_q", counter_bits(self.synapse_folds), self.step);
        probe.bit("busy_q", self.busy);
        probe.bit("flag_q", self.flag);
    }
}

/// `hwg_beats`.
#[derive(Clone, Debug)]
pub(super) struct Beats {
    beats: usize,
    address: usize,
}

impl Beats {
    pub(super) fn new(beats: usize) -> Self {
        Self { beats, address: 0 }
    }

    #[inline]
    pub(super) fn control(&self, valid: bool, flag: bool) -> Control {
        Control {
            valid,
            first: self.address == 0,
            last: self.address == self.beats - 1,
            flag,
        }
    }

    #[inline]
    pub(super) fn address(&self) -> usize {
        self.address
    }

    #[inline]
    pub(super) fn step(&mut self, reset: bool, valid: bool) {
        self.address = match (reset, valid) {
            (true, _) => 0,
            (_, true) if self.address == self.beats - 1 => 0,
            (_, true) => self.address + 1,
            (_, false) => self.address,
        };
    }

    pub(super) fn show<P: Probe>(&self, probe: &mut P) {
        probe.count("address_q", address_bits(self.beats), self.address);
    }
}

/// `hwg_hold`.
#[derive(Clone, Debug)]
pub(super) struct Hold {
    bits: u32,
    beats: usize,
    folds: usize,
    words: Vec<i64>,
    /// Clocks that the beat is still offered.
    left: usize,
    address: usize,
    flag: bool,
}

impl Hold {
    pub(super) fn new(words: usize, beats: usize, folds: usize, bits: u32) -> Self {
        Self {
            bits,
            beats,
            folds,
            words: vec![0; words],
            left: 0,
            address: 0,
            flag: false,
        }
    }

    #[inline]
    pub(super) fn control(&self) -> Control {
        let beat = self.address / self.folds;
        Control {
            valid: self.left != 0,
            first: beat == 0,
            last: beat == self.beats - 1,
            flag: self.flag,
        }
    }

    #[inline]
    pub(super) fn words(&self) -> &[i64] {
        &self.words
    }

    #[inline]
    pub(super) fn address(&self) -> usize {
        self.address
    }

    #[inline]
    pub(super) fn step(&mut self, reset: bool, valid: bool, flag: bool, data: &[i64]) {
        let offered = self.left != 0;
        if valid {
            self.words.copy_from_slice(data);
            self.flag = flag;
        }
        self.left = if valid {
            self.folds
        } else {
            self.left.saturating_sub(1)
        };
        if offered {
            self.address = (self.address + 1) % (self.beats * self.folds);
        }
        if reset {
            (self.left, self.address) = (0, 0);
        }
    }

    pub(super) fn show<P: Probe>(&self, probe: &mut P) {
        let left: Vec<i64> = (0..self.folds).map(|i| (i < self.left).into()).collect();
        probe.words("word_q", self.bits, &self.words);
        probe.words("left_q", 1, &left);
        probe.count(
            "address_q",
            address_bits(self.beats * self.folds),
            self.address,
        );
        probe.bit("flag_q", self.flag);
    }
}
