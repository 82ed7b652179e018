//! `hwgen synth`

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::Duration;

use clap::builder::RangedU64ValueParser;
use hwgen_gen::Source;
use hwgen_sim::tool::Toolbox;
use hwgen_spec::design::Design;
use hwgen_spec::device::{self, Device};
use hwgen_spec::options::{Budget, Options};
use serde_json::{Map, json};

use super::{Outcome, sites};
use crate::destination::{Destination, Precious};
use crate::failure::{Exit, Failure};
use crate::output::Output;
use crate::picture::floorplan::floorplan;
use crate::synth::board::{self, Board};
use crate::synth::{Plan, Synthesis, placed, shortages};

mod text;

const EXAMPLES: &str = "\
The core is placed and routed in a shell with three pins. A placement on ECP5 is routed for several
clocks, in search of the highest that it bears. Scripts, logs, netlist, places and reports are kept
in .cache/synth beside the bundle, and what is there already is not done again.

Examples:
  hwgen emit --weights w.json --device ecp5-85k
  hwgen synth build/<name>                             one placement, on the bundle's own device
  hwgen synth build/<name> --seeds 5 --freq 150        the median of five must reach 150 MHz
  hwgen synth build/<name> --device ecp5-45k --json
  hwgen synth build/<name> --floorplan places.svg
  hwgen synth build/<name> --board ulx3s-85f           a bitstream

Exit codes: 0 done, 1 if the core does not fit, the median misses --freq or no placement bears the
board's clock, 2 if the bundle was changed or is made for other devices, or the picture may not be
written there, 3 if a tool is missing, failed or ran out of time. Where one seed of several fails, the
others are told, and the code is that of the failure.";

/// More seeds than anybody waits for.
const MOST_SEEDS: u64 = 1000;

/// What `synth` takes.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Directory of the bundle
    #[arg(value_name = "DIR")]
    pub bundle: PathBuf,
    /// The device [default: the one that the bundle was made for]
    #[arg(long, value_name = "D")]
    pub device: Option<String>,
    /// Make a bitstream for a board; its clock is enough then
    #[arg(long, value_name = "B", conflicts_with = "device")]
    pub board: Option<String>,
    /// The clock that is enough [default: the highest where a placement is routed for several, else the
    /// family's usual one]
    #[arg(long, value_name = "MHZ", value_parser = clock)]
    pub freq: Option<f64>,
    /// How many placements, from seed 1 on
    #[arg(long, value_name = "N", default_value_t = 1,
          value_parser = RangedU64ValueParser::<u64>::new().range(1..=MOST_SEEDS))]
    pub seeds: u64,
    /// Draw where the first placement puts everything
    #[arg(long, value_name = "F.svg")]
    pub floorplan: Option<PathBuf>,
    /// Replace the picture if it is there already
    #[arg(long, requires = "floorplan")]
    pub force: bool,
    /// How many placements at once [default: one for each core of this machine]
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(1..=256))]
    pub jobs: Option<usize>,
    /// How long each run of a tool may take
    #[arg(long, value_name = "SECONDS", default_value_t = 3600,
          value_parser = clap::value_parser!(u64).range(1..=604_800))]
    pub timeout: u64,
}

fn clock(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(mhz) if (1.0..=2000.0).contains(&mhz) => Ok(mhz),
        _ => Err("a clock from 1 to 2000 MHz expected".into()),
    }
}

/// Synthesises, places and routes.
///
/// # Errors
/// If the bundle or the device is refused, or a tool gives no result.
pub fn run(args: &Args, output: &Output) -> Result<Outcome, Failure> {
    let source = Source::read(&args.bundle)?;
    let board = args.board.as_deref().map(board::find).transpose();
    let board =
        board.map_err(|error| Failure::input("board", format!("--{error}")).help(error.help()))?;
    let device = device_of(args, board, &source)?;
    let place = device.place.as_ref();
    if let (None, Some(option)) = (place, placing_option(args)) {
        return Err(unplaced(device, option));
    }
    let parent = match args.bundle.canonicalize() {
        Ok(real) => real.parent().map_or_else(|| real.clone(), Path::to_owned),
        Err(error) => return Err(Failure::io(&args.bundle, &error)),
    };
    let picture = args.floorplan.as_ref().map(|path| {
        let precious = Precious {
            bundle: Some(&args.bundle),
            inputs: &args.bundle.join("manifest.json"),
            force: args.force,
        };
        Destination::new(path, &precious)
    });
    let picture = picture
        .transpose()?
        .map(|path| Ok::<_, Failure>((path.begin()?, path)));
    let mut picture = picture.transpose()?;
    let seeds: Vec<u64> = (1..=args.seeds).collect();
    let toolbox = Toolbox::new(Path::new("."));
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let plan = Plan {
        bundle: &args.bundle,
        source: &source,
        device,
        place,
        board,
        goal_mhz: match (args.freq, board) {
            (Some(freq), Some(board)) => Some(freq.max(board.clock_mhz)),
            (freq, board) => freq.or(board.map(|board| board.clock_mhz)),
        },
        seeds: &seeds,
        toolbox: &toolbox,
        cache: &parent.join(".cache").join("synth"),
        timeout: Duration::from_secs(args.timeout),
        jobs: args.jobs.unwrap_or(cores),
    };
    let line = Mutex::new(output.progress());
    let mut synthesis = plan.run(&|progress| {
        let mut line = line.lock().expect("no thread panics");
        line.show(&progress.activity, progress.done, progress.total);
    })?;
    drop(line);
    let mut drawn = None;
    if let (Some((mut file, path)), Some(route), Some(place)) =
        (picture.take(), synthesis.routes.first(), place)
    {
        let design = &source.design;
        let cells = placed::read(&route.placed, place)?;
        let title = format!("{} on {}", design.name(), device.name);
        let layers = design.perceptron().layers();
        let layers: Vec<String> = layers.map(|layer| layer.quant.name.clone()).collect();
        file.write(floorplan(&title, &layers, &cells).as_bytes())?;
        file.keep()?;
        drawn = Some(path.path().display().to_string());
    }
    output.detail(&format!("all files in {}", synthesis.directory.display()));
    let speed = Speed::of(&synthesis, &source.design);
    let failed = synthesis.failed.take().map(|(seed, error)| {
        let mut failure = Failure::from(error);
        let others = if args.seeds == 1 {
            ""
        } else {
            "; the others are told"
        };
        failure.message = format!("seed {seed}: {}{others}", failure.message);
        if failure.code == "does-not-fit" {
            failure.code = "no-placement";
            failure = failure.help("others found room: a longer --interval gives every seed some");
        }
        failure
    });
    let verdict = judge(args, board, &source, device, &synthesis, speed.as_ref());
    let mut json = facts(&source.design, device, &synthesis, speed.as_ref());
    json.insert("floorplan".into(), json!(drawn));
    json.insert("board".into(), json!(args.board));
    let mut remarks = Vec::new();
    if let (Some(_), Some(verdict)) = (&failed, &verdict) {
        remarks.push(verdict.message.clone());
        json.insert("missed".into(), json!(verdict.message));
    }
    if !synthesis.uncounted.is_empty() {
        let kinds = synthesis.uncounted.iter();
        let kinds: Vec<String> = kinds.map(|(kind, n)| format!("{n} {kind}")).collect();
        let kinds = kinds.join(", ");
        remarks.push(format!("cells of unknown types are not counted: {kinds}"));
    }
    if let (Some(path), Some(board)) = (&synthesis.bitstream, board) {
        let (title, clock) = (&board.title, board.clock_mhz);
        let path = path.display();
        remarks.push(format!("bitstream for {title} at {clock} MHz in {path}"));
    }
    match (&args.floorplan, &drawn) {
        (Some(_), None) => remarks.push("nothing is placed, so no picture is drawn".to_owned()),
        (_, Some(path)) => remarks.push(format!("picture in {path}")),
        (None, None) => {}
    }
    Ok(Outcome {
        text: text::text(&source.design, device, &synthesis, speed.as_ref()),
        json,
        remarks,
        failure: failed.or(verdict),
    })
}

/// The device that is asked for, or the bundle's.
fn device_of(
    args: &Args,
    board: Option<&Board>,
    source: &Source,
) -> Result<&'static Device, Failure> {
    let own = source.design.device();
    let device = match board.map(|board| &board.device).or(args.device.as_ref()) {
        Some(name) => device::find(name)
            .map_err(|error| Failure::input("device", format!("--{error}")).help(error.help()))?,
        None => own,
    };
    if own.name != device::GENERIC && own.family != device.family {
        let message = format!(
            "--{}: one of the family of {}, which the bundle is made for, expected, {} found",
            board.map_or("device", |_| "board"),
            own.name,
            device.name
        );
        return Err(Failure::input("device", message)
            .help(format!("emit it with --device {}", device.name)));
    }
    if device.name == device::GENERIC {
        let known = device::all().iter().filter(|d| d.name != device::GENERIC);
        let known: Vec<&str> = known.map(|device| device.name.as_str()).collect();
        let message = format!("--device: a real one expected, `{}` found", device.name);
        return Err(Failure::input("device", message).help(format!("one of {}", known.join(", "))));
    }
    Ok(device)
}

/// An option that asks for a placement, if one is given.
fn placing_option(args: &Args) -> Option<&'static str> {
    let options = [
        ("--board", args.board.is_some()),
        ("--freq", args.freq.is_some()),
        ("--seeds", args.seeds != 1),
        ("--floorplan", args.floorplan.is_some()),
    ];
    options
        .iter()
        .find(|(_, given)| *given)
        .map(|(name, _)| *name)
}

fn unplaced(device: &Device, option: &str) -> Failure {
    let placed = device::all().iter().filter(|device| device.place.is_some());
    let placed: Vec<&str> = placed.map(|device| device.name.as_str()).collect();
    let message = format!(
        "{option}: a device that open tools place and route on expected, `{}` found",
        device.name
    );
    Failure::input("device", message).help(format!(
        "leave it out, for Yosys alone, or take one of {}",
        placed.join(", ")
    ))
}

/// What the placements come to.
#[derive(Clone, Copy, Debug)]
struct Speed {
    min_mhz: f64,
    median_mhz: f64,
    max_mhz: f64,
    /// At the median clock.
    latency_ns: f64,
    /// At the median clock.
    per_second: f64,
}

impl Speed {
    fn of(synthesis: &Synthesis, design: &Design) -> Option<Self> {
        let mut clocks: Vec<f64> = synthesis.routes.iter().map(|r| r.fmax_mhz).collect();
        clocks.sort_by(f64::total_cmp);
        let (min_mhz, max_mhz) = (*clocks.first()?, *clocks.last()?);
        let half = clocks.len() / 2;
        let median_mhz = if clocks.len() % 2 == 1 {
            clocks[half]
        } else {
            (clocks[half - 1] + clocks[half]) / 2.0
        };
        Some(Self {
            min_mhz,
            median_mhz,
            max_mhz,
            latency_ns: design.latency_cycles() as f64 * 1e3 / median_mhz,
            per_second: median_mhz * 1e6 / design.interval_cycles() as f64,
        })
    }
}

/// Why it is no success, if it isn't.
fn judge(
    args: &Args,
    board: Option<&Board>,
    source: &Source,
    device: &Device,
    synthesis: &Synthesis,
    speed: Option<&Speed>,
) -> Option<Failure> {
    let short = shortages(synthesis.netlist, device);
    if !short.is_empty() {
        let words = sites::in_words(&short);
        let message = format!("does not fit on {}: {words}", device.name);
        return Some(
            Failure::new(Exit::Difference, "does-not-fit", message).help(smaller(source, device)),
        );
    }
    let speed = speed?;
    if let Some(board) = board.filter(|board| speed.max_mhz < board.clock_mhz) {
        let message = format!(
            "the clock of {}, {} MHz, expected, {:.1} MHz reached: no bitstream",
            board.title, board.clock_mhz, speed.max_mhz
        );
        return Some(
            Failure::new(Exit::Difference, "too-slow", message)
                .help("a longer --interval takes fewer cells"),
        );
    }
    let wanted = args.freq?;
    (speed.median_mhz < wanted).then(|| {
        let message = format!(
            "a clock of {wanted} MHz expected, {:.1} MHz reached (median of {})",
            speed.median_mhz,
            synthesis.routes.len()
        );
        Failure::new(Exit::Difference, "too-slow", message)
            .help("the critical path is told above; a longer --interval takes fewer cells")
    })
}

/// The nearest design that has room, as far as multipliers are what is short.
fn smaller(source: &Source, device: &Device) -> String {
    let options = Options {
        device: Some(device.name.clone()),
        budget: Budget::Device,
        ..source.design.options().clone()
    };
    match Design::new(&source.net, &options) {
        Ok(design) if design.interval_cycles() > source.design.interval_cycles() => format!(
            "emit it with --device {}: {} multipliers and a frame every {} clocks",
            device.name,
            design
                .perceptron()
                .layers()
                .map(|l| l.all_blocks(device))
                .sum::<usize>(),
            design.interval_cycles()
        ),
        _ => "emit it with a longer --interval or fewer bits, or take a larger device".into(),
    }
}

/// Everything for programs.
fn facts(
    design: &Design,
    device: &Device,
    synthesis: &Synthesis,
    speed: Option<&Speed>,
) -> Map<String, serde_json::Value> {
    let routes = &synthesis.routes;
    let cells = routes
        .first()
        .map_or(synthesis.netlist, |route| route.cells);
    let fmax = speed.map(|speed| {
        json!({
            "min": speed.min_mhz,
            "median": speed.median_mhz,
            "max": speed.max_mhz,
            "per_seed": routes.iter().map(|r| json!({"seed": r.seed, "mhz": r.fmax_mhz, "sought_mhz": r.sought_mhz})).collect::<Vec<_>>(),
        })
    });
    let object = json!({
        "design": design.name(),
        "device": device.name,
        "tools": synthesis.tools,
        "fits": synthesis.fits(device),
        "cells": cells,
        "available": routes.first().map(|route| route.available),
        "netlist": synthesis.netlist,
        "parts": synthesis.parts,
        "uncounted": synthesis.uncounted,
        "fmax_mhz": fmax,
        "latency_cycles": design.latency_cycles(),
        "interval_cycles": design.interval_cycles(),
        "latency_ns": speed.map(|speed| speed.latency_ns),
        "inferences_per_second": speed.map(|speed| speed.per_second),
        "share_of_limit": speed.and_then(|speed| text::share_of_limit(design, device, speed)),
        "critical_paths": routes.iter().map(|r| &r.critical_path).collect::<Vec<_>>(),
        "bitstream": synthesis.bitstream.as_ref().map(|path| path.display().to_string()),
        "directory": synthesis.directory.display().to_string(),
    });
    match object {
        serde_json::Value::Object(map) => map,
        _ => unreachable!("an object was written"),
    }
}
