//! The array of a layer: weight ROMs, multipliers, adder trees, accumulators, drain.

use hwgen_spec::design::Layer;
use hwgen_spec::device::Device;

use super::probe::{Probe, address_bits, counter_bits, show_adders, show_wide, within};

/// One word of four processing elements.
///
/// Words are kept in double precision, whose arithmetic vectorises on every machine and is exact
/// here: sums have at most 52 bits.
type Row = [f64; 4];

/// All processing elements of a layer, each with its weight ROM, and the operands in front of them.
///
/// Nothing from `operands_q` and the ROMs' `address_q` down to the foot of the adder trees has an
/// enable or a reset: what stands there `age` clocks behind is a function of the operands and the
/// ROM address of `age` clocks ago. So these, the history of the first two registers, are all
/// that is kept, and the foot is one dot product an element, taken when somebody reads it.
/// Products and tree levels are worked out only to be shown.
///
/// | age | registers |
/// |---|---|
/// | 0 | `operands_q` of the layer, `address_q` of each ROM |
/// | 1 | `operands_q` of each element, `address_q2` of each ROM |
/// | d | the last operands of each element, `data_q` of each ROM |
/// | d + 1 | `a_q`, `b_q` |
/// | d + 2 | `p_q` |
/// | d + 3 | `r_q` |
/// | d + 3 + k | `sum_q` of level k, the last one being the foot |
///
/// d is the layer's `operand_latency`, 2 as a rule; without copies it is 0, and there are no registers
/// but the layer's own in front of the multipliers. A ROM of several tables has its words in these
/// at d - 1.
///
/// At power-up the history is of zeros, and so is all that comes of it; only the first words that leave
/// a ROM are those that its registers start with, then that of address 0.
#[derive(Clone, Debug)]
pub(super) struct Array {
    pe: usize,
    simd: usize,
    x_bits: u32,
    w_bits: u32,
    sum_bits: u32,
    folds: usize,
    address_copies: usize,
    hides_operands: bool,
    /// Whether the device has multipliers in blocks.
    in_blocks: bool,
    copy_latency: usize,
    /// Depths of the tables of a ROM, and their age.
    tables: Vec<usize>,
    tables_age: usize,
    /// Age of `data_q`.
    data: usize,
    /// Age of a product.
    foot: usize,
    levels: usize,
    /// `[1 + fold][block][simd]`, a block being four elements, those beyond the last of weight
    /// zero; word 0 is the zero of power-up, and behind the last fold stand what `data_q` starts with and
    /// the same of each table.
    weights: Vec<Row>,
    blocks: usize,
    /// `[slot][simd]`: a ring of the operands of the last clocks, one slot an age.
    operands: Vec<f64>,
    /// `[slot]`: the ROM's word in the same clock.
    words: Vec<usize>,
    /// Slot of age 0; greater ages follow.
    newest: usize,
    /// `enable_q` and `first_q`, the same in all elements.
    enable: bool,
    first: bool,
    /// `[group][block]`, a group for each neuron that takes turns in an element.
    accumulators: Option<Vec<Row>>,
    turns: usize,
    /// The group whose turn it is.
    turn: usize,
}

impl Array {
    pub(super) fn new(layer: &Layer, device: &Device) -> Self {
        let (pe, simd) = (layer.fold.pe, layer.fold.simd);
        let blocks = pe.div_ceil(4);
        let zero = [0.0; 4];
        let mut weights = vec![zero; simd * blocks];
        // `[fold][element][simd]`
        let codes: Vec<Vec<Vec<i64>>> = (0..layer.folds())
            .map(|fold| (0..pe).map(|p| layer.weight_word(p, fold)).collect())
            .collect();
        let mut rest = &codes[..];
        let tables = device.pieces_of_rom(layer.folds());
        let starts = tables.iter().map(|depth| {
            let (own, behind) = rest.split_at(rest.len().min(*depth));
            rest = behind;
            start(own, layer.folds(), device)
        });
        let starts: Vec<Vec<Vec<i64>>> = starts.collect();
        for words in codes
            .iter()
            .chain([&start(&codes, layer.folds(), device)])
            .chain(&starts)
        {
            for block in words.chunks(4) {
                weights.extend((0..simd).map(|s| {
                    let mut row = zero;
                    for (lane, word) in row.iter_mut().zip(block) {
                        *lane = real(word[s]);
                    }
                    row
                }));
            }
        }
        let levels = layer.tree_levels();
        let data = layer.operand_latency();
        let foot = data + 3;
        let tables_age = data + 1 - layer.rom_latency;
        let mut words = vec![0; levels + foot + 1];
        words[..layer.copy_latency].fill(1);
        words[tables_age] = 2 + layer.folds();
        words[data] = 1 + layer.folds();
        Self {
            pe,
            simd,
            x_bits: layer.quant.input.width(),
            w_bits: layer.quant.weight_format.width(),
            sum_bits: layer.quant.sum_width,
            folds: layer.folds(),
            address_copies: layer.address_copies(device),
            hides_operands: device.hides_operands(),
            in_blocks: device.has_multipliers(),
            copy_latency: layer.copy_latency,
            tables,
            tables_age,
            data,
            foot,
            levels,
            weights,
            blocks,
            operands: vec![0.0; (levels + foot + 1) * simd],
            words,
            newest: 0,
            enable: false,
            first: false,
            accumulators: layer
                .accumulates()
                .then(|| vec![zero; layer.turns() * blocks]),
            turns: layer.turns(),
            turn: 0,
        }
    }

    /// Operands and weights, `[block][simd]`, of `age` clocks ago.
    #[inline(always)]
    fn history(&self, age: usize) -> (&[f64], &[Row]) {
        let slots = self.words.len();
        let slot = self.newest + age;
        let slot = if slot < slots { slot } else { slot - slots };
        let (words, word) = (self.simd * self.blocks, self.words[slot]);
        (
            &self.operands[slot * self.simd..][..self.simd],
            &self.weights[word * words..][..words],
        )
    }

    /// The address of `age` clocks ago.
    fn address(&self, age: usize) -> usize {
        let slots = self.words.len();
        self.words[(self.newest + age) % slots].saturating_sub(1)
    }

    /// The group whose sum came so many sums ago; the newest at 0.
    #[inline]
    fn group(&self, age: usize) -> usize {
        let group = self.turn + self.turns - 1 - age;
        if group < self.turns {
            group
        } else {
            group - self.turns
        }
    }

    /// Writes one sum an element: the accumulators, or the feet of the trees.
    #[inline]
    pub(super) fn sums(&self, sums: &mut [i64]) {
        if let Some(accumulators) = &self.accumulators {
            let newest = &accumulators[self.group(0) * self.blocks..];
            for (sum, real) in sums.iter_mut().zip(newest.as_flattened()) {
                *sum = code(*real);
            }
            return;
        }
        let (operands, weights) = self.history(self.foot + self.levels);
        let (blocks, rest) = sums.as_chunks_mut::<4>();
        let mut at = 0;
        for block in blocks {
            *block = dot(operands, &weights[at..]).map(code);
            at += self.simd;
        }
        if !rest.is_empty() {
            let foot = dot(operands, &weights[at..]);
            for (sum, real) in rest.iter_mut().zip(foot) {
                *sum = code(real);
            }
        }
    }

    /// `enable`, `first`: control bits a clock ahead of the foot of the trees.
    #[inline]
    pub(super) fn step(
        &mut self,
        operands: impl Iterator<Item = f64>,
        address: usize,
        enable: bool,
        first: bool,
    ) {
        if self.enable
            && let Some(mut accumulators) = self.accumulators.take()
        {
            let (operands, weights) = self.history(self.foot + self.levels);
            let mut at = 0;
            for sum in &mut accumulators[self.turn * self.blocks..][..self.blocks] {
                let foot = dot(operands, &weights[at..]);
                *sum = if self.first { foot } else { add(sum, &foot) };
                at += self.simd;
            }
            self.accumulators = Some(accumulators);
            self.turn += 1;
            if self.turn == self.turns {
                self.turn = 0;
            }
        }
        (self.enable, self.first) = (enable, first);
        // The oldest slot becomes the newest.
        self.newest = self.newest.checked_sub(1).unwrap_or(self.words.len() - 1);
        self.words[self.newest] = 1 + address;
        let slot = &mut self.operands[self.newest * self.simd..][..self.simd];
        for (own, operand) in slot.iter_mut().zip(operands) {
            *own = operand;
        }
    }

    /// The operands that are shown: `operands_q` of the layer at age 0, those of an element later.
    pub(super) fn show_operands<P: Probe>(&self, name: &str, age: usize, probe: &mut P) {
        let operands: Vec<i64> = self.history(age).0.iter().copied().map(code).collect();
        probe.words(name, self.x_bits, &operands);
    }

    /// The tables that a ROM of several is built of, each with its word of the clock, and the bits of
    /// the address by which one of them is chosen.
    fn show_tables<P: Probe>(&self, p: usize, probe: &mut P) {
        let (Some(least), true) = (self.tables.last(), self.tables.len() > 1) else {
            return;
        };
        let slot = (self.newest + self.tables_age) % self.words.len();
        let address = Some(self.words[slot] - 1).filter(|address| *address < self.folds);
        let mut first = 0;
        for (table, depth) in self.tables.iter().enumerate() {
            let row = match address.map(|address| first + address % depth) {
                None => 2 + self.folds + table,
                Some(word) if word < self.folds => 1 + word,
                Some(_) => 0,
            };
            let block = &self.weights[(row * self.blocks + p / 4) * self.simd..][..self.simd];
            let codes: Vec<i64> = block.iter().map(|row| code(row[p % 4])).collect();
            probe.words(&format!("table{table}_q"), self.w_bits, &codes);
            first += depth;
        }
        let above = i64::try_from(address.unwrap_or(0) / least).expect("an address");
        let bits = address_bits(self.folds) - least.ilog2();
        probe.words("above_q", bits, &vec![above; self.address_copies]);
    }

    pub(super) fn show<P: Probe>(&self, probe: &mut P) {
        for p in 0..self.pe {
            let weights = |age| -> Vec<i64> {
                let own = self.history(age).1.chunks_exact(self.simd).nth(p / 4);
                let own = own.expect("a block of the element");
                own.iter().map(|row| code(row[p % 4])).collect()
            };
            let products = |age| -> Vec<i64> {
                let operands = self.history(age).0;
                let pairs = operands.iter().zip(weights(age));
                pairs.map(|(a, b)| code(*a) * b).collect()
            };
            let (a, b) = (self.history(self.data + 1).0, weights(self.data + 1));
            let (a2, b2) = (self.history(self.data + 2).0, weights(self.data + 2));
            let (p_q, r_q) = (products(self.data + 2), products(self.data + 3));
            within(probe, format_args!("u_w{p}"), |probe| {
                if self.copy_latency > 0 {
                    let bits = address_bits(self.folds);
                    probe.count("address_q", bits, self.address(0));
                    let address = i64::try_from(self.address(1)).expect("an address");
                    probe.words("address_q2", bits, &vec![address; self.address_copies]);
                }
                self.show_tables(p, probe);
                probe.words("data_q", self.w_bits, &weights(self.data));
            });
            within(probe, format_args!("u_pe{p}"), |probe| {
                for age in 1..=self.data {
                    match age {
                        1 => self.show_operands("operands_q", age, probe),
                        _ => self.show_operands(&format!("operands_q{age}"), age, probe),
                    }
                }
                if self.accumulators.is_some() {
                    probe.bit("enable_q", self.enable);
                    probe.bit("first_q", self.first);
                }
                for s in 0..self.simd {
                    within(probe, format_args!("g_mul[{s}]"), |probe| {
                        within(probe, format_args!("u_mul"), |probe| {
                            if !self.hides_operands {
                                probe.word("a_q", self.x_bits, code(a[s]));
                                probe.word("b_q", self.w_bits, b[s]);
                                probe.word("p_q", self.x_bits + self.w_bits, p_q[s]);
                            } else if self.in_blocks {
                                show_wide(probe, self.x_bits, self.w_bits);
                            } else {
                                let operands = [(code(a[s]), b[s]), (code(a2[s]), b2[s])];
                                show_adders(probe, (self.x_bits, self.w_bits), operands);
                            }
                            probe.word("r_q", self.x_bits + self.w_bits, r_q[s]);
                        });
                    });
                }
                let mut bits = self.x_bits + self.w_bits;
                for level in 1..=self.levels {
                    bits = (bits + 1).min(self.sum_bits);
                    let sums =
                        (0..level).fold(products(self.foot + level), |words, _| halve(&words));
                    within(probe, format_args!("u_level{level}"), |probe| {
                        probe.words("sum_q", bits, &sums);
                    });
                }
                if let Some(accumulators) = &self.accumulators {
                    within(probe, format_args!("u_acc"), |probe| {
                        let sum =
                            |age| code(accumulators[self.group(age) * self.blocks + p / 4][p % 4]);
                        let sums: Vec<i64> = (0..self.turns).map(sum).collect();
                        probe.words("sum_q", self.sum_bits, &sums);
                    });
                }
            });
        }
    }
}

/// What registers of these words start with, `[element][simd]` as each of them.
fn start(words: &[Vec<Vec<i64>>], rom_words: usize, device: &Device) -> Vec<Vec<i64>> {
    let weight = |p: usize, s: usize| {
        let codes: Vec<i64> = words.iter().map(|word| word[p][s]).collect();
        device.rom_start(&codes, rom_words)
    };
    let elements = words[0].iter().enumerate();
    let element = |(p, own): (usize, &Vec<i64>)| (0..own.len()).map(|s| weight(p, s)).collect();
    elements.map(element).collect()
}

/// One level of an adder tree: sums of neighbours, an odd last word passing through.
fn halve(words: &[i64]) -> Vec<i64> {
    words.chunks(2).map(|pair| pair.iter().sum()).collect()
}

/// The feet of four trees.
#[inline]
fn dot(operands: &[f64], weights: &[Row]) -> Row {
    let mut sums = [[0.0; 4]; 2];
    let weights = &weights[..operands.len()];
    // Even and odd ones apart, so that no addition waits for the one before.
    let ((pairs, last), (rows, last_row)) = (operands.as_chunks::<2>(), weights.as_chunks::<2>());
    for (a, row) in pairs.iter().zip(rows) {
        sums[0] = add(&sums[0], &row[0].map(|w| w * a[0]));
        sums[1] = add(&sums[1], &row[1].map(|w| w * a[1]));
    }
    for (a, row) in last.iter().zip(last_row) {
        sums[0] = add(&sums[0], &row.map(|w| w * a));
    }
    add(&sums[0], &sums[1])
}

#[inline]
fn add(left: &Row, right: &Row) -> Row {
    [
        left[0] + right[0],
        left[1] + right[1],
        left[2] + right[2],
        left[3] + right[3],
    ]
}

#[inline]
#[expect(clippy::cast_precision_loss, reason = "words have at most 52 bits")]
pub(super) fn real(code: i64) -> f64 {
    code as f64
}

/// The integer that a sum is, by way of a constant that moves it into the lowest bits.
#[inline]
pub(super) fn code(sum: f64) -> i64 {
    const SHIFT: f64 = 6_755_399_441_055_744.0; // 1.5 * 2^52
    (sum + SHIFT)
        .to_bits()
        .wrapping_sub(SHIFT.to_bits())
        .cast_signed()
}

/// `hwg_group`.
#[derive(Clone, Debug)]
pub(super) struct Group {
    copies: usize,
    pub(super) done: bool,
    pub(super) flag: bool,
    /// `done_q`, `flag_q`: what the other two, `done_q2` and `flag_q2`, will be.
    done_next: bool,
    flag_next: bool,
}

impl Group {
    pub(super) fn new(copies: usize) -> Self {
        Self {
            copies,
            done: false,
            flag: false,
            done_next: false,
            flag_next: false,
        }
    }

    #[inline]
    pub(super) fn step(&mut self, reset: bool, control: super::feed::Control) {
        self.done = !reset && self.done_next;
        self.flag = self.flag_next;
        self.done_next = !reset && control.valid && control.last;
        if control.valid {
            self.flag_next = (self.flag_next && !control.first) || control.flag;
        }
    }

    pub(super) fn show<P: Probe>(&self, probe: &mut P) {
        probe.bit("done_q", self.done_next);
        for copy in 0..self.copies {
            within(probe, format_args!("g_copy[{copy}]"), |probe| {
                probe.bit("done_q2", self.done);
            });
        }
        probe.bit("flag_q", self.flag_next);
        probe.bit("flag_q2", self.flag);
    }
}

/// `hwg_drain`.
#[derive(Clone, Debug)]
pub(super) struct Drain {
    bits: u32,
    lanes: usize,
    beats: usize,
    words: Vec<i64>,
    left: usize,
    flag: bool,
}

impl Drain {
    pub(super) fn new(words: usize, lanes: usize, bits: u32) -> Self {
        Self {
            bits,
            lanes,
            beats: words / lanes,
            words: vec![0; words],
            left: 0,
            flag: false,
        }
    }

    #[inline]
    pub(super) fn valid(&self) -> bool {
        self.left != 0
    }

    #[inline]
    pub(super) fn flag(&self) -> bool {
        self.flag
    }

    #[inline]
    pub(super) fn words(&self) -> &[i64] {
        &self.words[..self.lanes]
    }

    /// `put` writes all sums of the array.
    #[inline]
    pub(super) fn step(
        &mut self,
        reset: bool,
        load: bool,
        flag: bool,
        put: impl FnOnce(&mut [i64]),
    ) {
        let valid = self.valid();
        if load {
            put(&mut self.words);
            self.flag = flag;
        } else {
            self.words.copy_within(self.lanes.., 0);
        }
        self.left = match (reset, load) {
            (true, _) => 0,
            (_, true) => self.beats,
            _ => self.left - usize::from(valid),
        };
    }

    pub(super) fn show<P: Probe>(&self, probe: &mut P) {
        probe.words("word_q", self.bits, &self.words);
        probe.count("left_q", counter_bits(self.beats), self.left);
        probe.bit("flag_q", self.flag);
    }
}
