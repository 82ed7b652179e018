//! The static cells of `rtl/lib`, and what a family has in their place.

use hwgen_spec::device::{Device, Family};

use crate::bundle::File;

macro_rules! cells {
    ($($name:literal),* $(,)?) => {
        [$(($name, include_str!(concat!("../../rtl/lib/", $name, ".v")))),*]
    };
}

const CELLS: [(&str, &str); 20] = cells![
    "hwg_accumulator",
    "hwg_add",
    "hwg_admit",
    "hwg_beats",
    "hwg_delay",
    "hwg_drain",
    "hwg_egress",
    "hwg_gather",
    "hwg_group",
    "hwg_hold",
    "hwg_ingress",
    "hwg_mul",
    "hwg_mul_logic",
    "hwg_pair",
    "hwg_pwl",
    "hwg_queue",
    "hwg_replay",
    "hwg_requant",
    "hwg_slice",
    "hwg_tree_level",
];

/// A family's own bodies of cells, and models of its blocks for simulation.
struct Replacements {
    cells: &'static [(&'static str, &'static str)],
    models: &'static [(&'static str, &'static str)],
}

fn replacements(device: &Device) -> Replacements {
    match device.family {
        _ if !device.has_multipliers() => Replacements {
            cells: &[],
            models: &[],
        },
        Family::Generic => unreachable!("no number of multipliers is known of it"),
        Family::Ecp5 => Replacements {
            cells: &[
                ("hwg_mul", include_str!("../../rtl/devices/ecp5/hwg_mul.v")),
                (
                    "hwg_pair",
                    include_str!("../../rtl/devices/ecp5/hwg_pair.v"),
                ),
            ],
            models: &[
                (
                    "MULT18X18D",
                    include_str!("../../rtl/devices/ecp5/MULT18X18D.v"),
                ),
                ("CCU2C", include_str!("../../rtl/devices/ecp5/CCU2C.v")),
            ],
        },
        Family::Ice40 => Replacements {
            cells: &[("hwg_mul", include_str!("../../rtl/devices/ice40/hwg_mul.v"))],
            models: &[(
                "SB_MAC16",
                include_str!("../../rtl/devices/ice40/SB_MAC16.v"),
            )],
        },
    }
}

/// The cells that the files instantiate, and those that these do, with the bodies of a family.
pub(crate) fn cells_used_by(files: &[File], device: &Device) -> Vec<File> {
    let own = replacements(device).cells;
    let mut used: Vec<&(&str, &str)> = Vec::new();
    let mut texts: Vec<&str> = files.iter().map(|f| f.text.as_str()).collect();
    while let Some(text) = texts.pop() {
        for cell in &CELLS {
            let cell = own.iter().find(|own| own.0 == cell.0).unwrap_or(cell);
            if instantiates(text, cell.0) && !used.contains(&cell) {
                used.push(cell);
                texts.push(cell.1);
            }
        }
    }
    used.iter()
        .map(|(name, text)| File {
            path: format!("rtl/{name}.v"),
            text: (*text).to_owned(),
        })
        .collect()
}

/// Models of the family's blocks that the files instantiate.
pub(crate) fn models_used_by(files: &[File], device: &Device) -> Vec<File> {
    let models = replacements(device).models.iter();
    models
        .filter(|(name, _)| files.iter().any(|f| instantiates(&f.text, name)))
        .map(|(name, text)| File {
            path: format!("sim/{name}.v"),
            text: (*text).to_owned(),
        })
        .collect()
}

fn instantiates(text: &str, cell: &str) -> bool {
    text.lines().any(|line| {
        let rest = line.trim_start().strip_prefix(cell);
        rest.is_some_and(|rest| rest.starts_with(" #(") || rest.starts_with(" u_"))
    })
}
