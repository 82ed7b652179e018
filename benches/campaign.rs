//! Random correct designs, each of which `verify` must call verified: a command, not a test.
//!
//! `cargo bench --bench campaign -- --count 500 --seed 1 --verilator 50 --out docs/campaign.md`
//!
//! With `--log F` each outcome is appended to a file, and designs that are in it are not checked
//! again: a campaign of hours goes on where it ended. Delete the file after a change of hwgen.

#[path = "../tests/support/random.rs"]
mod random;

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use hwgen::harness::harness;
use hwgen_gen::Source;
use hwgen_sim::simulator::Simulator;
use hwgen_sim::stimulus::Effort;
use hwgen_sim::tool::Toolbox;
use hwgen_sim::verify::{VerifyPlan, verify};
use hwgen_spec::design::Design;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Random frames of each check.
const RANDOM: usize = 12;

struct Arguments {
    count: u64,
    seed: u64,
    icarus: u64,
    verilator: u64,
    out: Option<PathBuf>,
    log: Option<PathBuf>,
}

/// What came of one design.
#[derive(Clone, Default, Serialize, Deserialize)]
struct Outcome {
    seed: u64,
    simulators: usize,
    alarm: Option<String>,
    frames: usize,
    resets: usize,
    cycles: usize,
    values: u64,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments = read()?;
    let directory = tempfile::tempdir()?;
    let before = match &arguments.log {
        Some(log) => read_log(log)?,
        None => Vec::new(),
    };
    let log = match &arguments.log {
        Some(path) => Some(File::options().create(true).append(true).open(path)?),
        None => None,
    };
    let log = Mutex::new(log);
    let (start, done) = (Instant::now(), AtomicUsize::new(0));
    let outcomes: Vec<Outcome> = (0..arguments.count)
        .into_par_iter()
        .map(|i| {
            let seed = arguments.seed + i;
            let simulators: &[Simulator] = match i {
                i if i < arguments.verilator => &Simulator::ALL,
                i if i < arguments.icarus => &[Simulator::Icarus],
                _ => &[],
            };
            let known = |o: &&Outcome| o.seed == seed && o.simulators == simulators.len();
            if let Some(outcome) = before.iter().find(known) {
                done.fetch_add(1, Ordering::Relaxed);
                return outcome.clone();
            }
            let outcome = Outcome {
                seed,
                simulators: simulators.len(),
                ..one(seed, simulators, directory.path())
            };
            if let Some(log) = log.lock().expect("no thread panics").as_mut() {
                let line = serde_json::to_string(&outcome).expect("serializes");
                writeln!(log, "{line}").expect("the log is written");
            }
            let done = 1 + done.fetch_add(1, Ordering::Relaxed);
            if let Some(alarm) = &outcome.alarm {
                eprintln!("{alarm}");
            }
            if done.is_multiple_of(10) {
                eprintln!(
                    "{done} of {}, {:.0} s",
                    arguments.count,
                    start.elapsed().as_secs_f64()
                );
            }
            outcome
        })
        .collect();
    let text = report(&arguments, &outcomes);
    print!("{text}");
    if let Some(out) = &arguments.out {
        std::fs::write(out, &text)?;
    }
    match outcomes.iter().all(|outcome| outcome.alarm.is_none()) {
        true => Ok(()),
        false => Err("a correct design was not verified".into()),
    }
}

fn read() -> Result<Arguments, String> {
    let mut arguments = Arguments {
        count: 500,
        seed: 1,
        icarus: u64::MAX,
        verilator: 50,
        out: None,
        log: None,
    };
    let mut words = std::env::args().skip(1).filter(|word| word != "--bench");
    while let Some(word) = words.next() {
        let value = words
            .next()
            .ok_or(format!("expected a value behind {word}"))?;
        let number = || {
            value
                .parse()
                .map_err(|_| format!("expected a number behind {word}"))
        };
        match word.as_str() {
            "--count" => arguments.count = number()?,
            "--seed" => arguments.seed = number()?,
            "--icarus" => arguments.icarus = number()?,
            "--verilator" => arguments.verilator = number()?,
            "--out" => arguments.out = Some(value.into()),
            "--log" => arguments.log = Some(value.into()),
            _ => {
                return Err(format!(
                    "expected --count, --seed, --icarus, --verilator, --out or --log, found {word}"
                ));
            }
        }
    }
    Ok(arguments)
}

fn read_log(path: &Path) -> Result<Vec<Outcome>, Box<dyn std::error::Error>> {
    if !path.exists() {
        return Ok(Vec::new());
    }
    let text = std::fs::read_to_string(path)?;
    Ok(text
        .lines()
        .map(serde_json::from_str)
        .collect::<Result<_, _>>()?)
}

fn one(seed: u64, simulators: &[Simulator], directory: &Path) -> Outcome {
    let (net, options) = random::random_design(seed);
    let alarm = |what: String| Outcome {
        alarm: Some(format!("design {seed}: {what}")),
        ..Outcome::default()
    };
    let design = match Design::new(&net, &options) {
        Ok(design) => design,
        Err(error) => return alarm(error.to_string()),
    };
    let place = directory.join(format!("{seed}"));
    let bundle = place.join(design.name());
    let outcome = hwgen_gen::generate(&design, &net)
        .write(&bundle)
        .map_err(|error| error.to_string())
        .and_then(|()| Source::read(&bundle).map_err(|error| error.to_string()))
        .and_then(|source| {
            let plan = VerifyPlan {
                bundle: bundle.clone(),
                sources: source.rtl(),
                harness: harness(&source),
                design: &source.design,
                net: &source.net,
                vectors: Vec::new(),
                random: RANDOM,
                seed,
                effort: Effort::Usual,
                simulators: simulators.to_vec(),
                toolbox: &Toolbox::new(Path::new(env!("CARGO_MANIFEST_DIR"))),
                work_dir: place.join("work"),
                cache_dir: place.join("cache"),
                timeout: Duration::from_secs(1200),
            };
            verify(&plan, &mut |_| {}).map_err(|error| error.to_string())
        });
    let outcome = match outcome {
        // Without a simulator the structure alone is compared.
        Ok(report)
            if report.structure.checked
                && match simulators {
                    [] => report.first_difference.is_none() && report.stimulus.missing.is_empty(),
                    _ => report.verified,
                } =>
        {
            Outcome {
                alarm: None,
                frames: report.runs.iter().map(|run| run.frames).sum(),
                resets: report.stimulus.resets,
                cycles: report.runs.iter().map(|run| run.edges).sum(),
                values: report.runs.iter().map(|run| run.values_compared).sum(),
                ..Outcome::default()
            }
        }
        Ok(report) => alarm(format!(
            "{:?} {:?}",
            report.first_difference, report.stimulus
        )),
        Err(error) => alarm(error),
    };
    // Hundreds of bundles with their builds would fill a disk.
    let _ = std::fs::remove_dir_all(&place);
    outcome
}

fn report(arguments: &Arguments, outcomes: &[Outcome]) -> String {
    let sum = |of: fn(&Outcome) -> usize| outcomes.iter().map(of).sum::<usize>();
    let alarms: Vec<&str> = outcomes.iter().filter_map(|o| o.alarm.as_deref()).collect();
    let icarus = arguments.icarus.min(arguments.count);
    let mut text = format!(
        "# Random correct designs\n\nMade by `tools/campaign --count {} --seed {} --icarus {icarus} \
         --verilator {}`: designs of `tests/support/random.rs`, the first {icarus} in Icarus Verilog, the \
         first {} in Verilator too; the structure of all by Yosys.\n\n| | |\n|---|---|\n| designs | {} |\n| not verified, though correct | {} \
         |\n| frames compared | {} |\n| resets driven | {} |\n| cycles compared | {} |\n| values compared \
         | {} |\n",
        arguments.count,
        arguments.seed,
        arguments.verilator,
        arguments.verilator,
        outcomes.len(),
        alarms.len(),
        sum(|o| o.frames),
        sum(|o| o.resets),
        sum(|o| o.cycles),
        outcomes.iter().map(|o| o.values).sum::<u64>(),
    );
    for alarm in alarms {
        text.push_str(&format!("\n- {alarm}\n"));
    }
    text
}
