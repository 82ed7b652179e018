//! What became of a core on a device, in words.

use std::fmt::Write;

use hwgen_spec::design::Design;
use hwgen_spec::device::Device;

use super::super::sites;
use super::Speed;
use crate::layout::{columns, counted, row};
use crate::synth::Synthesis;

/// Useful multiplications a second, of those that the device's multipliers could do alone.
///
/// None where the device has no multipliers.
pub(super) fn share_of_limit(design: &Design, device: &Device, speed: &Speed) -> Option<f64> {
    let there = device.multipliers.filter(|there| *there > 0)?;
    let limit = f64::from(there) * device.place.as_ref()?.multiplier_mhz * 1e6;
    Some(design.macs() as f64 * speed.per_second / limit)
}

pub(super) fn text(
    design: &Design,
    device: &Device,
    synthesis: &Synthesis,
    speed: Option<&Speed>,
) -> String {
    let tools: Vec<String> = synthesis
        .tools
        .iter()
        .map(|tool| format!("{} {}", tool.name, tool.version))
        .collect();
    let mut text = format!(
        "{} on {} ({})\n\n",
        design.name(),
        device.name,
        tools.join(", ")
    );
    text.push_str(&sites::by_part("netlist", device, &synthesis.parts));
    if let Some(route) = synthesis.routes.first() {
        text.push('\n');
        text.push_str(&sites::of_device(
            "placed",
            device,
            &route.cells,
            &route.available,
        ));
    }
    let mut rows = vec![row![
        "seed",
        "MHz",
        "slowest path, ns",
        "logic",
        "routing",
        "through"
    ]];
    rows.extend(synthesis.routes.iter().map(|route| {
        let path = &route.critical_path;
        row![
            route.seed,
            format!("{:.1}", route.fmax_mhz),
            format!("{:.2}", path.logic_ns + path.routing_ns),
            format!("{:.2}", path.logic_ns),
            format!("{:.2}", path.routing_ns),
            path.through.join(" > ")
        ]
    }));
    if let Some(speed) = speed {
        text.push('\n');
        text.push_str(&columns("rrrrrl", &rows));
        let _ = write!(
            text,
            "\nclock of {}: {:.1} MHz at least, {:.1} in the median, {:.1} at most\n\
             at the median: latency {:.0} ns ({}), {:.2} million frames a second (one every {})\n",
            counted(synthesis.routes.len(), "placement"),
            speed.min_mhz,
            speed.median_mhz,
            speed.max_mhz,
            speed.latency_ns,
            counted(design.latency_cycles(), "clock"),
            speed.per_second / 1e6,
            counted(design.interval_cycles(), "clock"),
        );
        if let (Some(share), Some(place)) = (share_of_limit(design, device, speed), &device.place) {
            let _ = writeln!(
                text,
                "that is {:.1} % of what {} multipliers could do at {} MHz",
                100.0 * share,
                device.multipliers.unwrap_or(0),
                place.multiplier_mhz,
            );
        }
    }
    if device.place.is_none() {
        let _ = writeln!(
            text,
            "\nnot placed: no open tool does so on {}; scripts of the vendor's own are in syn/",
            device.name
        );
    }
    text
}
