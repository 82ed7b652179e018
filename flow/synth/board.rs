//! Boards that a bitstream may be made for: a directory below `constraints` for each.

use std::sync::OnceLock;

use include_dir::{Dir, include_dir};
use serde::Deserialize;

static BOARDS: Dir = include_dir!("$CARGO_MANIFEST_DIR/constraints");

/// A board.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Board {
    /// The name of its directory.
    #[serde(skip)]
    pub name: String,
    /// What people call it.
    pub title: String,
    /// The device on it.
    pub device: String,
    /// The clock that it gives the device.
    ///
    /// # Units
    /// MHz
    pub clock_mhz: f64,
    /// Where the ports of the shell go.
    pub pins: Pins,
}

/// The pins of the shell's ports.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pins {
    /// The clock.
    pub clk_i: String,
    /// What fills the shell's registers: a button.
    pub bit_i: String,
    /// What all outputs are folded into: a lamp.
    pub bit_o: String,
}

/// No board of a name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("board: one of {} expected, `{found}` found", names().join(", "))]
pub struct UnknownBoard {
    /// The name.
    pub found: String,
}

impl UnknownBoard {
    /// One line that says how to mend it.
    pub fn help(&self) -> String {
        let near = |name: &&str| strsim::jaro_winkler(name, &self.found);
        let nearest = names()
            .into_iter()
            .max_by(|a, b| near(a).total_cmp(&near(b)));
        match nearest.filter(|name| near(name) > 0.7) {
            Some(nearest) => format!("did you mean {nearest}?"),
            None => "leave it out, for no bitstream".into(),
        }
    }
}

/// All boards, by name.
pub fn all() -> &'static [Board] {
    static ALL: OnceLock<Vec<Board>> = OnceLock::new();
    ALL.get_or_init(|| {
        let read = |directory: &Dir<'_>| {
            let name = directory.path().to_str().expect("a plain name");
            let file = BOARDS.get_file(format!("{name}/board.toml"))?;
            let board: Board = toml::from_str(file.contents_utf8().expect("text"))
                .unwrap_or_else(|error| panic!("{name}: {error}"));
            Some(Board {
                name: name.to_owned(),
                ..board
            })
        };
        let mut boards: Vec<Board> = BOARDS.dirs().filter_map(read).collect();
        boards.sort_by(|a, b| a.name.cmp(&b.name));
        boards
    })
}

/// The board of a name.
///
/// # Errors
/// If there is none.
pub fn find(name: &str) -> Result<&'static Board, UnknownBoard> {
    let board = all().iter().find(|board| board.name == name);
    board.ok_or_else(|| UnknownBoard { found: name.into() })
}

fn names() -> Vec<&'static str> {
    all().iter().map(|board| board.name.as_str()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A device that can be placed on, and a clock of which the pin is one.
    #[test]
    fn every_board_has_a_device_that_is_placed_on() {
        assert!(all().len() >= 3);
        for board in all() {
            let device = hwgen_spec::device::find(&board.device).unwrap();
            let place = device.place.as_ref().unwrap();
            // A bitstream is made by a packer of these families alone.
            use hwgen_spec::device::PlaceTool::{Ecp5, Ice40};
            assert!([Ecp5, Ice40].contains(&place.tool), "{}", board.name);
            assert_eq!(place.clock_pin, board.pins.clk_i, "{}", board.name);
            assert!(board.clock_mhz < place.core_mhz);
        }
        assert_eq!(find("icebreaker").unwrap().device, "ice40-up5k");
        let error = find("icebraker").unwrap_err();
        assert!(error.help().contains("icebreaker"), "{error}");
    }
}
