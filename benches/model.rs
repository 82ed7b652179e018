//! Clocks a second of the cycle model and of Verilator on the same pins of the landing design.
//!
//! `cargo bench --bench model`; the numbers are in one run, on the same work, one after the other.

use std::path::Path;
use std::time::{Duration, Instant};

use hwgen_sim::model::Model;
use hwgen_sim::session;
use hwgen_sim::simulator::{BuildPlan, Purpose, Simulator};
use hwgen_sim::stimulus::segments;
use hwgen_sim::tool::Toolbox;
use hwgen_spec::design::Design;
use hwgen_spec::options::Options;
use hwgen_spec::weights;

const FRAMES: usize = 12_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let net = weights::read(include_bytes!("../designs/landing/weights.json"))?;
    let design = Design::new(&net, &Options::default())?;
    let segment = segments(&design, &[], FRAMES, 1)
        .into_iter()
        .find(|s| s.name == "random x continuous")
        .ok_or("no such segment")?;
    let pins = session::run(&design, &segment).pins;

    let mut seconds = f64::INFINITY;
    for _ in 0..5 {
        let mut model = Model::new(&design);
        let start = Instant::now();
        for pins in &pins {
            model.step(pins);
        }
        std::hint::black_box(&model);
        seconds = seconds.min(start.elapsed().as_secs_f64());
    }
    let clocks = f64::from(u32::try_from(pins.len())?);
    let model = clocks / seconds;
    println!("landing, {} clocks", pins.len());
    println!("model      {:>10.0} clocks/s", model);
    if std::env::args().any(|a| a == "--model-only") {
        return Ok(());
    }

    let directory = tempfile::tempdir()?;
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let toolbox = Toolbox::new(root);
    let bundle = hwgen_gen::generate(&design, &net);
    let out = directory.path().join("landing");
    bundle.write(&out)?;
    let stimulus = directory.path().join("stimulus");
    std::fs::write(&stimulus, session::stimulus_text(&design, &pins))?;
    let sources = bundle.files().iter().filter(|f| f.path.starts_with("rtl/"));
    let built = Simulator::Verilator.build(
        &toolbox,
        &BuildPlan {
            design: "landing".into(),
            sources: sources.map(|f| out.join(&f.path)).collect(),
            bench: out.join("tb/landing_tb.v"),
            bench_icarus: out.join("tb/landing_tb_icarus.v"),
            main_cpp: out.join("tb/sim_main.cpp"),
            work_dir: directory.path().join("work"),
            cache_dir: root.join("build/.cache/verilator"),
            purpose: Purpose::Speed,
            timeout: Duration::from_secs(1200),
        },
    )?;
    let mut best = 0f64;
    for _ in 0..5 {
        let speed = built.measure_speed(
            &stimulus,
            pins.len(),
            &directory.path().join("work"),
            Duration::from_secs(600),
        )?;
        best = best.max(clocks / speed.seconds);
    }
    println!("verilator  {best:>10.0} clocks/s ({})", built.version());
    println!("ratio      {:>10.2}", model / best);
    Ok(())
}
