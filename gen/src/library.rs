//! The static cells of `rtl/lib`, and what a family has in their place.

use hwgen_spec::device::Device;
use include_dir::{Dir, include_dir};

use crate::Header;
use crate::bundle::File;

macro_rules! cells {
    ($($name:literal),* $(,)?) => {
        [$(($name, include_str!(concat!("../../rtl/lib/", $name, ".v")))),*]
    };
}

const CELLS: [(&str, &str); 21] = cells![
    "hwg_accumulator",
    "hwg_add",
    "hwg_admit",
    "hwg_beats",
    "hwg_count",
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

/// A directory for each family that has bodies of its own: the cells, named as the portable ones, and models
/// of its blocks for simulation, named as these. `logic` is for devices without multipliers.
static FAMILIES: Dir = include_dir!("$CARGO_MANIFEST_DIR/../rtl/devices");

/// Name and text of a family's files; `cells`: of its cells, else of its models.
fn own_files(device: &Device, cells: bool) -> Vec<(&'static str, &'static str)> {
    let directory = match device.multipliers {
        None => return Vec::new(),
        Some(0) => "logic",
        Some(_) => &device.family,
    };
    let files = FAMILIES.get_dir(directory).into_iter();
    let mut files: Vec<_> = files
        .flat_map(Dir::files)
        .filter_map(|file| Some((file.path().file_stem()?.to_str()?, file.contents_utf8()?)))
        .filter(|(name, _)| name.starts_with("hwg_") == cells)
        .collect();
    files.sort_unstable();
    files
}

/// The cells that the files instantiate, and those that these do, with the bodies of a family, named as modules of
/// the design.
pub(crate) fn cells_used_by(files: &[File], header: &Header) -> Vec<File> {
    let own = own_files(header.device, true);
    let mut used: Vec<File> = Vec::new();
    let mut at = 0;
    while at < files.len() + used.len() {
        let file = files.get(at).unwrap_or_else(|| &used[at - files.len()]);
        let wanted = CELLS
            .iter()
            .filter(|(name, _)| instantiates(&file.text, &header.module(name)));
        let wanted: Vec<File> = wanted
            .map(|cell| {
                let (name, text) = own.iter().find(|own| own.0 == cell.0).unwrap_or(cell);
                header.rtl(&header.module(name), renamed(text, header))
            })
            .filter(|cell| used.iter().all(|other| other.path != cell.path))
            .collect();
        used.extend(wanted);
        at += 1;
    }
    used
}

/// The text of a cell in which every word that is a cell's name becomes that of the design's own copy.
fn renamed(text: &str, header: &Header) -> String {
    let joins = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let mut renamed = String::with_capacity(text.len() + 256);
    let mut rest = text;
    while !rest.is_empty() {
        let end = rest.find(|c| !joins(c)).unwrap_or(rest.len());
        let (word, behind) = rest.split_at(end);
        if CELLS.iter().any(|(name, _)| *name == word) {
            renamed.push_str(&header.module(word));
        } else {
            renamed.push_str(word);
        }
        let next = behind.find(joins).unwrap_or(behind.len());
        renamed.push_str(&behind[..next]);
        rest = &behind[next..];
    }
    renamed
}

/// Models of the family's blocks that the files instantiate.
pub(crate) fn models_used_by(files: &[File], device: &Device) -> Vec<File> {
    own_files(device, false)
        .into_iter()
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Yosys 0.23 ends where it would move a register that starts with a one into a block.
    #[test]
    fn roms_start_with_ones_only_where_multipliers_are_instantiated() {
        for device in hwgen_spec::device::all() {
            let own = own_files(device, true);
            let instantiated = own.iter().any(|(name, _)| *name == "hwg_mul");
            assert!(instantiated || !device.roms_start, "{}", device.name);
        }
    }
}
