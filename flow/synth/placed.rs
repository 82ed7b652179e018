//! Where nextpnr put the cells of a core.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use hwgen_spec::device::Place;
use serde::Deserialize;

use super::netlist::place;
use super::{SynthError, io};

/// A cell at its place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlacedCell {
    /// Column and row of the tile, as nextpnr counts them.
    pub tile: (u32, u32),
    /// The layer that it belongs to, or what stands beside the layers.
    pub part: String,
    /// Whether it is a multiplier; all others are tables and flip-flops.
    pub multiplier: bool,
}

#[derive(Deserialize)]
struct Netlist {
    modules: BTreeMap<String, Module>,
}

#[derive(Deserialize)]
struct Module {
    #[serde(default)]
    cells: BTreeMap<String, Cell>,
}

#[derive(Deserialize)]
struct Cell {
    #[serde(rename = "type")]
    kind: String,
    #[serde(default)]
    attributes: Attributes,
}

#[derive(Default, Deserialize)]
struct Attributes {
    #[serde(rename = "NEXTPNR_BEL")]
    site: Option<String>,
}

/// The tables, flip-flops and multipliers of the core in a netlist that nextpnr placed; the shell
/// around it is left out.
///
/// # Errors
/// If the file cannot be read as one.
pub fn read(path: &Path, known: &Place) -> Result<Vec<PlacedCell>, SynthError> {
    let strange = |found: String| SynthError::Strange {
        path: path.to_owned(),
        expected: "a placed netlist as nextpnr writes it".into(),
        found,
    };
    let file = File::open(path).map_err(io(path))?;
    let netlist: Netlist = serde_json::from_reader(BufReader::new(file))
        .map_err(|error| strange(error.to_string()))?;
    let mut cells = Vec::new();
    for (name, cell) in netlist.modules.into_values().flat_map(|m| m.cells) {
        let multiplier = cell.kind == known.sites.multipliers;
        let (part, _) = place(&name);
        let own = multiplier
            || cell.kind == known.sites.lut4
            || Some(&cell.kind) == known.sites.ff.as_ref();
        let Some(site) = cell.attributes.site.filter(|_| own && part != "shell") else {
            continue;
        };
        let tile = tile(&site).ok_or_else(|| strange(format!("a cell at `{site}`")))?;
        cells.push(PlacedCell {
            tile,
            part,
            multiplier,
        });
    }
    Ok(cells)
}

/// Column and row of a site such as `X57/Y43/SLICEA.FF0`.
fn tile(site: &str) -> Option<(u32, u32)> {
    let mut parts = site.split('/');
    let x = parts.next()?.strip_prefix('X')?.parse().ok()?;
    let y = parts.next()?.strip_prefix('Y')?.parse().ok()?;
    Some((x, y))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_read_with_their_tiles() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("placed.json");
        let cell = |kind: &str, site: &str| serde_json::json!({"type": kind, "attributes": {"NEXTPNR_BEL": site}});
        let netlist = serde_json::json!({"modules": {"x_shell": {"cells": {
            "u_core.u_mlp.u_a_l0.u_pe1.u_mul.u_block": cell("MULT18X18D", "X4/Y10/MULT18_0"),
            "u_core.u_ingress.word_q_TRELLIS_FF_Q": cell("TRELLIS_FF", "X57/Y43/SLICEA.FF0"),
            "drive_q_TRELLIS_FF_Q": cell("TRELLIS_FF", "X1/Y1/SLICEA.FF0"),
            "clk_i$tr_io": cell("TRELLIS_IO", "X0/Y47/PIOA"),
        }}}});
        std::fs::write(&path, netlist.to_string()).unwrap();
        let device = hwgen_spec::device::find("ecp5-85k").unwrap();
        let known = device.place.as_ref().unwrap();
        let cell = |tile, part: &str, multiplier| PlacedCell {
            tile,
            part: part.into(),
            multiplier,
        };
        assert_eq!(
            read(&path, known).unwrap(),
            [
                cell((57, 43), "ingress", false),
                cell((4, 10), "a_l0", true)
            ]
        );
        let text = netlist.to_string().replace("X57/Y43", "57.43");
        std::fs::write(&path, text).unwrap();
        let error = read(&path, known).unwrap_err().to_string();
        assert!(error.contains("a cell at `57.43/SLICEA.FF0`"), "{error}");
    }
}
