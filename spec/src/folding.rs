//! How many neurons and inputs each array takes at once.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
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

/// The cheapest folding that takes at most `interval` cycles a frame, or `serial` where the frame waits
/// for them with nothing else under way: in shared layers, and while the last sums of a network leave.
///
/// Layers are not chosen one by one: a layer that puts out more words at once takes more activation
/// units, and whoever takes its beats as they come as many multipliers a neuron.
pub fn fold(net: &QuantNet, serial: usize, interval: usize) -> Perceptron {
    let kept = |layers: &[QuantLayer]| -> Vec<Arc<QuantLayer>> {
        layers.iter().cloned().map(Arc::new).collect()
    };
    let layers: Vec<_> = net.networks.iter().map(|n| kept(&n.layers)).collect();
    let fronts = chains(&kept(&net.shared), None, serial, serial);
    let plans = fronts.into_iter().map(|front| {
        let networks = layers.iter().map(|layers| {
            let all = chains(layers, front.beats(), interval, serial);
            cheapest(all)
        });
        let networks: Vec<Chain> = networks.collect();
        let cost = front.cost + networks.iter().map(|n| n.cost).sum::<usize>();
        (cost, front, networks)
    });
    let (_, front, networks) = plans
        .min_by_key(|(cost, ..)| *cost)
        .expect("full parallelism takes one cycle");
    let networks = net
        .networks
        .iter()
        .zip(networks)
        .map(|(network, chain)| NetworkPlan {
            name: network.name.clone(),
            layers: chain.layers,
            output_names: network.output_names.clone(),
            unit: network.unit.clone(),
        });
    Perceptron {
        networks: networks.collect(),
        shared: front.layers,
        credits: 0,
    }
}

/// How words leave a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Beats {
    /// Words of a beat.
    lanes: usize,
    /// Clocks from a beat to the next, at least.
    gap: usize,
}

/// Layers one behind the other.
#[derive(Clone, Debug)]
struct Chain {
    cost: usize,
    /// Beats of what is in front, if anything streams into the first layer.
    before: Option<Beats>,
    layers: Vec<Layer>,
    /// Beats of the last layer.
    last: Option<Beats>,
}

impl Chain {
    /// What streams into a next layer.
    fn beats(&self) -> Option<Beats> {
        self.last.or(self.before)
    }

    fn with(
        &self,
        layer: &Arc<QuantLayer>,
        (feed, fold): (Feed, Fold),
        interval: usize,
        patience: usize,
    ) -> Option<Self> {
        let layer = arrange(layer, feed, fold, patience);
        (layer.folds() <= interval).then(|| {
            let mut longer = self.clone();
            longer.cost += cost(&layer);
            longer.last = Some(Beats {
                lanes: layer.lanes,
                gap: layer.output_gap(self.beats().map_or(1, |beats| beats.gap)),
            });
            longer.layers.push(layer);
            longer
        })
    }
}

fn cheapest(chains: Vec<Chain>) -> Chain {
    let least = chains.into_iter().min_by_key(|chain| chain.cost);
    least.expect("full parallelism takes one cycle")
}

/// The cheapest foldings of some layers, one for each kind of beats that the last can put out.
///
/// These are all that the next layer knows of those before it, so that nothing else need be kept of
/// them.
fn chains(
    layers: &[Arc<QuantLayer>],
    before: Option<Beats>,
    interval: usize,
    serial: usize,
) -> Vec<Chain> {
    let start = Chain {
        cost: 0,
        before,
        layers: Vec::new(),
        last: None,
    };
    let last = layers.len().saturating_sub(1);
    let all = layers.iter().enumerate();
    all.fold(vec![start], |fronts, (i, layer)| {
        let patience = if i == last { serial } else { interval };
        let mut best: BTreeMap<Option<Beats>, Chain> = BTreeMap::new();
        let mut consider = |front: &Chain, feed: Feed, fold: Fold| {
            let Some(chain) = front.with(layer, (feed, fold), interval, patience) else {
                return;
            };
            match best.entry(chain.beats()) {
                Entry::Vacant(entry) => {
                    entry.insert(chain);
                }
                Entry::Occupied(mut entry) if chain.cost < entry.get().cost => {
                    entry.insert(chain);
                }
                Entry::Occupied(_) => {}
            }
        };
        // A layer that reads its whole input at once does not care who filled it.
        let front = cheapest(fronts.clone());
        if layer.adders.is_some() {
            let (pe, simd) = (layer.outputs(), layer.inputs());
            consider(&front, Feed::Adders, Fold { pe, simd });
        }
        for fold in foldings(layer, interval) {
            consider(&front, Feed::Replay, fold);
        }
        for front in &fronts {
            let Some(beats) = front.beats() else { continue };
            let simd = beats.lanes;
            let pe = layer.outputs();
            consider(front, Feed::Direct, Fold { pe, simd });
            for folds in 2..=beats.gap.min(layer.outputs()) {
                let pe = layer.outputs().div_ceil(folds);
                if layer.outputs().div_ceil(pe) == folds {
                    consider(front, Feed::Hold, Fold { pe, simd });
                }
            }
        }
        best.into_values().collect()
    })
}

/// Foldings of a layer that hold its whole input: for each number of neuron folds the fewest inputs
/// a cycle, and no more neurons than those folds need.
fn foldings(layer: &QuantLayer, interval: usize) -> Vec<Fold> {
    let (inputs, outputs) = (layer.inputs(), layer.outputs());
    let mut foldings: Vec<Fold> = Vec::new();
    let mut neuron_folds = 0;
    for pe in (1..=outputs).rev() {
        let folds = outputs.div_ceil(pe);
        if folds > interval {
            break;
        }
        if folds != neuron_folds {
            neuron_folds = folds;
            foldings.push(Fold {
                pe: outputs.div_ceil(folds),
                simd: inputs.div_ceil(interval / folds),
            });
        }
    }
    foldings
}

/// Intervals above the lower bound that are tried one by one.
const TRIED: u32 = 512;

/// The least interval that `multipliers` allow, as `count` counts them: one for each of a layer, or more where
/// it takes several blocks.
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
    count: impl Fn(&Layer) -> usize,
) -> Result<u32, u32> {
    let used = |interval: u32| {
        let slow = used(net, interval, interval, &count);
        slow.min(used(net, 1, interval, &count))
    };
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
    let multiplied = layers().filter(|layer| layer.adders.is_none());
    let all: usize = multiplied.map(macs).sum();
    let bound = narrow(all.div_ceil(wanted.max(1))).clamp(1, slowest);
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
/// leaves over make the latency shorter there, and so do `spare` register bits more, as `register_bits` counts
/// them. Where none of these foldings has so few multipliers, the one of the fewest register bits.
pub fn shared_interval_for(
    net: &QuantNet,
    multipliers: u32,
    interval: u32,
    count: impl Fn(&Layer) -> usize,
    spare: usize,
) -> u32 {
    let plan = |shared: u32| fold(net, to_usize(shared), to_usize(interval));
    let bits = |plan: &Perceptron| plan.layers().map(register_bits).sum::<usize>();
    let most = bits(&plan(interval)).saturating_add(spare);
    let fitting = || {
        let plans = (1..=interval).map(|shared| (shared, plan(shared)));
        plans.filter(|(_, plan)| plan.layers().map(&count).sum::<usize>() <= to_usize(multipliers))
    };
    let cheap = fitting().find(|(_, plan)| bits(plan) <= most);
    let found = cheap.or_else(|| fitting().min_by_key(|(_, plan)| bits(plan)));
    found.map_or(interval, |(shared, _)| shared)
}

/// Multipliers of a folding.
fn used(net: &QuantNet, shared: u32, interval: u32, count: impl Fn(&Layer) -> usize) -> usize {
    let plan = fold(net, to_usize(shared), to_usize(interval));
    plan.layers().map(count).sum()
}

/// `patience`: clocks in which the sums of a whole layer may leave.
fn arrange(layer: &Arc<QuantLayer>, feed: Feed, fold: Fold, patience: usize) -> Layer {
    let synapse_folds = layer.inputs().div_ceil(fold.simd);
    // A group's sums may leave as slowly as the next group's sums arrive.
    let patience = if feed == Feed::Hold {
        1
    } else if fold.pe >= layer.outputs() {
        patience
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
        copy_latency: 0,
        rom_latency: 1,
        segment_latency: 1,
        gather_latency: 1,
        activation_in_logic: false,
    }
}

/// Register bits, a multiplier counted as [`MULTIPLIER_COST`] of them.
fn cost(layer: &Layer) -> usize {
    layer.all_multipliers() * MULTIPLIER_COST + register_bits(layer)
}

/// Register bits beside those of the array's multipliers and trees.
fn register_bits(layer: &Layer) -> usize {
    let word = to_usize(layer.quant.input.width());
    let sum = to_usize(layer.quant.sum_width);
    let sum = match layer.feed {
        Feed::Adders => sum - to_usize(layer.quant.trailing_zeros()),
        _ => sum,
    };
    let operands = match layer.feed {
        Feed::Direct => 0,
        Feed::Adders => {
            let adders = layer.adders().expect("a layer of adders");
            adders.register_bits(layer.quant.input.width())
        }
        Feed::Hold => layer.fold.simd * word,
        Feed::Replay => 2 * layer.quant.inputs() * word,
    };
    let accumulators = if layer.accumulates() {
        layer.turns() * layer.fold.pe * sum
    } else {
        0
    };
    let drain = if layer.lanes < layer.fold.pe {
        layer.fold.pe * sum
    } else {
        0
    };
    let behind = layer.lanes * 4 * sum;
    operands + accumulators + drain + behind
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::Options;
    use crate::quantize::quantize;
    use crate::weights;

    fn landing() -> QuantNet {
        let text = include_bytes!("../../designs/landing-wide/weights.json");
        quantize(&weights::read(text).unwrap(), &Options::default()).unwrap()
    }

    /// Layer by layer, 45 multipliers instead of 50 would be taken at 58, and 9 activation units
    /// instead of 5 behind them, whose 9 words take 27 multipliers in the next layer.
    #[test]
    fn more_time_takes_no_more_multipliers() {
        let mut net = landing();
        // Adders take none, at a price that a slow array does not have.
        net.shared[0].adders = None;
        let used = |interval: u32| used(&net, interval, interval, Layer::all_multipliers);
        let mut before = usize::MAX;
        for interval in 1..300 {
            let now = used(interval);
            assert!(now <= before, "{interval}: {now} after {before}");
            before = now;
        }
    }

    /// Operands of more bits than a block takes are several blocks each.
    #[test]
    fn a_device_gives_as_many_blocks_as_it_has() {
        use crate::design::Design;
        use crate::options::{Budget, WidthSetting};
        let text = include_bytes!("../../designs/landing/weights.json");
        let net = weights::read(text).unwrap();
        for device in ["gw2a-18", "ecp5-25k"] {
            for bits in [16, 24] {
                let options = Options {
                    device: Some(device.into()),
                    budget: Budget::Device,
                    weight_bits: vec![WidthSetting { layer: None, bits }],
                    ..Options::default()
                };
                let design = Design::new(&net, &options).unwrap();
                let device = design.device();
                let own = design.multipliers() + design.activation_multipliers();
                let layers = || design.perceptron().layers();
                let blocks: usize = layers().map(|l| l.all_blocks(device)).sum();
                let there = to_usize(device.multipliers.unwrap());
                assert!(there / 2 < blocks && blocks <= there, "{blocks} of {there}");
                assert_eq!(blocks > own, bits == 24, "{own} in {blocks}");
            }
        }
    }

    #[test]
    fn adders_alone_fit_any_number_of_multipliers() {
        let text = br#"{"format": "hwgen-weights/1", "name": "sums",
            "inputs": {"min": [-1, -1], "max": [1, 1]}, "networks": [{"name": "net", "layers": [
            {"activation": "linear", "weights": [[1, 0.5], [0.25, -1]]}]}]}"#;
        let net = quantize(&weights::read(text).unwrap(), &Options::default()).unwrap();
        for multipliers in [1, 28] {
            assert_eq!(interval_for(&net, multipliers, Layer::multipliers), Ok(1));
        }
    }

    #[test]
    fn no_smaller_interval_fits() {
        let net = landing();
        let counts: [fn(&Layer) -> usize; 2] = [Layer::multipliers, Layer::all_multipliers];
        for count in counts {
            let used = |interval: u32| {
                let slow = used(&net, interval, interval, count);
                slow.min(used(&net, 1, interval, count))
            };
            for multipliers in [40, 156] {
                let found = interval_for(&net, multipliers, count).unwrap();
                assert!(used(found) <= to_usize(multipliers));
                assert!((1..found).all(|less| used(less) > to_usize(multipliers)));
            }
            let interval = interval_for(&net, 156, count).unwrap();
            let shared = shared_interval_for(&net, 156, interval, count, usize::MAX);
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
