//! Synthesis by Yosys, place and route by nextpnr: what a core takes of a device, and how fast it is.
//!
//! The core stands in a shell of its own (`hwgen_gen::shell`), so that every path that is timed
//! begins and ends in the design or at a register beside it. All that the tools read and write
//! stays in one directory, named by a digest of everything that the result depends on: what is there
//! already is not done again.

pub mod board;
pub mod climb;
pub mod floorplan;
pub mod netlist;
mod pack;
mod place;
pub mod placed;
pub mod route;

use std::collections::BTreeMap;
use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use hwgen_gen::{Source, sha256, shell};
use hwgen_sim::error::ToolError;
use hwgen_sim::tool::{self, FoundTool, Invocation, Toolbox, YOSYS};
use hwgen_spec::device::{Device, Place, Sites};
use serde::Serialize;

use board::Board;
use netlist::Part;
use place::{NETLIST, Placer};
use route::Route;

/// A core to be synthesised, placed and routed.
#[derive(Debug)]
pub struct Plan<'a> {
    /// The bundle's directory.
    pub bundle: &'a Path,
    /// The bundle.
    pub source: &'a Source,
    /// The device.
    pub device: &'a Device,
    /// How it is placed, if open tools can.
    pub place: Option<&'a Place>,
    /// The board that a bitstream is made for, of the fastest placement that bears its clock.
    pub board: Option<&'a Board>,
    /// The clock that is enough; without one, the highest is sought where a placement is routed for several,
    /// else the family's usual one.
    ///
    /// # Units
    /// MHz
    pub goal_mhz: Option<f64>,
    /// Seeds of the placements.
    pub seeds: &'a [u64],
    /// Where tools are found.
    pub toolbox: &'a Toolbox,
    /// Where results are kept, a directory below it for each.
    pub cache: &'a Path,
    /// How long each run of a tool may take.
    pub timeout: Duration,
    /// How many placements run at once.
    pub jobs: usize,
}

/// What came of it.
#[derive(Debug)]
pub struct Synthesis {
    /// The tools, with their versions.
    pub tools: Vec<ToolVersion>,
    /// Where scripts, logs and reports are.
    pub directory: PathBuf,
    /// What the parts of the core take, by the netlist.
    pub parts: Vec<Part>,
    /// What they take together.
    pub netlist: Sites,
    /// Cells of the netlist of which it is not known what they take, by type.
    pub uncounted: BTreeMap<String, usize>,
    /// The placements, in the order of the seeds; none if the netlist is larger than the device, or no
    /// open tool places on it.
    pub routes: Vec<Route>,
    /// The bitstream, if it is for a board.
    pub bitstream: Option<PathBuf>,
    /// Why a placement is missing, or the bitstream: the first failure, with its seed.
    pub failed: Option<(u64, SynthError)>,
}

/// A tool that was used.
#[derive(Clone, Debug, Serialize)]
pub struct ToolVersion {
    /// Its name.
    pub name: String,
    /// Its version; empty if it prints none.
    pub version: String,
}

/// Why there is no result.
#[derive(Debug, thiserror::Error)]
pub enum SynthError {
    /// A tool.
    #[error(transparent)]
    Tool(#[from] ToolError),
    /// A file.
    #[error("{}: {source}", path.display())]
    Io {
        /// Which.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// The placer found no room for every cell.
    #[error("no room for every cell: {taken}")]
    NoRoom {
        /// What the core takes of what is there.
        taken: String,
    },
    /// The router came to no end at any clock.
    #[error("no routes for seed {seed}: the router came to no end at any clock, see {}", directory.display())]
    NoRoutes {
        /// The placement's.
        seed: u64,
        /// Where its logs are.
        directory: PathBuf,
    },
    /// A tool wrote something else than it should.
    #[error("{}: {expected} expected, {found} found", path.display())]
    Strange {
        /// The file.
        path: PathBuf,
        /// What should be there.
        expected: String,
        /// What is.
        found: String,
    },
}

/// What is under way: of so many steps, so many are done.
#[derive(Clone, Debug)]
pub struct Progress {
    /// What is being done.
    pub activity: String,
    /// Steps that are done.
    pub done: usize,
    /// All steps.
    pub total: usize,
}

impl Synthesis {
    /// Whether the netlist has room on a device.
    pub fn fits(&self, device: &Device) -> bool {
        shortages(self.netlist, device).is_empty()
    }
}

/// What a netlist takes more of than a device has: kind, number taken, number there.
pub fn shortages(netlist: Sites, device: &Device) -> Vec<(String, u64, u64)> {
    let kinds = [
        (device.lut_name(), netlist.lut4, device.lut4),
        ("flip-flops".into(), netlist.ff, device.flip_flops),
        (
            "multipliers".into(),
            netlist.multipliers,
            device.multipliers,
        ),
        (
            "block memories".into(),
            netlist.block_rams,
            device.block_rams,
        ),
    ];
    kinds
        .into_iter()
        .filter_map(|(kind, taken, there)| Some((kind, taken, u64::from(there?))))
        .filter(|(_, taken, there)| taken > there)
        .collect()
}

impl Plan<'_> {
    /// Runs the tools, as far as their results are not there already.
    ///
    /// # Errors
    /// If a tool is missing, fails, takes too long or writes what cannot be read.
    pub fn run(&self, progress: &(dyn Fn(Progress) + Sync)) -> Result<Synthesis, SynthError> {
        let yosys = self.toolbox.find(&YOSYS)?;
        let placer = self
            .place
            .map(|place| Placer::new(place, self.board, self.toolbox, self.timeout));
        let placer = placer.transpose()?;
        let total = 1 + placer.as_ref().map_or(0, |_| self.seeds.len());
        let shell = shell(&self.source.design, &self.source.manifest.digest);
        let script = self.script();
        let mut key = vec![
            yosys.version.to_string(),
            shell.text.clone(),
            script.clone(),
        ];
        let mut files = vec![("shell.v", shell.text.as_str()), ("synth.ys", &script)];
        if let Some(placer) = &placer {
            key.extend(placer.key());
            key.push(floorplan::RULE.to_owned());
            files.push((placer.pins_file, &placer.pins));
        }
        let directory = self.cache.join(&self.key(&key)[..16]);
        let _lock = lock(&directory, || {
            progress(Progress {
                activity: format!("waiting for another run in {}", directory.display()),
                done: 0,
                total,
            });
        })?;
        self.lay_out(&directory, &files)?;
        progress(Progress {
            activity: format!("Yosys {}", yosys.version),
            done: 0,
            total,
        });
        let netlist_path = directory.join(NETLIST);
        if !netlist_path.exists() {
            self.synthesize(&yosys, &directory)?;
        }
        let (parts, uncounted) = netlist::parts(&netlist_path, &self.device.synthesis)?;
        let tools = [&yosys]
            .into_iter()
            .chain(placer.as_ref().map(|p| &p.nextpnr))
            .chain(placer.as_ref().and_then(|p| Some(&p.packer.as_ref()?.tool)));
        let mut synthesis = Synthesis {
            tools: tools
                .map(|tool| ToolVersion {
                    name: tool.name.clone(),
                    version: tool.version.to_string(),
                })
                .collect(),
            directory: directory.clone(),
            netlist: parts
                .iter()
                .fold(Sites::default(), |sum, part| sum + part.sites),
            parts,
            uncounted,
            routes: Vec::new(),
            bitstream: None,
            failed: None,
        };
        if let Some(placer) = placer.filter(|_| synthesis.fits(self.device)) {
            let found = self.place_all(&placer, &directory, progress);
            for (seed, route) in self.seeds.iter().zip(found) {
                match route {
                    Ok(route) => synthesis.routes.push(route),
                    // What other placements came to is told all the same, if there are any.
                    Err(error) => synthesis.failed = synthesis.failed.or(Some((*seed, error))),
                }
            }
            if let (true, Some(_)) = (synthesis.routes.is_empty(), &synthesis.failed) {
                return Err(synthesis.failed.expect("a failure").1);
            }
            let routes = synthesis.routes.iter();
            let best = routes.max_by(|a, b| a.fmax_mhz.total_cmp(&b.fmax_mhz));
            let enough = |route: &&Route| {
                let board = self.board;
                board.is_some_and(|board| route.fmax_mhz >= board.clock_mhz)
            };
            if let (Some(packer), Some(best)) = (&placer.packer, best.filter(enough)) {
                let made = best.configuration.as_deref().map(|from| packer.pack(from));
                match made.transpose() {
                    Ok(bitstream) => synthesis.bitstream = bitstream,
                    Err(error) => synthesis.failed = synthesis.failed.or(Some((best.seed, error))),
                }
            }
            if placer.place.sites.ff.is_none() {
                for route in &mut synthesis.routes {
                    route.cells.ff = synthesis.netlist.ff;
                    route.available.ff = route.available.lut4;
                }
            }
        }
        Ok(synthesis)
    }

    /// Digest of all that the result depends on.
    fn key(&self, texts: &[String]) -> String {
        let files = self.sources().map(|file| file.sha256.as_str());
        let all: Vec<&str> = files.chain(texts.iter().map(String::as_str)).collect();
        sha256(&all.join("\n"))
    }

    /// What synthesis reads of the bundle.
    fn sources(&self) -> impl Iterator<Item = &hwgen_gen::ManifestFile> {
        let boxes = self.device.synthesis.library.is_none();
        let models = self.files("sim/").filter(move |_| boxes);
        self.files("rtl/").chain(models)
    }

    fn files(&self, below: &str) -> impl Iterator<Item = &hwgen_gen::ManifestFile> {
        let files = self.source.manifest.files.iter();
        files.filter(move |file| file.path.starts_with(below))
    }

    /// What Yosys is to do; paths are those in the directory of results.
    fn script(&self) -> String {
        let mut script = String::new();
        let synthesis = &self.device.synthesis;
        for file in synthesis.black_boxes(self.files("sim/").map(|file| file.path.as_str())) {
            script.push_str(&format!("read_verilog -lib {file}\n"));
        }
        for file in self.files("rtl/") {
            script.push_str(&format!("read_verilog {}\n", file.path));
        }
        let top = format!("{}_shell", self.source.design.name());
        script.push_str(&format!(
            "read_verilog shell.v\n{} -top {top}\n",
            synthesis.command
        ));
        for command in &synthesis.after {
            script.push_str(&format!("{command}\n"));
        }
        script.push_str("write_json netlist.part.json\nstat\n");
        script
    }

    /// Puts what the tools read into the directory.
    fn lay_out(&self, directory: &Path, files: &[(&str, &str)]) -> Result<(), SynthError> {
        for folder in ["rtl", "sim"].map(|folder| directory.join(folder)) {
            fs::create_dir_all(&folder).map_err(io(&folder))?;
        }
        for file in self.sources() {
            let (from, to) = (self.bundle.join(&file.path), directory.join(&file.path));
            fs::copy(&from, &to).map_err(io(&from))?;
        }
        for (name, text) in files {
            let path = directory.join(name);
            fs::write(&path, text).map_err(io(&path))?;
        }
        Ok(())
    }

    fn synthesize(&self, yosys: &FoundTool, directory: &Path) -> Result<(), SynthError> {
        let part = directory.join("netlist.part.json");
        if part.exists() {
            fs::remove_file(&part).map_err(io(&part))?;
        }
        let arguments = ["-q", "-l", "yosys.txt", "-s", "synth.ys"];
        let run = tool::run(&Invocation {
            tool: yosys.name.clone(),
            version: yosys.version.to_string(),
            program: yosys.path.clone(),
            arguments: arguments.map(Into::into).to_vec(),
            directory: directory.to_owned(),
            label: "yosys".into(),
            timeout: self.timeout,
        })?;
        if !part.exists() {
            return Err(run.no_verdict(&yosys.name, "a netlist").into());
        }
        floorplan::lay_out(&part, self.source.design.perceptron(), self.device)?;
        fs::rename(&part, directory.join(NETLIST)).map_err(io(&part))
    }

    /// Places and routes with every seed, some at once.
    fn place_all(
        &self,
        placer: &Placer<'_>,
        directory: &Path,
        progress: &(dyn Fn(Progress) + Sync),
    ) -> Vec<Result<Route, SynthError>> {
        let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let found: Mutex<Vec<(usize, Result<Route, SynthError>)>> = Mutex::new(Vec::new());
        let work = || {
            loop {
                let at = next.fetch_add(1, Ordering::SeqCst);
                let Some(seed) = self.seeds.get(at) else {
                    break;
                };
                let doing = |what: String| {
                    progress(Progress {
                        activity: format!("nextpnr {}, {what}", placer.nextpnr.version),
                        done: 1 + done.load(Ordering::SeqCst),
                        total: 1 + self.seeds.len(),
                    });
                };
                let route = placer.run(directory, *seed, self.goal_mhz, &doing);
                done.fetch_add(1, Ordering::SeqCst);
                found.lock().expect("no thread panics").push((at, route));
            }
        };
        std::thread::scope(|scope| {
            for _ in 0..self.jobs.clamp(1, self.seeds.len()) {
                scope.spawn(work);
            }
        });
        let mut found = found.into_inner().expect("no thread panics");
        found.sort_by_key(|(at, _)| *at);
        found.into_iter().map(|(_, route)| route).collect()
    }
}

/// Makes the directory, and keeps others out of it for as long as the lock lives.
fn lock(directory: &Path, wait: impl FnOnce()) -> Result<File, SynthError> {
    fs::create_dir_all(directory).map_err(io(directory))?;
    let path = directory.join("lock");
    let file = File::create(&path).map_err(io(&path))?;
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => {
            wait();
            file.lock().map_err(io(&path))?;
        }
        tried => tried.map_err(|error| io(&path)(error.into()))?,
    }
    Ok(file)
}

/// Names the file in an error.
pub(crate) fn io(path: &Path) -> impl FnOnce(std::io::Error) -> SynthError + '_ {
    move |source| SynthError::Io {
        path: path.to_owned(),
        source,
    }
}
