//! One layer: its formats, its codes, the proof that its sums fit.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::cut::{NEARLY, Reader, relevant_magnitude};
use super::settings::{MAX_SEGMENTS, check_width};
use super::shift::{Inputs, extra_shifts, finer};
use super::{FoldedLayer, InputFormat, MAX_SUM_WIDTH, QuantLayer, QuantizeError};
use crate::activation::{FRACTION_RANGE, OddTable, range_log2};
use crate::adders::Adders;
use crate::format::{QFormat, Rounding, half, signed_width};
use crate::network::{Activation, FloatLayer, FloatNet};
use crate::options::{
    DEFAULT_BOUNDED_BITS, DEFAULT_DEEP_BOUNDED_BITS, DEFAULT_FINE_WEIGHT_BITS, DEFAULT_OUTPUT_BITS,
    DEFAULT_UNBOUNDED_BITS, DEFAULT_WEIGHT_BITS, OPERAND_BITS, Options, width_of,
};

/// Bits of a bias below the argument's last one, where the trainer fixed no format: finer ones would
/// move no argument by more than a thirty-second of a step, and take ROMs, adders and registers.
const BIAS_GUARD_BITS: u32 = 4;

/// The greatest magnitude of an unbounded word over its typical one.
const CREST: f64 = 8.0;

/// What flows between layers while formats are chosen.
#[derive(Clone)]
pub(super) struct Signal {
    pub(super) format: QFormat,
    /// Least and greatest code of each word, over the input box.
    range: Vec<(i64, i64)>,
    /// Typical distance of each word from its centre, in real units.
    spread: Vec<f64>,
    /// What the first layer subtracts from raw inputs.
    centre: Option<Vec<f64>>,
}

impl Signal {
    pub(super) fn raw(net: &FloatNet, input: &InputFormat) -> Self {
        let edges = net.inputs.min.iter().zip(&net.inputs.max);
        Self {
            format: input.format,
            range: input
                .low
                .iter()
                .copied()
                .zip(input.high.iter().copied())
                .collect(),
            // The standard deviation of a uniform distribution over the box.
            spread: edges.map(|(min, max)| (max - min) / 12f64.sqrt()).collect(),
            centre: Some(net.inputs.offset.clone()),
        }
    }
}

/// Quantizes layers one after the other, sharing activation tables.
pub(super) struct Quantizer<'a> {
    pub(super) options: &'a Options,
    /// Bits of an operand that a multiplier of the device takes, and so the most of a width that
    /// nobody sets.
    pub(super) multiplier_bits: u32,
    /// Whether a network has several tanh or sigmoid layers in front of its last one.
    pub(super) deep: bool,
    pub(super) tables: BTreeMap<u32, Arc<OddTable>>,
}

/// The formats behind the sum.
struct Behind {
    pre: QFormat,
    output: QFormat,
    table: Option<Arc<OddTable>>,
}

impl Quantizer<'_> {
    /// One layer in integers, and the signal that it puts out.
    pub(super) fn layer(
        &mut self,
        (name, layer): &FoldedLayer,
        (network, index): (&str, usize),
        input: &Signal,
        readers: &[Reader],
    ) -> Result<(QuantLayer, Signal), QuantizeError> {
        let weight_format = self.weight_format(name, layer, !readers.is_empty())?;
        let bias_real = |weights: &[Vec<f64>]| centred_bias(layer, weights, input);
        let rows: Vec<Vec<f64>> = layer
            .weights
            .row_iter()
            .map(|r| r.iter().copied().collect())
            .collect();

        // First with the float weights, to see the range that the output format has to hold.
        let range = real_range(&rows, &bias_real(&rows), input);
        let provisional = self.behind(name, layer, range, readers)?;
        let extra_shift = if layer.format.weights.is_some() {
            vec![0; rows.len()]
        } else {
            let inputs = Inputs {
                step: input.format.step(),
                spread: &input.spread,
            };
            extra_shifts(&rows, weight_format, provisional.pre, &inputs)
        };

        let weights: Vec<Vec<i64>> = rows
            .iter()
            .zip(&extra_shift)
            .map(|(row, extra)| {
                let format = finer(weight_format, *extra);
                row.iter()
                    .map(|w| format.quantize(*w, Rounding::HalfUp).code)
                    .collect()
            })
            .collect();
        let unread = unread(&rows, &weights);
        let quantized: Vec<Vec<f64>> = weights
            .iter()
            .zip(&extra_shift)
            .map(|(row, extra)| {
                row.iter()
                    .map(|w| finer(weight_format, *extra).to_f64(*w))
                    .collect()
            })
            .collect();
        let bias_values = bias_real(&quantized);
        let proved_range = real_range(&quantized, &bias_values, input);
        let Behind { pre, output, table } = self.behind(name, layer, proved_range, readers)?;

        let product_fraction = input.format.fraction() + weight_format.fraction();
        let bias_fraction = layer
            .format
            .bias
            .map_or(product_fraction, QFormat::fraction);
        let biased_fraction = product_fraction.max(bias_fraction).max(pre.fraction());
        let product_shift = places(biased_fraction - product_fraction);
        let base_shift = places(biased_fraction - pre.fraction());
        // So far from the argument's binary point that not a bit of a product is in the sum.
        if (product_fraction - pre.fraction()).abs() > MAX_SUM_WIDTH.cast_signed() {
            return Err(magnitude(name, "weights", layer.weights.amax()));
        }

        let (mut sum_bound, mut bias_bound) = (0i64, 0i64);
        let mut bias = Vec::new();
        for (i, row) in weights.iter().enumerate() {
            let extra = extra_shift[i];
            let places = base_shift + extra;
            let zeros = match layer.format.bias {
                Some(_) => 0,
                // As far as any sum that is not refused is shifted.
                None => places.saturating_sub(BIAS_GUARD_BITS).min(MAX_SUM_WIDTH),
            };
            // 62 bits are wide enough to quantize any bias before its width is judged.
            let fraction = biased_fraction + extra.cast_signed() - zeros.cast_signed();
            let format = QFormat::new(62 - zeros, fraction)
                .map_err(|_| magnitude(name, "weights", layer.weights.amax()))?;
            let rounded = format.quantize(bias_values[i], Rounding::HalfUp).code;
            bias.push((rounded << zeros).saturating_add(half(places)));
            let magnitude: i64 = row.iter().map(|w| w.abs()).sum();
            sum_bound = sum_bound.max(magnitude << (input.format.width() - 1));
            bias_bound = bias_bound.max(bias[i].saturating_abs());
        }
        let biased_bound = i128::from(sum_bound) << product_shift.min(64);
        let biased_bound = i64::try_from(biased_bound + i128::from(bias_bound)).unwrap_or(i64::MAX);
        // A sum is at least a product wide, and a biased sum leaves a bit above the word by which
        // the saturation sees an overflow.
        let product_width = input.format.width() + weight_format.width();
        let sum_width = signed_width(-sum_bound, sum_bound).max(product_width);
        let biased_width = signed_width(-biased_bound, biased_bound)
            .max(sum_width + product_shift)
            .max(base_shift + pre.width() + 1);
        if biased_width > MAX_SUM_WIDTH {
            return Err(QuantizeError::SumWidth {
                layer: name.clone(),
                found: biased_width,
            });
        }

        let adders = Adders::of_short(&weights, input.format.width()).map(Arc::new);
        let quant = QuantLayer {
            name: name.clone(),
            network: network.to_owned(),
            index,
            activation: layer.activation,
            input: input.format,
            weight_format,
            weights,
            bias,
            extra_shift,
            unread,
            product_shift,
            base_shift,
            pre,
            output,
            table,
            adders,
            sum_width,
            biased_width,
            proved_range,
        };
        let signal = signal_behind(&quant, input);
        Ok((quant, signal))
    }

    /// Width of the words behind tanh and sigmoid that nobody sets.
    fn bounded_bits(&self) -> u32 {
        if self.deep {
            DEFAULT_DEEP_BOUNDED_BITS
        } else {
            DEFAULT_BOUNDED_BITS
        }
    }

    fn weight_format(
        &self,
        name: &str,
        layer: &FloatLayer,
        hidden: bool,
    ) -> Result<QFormat, QuantizeError> {
        if let Some(format) = layer.format.weights {
            return Ok(format);
        }
        let default = if self.deep || hidden && layer.activation == Activation::Linear {
            DEFAULT_FINE_WEIGHT_BITS
        } else {
            DEFAULT_WEIGHT_BITS
        };
        let bits =
            width_of(&self.options.weight_bits, name).unwrap_or(default.min(self.multiplier_bits));
        let (least, most) = (layer.weights.min(), layer.weights.max());
        Some((least, most))
            .filter(|(least, most)| least.is_finite() && most.is_finite())
            .and_then(|(least, most)| QFormat::holding(bits, least, most).ok())
            .ok_or_else(|| magnitude(name, "weights", layer.weights.amax()))
    }

    /// The formats of the activation's argument and of the output words.
    fn behind(
        &mut self,
        name: &str,
        layer: &FloatLayer,
        (low, high): (f64, f64),
        readers: &[Reader],
    ) -> Result<Behind, QuantizeError> {
        let asked = width_of(&self.options.activation_bits, name);
        let given = layer.format.activations;
        let beyond = |_| magnitude(name, "sums", low.abs().max(high.abs()));
        if !(low.is_finite() && high.is_finite()) {
            return Err(magnitude(name, "sums", f64::INFINITY));
        }
        match layer.activation {
            Activation::Tanh | Activation::Sigmoid => {
                let fraction = self.table_fraction(name, layer)?;
                let halving = halving(layer);
                let bits = asked.unwrap_or(self.bounded_bits());
                let output = match given {
                    Some(format) if format.integer() < 0 => {
                        return Err(bounded_width(name, layer, bits));
                    }
                    Some(format) => format,
                    None => QFormat::new(bits, bits.cast_signed() - 1).map_err(beyond)?,
                };
                let table = self.table(fraction)?;
                let pre_fraction = fraction.cast_signed() - halving;
                let pre = QFormat::new(table.magnitude_bits() + 1, pre_fraction).map_err(beyond)?;
                Ok(Behind {
                    pre,
                    output,
                    table: Some(table),
                })
            }
            Activation::Relu | Activation::Linear => {
                let low = if layer.activation == Activation::Relu {
                    low.max(0.0)
                } else {
                    low
                };
                let high = high.max(low);
                let default = if readers.is_empty() {
                    self.options.output_bits.unwrap_or(DEFAULT_OUTPUT_BITS)
                } else {
                    asked.unwrap_or(DEFAULT_UNBOUNDED_BITS.min(self.multiplier_bits))
                };
                let (low, high) = match self.relevant_magnitude(readers)? {
                    // The greatest code is one step short of the power of two.
                    Some(limit) => {
                        let most = limit - libm::ldexp(limit, 1 - default.cast_signed());
                        (low.clamp(-limit, most), high.clamp(-limit, most))
                    }
                    None => (low, high),
                };
                let derived = QFormat::holding(default, low, high).map_err(beyond)?;
                let output = given.unwrap_or(derived);
                if !readers.is_empty() {
                    check_width(
                        format!("{name}.activations"),
                        output.width().into(),
                        &OPERAND_BITS,
                    )?;
                }
                Ok(Behind {
                    pre: output,
                    output,
                    table: None,
                })
            }
        }
    }

    /// The magnitude that readers need of a word, if a table clips what all of them make of it.
    fn relevant_magnitude(&self, readers: &[Reader]) -> Result<Option<f64>, QuantizeError> {
        if !readers.iter().all(|r| r.layer.activation.is_bounded()) {
            return Ok(None);
        }
        let clip = |r: &Reader| {
            let range = range_log2(self.table_fraction(r.name, r.layer)?).cast_signed();
            let halving = halving(r.layer);
            Ok((
                libm::ldexp(1.0, range + halving),
                libm::ldexp(NEARLY, halving),
            ))
        };
        let clips = readers.iter().map(clip).collect::<Result<Vec<_>, _>>()?;
        Ok(relevant_magnitude(readers, &clips))
    }

    /// Fraction bits of the table of a tanh or sigmoid layer.
    fn table_fraction(&self, name: &str, layer: &FloatLayer) -> Result<u32, QuantizeError> {
        let asked = width_of(&self.options.activation_bits, name);
        let bits = asked.unwrap_or(self.bounded_bits());
        let given = layer.format.activations;
        let fraction = given.map_or(bits.cast_signed() - 1, QFormat::fraction) - halving(layer);
        u32::try_from(fraction)
            .ok()
            .filter(|f| FRACTION_RANGE.contains(f))
            .ok_or_else(|| bounded_width(name, layer, bits))
    }

    fn table(&mut self, fraction: u32) -> Result<Arc<OddTable>, QuantizeError> {
        if let Some(table) = self.tables.get(&fraction) {
            return Ok(Arc::clone(table));
        }
        let table = match self.options.segments {
            None => OddTable::tanh(fraction),
            Some(found) => {
                let finest = (OddTable::with_segments_log2(fraction, 2).magnitude_bits() - 1)
                    .min(MAX_SEGMENTS.ilog2());
                if !found.is_power_of_two() || !(2..=finest).contains(&found.ilog2()) {
                    return Err(QuantizeError::Segments {
                        high: (1 << finest).min(MAX_SEGMENTS),
                        found,
                    });
                }
                OddTable::with_segments_log2(fraction, found.ilog2())
            }
        };
        let table = Arc::new(table);
        self.tables.insert(fraction, Arc::clone(&table));
        Ok(table)
    }
}

/// The outer half of a sigmoid is a fraction bit that its table need not have.
fn halving(layer: &FloatLayer) -> i32 {
    i32::from(layer.activation == Activation::Sigmoid)
}

fn magnitude(layer: &str, what: &str, found: f64) -> QuantizeError {
    QuantizeError::Magnitude {
        what: format!("{layer}: {what}"),
        found,
    }
}

fn bounded_width(name: &str, layer: &FloatLayer, bits: u32) -> QuantizeError {
    let halving = u32::from(layer.activation == Activation::Sigmoid);
    let (low, high) = (
        FRACTION_RANGE.start() + halving,
        FRACTION_RANGE.end() + halving,
    );
    match layer.format.activations {
        Some(found) => QuantizeError::ActivationFormat {
            layer: name.to_owned(),
            expected: format!("Qm.n with m >= 0 and {low} <= n <= {high}"),
            found,
        },
        None => QuantizeError::Width {
            what: format!(
                "{name}: activation bits of a {} layer",
                layer.activation.name()
            ),
            low: low + 1,
            high: high + 1,
            found: bits.into(),
        },
    }
}

/// The bias with the centring of raw inputs folded in, for the weights that are really used.
fn centred_bias(layer: &FloatLayer, weights: &[Vec<f64>], input: &Signal) -> Vec<f64> {
    let centring = |row: &[f64]| match &input.centre {
        Some(centre) => row.iter().zip(centre).map(|(w, c)| w * c).sum(),
        None => 0.0,
    };
    layer
        .bias
        .iter()
        .zip(weights)
        .map(|(b, row)| b - centring(row))
        .collect()
}

/// Least and greatest weighted sum of any neuron over the input box.
fn real_range(weights: &[Vec<f64>], bias: &[f64], input: &Signal) -> (f64, f64) {
    let edges: Vec<(f64, f64)> = input
        .range
        .iter()
        .map(|(low, high)| (input.format.to_f64(*low), input.format.to_f64(*high)))
        .collect();
    weights.iter().zip(bias).fold(
        (f64::INFINITY, f64::NEG_INFINITY),
        |(least, most), (row, b)| {
            let (low, high) =
                row.iter()
                    .zip(&edges)
                    .fold((*b, *b), |(low, high), (w, (x0, x1))| {
                        (low + (w * x0).min(w * x1), high + (w * x0).max(w * x1))
                    });
            (least.min(low), most.max(high))
        },
    )
}

/// Inputs whose weights were all rounded to zero though they are not all zero.
fn unread(rows: &[Vec<f64>], codes: &[Vec<i64>]) -> Vec<usize> {
    let read = |i: &usize| rows.iter().any(|row| row[*i] != 0.0);
    let kept = |i: &usize| codes.iter().any(|row| row[*i] != 0);
    (0..rows[0].len()).filter(|i| read(i) && !kept(i)).collect()
}

fn places(difference: i32) -> u32 {
    u32::try_from(difference).expect("the wider fraction was taken")
}

/// What the layer puts out over the input box.
fn signal_behind(layer: &QuantLayer, input: &Signal) -> Signal {
    let range: Vec<(i64, i64)> = (0..layer.outputs())
        .map(|i| {
            let (low, high) = layer.weights[i].iter().zip(&input.range).fold(
                (0, 0),
                |(low, high), (w, (x0, x1))| {
                    (low + (w * x0).min(w * x1), high + (w * x0).max(w * x1))
                },
            );
            (layer.finish(i, low).code, layer.finish(i, high).code)
        })
        .collect();
    let typical = |(low, high): &(i64, i64)| {
        let magnitude = (-low).max(*high);
        let divisor = if layer.activation.is_bounded() {
            2.0
        } else {
            CREST
        };
        layer.output.to_f64(magnitude) / divisor
    };
    Signal {
        format: layer.output,
        spread: range.iter().map(typical).collect(),
        range,
        centre: None,
    }
}
