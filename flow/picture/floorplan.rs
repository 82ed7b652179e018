//! What stands where on a device.

use std::collections::BTreeMap;

use super::svg::{Anchor, Font, Pen, Svg};
use super::{BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, RULE, SKY, VERMILLION};
use crate::synth::placed::PlacedCell;

const LEFT: f64 = 20.0;
const TOP: f64 = 40.0;
const WIDTH: f64 = 760.0;
const LEGEND: f64 = 190.0;

/// Colours of the layers, one after the other.
const COLOURS: [&str; 7] = [ORANGE, BLUE, SKY, VERMILLION, PURPLE, GREEN, BLACK];

/// A routed core: each tile has the colour of the layer that most of its tables and flip-flops
/// belong to, the paler the fewer they are; multipliers are framed.
pub fn floorplan(title: &str, layers: &[String], cells: &[PlacedCell]) -> String {
    let edge = |of: fn(&PlacedCell) -> u32| cells.iter().map(of).max().unwrap_or(0) + 2;
    let (columns, rows) = (edge(|cell| cell.tile.0), edge(|cell| cell.tile.1));
    let side = WIDTH / f64::from(columns);
    let height = side * f64::from(rows);
    let description = "A device from above: tiles coloured by the layer that stands there, \
                       multipliers in rows across.";
    let lines = layers.len() as f64;
    let mut svg = Svg::new(
        LEFT + WIDTH + LEGEND,
        TOP + height.max(20.0 * (lines + 3.0)) + 20.0,
        title,
        description,
    );
    svg.words(
        (LEFT, TOP - 14.0),
        Font::new(14.0, Anchor::Start).bold(),
        title,
    );
    svg.rectangle(
        (LEFT, TOP),
        (WIDTH, height),
        "#ffffff",
        Some(Pen::new(GREY, 1.0)),
    );
    // What gathers a layer's words is named after it.
    let colour = |part: &str| {
        let layer = part.strip_suffix("_gather").unwrap_or(part);
        let at = layers.iter().position(|name| name == layer);
        at.map_or(GREY, |at| COLOURS[at % COLOURS.len()])
    };
    let corner = |(x, y): (u32, u32)| (LEFT + side * f64::from(x), TOP + side * f64::from(y));
    let mut tiles: BTreeMap<(u32, u32), BTreeMap<&str, u32>> = BTreeMap::new();
    for cell in cells.iter().filter(|cell| !cell.multiplier) {
        *tiles
            .entry(cell.tile)
            .or_default()
            .entry(colour(&cell.part))
            .or_default() += 1;
    }
    let most = tiles
        .values()
        .map(|kinds| kinds.values().sum())
        .max()
        .unwrap_or(1);
    for (tile, kinds) in &tiles {
        let (colour, _) = kinds
            .iter()
            .max_by_key(|(_, count)| **count)
            .expect("one cell");
        let count: u32 = kinds.values().sum();
        let opacity = 0.25 + 0.75 * f64::from(count) / f64::from(most);
        let (x, y) = corner(*tile);
        let corners = [(x, y), (x + side, y), (x + side, y + side), (x, y + side)];
        svg.area(&corners, colour, opacity);
    }
    for cell in cells.iter().filter(|cell| cell.multiplier) {
        let (x, y) = corner(cell.tile);
        let pen = Some(Pen::new(BLACK, 0.6));
        svg.rectangle((x, y - side), (side, 2.0 * side), colour(&cell.part), pen);
    }
    let font = Font::new(12.0, Anchor::Start);
    let left = LEFT + WIDTH + 14.0;
    let mut y = TOP + 8.0;
    let others = "streams, queues".to_owned();
    for name in layers.iter().chain([&others]) {
        svg.rectangle(
            (left, y),
            (12.0, 12.0),
            colour(name),
            Some(Pen::new(RULE, 0.5)),
        );
        svg.words((left + 19.0, y + 10.5), font, name);
        y += 20.0;
    }
    svg.rectangle(
        (left + 3.0, y),
        (6.0, 12.0),
        "#ffffff",
        Some(Pen::new(BLACK, 0.6)),
    );
    svg.words((left + 19.0, y + 10.5), font, "multiplier");
    svg.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_have_the_colour_of_most_of_their_cells() {
        let cell = |tile, part: &str, multiplier| PlacedCell {
            tile,
            part: part.into(),
            multiplier,
        };
        let cells = [
            cell((3, 4), "b_l1", false),
            cell((3, 4), "b_l1_gather", false),
            cell((3, 4), "ingress", false),
            cell((5, 4), "a_l0", true),
        ];
        let layers = ["a_l0".to_owned(), "b_l1".to_owned()];
        let text = floorplan("x", &layers, &cells);
        let tiles = |colour: &str| text.matches(&format!("fill=\"{colour}\" fill-op")).count();
        assert_eq!((tiles(BLUE), tiles(GREY), tiles(ORANGE)), (1, 0, 0));
        // A name that begins like another's is another's.
        let other = floorplan(
            "x",
            &["n_l1".into(), "n_l10".into()],
            &[cell((1, 1), "n_l10", false)],
        );
        assert_eq!(
            other.matches(&format!("fill=\"{BLUE}\" fill-op")).count(),
            1
        );
        // The multiplier and its place in the legend.
        assert_eq!(text.matches(&format!("fill=\"{ORANGE}\"")).count(), 2);
        assert_eq!(text, floorplan("x", &layers, &cells));
    }
}
