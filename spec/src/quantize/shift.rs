//! Extra fraction bits for neurons with small weights.

use crate::format::{QFormat, Rounding};

/// Scales per neuron are used where they take a neuron's rounding error down by this factor.
const EXTRA_SHIFT_GAIN: f64 = 4.0;
/// Greatest extra shift of a neuron.
const MAX_EXTRA_SHIFT: u32 = 15;

/// What a layer's inputs say of the precision that its weights need.
pub(super) struct Inputs<'a> {
    /// Step of the words.
    pub(super) step: f64,
    /// Typical distance of each word from its centre.
    pub(super) spread: &'a [f64],
}

/// Extra fraction bits per neuron, all zero where they don't pay.
///
/// A neuron's weights are too coarse if their rounding disturbs its sum by more than half an
/// output step and by more than half of what the rounding of its inputs does anyway.
pub(super) fn extra_shifts(
    rows: &[Vec<f64>],
    common: QFormat,
    pre: QFormat,
    input: &Inputs<'_>,
) -> Vec<u32> {
    let spread = input.spread.iter().map(|s| s * s).sum::<f64>().sqrt();
    let uniform = 1.0 / 12f64.sqrt();
    let error = |extra: u32| finer(common, extra).step() * uniform * spread;
    let wanted: Vec<(u32, bool)> = rows
        .iter()
        .map(|row| {
            let norm = row.iter().map(|w| w * w).sum::<f64>().sqrt();
            // Weights that are codes already have nothing to gain.
            let exact = row
                .iter()
                .all(|w| common.to_f64(common.quantize(*w, Rounding::HalfUp).code) == *w);
            let tolerated = (pre.step() / 2.0).max(norm * input.step * uniform / 2.0);
            let fits = |extra: &u32| {
                let format = finer(common, *extra);
                row.iter()
                    .all(|w| !format.quantize(*w, Rounding::HalfUp).clipped)
            };
            if exact {
                return (0, false);
            }
            let extra = (0..=MAX_EXTRA_SHIFT)
                .take_while(fits)
                .find(|extra| error(*extra) <= tolerated)
                .unwrap_or_else(|| (0..=MAX_EXTRA_SHIFT).take_while(fits).last().unwrap_or(0));
            let pays = extra > 0 && norm > 0.0 && error(0) > EXTRA_SHIFT_GAIN * tolerated;
            (extra, pays)
        })
        .collect();
    let pays = wanted.iter().any(|(_, pays)| *pays);
    wanted
        .iter()
        .map(|(extra, _)| if pays { *extra } else { 0 })
        .collect()
}

/// A format with so many more fraction bits and as many bits.
pub(super) fn finer(format: QFormat, extra: u32) -> QFormat {
    QFormat::new(format.width(), format.fraction() + extra.cast_signed()).unwrap_or(format)
}
