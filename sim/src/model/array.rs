//! The array of a layer: weight ROMs, multipliers, adder trees, accumulators, drain.

use hwgen_spec::design::Layer;

use super::probe::{Probe, counter_bits, within};

/// All processing elements of a layer, each with its weight ROM.
///
/// # Shape
/// Words of multiplier `s` of element `p` stand at `p * simd + s`; sums of a tree level at
/// `p * sums + i`.
#[derive(Clone, Debug)]
pub(super) struct Array {
    pe: usize,
    simd: usize,
    x_bits: u32,
    w_bits: u32,
    sum_bits: u32,
    /// `[fold][pe * simd]`
    weights: Vec<i64>,
    rom: Vec<i64>,
    a: Vec<i64>,
    b: Vec<i64>,
    products: Vec<i64>,
    /// One vector a level, `[pe * sums]`.
    levels: Vec<Vec<i64>>,
    accumulators: Option<Vec<i64>>,
}

impl Array {
    pub(super) fn new(layer: &Layer) -> Self {
        let (pe, simd) = (layer.fold.pe, layer.fold.simd);
        let weights = (0..layer.folds())
            .flat_map(|fold| (0..pe).flat_map(move |p| layer.weight_word(p, fold)))
            .collect();
        let mut sums = simd;
        let levels = (0..layer.tree_levels())
            .map(|_| {
                sums = sums.div_ceil(2);
                vec![0; pe * sums]
            })
            .collect();
        Self {
            pe,
            simd,
            x_bits: layer.quant.input.width(),
            w_bits: layer.quant.weight_format.width(),
            sum_bits: layer.quant.sum_width,
            weights,
            rom: vec![0; pe * simd],
            a: vec![0; pe * simd],
            b: vec![0; pe * simd],
            products: vec![0; pe * simd],
            levels,
            accumulators: layer.accumulates().then(|| vec![0; pe]),
        }
    }

    /// One sum an element: the accumulators, or the foot of the trees.
    pub(super) fn sums(&self) -> &[i64] {
        self.accumulators.as_deref().unwrap_or_else(|| self.feet())
    }

    fn feet(&self) -> &[i64] {
        self.levels.last().unwrap_or(&self.products)
    }

    /// `enable`, `first`: control bits that have kept pace with the trees.
    pub(super) fn step(&mut self, operands: &[i64], address: usize, enable: bool, first: bool) {
        if enable {
            let feet = self.levels.last().unwrap_or(&self.products);
            if let Some(accumulators) = &mut self.accumulators {
                for (sum, word) in accumulators.iter_mut().zip(feet) {
                    *sum = if first { 0 } else { *sum } + word;
                }
            }
        }
        for level in (0..self.levels.len()).rev() {
            let (before, this) = self.levels.split_at_mut(level);
            let words = before.last().unwrap_or(&self.products);
            let (inputs, sums) = (words.len() / self.pe, this[0].len() / self.pe);
            for (words, sums) in words
                .chunks_exact(inputs)
                .zip(this[0].chunks_exact_mut(sums))
            {
                for (pair, sum) in words.chunks(2).zip(sums) {
                    *sum = pair.iter().sum();
                }
            }
        }
        for (p, (a, b)) in self.products.iter_mut().zip(self.a.iter().zip(&self.b)) {
            *p = a * b;
        }
        for a in self.a.chunks_exact_mut(self.simd) {
            a.copy_from_slice(operands);
        }
        self.b.copy_from_slice(&self.rom);
        let words = self.rom.len();
        self.rom
            .copy_from_slice(&self.weights[address * words..(address + 1) * words]);
    }

    pub(super) fn show<P: Probe>(&self, probe: &mut P) {
        for p in 0..self.pe {
            let own = p * self.simd..(p + 1) * self.simd;
            within(probe, format_args!("u_w{p}"), |probe| {
                probe.words("data_q", self.w_bits, &self.rom[own.clone()]);
            });
            within(probe, format_args!("u_pe{p}"), |probe| {
                for (s, i) in own.enumerate() {
                    within(probe, format_args!("g_mul[{s}]"), |probe| {
                        within(probe, format_args!("u_mul"), |probe| {
                            probe.word("a_q", self.x_bits, self.a[i]);
                            probe.word("b_q", self.w_bits, self.b[i]);
                            probe.word("p_q", self.x_bits + self.w_bits, self.products[i]);
                        });
                    });
                }
                let mut bits = self.x_bits + self.w_bits;
                for (number, level) in self.levels.iter().enumerate() {
                    bits = (bits + 1).min(self.sum_bits);
                    let sums = level.len() / self.pe;
                    within(probe, format_args!("u_level{}", number + 1), |probe| {
                        probe.words("sum_q", bits, &level[p * sums..(p + 1) * sums]);
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
