//! Random networks, from one seed each, and the landing design.
#![allow(
    dead_code,
    clippy::allow_attributes,
    reason = "each test crate uses its part of it"
)]

use std::path::Path;

use hwgen_spec::format::QFormat;
use hwgen_spec::network::{Activation, FloatLayer, FloatNet, Inputs, LayerFormat};
use hwgen_spec::network::{Network, Outputs};
use hwgen_spec::options::{Options, WidthSetting};
use nalgebra::DMatrix;

/// A file of the landing design.
pub fn landing(file: &str) -> Vec<u8> {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("../designs/landing");
    std::fs::read(directory.join(file)).expect("a file of the project")
}

/// Steele, Lea and Flood's SplitMix64 (2014).
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// An integer of `low..=high`.
    pub fn integer(&mut self, low: i64, high: i64) -> i64 {
        let span = u64::try_from(high - low + 1).expect("low <= high");
        low + i64::try_from(self.bits() % span).expect("below the span")
    }

    pub fn count(&mut self, low: usize, high: usize) -> usize {
        let low = i64::try_from(low).expect("small");
        usize::try_from(self.integer(low, i64::try_from(high).expect("small"))).expect("positive")
    }

    pub fn width(&mut self, low: u32, high: u32) -> u32 {
        u32::try_from(self.integer(low.into(), high.into())).expect("positive")
    }

    /// Once in `of` times.
    pub fn once_in(&mut self, of: u64) -> bool {
        self.bits().is_multiple_of(of)
    }

    /// A number of `[-1, 1)`, in steps of 2^-31.
    pub fn unit(&mut self) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "32 bits")]
        let unit = self.integer(-(1 << 31), (1 << 31) - 1) as f64;
        libm::ldexp(unit, -31)
    }

    /// A power of two of `2^low ..= 2^high`.
    pub fn power(&mut self, low: i64, high: i64) -> f64 {
        let exponent = self.integer(low, high);
        libm::ldexp(1.0, i32::try_from(exponent).expect("small"))
    }
}

/// A code's value.
fn value(code: i64, format: QFormat) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "codes have 24 bits at most")]
    libm::ldexp(code as f64, -format.fraction())
}

fn layer(random: &mut Random, inputs: usize, last: bool) -> FloatLayer {
    let outputs = random.count(1, 7);
    let activation = Activation::ALL[random.count(0, 3)];
    let mut format = LayerFormat::default();
    if random.once_in(3) {
        let bits = random.width(2, 18);
        let fraction = i32::try_from(random.integer(-2, 20)).expect("small");
        format.weights = QFormat::new(bits, fraction).ok();
    }
    if random.once_in(4) {
        let fraction = i32::try_from(random.integer(0, 24)).expect("small");
        format.bias = QFormat::new(random.width(1, 20), fraction).ok();
    }
    if random.once_in(4) {
        let (width, fraction) = match activation {
            Activation::Tanh | Activation::Sigmoid => {
                let widest = if random.once_in(20) { 17 } else { 12 };
                let fraction = random.width(3, widest);
                (fraction + 1 + random.width(0, 2), fraction)
            }
            _ => (
                random.width(if last { 2 } else { 3 }, 22),
                random.width(0, 16),
            ),
        };
        format.activations = QFormat::new(width, fraction.cast_signed()).ok();
    }
    let number = |random: &mut Random, format: Option<QFormat>, scale: f64| match format {
        Some(format) => value(random.integer(format.min_code(), format.max_code()), format),
        None => random.unit() * scale,
    };
    let mut rows = Vec::new();
    for _ in 0..outputs {
        // Rows of very different magnitude, so that shifts per neuron pay.
        let scale = random.power(-9, 2);
        rows.extend((0..inputs).map(|_| number(random, format.weights, scale)));
    }
    FloatLayer {
        activation,
        weights: DMatrix::from_row_slice(outputs, inputs, &rows),
        bias: (0..outputs)
            .map(|_| number(random, format.bias, 2.0))
            .collect(),
        format,
    }
}

/// A small network: everything that a weights file may say, in any mixture.
pub fn net(random: &mut Random) -> FloatNet {
    let count = random.count(1, 7);
    let scale = random.power(-3, 9);
    let names = |prefix: &str, count: usize| (0..count).map(|i| format!("{prefix}{i}")).collect();
    let (mut min, mut max) = (Vec::new(), Vec::new());
    for _ in 0..count {
        let (a, b) = (random.unit() * scale, random.unit() * scale);
        min.push(a.min(b));
        max.push(a.max(b) + 0.1 * scale);
    }
    let mapped = random.once_in(2);
    let inputs = Inputs {
        names: names("in", count),
        unit: String::new(),
        offset: (0..count)
            .map(|i| {
                if mapped {
                    f64::midpoint(min[i], max[i])
                } else {
                    0.0
                }
            })
            .collect(),
        scale: (0..count)
            .map(|_| {
                if mapped {
                    1.5 * random.power(-4, 1)
                } else {
                    1.0
                }
            })
            .collect(),
        resolution: random
            .once_in(3)
            .then(|| scale * random.power(-14, -2) * 1.2),
        min,
        max,
    };
    let mut width = count;
    let layers = |random: &mut Random, least: usize, most: usize, width: &mut usize| {
        let count = random.count(least, most);
        (0..count)
            .map(|i| {
                let layer = layer(random, *width, least == 1 && i + 1 == count);
                *width = layer.outputs();
                layer
            })
            .collect::<Vec<_>>()
    };
    let shared = layers(random, 0, 2, &mut width);
    let networks = (0..random.count(1, 3))
        .map(|n| {
            let mut width = width;
            let layers = layers(random, 1, 3, &mut width);
            let mapped = random.once_in(2);
            Network {
                name: format!("n{n}"),
                layers,
                outputs: Outputs {
                    names: names("out", width),
                    unit: String::new(),
                    scale: (0..width)
                        .map(|_| {
                            if mapped {
                                random.unit() * 3.0 + 4.0
                            } else {
                                1.0
                            }
                        })
                        .collect(),
                    offset: (0..width)
                        .map(|_| if mapped { random.unit() } else { 0.0 })
                        .collect(),
                },
            }
        })
        .collect();
    FloatNet {
        name: "random".to_owned(),
        inputs,
        shared,
        networks,
        calibration: None,
    }
}

/// Widths, segments: some or none.
pub fn options(random: &mut Random) -> Options {
    let mut options = Options::default();
    if random.once_in(2) {
        let bits = random.width(3, 18);
        options.weight_bits = vec![WidthSetting { layer: None, bits }];
    }
    if random.once_in(2) {
        let bits = random.width(5, 14);
        options.activation_bits = vec![WidthSetting { layer: None, bits }];
    }
    if random.once_in(3) {
        options.output_bits = Some(random.width(4, 32));
    }
    if random.once_in(4) {
        options.segments = Some(1 << random.width(2, 6));
    }
    options
}

/// Input words: in the box, at its corners, beyond it.
pub fn frame(random: &mut Random, low: &[i64], high: &[i64], format: QFormat) -> Vec<i64> {
    let kind = random.count(0, 3);
    low.iter()
        .zip(high)
        .map(|(low, high)| match kind {
            0 => [*low, *high][random.count(0, 1)],
            1 => random.integer(format.min_code(), format.max_code()),
            2 => [format.min_code(), format.max_code()][random.count(0, 1)],
            _ => random.integer(*low, *high),
        })
        .collect()
}
