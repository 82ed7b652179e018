//! Frames that read the tables of activations: each segment that a search finds a frame for.
//!
//! Which segments are read depends on the data alone; a word that nobody reads may be wrong.

use std::collections::BTreeSet;

use hwgen_spec::design::Design;
use hwgen_spec::quantize::QuantLayer;
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;

/// Frames that are tried at most, and multiplications that this may take.
const TRIES: usize = 20_000;
const MULTIPLICATIONS: usize = 200_000_000;

/// A segment of a table: layers with the same table share its text. `(fraction, segments, segment)`.
type Read = (u32, usize, usize);

/// Inputs, as codes, that together read every segment which one of the inputs tried reads and
/// `before` do not.
pub(super) fn inputs(
    design: &Design,
    before: impl Iterator<Item = Vec<i64>>,
    rng: &mut ChaCha8Rng,
) -> Vec<Vec<i64>> {
    let all = segments(design);
    let mut found: BTreeSet<Read> = BTreeSet::new();
    for codes in before {
        read(design, codes, &mut found);
    }
    let weights: usize = layers(design)
        .map(|l| l.weights.len() * l.weights[0].len())
        .sum();
    let mut chosen = Vec::new();
    for try_ in 0..TRIES.min(MULTIPLICATIONS / weights.max(1)) {
        if found.len() == all {
            break;
        }
        let codes = some_input(design, try_ % 3, rng);
        let count = found.len();
        read(design, codes.clone(), &mut found);
        if found.len() > count {
            chosen.push(codes);
        }
    }
    chosen
}

/// How many segments some inputs read, and how many there are.
pub(crate) fn coverage(design: &Design, inputs: impl Iterator<Item = Vec<i64>>) -> (usize, usize) {
    let mut found = BTreeSet::new();
    for codes in inputs {
        read(design, codes, &mut found);
    }
    (found.len(), segments(design))
}

/// Anywhere in the box, at one of its corners, or on the way from its middle to one.
fn some_input(design: &Design, kind: usize, rng: &mut ChaCha8Rng) -> Vec<i64> {
    let input = design.input();
    let part: f64 = if kind == 1 { 1.0 } else { rng.random() };
    let bounds = input.low.iter().zip(&input.high);
    bounds
        .map(|(low, high)| match kind {
            0 => rng.random_range(*low..=*high),
            _ => {
                let middle = low + (high - low) / 2;
                let corner = if rng.random() { *low } else { *high };
                // Codes have at most 32 bits, which a double holds.
                middle + ((corner - middle) as f64 * part) as i64
            }
        })
        .collect()
}

fn layers(design: &Design) -> impl Iterator<Item = &QuantLayer> {
    let net = design.net();
    let behind = net.networks.iter().flat_map(|network| &network.layers);
    net.shared.iter().chain(behind)
}

/// Segments of all tables.
fn segments(design: &Design) -> usize {
    let tables = layers(design).filter_map(|layer| layer.table.as_ref());
    let different: BTreeSet<_> = tables.map(|t| (t.fraction(), t.segments())).collect();
    different.iter().map(|(_, segments)| segments).sum()
}

/// Adds the segments that a frame reads.
fn read(design: &Design, mut codes: Vec<i64>, found: &mut BTreeSet<Read>) {
    let net = design.net();
    net.input.clip(&mut codes);
    let mut pass = |layer: &QuantLayer, x: &[i64]| -> Vec<i64> {
        if let Some(table) = &layer.table {
            for (i, row) in layer.weights.iter().enumerate() {
                let sum = row.iter().zip(x).map(|(w, x)| w * x).sum();
                let segment = table.segment_of(layer.argument(i, sum));
                found.insert((table.fraction(), table.segments(), segment));
            }
        }
        layer.apply(x, &mut false)
    };
    let shared = net.shared.iter().fold(codes, |x, layer| pass(layer, &x));
    for network in &net.networks {
        network
            .layers
            .iter()
            .fold(shared.clone(), |x, layer| pass(layer, &x));
    }
}
