//! Clocks a second of the cycle model and of Verilator on the same pins of the landing design.
//!
//! `cargo bench --bench model`; the numbers are in one run, on the same work, one after the other.
//!
//! Both have the pins in memory before the clock starts, and both are looked at: Verilator leaves
//! out whatever no port or display depends on, which in the emitted bench, built without a dump,
//! is the whole core. Hence a bench of its own here, with a digest of the beats at `m_axis`, which
//! has to be the model's as well. The digest is in Verilator's time, but not in the model's, where
//! it is taken in a run of its own; it costs a few instructions a clock.

use std::path::Path;
use std::time::{Duration, Instant};

use hwgen_sim::model::{Model, Pins};
use hwgen_sim::session;
use hwgen_sim::simulator::{BuildPlan, Purpose, Simulator, Text};
use hwgen_sim::stimulus::{Effort, segments};
use hwgen_sim::tool::Toolbox;
use hwgen_spec::design::Design;
use hwgen_spec::format::to_bits;
use hwgen_spec::options::Options;
use hwgen_spec::weights;

const FRAMES: usize = 12_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let net = weights::read(include_bytes!("../designs/landing-wide/weights.json"))?;
    let design = Design::new(&net, &Options::default())?;
    // Long flows come in pieces.
    let mut pieces = segments(&design, &[], FRAMES, 1, Effort::Usual)
        .into_iter()
        .filter(|s| s.name.starts_with("random x continuous"));
    let mut segment = pieces.next().ok_or("no such segment")?;
    segment.frames.extend(pieces.flat_map(|piece| piece.frames));
    let pins = session::run(&design, &segment).pins;

    let clocks = f64::from(u32::try_from(pins.len())?);
    if std::env::args().any(|a| a == "--model-only") {
        let runs = (0..5).map(|_| run_model(&design, &pins));
        let seconds = runs.fold(f64::INFINITY, f64::min);
        println!("landing, {} clocks", pins.len());
        println!("model      {:>10.0} clocks/s", clocks / seconds);
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
    let generated = |path: &str| {
        let file = bundle.files().iter().find(|f| f.path == path);
        Text {
            name: path.rsplit('/').next().unwrap_or(path).into(),
            text: file.map(|f| f.text.clone()).unwrap_or_default(),
        }
    };
    let bench = Text {
        name: "bench.v".into(),
        text: speed_bench(&design, pins.len()),
    };
    let work = directory.path().join("work");
    let sources = bundle.files().iter().filter(|f| f.path.starts_with("rtl/"));
    let built = Simulator::Verilator.build(
        &toolbox,
        &BuildPlan {
            design: "landing".into(),
            sources: sources.map(|f| out.join(&f.path)).collect(),
            bench,
            bench_icarus: generated("tb/landing_tb_icarus.v"),
            main_cpp: generated("tb/sim_main.cpp"),
            models: Vec::new(),
            work_dir: work.clone(),
            cache_dir: root.join("build/.cache/verilator"),
            purpose: Purpose::Speed,
            timeout: Duration::from_secs(1200),
        },
    )?;
    // In turns, so that a slow moment of the machine meets both.
    let expected = digest(&design, &pins);
    let (mut ours, mut theirs) = (f64::INFINITY, f64::INFINITY);
    for _ in 0..7 {
        ours = ours.min(run_model(&design, &pins));
        let timeout = Duration::from_secs(600);
        let speed = built.measure_speed(&stimulus, pins.len(), &work, timeout)?;
        theirs = theirs.min(speed.seconds);
        if speed.digest != expected {
            return Err(
                format!("digest {expected:08x} expected, {:08x} found", speed.digest).into(),
            );
        }
    }
    println!("landing, {} clocks, pins in memory, least of 7", pins.len());
    println!("model      {:>10.0} clocks/s", clocks / ours);
    println!(
        "verilator  {:>10.0} clocks/s ({})",
        clocks / theirs,
        built.version()
    );
    println!("ratio      {:>10.2}", theirs / ours);
    Ok(())
}

/// Seconds that the model takes for these pins.
fn run_model(design: &Design, pins: &[Pins]) -> f64 {
    let mut model = Model::new(design);
    let start = Instant::now();
    for pins in pins {
        model.step(pins);
    }
    let seconds = start.elapsed().as_secs_f64();
    std::hint::black_box(&model);
    seconds
}

/// What `speed_bench` makes of the beats at `m_axis`.
fn digest(design: &Design, pins: &[Pins]) -> u32 {
    let mut model = Model::new(design);
    let mut digest = 0u32;
    for pins in pins {
        if let Some(beat) = model.output() {
            let low = to_bits(beat.data[0], design.sink().lane_bits) & u64::from(u32::MAX);
            let control = beat.user << 1 | i64::from(beat.last);
            let control = u32::try_from(control).expect("three bits") << 29;
            digest = digest.rotate_left(1) ^ control ^ u32::try_from(low).expect("masked");
        }
        model.step(pins);
    }
    digest
}

/// The emitted bench for speed: the pins are read before the first clock, the output is looked at.
fn speed_bench(design: &Design, clocks: usize) -> String {
    let (source, sink) = (design.source(), design.sink());
    let (top, last) = (source.data_bits() + 3, clocks - 1);
    format!(
        "module landing_tb (input wire clk_i);
  reg [{top}:0] lines [0:{last}];
  reg [{top}:0] pins_q = 0;
  reg [8*1024-1:0] path = 0;
  reg [31:0] digest_q = 0;
  integer clocks_q = 0;
  wire [{}:0] m_axis_tdata;
  wire m_axis_tvalid, m_axis_tlast;
  wire [1:0] m_axis_tuser;
  initial begin
    if ($value$plusargs(\"stimulus=%s\", path) == 0) $finish;
    $readmemh(path, lines);
    pins_q = lines[0];
  end
  always @(posedge clk_i)
    if (m_axis_tvalid)
      digest_q <= {{digest_q[30:0], digest_q[31]}} ^ {{m_axis_tuser, m_axis_tlast, 29'b0}}
        ^ m_axis_tdata[{}:0];
  always @(negedge clk_i) if ($time != 0) begin
    clocks_q <= clocks_q + 1;
    if (clocks_q == {last}) begin
      $display(\"hwgen: replayed %0d clocks\", clocks_q + 1);
      $display(\"hwgen: digest %h\", digest_q);
      $finish;
    end else pins_q <= lines[clocks_q + 1];
  end
  landing u_dut (
      .aclk(clk_i), .aresetn(pins_q[{top}]), .s_axis_tvalid(pins_q[{top}-1]),
      .s_axis_tlast(pins_q[{top}-2]), .m_axis_tready(pins_q[{top}-3]),
      .s_axis_tdata(pins_q[{top}-4:0]), .s_axis_tready(), .m_axis_tlast(m_axis_tlast), .m_axis_tuser(m_axis_tuser),
      .m_axis_tdata(m_axis_tdata), .m_axis_tvalid(m_axis_tvalid)
  );
endmodule
",
        sink.data_bits() - 1,
        sink.lane_bits - 1,
    )
}
