//! How much of an unbounded hidden word its readers need.

use crate::network::FloatLayer;

/// Neurons whose weights in all layers behind are below this part of a typical one don't count.
const INFLUENCE: f64 = 1.0 / 64.0;

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
/// its inputs (whitening): the landing networks' words are proved within 1120 and stay within 14.
/// Where only tanh and sigmoid read a word, bits above this magnitude would carry nothing.
/// `clips` gives the argument at which the table of a reading layer is clipped.
///
/// For a neuron with one input this is exact. For others it is an estimate: the words may cancel.
/// So it is the greatest that any neuron asks for (its argument for words of one magnitude and
/// any sign) and any word (by the weights that read it); a word beyond it raises the flag.
pub(super) fn relevant_magnitude(readers: &[Reader], clips: &[f64]) -> Option<f64> {
    let needs = readers.iter().zip(clips);
    let needed = needs.map(|(r, clip)| needed(r, *clip)).fold(0.0, f64::max);
    (needed > 0.0).then(|| libm::exp2(libm::log2(needed).ceil()))
}

fn needed(reader: &Reader, clip: f64) -> f64 {
    let layer = reader.layer;
    let counted: Vec<usize> = (0..layer.outputs())
        .filter(|i| counts(reader, *i))
        .collect();
    let argument = |i: usize| clip + layer.bias[i].abs();
    let by_neuron = counted
        .iter()
        .map(|i| argument(*i) / layer.weights.row(*i).norm());
    let typical = rms(counted.iter().map(|i| argument(*i)));
    let by_word = layer
        .weights
        .column_iter()
        .map(|column| typical / rms(counted.iter().map(|i| column[*i])));
    // A neuron that reads nothing and a word that nobody reads need nothing.
    by_neuron
        .chain(by_word)
        .filter(|needed| needed.is_finite())
        .fold(0.0, f64::max)
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
