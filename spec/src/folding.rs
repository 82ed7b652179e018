//! How many neurons and inputs each array takes at once.

use std::sync::Arc;

use crate::design::{Feed, Layer, NetworkPlan, Perceptron, to_usize};
use crate::quantize::{QuantLayer, QuantNet};

/// Parallelism of an array: `pe` neurons, `simd` inputs a cycle each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Fold {
    /// Neurons in parallel.
    pub pe: usize,
    /// Inputs a cycle and neuron.
    pub simd: usize,
}

/// What a multiplier is worth in register bits when foldings are compared.
const MULTIPLIER_COST: usize = 200;

/// The cheapest folding of every layer that takes at most `interval` cycles a frame, or `shared`
/// where all networks wait for it.
pub fn fold(net: &QuantNet, shared: usize, interval: usize) -> Perceptron {
    let front = shared;
    let mut shared: Vec<Layer> = Vec::new();
    for layer in &net.shared {
        let before = shared.last().map(|l| l.lanes);
        shared.push(fold_layer(layer, before, front));
    }
    let before = shared.last().map(|l| l.lanes);
    let networks = net
        .networks
        .iter()
        .map(|network| {
            let mut layers: Vec<Layer> = Vec::new();
            for layer in &network.layers {
                let before = layers.last().map_or(before, |l| Some(l.lanes));
                layers.push(fold_layer(layer, before, interval));
            }
            NetworkPlan {
                name: network.name.clone(),
                layers,
                output_names: network.output_names.clone(),
                unit: network.unit.clone(),
            }
        })
        .collect();
    Perceptron {
        shared,
        networks,
        credits: 0,
    }
}

/// Intervals above the lower bound that are tried one by one.
const TRIED: u32 = 512;

/// The least interval that `multipliers` allow, counted by `count`.
///
/// The need falls with the interval, but not strictly so. Among the first 512 intervals that
/// the multiplications leave possible the least is found; beyond them one that is allowed while the
/// one below is not.
///
/// # Errors
/// The least number of multipliers that any interval needs.
pub fn interval_for(
    net: &QuantNet,
    multipliers: u32,
    count: fn(&Layer) -> usize,
) -> Result<u32, u32> {
    let used = |interval: u32| used(net, interval, interval, count);
    let layers = || {
        net.shared
            .iter()
            .chain(net.networks.iter().flat_map(|n| &n.layers))
    };
    let macs = |l: &QuantLayer| l.inputs() * l.outputs();
    let narrow = |cycles: usize| u32::try_from(cycles).unwrap_or(u32::MAX);
    let slowest = narrow(layers().map(macs).max().unwrap_or(1));
    let wanted = to_usize(multipliers);
    if used(slowest) > wanted {
        return Err(narrow(used(slowest)));
    }
    let all: usize = layers().map(macs).sum();
    let bound = narrow(all.div_ceil(wanted.max(1))).min(slowest);
    let tried = bound..=bound.saturating_add(TRIED).min(slowest);
    let mut low = *tried.end();
    if let Some(found) = tried.into_iter().find(|interval| used(*interval) <= wanted) {
        return Ok(found);
    }
    let mut high = slowest;
    while low < high {
        let middle = low + (high - low) / 2;
        if used(middle) <= wanted {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    Ok(low)
}

/// The fewest cycles that shared layers can take with so many multipliers and an interval of all.
///
/// A frame waits for one shared layer after the other, so that multipliers which the interval
/// leaves over make the latency shorter there.
pub fn shared_interval_for(
    net: &QuantNet,
    multipliers: u32,
    interval: u32,
    count: fn(&Layer) -> usize,
) -> u32 {
    let fits = |shared: &u32| used(net, *shared, interval, count) <= to_usize(multipliers);
    (1..interval).find(fits).unwrap_or(interval)
}

/// Multipliers of a folding.
fn used(net: &QuantNet, shared: u32, interval: u32, count: fn(&Layer) -> usize) -> usize {
    let plan = fold(net, to_usize(shared), to_usize(interval));
    plan.layers().map(count).sum()
}

/// `before`: lanes of the layer in front, if one streams into this one.
fn fold_layer(layer: &QuantLayer, before: Option<usize>, interval: usize) -> Layer {
    let (inputs, outputs) = (layer.inputs(), layer.outputs());
    let layer = Arc::new(layer.clone());
    let mut best: Option<(usize, Layer)> = None;
    let mut consider = |pe: usize, simd: usize| {
        let candidate = arrange(&layer, before, Fold { pe, simd }, interval);
        let cost = cost(&candidate);
        if candidate.folds() <= interval && best.as_ref().is_none_or(|(least, _)| cost < *least) {
            best = Some((cost, candidate));
        }
    };
    // One candidate for each number of neuron folds, none with more neurons than those need.
    let mut neuron_folds = 0;
    for pe in (1..=outputs).rev() {
        let folds = outputs.div_ceil(pe);
        if folds > interval {
            break;
        }
        if folds != neuron_folds {
            neuron_folds = folds;
            let pe = outputs.div_ceil(folds);
            consider(pe, inputs.div_ceil(interval / folds));
        }
    }
    if let Some(lanes) = before {
        consider(outputs, lanes);
    }
    best.expect("full parallelism takes one cycle").1
}

fn arrange(layer: &Arc<QuantLayer>, before: Option<usize>, fold: Fold, interval: usize) -> Layer {
    let one_pass = fold.pe >= layer.outputs();
    let feed = if one_pass && before == Some(fold.simd) {
        Feed::Direct
    } else {
        Feed::Replay
    };
    let synapse_folds = layer.inputs().div_ceil(fold.simd);
    // A group's sums may leave as slowly as the next group's sums arrive.
    let patience = if one_pass {
        interval.max(synapse_folds)
    } else {
        synapse_folds
    };
    let lanes = (1..=fold.pe)
        .find(|lanes| fold.pe.is_multiple_of(*lanes) && fold.pe / lanes <= patience)
        .expect("all at once is always in time");
    Layer {
        quant: Arc::clone(layer),
        fold,
        lanes,
        feed,
    }
}

/// Register bits, a multiplier counted as [`MULTIPLIER_COST`] of them.
fn cost(layer: &Layer) -> usize {
    let word = to_usize(layer.quant.input.width());
    let sum = to_usize(layer.quant.sum_width);
    let operands = match layer.feed {
        Feed::Direct => 0,
        Feed::Replay => 2 * layer.quant.inputs() * word,
    };
    let accumulators = if layer.accumulates() {
        layer.fold.pe * sum
    } else {
        0
    };
    let drain = if layer.lanes < layer.fold.pe {
        layer.fold.pe * sum
    } else {
        0
    };
    let behind = layer.lanes * 4 * sum;
    layer.multipliers() * MULTIPLIER_COST + operands + accumulators + drain + behind
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::Options;
    use crate::quantize::quantize;
    use crate::weights;

    #[test]
    fn no_smaller_interval_fits() {
        let text = include_bytes!("../../designs/landing/weights.json");
        let net = quantize(&weights::read(text).unwrap(), &Options::default()).unwrap();
        let counts: [fn(&Layer) -> usize; 2] = [Layer::multipliers, Layer::all_multipliers];
        for count in counts {
            let used = |interval: u32| used(&net, interval, interval, count);
            for multipliers in [40, 156] {
                let found = interval_for(&net, multipliers, count).unwrap();
                assert!(used(found) <= to_usize(multipliers));
                assert!((1..found).all(|less| used(less) > to_usize(multipliers)));
            }
            let interval = interval_for(&net, 156, count).unwrap();
            let shared = shared_interval_for(&net, 156, interval, count);
            let used = |shared: u32| super::used(&net, shared, interval, count);
            assert!(
                shared <= interval
                    && used(shared) <= 156
                    && (1..shared).all(|less| used(less) > 156)
            );
            let least = interval_for(&net, 1, count).unwrap_err();
            assert!(interval_for(&net, least, count).is_ok());
            assert!(interval_for(&net, least - 1, count).is_err());
        }
    }
}
