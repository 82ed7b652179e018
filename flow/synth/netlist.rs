//! What the parts of a core take, from the netlist that Yosys wrote.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use hwgen_spec::device::{Sites, Synthesis};
use serde::{Deserialize, Serialize};

use super::{SynthError, io};

/// A part of the core, and what it takes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Part {
    /// A layer, or what stands beside the layers: `position_l0`, `ingress`.
    pub name: String,
    /// Its part, without a number: `pe`, `w`, `act`; empty for what stands in the layer itself.
    pub piece: String,
    /// What it takes.
    #[serde(flatten)]
    pub sites: Sites,
}

#[derive(Deserialize)]
struct Netlist {
    modules: BTreeMap<String, Module>,
}

#[derive(Deserialize)]
struct Module {
    #[serde(default)]
    attributes: BTreeMap<String, serde_json::Value>,
    #[serde(default)]
    cells: BTreeMap<String, Cell>,
}

#[derive(Deserialize)]
struct Cell {
    #[serde(rename = "type")]
    kind: String,
}

/// Sites by part, from a flat netlist whose cells are named by their place in the hierarchy; and cells of
/// types that are not known, counted.
///
/// # Errors
/// If the netlist cannot be read.
pub fn parts(
    path: &Path,
    synthesis: &Synthesis,
) -> Result<(Vec<Part>, BTreeMap<String, usize>), SynthError> {
    let file = File::open(path).map_err(io(path))?;
    let netlist: Netlist =
        serde_json::from_reader(BufReader::new(file)).map_err(|error| SynthError::Strange {
            path: path.to_owned(),
            expected: "a netlist as Yosys writes it".into(),
            found: error.to_string(),
        })?;
    let mut parts: BTreeMap<(String, String), Sites> = BTreeMap::new();
    let mut unknown = BTreeMap::new();
    // The others are what Yosys knows of the device's cells.
    let core = netlist.modules.values();
    let core = core.filter(|module| module.attributes.contains_key("top"));
    let core: Vec<&Module> = core.collect();
    let [core] = core[..] else {
        return Err(SynthError::Strange {
            path: path.to_owned(),
            expected: "one module marked as the top".into(),
            found: core.len().to_string(),
        });
    };
    for (name, cell) in &core.cells {
        match synthesis.cells.get(&cell.kind) {
            Some(taken) => *parts.entry(place(name)).or_default() += *taken,
            None if synthesis.free.contains(&cell.kind) => {}
            None => *unknown.entry(cell.kind.clone()).or_default() += 1,
        }
    }
    let parts = parts.into_iter();
    let parts = parts.map(|((name, piece), sites)| Part { name, piece, sites });
    Ok((parts.collect(), unknown))
}

/// The part, and the piece of it, that a cell or net of a flat netlist belongs to.
///
/// Instances are called `u_<name>`, generated blocks `g_<name>[<number>]`; `u_core` is the core in
/// its shell and `u_mlp` the stage of perceptrons.
pub fn place(cell: &str) -> (String, String) {
    let mut instances = cell
        .split('.')
        .map_while(|segment| {
            let name = segment
                .strip_prefix("u_")
                .or_else(|| segment.strip_prefix("g_"))?;
            Some((segment, name))
        })
        .peekable();
    if instances
        .next_if(|(segment, _)| *segment == "u_core")
        .is_none()
    {
        return ("shell".into(), String::new());
    }
    let stage = instances
        .next_if(|(segment, _)| *segment == "u_mlp")
        .is_some();
    // The cells that Yosys makes are named after a register or a port: they are no instances.
    let name = instances.next().map_or_else(
        || if stage { "stage" } else { "core" }.into(),
        |(_, name)| unnumbered(name, false),
    );
    let piece = instances
        .next()
        .map_or_else(String::new, |(_, name)| unnumbered(name, true));
    (name, piece)
}

/// A name without the index of a generated block, and without its final number if that is one of
/// many alike.
fn unnumbered(name: &str, alike: bool) -> String {
    let name = name.split('[').next().unwrap_or(name);
    if alike {
        name.trim_end_matches(|c: char| c.is_ascii_digit())
            .to_owned()
    } else {
        name.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_belong_to_where_they_stand() {
        for (cell, name, piece) in [
            (
                "u_core.u_mlp.u_position_l0.u_pe3.u_tree.sum_q_TRELLIS_FF_Q_3",
                "position_l0",
                "pe",
            ),
            (
                "u_core.u_mlp.u_position_l0.g_act[4].u_pwl.u_mul.g_block.u_block",
                "position_l0",
                "act",
            ),
            (
                "u_core.u_mlp.u_position_l0.valid_q_TRELLIS_FF_Q",
                "position_l0",
                "",
            ),
            (
                "u_core.u_ingress.g_lane[0].high_CCU2C_A0",
                "ingress",
                "lane",
            ),
            ("u_core.u_mlp.clipped_TRELLIS_FF_Q", "stage", ""),
            ("u_core.m_axis_tlast_LUT4_D", "core", ""),
            ("drive_q_TRELLIS_FF_Q_1", "shell", ""),
        ] {
            assert_eq!(place(cell), (name.to_owned(), piece.to_owned()), "{cell}");
        }
    }

    #[test]
    fn sites_are_counted_by_part() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("n.json");
        let text = r#"{"creator": "Yosys", "modules": {
            "CCU2C": {"attributes": {"whitebox": "1"}, "cells": {"lut": {"type": "LUT4"}}},
            "x_shell": {"attributes": {"top": "1"}, "cells": {
                "u_core.u_mlp.u_a_l0.u_pe0.p_LUT4_Z": {"type": "LUT4", "connections": {}},
                "u_core.u_mlp.u_a_l0.u_pe1.p_CCU2C_S0": {"type": "CCU2C"},
                "u_core.u_mlp.u_a_l0.u_pe1.u_mul.u_block": {"type": "MULT18X18D"},
                "u_core.u_mlp.u_a_l0.u_pe1.x_PFUMX_Z": {"type": "PFUMX"},
                "u_core.u_mlp.u_a_l0.u_pe1.x_LUT7_Z": {"type": "LUT7"},
                "drive_q_TRELLIS_FF_Q": {"type": "TRELLIS_FF"}}}}}"#;
        std::fs::write(&path, text).unwrap();
        let device = hwgen_spec::device::find("ecp5-85k").unwrap();
        let (parts, unknown) = parts(&path, &device.synthesis).unwrap();
        let part = |name: &str, piece: &str, lut4, ff, multipliers| Part {
            name: name.into(),
            piece: piece.into(),
            sites: Sites {
                lut4,
                ff,
                multipliers,
                block_rams: 0,
            },
        };
        assert_eq!(
            parts,
            [part("a_l0", "pe", 3, 0, 1), part("shell", "", 0, 1, 0)]
        );
        assert_eq!(unknown, BTreeMap::from([("LUT7".to_owned(), 1)]));
        std::fs::write(&path, text.replace(r#""top": "1""#, "")).unwrap();
        let error = super::parts(&path, &device.synthesis).unwrap_err();
        assert!(error.to_string().contains("0 found"), "{error}");
        std::fs::write(&path, "{").unwrap();
        let error = super::parts(&path, &device.synthesis)
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("a netlist as Yosys writes it expected"),
            "{error}"
        );
    }
}
