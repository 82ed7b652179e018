//! The batch model gives the integers and flags of the model for one frame.

use hwgen_spec::design::Design;
use hwgen_spec::eval::{Answer, Batch};
use hwgen_spec::format::Rounding;
use hwgen_spec::options::Options;
use hwgen_spec::quantize::{QuantNet, quantize};
use hwgen_spec::weights;
use proptest::prelude::*;

mod support;

use support::Random;

fn assert_equal(net: &QuantNet, frames: &[Vec<i64>]) {
    let found = net.evaluate_batch(frames);
    assert_eq!(found.len(), frames.len());
    for (frame, found) in frames.iter().zip(found) {
        assert_eq!(net.evaluate(frame), found, "{frame:?}");
    }
}

fn frames(random: &mut Random, net: &QuantNet, count: usize) -> Vec<Vec<i64>> {
    let input = &net.input;
    (0..count)
        .map(|_| support::frame(random, &input.low, &input.high, input.format))
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(250))]

    #[test]
    fn random_networks(seed: u64, count in 0usize..200) {
        let mut random = Random(seed);
        let float = support::net(&mut random);
        let options = support::options(&mut random);
        if let Ok(net) = quantize(&float, &options) {
            assert_equal(&net, &frames(&mut random, &net, count));
        }
    }
}

#[test]
fn the_landing_networks_on_their_vectors_and_on_random_words() {
    let float = weights::read(&support::landing("weights.json")).expect("a weights file");
    let design = Design::new(&float, &Options::default()).expect("a design");
    let text = String::from_utf8(support::landing("vectors.csv")).expect("text");
    let format = design.input().format;
    let mut all: Vec<Vec<i64>> = text
        .lines()
        .skip(1)
        .map(|line| {
            let row = line.split(',').skip(1).take(10);
            row.map(|v| {
                format
                    .quantize(v.parse().expect("a number"), Rounding::HalfUp)
                    .code
            })
            .collect()
        })
        .collect();
    assert_eq!(all.len(), 500);
    all.extend(frames(&mut Random(1), design.net(), 1500));
    assert_equal(design.net(), &all);
    let clipped = |a: &Answer| a.input_clipped;
    let answers = design.net().evaluate_batch(&all);
    assert!(answers.iter().any(clipped) && !answers.iter().all(clipped));
}

/// A bias far beyond its sum leaves no room for half a unit: one frame after the other, then.
#[test]
fn sums_at_the_limit() {
    for bias in ["1e3", "-1e3", "4e3", "-4e3", "8e3"] {
        let text = format!(
            r#"{{"format": "hwgen-weights/1", "name": "wide",
            "inputs": {{"min": [-1], "max": [1]}},
            "networks": [{{"name": "net", "layers": [{{"activation": "linear",
              "weights": [[0.75]], "bias": [{bias}],
              "format": {{"weights": "Q0.15", "bias": "Q14.38", "activations": "Q14.9"}}}}]}}]}}"#
        );
        let float = weights::read(text.as_bytes()).expect("a weights file");
        let Ok(net) = quantize(&float, &Options::default()) else {
            continue;
        };
        let mut random = Random(2);
        assert_equal(&net, &frames(&mut random, &net, 300));
    }
}

#[test]
#[should_panic(expected = "frames of 10 words expected")]
fn a_broken_frame() {
    let float = weights::read(&support::landing("weights.json")).expect("a weights file");
    let net = quantize(&float, &Options::default()).expect("a network");
    let _ = Batch::new(&net).evaluate(&[0; 15]);
}
