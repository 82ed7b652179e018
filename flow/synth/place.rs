//! Places a netlist, and routes what is placed for the highest clock that it bears.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use hwgen_sim::error::ToolError;
use hwgen_sim::tool::{
    self, FoundTool, Invocation, NEXTPNR_ECP5, NEXTPNR_GOWIN, NEXTPNR_ICE40, NEXTPNR_NEXUS, Run,
    Tool, Toolbox,
};
use hwgen_spec::device::{Place, PlaceTool};

use super::board::Board;
use super::climb::Climb;
use super::pack::Packer;
use super::route::Route;
use super::{SynthError, io};

/// The program that places and routes on a device.
#[derive(Debug)]
pub(super) struct Placer<'a> {
    pub nextpnr: FoundTool,
    pub place: &'a Place,
    /// The file of pins, the options that name it, and what is in it; pins that are not may be anywhere.
    pub pins_file: &'static str,
    pin_options: &'static [&'static str],
    pub pins: String,
    /// How long each run may take.
    timeout: Duration,
    /// What makes bitstreams, if it is for a board.
    pub packer: Option<Packer>,
}

/// A placement to be routed.
struct Placement<'a> {
    placer: &'a Placer<'a>,
    directory: &'a Path,
    seed: u64,
}

/// What is placed.
pub(super) const NETLIST: &str = "netlist.json";

/// What a placement is called.
fn placed(seed: u64) -> String {
    format!("seed-{seed}.placed.json")
}

impl<'a> Placer<'a> {
    /// Finds the program.
    ///
    /// # Errors
    /// If it is not there.
    pub fn new(
        place: &'a Place,
        board: Option<&Board>,
        toolbox: &Toolbox,
        timeout: Duration,
    ) -> Result<Self, ToolError> {
        let pins: Vec<&String> = match board {
            Some(Board { pins, .. }) => vec![&pins.clk_i, &pins.bit_i, &pins.bit_o],
            None => [&place.clock_pin]
                .into_iter()
                .chain(&place.other_pins)
                .collect(),
        };
        let ports = || ["clk_i", "bit_i", "bit_o"].into_iter().zip(&pins);
        let (tool, pins_file, pin_options, pins): (&'static Tool, _, &'static [_], _) =
            match place.tool {
                PlaceTool::Ecp5 => (
                    &NEXTPNR_ECP5,
                    "pins.lpf",
                    &["--lpf", "pins.lpf", "--lpf-allow-unconstrained"],
                    ports()
                        .map(|(port, pin)| {
                            format!(
                                "LOCATE COMP \"{port}\" SITE \"{pin}\";\n\
                             IOBUF PORT \"{port}\" IO_TYPE=LVCMOS33;\n"
                            )
                        })
                        .collect(),
                ),
                PlaceTool::Ice40 => (
                    &NEXTPNR_ICE40,
                    "pins.pcf",
                    &["--pcf", "pins.pcf", "--pcf-allow-unconstrained"],
                    ports()
                        .map(|(port, pin)| format!("set_io {port} {pin}\n"))
                        .collect(),
                ),
                PlaceTool::Nexus => (
                    &NEXTPNR_NEXUS,
                    "pins.pdc",
                    &["--pdc", "pins.pdc"],
                    ports()
                        .map(|(port, pin)| {
                            format!(
                                "ldc_set_location -site {{{pin}}} [get_ports {port}]\n\
                             ldc_set_port -iobuf {{IO_TYPE=LVCMOS33}} [get_ports {port}]\n"
                            )
                        })
                        .collect(),
                ),
                PlaceTool::Gowin => (
                    &NEXTPNR_GOWIN,
                    "pins.cst",
                    &["--vopt", "cst=pins.cst"],
                    ports()
                        .map(|(port, pin)| format!("IO_LOC \"{port}\" {pin};\n"))
                        .collect(),
                ),
            };
        Ok(Self {
            nextpnr: toolbox.find(tool)?,
            place,
            pins_file,
            pin_options,
            pins,
            timeout,
            packer: board
                .map(|_| Packer::new(place.tool, toolbox, timeout))
                .transpose()?,
        })
    }

    /// All that placements and routes depend on but the netlist, the seed and the clock.
    pub fn key(&self) -> [String; 7] {
        [
            self.nextpnr.version.to_string(),
            self.pins.clone(),
            self.place.arguments.join(" "),
            self.place.sought_mhz.to_string(),
            format!("{:?}", self.place.most_rounds),
            self.place.multiplier_rows.concat().join(" "),
            self.packer.as_ref().map_or(String::new(), Packer::key),
        ]
    }

    /// Places the netlist of a directory and routes it: for a clock, or else for the highest one.
    ///
    /// # Errors
    /// If the program fails, takes too long or writes what cannot be read.
    pub fn run(
        &self,
        directory: &Path,
        seed: u64,
        goal: Option<f64>,
        doing: &dyn Fn(String),
    ) -> Result<Route, SynthError> {
        let placement = Placement {
            placer: self,
            directory,
            seed,
        };
        let first = goal.unwrap_or(self.place.sought_mhz);
        let Some(most_rounds) = self.place.most_rounds else {
            doing(format!("seed {seed}"));
            return placement.place_and_route(first);
        };
        doing(format!("seed {seed}, placing"));
        let mut climb = Climb::new(first, placement.place()?);
        let mut best: Option<Route> = None;
        while let Some(mhz) = climb.next() {
            doing(format!("seed {seed}, routing for {mhz} MHz"));
            let route = match placement.route(mhz, most_rounds) {
                // What was reached is told; a router that comes to no end may take any time.
                Err(SynthError::Tool(ToolError::TimedOut { .. })) if best.is_some() => None,
                route => route?,
            };
            let Some(route) = route else {
                climb.missed(mhz);
                continue;
            };
            climb.made(mhz, route.fmax_mhz);
            if best.as_ref().is_none_or(|b| b.fmax_mhz < route.fmax_mhz) {
                best = Some(route);
            }
            let reached = best.as_ref().map(|best| best.fmax_mhz);
            if reached
                .zip(goal)
                .is_some_and(|(reached, goal)| reached >= goal)
            {
                break;
            }
        }
        best.ok_or_else(|| SynthError::NoRoutes {
            seed,
            directory: directory.to_owned(),
        })
    }
}

impl Placement<'_> {
    /// Places, if that has not been done, and gives the clock that the placer expects, in MHz.
    fn place(&self) -> Result<Option<f64>, SynthError> {
        let label = format!("seed-{}", self.seed);
        let placed = placed(self.seed);
        if !self.directory.join(&placed).exists() {
            let sought = self.placer.place.sought_mhz.to_string();
            let (part, own) = (
                format!("{label}.part.json"),
                ["--freq", &sought, "--no-route"],
            );
            let own = [&own[..], &["--json", NETLIST, "--write", &part]].concat();
            self.forget(&part)?;
            let run = tool::run(&self.invocation(&label, &own));
            let run = run.map_err(|error| self.told(error))?;
            let part = self.written(&run, &part)?;
            forget_clock(&part)?;
            self.keep(&part, &placed)?;
        }
        let log = self.directory.join(format!("{label}.log"));
        Ok(fs::read_to_string(&log).ok().as_deref().and_then(promised))
    }

    /// Routes what is placed for a clock, if that has not been done; nothing if the router comes to no end.
    fn route(&self, mhz: f64, most_rounds: u32) -> Result<Option<Route>, SynthError> {
        let (label, report) = self.report(mhz);
        let late = self.directory.join(format!("{label}.late"));
        if late.exists() {
            return Ok(None);
        }
        if !self.directory.join(&report).exists() || !self.configured(&label) {
            let (placed, freq) = (placed(self.seed), mhz.to_string());
            let (part, own) = (format!("{label}.part.json"), ["--no-pack", "--no-place"]);
            let own = [
                &own[..],
                &["--json", &placed, "--freq", &freq, "--report", &part],
            ]
            .concat();
            let endless = |log: &Path| {
                let text = fs::read_to_string(log).unwrap_or_default();
                rounds(&text).is_some_and(|(rounds, late)| rounds > most_rounds && late > 0)
            };
            self.forget(&part)?;
            let run = tool::run_until(&self.routing(&label, &own), endless);
            let Some(run) = run.map_err(|error| self.told(error))? else {
                let log = self.directory.join(format!("{label}.log"));
                let text = fs::read_to_string(&log).map_err(io(&log))?;
                let (rounds, routes) = rounds(&text).unwrap_or_default();
                let text = format!("{routes} routes late after {rounds} rounds\n");
                fs::write(&late, text).map_err(io(&late))?;
                return Ok(None);
            };
            self.keep(&self.written(&run, &part)?, &report)?;
        }
        self.read(mhz, placed(self.seed)).map(Some)
    }

    /// Both at once, if that has not been done.
    fn place_and_route(&self, mhz: f64) -> Result<Route, SynthError> {
        let (label, report) = self.report(mhz);
        let placed = format!("{label}.placed.json");
        let whole = [&report, &placed]
            .into_iter()
            .all(|name| self.directory.join(name).exists());
        if !whole || !self.configured(&label) {
            let freq = mhz.to_string();
            let [report_part, placed_part] =
                ["part.json", "placed.part.json"].map(|end| format!("{label}.{end}"));
            let own = ["--json", NETLIST, "--freq", &freq];
            let own = [
                &own[..],
                &["--report", &report_part, "--write", &placed_part],
            ]
            .concat();
            self.forget(&report_part)?;
            self.forget(&placed_part)?;
            let run = tool::run(&self.routing(&label, &own));
            let run = run.map_err(|error| self.told(error))?;
            self.keep(&self.written(&run, &placed_part)?, &placed)?;
            self.keep(&self.written(&run, &report_part)?, &report)?;
        }
        self.read(mhz, placed)
    }

    /// What the files of a route are called: their stem, and the report.
    fn report(&self, mhz: f64) -> (String, String) {
        let label = format!("seed-{}-at-{mhz}-mhz", self.seed);
        let report = format!("{label}.json");
        (label, report)
    }

    fn read(&self, mhz: f64, placed: String) -> Result<Route, SynthError> {
        let report = self.directory.join(self.report(mhz).1);
        let mut route = Route::read(&report, self.seed, mhz, self.placer.place)?;
        route.placed = self.directory.join(placed);
        let configuration = self.configuration(&self.report(mhz).0);
        route.configuration = configuration.map(|name| self.directory.join(name));
        Ok(route)
    }

    /// What a bitstream will be made of, if it is for a board.
    fn configuration(&self, label: &str) -> Option<String> {
        let packer = self.placer.packer.as_ref()?;
        Some(packer.configuration(label))
    }

    /// Whether it is there, if it is asked for.
    fn configured(&self, label: &str) -> bool {
        let name = self.configuration(label);
        name.is_none_or(|name| self.directory.join(name).exists())
    }

    /// A run of the program that routes, which writes that, too.
    fn routing(&self, label: &str, own: &[&str]) -> Invocation {
        let name = self.configuration(label);
        let option = self.placer.packer.as_ref().map(|packer| packer.option);
        let configuration = option.into_iter().chain(name.as_deref());
        let own: Vec<&str> = own.iter().copied().chain(configuration).collect();
        self.invocation(label, &own)
    }

    /// Deletes what a run that was broken off may have left.
    fn forget(&self, name: &str) -> Result<(), SynthError> {
        let path = self.directory.join(name);
        match fs::remove_file(&path) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(io(&path)(error)),
            _ => Ok(()),
        }
    }

    /// A file that a run should have written.
    fn written(&self, run: &Run, name: &str) -> Result<PathBuf, SynthError> {
        let path = self.directory.join(name);
        if !path.exists() {
            return Err(run.no_verdict(&self.placer.nextpnr.name, name).into());
        }
        Ok(path)
    }

    /// Gives a file that is whole its name.
    fn keep(&self, part: &Path, name: &str) -> Result<(), SynthError> {
        fs::rename(part, self.directory.join(name)).map_err(io(part))
    }

    fn invocation(&self, label: &str, own: &[&str]) -> Invocation {
        let Placer {
            nextpnr,
            place,
            pin_options,
            timeout,
            ..
        } = self.placer;
        let seed = self.seed.to_string();
        let arguments = place.arguments.iter().map(String::as_str);
        let arguments = arguments.chain(pin_options.iter().copied());
        // A clock that is missed is our verdict to give, not a failure of the tool.
        let arguments = arguments.chain(["--seed", &seed, "--timing-allow-fail"]);
        Invocation {
            tool: nextpnr.name.clone(),
            version: nextpnr.version.to_string(),
            program: nextpnr.path.clone(),
            arguments: arguments
                .chain(own.iter().copied())
                .map(Into::into)
                .collect(),
            directory: self.directory.to_owned(),
            label: label.to_owned(),
            timeout: *timeout,
        }
    }

    /// Why the program failed: want of room, perhaps.
    fn told(&self, error: ToolError) -> SynthError {
        let text = match &error {
            ToolError::Failed { log, .. } => fs::read_to_string(log).ok(),
            _ => None,
        };
        let room = text.and_then(|text| no_room(&text, self.placer.place));
        room.unwrap_or(SynthError::Tool(error))
    }
}

/// Takes the clock that was sought out of a placement, for another one could not be asked for.
fn forget_clock(path: &Path) -> Result<(), SynthError> {
    let text = fs::read_to_string(path).map_err(io(path))?;
    let other = text
        .lines()
        .filter(|line| !line.trim_start().starts_with("\"target_freq\":"));
    let text: String = other.flat_map(|line| [line, "\n"]).collect();
    fs::write(path, text).map_err(io(path))
}

/// The clock that the placer expects of the routes, in MHz.
fn promised(log: &str) -> Option<f64> {
    let line = log
        .lines()
        .rev()
        .find(|line| line.contains("Max frequency for clock"))?;
    let (_, rest) = line.rsplit_once(": ")?;
    let mhz: f64 = rest.split_once(" MHz")?.0.parse().ok()?;
    Some(mhz.round().max(1.0))
}

/// How often late routes were torn up, and how many were late then.
fn rounds(log: &str) -> Option<(u32, u32)> {
    let line = log.lines().rev().find(|line| line.contains("tmgfail="))?;
    let number = |name: &str| {
        let (_, rest) = line.split_once(name)?;
        let end = rest.find(|c: char| !c.is_ascii_digit())?;
        rest[..end].parse().ok()
    };
    Some((number("iter=")?, number("tmgfail=")?))
}

/// Why a placement was given up, if its log says that there was no room: numbers of sites, and there may
/// be too few even where each number is below that of the device, as for chains of carries.
fn no_room(log: &str, place: &Place) -> Option<SynthError> {
    let given_up = [
        "Unable to place cell",
        "Unable to find legal placement",
        "Unable to find a placement",
        "Unable to find placement",
        "failed to place",
    ];
    if !given_up.iter().any(|words| log.contains(words)) {
        return None;
    }
    let names = [
        ("LUT4", place.sites.lut4.split('+').next()),
        ("flip-flops", place.sites.ff.as_deref()),
        ("multipliers", Some(place.sites.multipliers.as_str())),
        ("block memories", Some(place.sites.block_rams.as_str())),
    ];
    let taken = names.iter().filter_map(|(kind, name)| {
        let (_, counts) = log.split_once(&format!("{}:", (*name)?))?;
        let (used, rest) = counts.lines().next()?.split_once('/')?;
        let available = rest.split_whitespace().next()?;
        Some(format!("{} of {available} {kind}", used.trim()))
    });
    Some(SynthError::NoRoom {
        taken: taken.collect::<Vec<_>>().join(", "),
    })
}
