//! Where the multipliers of a core stand on the device.
//!
//! A placer minds the wires as a whole, and settles blocks of which there are few and which stand
//! far apart, as multipliers do, with no regard to what belongs together. So they are laid out first,
//! in the order in which the data goes through them, and the placer builds the rest around them.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use hwgen_spec::design::{Layer, NetworkPlan, Perceptron};
use hwgen_spec::device::Device;
use serde_json::Value;

use super::{SynthError, io};

/// A name of what stands below: placements of another rule are other placements.
pub const RULE: &str = "multipliers in the order of the data, 1";

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
    let names: Vec<String> = sequence(stage, &names)
        .into_iter()
        .map(Into::into)
        .collect();
    for (name, site) in names.iter().zip(sites(&rows, names.len())) {
        let cell = multipliers.get_mut(name).expect("one of them");
        cell["attributes"]["BEL"] = Value::from(site);
    }
    let text = serde_json::to_vec(&netlist).expect("a value that was read");
    fs::write(path, text).map_err(io(path))
}

/// The multipliers in the order of the data: half of the networks mirrored, the shared layers, the
/// other half, so that all begin in the middle.
fn sequence<'a>(stage: &'a Perceptron, names: &[&'a str]) -> Vec<&'a str> {
    let mut rest: BTreeSet<&str> = names.iter().copied().collect();
    let mut take = |layer: &Layer, mirrored: bool| {
        let inside = format!("u_core.u_mlp.u_{}.", layer.quant.name);
        let own = names
            .iter()
            .filter_map(|name| Some((*name, name.strip_prefix(&inside)?)));
        let mut own: Vec<(&str, &str)> = own.collect();
        own.sort_by_cached_key(|(_, local)| (local.starts_with("g_act"), numbers(local)));
        if mirrored {
            own.reverse();
        }
        for (name, _) in &own {
            rest.remove(name);
        }
        own.into_iter().map(|(name, _)| name).collect::<Vec<_>>()
    };
    let (front, back) = stage.networks.split_at(stage.networks.len() / 2);
    let layers = |networks: &'a [NetworkPlan]| networks.iter().flat_map(|n| &n.layers);
    let front = layers(front).rev().map(|layer| (layer, true));
    let back = stage
        .shared
        .iter()
        .chain(layers(back))
        .map(|layer| (layer, false));
    let mut all: Vec<&str> = front
        .chain(back)
        .flat_map(|(layer, mirrored)| take(layer, mirrored))
        .collect();
    all.extend(rest);
    all
}

/// The numbers in a name: places in the hierarchy, in order.
fn numbers(name: &str) -> Vec<u64> {
    let digits = name.split(|c: char| !c.is_ascii_digit());
    digits.filter_map(|number| number.parse().ok()).collect()
}

/// Sites for so many multipliers: of the rows in the middle, as many as it takes, the same part of
/// each, there and back.
fn sites<'a>(rows: &[&'a [String]], count: usize) -> Vec<&'a str> {
    let most = rows.iter().map(|row| row.len()).max().unwrap_or(0).max(1);
    let used = count.div_ceil(most).clamp(1, rows.len().max(1));
    let first = (rows.len() - used.min(rows.len())) / 2;
    let each = count.div_ceil(used);
    let rows = rows[first..].iter().take(used).enumerate();
    rows.flat_map(|(at, row)| {
        let part = each.min(row.len());
        let left = (row.len() - part) / 2;
        let part = row[left..left + part].iter().map(String::as_str);
        if at % 2 == 0 {
            part.collect::<Vec<_>>()
        } else {
            part.rev().collect()
        }
    })
    .collect()
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
        assert_eq!(sites(&rows, 2), ["2/1", "3/1"]);
        assert_eq!(sites(&rows, 0), Vec::<&str>::new());
        let eight = sites(&rows, 8);
        assert_eq!(eight[..4], ["1/0", "2/0", "3/0", "4/0"]);
        assert_eq!(eight[4..], ["4/1", "3/1", "2/1", "1/1"]);
        let all = sites(&rows, 18);
        assert_eq!(all.iter().collect::<BTreeSet<_>>().len(), 18);
        // A netlist that is too large is another's to refuse.
        assert_eq!(sites(&rows, 20).len(), 18);
    }

    #[test]
    fn two_networks_begin_in_the_middle() {
        let text = include_bytes!("../../designs/landing-wide/weights.json");
        let net = hwgen_spec::weights::read(text).unwrap();
        let design = hwgen_spec::design::Design::new(&net, &Default::default()).unwrap();
        let cell = |layer: &str, cell: &str| format!("u_core.u_mlp.u_{layer}.{cell}.u_mul");
        let order = [
            cell("position_l1", "u_pe0.g_mul[0]"),
            cell("position_l0", "g_act[0].u_pwl"),
            cell("position_l0", "u_pe1.g_mul[0]"),
            cell("position_l0", "u_pe0.g_mul[1]"),
            cell("position_l0", "u_pe0.g_mul[0]"),
            cell("shared_l0", "u_pe0.g_mul[0]"),
            cell("shared_l0", "u_pe0.g_mul[1]"),
            cell("orientation_l0", "u_pe0.g_mul[0]"),
            cell("orientation_l0", "u_pe1.g_mul[0]"),
            cell("orientation_l0", "g_act[0].u_pwl"),
            cell("orientation_l1", "u_pe0.g_mul[0]"),
            "u_core.u_strange.u_mul".to_owned(),
        ];
        let mut names: Vec<&str> = order.iter().map(String::as_str).collect();
        names.sort_unstable();
        assert_eq!(sequence(design.perceptron(), &names), order);
    }

    #[test]
    fn numbers_sort_as_numbers() {
        assert!(numbers("u_pe2.g_mul[10].u_mul") > numbers("u_pe2.g_mul[9].u_mul"));
        assert!(numbers("u_pe10.g_mul[0]") > numbers("u_pe9.g_mul[1]"));
    }
}
