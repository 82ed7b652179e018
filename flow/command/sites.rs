//! Sites of a device, in words.

use hwgen_spec::device::{Device, Sites};

use crate::layout::{columns, row};
use crate::synth::netlist::Part;

type Count = fn(&Sites) -> u64;

fn kinds(device: &Device) -> [(String, Count); 4] {
    [
        (device.lut_name(), |sites| sites.lut4),
        ("flip-flops".into(), |sites| sites.ff),
        ("multipliers".into(), |sites| sites.multipliers),
        ("block memories".into(), |sites| sites.block_rams),
    ]
}

/// A line for each layer, and for what stands beside them.
pub(super) fn by_part(title: &str, device: &Device, parts: &[Part]) -> String {
    let mut sums: Vec<(&str, Sites)> = Vec::new();
    for part in parts {
        match sums.last_mut() {
            Some((name, sum)) if *name == part.name => *sum += part.sites,
            _ => sums.push((&part.name, part.sites)),
        }
    }
    let all = sums
        .iter()
        .fold(Sites::default(), |sum, (_, sites)| sum + *sites);
    sums.push(("all", all));
    let [(lut, _), (ff, _), (multipliers, _), (memories, _)] = kinds(device);
    let mut rows = vec![row![title, lut, ff, multipliers, memories]];
    rows.extend(
        sums.iter()
            .map(|(name, s)| row![name, s.lut4, s.ff, s.multipliers, s.block_rams]),
    );
    columns("lrrrr", &rows)
}

/// What is taken of what is there.
pub(super) fn of_device(title: &str, device: &Device, cells: &Sites, available: &Sites) -> String {
    let mut rows = vec![row![title, "taken", "there", "%"]];
    for (kind, of) in kinds(device) {
        let (taken, there) = (of(cells), of(available));
        let share = 100.0 * taken as f64 / there.max(1) as f64;
        rows.push(row![kind, taken, there, format!("{share:.0}")]);
    }
    columns("lrrr", &rows)
}

/// Kinds of which there are too few: taken, and there.
pub(super) fn in_words(short: &[(String, u64, u64)]) -> String {
    let words = short.iter().map(|(kind, taken, there)| {
        format!("{} {kind} too few ({taken} of {there})", taken - there)
    });
    words.collect::<Vec<_>>().join(", ")
}
