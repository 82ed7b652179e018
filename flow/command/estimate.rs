//! `hwgen estimate`

use hwgen_spec::device::{self, Device, Sites};
use serde_json::json;

use super::Outcome;
use super::emit::{describe, design_facts};
use super::request::Request;
use super::sites;
use crate::estimate;
use crate::failure::{Exit, Failure};
use crate::synth::shortages;

const EXAMPLES: &str = "\
Name a --device. Nothing is written and no tool is run. How far estimates were from what Yosys made of the same
designs is told in docs/measurements.md.

Examples:
  hwgen estimate --weights w.json --device ecp5-25k
  hwgen estimate --weights w.json --device ecp5-85k --interval 100 --json

Exit codes: 0 it should fit, 1 it will not, 2 if weights or options are refused.";

/// What `estimate` takes.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// What is asked about.
    #[command(flatten)]
    pub request: Request,
}

/// Tells what the design will take of its device.
///
/// # Errors
/// If weights or options are refused, or nothing is known of the device.
pub fn run(args: &Args) -> Result<Outcome, Failure> {
    let (net, design) = args.request.design()?;
    let device = design.device();
    if device.lut4.is_none() {
        return Err(nothing_known(device));
    }
    let bundle = hwgen_gen::generate(&design, &net);
    let parts = estimate::parts(&design, device);
    let cells = parts.iter().fold(Sites::default(), |sum, p| sum + p.sites);
    let short = shortages(cells, device);
    let mut json = design_facts(&bundle)?;
    let available = Sites {
        lut4: device.lut4.unwrap_or(0).into(),
        ff: device.flip_flops.unwrap_or(0).into(),
        multipliers: device.multipliers.unwrap_or(0).into(),
        block_rams: device.block_rams.unwrap_or(0).into(),
    };
    let clock = device.place.as_ref().map(|place| place.core_mhz);
    let (latency, interval) = (design.latency_cycles(), design.interval_cycles());
    let latency_ns = clock.map(|mhz| latency as f64 * 1e3 / mhz);
    let per_second = clock.map(|mhz| mhz * 1e6 / interval as f64);
    json.extend([
        ("device".to_owned(), json!(device.name)),
        ("fits".to_owned(), json!(short.is_empty())),
        ("cells".to_owned(), json!(cells)),
        ("available".to_owned(), json!(available)),
        ("parts".to_owned(), json!(parts)),
        ("clock_mhz".to_owned(), json!(clock)),
        ("latency_ns".to_owned(), json!(latency_ns)),
        ("inferences_per_second".to_owned(), json!(per_second)),
    ]);
    let speed = match (clock, latency_ns, per_second) {
        (Some(mhz), Some(ns), Some(rate)) => format!(
            "about {mhz:.0} MHz, as other cores on it: latency {ns:.0} ns ({latency} clocks), {rate:.0} frames a second"
        ),
        _ => format!("no clock: no open tool places on {}", device.name),
    };
    let text = format!(
        "{}\n{}\n{}\n{speed}\n",
        describe(&design, &bundle),
        sites::by_part("estimate", device, &parts),
        sites::of_device("estimate", device, &cells, &available)
    );
    let failure = (!short.is_empty()).then(|| {
        let words = sites::in_words(&short);
        let message = format!("will not fit on {}: {words}", device.name);
        Failure::new(Exit::Difference, "does-not-fit", message)
            .help("a longer --interval or fewer bits, or a larger device")
    });
    Ok(Outcome {
        text,
        json,
        failure,
        ..Outcome::default()
    })
}

fn nothing_known(device: &Device) -> Failure {
    let known = device::all().iter().filter(|device| device.lut4.is_some());
    let known: Vec<&str> = known.map(|device| device.name.as_str()).collect();
    let message = format!(
        "--device: one whose cells are known expected, `{}` found",
        device.name
    );
    Failure::input("device", message).help(format!("one of {}", known.join(", ")))
}
