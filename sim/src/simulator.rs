//! Simulators that replay a file of pin values on the Verilog and dump what happens.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::error::ToolError;
use crate::tool::run::{io, remove};
use crate::tool::{Invocation, Run, Toolbox, run};

mod icarus;
mod input;
pub(crate) mod text;
mod verilator;

pub use input::Text;

/// Copies the Verilog of a core, if none of it is refused, below a directory; names from there.
pub(crate) fn place_sources(
    sources: &[PathBuf],
    directory: &Path,
) -> Result<Vec<OsString>, ToolError> {
    input::place(&input::core(sources, &[])?, directory)
}

/// A simulator that is supported.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Simulator {
    /// Interpreted, with 0, 1, X and Z.
    Icarus,
    /// Compiled, with 0 and 1.
    Verilator,
}

/// What a build is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// To dump every signal; quick to build.
    Trace,
    /// To measure how fast the simulator can be: no dump, all optimisation.
    Speed,
}

/// What is built.
#[derive(Clone, Debug)]
pub struct BuildPlan {
    /// Module name of the core; the benches are `<design>_tb` and `<design>_tb_icarus`.
    pub design: String,
    /// Verilog files of the core.
    pub sources: Vec<PathBuf>,
    /// The replaying bench, for all simulators.
    pub bench: Text,
    /// Clock and dump around it, for Icarus.
    pub bench_icarus: Text,
    /// Clock and dump around it, for Verilator.
    pub main_cpp: Text,
    /// Models of the blocks that the core instantiates.
    pub models: Vec<Text>,
    /// Where logs and results are left.
    pub work_dir: PathBuf,
    /// Where builds are kept for the next time.
    pub cache_dir: PathBuf,
    /// What the build is for.
    pub purpose: Purpose,
    /// How long it may take.
    pub timeout: Duration,
}

/// A design that is ready to be simulated.
#[derive(Clone, Debug)]
pub struct Built {
    simulator: Simulator,
    version: String,
    program: PathBuf,
    /// The compiled design, where it is not the program itself.
    image: Option<PathBuf>,
    cached: bool,
}

/// What is replayed.
#[derive(Clone, Debug)]
pub struct ReplayPlan {
    /// Pin values, one hexadecimal word a line, one line a clock; see `rtl/tpl/tb.v`.
    pub stimulus: PathBuf,
    /// Lines in it.
    pub clocks: usize,
    /// A number that the dump must contain, so that none of another run is taken for it.
    pub nonce: u64,
    /// Where the simulator dumps; the log is left beside it. Icarus writes FST if the name ends
    /// in `.fst`, else VCD; Verilator always writes VCD.
    pub dump: PathBuf,
    /// How long it may take.
    pub timeout: Duration,
}

/// A replay that came to its end.
#[derive(Clone, Debug)]
pub struct Replay {
    /// Clocks simulated.
    pub clocks: usize,
    /// The dump.
    pub dump: PathBuf,
    /// What the simulator printed.
    pub log: PathBuf,
    /// How long it took.
    pub duration: Duration,
}

/// How fast a simulator ran without a dump.
#[derive(Clone, Copy, Debug)]
pub struct Speed {
    /// Clocks simulated.
    pub clocks: usize,
    /// Seconds that they took; for Verilator without the start of the process.
    pub seconds: f64,
    /// What the bench made of the core's outputs.
    pub digest: u32,
}

impl Simulator {
    /// All of them, the newcomer's first one first.
    pub const ALL: [Self; 2] = [Self::Icarus, Self::Verilator];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Icarus => "icarus",
            Self::Verilator => "verilator",
        }
    }

    /// Extension of the dump that suits it.
    ///
    /// Measured with 2,028 registers that all change at each of 10,000 clocks, written and read
    /// back: Icarus VCD 19 + 9 s and 610 MB, FST 34 + 7 s and 80 MB; Verilator VCD 1.5 + 8.6 s and
    /// 635 MB, FST 4.4 + 5.3 s and 98 MB. So it is VCD for both; a check cuts its stimuli into
    /// pieces that keep a dump small, and deletes it when it was equal.
    pub fn dump_extension(self) -> &'static str {
        "vcd"
    }

    /// Version of the simulator that would be used.
    ///
    /// # Errors
    /// If it, or something it needs, is missing or too old.
    pub fn version(self, tools: &Toolbox) -> Result<String, ToolError> {
        match self {
            Self::Icarus => icarus::version(tools),
            Self::Verilator => verilator::version(tools),
        }
    }

    /// Compiles the core with its bench.
    ///
    /// The compiler sees copies, in a directory of plain name that is deleted again; log and
    /// record are left in the work directory, come what may.
    ///
    /// # Errors
    /// If a tool is missing, fails, takes too long, or leaves nothing behind;
    /// [`ToolError::Refused`] if a source of the core has text that may be read in two ways.
    pub fn build(self, tools: &Toolbox, plan: &BuildPlan) -> Result<Built, ToolError> {
        std::fs::create_dir_all(&plan.work_dir).map_err(io(&plan.work_dir))?;
        match self {
            Self::Icarus => icarus::build(tools, plan),
            Self::Verilator => verilator::build(tools, plan),
        }
    }
}

impl BuildPlan {
    /// What is compiled around the core.
    fn others(&self) -> Vec<&Text> {
        let benches = [&self.bench, &self.bench_icarus];
        self.models.iter().chain(benches).collect()
    }
}

impl Built {
    /// The simulator.
    pub fn simulator(&self) -> Simulator {
        self.simulator
    }

    /// Its version.
    pub fn version(&self) -> &str {
        &self.version
    }

    /// Whether an earlier build was taken from the cache.
    pub fn cached(&self) -> bool {
        self.cached
    }

    /// Replays the pins and dumps every signal of the core.
    ///
    /// An old dump is deleted first. The replay counts only if the bench says that it came to the
    /// end of the file after exactly `clocks` lines, and left a dump.
    ///
    /// # Errors
    /// If the simulator fails, takes too long, or one of these is missing.
    pub fn replay(&self, plan: &ReplayPlan) -> Result<Replay, ToolError> {
        let dump = std::path::absolute(&plan.dump).map_err(io(&plan.dump))?;
        let directory = dump.parent().unwrap_or(Path::new("/")).to_owned();
        std::fs::create_dir_all(&directory).map_err(io(&directory))?;
        remove(&dump)?;

        let mut arguments = Vec::new();
        if self.simulator == Simulator::Icarus && dump.extension().is_some_and(|e| e == "fst") {
            arguments.push(OsString::from("-fst"));
        }
        // By its bare name in its own directory: the bench holds a path of 1,023 bytes at most.
        let name = Path::new(dump.file_name().unwrap_or_default());
        arguments.push(plus_argument("dump", name));
        arguments.push(format!("+nonce={:016x}", plan.nonce).into());
        // Replays may run side by side: each has the log that its dump is named after.
        let label = name.with_extension("").to_string_lossy().into_owned();
        let place = (directory.as_path(), label);
        let run = self.start(&plan.stimulus, arguments, place, plan.timeout)?;
        self.demand_verdict(&run, plan.clocks)?;
        let size = std::fs::metadata(&dump).map_or(0, |m| m.len());
        if size == 0 {
            let expected = format!("a dump in {}", dump.display());
            return Err(run.no_verdict(self.simulator.name(), expected));
        }
        Ok(Replay {
            clocks: plan.clocks,
            dump,
            log: run.log,
            duration: run.duration,
        })
    }

    /// Replays the pins without a dump and measures the time.
    ///
    /// The bench has to print `hwgen: digest <8 hexadecimal digits>` of the outputs of the core. A
    /// simulator may leave out whatever nobody looks at: with the emitted bench, which looks at
    /// nothing, Verilator leaves out the whole core and is fast.
    ///
    /// # Errors
    /// As [`Built::replay`], and if there is no digest.
    pub fn measure_speed(
        &self,
        stimulus: &Path,
        clocks: usize,
        directory: &Path,
        timeout: Duration,
    ) -> Result<Speed, ToolError> {
        let directory = std::path::absolute(directory).map_err(io(directory))?;
        let arguments = vec![OsString::from("+bench")];
        let label = format!("{}-speed", self.simulator.name());
        let run = self.start(stimulus, arguments, (&directory, label), timeout)?;
        self.demand_verdict(&run, clocks)?;
        let digest = run
            .output
            .lines()
            .find_map(|line| line.strip_prefix("hwgen: digest "))
            .and_then(|digest| u32::from_str_radix(digest.trim_end(), 16).ok())
            .ok_or_else(|| run.no_verdict(self.simulator.name(), "a digest of the outputs"))?;
        let seconds = match self.simulator {
            Simulator::Icarus => run.duration.as_secs_f64(),
            Simulator::Verilator => verilator::seconds(&run.output, clocks)
                .ok_or_else(|| run.no_verdict(self.simulator.name(), "a time"))?,
        };
        Ok(Speed {
            clocks,
            seconds,
            digest,
        })
    }

    fn start(
        &self,
        stimulus: &Path,
        arguments: Vec<OsString>,
        (directory, label): (&Path, String),
        timeout: Duration,
    ) -> Result<Run, ToolError> {
        // By its bare name where it can be: some simulators refuse letters outside of ASCII.
        let stimulus = std::path::absolute(stimulus).map_err(io(stimulus))?;
        let stimulus = match stimulus.strip_prefix(directory) {
            Ok(name) => name.to_owned(),
            Err(_) => stimulus,
        };
        let mut all = Vec::new();
        if let Some(image) = &self.image {
            // -n: end, and don't ask, where a human would be asked.
            all.push(OsString::from("-n"));
            all.push(image.into());
        }
        all.push(plus_argument("stimulus", &stimulus));
        all.extend(arguments);
        run(&Invocation {
            tool: self.simulator.name().to_owned(),
            version: self.version.clone(),
            program: self.program.clone(),
            arguments: all,
            directory: directory.to_owned(),
            label,
            timeout,
        })
    }

    fn demand_verdict(&self, run: &Run, clocks: usize) -> Result<(), ToolError> {
        let verdict = format!("hwgen: replayed {clocks} clocks");
        let contract = run.output.lines().find_map(|line| {
            let rest = line.strip_prefix("hwgen: block ")?;
            let (instance, rest) = rest.split_once(": expected ")?;
            let (expected, found) = rest.split_once(", found ")?;
            Some(ToolError::Contract {
                instance: instance.to_owned(),
                expected: expected.to_owned(),
                found: found.to_owned(),
            })
        });
        if let Some(error) = contract {
            Err(error)
        } else if run.says(&verdict) {
            Ok(())
        } else {
            Err(run.no_verdict(self.simulator.name(), format!("`{verdict}`")))
        }
    }
}

fn plus_argument(name: &str, path: &Path) -> OsString {
    let mut argument = OsString::from(format!("+{name}="));
    argument.push(path);
    argument
}
