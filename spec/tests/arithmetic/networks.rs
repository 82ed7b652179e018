//! Whole networks against a second computation from first principles.

use hwgen_spec::design::Design;
use hwgen_spec::network::{Activation, FloatLayer};
use hwgen_spec::options::Options;
use hwgen_spec::quantize::{QuantLayer, QuantNet, quantize};
use hwgen_spec::weights;

use super::support::{self, Random};
use super::{clip, floor_shift, ldexp};

/// One layer for one frame in plain wide integers; the flag of a word that was clipped.
fn layer_again(layer: &QuantLayer, x: &[i64]) -> (Vec<i64>, bool) {
    let mut any = false;
    let mut words = Vec::new();
    for i in 0..layer.weights.len() {
        let mut sum = 0i128;
        for (w, x) in layer.weights[i].iter().zip(x) {
            sum += i128::from(*w) * i128::from(*x);
            assert_fits(sum, layer.sum_width, "a partial sum");
        }
        let biased = sum * (1i128 << layer.product_shift) + i128::from(layer.bias[i]);
        assert_fits(biased, layer.biased_width, "a biased sum");
        let z = floor_shift(biased, layer.base_shift + layer.extra_shift[i]);
        let width = layer.pre.width();
        words.push(match layer.activation {
            Activation::Linear | Activation::Relu => {
                let z = if layer.activation == Activation::Relu {
                    z.max(0)
                } else {
                    z
                };
                let (code, clipped) = clip(z, width);
                any |= clipped;
                code
            }
            Activation::Tanh | Activation::Sigmoid => {
                let table = layer.table.as_ref().expect("a table");
                let bits = table.range_log2() + table.fraction();
                let magnitude = z.abs().min((1i128 << bits) - 1);
                let distance_bits = bits - table.segment_bits();
                let segment = usize::try_from(magnitude >> distance_bits).expect("small");
                let distance = magnitude % (1i128 << distance_bits);
                let (offset, slope) = table.lines().nth(segment).expect("a segment");
                let line = i128::from(offset) * (1i128 << table.slope_bits())
                    + 4 * i128::from(slope) * distance;
                let t = floor_shift(line, table.slope_bits() + 2);
                let t = if z < 0 { -t } else { t };
                let one = match layer.activation {
                    Activation::Sigmoid => 1i128 << table.fraction(),
                    _ => 0,
                };
                i64::try_from(one + t).expect("a word")
            }
        });
        let word = i128::from(words[i]);
        assert_fits(word, layer.output.width(), "an output word");
    }
    (words, any)
}

fn assert_fits(value: i128, width: u32, what: &str) {
    let top = 1i128 << (width - 1);
    assert!(
        (-top..top).contains(&value),
        "{what} beyond {width} bits: {value}"
    );
}

/// All networks for one frame: codes, input flag, saturation flag.
fn again(net: &QuantNet, frame: &[i64]) -> (Vec<i64>, bool, bool) {
    let mut x = frame.to_vec();
    for (i, x) in x.iter_mut().enumerate() {
        *x = (*x).max(net.input.low[i]).min(net.input.high[i]);
    }
    let outside = x != frame;
    let mut saturated = false;
    let mut run = |layers: &[QuantLayer], x: &[i64]| {
        layers.iter().fold(x.to_vec(), |x, layer| {
            let (y, clipped) = layer_again(layer, &x);
            saturated |= clipped;
            y
        })
    };
    let x = run(&net.shared, &x);
    let codes = net
        .networks
        .iter()
        .flat_map(|n| run(&n.layers, &x))
        .collect();
    (codes, outside, saturated)
}

fn layers(net: &QuantNet) -> impl Iterator<Item = &QuantLayer> {
    net.shared
        .iter()
        .chain(net.networks.iter().flat_map(|n| &n.layers))
}

#[test]
fn random_networks_compute_what_first_principles_do() {
    let (mut made, mut frames, mut saturations, mut outsides) = (0, 0, 0, 0);
    let mut seen = [0usize; 4];
    let mut features = [0usize; 3];
    for seed in 0..700u64 {
        let mut random = Random(seed);
        let float = support::net(&mut random);
        let Ok(net) = quantize(&float, &support::options(&mut random)) else {
            continue;
        };
        made += 1;
        for layer in layers(&net) {
            let kind = Activation::ALL.iter().position(|a| *a == layer.activation);
            seen[kind.expect("one of all")] += 1;
            features[0] += usize::from(layer.max_extra_shift() > 0);
            features[1] += usize::from(layer.product_shift > 0);
            features[2] += usize::from(layer.name.ends_with("_out") || layer.name == "shared_in");
        }
        for _ in 0..20 {
            let frame = support::frame(
                &mut random,
                &net.input.low,
                &net.input.high,
                net.input.format,
            );
            let found = net.evaluate(&frame);
            let expected = again(&net, &frame);
            assert_eq!(
                (found.codes, found.input_clipped, found.saturated),
                expected,
                "seed {seed}, {frame:?}"
            );
            frames += 1;
            saturations += usize::from(expected.2);
            outsides += usize::from(expected.1);
        }
    }
    println!(
        "{made} networks, {frames} frames, {saturations} saturated, {outsides} outside, layers {seen:?}, {features:?}"
    );
    assert!(made >= 400, "{made} networks");
    assert!(
        saturations > 100 && saturations < frames - 100,
        "{saturations} of {frames}"
    );
    assert!(outsides > 100 && outsides < frames - 100);
    assert!(seen.iter().all(|n| *n > 100), "{seen:?}");
    assert!(features.iter().all(|n| *n > 30), "{features:?}");
}

/// A sum of products is greatest at a corner: all of them, of words in the box or not.
#[test]
fn no_sum_is_beyond_its_width_at_any_corner() {
    let mut corners = 0;
    for seed in 0..300u64 {
        let mut random = Random(seed);
        let float = support::net(&mut random);
        let Ok(net) = quantize(&float, &support::options(&mut random)) else {
            continue;
        };
        for layer in layers(&net) {
            let (least, most) = (layer.input.min_code(), layer.input.max_code());
            assert!(layer.inputs() <= 7);
            for corner in 0u32..1 << layer.inputs() {
                let x: Vec<i64> = (0..layer.inputs())
                    .map(|i| if corner >> i & 1 == 1 { most } else { least })
                    .collect();
                layer_again(layer, &x);
                corners += 1;
            }
            assert!(layer.biased_width <= 52);
        }
    }
    assert!(corners > 10_000, "{corners}");
}

/// The numbers of a layer with a format are that format's codes, and stay so.
#[test]
fn given_formats_are_kept() {
    let (mut weights, mut activations) = (0, 0);
    for seed in 0..400u64 {
        let mut random = Random(seed);
        let float = support::net(&mut random);
        let Ok(net) = quantize(&float, &support::options(&mut random)) else {
            continue;
        };
        let floats: Vec<(String, &FloatLayer)> = float
            .shared
            .iter()
            .enumerate()
            .map(|(i, l)| (format!("shared_l{i}"), l))
            .chain(float.networks.iter().flat_map(|n| {
                let named = |(i, l)| (format!("{}_l{i}", n.name), l);
                n.layers.iter().enumerate().map(named)
            }))
            .collect();
        for (name, float) in floats {
            let layer = layers(&net)
                .find(|l| l.name == name)
                .expect("of the same name");
            if let Some(format) = float.format.weights {
                weights += 1;
                assert_eq!(layer.weight_format, format, "{name}");
                assert_eq!(layer.max_extra_shift(), 0, "{name}");
                for (i, row) in layer.weights.iter().enumerate() {
                    for (k, code) in row.iter().enumerate() {
                        #[expect(clippy::cast_precision_loss, reason = "24 bits")]
                        let code = *code as f64;
                        assert_eq!(
                            code,
                            ldexp(float.weights[(i, k)], format.fraction()),
                            "{name}"
                        );
                    }
                }
            }
            if let Some(format) = float.format.activations {
                activations += 1;
                assert_eq!(layer.output, format, "{name}");
            }
        }
    }
    assert!(
        weights > 100 && activations > 100,
        "{weights}, {activations}"
    );
}

/// Formats that lead to absurd shifts are refused, without a panic.
#[test]
fn far_formats_are_refused() {
    for (weights, bias, activations) in [
        ("Q-90.105", "Q0.15", "Q7.8"),
        ("Q-985.1000", "Q0.15", "Q7.8"),
        ("Q0.15", "Q-980.1000", "Q7.8"),
        ("Q1000.-985", "Q0.15", "Q7.8"),
        ("Q0.15", "Q0.15", "Q-960.975"),
        ("Q0.15", "Q0.15", "Q975.-960"),
    ] {
        let text = format!(
            r#"{{"format": "hwgen-weights/1", "name": "far",
            "inputs": {{"min": [-1], "max": [1]}},
            "networks": [{{"name": "net", "layers": [{{"activation": "linear",
              "weights": [[0]], "bias": [0], "format":
              {{"weights": "{weights}", "bias": "{bias}", "activations": "{activations}"}}}}]}}]}}"#
        );
        let float = weights::read(text.as_bytes()).expect("a weights file");
        if let Ok(design) = Design::new(&float, &Options::default()) {
            for layer in layers(design.net()) {
                layer_again(layer, &[layer.input.min_code()]);
            }
        }
    }
}
