//! From a float network to integers: formats derived, scales folded, sums bounded by proof.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::DMatrix;

use self::cut::Reader;
use self::layer::{Quantizer, Signal};
use crate::activation::OddTable;
use crate::adders::Adders;
use crate::format::QFormat;
use crate::network::{Activation, FloatLayer, FloatNet, LayerFormat};
use crate::options::Options;

mod cut;
mod input;
mod layer;
mod settings;
mod shift;

pub use self::input::InputFormat;

/// Why a float network can't become an integer one.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum QuantizeError {
    /// An option names a layer that the design does not have.
    #[error("option {option}: a layer of {known} expected, `{found}` found")]
    UnknownLayer {
        /// The option's name.
        option: &'static str,
        /// What it named.
        found: String,
        /// The layers there are.
        known: String,
    },
    /// A width outside the legal range.
    #[error("{what}: {low} to {high} bits expected, {found} found")]
    Width {
        /// Of what.
        what: String,
        /// Least legal width.
        low: u32,
        /// Greatest legal width.
        high: u32,
        /// The width asked for or needed.
        found: i64,
    },
    /// A number of segments that is no power of two in the legal range.
    #[error("segments: a power of two from 4 to {high} expected, {found} found")]
    Segments {
        /// One segment a code.
        high: u32,
        /// The number asked for.
        found: u32,
    },
    /// A format fixed by the trainer that the layer's activation can't have.
    #[error("{layer}: an activations format {expected} expected, {found} found")]
    ActivationFormat {
        /// The layer's name.
        layer: String,
        /// What would do.
        expected: String,
        /// The format in the file.
        found: QFormat,
    },
    /// An option that would change nothing.
    #[error("{option}: {expected} expected, {found} found")]
    Idle {
        /// The option and the layer that it names.
        option: String,
        /// What it applies to.
        expected: String,
        /// What there is.
        found: String,
    },
    /// An input whose whole box is a single code.
    #[error(
        "inputs: a step below the box of `{input}`, {low} to {high}, expected, a step of {step} \
         found"
    )]
    OneCode {
        /// The input's name.
        input: String,
        /// Lower edge of its box.
        low: f64,
        /// Upper edge of its box.
        high: f64,
        /// The step of its word.
        step: f64,
    },
    /// A number so large or so small that no word beside the others holds it.
    #[error("{what} of magnitude {found:e} can't be represented")]
    Magnitude {
        /// Of what.
        what: String,
        /// The greatest magnitude among them.
        found: f64,
    },
    /// A sum that no word is wide enough for.
    #[error("{layer}: sums of at most 52 bits expected, {found} bits needed")]
    SumWidth {
        /// The layer's name.
        layer: String,
        /// The bits that its greatest magnitude asks for.
        found: u32,
    },
}

impl QuantizeError {
    /// One line that says how to mend it.
    pub fn help(&self) -> String {
        match self {
            Self::UnknownLayer { .. } => "name one of the layers listed, or none for all".into(),
            Self::Width { what, .. } if what.starts_with("inputs") => {
                "give a coarser `resolution` or a smaller box".into()
            }
            Self::Width { .. } => "choose a width in the range".into(),
            Self::Segments { .. } => "choose a power of two, or leave the option out".into(),
            Self::ActivationFormat { .. } => "change the layer's `format.activations`".into(),
            Self::Idle { .. } => "leave the option out".into(),
            Self::OneCode { .. } => {
                "give a finer `resolution`, or the input another unit or offset".into()
            }
            Self::Magnitude { .. } => {
                "rescale: choose a unit in which the numbers are nearer to one".into()
            }
            Self::SumWidth { .. } => "use narrower weights or activations".into(),
        }
    }
}

/// Sums stay below this so that double precision holds them exactly.
const MAX_SUM_WIDTH: u32 = 52;

/// A layer in integers: `y = act(((W x << product_shift) + bias) >> shift)`.
///
/// # Format
/// Neuron `i` has weights of fraction `weights.fraction() + extra_shift[i]`; its sum is brought
/// back by `base_shift + extra_shift[i]` places to [`pre`](Self::pre), the activation's argument.
/// The bias carries half an output step, so that dropping the bits rounds half up.
#[derive(Clone, Debug, PartialEq)]
pub struct QuantLayer {
    /// `shared_l0`, `position_l1`: unique in the design.
    pub name: String,
    /// Name of its network, `shared` for the shared layers.
    pub network: String,
    /// Place among the layers of its network.
    pub index: usize,
    /// The activation.
    pub activation: Activation,
    /// Format of the input words.
    pub input: QFormat,
    /// Format of the weights of a neuron without extra shift.
    pub weight_format: QFormat,
    /// Weight codes, `[out][in]`.
    pub weights: Vec<Vec<i64>>,
    /// Bias codes with the rounding half, in units of the shifted sum.
    pub bias: Vec<i64>,
    /// Extra fraction bits of each neuron's weights.
    pub extra_shift: Vec<u32>,
    /// Inputs that count for nothing: their weights are not all zero, but all round to zero.
    pub unread: Vec<usize>,
    /// Places by which the sum is moved up before the bias is added.
    pub product_shift: u32,
    /// Places dropped after the bias was added, extra shift aside.
    pub base_shift: u32,
    /// Format of the activation's argument; the output's own for linear and ReLU.
    pub pre: QFormat,
    /// Format of the output words.
    pub output: QFormat,
    /// The table of tanh and sigmoid.
    pub table: Option<Arc<OddTable>>,
    /// Adders that form the sums without multipliers, where the weights are short enough.
    pub adders: Option<Arc<Adders>>,
    /// Bits that hold every partial sum of products for every input word, in the box or not.
    pub sum_width: u32,
    /// Bits that hold every sum with bias.
    pub biased_width: u32,
    /// Range of the weighted sums with bias over the input box, in real units: what reaches the
    /// activation.
    pub proved_range: (f64, f64),
}

impl QuantLayer {
    /// Number of inputs.
    pub fn inputs(&self) -> usize {
        self.weights[0].len()
    }

    /// Number of neurons.
    pub fn outputs(&self) -> usize {
        self.weights.len()
    }

    /// Lowest bits of a sum that are always zero: no weight has a digit there.
    pub fn trailing_zeros(&self) -> u32 {
        let weights = self.weights.iter().flatten();
        weights
            .map(|w| w.trailing_zeros())
            .min()
            .unwrap_or(0)
            .min(self.sum_width - 1)
    }

    /// Lowest bits of a biased sum that reach no word: they are dropped, and no bias carries out of them.
    pub fn dropped_bits(&self) -> u32 {
        let zeros = self.bias.iter().map(|bias| bias.trailing_zeros());
        zeros.min().unwrap_or(0).min(self.base_shift)
    }

    /// Greatest extra shift, zero if no neuron has one.
    pub fn max_extra_shift(&self) -> u32 {
        self.extra_shift.iter().copied().max().unwrap_or(0)
    }
}

/// One network in integers.
#[derive(Clone, Debug, PartialEq)]
pub struct QuantNetwork {
    /// Its name.
    pub name: String,
    /// Its own layers.
    pub layers: Vec<QuantLayer>,
    /// Names of its outputs.
    pub output_names: Vec<String>,
    /// Unit of its outputs.
    pub unit: String,
}

/// All networks in integers.
#[derive(Clone, Debug, PartialEq)]
pub struct QuantNet {
    /// The input words.
    pub input: InputFormat,
    /// Layers that all networks read.
    pub shared: Vec<QuantLayer>,
    /// The networks.
    pub networks: Vec<QuantNetwork>,
}

/// Chooses every format and turns every number into a code.
///
/// # Errors
/// [`QuantizeError`] where an option or a trainer's format can't be met.
pub fn quantize(net: &FloatNet, options: &Options) -> Result<QuantNet, QuantizeError> {
    let multiplier_bits = options.multiplier_bits();
    let input = InputFormat::of(net, multiplier_bits)?;
    let net = &input.in_one_format(net)?;
    let folded = fold_scales(net);
    settings::check(&folded, options)?;
    let mut quantizer = Quantizer {
        options,
        multiplier_bits,
        deep: folded.is_deep(),
        tables: BTreeMap::new(),
    };
    let mut signal = Signal::raw(net, &input);
    let mut shared = Vec::new();
    for (index, layer) in folded.shared.iter().enumerate() {
        let readers = folded.readers_of_shared(index);
        let q = quantizer.layer(layer, ("shared", index), &signal, &readers)?;
        signal = q.1;
        shared.push(q.0);
    }
    let mut networks = Vec::new();
    for (network, layers) in net.networks.iter().zip(&folded.networks) {
        let mut signal = signal.clone();
        let mut quantized = Vec::new();
        for (index, layer) in layers.iter().enumerate() {
            let readers: Vec<Reader> = reader(layers, index + 1).into_iter().collect();
            let q = quantizer.layer(layer, (&network.name, index), &signal, &readers)?;
            signal = q.1;
            quantized.push(q.0);
        }
        networks.push(QuantNetwork {
            name: network.name.clone(),
            layers: quantized,
            output_names: network.outputs.names.clone(),
            unit: network.outputs.unit.clone(),
        });
    }
    Ok(QuantNet {
        input,
        shared,
        networks,
    })
}

/// A layer, raw-unit maps folded in, and its name.
type FoldedLayer = (String, FloatLayer);

/// All layers, in the networks' order.
struct Folded {
    shared: Vec<FoldedLayer>,
    networks: Vec<Vec<FoldedLayer>>,
}

impl Folded {
    /// Whether a network has several tanh or sigmoid layers in front of its last one.
    ///
    /// What the first of them rounds off the others magnify, and their few neurons carry more each
    /// than those of one wide layer.
    fn is_deep(&self) -> bool {
        let hidden = |network: &Vec<FoldedLayer>| {
            let all = self.shared.iter().chain(network).rev().skip(1);
            all.filter(|(_, l)| l.activation.is_bounded()).count()
        };
        self.networks.iter().any(|network| hidden(network) > 1)
    }

    /// The layers that read a shared layer's words.
    fn readers_of_shared(&self, index: usize) -> Vec<Reader<'_>> {
        match reader(&self.shared, index + 1) {
            Some(mut next) => {
                if next.behind.is_empty() {
                    next.behind = self.networks.iter().map(|n| &n[0].1).collect();
                }
                vec![next]
            }
            None => {
                let networks = self.networks.iter();
                networks.filter_map(|n| reader(n, 0)).collect()
            }
        }
    }
}

/// A layer, if there is one, with the one behind it.
fn reader(layers: &[FoldedLayer], index: usize) -> Option<Reader<'_>> {
    layers.get(index).map(|(name, layer)| Reader {
        name,
        layer,
        behind: layers.get(index + 1).map(|(_, l)| l).into_iter().collect(),
    })
}

/// Puts the input and output maps into the first and last layers.
///
/// Where the trainer fixed a layer's format, or the last activation is not linear, the map
/// becomes a diagonal linear layer of its own, `shared_in` or `<network>_out`.
fn fold_scales(net: &FloatNet) -> Folded {
    let named = |prefix: &str, layers: &[FloatLayer]| -> Vec<FoldedLayer> {
        let name = |i| format!("{prefix}_l{i}");
        layers
            .iter()
            .enumerate()
            .map(|(i, l)| (name(i), l.clone()))
            .collect()
    };
    let mut shared = named("shared", &net.shared);
    let mut networks: Vec<Vec<FoldedLayer>> = net
        .networks
        .iter()
        .map(|n| named(&n.name, &n.layers))
        .collect();

    let scaled = net.inputs.scale.iter().any(|s| *s != 1.0);
    let fixed = |l: &FloatLayer| l.format.weights.is_some();
    let any_fixed = match shared.first() {
        Some((_, first)) => fixed(first),
        None => networks.iter().any(|layers| fixed(&layers[0].1)),
    };
    if scaled && any_fixed {
        shared.insert(0, ("shared_in".into(), diagonal(&net.inputs.scale, None)));
    } else {
        let scale_columns = |layer: &mut FloatLayer| {
            for (mut column, scale) in layer.weights.column_iter_mut().zip(&net.inputs.scale) {
                column *= *scale;
            }
        };
        match shared.first_mut() {
            Some((_, first)) => scale_columns(first),
            None => networks
                .iter_mut()
                .for_each(|layers| scale_columns(&mut layers[0].1)),
        }
    }
    for (network, layers) in net.networks.iter().zip(&mut networks) {
        let map = &network.outputs;
        if map.scale.iter().all(|s| *s == 1.0) && map.offset.iter().all(|o| *o == 0.0) {
            continue;
        }
        let (_, last) = layers.last_mut().expect("a network has a layer");
        if last.activation == Activation::Linear && last.format == LayerFormat::default() {
            for (i, (scale, offset)) in map.scale.iter().zip(&map.offset).enumerate() {
                last.weights.row_mut(i).scale_mut(*scale);
                last.bias[i] = last.bias[i] * scale + offset;
            }
        } else {
            let name = format!("{}_out", network.name);
            layers.push((name, diagonal(&map.scale, Some(&map.offset))));
        }
    }
    Folded { shared, networks }
}

fn diagonal(scale: &[f64], offset: Option<&[f64]>) -> FloatLayer {
    FloatLayer {
        activation: Activation::Linear,
        weights: DMatrix::from_diagonal(&nalgebra::DVector::from_column_slice(scale)),
        bias: offset.map_or_else(|| vec![0.0; scale.len()], <[f64]>::to_vec),
        format: LayerFormat::default(),
    }
}
