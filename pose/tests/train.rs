//! Training: slopes, optimisers, a short training, and resuming.

mod support;

use hwgen_pose::sample::{NoiseShape, Sampler};
use hwgen_pose::train::data::Conditioning;
use hwgen_pose::train::learner::{Learner, Stop};
use hwgen_pose::train::recipe::{Optimizer, Recipe};
use hwgen_pose::train::{Batch, Levenberg, Perceptron, Rprop, Shape, Training};
use hwgen_spec::network::FloatNet;
use nalgebra::{DMatrix, DVector};
use support::landing;

const INPUTS: usize = 3;
const OUTPUTS: usize = 2;

fn shape(hidden: &[usize]) -> Shape {
    Shape {
        inputs: INPUTS,
        hidden: hidden.to_vec(),
        outputs: OUTPUTS,
    }
}

/// One hidden layer, and several.
fn shapes() -> [Shape; 3] {
    [&[5][..], &[5, 4], &[4, 3, 5]].map(shape)
}

/// Inputs that fill a cube evenly.
fn inputs(samples: usize) -> DMatrix<f64> {
    DMatrix::from_fn(INPUTS, samples, |i, n| {
        let turn = (n as f64 + 0.5) * [0.618_034, 0.414_214, 0.732_051][i];
        4.0 * turn.fract() - 2.0
    })
}

fn answers(shape: &Shape, parameters: &DVector<f64>, inputs: &DMatrix<f64>) -> DMatrix<f64> {
    let net = Perceptron::new(shape, parameters);
    let words = words(&net, inputs).pop().expect("a hidden layer");
    (net.output.transpose() * words).map(f64::from)
}

fn words(net: &Perceptron, inputs: &DMatrix<f64>) -> Vec<DMatrix<f32>> {
    let with_one = inputs.map(|x| x as f32).insert_row(INPUTS, 1.0);
    net.hidden_words(&with_one.columns(0, inputs.ncols()))
}

/// A network whose outputs depend on every weight.
fn busy(shape: &Shape, seed: u64) -> DVector<f64> {
    let mut parameters = shape.random(seed);
    for (i, p) in parameters.iter_mut().enumerate() {
        *p += ((i * 7 % 11) as f64 - 5.0) / 8.0;
    }
    parameters
}

fn weights(samples: usize) -> Vec<f64> {
    (0..samples).map(|n| 0.5 + (n % 3) as f64).collect()
}

/// A batch of several blocks with uneven weights.
fn batch(shape: &Shape) -> Batch {
    let inputs = inputs(700);
    let targets = answers(shape, &busy(shape, 2), &inputs);
    Batch::new(&inputs, &targets, &weights(700))
}

#[test]
fn slopes_are_those_of_finite_differences() {
    for shape in &shapes() {
        let batch = batch(shape);
        let at = busy(shape, 1);
        let slope = batch.slope(&Perceptron::new(shape, &at));
        let whole = batch.loss(&Perceptron::new(shape, &at));
        assert!((slope.loss - whole).abs() < 1e-6 * slope.loss);
        let step: f64 = 1e-2;
        for i in 0..at.len() {
            let loss = |by: f64| {
                let mut moved = at.clone();
                moved[i] += by;
                batch.loss(&Perceptron::new(shape, &moved))
            };
            // Fourth order, so that the step can be large against single precision.
            let difference = (8.0 * (loss(step) - loss(-step))
                - (loss(2.0 * step) - loss(-2.0 * step)))
                / (12.0 * step);
            let error = (difference - slope.gradient[i]).abs();
            assert!(
                error < 2e-4 * (1.0 + difference.abs()),
                "{shape:?} {i}: {difference} {}",
                slope.gradient[i]
            );
        }
    }
}

#[test]
fn bends_are_those_of_finite_differences() {
    for shape in &shapes() {
        let inputs = inputs(700);
        let (at, direction) = (busy(shape, 1), 0.2 * busy(shape, 2));
        // The gradient of a batch whose errors are the second differences of the outputs.
        let step = 0.05;
        let here = answers(shape, &at, &inputs);
        let second = (answers(shape, &(&at + &direction * step), &inputs)
            + answers(shape, &(&at - &direction * step), &inputs)
            - &here * 2.0)
            / (step * step);
        let expected = Batch::new(&inputs, &(here - second), &weights(700))
            .slope(&Perceptron::new(shape, &at))
            .gradient;
        let found = Batch::new(&inputs, &DMatrix::zeros(OUTPUTS, 700), &weights(700)).bend(
            &Perceptron::new(shape, &at),
            &Perceptron::new(shape, &direction),
        );
        assert!(expected.norm() > 0.01);
        let miss = (&found - &expected).norm() / expected.norm();
        assert!(miss < 1e-2, "{shape:?} {miss}");
    }
}

#[test]
fn neurons_are_zero_at_the_first_samples() {
    for shape in &shapes() {
        let inputs = inputs(4);
        let batch = Batch::new(&inputs, &DMatrix::zeros(OUTPUTS, 4), &[1.0; 4]);
        let mut parameters = shape.random(1);
        batch.center(shape, &mut parameters);
        let words = words(&Perceptron::new(shape, &parameters), &inputs);
        let neurons = words.iter().flat_map(|layer| {
            let neurons = layer.nrows() - 1;
            (0..neurons).map(move |j| layer.row(j))
        });
        for (neuron, words) in neurons.enumerate() {
            for (sample, word) in words.iter().enumerate() {
                let zero = word.abs() < 1e-6;
                assert_eq!(zero, sample == neuron % 4, "{shape:?} {neuron} {sample}");
            }
        }
    }
}

#[test]
fn levenberg_finds_a_network_that_gave_the_answers() {
    for shape in &shapes() {
        let batch = batch(shape);
        let mut at = busy(shape, 2);
        for (i, p) in at.iter_mut().enumerate() {
            *p += 0.1 * ((i % 5) as f64 - 2.0);
        }
        let mut levenberg = Levenberg::default();
        let first = batch.loss(&Perceptron::new(shape, &at));
        let mut steps = 0;
        while steps < 40 && levenberg.step(shape, &mut at, &batch, 0.0).is_some() {
            steps += 1;
        }
        let last = batch.loss(&Perceptron::new(shape, &at));
        assert!(
            first > 1e-3 && last < 1e-10,
            "{shape:?}: {first} to {last} in {steps} steps"
        );
    }
}

#[test]
fn rprop_goes_down() {
    for shape in &shapes() {
        let batch = batch(shape);
        let mut at = busy(shape, 1);
        let mut rprop = Rprop::new(at.len());
        let first = batch.loss(&Perceptron::new(shape, &at));
        for _ in 0..300 {
            let slope = batch.slope(&Perceptron::new(shape, &at));
            rprop.step(&mut at, &slope.gradient);
        }
        let last = batch.loss(&Perceptron::new(shape, &at));
        assert!(last < 1e-2 * first, "{shape:?}: {first} to {last}");
    }
}

fn short(optimizer: Optimizer) -> Recipe {
    Recipe {
        hidden: vec![16],
        samples: 3000,
        posterior_draws: 16,
        epochs: 25,
        optimizer,
        ..Recipe::best()
    }
}

fn finish(mut training: Training<'_>) -> FloatNet {
    while training.epoch().unwrap() {}
    training.net()
}

/// Mean relative errors of position and orientation, %.
fn relative_errors(net: &FloatNet, noise_px: f64) -> [f64; 2] {
    let scene = landing();
    let sampler = Sampler::new(&scene, NoiseShape::Gaussian, 1234).unwrap();
    let count = 500;
    let mut sums = [0.0; 2];
    for i in 0..count {
        let sample = sampler.draw(i);
        let y = net.forward(&sample.noisy_px(noise_px));
        let p = nalgebra::Vector3::from_column_slice(&y[..3]);
        let r = nalgebra::Vector3::from_column_slice(&y[3..]);
        let truth = (sample.pose.position_m, sample.pose.rodrigues_rad());
        sums[0] += (p - truth.0).norm() / truth.0.norm();
        sums[1] += (r - truth.1).norm() / truth.1.norm();
    }
    sums.map(|sum| 100.0 * sum / count as f64)
}

#[test]
fn a_short_training_beats_what_was_published() {
    let scene = landing();
    let sampler = Sampler::new(&scene, NoiseShape::Gaussian, 1).unwrap();
    let training = Training::new(&sampler, short(Optimizer::Levenberg), 1);
    let net = finish(training);
    let [position, orientation] = relative_errors(&net, 1.0);
    assert!(
        position < 2.8 && orientation < 22.0,
        "{position} {orientation}"
    );
    // The weights file says the same network.
    let read = hwgen_spec::weights::read(hwgen_spec::weights::to_json(&net).as_bytes()).unwrap();
    assert_eq!(read, net);
}

#[test]
fn a_resumed_training_equals_an_uninterrupted_one() {
    let scene = landing();
    let sampler = Sampler::new(&scene, NoiseShape::Gaussian, 3).unwrap();
    for optimizer in [Optimizer::Rprop, Optimizer::Levenberg] {
        let recipe = Recipe {
            samples: 500,
            epochs: 6,
            hidden: vec![6, 4],
            ..short(optimizer)
        };
        let whole = finish(Training::new(&sampler, recipe.clone(), 3));
        let mut first = Training::new(&sampler, recipe, 3);
        for _ in 0..4 {
            first.epoch().unwrap();
        }
        let kept = serde_json::to_string(first.checkpoint()).unwrap();
        drop(first);
        let resumed = Training::resume(&sampler, serde_json::from_str(&kept).unwrap()).unwrap();
        assert!(finish(resumed) == whole, "{optimizer:?}");
    }
}

#[test]
fn a_loss_that_is_no_number_is_a_divergence() {
    for optimizer in [Optimizer::Rprop, Optimizer::Levenberg] {
        let shape = shape(&[5]);
        let (batch, broken) = (
            batch(&shape),
            Batch::new(
                &inputs(10),
                &DMatrix::from_element(OUTPUTS, 10, f64::NAN),
                &[1.0; 10],
            ),
        );
        let mut learner = Learner::new(&shape, optimizer, 1, &batch);
        let error = learner
            .epoch(&short(optimizer), &broken, &batch)
            .unwrap_err();
        assert!(error.epoch == 1 && error.loss.is_nan(), "{error}");
    }
}

#[test]
fn axes_that_show_nothing_are_left_out() {
    // The third coordinate follows from the first two but for less than a pixel's step.
    let pixels = DMatrix::from_fn(3, 500, |i, n| {
        let [a, b] = [0.618_034, 0.414_214].map(|turn: f64| 100.0 * (n as f64 * turn).fract());
        [a, b, a - b + 1e-3 * (n % 2) as f64][i]
    });
    for (least_px, features) in [(1e-5, 3), (4.5e-3, 2)] {
        let found = Conditioning::whitening(&pixels, least_px);
        assert_eq!(found.matrix.shape(), (features, 3), "{least_px}");
        let white = found.apply(&pixels);
        let covariance = &white * white.transpose() / 500.0;
        assert!((covariance - DMatrix::identity(features, features)).norm() < 1e-3);
    }
}

#[test]
fn training_stops_when_the_samples_kept_back_say_so() {
    let scene = landing();
    let sampler = Sampler::new(&scene, NoiseShape::Gaussian, 3).unwrap();
    // A few noisy samples: fitting them soon means fitting their noise.
    let recipe = Recipe {
        hidden: vec![64],
        samples: 150,
        noise_px: vec![5.0],
        epochs: 1000,
        patience: 3,
        ..Recipe::paper()
    };
    let mut training = Training::new(&sampler, recipe, 3);
    while training.epoch().unwrap() {}
    for learner in &training.checkpoint().learners {
        assert_eq!(learner.stop(), Some(Stop::Patience));
        let best = learner.best_losses().unwrap().validation;
        assert!(
            learner
                .curve()
                .iter()
                .all(|losses| losses.validation >= best)
        );
        assert_eq!(learner.curve().len(), learner.best_epoch() + 3);
    }
}
