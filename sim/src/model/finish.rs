//! The cells behind a sum: requantization and activation.

use std::sync::Arc;

use hwgen_spec::activation::{GUARD_BITS, OddTable};
use hwgen_spec::design::{Layer, extra_shift_width};
use hwgen_spec::device::Device;
use hwgen_spec::format::to_bits;
use hwgen_spec::network::Activation;
use hwgen_spec::schedule::activation_latency;

use super::probe::{Probe, address_bits, show_adders, show_wide, within};

/// `hwg_requant` and the bias ROM in front of it.
///
/// As in the array, only control has a reset and nothing has an enable, so that a lane's registers
/// of `age` clocks behind `sum_q` follow from sum and ROM entry of `age` clocks ago. A sum's word
/// is worked out when the sum comes in and waits until it stands in `word_q`; what lies between
/// is worked out only to be shown. The zeros of power-up fit in: zero, through entry zero, is zero. Age 0
/// has then what the ROM's register starts with.
///
/// | age | registers |
/// |---|---|
/// | 0 | `sum_q`, `data_q` |
/// | 1 | `biased_q`, `extra_q` |
/// | 2 | `shifted_q`, only where a neuron has a shift of its own |
/// | 2 or 3 | `value_q`, `negative_q`, `beyond_q` |
/// | 3 or 4 | `word_q` |
#[derive(Clone, Debug)]
pub(super) struct Requant {
    lanes: usize,
    sum_bits: u32,
    biased_bits: u32,
    extra_bits: u32,
    word_bits: u32,
    product_shift: u32,
    /// What a word is clamped to.
    low: i64,
    high: i64,
    /// All ones if negative words are zero before they are clamped, else zero.
    relu: i64,
    /// Whether clamping counts: clipping the argument of an odd function is no overflow.
    counts: bool,
    output_beats: usize,
    array_beats: usize,
    /// `[1 + beat][lane]`; word 0 is the zero of power-up, behind the last stands what `data_q` starts with.
    entries: Vec<Entry>,
    beat: usize,
    address_copies: usize,
    valid: u32,
    /// `flag_q` as if nothing were clipped here.
    flag: u32,
    /// Whether some lane's word is clipped, the newest lowest.
    clipped: u32,
    /// Slots of the ring and registers in a row: ages from a sum to its word.
    stages: usize,
    /// Slot of age 0; greater ages follow.
    newest: usize,
    /// `[slot]`: the ROM's word.
    roms: Vec<usize>,
    /// `[slot][lane]`
    sums: Vec<i64>,
    /// `[slot][lane]`: what will be in `word_q`.
    words: Vec<i64>,
}

/// A lane of a word of the bias ROM.
#[derive(Clone, Copy, Debug, Default)]
struct Entry {
    bias: i64,
    extra: u32,
    /// This neuron's shift and that of all: dropping bits twice is dropping them at once.
    shift: u32,
}

impl Requant {
    pub(super) fn new(layer: &Layer, device: &Device) -> Self {
        let quant = &layer.quant;
        let entry = |(bias, extra): (i64, u32)| Entry {
            bias,
            extra,
            shift: (extra + quant.base_shift).min(63),
        };
        let beats: Vec<Vec<(i64, u32)>> = (0..layer.array_beats())
            .map(|beat| layer.bias_word(beat).into_iter().collect())
            .collect();
        let start = (0..layer.lanes).map(|lane| {
            let of_lane = beats.iter().map(|beat| beat[lane]);
            let (biases, extras): (Vec<_>, Vec<_>) = of_lane
                .map(|(bias, extra)| (bias, i64::from(extra)))
                .unzip();
            let extra = u32::try_from(device.rom_start(&extras, beats.len())).expect("a shift");
            (device.rom_start(&biases, beats.len()), extra)
        });
        let entries = beats.iter().flatten().copied().chain(start).map(entry);
        let zero = std::iter::repeat_n(Entry::default(), layer.lanes);
        let extra_bits = extra_shift_width(quant);
        let stages = if extra_bits > 0 { 5 } else { 4 };
        let pre = quant.pre;
        let odd = matches!(quant.activation, Activation::Tanh | Activation::Sigmoid);
        let mut new = Self {
            lanes: layer.lanes,
            sum_bits: quant.sum_width,
            biased_bits: quant.biased_width,
            extra_bits,
            word_bits: pre.width(),
            product_shift: quant.product_shift,
            low: if odd { -pre.max_code() } else { pre.min_code() },
            high: pre.max_code(),
            relu: -i64::from(quant.activation == Activation::Relu),
            counts: !odd,
            output_beats: layer.output_beats(),
            array_beats: layer.array_beats(),
            entries: zero.chain(entries).collect(),
            beat: 0,
            address_copies: layer.bias_address_copies(device),
            valid: 0,
            flag: 0,
            clipped: 0,
            stages,
            newest: 0,
            roms: vec![0; stages],
            sums: vec![0; stages * layer.lanes],
            words: vec![0; stages * layer.lanes],
        };
        new.finish(1 + layer.array_beats());
        new
    }

    #[inline]
    fn slot(&self, age: usize) -> usize {
        let slot = self.newest + age;
        if slot < self.stages {
            slot
        } else {
            slot - self.stages
        }
    }

    #[inline]
    pub(super) fn valid(&self) -> bool {
        self.valid >> (self.stages - 1) & 1 == 1
    }

    /// Whether a word will be valid after the next edge.
    #[inline]
    pub(super) fn next(&self) -> bool {
        self.valid >> (self.stages - 2) & 1 == 1
    }

    #[inline]
    pub(super) fn flag(&self) -> bool {
        (self.flag | self.clipped) >> (self.stages - 1) & 1 == 1
    }

    #[inline]
    pub(super) fn words(&self) -> &[i64] {
        &self.words[self.slot(self.stages - 1) * self.lanes..][..self.lanes]
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
        // The oldest slot becomes the newest.
        self.newest = self.slot(self.stages - 1);
        let rom = 1 + self.beat;
        put(&mut self.sums[self.newest * self.lanes..][..self.lanes]);
        self.finish(rom);
        self.flag = self.flag << 1 | u32::from(flag);
        let keep = valid && self.beat < self.output_beats;
        self.valid = if reset {
            0
        } else {
            self.valid << 1 | u32::from(keep)
        };
        if reset {
            self.beat = 0;
        } else if valid {
            self.beat = if rom == self.array_beats { 0 } else { rom };
        }
    }

    /// Works out the words of the newest sums with a word of the ROM.
    #[inline]
    fn finish(&mut self, rom: usize) {
        self.roms[self.newest] = rom;
        let lanes = self.lanes;
        let sums = &self.sums[self.newest * lanes..][..lanes];
        let words = &mut self.words[self.newest * lanes..][..lanes];
        let entries = &self.entries[rom * lanes..][..lanes];
        let mut clipped = 0;
        for ((word, sum), entry) in words.iter_mut().zip(sums).zip(entries) {
            let value = ((*sum << self.product_shift) + entry.bias) >> entry.shift;
            let value = value & !(value >> 63 & self.relu);
            // Clamped without a branch, which random values would lead astray.
            let (above, below) = (self.high - value, value - self.low);
            let cut = (above & above >> 63) - (below & below >> 63);
            *word = value + cut;
            clipped |= cut;
        }
        self.clipped = self.clipped << 1 | u32::from(clipped != 0 && self.counts);
    }

    /// Whether a word does not hold a value: then it is clamped, unless it is a negative one that
    /// becomes zero.
    fn beyond(&self, value: i64) -> bool {
        // What is clamped to is not the least word where the function is odd.
        let least = if self.relu == 0 {
            self.low
        } else {
            -self.high - 1
        };
        value < least || value > self.high
    }

    pub(super) fn show<P: Probe>(&self, probe: &mut P) {
        let entries = |age| &self.entries[self.roms[self.slot(age)] * self.lanes..][..self.lanes];
        let sums = |age| &self.sums[self.slot(age) * self.lanes..][..self.lanes];
        let biased =
            |age, lane: usize| (sums(age)[lane] << self.product_shift) + entries(age)[lane].bias;
        within(probe, format_args!("u_bias"), |probe| {
            let codes = entries(0).iter().map(|entry| {
                let high = u64::from(entry.extra) << self.biased_bits;
                (high | to_bits(entry.bias, self.biased_bits)).cast_signed()
            });
            let codes: Vec<i64> = codes.collect();
            probe.words("data_q", self.biased_bits + self.extra_bits, &codes);
        });
        within(probe, format_args!("u_requant"), |probe| {
            probe.count("beat_q", address_bits(self.array_beats), self.beat);
            probe.words("sum_q", self.sum_bits, sums(0));
            let bits = register_bits(self.stages);
            let (mask, top) = ((1 << bits) - 1, 1 << (bits - 1));
            let flag = self.flag & mask | self.clipped & top;
            probe.word("valid_q", bits, (self.valid & mask).into());
            probe.word("flag_q", bits, flag.into());
            for (lane, word) in self.words().iter().enumerate() {
                within(probe, format_args!("g_lane[{lane}]"), |probe| {
                    probe.word("biased_q", self.biased_bits, biased(1, lane));
                    if self.extra_bits > 0 {
                        let shifted = biased(2, lane) >> entries(2)[lane].extra.min(63);
                        within(probe, format_args!("g_extra"), |probe| {
                            let extra = entries(1)[lane].extra;
                            probe.word("extra_q", self.extra_bits, extra.into());
                            probe.word("shifted_q", self.biased_bits, shifted);
                        });
                    }
                    let held = self.stages - 2;
                    let value = biased(held, lane) >> entries(held)[lane].shift;
                    let bits = 64 - self.word_bits;
                    probe.word("value_q", self.word_bits, value << bits >> bits);
                    probe.bit("negative_q", value < 0);
                    probe.bit("beyond_q", self.beyond(value));
                    probe.word("word_q", self.word_bits, *word);
                });
            }
            if self.address_copies > 1 {
                for copy in 0..self.address_copies {
                    within(probe, format_args!("g_copy[{copy}].g_own"), |probe| {
                        probe.count("address_q", address_bits(self.array_beats), self.beat);
                    });
                }
            }
        });
    }
}

/// Bits of a shift register of few stages.
fn register_bits(stages: usize) -> u32 {
    u32::try_from(stages).expect("a few stages")
}

/// The activation units of a layer: `hwg_pwl` a lane, each with its segment ROM.
///
/// They too have neither enable nor reset: a value is worked out when its argument comes in and
/// waits until it stands in `y_q`; what lies between is worked out only to be shown.
///
/// | age | registers |
/// |---|---|
/// | 0 | `magnitude_q`, `negative_q[0]` and so on to age 4 |
/// | 1 | `data_q`, `distance_q` |
/// | 2 | `a_q`, `b_q`, newest third of `offset_q` |
/// | 3 | `p_q` |
/// | 4 | `r_q`, oldest third of `offset_q` |
/// | 5 | `sum_q` |
/// | 6 | `y_q` |
///
/// A ROM of several tables has their words at age 1; all but these is a clock older then.
///
/// At power-up age 0 holds the argument 0, but the ROM's registers no line of the table: in them are
/// lines that they start with, and beyond are blanks, of offset and slope 0, until they have left.
#[derive(Clone, Debug)]
pub(super) struct Units {
    table: Arc<OddTable>,
    /// Of each segment: offset, in steps of `sum_q`, and slope.
    lines: Vec<(i64, i64)>,
    slope_bits: u32,
    distance_bits: u32,
    one: i64,
    bits: u32,
    hides_operands: bool,
    /// Whether the device has multipliers in blocks.
    in_blocks: bool,
    in_logic: bool,
    lanes: usize,
    /// Depths of the tables of the ROM.
    tables: Vec<usize>,
    /// What registers start with: those of tables, if there are several, each with its own.
    table_starts: Vec<(i64, i64)>,
    /// That of the ROM behind that of the first table, as they come out.
    starts: Vec<(i64, i64)>,
    /// Slots of the ring and registers in a row: from an argument to its word.
    stages: usize,
    /// Clocks of the ROM.
    rom: usize,
    /// Edges since power-up, as far as there may be blanks.
    edges: usize,
    /// Slot of age 0; greater ages follow.
    newest: usize,
    /// `[slot][unit]`
    arguments: Vec<i64>,
    /// `[slot][unit]`: what will be in `y_q`.
    words: Vec<i64>,
}

impl Units {
    pub(super) fn new(layer: &Layer, device: &Device) -> Option<Self> {
        let table = Arc::clone(layer.quant.table.as_ref()?);
        let sigmoid = layer.quant.activation == Activation::Sigmoid;
        let shift = table.slope_bits() - GUARD_BITS;
        let one = if sigmoid { 1 << table.fraction() } else { 0 };
        let lanes = layer.lanes;
        let stages = activation_latency(layer);
        let rom = layer.segment_latency;
        let start = |lines: &[(i64, i64)]| {
            let (offsets, slopes): (Vec<_>, Vec<_>) = lines.iter().copied().unzip();
            (
                device.rom_start(&offsets, table.segments()),
                device.rom_start(&slopes, table.segments()),
            )
        };
        let lines: Vec<(i64, i64)> = table.lines().collect();
        let tables = match rom {
            1 => Vec::new(),
            _ => device.pieces_of_rom(table.segments()),
        };
        let of_tables = tables.first().map(|depth| lines.chunks(*depth).map(start));
        let table_starts: Vec<(i64, i64)> = of_tables.into_iter().flatten().collect();
        let first = table_starts.first().copied().into_iter();
        let mut new = Self {
            starts: first.chain([start(&lines)]).collect(),
            table_starts,
            tables,
            stages,
            rom,
            lines: lines.iter().map(|(a, b)| (a << shift, *b)).collect(),
            slope_bits: table.slope_bits(),
            distance_bits: table.distance_bits(),
            one,
            hides_operands: device.hides_operands(),
            in_blocks: device.has_multipliers(),
            in_logic: layer.activation_in_logic,
            table,
            bits: layer.quant.output.width(),
            lanes,
            edges: 0,
            newest: 0,
            arguments: vec![0; stages * lanes],
            words: vec![one; stages * lanes],
        };
        let zero = new.value(0);
        new.words[..lanes].fill(zero);
        for (age, start) in new.starts.iter().enumerate() {
            let word = (start.0 << shift) >> new.slope_bits;
            new.words[(1 + age) * lanes..][..lanes].fill(one + word);
        }
        let oldest = new.words.len() - lanes;
        new.words[oldest..].fill(0);
        Some(new)
    }

    #[inline]
    fn slot(&self, age: usize) -> usize {
        let slot = self.newest + age;
        if slot < self.stages {
            slot
        } else {
            slot - self.stages
        }
    }

    #[inline]
    fn segment(&self, magnitude: i64) -> usize {
        usize::try_from(magnitude >> self.distance_bits).expect("a magnitude")
    }

    #[inline]
    fn distance(&self, magnitude: i64) -> i64 {
        magnitude & ((1 << self.distance_bits) - 1)
    }

    /// What `y_q` will hold.
    #[inline]
    fn value(&self, z: i64) -> i64 {
        let magnitude = z.abs();
        let (offset, slope) = self.lines[self.segment(magnitude)];
        let sum = offset + self.distance(magnitude) * slope;
        let t = sum >> self.slope_bits;
        // -1 or 0: in two's complement -t = ~t + 1.
        let minus = z >> 63;
        self.one + ((t ^ minus) - minus)
    }

    #[inline]
    pub(super) fn words(&self) -> &[i64] {
        &self.words[self.slot(self.stages - 1) * self.lanes..][..self.lanes]
    }

    /// `arguments`: one z a unit.
    #[inline]
    pub(super) fn step(&mut self, arguments: &[i64]) {
        self.edges = (self.edges + 1).min(self.stages);
        // The oldest slot becomes the newest.
        self.newest = self.slot(self.stages - 1);
        let at = self.newest * self.lanes;
        for (lane, z) in arguments.iter().enumerate() {
            self.arguments[at + lane] = *z;
            self.words[at + lane] = self.value(*z);
        }
    }

    pub(super) fn show<P: Probe>(&self, probe: &mut P) {
        for (unit, y) in self.words().iter().enumerate() {
            within(probe, format_args!("g_act[{unit}]"), |p| {
                self.show_unit(p, unit, *y);
            });
        }
    }

    /// The tables that the ROM is built of, if there are several, a clock behind the address.
    fn show_tables<P: Probe>(&self, argument: i64, probe: &mut P) {
        let Some(depth) = self.tables.last() else {
            return;
        };
        let (table, segment) = (&self.table, self.segment(argument.abs()));
        for (number, start) in self.table_starts.iter().enumerate() {
            let (a, b) = match self.edges {
                0 => *start,
                _ => table.line_of(number * depth + segment % depth),
            };
            let widths = [table.slope_width(), table.offset_width()];
            probe.fields(&format!("table{number}_q"), &widths, &[b, a]);
        }
        let bits = address_bits(table.segments()) - depth.ilog2();
        probe.count("above_q", bits, segment / depth);
    }

    fn show_unit<P: Probe>(&self, probe: &mut P, unit: usize, y: i64) {
        let table = &self.table;
        let argument = |age| self.arguments[self.slot(age) * self.lanes + unit];
        let line = |age| {
            if age > self.edges {
                let start = self.starts.get(age - self.edges - 1);
                start.copied().unwrap_or_default()
            } else {
                table.line_of(self.segment(argument(age).abs()))
            }
        };
        let part = |age| self.distance(argument(age).abs());
        let rom = self.rom;
        let ages = 0..rom + 5;
        let negative = ages.map(|age| i64::from(argument(age) < 0) << age).sum();
        let sum = (line(rom + 4).0 << (table.slope_bits() - GUARD_BITS))
            + part(rom + 4) * line(rom + 4).1;
        let (distance, slope) = (table.distance_bits(), table.slope_width());
        within(probe, format_args!("u_segments"), |probe| {
            self.show_tables(argument(1), probe);
            let (a, b) = line(rom);
            probe.fields("data_q", &[slope, table.offset_width()], &[b, a]);
        });
        within(probe, format_args!("u_pwl"), |probe| {
            probe.word("magnitude_q", table.magnitude_bits(), argument(0).abs());
            let parts: Vec<i64> = (1..=rom).map(part).collect();
            probe.words("distance_q", distance, &parts);
            probe.words(
                "offset_q",
                table.offset_width(),
                &[line(rom + 1).0, line(rom + 2).0, line(rom + 3).0],
            );
            probe.word("negative_q", register_bits(rom + 5), negative);
            probe.word("sum_q", table.fraction() + table.slope_bits(), sum);
            probe.word("y_q", self.bits, y);
        });
        within(probe, format_args!("u_mul"), |probe| {
            if self.in_logic {
                // The slope times two bits of the distance, then four, then all.
                for pair in 0..distance.div_ceil(2) {
                    within(probe, format_args!("g_pair[{pair}]"), |probe| {
                        let bits = part(rom + 1) >> (2 * pair) & 3;
                        probe.word("sum_q", slope + 2, bits * line(rom + 1).1);
                    });
                }
                for quad in 0..distance.div_ceil(4) {
                    within(probe, format_args!("g_quad[{quad}]"), |probe| {
                        let bits = part(rom + 2) >> (4 * quad) & 15;
                        probe.word("sum_q", slope + 4, bits * line(rom + 2).1);
                    });
                }
                probe.word("p_q", distance + slope, part(rom + 3) * line(rom + 3).1);
                return;
            }
            if !self.hides_operands {
                probe.word("a_q", distance + 1, part(rom + 1));
                probe.word("b_q", slope + 1, line(rom + 1).1);
                probe.word("p_q", distance + slope + 2, part(rom + 2) * line(rom + 2).1);
            } else if self.in_blocks {
                show_wide(probe, distance + 1, slope + 1);
            } else {
                let operands = [rom + 1, rom + 2].map(|age| (part(age), line(age).1));
                show_adders(probe, (distance + 1, slope + 1), operands);
            }
            probe.word("r_q", distance + slope + 2, part(rom + 3) * line(rom + 3).1);
        });
    }
}
