//! Where the multipliers of a core stand on the device.
//!
//! A placer minds the wires as a whole, and settles blocks of which there are few and which stand
//! far apart, as multipliers do, with no regard to what belongs together. So they are laid out first,
//! in the order in which the data goes through them, and the placer builds the rest around them.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use hwgen_spec::design::{Layer, Perceptron};
use hwgen_spec::device::Device;
use serde_json::Value;

use super::{SynthError, io};

/// A name of what stands below: placements of another rule are other placements.
pub const RULE: &str = "multipliers in the order of the data, out and back, 4";

/// Names a site for each multiplier of a netlist, in its file.
///
/// # Errors
/// If the file cannot be read as a netlist, or written.
pub fn lay_out(path: &Path, stage: &Perceptron, device: &Device) -> Result<(), SynthError> {
    let rows = device.place.iter().flat_map(|place| &place.multiplier_rows);
    let rows: Vec<&[String]> = rows.map(Vec::as_slice).collect();
    if rows.is_empty() {
        return Ok(());
    }
    let text = fs::read(path).map_err(io(path))?;
    let strange = |found: String| SynthError::Strange {
        path: path.to_owned(),
        expected: "a netlist as Yosys writes it".into(),
        found,
    };
    let mut netlist: Value =
        serde_json::from_slice(&text).map_err(|error| strange(error.to_string()))?;
    let modules = netlist.get_mut("modules").and_then(Value::as_object_mut);
    let modules = modules.ok_or_else(|| strange("none with modules".into()))?;
    let is_multiplier = |cell: &Value| {
        let kind = cell["type"].as_str();
        let sites = kind.and_then(|kind| device.synthesis.cells.get(kind));
        sites.is_some_and(|sites| sites.multipliers > 0)
    };
    let mut multipliers: BTreeMap<String, &mut Value> = modules
        .values_mut()
        .filter_map(|module| module.get_mut("cells")?.as_object_mut())
        .flatten()
        .filter(|(_, cell)| is_multiplier(cell))
        .map(|(name, cell)| (name.clone(), cell))
        .collect();
    let names: Vec<&str> = multipliers.keys().map(String::as_str).collect();
    let strips = strips(stage, &names);
    let mut columns = columns(&rows, names.len()).into_iter();
    let mut placed: Vec<(String, &str)> = Vec::new();
    for strip in &strips {
        let sites = out_and_back(columns.by_ref().take(strip.names.len()), strip.leftwards);
        let names = strip.names.iter().map(|name| (*name).to_owned());
        placed.extend(names.zip(sites));
    }
    for (name, site) in placed {
        let cell = multipliers.get_mut(&name).expect("one of them");
        cell["attributes"]["BEL"] = Value::from(site);
    }
    let text = serde_json::to_vec(&netlist).expect("a value that was read");
    fs::write(path, text).map_err(io(path))
}

/// Multipliers that stand side by side, in the order of their data.
struct Strip<'a> {
    names: Vec<&'a str>,
    /// Whether the data begins at the right.
    leftwards: bool,
}

/// Half of the networks, the shared layers, the other half and what is of none: all begin towards the
/// middle, where the shared words come from.
fn strips<'a>(stage: &'a Perceptron, names: &[&'a str]) -> Vec<Strip<'a>> {
    let mut rest: BTreeSet<&str> = names.iter().copied().collect();
    let mut strip = |layers: &[Layer], leftwards: bool| {
        let own = layers.iter().flat_map(|layer| {
            let inside = format!("u_core.u_mlp.u_{}.", layer.quant.name);
            let own = names
                .iter()
                .filter_map(|name| Some((*name, name.strip_prefix(&inside)?.to_owned())));
            let mut own: Vec<(&str, String)> = own.collect();
            own.sort_by_cached_key(|(_, local)| (local.starts_with("g_act"), numbers(local)));
            own.into_iter().map(|(name, _)| name)
        });
        let names: Vec<&str> = own.collect();
        for name in &names {
            rest.remove(name);
        }
        Strip { names, leftwards }
    };
    let (front, back) = stage.networks.split_at(stage.networks.len() / 2);
    let mut all: Vec<Strip> = front.iter().map(|n| strip(&n.layers, true)).collect();
    all.push(strip(&stage.shared, false));
    all.extend(back.iter().map(|n| strip(&n.layers, false)));
    let names = rest.into_iter().collect();
    all.push(Strip {
        names,
        leftwards: false,
    });
    all
}

/// The numbers in a name: places in the hierarchy, in order.
fn numbers(name: &str) -> Vec<u64> {
    let digits = name.split(|c: char| !c.is_ascii_digit());
    digits.filter_map(|number| number.parse().ok()).collect()
}

/// A site, and where it is: column and row among those that are used.
type Site<'a> = (usize, usize, &'a str);

/// Sites for so many multipliers, column by column: of the rows in the middle, as many as it takes, the
/// same part of each.
fn columns<'a>(rows: &[&'a [String]], count: usize) -> Vec<Site<'a>> {
    let most = rows.iter().map(|row| row.len()).max().unwrap_or(0).max(1);
    let used = count.div_ceil(most).clamp(1, rows.len().max(1));
    let first = (rows.len() - used.min(rows.len())) / 2;
    let each = count.div_ceil(used);
    let mut all = Vec::new();
    for (y, row) in rows[first..].iter().take(used).enumerate() {
        let part = each.min(row.len());
        let left = (row.len() - part) / 2;
        let part = row[left..left + part].iter();
        all.extend(part.enumerate().map(|(x, site)| (x, y, site.as_str())));
    }
    all.sort_unstable();
    all
}

/// Columns that are filled row by row before the next ones: on two rows sixteen multipliers, about those of a
/// processing element, whose products are summed.
const BLOCK: usize = 8;

/// The sites of a strip in the order of its data: out along the lower half of the rows and back along the
/// others, so that it ends, too, where it began; on one row it only goes out.
fn out_and_back<'a>(sites: impl Iterator<Item = Site<'a>>, leftwards: bool) -> Vec<&'a str> {
    let mut sites: Vec<Site> = sites.collect();
    let first = sites.iter().map(|&(x, ..)| x).min().unwrap_or(0);
    let last = sites.iter().map(|&(x, ..)| x).max().unwrap_or(0);
    let rows = 1 + sites.iter().map(|&(_, y, _)| y).max().unwrap_or(0);
    let out = rows.div_ceil(2);
    sites.sort_by_key(|&(x, y, _)| {
        let back = y >= out;
        let along = if leftwards == back {
            x - first
        } else {
            last - x
        };
        let row = if back { y - out } else { y };
        // In a block there and back.
        let place = if row % 2 == 1 { last - along } else { along };
        (back, along / BLOCK, row, place)
    });
    sites.into_iter().map(|(_, _, site)| site).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(counts: &[usize]) -> Vec<Vec<String>> {
        let row = |(y, count): (usize, &usize)| (0..*count).map(|x| format!("{x}/{y}")).collect();
        counts.iter().enumerate().map(row).collect()
    }

    #[test]
    fn few_multipliers_stand_in_the_middle_and_many_everywhere() {
        let rows = rows(&[6, 6, 6]);
        let rows: Vec<&[String]> = rows.iter().map(Vec::as_slice).collect();
        let names = |count| {
            let all = columns(&rows, count).into_iter();
            all.take(count).map(|(_, _, site)| site).collect::<Vec<_>>()
        };
        assert_eq!(names(2), ["2/1", "3/1"]);
        assert_eq!(names(0), Vec::<&str>::new());
        assert_eq!(
            names(8),
            ["1/0", "1/1", "2/0", "2/1", "3/0", "3/1", "4/0", "4/1"]
        );
        assert_eq!(names(18).iter().collect::<BTreeSet<_>>().len(), 18);
        // A netlist that is too large is another's to refuse.
        assert_eq!(names(20).len(), 18);
    }

    #[test]
    fn a_strip_ends_where_it_began() {
        let rows = rows(&[10, 10, 10]);
        let rows: Vec<&[String]> = rows.iter().map(Vec::as_slice).collect();
        let sites = out_and_back(columns(&rows, 30).into_iter(), false);
        let row = |y: usize, xs: std::ops::Range<usize>| xs.map(move |x| format!("{x}/{y}"));
        let out = row(0, 0..8).chain(row(1, 0..8).rev());
        let out = out.chain(row(0, 8..10)).chain(row(1, 8..10).rev());
        let back = row(2, 0..10).rev();
        assert!(sites.iter().copied().eq(out.chain(back)), "{sites:?}");

        // The other way round it is its mirror image.
        let mirrored = out_and_back(columns(&rows, 30).into_iter(), true);
        let mirror = |site: &&str| {
            let (x, y) = site.split_once('/').unwrap();
            format!("{}/{y}", 9 - x.parse::<usize>().unwrap())
        };
        assert!(
            mirrored.iter().map(mirror).eq(sites.iter().copied()),
            "{mirrored:?}"
        );
        let row = &rows[..1];
        let leftwards = out_and_back(columns(row, 2).into_iter(), true);
        assert_eq!(leftwards, ["5/0", "4/0"]);
    }

    #[test]
    fn two_networks_begin_in_the_middle() {
        let text = include_bytes!("../../designs/landing-wide/weights.json");
        let net = hwgen_spec::weights::read(text).unwrap();
        let design = hwgen_spec::design::Design::new(&net, &Default::default()).unwrap();
        let cell = |layer: &str, cell: &str| format!("u_core.u_mlp.u_{layer}.{cell}.u_mul");
        let position = [
            cell("position_l0", "u_pe0.g_mul[0]"),
            cell("position_l0", "u_pe0.g_mul[1]"),
            cell("position_l0", "u_pe1.g_mul[0]"),
            cell("position_l0", "g_act[0].u_pwl"),
            cell("position_l1", "u_pe0.g_mul[0]"),
        ];
        let shared = [
            cell("shared_l0", "u_pe0.g_mul[0]"),
            cell("shared_l0", "u_pe0.g_mul[1]"),
        ];
        let orientation = [
            cell("orientation_l0", "u_pe0.g_mul[0]"),
            cell("orientation_l1", "u_pe0.g_mul[0]"),
        ];
        let strange = ["u_core.u_strange.u_mul".to_owned()];
        let order = [&position[..], &shared, &orientation, &strange];
        let mut names: Vec<&str> = order.iter().copied().flatten().map(|n| &**n).collect();
        names.sort_unstable();
        let strips = strips(design.perceptron(), &names);
        let found: Vec<&[&str]> = strips.iter().map(|strip| &*strip.names).collect();
        assert_eq!(found, order);
        let leftwards: Vec<bool> = strips.iter().map(|strip| strip.leftwards).collect();
        assert_eq!(leftwards, [true, false, false, false]);
    }

    #[test]
    fn numbers_sort_as_numbers() {
        assert!(numbers("u_pe2.g_mul[10].u_mul") > numbers("u_pe2.g_mul[9].u_mul"));
        assert!(numbers("u_pe10.g_mul[0]") > numbers("u_pe9.g_mul[1]"));
    }
}
