//! Whether the options fit the layers: legal, and not without effect.

use super::{Folded, FoldedLayer, QuantizeError};
use crate::network::Activation;
use crate::options::{OPERAND_BITS, OUTPUT_BITS, Options, WidthSetting};

/// Refuses what no layer of the design can follow.
///
/// A setting that names a layer, or that there is only one of, must change something: one that is
/// silently without effect is a mistake.
pub(super) fn check(folded: &Folded, options: &Options) -> Result<(), QuantizeError> {
    let layers = || folded.shared.iter().chain(folded.networks.iter().flatten());
    let named = |option: &'static str, setting: &WidthSetting| match &setting.layer {
        None => Ok(None),
        Some(found) => layers()
            .find(|(name, _)| name == found)
            .map(Some)
            .ok_or_else(|| {
                let known: Vec<&str> = layers().map(|(name, _)| name.as_str()).collect();
                QuantizeError::UnknownLayer {
                    option,
                    found: found.clone(),
                    known: known.join(", "),
                }
            }),
    };
    for setting in &options.weight_bits {
        check_width("weight-bits".into(), setting.bits.into(), &OPERAND_BITS)?;
        if let Some((name, layer)) = named("weight-bits", setting)?
            && let Some(format) = layer.format.weights
        {
            return Err(idle(
                format!("weight-bits {name}={}", setting.bits),
                "a layer without `format.weights`",
                format!("one of {format}"),
            ));
        }
    }
    for setting in &options.activation_bits {
        check_width("activation-bits".into(), setting.bits.into(), &OPERAND_BITS)?;
        let Some(found) = named("activation-bits", setting)? else {
            continue;
        };
        let (name, layer) = found;
        let option = format!("activation-bits {name}={}", setting.bits);
        if let Some(format) = layer.format.activations {
            let found = format!("one of {format}");
            return Err(idle(option, "a layer without `format.activations`", found));
        }
        if !layer.activation.is_bounded() && is_last(folded, found) {
            let found = format!("the last layer, {}", layer.activation.name());
            let expected = "a hidden, tanh or sigmoid layer (see output-bits)";
            return Err(idle(option, expected, found));
        }
    }
    if let Some(bits) = options.output_bits {
        check_width("output-bits".into(), bits.into(), &OUTPUT_BITS)?;
        let last: Vec<&FoldedLayer> = folded.networks.iter().filter_map(|n| n.last()).collect();
        let free = |(_, layer): &&FoldedLayer| {
            !layer.activation.is_bounded() && layer.format.activations.is_none()
        };
        if !last.iter().any(free) {
            let found: Vec<String> = last.iter().map(|layer| described(layer)).collect();
            return Err(idle(
                format!("output-bits {bits}"),
                "a last layer that is linear or relu without `format.activations`",
                found.join(", "),
            ));
        }
    }
    if let Some(segments) = options.segments {
        let bounded = |(_, layer): &FoldedLayer| layer.activation.is_bounded();
        if !segments.is_power_of_two() || segments < 4 {
            return Err(QuantizeError::Segments {
                high: MAX_SEGMENTS,
                found: segments,
            });
        }
        if !layers().any(bounded) {
            let names: Vec<&str> = Activation::ALL
                .into_iter()
                .filter(|a| layers().any(|(_, l)| l.activation == *a))
                .map(Activation::name)
                .collect();
            return Err(idle(
                format!("segments {segments}"),
                "a tanh or sigmoid layer",
                format!("only {}", names.join(" and ")),
            ));
        }
    }
    Ok(())
}

/// Most segments of any table.
pub(super) const MAX_SEGMENTS: u32 = 1 << 12;

fn is_last(folded: &Folded, layer: &FoldedLayer) -> bool {
    let mut networks = folded.networks.iter();
    networks.any(|n| n.last().is_some_and(|(name, _)| *name == layer.0))
}

fn described((name, layer): &FoldedLayer) -> String {
    match layer.format.activations {
        Some(format) => format!("{name} of {format}"),
        None => format!("{name}, {}", layer.activation.name()),
    }
}

fn idle(option: String, expected: &str, found: String) -> QuantizeError {
    QuantizeError::Idle {
        option,
        expected: expected.to_owned(),
        found,
    }
}

/// Refuses a width outside of the legal range.
pub(super) fn check_width(
    what: String,
    found: i64,
    legal: &std::ops::RangeInclusive<u32>,
) -> Result<(), QuantizeError> {
    let (low, high) = (*legal.start(), *legal.end());
    if (i64::from(low)..=i64::from(high)).contains(&found) {
        return Ok(());
    }
    Err(QuantizeError::Width {
        what,
        low,
        high,
        found,
    })
}
