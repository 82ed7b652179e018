//! The static cells of `rtl/lib`.

use crate::bundle::File;

macro_rules! cells {
    ($($name:literal),* $(,)?) => {
        [$(($name, include_str!(concat!("../../rtl/lib/", $name, ".v")))),*]
    };
}

const CELLS: [(&str, &str); 15] = cells![
    "hwg_accumulator",
    "hwg_admit",
    "hwg_beats",
    "hwg_delay",
    "hwg_drain",
    "hwg_egress",
    "hwg_fifo",
    "hwg_gather",
    "hwg_group",
    "hwg_ingress",
    "hwg_mul",
    "hwg_pwl",
    "hwg_replay",
    "hwg_requant",
    "hwg_tree_level",
];

/// The cells that the files instantiate, and those that these do.
pub(crate) fn cells_used_by(files: &[File]) -> Vec<File> {
    let mut used: Vec<&(&str, &str)> = Vec::new();
    let mut texts: Vec<&str> = files.iter().map(|f| f.text.as_str()).collect();
    while let Some(text) = texts.pop() {
        for cell in &CELLS {
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

fn instantiates(text: &str, cell: &str) -> bool {
    text.lines().any(|line| {
        let rest = line.trim_start().strip_prefix(cell);
        rest.is_some_and(|rest| rest.starts_with(" #(") || rest.starts_with(" u_"))
    })
}
