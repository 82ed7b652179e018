//! The three-way check of a bundle: untimed values, cycle model, simulators.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use hwgen_spec::design::Design;
use hwgen_spec::deviation;
use hwgen_spec::network::FloatNet;

use crate::error::{SimError, ToolError};
use crate::session::{self, Session, stimulus_text};
use crate::simulator::{BuildPlan, Purpose, Simulator, Text};
use crate::stimulus::{Effort, segments};
use crate::tool::Toolbox;
use crate::work::WorkDir;

mod difference;
mod replay;
mod report;
mod stimulus;
mod structure;

pub use report::{
    Cycles, FirstDifference, Report, SimulatorRun, Stimulus, StructureReport, Verdict,
};

pub use stimulus::summary;

use replay::{Case, Found, Outcome, Steps, replay_all};

/// What is to be checked, with what.
pub struct VerifyPlan<'a> {
    /// Directory of the bundle.
    pub bundle: PathBuf,
    /// Verilog files of the core, below the bundle's directory: simulated as they lie there.
    pub sources: Vec<String>,
    /// What is simulated around the core. It follows from the design and is generated, not read.
    pub harness: Harness,
    /// The design that the bundle states.
    pub design: &'a Design,
    /// The float reference.
    pub net: &'a FloatNet,
    /// Rows of raw inputs in the order of the design's inputs, empty for none.
    pub vectors: Vec<Vec<f64>>,
    /// Number of random frames in the box.
    pub random: usize,
    /// Seed of random frames, gaps and back-pressure.
    pub seed: u64,
    /// How much is driven.
    pub effort: Effort,
    /// The simulators, at least one.
    pub simulators: Vec<Simulator>,
    /// Where tools are found.
    pub toolbox: &'a Toolbox,
    /// Where logs, stimuli and, after a difference, dumps are left: a directory that is new, empty,
    /// or of an earlier check; emptied first.
    pub work_dir: PathBuf,
    /// Where simulator builds are kept.
    pub cache_dir: PathBuf,
    /// How long a build or a replay may take.
    pub timeout: Duration,
}

/// What is simulated around a core.
#[derive(Clone, Debug)]
pub struct Harness {
    /// The replaying bench, for all simulators.
    pub bench: Text,
    /// Clock and dump around it, for Icarus.
    pub bench_icarus: Text,
    /// Clock and dump around it, for Verilator.
    pub main_cpp: Text,
    /// Models of the device's blocks, each named as its module.
    pub models: Vec<Text>,
}

/// What the check is doing.
#[derive(Clone, Debug)]
pub struct Progress {
    /// In words: `verilator: building`, `icarus: random x back-pressure`.
    pub activity: String,
    /// Steps done.
    pub done: usize,
    /// Steps in all.
    pub total: usize,
}

/// Checks a bundle.
///
/// The model is driven first and its answers compared with the untimed values; each simulator
/// then replays the same pins, and its registers are compared with the model's at every edge.
///
/// # Errors
/// [`SimError`] if nothing can be said: a tool is missing, failed, or printed no verdict, or the
/// work directory holds files of others or is in use.
pub fn verify(
    plan: &VerifyPlan<'_>,
    progress: &mut (dyn FnMut(Progress) + Send),
) -> Result<Report, SimError> {
    let _work = WorkDir::claim(&plan.work_dir)?;
    let segments = segments(
        plan.design,
        &plan.vectors,
        plan.random,
        plan.seed,
        plan.effort,
    );
    let steps = 2 + plan.simulators.len() * (1 + segments.len());
    let progress = Steps::new(progress, steps);
    progress.start("model: driving the pins");
    let mut sessions: Vec<Session> = Vec::with_capacity(segments.len());
    let mut cases = Vec::with_capacity(segments.len());
    for (number, segment) in segments.iter().enumerate() {
        let mut session = session::run(plan.design, segment);
        let case = Case::new(number, segment, &session);
        let text = stimulus_text(plan.design, &session.pins);
        write(&plan.work_dir.join(case.stimulus()), &text)?;
        // Driven once more when they are replayed: all of them take gigabytes in a long check.
        session.pins = Vec::new();
        sessions.push(session);
        cases.push(case);
    }
    progress.done();

    let mut report = Report {
        verified: false,
        runs: Vec::new(),
        latency_cycles: measured_latency(plan.design, &sessions),
        interval_cycles: measured_interval(plan.design, &sessions),
        error: deviation::measure(plan.design, plan.net, &plan.vectors),
        rows_outside_box: rows_outside_box(plan),
        frames_saturated: sessions.iter().map(|s| s.saturated).sum(),
        stimulus: stimulus::summary(plan.design, &segments, &sessions),
        structure: StructureReport::default(),
        first_difference: difference::of_sessions(&segments, &sessions),
    };
    if report.first_difference.is_some() || !report.stimulus.missing.is_empty() {
        return Ok(report);
    }
    let mut structure = Ok(());
    if plan.effort != Effort::Quick {
        progress.start("yosys: registers and memories");
        // Verilog that Yosys refuses may still differ in a simulator, which says more.
        structure = match structure::check(plan) {
            Ok((structure, extra)) => {
                (report.structure, report.first_difference) = (structure, extra);
                Ok(())
            }
            Err(error) => Err(error),
        };
    }
    progress.done();
    if report.first_difference.is_some() {
        return Ok(report);
    }

    let mut built = Vec::new();
    for simulator in &plan.simulators {
        progress.start(&format!("{}: building", simulator.name()));
        let start = Instant::now();
        built.push((
            simulator.build(plan.toolbox, &build_plan(plan, *simulator))?,
            start.elapsed(),
        ));
        progress.done();
    }
    // It is in no file and no report before the run, so that no dump can be made beforehand.
    let nonce = rand::random();
    let outcomes = replay_all(plan, &built, &cases, nonce, &progress)?;
    for (i, (built, build_time)) in built.iter().enumerate() {
        let mine: Vec<&Outcome> = outcomes.iter().filter(|o| o.simulator == i).collect();
        let differs = mine
            .iter()
            .filter_map(|o| Some((o, o.difference.as_ref()?)));
        let first = differs.min_by_key(|(o, _)| o.case);
        let registers = mine.iter().map(|o| o.registers).max().unwrap_or(0);
        report.runs.push(SimulatorRun {
            simulator: built.simulator().name().to_owned(),
            version: built.version().to_owned(),
            frames: mine.iter().map(|o| cases[o.case].frames).sum(),
            edges: mine.iter().map(|o| o.edges).sum(),
            registers,
            values_compared: mine.iter().map(|o| o.values_compared).sum(),
            verdict: if first.is_some() {
                Verdict::Differs
            } else {
                Verdict::Equal
            },
            seconds: (*build_time + mine.iter().map(|o| o.duration).sum::<Duration>())
                .as_secs_f64(),
        });
        if let (None, Some((outcome, found))) = (&report.first_difference, first) {
            let case = &cases[outcome.case];
            let dump = plan.work_dir.join(case.dump(built.simulator()));
            let simulator = built.simulator();
            report.first_difference = Some(match found {
                Found::Value(found) => {
                    difference::of_registers(plan, case, simulator, &dump, found)?
                }
                Found::Shape { signal, note } => {
                    difference::of_shape(plan, case, simulator.name(), signal, note)
                }
            });
        }
    }
    if report.first_difference.is_none() {
        structure?;
    }
    report.verified = report.first_difference.is_none()
        && report.stimulus.missing.is_empty()
        && report.latency_cycles.measured == Some(report.latency_cycles.stated)
        && report.interval_cycles.measured == Some(report.interval_cycles.stated)
        && !report.runs.is_empty()
        && report.runs.iter().all(|r| {
            r.verdict == Verdict::Equal && r.frames > 0 && r.edges > 0 && r.values_compared > 0
        });
    Ok(report)
}

fn build_plan(plan: &VerifyPlan<'_>, simulator: Simulator) -> BuildPlan {
    let name = plan.design.name();
    BuildPlan {
        design: name.to_owned(),
        sources: plan.sources.iter().map(|s| plan.bundle.join(s)).collect(),
        bench: plan.harness.bench.clone(),
        bench_icarus: plan.harness.bench_icarus.clone(),
        main_cpp: plan.harness.main_cpp.clone(),
        models: plan.harness.models.clone(),
        work_dir: plan.work_dir.join(format!("{}-build", simulator.name())),
        cache_dir: plan.cache_dir.clone(),
        purpose: Purpose::Trace,
        timeout: plan.timeout,
    }
}

fn measured_latency(design: &Design, sessions: &[Session]) -> Cycles {
    let seen: Vec<usize> = sessions.iter().filter_map(|s| s.latency).collect();
    let stated = design.latency_cycles();
    // One that is not as stated is what has to be shown.
    let measured = seen
        .iter()
        .find(|l| **l != stated)
        .or(seen.first())
        .copied();
    Cycles { stated, measured }
}

fn measured_interval(design: &Design, sessions: &[Session]) -> Cycles {
    let stated = design.interval_cycles();
    let seen: Vec<usize> = sessions
        .iter()
        .filter_map(|s| s.interval)
        .flat_map(|(least, most)| [least, most])
        .collect();
    let measured = seen
        .iter()
        .find(|i| **i != stated)
        .or(seen.first())
        .copied();
    Cycles { stated, measured }
}

fn rows_outside_box(plan: &VerifyPlan<'_>) -> usize {
    let input = plan.design.input();
    plan.vectors.iter().filter(|row| input.outside(row)).count()
}

fn write(path: &Path, text: &str) -> Result<(), SimError> {
    std::fs::write(path, text).map_err(|source| io_error(path, source))
}

fn io_error(path: &Path, source: std::io::Error) -> SimError {
    ToolError::Io {
        path: path.to_owned(),
        source,
    }
    .into()
}
