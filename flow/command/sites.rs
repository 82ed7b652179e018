//! Sites of a device, in words.

use hwgen_spec::device::Sites;

use crate::layout::{columns, row};
use crate::synth::netlist::Part;

type Count = fn(&Sites) -> u64;

const KINDS: [(&str, Count); 4] = [
    ("LUT4", |sites| sites.lut4),
    ("flip-flops", |sites| sites.ff),
    ("multipliers", |sites| sites.multipliers),
    ("block memories", |sites| sites.block_rams),
];

/// A line for each layer, and for what stands beside them.
pub(super) fn by_part(title: &str, parts: &[Part]) -> String {
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
    let mut rows = vec![row![title, KINDS[0].0, KINDS[1].0, KINDS[2].0, KINDS[3].0]];
    rows.extend(
        sums.iter()
            .map(|(name, s)| row![name, s.lut4, s.ff, s.multipliers, s.block_rams]),
    );
    columns("lrrrr", &rows)
}

/// What is taken of what is there.
pub(super) fn of_device(title: &str, cells: &Sites, available: &Sites) -> String {
    let mut rows = vec![row![title, "taken", "there", "%"]];
    for (kind, of) in KINDS {
        let (taken, there) = (of(cells), of(available));
        let share = 100.0 * taken as f64 / there.max(1) as f64;
        rows.push(row![kind, taken, there, format!("{share:.0}")]);
    }
    columns("lrrr", &rows)
}

/// Kinds of which there are too few: taken, and there.
pub(super) fn in_words(short: &[(&str, u64, u64)]) -> String {
    let words = short.iter().map(|(kind, taken, there)| {
        format!("{} {kind} too few ({taken} of {there})", taken - there)
    });
    words.collect::<Vec<_>>().join(", ")
}
