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

/// The cheapest folding of every layer that takes at most `interval` cycles a frame.
pub fn fold(net: &QuantNet, interval: usize) -> Perceptron {
    let mut shared: Vec<Layer> = Vec::new();
    for layer in &net.shared {
        let before = shared.last().map(|l| l.lanes);
        shared.push(fold_layer(layer, before, interval));
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

/// An interval that `multipliers` allow and the one below does not.
///
/// # Errors
/// The least number of multipliers that any interval needs: one a layer.
pub fn interval_for(net: &QuantNet, multipliers: u32) -> Result<u32, u32> {
    let used = |interval: u32| -> usize {
        fold(net, to_usize(interval))
            .layers()
            .map(Layer::multipliers)
            .sum()
    };
    let layers = || {
        net.shared
            .iter()
            .chain(net.networks.iter().flat_map(|n| &n.layers))
    };
    let slowest = layers()
        .map(|l| l.inputs() * l.outputs())
        .max()
        .unwrap_or(1);
    let slowest = u32::try_from(slowest).unwrap_or(u32::MAX);
    let wanted = to_usize(multipliers);
    if used(slowest) > wanted {
        return Err(u32::try_from(used(slowest)).unwrap_or(u32::MAX));
    }
    // The need falls with the interval, but not strictly so: bisect, then step down.
    let (mut low, mut high) = (1, slowest);
    while low < high {
        let middle = low + (high - low) / 2;
        if used(middle) <= wanted {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    while low > 1 && used(low - 1) <= wanted {
        low -= 1;
    }
    Ok(low)
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
