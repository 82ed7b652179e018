//! The untimed model: what the hardware computes, with no notion of a clock.

use crate::format::{Rounding, Saturated, shift_right};
use crate::network::Activation;
use crate::quantize::{InputFormat, QuantLayer, QuantNet};

mod batch;

pub use batch::{Batch, BatchAnswers};

/// What one frame of inputs leads to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Answer {
    /// Output codes of all networks in stream order.
    pub codes: Vec<i64>,
    /// An input was outside the box and was clipped to it.
    pub input_clipped: bool,
    /// A word inside was beyond its format and was saturated.
    pub saturated: bool,
}

impl InputFormat {
    /// Rounds raw inputs to codes; what the word can't hold is saturated.
    pub fn codes(&self, raw: &[f64]) -> Vec<i64> {
        self.words(raw).map(|word| word.code).collect()
    }

    /// Whether raw inputs lie outside of the box by more than rounding.
    pub fn outside(&self, raw: &[f64]) -> bool {
        let mut wide = false;
        let mut codes: Vec<i64> = self
            .words(raw)
            .map(|word| {
                wide |= word.clipped;
                word.code
            })
            .collect();
        self.clip(&mut codes) || wide
    }

    fn words(&self, raw: &[f64]) -> impl Iterator<Item = Saturated> {
        let values = raw.iter().zip(&self.formats);
        values.map(|(v, format)| format.quantize(*v, Rounding::HalfUp))
    }

    /// Raw inputs that codes stand for.
    pub fn values(&self, codes: &[i64]) -> Vec<f64> {
        let words = codes.iter().zip(&self.formats);
        words.map(|(code, format)| format.to_f64(*code)).collect()
    }

    /// Clips codes to the box, as the hardware does first; true if one was outside.
    pub fn clip(&self, codes: &mut [i64]) -> bool {
        let mut clipped = false;
        for (code, (low, high)) in codes.iter_mut().zip(self.low.iter().zip(&self.high)) {
            let inside = (*code).clamp(*low, *high);
            clipped |= inside != *code;
            *code = inside;
        }
        clipped
    }
}

impl QuantLayer {
    /// The argument of the activation of neuron `i` for its sum of products.
    pub fn argument(&self, i: usize, sum: i64) -> i64 {
        let biased = (sum << self.product_shift) + self.bias[i];
        let shift = self.base_shift + self.extra_shift[i];
        shift_right(biased, shift, Rounding::Floor)
    }

    /// Bias, shift, saturation and activation of neuron `i` for its sum of products.
    pub fn finish(&self, i: usize, sum: i64) -> Saturated {
        let z = self.argument(i, sum);
        match (&self.table, self.activation) {
            // Clipping the argument is part of the function, not an overflow.
            (Some(table), activation) => {
                let t = table.apply(z);
                let one = 1i64 << table.fraction();
                let code = if activation == Activation::Sigmoid {
                    one + t
                } else {
                    t
                };
                Saturated {
                    code,
                    clipped: false,
                }
            }
            (None, Activation::Relu) => self.pre.saturate(z.max(0)),
            (None, _) => self.pre.saturate(z),
        }
    }

    /// The layer's output codes; `saturated` is raised if a word was clipped.
    pub fn apply(&self, x: &[i64], saturated: &mut bool) -> Vec<i64> {
        self.weights
            .iter()
            .enumerate()
            .map(|(i, row)| {
                let sum = row.iter().zip(x).map(|(w, x)| w * x).sum();
                let y = self.finish(i, sum);
                *saturated |= y.clipped;
                y.code
            })
            .collect()
    }
}

impl QuantNet {
    /// Evaluates one frame of input codes.
    ///
    /// # Shape
    /// `codes`: `[in]`; answer: `[sum of the networks' outputs]`.
    pub fn evaluate(&self, codes: &[i64]) -> Answer {
        let mut x = codes.to_vec();
        let input_clipped = self.input.clip(&mut x);
        let mut saturated = false;
        for layer in &self.shared {
            x = layer.apply(&x, &mut saturated);
        }
        let mut codes = Vec::new();
        for network in &self.networks {
            let mut y = x.clone();
            for layer in &network.layers {
                y = layer.apply(&y, &mut saturated);
            }
            codes.extend(y);
        }
        Answer {
            codes,
            input_clipped,
            saturated,
        }
    }

    /// Output codes in real units, in stream order.
    pub fn real_outputs(&self, codes: &[i64]) -> Vec<f64> {
        let formats = self.networks.iter().flat_map(|n| {
            let last = n.layers.last().expect("a network has a layer");
            std::iter::repeat_n(last.output, last.outputs())
        });
        codes
            .iter()
            .zip(formats)
            .map(|(code, format)| format.to_f64(*code))
            .collect()
    }
}
