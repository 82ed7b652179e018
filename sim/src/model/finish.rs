//! The cells behind a sum: requantization and activation.

use std::sync::Arc;

use hwgen_spec::activation::{GUARD_BITS, OddTable};
use hwgen_spec::design::{Layer, extra_shift_width};
use hwgen_spec::format::{QFormat, Rounding, shift_right, to_bits};
use hwgen_spec::network::Activation;

use super::probe::{Probe, address_bits, within};

/// `hwg_requant` and the bias ROM in front of it.
#[derive(Clone, Debug)]
pub(super) struct Requant {
    lanes: usize,
    sum_bits: u32,
    biased_bits: u32,
    extra_bits: u32,
    product_shift: u32,
    shift: u32,
    pre: QFormat,
    activation: Activation,
    output_beats: usize,
    /// `[1 + beat][lane]`; word 0 is the zero of power-up.
    biases: Vec<i64>,
    extras: Vec<u32>,
    array_beats: usize,
    beat: usize,
    /// Word in the ROM's register.
    rom: usize,
    sums: Vec<i64>,
    valid: u32,
    flag: u32,
    biased: Vec<i64>,
    extra: Vec<u32>,
    shifted: Vec<i64>,
    words: Vec<i64>,
}

impl Requant {
    pub(super) fn new(layer: &Layer) -> Self {
        let quant = &layer.quant;
        let entries = (0..layer.array_beats()).flat_map(|beat| layer.bias_word(beat));
        let zero = std::iter::repeat_n((0, 0), layer.lanes);
        let (biases, extras) = zero.chain(entries).unzip();
        let zeros = vec![0; layer.lanes];
        Self {
            lanes: layer.lanes,
            sum_bits: quant.sum_width,
            biased_bits: quant.biased_width,
            extra_bits: extra_shift_width(quant),
            product_shift: quant.product_shift,
            shift: quant.base_shift,
            pre: quant.pre,
            activation: quant.activation,
            output_beats: layer.output_beats(),
            biases,
            extras,
            array_beats: layer.array_beats(),
            beat: 0,
            rom: 0,
            sums: zeros.clone(),
            valid: 0,
            flag: 0,
            biased: zeros.clone(),
            extra: vec![0; layer.lanes],
            shifted: zeros.clone(),
            words: zeros,
        }
    }

    fn stages(&self) -> u32 {
        if self.extra_bits > 0 { 4 } else { 3 }
    }

    pub(super) fn valid(&self) -> bool {
        self.valid >> (self.stages() - 1) & 1 == 1
    }

    pub(super) fn flag(&self) -> bool {
        self.flag >> (self.stages() - 1) & 1 == 1
    }

    pub(super) fn words(&self) -> &[i64] {
        &self.words
    }

    pub(super) fn step(&mut self, reset: bool, valid: bool, flag: bool, sums: &[i64]) {
        let stages = self.stages();
        let clipped = self.saturate();
        let own = self.rom * self.lanes..(self.rom + 1) * self.lanes;
        let (biases, extras) = (&self.biases[own.clone()], &self.extras[own]);
        if self.extra_bits > 0 {
            let lanes = self.shifted.iter_mut().zip(&self.biased);
            for ((shifted, biased), extra) in lanes.zip(&self.extra) {
                *shifted = shift_right(*biased, *extra, Rounding::Floor);
            }
            self.extra.copy_from_slice(extras);
        }
        for ((biased, sum), bias) in self.biased.iter_mut().zip(&self.sums).zip(biases) {
            *biased = (sum << self.product_shift) + bias;
        }
        self.sums.copy_from_slice(sums);
        let mask = (1 << stages) - 1;
        self.flag = (self.flag << 1 | u32::from(flag)) & mask;
        self.flag |= u32::from(clipped) << (stages - 1);
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

    /// The last step of `hwg_requant`; true if a word was beyond its format.
    fn saturate(&mut self) -> bool {
        let values = if self.extra_bits > 0 {
            &self.shifted
        } else {
            &self.biased
        };
        let (format, shift) = (self.pre, self.shift);
        let mut clipped = false;
        let lanes = self.words.iter_mut().zip(values);
        let lanes = lanes.map(|(word, v)| (word, shift_right(*v, shift, Rounding::Floor)));
        match self.activation {
            Activation::Linear | Activation::Relu => {
                let relu = self.activation == Activation::Relu;
                for (word, value) in lanes {
                    let z = format.saturate(if relu { value.max(0) } else { value });
                    *word = z.code;
                    clipped |= z.clipped;
                }
            }
            Activation::Tanh | Activation::Sigmoid => {
                // Clipping the argument of an odd function is no overflow.
                let most = format.max_code();
                lanes.for_each(|(word, value)| *word = value.clamp(-most, most));
            }
        }
        clipped
    }

    pub(super) fn show<P: Probe>(&self, probe: &mut P) {
        within(probe, format_args!("u_bias"), |probe| {
            let own = self.rom * self.lanes..(self.rom + 1) * self.lanes;
            let entries: Vec<i64> = self.biases[own.clone()]
                .iter()
                .zip(&self.extras[own])
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
            probe.word("valid_q", self.stages(), self.valid.into());
            probe.word("flag_q", self.stages(), self.flag.into());
            for lane in 0..self.lanes {
                within(probe, format_args!("g_lane[{lane}]"), |probe| {
                    probe.word("biased_q", self.biased_bits, self.biased[lane]);
                    if self.extra_bits > 0 {
                        within(probe, format_args!("g_extra"), |probe| {
                            probe.word("extra_q", self.extra_bits, self.extra[lane].into());
                            probe.word("shifted_q", self.biased_bits, self.shifted[lane]);
                        });
                    }
                    probe.word("word_q", self.pre.width(), self.words[lane]);
                });
            }
        });
    }
}

/// `hwg_pwl` and its segment ROM.
#[derive(Clone, Debug)]
pub(super) struct Pwl {
    table: Arc<OddTable>,
    one: i64,
    bits: u32,
    magnitude: i64,
    line: (i64, i64),
    distance: i64,
    mul: (i64, i64, i64),
    offset: [i64; 2],
    negative: u32,
    sum: i64,
    y: i64,
}

impl Pwl {
    pub(super) fn new(layer: &Layer) -> Option<Self> {
        let table = Arc::clone(layer.quant.table.as_ref()?);
        let sigmoid = layer.quant.activation == Activation::Sigmoid;
        Some(Self {
            one: if sigmoid { 1 << table.fraction() } else { 0 },
            table,
            bits: layer.quant.output.width(),
            magnitude: 0,
            line: (0, 0),
            distance: 0,
            mul: (0, 0, 0),
            offset: [0; 2],
            negative: 0,
            sum: 0,
            y: 0,
        })
    }

    pub(super) fn word(&self) -> i64 {
        self.y
    }

    pub(super) fn step(&mut self, z: i64) {
        let table = &self.table;
        let t = self.sum >> table.slope_bits();
        self.y = if self.negative >> 4 & 1 == 1 {
            self.one - t
        } else {
            self.one + t
        };
        self.sum = (self.offset[1] << (table.slope_bits() - GUARD_BITS)) + self.mul.2;
        self.mul = (self.distance, self.line.1, self.mul.0 * self.mul.1);
        self.offset = [self.line.0, self.offset[0]];
        self.negative = (self.negative << 1 | u32::from(z < 0)) & 0b1_1111;
        let segment = usize::try_from(self.magnitude >> table.distance_bits()).expect("magnitude");
        self.line = table.line_of(segment);
        self.distance = self.magnitude & ((1 << table.distance_bits()) - 1);
        self.magnitude = z.abs();
    }

    pub(super) fn show<P: Probe>(&self, probe: &mut P) {
        let table = &self.table;
        let (distance, slope) = (table.distance_bits(), table.slope_width());
        within(probe, format_args!("u_segments"), |probe| {
            let (a, b) = self.line;
            probe.fields("data_q", &[slope, table.offset_width()], &[b, a]);
        });
        within(probe, format_args!("u_pwl"), |probe| {
            probe.word("magnitude_q", table.magnitude_bits(), self.magnitude);
            probe.word("distance_q", distance, self.distance);
            probe.words("offset_q", table.offset_width(), &self.offset);
            probe.word("negative_q", 5, self.negative.into());
            probe.word("sum_q", table.fraction() + table.slope_bits(), self.sum);
            probe.word("y_q", self.bits, self.y);
            within(probe, format_args!("u_mul"), |probe| {
                probe.word("a_q", distance + 1, self.mul.0);
                probe.word("b_q", slope + 1, self.mul.1);
                probe.word("p_q", distance + slope + 2, self.mul.2);
            });
        });
    }
}
