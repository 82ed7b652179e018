//! The input words: a binary point for each input, and one for the arithmetic behind them.

use super::QuantizeError;
use crate::format::{QFormat, Rounding};
use crate::network::{FloatNet, Inputs};
use crate::options::{DEFAULT_INPUT_BITS, OPERAND_BITS};

/// The input words of a design.
///
/// # Format
/// All words have one width. Word `i` stands for raw values in [`formats`](Self::formats)`[i]`;
/// the first layer reads every word as [`format`](Self::format), and the powers of two between
/// the two stand in the columns of its weights.
#[derive(Clone, Debug, PartialEq)]
pub struct InputFormat {
    /// Format of each input word, raw units.
    pub formats: Vec<QFormat>,
    /// What the first layer takes all words for: the coarsest of the formats.
    pub format: QFormat,
    /// Least code of each input: the lower edge of the box.
    pub low: Vec<i64>,
    /// Greatest code of each input: the upper edge of the box.
    pub high: Vec<i64>,
    /// Bits of the file's resolution that the words lack, as the device's multipliers take no more.
    pub dropped_bits: u32,
}

impl InputFormat {
    /// Every input has the finest format of the default width that holds its box.
    ///
    /// No word is wider than the device's multipliers, should the resolution ask for more.
    ///
    /// There is one format for all where the file gives a resolution, which is one raw step for
    /// all, and where the words meet weights that the trainer fixed.
    pub(super) fn of(net: &FloatNet, multiplier_bits: u32) -> Result<Self, QuantizeError> {
        let inputs = &net.inputs;
        let (formats, dropped_bits) = if inputs.resolution.is_some() || meets_fixed_weights(net) {
            let (format, dropped_bits) = common(inputs, multiplier_bits)?;
            (vec![format; inputs.names.len()], dropped_bits)
        } else {
            (each(inputs)?, 0)
        };
        let format = *formats
            .iter()
            .min_by_key(|f| f.fraction())
            .expect("a network has an input");
        let codes = |edge: &[f64]| -> Vec<i64> {
            let words = edge.iter().zip(&formats);
            words
                .map(|(v, format)| format.quantize(*v, Rounding::HalfUp).code)
                .collect()
        };
        let (low, high) = (codes(&inputs.min), codes(&inputs.max));
        for (i, name) in inputs.names.iter().enumerate() {
            if low[i] == high[i] && inputs.min[i] < inputs.max[i] {
                return Err(QuantizeError::OneCode {
                    input: name.clone(),
                    low: inputs.min[i],
                    high: inputs.max[i],
                    step: formats[i].step(),
                });
            }
        }
        Ok(Self {
            formats,
            format,
            low,
            high,
            dropped_bits,
        })
    }

    /// The same network for inputs whose words are all read in the common format.
    ///
    /// A factor that is a power of two is exact, so this changes no weight's digits.
    pub(super) fn in_one_format(&self, net: &FloatNet) -> Result<FloatNet, QuantizeError> {
        let mut net = net.clone();
        let inputs = &mut net.inputs;
        for (i, format) in self.formats.iter().enumerate() {
            let up = format.fraction() - self.format.fraction();
            inputs.scale[i] = libm::ldexp(inputs.scale[i], -up);
            for raw in [&mut inputs.min, &mut inputs.max, &mut inputs.offset] {
                let found = raw[i];
                raw[i] = libm::ldexp(found, up);
                if !raw[i].is_finite() {
                    return Err(magnitude(&inputs.names[i], found));
                }
            }
        }
        Ok(net)
    }
}

/// Whether words are multiplied with weights whose codes the trainer fixed: no power of two can go
/// into those. An input scale has a layer of its own then, which takes the powers in.
fn meets_fixed_weights(net: &FloatNet) -> bool {
    let scaled = net.inputs.scale.iter().any(|s| *s != 1.0);
    !scaled
        && match net.shared.first() {
            Some(first) => first.format.weights.is_some(),
            None => {
                let mut networks = net.networks.iter();
                networks.any(|n| n.layers[0].format.weights.is_some())
            }
        }
}

/// One format for all inputs: that of the resolution, or the finest that holds every box; and how
/// many bits of the resolution it lacks.
fn common(inputs: &Inputs, multiplier_bits: u32) -> Result<(QFormat, u32), QuantizeError> {
    let low = inputs.min.iter().copied().fold(f64::INFINITY, f64::min);
    let high = inputs.max.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let Some(resolution) = inputs.resolution else {
        let format = QFormat::holding(DEFAULT_INPUT_BITS, low, high)
            .map_err(|_| magnitude("the inputs", low.abs().max(high.abs())))?;
        return Ok((format, 0));
    };
    // The coarsest power of two that is no coarser than the resolution.
    let fraction = -libm::ilogb(resolution);
    let least = *OPERAND_BITS.start();
    QFormat::new(least, fraction).map_err(|_| magnitude_of("inputs: a resolution", resolution))?;
    let too_wide = |found: u32| QuantizeError::Width {
        what: "inputs: words for the box at this resolution".into(),
        low: least,
        high: *OPERAND_BITS.end(),
        found: found.into(),
    };
    let format = QFormat::with_fraction(fraction, low, high).map_err(|_| {
        // Beyond what a word may have at all, the box says how much is missing.
        let bits = libm::ilogb(low.abs().max(high.abs())) + fraction + 2;
        too_wide(bits.unsigned_abs())
    })?;
    if format.width() > *OPERAND_BITS.end() {
        return Err(too_wide(format.width()));
    }
    // Finer than the device's multipliers take: it loses bits until they do. An edge of the box may round
    // to a word of a bit more, so that each width is looked at.
    let (mut format, mut dropped) = (format, 0u32);
    while format.width() > multiplier_bits {
        dropped += 1;
        format = QFormat::with_fraction(fraction - dropped.cast_signed(), low, high)
            .map_err(|_| too_wide(format.width()))?;
    }
    if dropped > 0 {
        return Ok((format, dropped));
    }
    if format.width() < least {
        let format = QFormat::new(least, fraction);
        let format = format.map_err(|_| magnitude_of("inputs: a resolution", resolution))?;
        return Ok((format, 0));
    }
    Ok((format, 0))
}

/// The finest format of the default width for each input alone.
fn each(inputs: &Inputs) -> Result<Vec<QFormat>, QuantizeError> {
    let mut formats = Vec::new();
    for (name, (low, high)) in inputs.names.iter().zip(inputs.min.iter().zip(&inputs.max)) {
        // An input that is always zero has no magnitude of its own.
        formats.push(if *low == 0.0 && *high == 0.0 {
            None
        } else {
            let format = QFormat::holding(DEFAULT_INPUT_BITS, *low, *high);
            Some(format.map_err(|_| magnitude(name, low.abs().max(high.abs())))?)
        });
    }
    let coarsest = formats.iter().flatten().min_by_key(|f| f.fraction());
    let zero = match coarsest {
        Some(format) => *format,
        None => QFormat::holding(DEFAULT_INPUT_BITS, 0.0, 0.0).expect("zero fits"),
    };
    Ok(formats.into_iter().map(|f| f.unwrap_or(zero)).collect())
}

fn magnitude(input: &str, found: f64) -> QuantizeError {
    magnitude_of(&format!("inputs: values of `{input}`"), found)
}

fn magnitude_of(what: &str, found: f64) -> QuantizeError {
    QuantizeError::Magnitude {
        what: what.to_owned(),
        found: found.abs(),
    }
}
