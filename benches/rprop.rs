//! CPU time of an RPROP epoch: one 10-256-3 network, 8000 samples, one thread.
//!
//! `cargo bench --bench rprop` prints milliseconds; `tools/bench-rprop` runs PyTorch and FANN on
//! the same work beside it.

use hwgen_pose::train::{Batch, Perceptron, Rprop, Shape};
use nalgebra::DMatrix;
use rustix::time::{ClockId, clock_gettime};

const SAMPLES: usize = 8000;
const EPOCHS: usize = 20;
const ROUNDS: usize = 7;

fn cpu_ms() -> f64 {
    let now = clock_gettime(ClockId::ProcessCPUTime);
    now.tv_sec as f64 * 1e3 + now.tv_nsec as f64 * 1e-6
}

fn main() {
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    one.expect("a pool of one thread").install(measure);
}

fn measure() {
    let shape = Shape {
        inputs: 10,
        hidden: vec![256],
        outputs: 3,
    };
    // Any smooth function will do: the work does not depend on it.
    let inputs = DMatrix::from_fn(shape.inputs, SAMPLES, |i, n| {
        ((n * (2 * i + 3)) as f64 * 0.618_034).fract() * 2.0 - 1.0
    });
    let targets = DMatrix::from_fn(shape.outputs, SAMPLES, |k, n| {
        (inputs[(k, n)] + inputs[(k + 3, n)]).sin()
    });
    let batch = Batch::new(&inputs, &targets, &vec![1.0; SAMPLES]);
    let mut parameters = shape.random(1);
    let mut rprop = Rprop::new(shape.parameters());
    let first = batch.loss(&Perceptron::new(&shape, &parameters));
    let rounds = (0..ROUNDS).map(|_| {
        let start = cpu_ms();
        for _ in 0..EPOCHS {
            let slope = batch.slope(&Perceptron::new(&shape, &parameters));
            rprop.step(&mut parameters, &slope.gradient);
        }
        (cpu_ms() - start) / EPOCHS as f64
    });
    let mut rounds: Vec<f64> = rounds.collect();
    rounds.sort_by(f64::total_cmp);
    let last = batch.loss(&Perceptron::new(&shape, &parameters));
    assert!(last < 0.5 * first, "nothing was learnt: {first} to {last}");
    println!(
        "hwgen: {:.2} ms of CPU an epoch (least {:.2}, most {:.2} of {ROUNDS} rounds)",
        rounds[ROUNDS / 2],
        rounds[0],
        rounds[ROUNDS - 1],
    );
}
