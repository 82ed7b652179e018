//! The adders that take the place of an array, `hwg_add` and the words that wait for a later level.

use std::sync::Arc;

use hwgen_spec::adders::{Adders, Source, Term};
use hwgen_spec::design::Layer;

use super::probe::{Probe, within};

/// `u_adders` of a layer.
#[derive(Clone, Debug)]
pub(super) struct Sums {
    adders: Arc<Adders>,
    bits: u32,
    /// `[input][age - 1]`: words of the vector of clocks before.
    inputs: Vec<Vec<i64>>,
    /// `[adder][age]`: its sum, and those of clocks before.
    sums: Vec<Vec<i64>>,
}

impl Sums {
    /// None where the layer has an array.
    pub(super) fn new(layer: &Layer) -> Option<Self> {
        layer.adders()?;
        let adders = Arc::clone(layer.quant.adders.as_ref()?);
        Some(Self {
            bits: layer.quant.input.width(),
            inputs: adders.input_waits.iter().map(|n| vec![0; *n]).collect(),
            sums: adders.adder_waits.iter().map(|n| vec![0; 1 + n]).collect(),
            adders,
        })
    }

    /// What an adder or output of `level` reads: the word came as many clocks before as it has levels
    /// less. `vector` is that of this clock.
    fn read(&self, term: Term, level: usize, vector: &[i64]) -> i64 {
        let word = match term.source {
            Source::Input(i) if level == 1 => vector[i],
            Source::Input(i) => self.inputs[i][level - 2],
            Source::Adder(k) => self.sums[k][level - 1 - self.adders.adders[k].level],
        };
        word << term.shift
    }

    /// Writes the sums.
    pub(super) fn sums(&self, sums: &mut [i64]) {
        for (sum, term) in sums.iter_mut().zip(&self.adders.outputs) {
            *sum = term.map_or(0, |term| self.read(term, self.adders.levels + 1, &[]));
        }
    }

    pub(super) fn step(&mut self, vector: &[i64]) {
        // From the last to the first, so that each still sees those that it reads as they were.
        for k in (0..self.sums.len()).rev() {
            let adder = &self.adders.adders[k];
            let a = adder
                .a
                .map_or(0, |term| self.read(term, adder.level, vector));
            let b = self.read(adder.b, adder.level, vector);
            let sum = if adder.subtract { a - b } else { a + b };
            self.sums[k].rotate_right(1);
            self.sums[k][0] = sum;
        }
        for (waiting, word) in self.inputs.iter_mut().zip(vector) {
            if !waiting.is_empty() {
                waiting.rotate_right(1);
                waiting[0] = *word;
            }
        }
    }

    pub(super) fn show<P: Probe>(&self, probe: &mut P) {
        within(probe, format_args!("u_adders"), |probe| {
            let name = |word: &str, i: usize, age: usize| match age {
                1 => format!("{word}{i}_q"),
                _ => format!("{word}{i}_q{age}"),
            };
            for (i, words) in self.inputs.iter().enumerate() {
                for (age, word) in (1..).zip(words) {
                    probe.word(&name("x", i, age), self.bits, *word);
                }
            }
            for (k, (sums, adder)) in self.sums.iter().zip(&self.adders.adders).enumerate() {
                within(probe, format_args!("u_add{k}"), |probe| {
                    probe.word("sum_q", adder.width, sums[0]);
                });
                for (age, sum) in (1..).zip(&sums[1..]) {
                    probe.word(&name("sum", k, age), adder.width, *sum);
                }
            }
        });
    }
}
