//! The array of a layer: weight ROMs, multipliers, adder trees, accumulators, drain.

use hwgen_spec::design::Layer;

use super::probe::{Probe, counter_bits, within};

/// One word of four processing elements.
///
/// Words are kept in double precision, whose arithmetic vectorises on every machine and is exact
/// here: sums have at most 52 bits.
type Row = [f64; 4];

/// All processing elements of a layer, each with its weight ROM.
///
/// Two registers are kept in a form that is quicker to step: the ROM's word and the multiplier's
/// weight operand as the address of the word that they hold, and the multipliers' other operand,
/// which all elements have alike, once.
///
/// # Shape
/// `[word][block]`, a block being four elements; elements beyond the last are zero.
#[derive(Clone, Debug)]
pub(super) struct Array {
    pe: usize,
    simd: usize,
    blocks: usize,
    x_bits: u32,
    w_bits: u32,
    sum_bits: u32,
    /// `[1 + fold][simd][block]`; word 0 is the zero of power-up.
    weights: Vec<Row>,
    /// Word in the ROM's register.
    rom: usize,
    /// Word in the multipliers' weight operands.
    b: usize,
    /// `[simd]`
    a: Vec<f64>,
    products: Vec<Row>,
    /// One vector a level.
    levels: Vec<Vec<Row>>,
    accumulators: Option<Vec<Row>>,
    sums: Vec<i64>,
}

impl Array {
    pub(super) fn new(layer: &Layer) -> Self {
        let (pe, simd) = (layer.fold.pe, layer.fold.simd);
        let blocks = pe.div_ceil(4);
        let zero = [0.0; 4];
        let mut weights = vec![zero; simd * blocks];
        for fold in 0..layer.folds() {
            let words: Vec<Vec<i64>> = (0..pe).map(|p| layer.weight_word(p, fold)).collect();
            for s in 0..simd {
                weights.extend(words.chunks(4).map(|block| {
                    let mut row = zero;
                    for (lane, word) in row.iter_mut().zip(block) {
                        *lane = real(word[s]);
                    }
                    row
                }));
            }
        }
        let mut words = simd;
        let levels = (0..layer.tree_levels())
            .map(|_| {
                words = words.div_ceil(2);
                vec![zero; words * blocks]
            })
            .collect();
        Self {
            pe,
            simd,
            blocks,
            x_bits: layer.quant.input.width(),
            w_bits: layer.quant.weight_format.width(),
            sum_bits: layer.quant.sum_width,
            weights,
            rom: 0,
            b: 0,
            a: vec![0.0; simd],
            products: vec![zero; simd * blocks],
            levels,
            accumulators: layer.accumulates().then(|| vec![zero; blocks]),
            sums: vec![0; pe],
        }
    }

    /// One sum an element: the accumulators, or the foot of the trees.
    pub(super) fn sums(&self) -> &[i64] {
        &self.sums
    }

    fn word(&self, at: usize) -> &[Row] {
        let words = self.products.len();
        &self.weights[at * words..(at + 1) * words]
    }

    /// `enable`, `first`: control bits that have kept pace with the trees.
    pub(super) fn step(&mut self, operands: &[i64], address: usize, enable: bool, first: bool) {
        let blocks = self.blocks;
        if enable && let Some(accumulators) = &mut self.accumulators {
            let feet = self.levels.last().unwrap_or(&self.products);
            for (sum, word) in accumulators.iter_mut().zip(feet) {
                *sum = if first { *word } else { add(sum, word) };
            }
        }
        for level in (0..self.levels.len()).rev() {
            let (before, this) = self.levels.split_at_mut(level);
            let words = before.last().unwrap_or(&self.products);
            let sums = &mut this[0];
            if blocks == 1 {
                for (sum, pair) in sums.iter_mut().zip(words.chunks_exact(2)) {
                    *sum = add(&pair[0], &pair[1]);
                }
            } else {
                let pairs = words.chunks_exact(2 * blocks);
                for (sums, pair) in sums.chunks_exact_mut(blocks).zip(pairs) {
                    let (left, right) = pair.split_at(blocks);
                    for ((sum, left), right) in sums.iter_mut().zip(left).zip(right) {
                        *sum = add(left, right);
                    }
                }
            }
            // An odd last word passes through.
            if words.len() != 2 * sums.len() {
                let at = sums.len() - blocks;
                sums[at..].copy_from_slice(&words[2 * at..]);
            }
        }
        let words = self.products.len();
        let weights = &self.weights[self.b * words..(self.b + 1) * words];
        if blocks == 1 {
            for ((product, weight), a) in self.products.iter_mut().zip(weights).zip(&self.a) {
                *product = weight.map(|w| w * a);
            }
        } else {
            let rows = self
                .products
                .chunks_exact_mut(blocks)
                .zip(weights.chunks_exact(blocks));
            for ((products, weights), a) in rows.zip(&self.a) {
                for (product, weight) in products.iter_mut().zip(weights) {
                    *product = weight.map(|w| w * a);
                }
            }
        }
        for (a, operand) in self.a.iter_mut().zip(operands) {
            *a = real(*operand);
        }
        self.b = self.rom;
        self.rom = 1 + address;
        let feet = self.levels.last().unwrap_or(&self.products);
        let feet = self.accumulators.as_ref().unwrap_or(feet);
        for (sum, foot) in self.sums.iter_mut().zip(feet.as_flattened()) {
            *sum = code(*foot);
        }
    }

    pub(super) fn show<P: Probe>(&self, probe: &mut P) {
        let blocks = self.blocks;
        for p in 0..self.pe {
            let element = |rows: &[Row]| -> Vec<i64> {
                rows.iter()
                    .skip(p / 4)
                    .step_by(blocks)
                    .map(|row| code(row[p % 4]))
                    .collect()
            };
            let (rom, b) = (element(self.word(self.rom)), element(self.word(self.b)));
            let products = element(&self.products);
            within(probe, format_args!("u_w{p}"), |probe| {
                probe.words("data_q", self.w_bits, &rom)
            });
            within(probe, format_args!("u_pe{p}"), |probe| {
                for s in 0..self.simd {
                    within(probe, format_args!("g_mul[{s}]"), |probe| {
                        within(probe, format_args!("u_mul"), |probe| {
                            probe.word("a_q", self.x_bits, code(self.a[s]));
                            probe.word("b_q", self.w_bits, b[s]);
                            probe.word("p_q", self.x_bits + self.w_bits, products[s]);
                        });
                    });
                }
                let mut bits = self.x_bits + self.w_bits;
                for (number, level) in self.levels.iter().enumerate() {
                    bits = (bits + 1).min(self.sum_bits);
                    within(probe, format_args!("u_level{}", number + 1), |probe| {
                        probe.words("sum_q", bits, &element(level));
                    });
                }
                if let Some(accumulators) = &self.accumulators {
                    within(probe, format_args!("u_acc"), |probe| {
                        probe.word("sum_q", self.sum_bits, element(accumulators)[0]);
                    });
                }
            });
        }
    }
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
fn real(code: i64) -> f64 {
    code as f64
}

/// The integer that a sum is, by way of a constant that moves it into the lowest bits.
#[inline]
fn code(sum: f64) -> i64 {
    const SHIFT: f64 = 6_755_399_441_055_744.0; // 1.5 * 2^52
    (sum + SHIFT)
        .to_bits()
        .wrapping_sub(SHIFT.to_bits())
        .cast_signed()
}

/// `hwg_group`.
#[derive(Clone, Debug, Default)]
pub(super) struct Group {
    pub(super) done: bool,
    pub(super) flag: bool,
}

impl Group {
    pub(super) fn step(&mut self, reset: bool, control: super::feed::Control) {
        self.done = !reset && control.valid && control.last;
        if control.valid {
            self.flag = (self.flag && !control.first) || control.flag;
        }
    }

    pub(super) fn show<P: Probe>(&self, probe: &mut P) {
        probe.bit("done_q", self.done);
        probe.bit("flag_q", self.flag);
    }
}

/// `hwg_drain`.
#[derive(Clone, Debug)]
pub(super) struct Drain {
    bits: u32,
    lanes: usize,
    words: Vec<i64>,
    left: usize,
    flag: bool,
}

impl Drain {
    pub(super) fn new(words: usize, lanes: usize, bits: u32) -> Self {
        Self {
            bits,
            lanes,
            words: vec![0; words],
            left: 0,
            flag: false,
        }
    }

    pub(super) fn valid(&self) -> bool {
        self.left != 0
    }

    pub(super) fn flag(&self) -> bool {
        self.flag
    }

    pub(super) fn words(&self) -> &[i64] {
        &self.words[..self.lanes]
    }

    pub(super) fn step(&mut self, reset: bool, load: bool, flag: bool, words: &[i64]) {
        let valid = self.valid();
        if load {
            self.words.copy_from_slice(words);
            self.flag = flag;
        } else if valid {
            self.words.copy_within(self.lanes.., 0);
        }
        self.left = match (reset, load) {
            (true, _) => 0,
            (_, true) => self.words.len() / self.lanes,
            _ => self.left - usize::from(valid),
        };
    }

    pub(super) fn show<P: Probe>(&self, probe: &mut P) {
        probe.words("word_q", self.bits, &self.words);
        probe.count(
            "left_q",
            counter_bits(self.words.len() / self.lanes),
            self.left,
        );
        probe.bit("flag_q", self.flag);
    }
}
