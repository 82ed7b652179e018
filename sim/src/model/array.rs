//! The array of a layer: weight ROMs, multipliers, adder trees, accumulators, drain.

use hwgen_spec::design::Layer;

use super::probe::{Probe, counter_bits, within};

/// All processing elements of a layer, each with its weight ROM.
///
/// Two registers are kept in a form that is quicker to step: the ROM's word and the multiplier's
/// weight operand as the address of the word that they hold.
/// The words of a level stand in the order of [`tree_orders`], so that a level of the trees of all
/// elements is the sum of two slices.
///
/// # Shape
/// Word `w` of element `p` stands at `place(w) * pe + p`.
#[derive(Clone, Debug)]
pub(super) struct Array {
    pe: usize,
    simd: usize,
    x_bits: u32,
    w_bits: u32,
    sum_bits: u32,
    /// `[1 + fold][simd * pe]`; word 0 is the zero of power-up.
    weights: Vec<i32>,
    /// Word in the ROM's register.
    rom: usize,
    /// Word in the multipliers' weight operands.
    b: usize,
    a: Vec<i32>,
    /// What stands in `a`, in order.
    latest: Vec<i64>,
    products: Vec<i64>,
    /// One vector a level.
    levels: Vec<Vec<i64>>,
    accumulators: Option<Vec<i64>>,
    /// The word at each place, of the products and of each level.
    orders: Vec<Vec<usize>>,
}

impl Array {
    pub(super) fn new(layer: &Layer) -> Self {
        let (pe, simd) = (layer.fold.pe, layer.fold.simd);
        let orders = tree_orders(simd);
        let mut weights = vec![0; pe * simd];
        for fold in 0..layer.folds() {
            let words: Vec<Vec<i64>> = (0..pe).map(|p| layer.weight_word(p, fold)).collect();
            weights.extend(
                orders[0]
                    .iter()
                    .flat_map(|s| words.iter().map(|w| narrow(w[*s]))),
            );
        }
        let levels = orders[1..]
            .iter()
            .map(|order| vec![0; pe * order.len()])
            .collect();
        Self {
            pe,
            simd,
            x_bits: layer.quant.input.width(),
            w_bits: layer.quant.weight_format.width(),
            sum_bits: layer.quant.sum_width,
            weights,
            rom: 0,
            b: 0,
            a: vec![0; pe * simd],
            latest: vec![0; simd],
            products: vec![0; pe * simd],
            levels,
            accumulators: layer.accumulates().then(|| vec![0; pe]),
            orders,
        }
    }

    /// One sum an element: the accumulators, or the foot of the trees.
    pub(super) fn sums(&self) -> &[i64] {
        let feet = self.levels.last().unwrap_or(&self.products);
        self.accumulators.as_deref().unwrap_or(feet)
    }

    fn word(&self, at: usize) -> &[i32] {
        &self.weights[at * self.products.len()..(at + 1) * self.products.len()]
    }

    /// `enable`, `first`: control bits that have kept pace with the trees.
    pub(super) fn step(&mut self, operands: &[i64], address: usize, enable: bool, first: bool) {
        if enable && let Some(accumulators) = &mut self.accumulators {
            let feet = self.levels.last().unwrap_or(&self.products);
            for (sum, word) in accumulators.iter_mut().zip(feet) {
                *sum = if first { 0 } else { *sum } + word;
            }
        }
        for level in (0..self.levels.len()).rev() {
            let (before, this) = self.levels.split_at_mut(level);
            let words = before.last().unwrap_or(&self.products);
            let pairs = words.len() - this[0].len();
            let (left, rest) = words.split_at(pairs);
            let (right, odd) = rest.split_at(pairs);
            let (sums, passed) = this[0].split_at_mut(pairs);
            for ((sum, left), right) in sums.iter_mut().zip(left).zip(right) {
                *sum = left + right;
            }
            // An odd last word passes through.
            passed.copy_from_slice(odd);
        }
        let words = self.products.len();
        let weights = &self.weights[self.b * words..(self.b + 1) * words];
        for ((product, a), weight) in self.products.iter_mut().zip(&self.a).zip(weights) {
            *product = i64::from(*a) * i64::from(*weight);
        }
        // A vector that is replayed for many groups of neurons seldom changes.
        if self.latest != operands {
            self.latest.copy_from_slice(operands);
            for (a, word) in self.a.chunks_exact_mut(self.pe).zip(&self.orders[0]) {
                a.fill(narrow(operands[*word]));
            }
        }
        self.b = self.rom;
        self.rom = 1 + address;
    }

    pub(super) fn show<P: Probe>(&self, probe: &mut P) {
        let (pe, simd) = (self.pe, self.simd);
        // Words of an element in their own order.
        let ordered = |level: usize, word: &dyn Fn(usize) -> i64| -> Vec<i64> {
            let mut row = vec![0; self.orders[level].len()];
            for (place, at) in self.orders[level].iter().enumerate() {
                row[*at] = word(place);
            }
            row
        };
        for p in 0..pe {
            let rom = ordered(0, &|place| self.word(self.rom)[place * pe + p].into());
            let a = ordered(0, &|place| self.a[place * pe + p].into());
            let b = ordered(0, &|place| self.word(self.b)[place * pe + p].into());
            let products = ordered(0, &|place| self.products[place * pe + p]);
            within(probe, format_args!("u_w{p}"), |probe| {
                probe.words("data_q", self.w_bits, &rom)
            });
            within(probe, format_args!("u_pe{p}"), |probe| {
                for s in 0..simd {
                    within(probe, format_args!("g_mul[{s}]"), |probe| {
                        within(probe, format_args!("u_mul"), |probe| {
                            probe.word("a_q", self.x_bits, a[s]);
                            probe.word("b_q", self.w_bits, b[s]);
                            probe.word("p_q", self.x_bits + self.w_bits, products[s]);
                        });
                    });
                }
                let mut bits = self.x_bits + self.w_bits;
                for (number, level) in self.levels.iter().enumerate() {
                    bits = (bits + 1).min(self.sum_bits);
                    let row = ordered(number + 1, &|place| level[place * pe + p]);
                    within(probe, format_args!("u_level{}", number + 1), |probe| {
                        probe.words("sum_q", bits, &row);
                    });
                }
                if let Some(accumulators) = &self.accumulators {
                    within(probe, format_args!("u_acc"), |probe| {
                        probe.word("sum_q", self.sum_bits, accumulators[p]);
                    });
                }
            });
        }
    }
}

fn narrow(word: i64) -> i32 {
    i32::try_from(word).expect("an operand has at most 24 bits")
}

/// For each level of a tree over `words` words, the word at each place: first the left words of
/// all pairs, then the right ones, an odd last word last; the pairs in the order of their sums.
fn tree_orders(words: usize) -> Vec<Vec<usize>> {
    if words == 1 {
        return vec![vec![0]];
    }
    let above = tree_orders(words.div_ceil(2));
    let pairs = || above[0].iter().filter(|sum| 2 * **sum + 1 < words);
    let mut order: Vec<usize> = pairs().map(|sum| 2 * sum).collect();
    order.extend(pairs().map(|sum| 2 * sum + 1));
    order.extend((words % 2 == 1).then(|| words - 1));
    [vec![order], above].concat()
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
