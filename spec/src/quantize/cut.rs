//! How much of an unbounded hidden word its readers need.

use crate::network::FloatLayer;

/// Neurons whose weights in all layers behind are below this part of a typical one don't count.
const INFLUENCE: f64 = 1.0 / 64.0;

/// The argument at which tanh is within half a percent of its limit; sigmoid is so at twice that.
pub(super) const NEARLY: f64 = 3.0;

/// A layer that reads a word.
pub(super) struct Reader<'a> {
    /// Its name.
    pub(super) name: &'a str,
    /// Its weights and biases.
    pub(super) layer: &'a FloatLayer,
    /// The layers that read its neurons; none behind a last layer.
    pub(super) behind: Vec<&'a FloatLayer>,
}

/// The magnitude beyond which a hidden word drives every neuron behind it into saturation.
///
/// Interval analysis over a box of independent inputs is far too wide for a layer that decorrelates
/// its inputs: the landing networks' words are proved within 340 and stay within 5.3.
/// Where only tanh and sigmoid read a word, bits above this magnitude would carry nothing.
/// `clips` gives the argument at which the table of a reading layer is clipped, and the one at which
/// its activation is nearly at its limit.
///
/// For a neuron that reads one word this is exact. For others it is an estimate: words that are
/// large together may cancel. So it is the greatest that any neuron asks for (its argument for
/// words of one magnitude and any sign) and any word (by the weights of the layer that makes most
/// of it); a word beyond it raises the flag.
pub(super) fn relevant_magnitude(readers: &[Reader], clips: &[(f64, f64)]) -> Option<f64> {
    let mut by_neuron = Vec::new();
    let mut by_word: Vec<f64> = Vec::new();
    for (reader, limits) in readers.iter().zip(clips) {
        let needs = Needs::of(reader, *limits);
        by_neuron.extend(needs.by_neuron);
        by_word.resize(needs.by_word.len(), f64::INFINITY);
        for (least, need) in by_word.iter_mut().zip(needs.by_word) {
            *least = least.min(need);
        }
    }
    // A neuron that reads nothing and a word that nobody reads need nothing.
    let finite = by_neuron
        .into_iter()
        .chain(by_word)
        .filter(|e| e.is_finite());
    finite.reduce(f64::max).map(libm::exp2)
}

/// The powers of two that the neurons of one reading layer ask for, and those it asks for each word.
struct Needs {
    by_neuron: Vec<f64>,
    by_word: Vec<f64>,
}

impl Needs {
    fn of(reader: &Reader, (clip, nearly): (f64, f64)) -> Self {
        let layer = reader.layer;
        let counted = (0..layer.outputs()).filter(|i| counts(reader, *i));
        let counted: Vec<usize> = counted.collect();
        let argument = |i: &usize, clip: f64| clip + layer.bias[*i].abs();
        let estimate = |need: f64| libm::log2(need).round();
        let by_neuron = counted.iter().map(|i| {
            let row = layer.weights.row(*i);
            if row.iter().filter(|w| **w != 0.0).count() == 1 {
                libm::log2(argument(i, clip) / row.norm()).ceil()
            } else {
                estimate(argument(i, nearly) / row.norm())
            }
        });
        let typical = rms(counted.iter().map(|i| argument(i, nearly)));
        let by_word = layer
            .weights
            .column_iter()
            .map(|column| estimate(typical / rms(counted.iter().map(|i| column[*i]))));
        Self {
            by_neuron: by_neuron.collect(),
            by_word: by_word.collect(),
        }
    }
}

/// Whether a neuron is of influence. Training leaves some that aren't, with weights near zero
/// before them as well, which would ask for words far wider than any other neuron.
fn counts(reader: &Reader, neuron: usize) -> bool {
    let mut rows = reader.behind.iter().flat_map(|l| l.weights.row_iter());
    reader.behind.is_empty()
        || rows.any(|row| row[neuron].abs() > INFLUENCE * rms(row.iter().copied()))
}

fn rms(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "a count of weights")]
    let count = values.len() as f64;
    (values.map(|v| v * v).sum::<f64>() / count).sqrt()
}
