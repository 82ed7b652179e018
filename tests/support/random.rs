//! Designs drawn from a seed.

use hwgen_spec::design::Design;
use hwgen_spec::format::{QFormat, Rounding};
use hwgen_spec::network::{
    Activation, FloatLayer, FloatNet, Inputs, LayerFormat, Network, Outputs,
};
use hwgen_spec::options::{Budget, Options, WidthSetting};
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A legal network and options, drawn from a seed: sizes, widths, foldings, activations, layers,
/// networks, formats; in one of three some layers have formats of the trainer's.
pub fn random_design(seed: u64) -> (FloatNet, Options) {
    let (mut net, mut options) = float_design(seed);
    let mut rng = ChaCha8Rng::seed_from_u64(!seed);
    if rng.random_ratio(1, 3) {
        let layers = net.networks.iter_mut().flat_map(|n| &mut n.layers);
        for layer in net.shared.iter_mut().chain(layers) {
            if rng.random_bool(0.6) {
                fix_formats(layer, &mut rng);
            }
        }
    }
    if rng.random_ratio(1, 3) {
        let layers = net.networks.iter_mut().flat_map(|n| &mut n.layers);
        for layer in net.shared.iter_mut().chain(layers) {
            if layer.format.weights.is_none() && rng.random_bool(0.5) {
                shorten(layer, &mut rng);
            }
        }
    }
    options.stream_bits = [None, Some(64), Some(8)][rng.random_range(0..3)];
    drop_idle(&net, &mut options);
    // A number of multipliers, the device's among them, where they are enough for the design.
    if rng.random_ratio(1, 2) {
        let some = Budget::Multipliers(rng.random_range(1..60));
        let other = Options {
            budget: match options.device {
                Some(_) if rng.random_bool(0.7) => Budget::Device,
                _ => some,
            },
            ..options.clone()
        };
        if Design::new(&net, &other).is_ok() {
            options = other;
        }
    }
    (net, options)
}

/// Leaves options out that no layer of the network would follow.
fn drop_idle(net: &FloatNet, options: &mut Options) {
    let layers = || {
        net.shared
            .iter()
            .chain(net.networks.iter().flat_map(|n| &n.layers))
    };
    if !layers().any(|l| l.activation.is_bounded()) {
        options.segments = None;
    }
    let has_free_words = |network: &Network| {
        let last = network.layers.last().expect("a layer");
        let mapped = network.outputs.scale.iter().any(|s| *s != 1.0);
        let plain = last.activation == Activation::Linear && last.format == LayerFormat::default();
        (mapped && !plain) || (!last.activation.is_bounded() && last.format.activations.is_none())
    };
    if !net.networks.iter().any(has_free_words) {
        options.output_bits = None;
    }
}

/// Gives a layer weights that adders may form, some rows without any.
fn shorten(layer: &mut FloatLayer, rng: &mut ChaCha8Rng) {
    let reach = layer.weights.amax().max(1e-3);
    let unit = libm_exp2(reach.log2().floor() as i32 - 2);
    for mut row in layer.weights.row_iter_mut() {
        let few = rng.random_bool(0.2);
        for w in &mut row {
            let short = [0.0, 0.0, 1.0, -1.0, 2.0, -2.0, 4.0, -4.0, 3.0, -1.0];
            let at = rng.random_range(0..if few { 2 } else { short.len() });
            *w = unit * short[at];
        }
    }
}

/// Gives a layer formats, and rounds its numbers to them as a trainer would have done.
fn fix_formats(layer: &mut FloatLayer, rng: &mut ChaCha8Rng) {
    let round = |format: QFormat, v: &mut f64| {
        *v = format.to_f64(format.quantize(*v, Rounding::HalfUp).code);
    };
    let (low, high) = (layer.weights.min(), layer.weights.max());
    let weights = QFormat::holding(rng.random_range(4..=12), low, high).expect("legal");
    let bias = QFormat::new(20, rng.random_range(6..=17)).expect("legal");
    layer.weights.iter_mut().for_each(|w| round(weights, w));
    layer.bias.iter_mut().for_each(|b| round(bias, b));
    layer.format.weights = Some(weights);
    layer.format.bias = Some(bias);
    if !layer.activation.is_bounded() && rng.random_bool(0.5) {
        layer.format.activations = QFormat::new(12, rng.random_range(4..=9)).ok();
    }
}

fn float_design(seed: u64) -> (FloatNet, Options) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let sizes = [1, 1, 2, 3, 4, 5, 7, 8, 11, 13, 16, 17];
    let size = |rng: &mut ChaCha8Rng| sizes[rng.random_range(0..sizes.len())];
    let inputs = size(&mut rng);
    let low: Vec<f64> = (0..inputs)
        .map(|_| rng.random_range(-100.0..50.0))
        .collect();
    let high: Vec<f64> = low
        .iter()
        .map(|l| l + f64::max(4.0, rng.random_range(0.0..200.0)))
        .collect();
    let plain = rng.random_bool(0.3);
    let layer = |rng: &mut ChaCha8Rng, inputs: usize, outputs: usize| {
        let activation = Activation::ALL[rng.random_range(0..4)];
        let reach = libm_exp2(rng.random_range(-6..4)) / f64::from(u32::try_from(inputs).unwrap());
        let mut draw = |reach: f64| rng.random_range(-reach..reach);
        let weights = DMatrix::from_fn(outputs, inputs, |i, _| {
            // Rows of very different size call for shifts of their own.
            draw(reach) * if i % 3 == 2 { 0.01 } else { 1.0 }
        });
        let bias = (0..outputs).map(|_| draw(2.0)).collect();
        FloatLayer {
            activation,
            weights,
            bias,
            format: LayerFormat::default(),
        }
    };
    let stack = |rng: &mut ChaCha8Rng, inputs: usize, layers: usize| {
        let mut stack: Vec<FloatLayer> = Vec::new();
        for _ in 0..layers {
            let from = stack.last().map_or(inputs, FloatLayer::outputs);
            let to = size(rng);
            stack.push(layer(rng, from, to));
        }
        stack
    };
    let shared_layers = [0, 0, 1, 2][rng.random_range(0..4)];
    let shared = stack(&mut rng, inputs, shared_layers);
    let into = shared.last().map_or(inputs, FloatLayer::outputs);
    let networks = (0..[1, 1, 2, 3][rng.random_range(0..4)])
        .map(|i| {
            let depth = rng.random_range(1..=3);
            let layers = stack(&mut rng, into, depth);
            let outputs = layers.last().expect("a layer").outputs();
            let scaled = rng.random_bool(0.5);
            let scale = |rng: &mut ChaCha8Rng| {
                (0..outputs)
                    .map(|_| {
                        if scaled {
                            rng.random_range(0.1..20.0)
                        } else {
                            1.0
                        }
                    })
                    .collect::<Vec<f64>>()
            };
            let (scale, offset) = (scale(&mut rng), scale(&mut rng));
            let offset = if scaled { offset } else { vec![0.0; outputs] };
            let names = (0..outputs).map(|o| format!("out{o}")).collect();
            let outputs = Outputs {
                names,
                unit: "m".into(),
                scale,
                offset,
            };
            Network {
                name: format!("net{i}"),
                layers,
                outputs,
            }
        })
        .collect();
    let net = FloatNet {
        name: format!("random{seed}"),
        inputs: Inputs {
            names: (0..inputs).map(|i| format!("in{i}")).collect(),
            unit: "px".into(),
            offset: (0..inputs)
                .map(|i| if plain { 0.0 } else { (low[i] + high[i]) / 2.0 })
                .collect(),
            scale: (0..inputs)
                .map(|_| {
                    if plain {
                        1.0
                    } else {
                        rng.random_range(0.01..0.1)
                    }
                })
                .collect(),
            resolution: [None, Some(0.0625), Some(3.0)][rng.random_range(0..3)],
            min: low,
            max: high,
        },
        shared,
        networks,
        calibration: None,
    };
    let any = |bits| vec![WidthSetting { layer: None, bits }];
    let options = Options {
        budget: Budget::Interval([1, 2, 3, 5, 7, 8, 16, 31, 64, 200][rng.random_range(0..10)]),
        weight_bits: any(rng.random_range(4..=18)),
        activation_bits: any(rng.random_range(7..=16)),
        output_bits: Some(rng.random_range(6..=32)),
        segments: [None, None, Some(8), Some(32)][rng.random_range(0..4)],
        device: [None, Some("ecp5-25k"), Some("ice40-up5k")][rng.random_range(0..3)]
            .map(|device| match device {
                "ice40-up5k" if rng.random_bool(0.4) => "ice40-hx8k",
                _ => device,
            })
            .map(str::to_owned),
        stream_bits: None,
        prefix: None,
    };
    (net, options)
}

fn libm_exp2(exponent: i32) -> f64 {
    2f64.powi(exponent)
}
