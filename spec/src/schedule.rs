//! When what happens: the one place where latency, interval and depths are derived.
//!
//! Times are counted in rising clock edges; an event "at `t`" is in its register after edge `t`.
//! Edge 0 takes the first input beat of a frame into an idle core.

use serde::Serialize;

use crate::design::{Feed, Layer, Perceptron, Port};

/// Cycles from a multiplier's operands to its product, which is registered twice: in the device's
/// block, and once more there or on its way to the adders.
const MULTIPLIER_LATENCY: usize = 3;
/// Cycles from a sum to its requantized word, a neuron's own shift not counted.
pub const REQUANT_LATENCY: usize = 4;
/// Cycles of the stage that undoes a neuron's own shift.
pub const EXTRA_SHIFT_LATENCY: usize = 1;

/// Times and depths of a design.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Schedule {
    /// Cycles between two frames in continuous flow.
    pub interval: usize,
    /// Cycles from taking the first input beat to handing over the last output beat.
    pub latency: usize,
    /// Frames under way at most, so that an interval is never lost for want of a credit.
    pub credits: usize,
    /// Frames that a queue of answers holds.
    pub fifo_depth: usize,
}

impl Schedule {
    /// Derives the schedule of one perceptron stage between two streams.
    pub(crate) fn of(stage: &Perceptron, source: &Port, sink: &Port) -> Self {
        let interval = stage
            .layers()
            .map(|l| l.folds().max(l.array_beats()))
            .chain([source.beats(), sink.beats()])
            .max()
            .expect("there are streams");
        // The last beat meets its bounds, is compared with them, is within them, completes the frame.
        let start = source.beats() + 4;
        let mut beats: Option<Beats> = None;
        for layer in &stage.shared {
            beats = Some(Beats::of(layer, beats.as_ref(), start));
        }
        let whole = stage
            .networks
            .iter()
            .map(|network| {
                let mut beats = beats.clone();
                for layer in &network.layers {
                    beats = Some(Beats::of(layer, beats.as_ref(), start));
                }
                beats.expect("a network has a layer").gathered()
            })
            .max()
            .expect("there is a network");
        // In the queue, in the serializer, in the output slice, handed over.
        let in_fifo = whole + 1;
        let in_serializer = in_fifo + 1;
        let handed_over = in_serializer + 1 + sink.beats();
        let credits = (in_serializer + 1 - start).div_ceil(interval);
        Self {
            interval,
            latency: handed_over,
            credits,
            fifo_depth: credits.max(2),
        }
    }
}

/// When a layer's output beats are in their register.
#[derive(Clone)]
struct Beats {
    times: Vec<usize>,
    /// Clocks from the last one to the whole vector.
    gather: usize,
}

impl Beats {
    /// `before`: those of the layer in front; `start`: the edge that loads the input frame where
    /// there is none.
    fn of(layer: &Layer, before: Option<&Self>, start: usize) -> Self {
        let operands: Vec<usize> = match (layer.feed, before) {
            (Feed::Direct, Some(beats)) => beats.times.clone(),
            // Loaded, then a clock a group; only the last beat completes sums.
            (Feed::Hold, Some(beats)) => {
                let loaded = last(&beats.times) + 1;
                (0..layer.neuron_folds())
                    .map(|turn| loaded + turn)
                    .collect()
            }
            // What goes into adders need not be loaded.
            (Feed::Adders, before) => vec![before.map_or(start - 1, Self::gathered)],
            (_, before) => {
                let loaded = before.map_or(start, |beats| beats.gathered() + 1);
                (0..layer.folds()).map(|fold| loaded + fold).collect()
            }
        };
        let drain = if layer.drain_beats() > 1 { 1 } else { 0 };
        let to_sum = sum_latency(layer) + drain;
        let behind = finish_latency(layer);
        let operands_of_sum = match layer.feed {
            Feed::Replay | Feed::Direct => layer.synapse_folds(),
            Feed::Hold | Feed::Adders => 1,
        };
        let times = operands
            .chunks(operands_of_sum)
            .flat_map(|group| {
                let sum = last(group) + to_sum;
                (0..layer.drain_beats()).map(move |beat| sum + beat + behind)
            })
            .take(layer.output_beats())
            .collect();
        Self {
            times,
            gather: layer.gather_latency,
        }
    }

    /// When the vector is whole.
    fn gathered(&self) -> usize {
        last(&self.times) + self.gather
    }
}

/// Cycles from an operand to its sum at the foot of the array.
pub fn sum_latency(layer: &Layer) -> usize {
    if let Some(adders) = layer.adders() {
        return adders.levels;
    }
    layer.copy_latency
        + layer.rom_latency
        + MULTIPLIER_LATENCY
        + layer.tree_levels()
        + usize::from(layer.accumulates())
}

/// Clocks that control bits are kept beside the array: until its sums, or where these are
/// accumulated until the elements take copies of the bits, a clock before the foot of the trees.
pub fn control_depth(layer: &Layer) -> usize {
    sum_latency(layer) - if layer.accumulates() { 2 } else { 0 }
}

/// Cycles from a sum to the layer's output word.
pub fn finish_latency(layer: &Layer) -> usize {
    let shift = if layer.quant.max_extra_shift() > 0 {
        EXTRA_SHIFT_LATENCY
    } else {
        0
    };
    let activation = layer.quant.table.as_ref();
    let activation = activation.map_or(0, |_| activation_latency(layer));
    REQUANT_LATENCY + shift + activation
}

/// Cycles of the activation unit: magnitude, segment, product, sum, sign.
pub fn activation_latency(layer: &Layer) -> usize {
    3 + layer.segment_latency + MULTIPLIER_LATENCY
}

fn last(times: &[usize]) -> usize {
    *times.last().expect("a frame has a beat")
}
