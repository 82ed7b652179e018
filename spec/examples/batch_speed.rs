//! Frames a second of the untimed model on one core, for the landing networks or a weights file.
//!
//! `cargo run --release --example batch_speed -p hwgen-spec [-- weights.json]`

use std::error::Error;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use hwgen_spec::design::Design;
use hwgen_spec::eval::Batch;
use hwgen_spec::options::Options;
use hwgen_spec::weights;

const FRAMES: u64 = 20_000;

fn main() -> Result<(), Box<dyn Error>> {
    let landing =
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../designs/landing/weights.json");
    let path = std::env::args_os()
        .nth(1)
        .map_or_else(landing, PathBuf::from);
    let design = Design::new(&weights::read(&std::fs::read(&path)?)?, &Options::default())?;
    let input = design.input();

    // Any spread over the box will do; a multiplicative generator needs no crate.
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut codes = Vec::new();
    for _ in 0..FRAMES {
        for (low, high) in input.low.iter().zip(&input.high) {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let span = (high - low + 1).unsigned_abs();
            codes.push(low + ((state >> 33) % span).cast_signed());
        }
    }

    let batch = Batch::new(design.net());
    let (mut best, mut total) = (Duration::MAX, Duration::ZERO);
    let mut runs = 0;
    while total < Duration::from_secs(3) {
        let start = Instant::now();
        let answers = batch.evaluate(std::hint::black_box(&codes));
        let duration = start.elapsed();
        std::hint::black_box(answers);
        best = best.min(duration);
        total += duration;
        runs += 1;
    }
    let mean = total / runs;

    let start = Instant::now();
    let some = 2000;
    for frame in codes.chunks_exact(input.low.len()).take(some) {
        std::hint::black_box(design.net().evaluate(std::hint::black_box(frame)));
    }
    let single = start.elapsed() / u32::try_from(some)?;

    let rate =
        |time: Duration| f64::from(u32::try_from(FRAMES).unwrap_or(u32::MAX)) / time.as_secs_f64();
    println!(
        "{}: {:.0} frames a second in batches (mean of {runs} runs, best {:.0}), {:.0} one by one; one core",
        design.name(),
        rate(mean),
        rate(best),
        1.0 / single.as_secs_f64()
    );
    Ok(())
}
