//! `hwgen verify`

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::builder::RangedU64ValueParser;
use hwgen_gen::Source;
use hwgen_sim::error::ToolError;
use hwgen_sim::simulator::Simulator;
use hwgen_sim::stimulus::Effort;
use hwgen_sim::tool::Toolbox;
use hwgen_sim::verify::{Report, VerifyPlan};
use serde_json::json;

use super::Outcome;
use crate::cache;
use crate::destination::real_path;
use crate::failure::{Exit, Failure};
use crate::harness::harness;
use crate::output::Output;
use crate::table::Table;

pub(crate) mod report;

const EXAMPLES: &str = "\
The bundle itself is left as it is. Left elsewhere are
  .verify/<bundle>     beside the bundle: logs, stimuli and, after a difference, the dumps (see --work)
  ~/.cache/hwgen       compiled benches, for the next time ($XDG_CACHE_HOME, if it is set)

The error against float is measured over the vectors, else over the frames under `calibration` in
the weights file, else over independent points of the input box, which say little.

Examples:
  hwgen verify build/landing
  hwgen verify build/landing --vectors vectors.csv --random 200 --simulators icarus
  hwgen verify build/landing --json

Exit codes: 0 if every register, output word and cycle count is equal, 1 if one differs or the Verilog
has text that simulators and synthesis may read in two ways, 2 if the bundle was changed, 3 if a
simulator is missing or failed.";

/// More random frames would take days, and more memory than there may be.
const MOST_FRAMES: u64 = 1_000_000;

/// What `verify` takes.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Directory of the bundle
    #[arg(value_name = "DIR")]
    pub bundle: PathBuf,
    /// Frames of raw inputs: a header with the input names in any order
    #[arg(long, value_name = "F.csv")]
    pub vectors: Option<PathBuf>,
    /// Random frames in the input box
    #[arg(long, value_name = "N", default_value_t = 64,
          value_parser = RangedU64ValueParser::<usize>::new().range(0..=MOST_FRAMES))]
    pub random: usize,
    /// Seed of the random frames, gaps and back-pressure
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub seed: u64,
    /// Which simulators, separated by commas [default: all that are installed]
    #[arg(long, value_name = "icarus,verilator", value_delimiter = ',', value_parser = simulator)]
    pub simulators: Vec<Simulator>,
    /// Resets of 1 to 8 cycles at every cycle of an interval in every simulator, however long that
    /// takes
    #[arg(long)]
    pub thorough: bool,
    /// Where logs and dumps go: a new or empty directory, or one of an earlier check
    #[arg(long, value_name = "DIR")]
    pub work: Option<PathBuf>,
    /// How long a build or a simulation may take
    #[arg(long, value_name = "SECONDS", default_value_t = 600,
          value_parser = clap::value_parser!(u64).range(1..=604_800))]
    pub timeout: u64,
}

fn simulator(text: &str) -> Result<Simulator, String> {
    let known = Simulator::ALL.map(Simulator::name);
    Simulator::ALL
        .into_iter()
        .find(|s| s.name() == text)
        .ok_or_else(|| format!("one of {} expected", known.join(", ")))
}

/// Checks the bundle.
///
/// # Errors
/// If bundle or vectors are refused, or nothing can be said of the bundle.
pub fn run(args: &Args, output: &Output) -> Result<Outcome, Failure> {
    let source = Source::read(&args.bundle)?;
    let vectors = match &args.vectors {
        Some(path) => Table::read(path)?.numbers(source.design.input_names())?,
        None => Vec::new(),
    };
    let toolbox = Toolbox::new(Path::new("."));
    let simulators = if args.simulators.is_empty() {
        let (present, missing) = installed(&toolbox);
        for (simulator, error) in &missing {
            output.remark(&format!("note: without {}: {error}", simulator.name()));
        }
        if present.is_empty() {
            return Err(no_simulator(missing));
        }
        present
    } else {
        let mut named: Vec<Simulator> = Vec::new();
        for simulator in &args.simulators {
            simulator.version(&toolbox)?;
            if !named.contains(simulator) {
                named.push(*simulator);
            }
        }
        named
    };
    let check = Check {
        bundle: &args.bundle,
        source: &source,
        vectors,
        random: args.random,
        seed: args.seed,
        thorough: args.thorough,
        simulators,
        toolbox: &toolbox,
        work: args.work.as_deref(),
        timeout: Duration::from_secs(args.timeout),
    };
    let (report, failure) = check.run(output)?;
    let mut json = report::object(&report);
    json.insert("design".into(), json!(source.design.name()));
    json.insert("digest".into(), json!(source.manifest.digest));
    json.insert("bundle".into(), json!(args.bundle.display().to_string()));
    json.insert("seed".into(), json!(args.seed));
    let mut text = report::text(source.design.name(), &report);
    if failure.is_none() {
        text.push_str(&report::verified(&report));
    }
    Ok(Outcome {
        text,
        json,
        failure,
        remarks: report::error(&report).warnings(),
    })
}

/// The simulators that work, and the others with what is wrong with them.
pub(crate) fn installed(toolbox: &Toolbox) -> (Vec<Simulator>, Vec<(Simulator, ToolError)>) {
    let mut missing = Vec::new();
    let present = Simulator::ALL
        .into_iter()
        .filter(|s| match s.version(toolbox) {
            Ok(_) => true,
            Err(error) => {
                missing.push((*s, error));
                false
            }
        })
        .collect();
    (present, missing)
}

/// The failure that there is no simulator at all.
pub(crate) fn no_simulator(missing: Vec<(Simulator, ToolError)>) -> Failure {
    let causes = missing.iter().map(|(_, error)| error.to_string()).collect();
    let install = missing.first().and_then(|(_, e)| e.install());
    let help = match install {
        Some(install) => format!("install one with `{install}`"),
        None => "`hwgen doctor` lists what is there".into(),
    };
    let message = "a simulator expected, none that works found";
    let mut failure = Failure::new(Exit::Tool, "tool-missing", message).help(help);
    failure.causes = causes;
    failure
}

/// A check of a bundle that was read.
pub(crate) struct Check<'a> {
    pub bundle: &'a Path,
    pub source: &'a Source,
    pub vectors: Vec<Vec<f64>>,
    pub random: usize,
    pub seed: u64,
    pub thorough: bool,
    pub simulators: Vec<Simulator>,
    pub toolbox: &'a Toolbox,
    pub work: Option<&'a Path>,
    pub timeout: Duration,
}

impl Check<'_> {
    /// The report, and the failure if it says that something differs.
    pub fn run(self, output: &Output) -> Result<(Report, Option<Failure>), Failure> {
        let (parent, name) = place(self.bundle)?;
        let work = match self.work {
            Some(work) => work.to_owned(),
            None => parent.join(".verify").join(name),
        };
        keep_apart(&work, self.bundle)?;
        output.detail(&format!("logs in {}", work.display()));
        let cache_dir = cache::directory("verilator", &work);
        let expected: Vec<Simulator> = self.simulators.clone();
        let plan = VerifyPlan {
            bundle: self.bundle.to_owned(),
            sources: self.source.rtl(),
            harness: harness(self.source),
            design: &self.source.design,
            net: &self.source.net,
            vectors: self.vectors,
            random: self.random,
            seed: self.seed,
            effort: match self.thorough {
                true => Effort::Thorough,
                false => Effort::Usual,
            },
            simulators: self.simulators,
            toolbox: self.toolbox,
            work_dir: work,
            cache_dir,
            timeout: self.timeout,
        };
        let mut line = output.progress();
        let outcome = hwgen_sim::verify::verify(&plan, &mut |progress| {
            line.show(&progress.activity, progress.done, progress.total);
        });
        drop(line);
        let report = outcome?;
        let failure = report::judge(&report, &expected);
        Ok((report, failure))
    }
}

/// The directory that holds the bundle, and the bundle's name in it.
fn place(bundle: &Path) -> Result<(PathBuf, std::ffi::OsString), Failure> {
    let split = |path: &Path| {
        let name = path.file_name().map(OsStr::to_owned)?;
        let parent = path.parent()?;
        let here = parent.as_os_str().is_empty();
        let parent = if here { Path::new(".") } else { parent };
        Some((parent.to_owned(), name))
    };
    if let Some(place) = split(bundle) {
        return Ok(place);
    }
    let real = bundle.canonicalize().map_err(|e| Failure::io(bundle, &e))?;
    split(&real).ok_or_else(|| {
        Failure::input("work", "a directory inside another one expected")
            .file(bundle.display().to_string())
            .help("move the bundle into a directory of its own")
    })
}

/// Makes sure that neither of work directory and bundle is inside of the other one.
fn keep_apart(work: &Path, bundle: &Path) -> Result<(), Failure> {
    let real_path = |path: &Path| real_path(path).map_err(|e| Failure::io(path, &e));
    let (real_work, real_bundle) = (real_path(work)?, real_path(bundle)?);
    if real_work.starts_with(&real_bundle) || real_bundle.starts_with(&real_work) {
        return Err(
            Failure::input("work", "a directory outside of the bundle expected")
                .file(work.display().to_string())
                .help("choose another --work: it is emptied, and a bundle is never written to"),
        );
    }
    Ok(())
}
