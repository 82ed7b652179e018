//! `hwgen demo`

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::Duration;

use hwgen_gen::Source;
use hwgen_pose::evaluate::{ErrorSum, PoseError};
use hwgen_pose::frames::Pose;
use hwgen_sim::error::ToolError;
use hwgen_sim::simulator::Simulator;
use hwgen_sim::tool::Toolbox;
use hwgen_sim::verify::{Cycles, Report};
use hwgen_spec::design::Design;
use hwgen_spec::deviation;
use hwgen_spec::options::Options;
use hwgen_spec::weights;
use serde::Serialize;
use serde_json::json;

use super::verify::{Check, installed, no_simulator, report};
use super::{Outcome, emit};
use crate::deviation::{Judged, TOLERANCE_PCT};
use crate::failure::Failure;
use crate::inference;
use crate::layout::{columns, counted, row, shell_word};
use crate::output::Output;
use crate::table::Table;

const EXAMPLES: &str = "\
The design estimates the pose of a camera from the pixels of five landmarks: two networks of 256
tanh neurons behind a shared layer, trained beforehand. Its weights and vectors are in the program.

Examples:
  hwgen demo
  hwgen demo --out build/mine --json

Exit codes: 0 if Icarus Verilog and Verilator both confirm the design, 1 if one differs,
3 if one is missing: then all is done that can be done without it.";

const WEIGHTS: &str = include_str!("../../designs/landing/weights.json");
const VECTORS: &str = include_str!("../../designs/landing/vectors.csv");
/// What errors in them are called.
const VECTORS_FILE: &str = "designs/landing/vectors.csv";
/// The true pose in the vectors, in the order of the outputs.
const TRUTH: [&str; 6] = ["x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad"];
const NOISE: &str = "noise_px";
const RANDOM_FRAMES: usize = 100;
const SEED: u64 = 1;
const TIMEOUT: Duration = Duration::from_secs(900);
/// An example: what a clock of 100 MHz makes of cycles.
const CYCLES_PER_US: f64 = 100.0;

/// What `demo` takes.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Directory of the bundle; one that is there is replaced
    #[arg(long, value_name = "DIR", default_value = "build/demo")]
    pub out: PathBuf,
}

/// Errors at one level of noise.
#[derive(Clone, Debug, Serialize)]
struct NoiseRow {
    noise_px: f64,
    frames: usize,
    fixed: PoseError,
    float: PoseError,
}

/// Emits, measures and checks the landing design.
///
/// # Errors
/// If the bundle can't be written, or nothing can be said of it.
pub fn run(args: &Args, output: &Output) -> Result<Outcome, Failure> {
    let net = weights::read(WEIGHTS.as_bytes())
        .map_err(|e| Failure::weights(Path::new("designs/landing/weights.json"), &e))?;
    let bundle = hwgen_gen::generate(&Design::new(&net, &Options::default())?, &net);
    bundle.replace(&args.out)?;
    let out = args.out.display().to_string();
    output.detail(&format!("wrote {out}"));
    // Read back, as `verify` does: the digests are checked.
    let source = Source::read(&args.out)?;
    let design = &source.design;

    let table = Table::parse(VECTORS_FILE, VECTORS.as_bytes())?;
    let vectors = table.numbers(design.input_names())?;
    let accuracy = accuracy(&source, &table, &vectors)?;

    let mut json = emit::facts(&bundle, &out)?;
    json.insert("accuracy".into(), json!(accuracy));
    let mut text = format!("Built in {out}\n\n{}", emit::describe(design, &bundle));
    for note in emit::notes(design) {
        let _ = writeln!(text, "note: {note}");
    }
    let _ = write!(
        text,
        "\nErrors against the true pose\n\n{}\n",
        errors(&accuracy)
    );

    let toolbox = Toolbox::new(Path::new("."));
    let (present, missing) = installed(&toolbox);
    let outcome = Outcome {
        text,
        json,
        ..Outcome::default()
    };
    if present.is_empty() {
        return without_simulator(outcome, &source, &vectors, missing);
    }
    let check = Check {
        bundle: &args.out,
        source: &source,
        vectors,
        random: RANDOM_FRAMES,
        seed: SEED,
        thorough: false,
        simulators: present,
        toolbox: &toolbox,
        work: None,
        timeout: TIMEOUT,
    };
    let (report, failure) = check.run(output)?;
    Ok(checked(
        outcome,
        &report,
        failure.or_else(|| lacking(missing)),
        &out,
    ))
}

/// Models against each other: all that can be done without a simulator.
fn without_simulator(
    mut outcome: Outcome,
    source: &Source,
    vectors: &[Vec<f64>],
    missing: Vec<(Simulator, ToolError)>,
) -> Result<Outcome, Failure> {
    let design = &source.design;
    let frames = &vectors[..vectors.len().min(RANDOM_FRAMES)];
    let one = inference::cycle_accurate(design, &frames[..1], None)?;
    let all = inference::cycle_accurate(design, frames, None)?;
    let cycles = |stated, measured| Cycles {
        stated,
        measured: Some(measured),
    };
    let latency = cycles(design.latency_cycles(), one.cycles);
    let interval = (all.cycles - one.cycles) / (frames.len() - 1).max(1);
    let interval = cycles(design.interval_cycles(), interval);
    let deviation = deviation::measure(design, &source.net, vectors);
    let error = Judged::new(&deviation, TOLERANCE_PCT);
    outcome.json.insert("error".into(), json!(error.json()));
    outcome.remarks.extend(error.warnings());
    let _ = write!(
        outcome.text,
        "Without a simulator the RTL can't be checked. The cycle-accurate model and the untimed \
         one\nagree in {}.\n\n{}\n{}\n{}",
        counted(frames.len(), "frame"),
        report::cycle_table(&latency, &interval),
        error.text(),
        time(&latency, &interval),
    );
    outcome.json.insert("latency_cycles".into(), json!(latency));
    outcome
        .json
        .insert("interval_cycles".into(), json!(interval));
    outcome.failure = Some(no_simulator(missing));
    Ok(outcome)
}

/// The failure that the demo wants two simulators.
fn lacking(missing: Vec<(Simulator, ToolError)>) -> Option<Failure> {
    let (simulator, error) = missing.into_iter().next()?;
    let mut failure = Failure::from(error);
    failure.message = format!(
        "{}: two simulators expected, one of them does not work: {}",
        simulator.name(),
        failure.message
    );
    Some(failure)
}

fn checked(mut outcome: Outcome, report: &Report, failure: Option<Failure>, out: &str) -> Outcome {
    let _ = write!(
        outcome.text,
        "Compared, clock by clock: {}",
        report::text("landing", report)
    );
    let time = time(&report.latency_cycles, &report.interval_cycles);
    let _ = write!(outcome.text, "\n{time}");
    outcome.json.extend(report::object(report));
    outcome.remarks.extend(report::error(report).warnings());
    outcome
        .json
        .insert("verified".into(), json!(failure.is_none()));
    if failure.is_none() {
        let word = shell_word(out);
        outcome.text.push_str(&report::verified(report));
        let _ = write!(
            outcome.text,
            "\nNext:\n  hwgen verify {word} --random 1000 --seed 2\n  \
             hwgen run {word} --inputs designs/landing/vectors.csv --out build/demo.csv\n  \
             hwgen emit --weights yours.json          (`hwgen schema` describes the file)\n"
        );
    }
    outcome.failure = failure;
    outcome
}

/// Cycles in words of time.
fn time(latency: &Cycles, interval: &Cycles) -> String {
    #[expect(clippy::cast_precision_loss, reason = "counts far below 2^53")]
    let us = |cycles: &Cycles| cycles.stated as f64 / CYCLES_PER_US;
    format!(
        "With a clock of 100 MHz, for example: latency {:.2} us, an answer every {:.2} us.\n",
        us(latency),
        us(interval),
    )
}

fn accuracy(
    source: &Source,
    table: &Table,
    vectors: &[Vec<f64>],
) -> Result<Vec<NoiseRow>, Failure> {
    let pose = |values: &[f64]| match *values {
        [x, y, z, rx, ry, rz] => Ok(Pose::new([x, y, z].into(), [rx, ry, rz].into())),
        _ => {
            let message = format!("6 numbers of a pose expected, {} found", values.len());
            Err(Failure::input("pose", message).file(VECTORS_FILE))
        }
    };
    let poses = |rows: Vec<Vec<f64>>| -> Result<Vec<Pose>, Failure> {
        rows.iter().map(|row| pose(row)).collect()
    };
    let names = TRUTH.map(str::to_owned);
    let truth = poses(table.numbers(&names)?)?;
    let noise: Vec<f64> = table.numbers(&[NOISE.to_owned()])?.concat();
    let answers = inference::untimed(&source.design, vectors).answers;
    let real = |answer: &hwgen_spec::eval::Answer| source.design.net().real_outputs(&answer.codes);
    let fixed = poses(answers.iter().map(real).collect())?;
    let float = poses(vectors.iter().map(|row| source.net.forward(row)).collect())?;

    let mut levels = noise.clone();
    levels.sort_by(f64::total_cmp);
    levels.dedup();
    Ok(levels
        .into_iter()
        .map(|noise_px| {
            let here: Vec<usize> = (0..noise.len()).filter(|i| noise[*i] == noise_px).collect();
            let error = |estimates: &[Pose]| {
                let mut sum = ErrorSum::default();
                sum.extend(
                    here.iter()
                        .map(|i| PoseError::between(&estimates[*i], &truth[*i])),
                );
                sum.mean().unwrap_or_default()
            };
            NoiseRow {
                noise_px,
                frames: here.len(),
                fixed: error(&fixed),
                float: error(&float),
            }
        })
        .collect())
}

fn errors(accuracy: &[NoiseRow]) -> String {
    let mut rows = vec![row![
        "noise, px",
        "frames",
        "position, m",
        "%",
        "% in float",
        "orientation, deg",
        "%",
        "% in float"
    ]];
    rows.extend(accuracy.iter().map(|r| {
        row![
            r.noise_px,
            r.frames,
            format!("{:.3}", r.fixed.position_m),
            format!("{:.3}", r.fixed.position_pct),
            format!("{:.3}", r.float.position_pct),
            format!("{:.3}", r.fixed.orientation_deg),
            format!("{:.2}", r.fixed.orientation_pct),
            format!("{:.2}", r.float.orientation_pct)
        ]
    }));
    columns("rrrrrrrr", &rows)
}
