//! The three-way check of a bundle: untimed values, cycle model, simulators.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use hwgen_spec::design::Design;
use hwgen_spec::network::FloatNet;
use serde::Serialize;

use crate::compare::{Difference, Plan, compare_rows};
use crate::error::{SimError, ToolError};
use crate::model::Model;
use crate::session::{self, Session, stimulus_text};
use crate::simulator::{BuildPlan, Built, Purpose, ReplayPlan, Simulator};
use crate::stimulus::{Segment, segments};
use crate::tool::Toolbox;
use crate::trace::Dump;

mod difference;

/// What is to be checked, with what.
pub struct VerifyPlan<'a> {
    /// Directory of the bundle.
    pub bundle: PathBuf,
    /// Verilog files of the core, below the bundle's directory.
    pub sources: Vec<String>,
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
    /// The simulators, at least one.
    pub simulators: Vec<Simulator>,
    /// Where tools are found.
    pub toolbox: &'a Toolbox,
    /// Where logs, stimuli and, after a difference, dumps are left; emptied first.
    pub work_dir: PathBuf,
    /// Where simulator builds are kept.
    pub cache_dir: PathBuf,
    /// How long a build or a replay may take.
    pub timeout: Duration,
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

/// What was promised and what was seen.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Cycles {
    /// By the design.
    pub stated: usize,
    /// At the pins; `None` if nothing could be measured.
    pub measured: Option<usize>,
}

/// The verdict on one simulator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Every register at every edge.
    Equal,
    /// There is a first difference.
    Differs,
}

/// One simulator's part.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SimulatorRun {
    /// `icarus` or `verilator`.
    pub simulator: String,
    /// Its version.
    pub version: String,
    /// Frames whose outputs were compared.
    pub frames: usize,
    /// Rising edges compared.
    pub edges: usize,
    /// Registers compared at each edge.
    pub registers: usize,
    /// Words compared, over all edges.
    pub values_compared: u64,
    /// Equal or not.
    pub verdict: Verdict,
    /// Seconds of building and replaying, replays that ran side by side added up.
    pub seconds: f64,
}

/// Error of the fixed-point outputs against the float network, over frames inside the box.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OutputError {
    /// `<network>.<output>`
    pub output: String,
    /// Unit of the numbers below.
    pub unit: String,
    /// Greatest absolute error.
    pub max: f64,
    /// Root of the mean square error.
    pub rms: f64,
}

/// Where a simulator parts from the model, or the model from the untimed values.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FirstDifference {
    /// `icarus`, `verilator`, or `model` where the model itself parts from the untimed values.
    pub simulator: String,
    /// The stimulus that showed it, such as `random x back-pressure`.
    pub segment: String,
    /// Rising edge of that stimulus, from 0.
    pub cycle: usize,
    /// Path of the signal from the top module.
    pub signal: String,
    /// Lane of the signal, lowest first.
    pub lane: usize,
    /// Network, if the signal belongs to one.
    pub network: Option<String>,
    /// Layer, if the signal belongs to one.
    pub layer: Option<String>,
    /// Neuron whose value it is, where that can be told.
    pub neuron: Option<usize>,
    /// Input whose weight or operand it is, where that can be told.
    pub input: Option<usize>,
    /// The model's code.
    pub model: i64,
    /// The simulator's code, or its bits if some are unknown.
    pub rtl: String,
    /// The model's value in real units, where the register has a format.
    pub model_real: Option<f64>,
    /// The simulator's value in real units.
    pub rtl_real: Option<f64>,
    /// Values around the first difference, a line a cycle.
    pub window: Vec<String>,
    /// The simulator's dump, the model's, and a GTKWave save file that shows both.
    pub files: Vec<PathBuf>,
}

/// The outcome of a check.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// True if everything was compared and equal.
    pub verified: bool,
    /// One entry a simulator.
    pub runs: Vec<SimulatorRun>,
    /// Latency.
    pub latency_cycles: Cycles,
    /// Interval.
    pub interval_cycles: Cycles,
    /// One entry an output.
    pub error_vs_float: Vec<OutputError>,
    /// Rows of the vectors file that lie outside of the box.
    pub rows_outside_box: usize,
    /// Frames with an input outside of the box or a word inside saturated, whatever their class.
    pub frames_saturated: usize,
    /// The first difference, if there is one.
    pub first_difference: Option<FirstDifference>,
}

/// Checks a bundle.
///
/// The model is driven first and its answers compared with the untimed values; each simulator
/// then replays the same pins, and its registers are compared with the model's at every edge.
///
/// # Errors
/// [`SimError`] if nothing can be said: a tool is missing, failed, or printed no verdict.
pub fn verify(
    plan: &VerifyPlan<'_>,
    progress: &mut (dyn FnMut(Progress) + Send),
) -> Result<Report, SimError> {
    let segments = segments(plan.design, &plan.vectors, plan.random, plan.seed);
    let steps = 1 + plan.simulators.len() * (1 + segments.len());
    let progress = Steps {
        report: Mutex::new((progress, 0)),
        total: steps,
    };
    fresh_directory(&plan.work_dir)?;
    progress.start("model: driving the pins");
    let sessions: Vec<Session> = segments
        .iter()
        .map(|s| session::run(plan.design, s))
        .collect();
    progress.done();

    let mut report = Report {
        verified: false,
        runs: Vec::new(),
        latency_cycles: measured_latency(plan.design, &sessions),
        interval_cycles: measured_interval(plan.design, &sessions),
        error_vs_float: errors_vs_float(plan),
        rows_outside_box: rows_outside_box(plan),
        frames_saturated: sessions.iter().map(|s| s.saturated).sum(),
        first_difference: difference::of_sessions(&segments, &sessions),
    };
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
    let cases: Vec<Case<'_>> = segments
        .iter()
        .zip(&sessions)
        .enumerate()
        .map(|(number, (segment, session))| Case {
            number,
            segment,
            session,
        })
        .collect();
    for case in &cases {
        let text = stimulus_text(plan.design, &case.session.pins);
        write(&plan.work_dir.join(case.stimulus()), &text)?;
    }
    let outcomes = replay_all(plan, &built, &cases, &progress)?;
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
            frames: mine.iter().map(|o| cases[o.case].session.frames).sum(),
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
            report.first_difference = Some(difference::of_registers(
                plan,
                case,
                built.simulator(),
                &dump,
                found,
            )?);
        }
    }
    report.verified = report.first_difference.is_none()
        && report.latency_cycles.measured == Some(report.latency_cycles.stated)
        && report.interval_cycles.measured == Some(report.interval_cycles.stated)
        && !report.runs.is_empty()
        && report.runs.iter().all(|r| {
            r.verdict == Verdict::Equal && r.frames > 0 && r.edges > 0 && r.values_compared > 0
        });
    Ok(report)
}

/// One segment with the pins that the model was driven with.
struct Case<'a> {
    number: usize,
    segment: &'a Segment,
    session: &'a Session,
}

impl Case<'_> {
    fn stem(&self) -> String {
        format!(
            "{:02}-{}",
            self.number,
            self.segment.name.replace(" x ", "-").replace(' ', "-")
        )
    }

    fn stimulus(&self) -> String {
        format!("{}.stimulus", self.stem())
    }

    fn dump(&self, simulator: Simulator) -> String {
        format!(
            "{}.{}.{}",
            self.stem(),
            simulator.name(),
            simulator.dump_extension()
        )
    }
}

/// One case in one simulator.
struct Outcome {
    simulator: usize,
    case: usize,
    registers: usize,
    edges: usize,
    values_compared: u64,
    duration: Duration,
    difference: Option<Difference>,
}

/// Replays every case in every simulator, as many at a time as there are cores.
fn replay_all(
    plan: &VerifyPlan<'_>,
    built: &[(Built, Duration)],
    cases: &[Case<'_>],
    progress: &Steps<'_>,
) -> Result<Vec<Outcome>, SimError> {
    // The slowest first, so that no core waits long at the end.
    let mut jobs: Vec<(usize, usize)> = (0..built.len())
        .flat_map(|s| (0..cases.len()).map(move |c| (s, c)))
        .collect();
    jobs.sort_by_key(|(s, c)| (*s, std::cmp::Reverse(cases[*c].session.pins.len())));
    let queue = Mutex::new(VecDeque::from(jobs));
    let outcomes = Mutex::new(Vec::new());
    let failure: Mutex<Option<SimError>> = Mutex::new(None);
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                loop {
                    if lock(&failure).is_some() {
                        return;
                    }
                    let Some((s, c)) = lock(&queue).pop_front() else {
                        return;
                    };
                    let (simulator, case) = (&built[s].0, &cases[c]);
                    progress.start(&format!(
                        "{}: {}",
                        simulator.simulator().name(),
                        case.segment.name
                    ));
                    match replay(plan, simulator, case) {
                        Ok(outcome) => {
                            lock(&outcomes).push(Outcome {
                                simulator: s,
                                case: c,
                                ..outcome
                            });
                        }
                        Err(error) => {
                            lock(&failure).get_or_insert(error);
                        }
                    }
                    progress.done();
                }
            });
        }
    });
    match failure.into_inner().expect("no worker panics") {
        Some(error) => Err(error),
        None => Ok(outcomes.into_inner().expect("no worker panics")),
    }
}

/// One replay, compared clock by clock with a model that runs along.
fn replay(plan: &VerifyPlan<'_>, built: &Built, case: &Case<'_>) -> Result<Outcome, SimError> {
    let start = Instant::now();
    let dump = plan.work_dir.join(case.dump(built.simulator()));
    built.replay(&ReplayPlan {
        stimulus: plan.work_dir.join(case.stimulus()),
        clocks: case.session.pins.len(),
        dump: dump.clone(),
        timeout: plan.timeout,
    })?;
    let mut model = Model::new(plan.design);
    let registers = model.registers();
    let mut row = Vec::new();
    let rows = Plan {
        registers: &registers,
        clocks: case.session.pins.len(),
        first_clock: 0,
    };
    let comparison = compare_rows(&rows, &mut Dump::open(&dump)?, |clock, values| {
        model.step(&case.session.pins[clock]);
        row.clear();
        model.values(&mut row);
        values.copy_from_slice(&row);
    })?;
    if comparison.first_difference.is_none() {
        std::fs::remove_file(&dump).map_err(|source| io_error(&dump, source))?;
    }
    Ok(Outcome {
        simulator: 0,
        case: 0,
        registers: comparison.registers,
        edges: comparison.edges,
        values_compared: comparison.values_compared,
        duration: start.elapsed(),
        difference: comparison.first_difference,
    })
}

fn build_plan(plan: &VerifyPlan<'_>, simulator: Simulator) -> BuildPlan {
    let name = plan.design.name();
    BuildPlan {
        design: name.to_owned(),
        sources: plan.sources.iter().map(|s| plan.bundle.join(s)).collect(),
        bench: plan.bundle.join(format!("tb/{name}_tb.v")),
        bench_icarus: plan.bundle.join(format!("tb/{name}_tb_icarus.v")),
        main_cpp: plan.bundle.join("tb/sim_main.cpp"),
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

/// Rows of the file, or random points of the box if there is none, against the float network.
fn errors_vs_float(plan: &VerifyPlan<'_>) -> Vec<OutputError> {
    let design = plan.design;
    let net = design.net();
    let random = segments(design, &[], plan.random, plan.seed);
    let sampled = random
        .iter()
        .filter(|s| s.name.starts_with("random"))
        .flat_map(|s| &s.frames);
    let inputs = design.input().low.len();
    let rows: Vec<Vec<f64>> = if plan.vectors.is_empty() {
        sampled
            .map(|f| design.input().values(&f.lanes[..inputs]))
            .collect()
    } else {
        plan.vectors.clone()
    };
    let mut errors: Vec<Vec<f64>> = vec![Vec::new(); plan.net.output_columns().len()];
    for row in rows {
        if design.input().outside(&row) {
            continue;
        }
        let answer = net.evaluate(&design.input().codes(&row));
        let fixed = net.real_outputs(&answer.codes);
        for ((errors, fixed), float) in errors.iter_mut().zip(fixed).zip(plan.net.forward(&row)) {
            errors.push(fixed - float);
        }
    }
    let units = plan
        .net
        .networks
        .iter()
        .flat_map(|n| n.outputs.names.iter().map(|_| &n.outputs.unit));
    plan.net
        .output_columns()
        .into_iter()
        .zip(units)
        .zip(errors)
        .map(|((output, unit), errors)| {
            #[expect(clippy::cast_precision_loss, reason = "a count of rows")]
            let count = errors.len().max(1) as f64;
            OutputError {
                output,
                unit: unit.clone(),
                max: errors.iter().fold(0.0, |most, e| e.abs().max(most)),
                rms: (errors.iter().map(|e| e * e).sum::<f64>() / count).sqrt(),
            }
        })
        .collect()
}

fn rows_outside_box(plan: &VerifyPlan<'_>) -> usize {
    let input = plan.design.input();
    plan.vectors.iter().filter(|row| input.outside(row)).count()
}

/// Counts steps and tells what is going on.
struct Steps<'a> {
    report: Mutex<(&'a mut (dyn FnMut(Progress) + Send), usize)>,
    total: usize,
}

impl Steps<'_> {
    fn start(&self, activity: &str) {
        let mut report = lock(&self.report);
        let progress = Progress {
            activity: activity.to_owned(),
            done: report.1,
            total: self.total,
        };
        (report.0)(progress);
    }

    fn done(&self) {
        lock(&self.report).1 += 1;
    }
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().expect("no holder panics")
}

fn fresh_directory(path: &Path) -> Result<(), SimError> {
    match std::fs::remove_dir_all(path) {
        Err(source) if source.kind() != std::io::ErrorKind::NotFound => {
            return Err(io_error(path, source));
        }
        _ => {}
    }
    std::fs::create_dir_all(path).map_err(|source| io_error(path, source))
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
