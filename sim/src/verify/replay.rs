//! The stimuli in the simulators, compared with the model that runs along.

use std::collections::VecDeque;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use super::{Progress, VerifyPlan, io_error};
use crate::compare::{Difference, Plan, compare_rows};
use crate::error::{SimError, ToolError, TraceError};
use crate::model::{Model, Pins};
use crate::session::{self, Session};
use crate::simulator::{Built, ReplayPlan, Simulator};
use crate::stimulus::{Segment, Share};
use crate::trace::Dump;

/// One segment, and what it was when the model was driven with it.
pub(super) struct Case<'a> {
    number: usize,
    pub(super) segment: &'a Segment,
    pub(super) clocks: usize,
    pub(super) frames: usize,
}

impl<'a> Case<'a> {
    pub(super) fn new(number: usize, segment: &'a Segment, session: &Session) -> Self {
        Self {
            number,
            segment,
            clocks: session.pins.len(),
            frames: session.frames,
        }
    }

    /// The pins of every clock, by driving the model again: it is far faster than a simulator.
    pub(super) fn pins(&self, plan: &VerifyPlan<'_>) -> Vec<Pins> {
        session::run(plan.design, self.segment).pins
    }

    pub(super) fn stem(&self) -> String {
        format!(
            "{:02}-{}",
            self.number,
            self.segment.name.replace(" x ", "-").replace(' ', "-")
        )
    }

    pub(super) fn stimulus(&self) -> String {
        format!("{}.stimulus", self.stem())
    }

    pub(super) fn dump(&self, simulator: Simulator) -> String {
        format!(
            "{}.{}.{}",
            self.stem(),
            simulator.name(),
            simulator.dump_extension()
        )
    }
}

/// One case in one simulator.
pub(super) struct Outcome {
    pub(super) simulator: usize,
    pub(super) case: usize,
    pub(super) registers: usize,
    pub(super) edges: usize,
    pub(super) values_compared: u64,
    pub(super) duration: Duration,
    pub(super) difference: Option<Found>,
}

/// What differs.
pub(super) enum Found {
    /// The value of a register or port.
    Value(Difference),
    /// A register that is missing or has another width, a block that is tied otherwise.
    Shape {
        /// Its path from the core down.
        signal: String,
        /// What was expected and found.
        note: String,
    },
}

/// Replays every case in every simulator, as many at a time as there are cores.
pub(super) fn replay_all(
    plan: &VerifyPlan<'_>,
    built: &[(Built, Duration)],
    cases: &[Case<'_>],
    nonce: u64,
    progress: &Steps<'_>,
) -> Result<Vec<Outcome>, SimError> {
    // The slowest first, so that no core waits long at the end.
    let mut jobs: Vec<(usize, usize)> = (0..built.len())
        .flat_map(|s| (0..cases.len()).map(move |c| (s, c)))
        .filter(|(s, c)| {
            let all: Vec<Simulator> = built.iter().map(|(b, _)| b.simulator()).collect();
            takes_part(all[*s], cases[*c].segment.share, &all)
        })
        .collect();
    jobs.sort_by_key(|(s, c)| (*s, std::cmp::Reverse(cases[*c].clocks)));
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
                    match replay(plan, simulator, case, nonce) {
                        Ok(outcome) => {
                            if outcome.difference.is_some() {
                                // Only the first difference is told: later cases can't have it.
                                lock(&queue).retain(|(other, later)| *other != s || *later < c);
                            }
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
fn replay(
    plan: &VerifyPlan<'_>,
    built: &Built,
    case: &Case<'_>,
    nonce: u64,
) -> Result<Outcome, SimError> {
    let start = Instant::now();
    let dump = plan.work_dir.join(case.dump(built.simulator()));
    let differs = |signal: &str, note: String| Outcome {
        simulator: 0,
        case: 0,
        registers: 0,
        edges: 0,
        values_compared: 0,
        duration: start.elapsed(),
        difference: Some(Found::Shape {
            signal: signal.to_owned(),
            note,
        }),
    };
    let replay = built.replay(&ReplayPlan {
        stimulus: plan.work_dir.join(case.stimulus()),
        clocks: case.clocks,
        nonce,
        dump: dump.clone(),
        timeout: plan.timeout,
    });
    match replay {
        Ok(_) => {}
        Err(ToolError::Contract {
            instance,
            expected,
            found,
        }) => {
            let path = instance.split_once("u_dut.").map_or(&*instance, |(_, p)| p);
            return Ok(differs(path, format!("expected {expected}, found {found}")));
        }
        Err(error) => return Err(error.into()),
    }
    Dump::open(&dump)?.demand_nonce(nonce)?;
    let pins = case.pins(plan);
    let mut model = Model::new(plan.design);
    let registers = model.registers();
    let mut row = Vec::new();
    let rows = Plan {
        registers: &registers,
        clocks: pins.len(),
        first_clock: 0,
    };
    let comparison = compare_rows(&rows, &mut Dump::open(&dump)?, |clock, values| {
        model.step(&pins[clock]);
        row.clear();
        model.values(&mut row);
        values.copy_from_slice(&row);
    });
    let comparison = match comparison {
        Ok(comparison) => comparison,
        Err(TraceError::Width {
            register,
            expected,
            found,
        }) => {
            let note = format!("expected {expected} bits, found {found}");
            return Ok(differs(&register, note));
        }
        Err(TraceError::MissingRegister { register, .. }) => {
            return Ok(differs(&register, "expected a register, found none".into()));
        }
        Err(error) => return Err(error.into()),
    };
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
        difference: comparison.first_difference.map(Found::Value),
    })
}

/// Whether a simulator replays the segments of a share.
fn takes_part(simulator: Simulator, share: Share, all: &[Simulator]) -> bool {
    match share {
        Share::All => true,
        Share::Fastest => simulator == Simulator::Verilator || !all.contains(&Simulator::Verilator),
        Share::Compiled => simulator == Simulator::Verilator,
        Share::Interpreted => simulator == Simulator::Icarus,
    }
}

/// Counts steps and tells what is going on.
pub(super) struct Steps<'a> {
    report: Mutex<(&'a mut (dyn FnMut(Progress) + Send), usize)>,
    total: usize,
}

impl<'a> Steps<'a> {
    pub(super) fn new(report: &'a mut (dyn FnMut(Progress) + Send), total: usize) -> Self {
        Self {
            report: Mutex::new((report, 0)),
            total,
        }
    }

    pub(super) fn start(&self, activity: &str) {
        let mut report = lock(&self.report);
        let progress = Progress {
            activity: activity.to_owned(),
            done: report.1,
            total: self.total,
        };
        (report.0)(progress);
    }

    pub(super) fn done(&self) {
        lock(&self.report).1 += 1;
    }
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().expect("no holder panics")
}
