//! The network that the faults are put into.

use hwgen_spec::format::{QFormat, Rounding};
use hwgen_spec::network::{
    Activation, FloatLayer, FloatNet, Inputs, LayerFormat, Network, Outputs,
};
use hwgen_spec::options::{Budget, Options, WidthSetting};
use nalgebra::DMatrix;

/// Weights between -1 and 1 without a pattern, the same on every machine.
fn layer(
    activation: Activation,
    outputs: usize,
    inputs: usize,
    weight: impl Fn(usize, usize) -> Option<f64>,
) -> FloatLayer {
    let noise = |i: usize, j: usize| {
        let mixed = (i * 31 + j * 17 + outputs * 7 + inputs) * 2_654_435_761 % 4_294_967_296;
        f64::from(u32::try_from(mixed).expect("32 bits")) / 2_147_483_648.0 - 1.0
    };
    FloatLayer {
        activation,
        weights: DMatrix::from_fn(outputs, inputs, |i, j| {
            weight(i, j).unwrap_or_else(|| noise(i, j))
        }),
        bias: (0..outputs).map(|i| noise(i, 99) / 2.0).collect(),
        format: LayerFormat::default(),
    }
}

/// Rounds what a format is fixed for.
fn to_format(layer: &mut FloatLayer) {
    let round = |format: Option<QFormat>, v: &mut f64| {
        if let Some(format) = format {
            *v = format.to_f64(format.quantize(*v, Rounding::HalfUp).code);
        }
    };
    let format = layer.format;
    layer
        .weights
        .iter_mut()
        .for_each(|w| round(format.weights, w));
    layer.bias.iter_mut().for_each(|b| round(format.bias, b));
}

/// Small, and with every feature that the array has.
///
/// Some words are cut short by a format, so that saturation is reached inside the box, and one
/// neuron meets the lowest code of an argument exactly.
pub fn fixture() -> (FloatNet, Options) {
    let words = |bits, fraction| LayerFormat {
        activations: Some(QFormat::new(bits, fraction).expect("legal")),
        ..LayerFormat::default()
    };
    // Neuron 0 puts out its input, up to 2 exactly; the others go beyond 4.
    let mut shared = layer(Activation::Relu, 6, 5, |i, j| match (i, j) {
        (0, 0) => Some(1.0),
        (0, _) => Some(0.0),
        (4, _) => None,
        (_, 0) => Some(1.75),
        _ => None,
    });
    shared.bias[0] = 0.0;
    shared.format = words(11, 8);
    // Neuron 0 is -4 exactly where its input is 2; neuron 2 is small and has a shift of its own.
    let mut tanh = layer(Activation::Tanh, 7, 6, |i, j| match (i, j) {
        (0, 0) => Some(-2.0),
        (0, _) => Some(0.0),
        (2 | 5, _) => Some(0.003 * ((i + 2 * j) % 5) as f64 - 0.005),
        _ => None,
    });
    tanh.bias[0] = 0.0;
    let mut linear = layer(Activation::Linear, 3, 7, |_, _| None);
    // Cut to [-1, 1), and the map of the outputs becomes a layer of its own.
    linear.format = words(10, 9);
    // Biases finer than products, and weights that the trainer fixed.
    let mut sigmoid = layer(Activation::Sigmoid, 4, 6, |_, _| None);
    sigmoid.format.bias = QFormat::new(20, 18).ok();
    to_format(&mut sigmoid);
    let mut relu = layer(Activation::Relu, 2, 4, |_, _| None);
    relu.format.weights = QFormat::new(8, 6).ok();
    relu.format.bias = QFormat::new(10, 8).ok();
    to_format(&mut relu);
    // Two beats, two clocks apart, for two neurons that take turns.
    let narrow = layer(Activation::Relu, 2, 6, |_, _| None);
    let turns = layer(Activation::Linear, 2, 2, |_, _| None);
    let outputs = |count: usize, scale: f64| Outputs {
        names: (0..count).map(|o| format!("out{o}")).collect(),
        unit: "m".into(),
        scale: vec![scale; count],
        offset: vec![0.0; count],
    };
    let net = FloatNet {
        name: "mutant".into(),
        inputs: Inputs {
            names: (0..5).map(|i| format!("in{i}")).collect(),
            unit: "V".into(),
            min: vec![-2.0, -1.0, -1.5, -3.0, -1.0],
            max: vec![2.0, 1.0, 1.0, 3.0, 2.0],
            offset: vec![0.0; 5],
            scale: vec![1.0; 5],
            resolution: Some(1.0 / 64.0),
        },
        shared: vec![shared],
        networks: vec![
            Network {
                name: "a".into(),
                layers: vec![tanh, linear],
                outputs: outputs(3, 3.0),
            },
            Network {
                name: "b".into(),
                layers: vec![sigmoid, relu],
                outputs: outputs(2, 1.0),
            },
            Network {
                name: "c".into(),
                layers: vec![narrow, turns],
                outputs: outputs(2, 1.0),
            },
        ],
        calibration: None,
    };
    let any = |bits| vec![WidthSetting { layer: None, bits }];
    let options = Options {
        budget: Budget::Interval(4),
        weight_bits: any(6),
        activation_bits: any(10),
        output_bits: Some(16),
        segments: None,
        device: None,
        stream_bits: None,
        prefix: None,
    };
    (net, options)
}
