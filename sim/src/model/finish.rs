//! The cells behind a sum: requantization and activation.

use std::sync::Arc;

use hwgen_spec::activation::{GUARD_BITS, OddTable};
use hwgen_spec::design::{Layer, extra_shift_width};
use hwgen_spec::format::to_bits;
use hwgen_spec::network::Activation;

use super::probe::{Probe, address_bits, within};

/// `hwg_requant` and the bias ROM in front of it.
#[derive(Clone, Debug)]
pub(super) struct Requant {
    lanes: usize,
    sum_bits: u32,
    biased_bits: u32,
    extra_bits: u32,
    word_bits: u32,
    product_shift: u32,
    shift: u32,
    /// What a word is clamped to.
    low: i64,
    high: i64,
    /// Whether negative words are zero before they are clamped.
    relu: bool,
    /// Whether clamping counts: clipping the argument of an odd function is no overflow.
    counts: bool,
    /// Edges from a sum to its word.
    stages: u32,
    output_beats: usize,
    array_beats: usize,
    /// Bias and shift, `[1 + beat][lane]`; word 0 is the zero of power-up.
    entries: Vec<(i64, u32)>,
    beat: usize,
    /// Word in the ROM's register.
    rom: usize,
    sums: Vec<i64>,
    valid: u32,
    flag: u32,
    pipes: Vec<Pipe>,
    words: Vec<i64>,
}

/// A lane's registers between sum and word.
#[derive(Clone, Debug, Default)]
struct Pipe {
    biased: i64,
    /// These two only where a neuron has a shift of its own.
    extra: u32,
    shifted: i64,
}

impl Requant {
    pub(super) fn new(layer: &Layer) -> Self {
        let quant = &layer.quant;
        let entries = (0..layer.array_beats()).flat_map(|beat| layer.bias_word(beat));
        let zero = std::iter::repeat_n((0, 0), layer.lanes);
        let extra_bits = extra_shift_width(quant);
        let pre = quant.pre;
        let odd = matches!(quant.activation, Activation::Tanh | Activation::Sigmoid);
        Self {
            lanes: layer.lanes,
            sum_bits: quant.sum_width,
            biased_bits: quant.biased_width,
            extra_bits,
            word_bits: pre.width(),
            product_shift: quant.product_shift,
            shift: quant.base_shift.min(63),
            low: if odd { -pre.max_code() } else { pre.min_code() },
            high: pre.max_code(),
            relu: quant.activation == Activation::Relu,
            counts: !odd,
            stages: if extra_bits > 0 { 4 } else { 3 },
            output_beats: layer.output_beats(),
            array_beats: layer.array_beats(),
            entries: zero.chain(entries).collect(),
            beat: 0,
            rom: 0,
            sums: vec![0; layer.lanes],
            valid: 0,
            flag: 0,
            pipes: vec![Pipe::default(); layer.lanes],
            words: vec![0; layer.lanes],
        }
    }

    pub(super) fn valid(&self) -> bool {
        self.valid >> (self.stages - 1) & 1 == 1
    }

    pub(super) fn flag(&self) -> bool {
        self.flag >> (self.stages - 1) & 1 == 1
    }

    pub(super) fn words(&self) -> &[i64] {
        &self.words
    }

    /// `put` writes the sums of the beat.
    #[inline]
    pub(super) fn step(
        &mut self,
        reset: bool,
        valid: bool,
        flag: bool,
        put: impl FnOnce(&mut [i64]),
    ) {
        let clipped = if self.extra_bits > 0 {
            self.lanes::<true>()
        } else {
            self.lanes::<false>()
        };
        put(&mut self.sums);
        let mask = (1 << self.stages) - 1;
        self.flag = (self.flag << 1 | u32::from(flag)) & mask;
        self.flag |= u32::from(clipped) << (self.stages - 1);
        let keep = valid && self.beat < self.output_beats;
        self.valid = if reset {
            0
        } else {
            (self.valid << 1 | u32::from(keep)) & mask
        };

        self.rom = 1 + self.beat;
        let last = self.beat + 1 == self.array_beats;
        self.beat = match (reset, valid) {
            (true, _) => 0,
            (_, true) if last => 0,
            (_, true) => self.beat + 1,
            (_, false) => self.beat,
        };
    }

    /// An edge of all lanes; true if a word was beyond its format.
    #[inline]
    fn lanes<const EXTRA: bool>(&mut self) -> bool {
        let (product_shift, shift) = (self.product_shift, self.shift);
        let (low, high, relu) = (self.low, self.high, self.relu);
        let mut clipped = false;
        let entries = &self.entries[self.rom * self.lanes..][..self.lanes];
        let ends = self.sums.iter().zip(&mut self.words);
        for ((pipe, (bias, extra)), (sum, word)) in self.pipes.iter_mut().zip(entries).zip(ends) {
            let value = if EXTRA { pipe.shifted } else { pipe.biased } >> shift;
            let value = if relu { value.max(0) } else { value };
            *word = value.clamp(low, high);
            clipped |= *word != value;
            if EXTRA {
                pipe.shifted = pipe.biased >> pipe.extra;
                pipe.extra = *extra;
            }
            pipe.biased = (sum << product_shift) + bias;
        }
        clipped && self.counts
    }

    pub(super) fn show<P: Probe>(&self, probe: &mut P) {
        within(probe, format_args!("u_bias"), |probe| {
            let own = self.rom * self.lanes..(self.rom + 1) * self.lanes;
            let entries: Vec<i64> = self.entries[own]
                .iter()
                .map(|(bias, extra)| {
                    let high = u64::from(*extra) << self.biased_bits;
                    (high | to_bits(*bias, self.biased_bits)).cast_signed()
                })
                .collect();
            probe.words("data_q", self.biased_bits + self.extra_bits, &entries);
        });
        within(probe, format_args!("u_requant"), |probe| {
            probe.count("beat_q", address_bits(self.array_beats), self.beat);
            probe.words("sum_q", self.sum_bits, &self.sums);
            probe.word("valid_q", self.stages, self.valid.into());
            probe.word("flag_q", self.stages, self.flag.into());
            for (i, (lane, word)) in self.pipes.iter().zip(&self.words).enumerate() {
                within(probe, format_args!("g_lane[{i}]"), |probe| {
                    probe.word("biased_q", self.biased_bits, lane.biased);
                    if self.extra_bits > 0 {
                        within(probe, format_args!("g_extra"), |probe| {
                            probe.word("extra_q", self.extra_bits, lane.extra.into());
                            probe.word("shifted_q", self.biased_bits, lane.shifted);
                        });
                    }
                    probe.word("word_q", self.word_bits, *word);
                });
            }
        });
    }
}

/// The activation units of a layer: `hwg_pwl` a lane, each with its segment ROM.
#[derive(Clone, Debug)]
pub(super) struct Units {
    table: Arc<OddTable>,
    /// Offset and slope of each segment.
    lines: Vec<(i64, i64)>,
    one: i64,
    bits: u32,
    units: Vec<Pwl>,
    /// `y_q` of all units.
    words: Vec<i64>,
}

/// `hwg_pwl` and the register of its segment ROM.
#[derive(Clone, Debug, Default)]
struct Pwl {
    magnitude: i64,
    line: (i64, i64),
    distance: i64,
    mul: (i64, i64, i64),
    offset: [i64; 2],
    negative: u32,
    sum: i64,
}

impl Units {
    pub(super) fn new(layer: &Layer) -> Option<Self> {
        let table = Arc::clone(layer.quant.table.as_ref()?);
        let sigmoid = layer.quant.activation == Activation::Sigmoid;
        Some(Self {
            lines: table.lines().collect(),
            one: if sigmoid { 1 << table.fraction() } else { 0 },
            table,
            bits: layer.quant.output.width(),
            units: vec![Pwl::default(); layer.lanes],
            words: vec![0; layer.lanes],
        })
    }

    pub(super) fn words(&self) -> &[i64] {
        &self.words
    }

    /// `arguments`: one z a unit.
    #[inline]
    pub(super) fn step(&mut self, arguments: &[i64]) {
        let table = &*self.table;
        let (slope_bits, distance_bits) = (table.slope_bits(), table.distance_bits());
        let (offset_shift, below) = (slope_bits - GUARD_BITS, (1 << distance_bits) - 1);
        let (lines, one) = (self.lines.as_slice(), self.one);
        for ((unit, y), z) in self.units.iter_mut().zip(&mut self.words).zip(arguments) {
            let t = unit.sum >> slope_bits;
            // -1 or 0: in two's complement -t = ~t + 1.
            let minus = -i64::from(unit.negative >> 4 & 1);
            *y = one + ((t ^ minus) - minus);
            unit.sum = (unit.offset[1] << offset_shift) + unit.mul.2;
            unit.mul = (unit.distance, unit.line.1, unit.mul.0 * unit.mul.1);
            unit.offset = [unit.line.0, unit.offset[0]];
            unit.negative = (unit.negative << 1 | u32::from(*z < 0)) & 0b1_1111;
            let segment = usize::try_from(unit.magnitude >> distance_bits).expect("magnitude");
            unit.line = lines[segment];
            unit.distance = unit.magnitude & below;
            unit.magnitude = z.abs();
        }
    }

    pub(super) fn show<P: Probe>(&self, probe: &mut P) {
        for (i, (unit, y)) in self.units.iter().zip(&self.words).enumerate() {
            within(probe, format_args!("g_act[{i}]"), |p| {
                self.show_unit(p, unit, *y)
            });
        }
    }

    fn show_unit<P: Probe>(&self, probe: &mut P, unit: &Pwl, y: i64) {
        let table = &self.table;
        let (distance, slope) = (table.distance_bits(), table.slope_width());
        within(probe, format_args!("u_segments"), |probe| {
            let (a, b) = unit.line;
            probe.fields("data_q", &[slope, table.offset_width()], &[b, a]);
        });
        within(probe, format_args!("u_pwl"), |probe| {
            probe.word("magnitude_q", table.magnitude_bits(), unit.magnitude);
            probe.word("distance_q", distance, unit.distance);
            probe.words("offset_q", table.offset_width(), &unit.offset);
            probe.word("negative_q", 5, unit.negative.into());
            probe.word("sum_q", table.fraction() + table.slope_bits(), unit.sum);
            probe.word("y_q", self.bits, y);
            within(probe, format_args!("u_mul"), |probe| {
                probe.word("a_q", distance + 1, unit.mul.0);
                probe.word("b_q", slope + 1, unit.mul.1);
                probe.word("p_q", distance + slope + 2, unit.mul.2);
            });
        });
    }
}
