//! The trained network in floating point: what a weights file says, before any format is chosen.

use nalgebra::DMatrix;

use crate::format::QFormat;

/// What a neuron does to its weighted sum.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Activation {
    /// Hyperbolic tangent, the symmetric sigmoid.
    Tanh,
    /// Logistic function `1 / (1 + exp(-z))`.
    Sigmoid,
    /// `max(0, z)`.
    Relu,
    /// The identity.
    Linear,
}

impl Activation {
    /// Every activation, in the order in which messages list them.
    pub const ALL: [Self; 4] = [Self::Tanh, Self::Sigmoid, Self::Relu, Self::Linear];

    /// The name used in a weights file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tanh => "tanh",
            Self::Sigmoid => "sigmoid",
            Self::Relu => "relu",
            Self::Linear => "linear",
        }
    }

    /// The function itself, in double precision.
    pub fn apply(self, z: f64) -> f64 {
        match self {
            Self::Tanh => libm::tanh(z),
            Self::Sigmoid => 1.0 / (1.0 + libm::exp(-z)),
            Self::Relu => z.max(0.0),
            Self::Linear => z,
        }
    }

    /// Whether the output is bounded whatever the input.
    pub fn is_bounded(self) -> bool {
        matches!(self, Self::Tanh | Self::Sigmoid)
    }
}

/// Formats that a trainer fixed for a layer; absent fields are derived by the quantizer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LayerFormat {
    /// Format of every weight; the weights are multiples of its step.
    pub weights: Option<QFormat>,
    /// Format of every bias; the biases are multiples of its step.
    pub bias: Option<QFormat>,
    /// Format of the words that the layer puts out.
    pub activations: Option<QFormat>,
}

/// A fully connected layer: `act(W x + b)`.
#[derive(Clone, Debug, PartialEq)]
pub struct FloatLayer {
    /// Activation of all its neurons.
    pub activation: Activation,
    /// Weights, one row a neuron.
    ///
    /// # Shape
    /// `[out][in]`, at least 1 x 1.
    pub weights: DMatrix<f64>,
    /// Bias, one a neuron.
    ///
    /// # Shape
    /// `[out]`
    pub bias: Vec<f64>,
    /// Formats fixed by the trainer.
    pub format: LayerFormat,
}

impl FloatLayer {
    /// Number of inputs.
    pub fn inputs(&self) -> usize {
        self.weights.ncols()
    }

    /// Number of neurons.
    pub fn outputs(&self) -> usize {
        self.weights.nrows()
    }
}

/// The inputs that every network reads: names, unit, box, scaling.
///
/// All vectors have one entry an input.
#[derive(Clone, Debug, PartialEq)]
pub struct Inputs {
    /// Unique names; `in0`, `in1`, ... where the file gives none.
    pub names: Vec<String>,
    /// Unit of the raw values, empty if not given.
    pub unit: String,
    /// Lower edge of the box that raw inputs come from.
    pub min: Vec<f64>,
    /// Upper edge of the box.
    pub max: Vec<f64>,
    /// `x = (raw - offset) * scale`.
    pub offset: Vec<f64>,
    /// `x = (raw - offset) * scale`.
    pub scale: Vec<f64>,
    /// Raw step that the input format must represent.
    pub resolution: Option<f64>,
}

/// The outputs of one network in real units: `y = o * scale + offset`.
#[derive(Clone, Debug, PartialEq)]
pub struct Outputs {
    /// Unique names within the network; `out0`, ... where the file gives none.
    pub names: Vec<String>,
    /// Unit of the real values, empty if not given.
    pub unit: String,
    /// Factor, one an output.
    pub scale: Vec<f64>,
    /// Summand, one an output.
    pub offset: Vec<f64>,
}

/// One network: its own layers after the shared ones, and its outputs.
#[derive(Clone, Debug, PartialEq)]
pub struct Network {
    /// A Verilog identifier, unique in the file.
    pub name: String,
    /// At least one layer.
    pub layers: Vec<FloatLayer>,
    /// Names and units of what comes out.
    pub outputs: Outputs,
}

/// Frames that are like those that the core will meet.
///
/// The box says how far each input reaches by itself, and nothing of how they go together.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// At least one frame, all finite, possibly outside of the box.
    ///
    /// # Shape
    /// `[frames][in]`, in raw units.
    pub inputs: Vec<Vec<f64>>,
    /// Where they come from, empty if not given.
    pub note: String,
}

/// Everything that a weights file says.
#[derive(Clone, Debug, PartialEq)]
pub struct FloatNet {
    /// Name of the design, a Verilog identifier.
    pub name: String,
    /// The inputs.
    pub inputs: Inputs,
    /// Layers that every network reads, possibly none.
    pub shared: Vec<FloatLayer>,
    /// One or more networks.
    pub networks: Vec<Network>,
    /// Frames that the error of fixed point is measured with.
    pub calibration: Option<Calibration>,
}

impl FloatNet {
    /// Outputs of all networks in file order, in real units, for one vector of raw inputs.
    ///
    /// This is the float reference that errors are reported against.
    ///
    /// # Shape
    /// `raw`: `[in]`; result: `[sum of the networks' outputs]`.
    pub fn forward(&self, raw: &[f64]) -> Vec<f64> {
        let standard: Vec<f64> = raw
            .iter()
            .zip(self.inputs.offset.iter().zip(&self.inputs.scale))
            .map(|(r, (offset, scale))| (r - offset) * scale)
            .collect();
        let shared = forward_layers(&self.shared, standard);
        self.networks
            .iter()
            .flat_map(|network| {
                let o = forward_layers(&network.layers, shared.clone());
                let map = network.outputs.scale.iter().zip(&network.outputs.offset);
                o.into_iter()
                    .zip(map)
                    .map(|(o, (scale, offset))| o * scale + offset)
                    .collect::<Vec<_>>()
            })
            .collect()
    }

    /// `<network>.<output>` of every output in stream order.
    pub fn output_columns(&self) -> Vec<String> {
        self.networks
            .iter()
            .flat_map(|n| n.outputs.names.iter().map(|o| format!("{}.{o}", n.name)))
            .collect()
    }

    /// Multiplications of one inference, shared layers counted once.
    pub fn macs(&self) -> usize {
        let layers = self.networks.iter().flat_map(|n| &n.layers);
        self.shared
            .iter()
            .chain(layers)
            .map(|l| l.weights.len())
            .sum()
    }
}

fn forward_layers(layers: &[FloatLayer], input: Vec<f64>) -> Vec<f64> {
    let mut x = nalgebra::DVector::from_vec(input);
    for layer in layers {
        let mut z = &layer.weights * x;
        for (z, b) in z.iter_mut().zip(&layer.bias) {
            *z = layer.activation.apply(*z + b);
        }
        x = z;
    }
    x.data.into()
}
