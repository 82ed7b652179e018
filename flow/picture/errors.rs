//! Errors against noise.

use hwgen_pose::evaluate::Row;

use super::axis::{Axis, decades};
use super::svg::{Anchor, Font, Marker, Pen, Point, Svg};
use super::{BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, RULE, SKY, VERMILLION};

/// A column of the table.
type Quantity = fn(&Row) -> Option<f64>;

/// How an estimator is drawn.
struct Style {
    estimator: &'static str,
    label: &'static str,
    line: Option<Pen>,
    marker: Option<(Marker, f64, &'static str, bool)>,
}

const fn limit(estimator: &'static str, label: &'static str, pen: Pen) -> Style {
    Style {
        estimator,
        label,
        line: Some(pen),
        marker: None,
    }
}

const fn marked(
    estimator: &'static str,
    colour: &'static str,
    (marker, size, filled): (Marker, f64, bool),
) -> Style {
    Style {
        estimator,
        label: estimator,
        line: Some(Pen::new(colour, 1.4)),
        marker: Some((marker, size, colour, filled)),
    }
}

/// In the order in which they are drawn: what often lies on one spot is smaller the later it is.
const STYLES: [Style; 9] = [
    limit("crb", "crb, Cramér-Rao bound", Pen::new(BLACK, 2.4)),
    limit(
        "bayes",
        "bayes, known noise",
        Pen::new(GREY, 2.4).dashed("7 4"),
    ),
    marked("p3p-ransac", GREEN, (Marker::Square, 7.0, false)),
    marked("epnp", ORANGE, (Marker::Triangle, 5.5, false)),
    marked("sqpnp", PURPLE, (Marker::Diamond, 4.4, false)),
    marked("ml", SKY, (Marker::Circle, 2.8, true)),
    marked("network-float", BLUE, (Marker::Circle, 5.5, false)),
    marked("network-fixed", VERMILLION, (Marker::Circle, 2.8, true)),
    Style {
        estimator: "paper",
        label: "paper, its own scene",
        line: None,
        marker: Some((Marker::Star, 5.5, BLACK, true)),
    },
];

const WIDTH: f64 = 920.0;
const HEIGHT: f64 = 500.0;
const TOP: f64 = 52.0;
const BOTTOM: f64 = 392.0;
/// Left ends of the two panels, and how wide they are.
const PANELS: [f64; 2] = [66.0, 520.0];
const PANEL_WIDTH: f64 = 380.0;
/// Width of the strip where noise is zero, and of the break of the axis behind it.
const ZERO_WIDTH: f64 = 34.0;
const BREAK: f64 = 12.0;
/// Errors that rounding alone leaves are not drawn.
const LEAST_PCT: f64 = 1e-3;

const SMALL: Font = Font::new(11.0, Anchor::Middle);

/// Mean relative errors of all rows: a panel for the position, one for the orientation.
pub fn picture(rows: &[Row], scene: &str) -> String {
    let title = format!("Errors of pose estimates against pixel noise, scene {scene}");
    let description = "Mean relative error in percent against noise in pixels, both on logarithmic \
                       axes, for the position on the left and the orientation on the right.";
    let mut svg = Svg::new(WIDTH, HEIGHT, &title, description);
    let title = Font::new(15.0, Anchor::Start).bold();
    svg.words(
        (PANELS[0], 24.0),
        title,
        &format!("{scene}: mean error of pose estimates"),
    );
    let quantities: [(&str, Quantity); 2] = [
        ("position, |Δp| / |p|, %", |row| row.position_pct),
        ("orientation, |Δr| / |r|, %", |row| row.orientation_pct),
    ];
    for (left, (label, value)) in PANELS.into_iter().zip(quantities) {
        panel(&mut svg, left, label, &points(rows, value));
    }
    legend(&mut svg, rows);
    if rows.iter().any(too_small) {
        let font = Font {
            anchor: Anchor::End,
            ..SMALL
        };
        let remark = format!("errors below {LEAST_PCT} % are not drawn");
        svg.words((PANELS[1] + PANEL_WIDTH, 24.0), font, &remark);
    }
    svg.finish()
}

fn too_small(row: &Row) -> bool {
    [row.position_pct, row.orientation_pct]
        .into_iter()
        .flatten()
        .any(|error| error < LEAST_PCT)
}

/// Name, noise and error, where there is one worth drawing.
fn points(rows: &[Row], value: fn(&Row) -> Option<f64>) -> Vec<(&str, f64, f64)> {
    let mut points: Vec<(&str, f64, f64)> = rows
        .iter()
        .filter_map(|row| Some((row.estimator.as_str(), row.noise_px, value(row)?)))
        .filter(|(_, _, error)| *error >= LEAST_PCT)
        .collect();
    points.sort_by(|a, b| a.1.total_cmp(&b.1));
    points
}

fn panel(svg: &mut Svg, left: f64, label: &str, points: &[(&str, f64, f64)]) {
    let right = left + PANEL_WIDTH;
    let mut levels: Vec<f64> = points.iter().map(|point| point.1).collect();
    levels.dedup();
    let zero = levels.first() == Some(&0.0);
    let start = if zero {
        left + ZERO_WIDTH + BREAK
    } else {
        left
    };
    let noise = noise_axis(&levels, (start, right));
    let range = decades(points.iter().map(|point| point.2)).unwrap_or((0.1, 100.0));
    let error = Axis::logarithmic(range, (BOTTOM, TOP));

    svg.begin_group(label);
    for tick in error.ticks(0) {
        let y = error.at(tick);
        if zero {
            svg.line((left, y), (left + ZERO_WIDTH, y), Pen::new(RULE, 1.0));
        }
        svg.line((start, y), (right, y), Pen::new(RULE, 1.0));
        svg.words(
            (left - 6.0, y + 4.0),
            Font {
                anchor: Anchor::End,
                ..SMALL
            },
            &tick.to_string(),
        );
    }
    let mut last = f64::NEG_INFINITY;
    for level in &levels {
        let x = if *level == 0.0 {
            left + ZERO_WIDTH / 2.0
        } else {
            noise.at(*level)
        };
        svg.line((x, TOP), (x, BOTTOM), Pen::new(RULE, 1.0));
        // Names of levels that are close together would run into each other.
        if x - last > 24.0 {
            svg.words((x, BOTTOM + 16.0), SMALL, &level.to_string());
            last = x;
        }
    }
    frame(svg, left, start, right);
    svg.words(
        ((left + right) / 2.0, BOTTOM + 34.0),
        SMALL,
        "noise on each pixel coordinate, px",
    );
    let middle = (left - 44.0, (TOP + BOTTOM) / 2.0);
    svg.words(
        middle,
        Font {
            size: 12.0,
            ..SMALL
        }
        .upright(),
        label,
    );

    for style in &STYLES {
        let drawn: Vec<Point> = points
            .iter()
            .filter(|(name, ..)| *name == style.estimator)
            .map(|(_, level, value)| {
                let x = if *level == 0.0 {
                    left + ZERO_WIDTH / 2.0
                } else {
                    noise.at(*level)
                };
                (x, error.at(*value))
            })
            .collect();
        style.draw(svg, &drawn, start);
    }
    svg.end_group();
}

fn noise_axis(levels: &[f64], place: (f64, f64)) -> Axis {
    let positive = || levels.iter().copied().filter(|level| *level > 0.0);
    let least = positive().fold(f64::INFINITY, f64::min);
    let most = positive().fold(0.0, f64::max);
    if most == 0.0 {
        return Axis::logarithmic((0.1, 10.0), place);
    }
    let margin = (most / least).powf(0.06).max(1.2);
    Axis::logarithmic((least / margin, most * margin), place)
}

/// The frame of a panel, broken between zero and the logarithmic part.
fn frame(svg: &mut Svg, left: f64, start: f64, right: f64) {
    let pen = Pen::new(GREY, 1.0);
    if start > left {
        let end = left + ZERO_WIDTH;
        svg.curve(
            &[(end, TOP), (left, TOP), (left, BOTTOM), (end, BOTTOM)],
            pen,
        );
        svg.curve(
            &[(start, TOP), (right, TOP), (right, BOTTOM), (start, BOTTOM)],
            pen,
        );
        for y in [TOP, BOTTOM] {
            for x in [end, start] {
                svg.line((x - 3.0, y + 5.0), (x + 3.0, y - 5.0), pen);
            }
        }
    } else {
        svg.rectangle((left, TOP), (right - left, BOTTOM - TOP), "none", Some(pen));
    }
}

impl Style {
    /// Points right of `start` are joined; those of zero noise stand alone.
    fn draw(&self, svg: &mut Svg, points: &[Point], start: f64) {
        if points.is_empty() {
            return;
        }
        svg.begin_group(self.estimator);
        let joined: Vec<Point> = points.iter().copied().filter(|p| p.0 > start).collect();
        if let (Some(pen), [_, _, ..]) = (self.line, &joined[..]) {
            svg.curve(&joined, pen);
        }
        for at in points {
            match (self.marker, self.line) {
                (Some((marker, size, colour, filled)), _) => {
                    svg.marker(marker, *at, size, colour, filled);
                }
                // A limit at zero noise, or at one level alone.
                (None, Some(pen)) if at.0 <= start || joined.len() == 1 => {
                    svg.line((at.0 - 9.0, at.1), (at.0 + 9.0, at.1), pen);
                }
                _ => {}
            }
        }
        svg.end_group();
    }
}

fn legend(svg: &mut Svg, rows: &[Row]) {
    const COLUMNS: usize = 5;
    let present = STYLES
        .iter()
        .filter(|style| rows.iter().any(|row| row.estimator == style.estimator));
    for (i, style) in present.enumerate() {
        #[expect(clippy::cast_precision_loss, reason = "a few")]
        let (column, line) = ((i % COLUMNS) as f64, (i / COLUMNS) as f64);
        let (x, y) = (PANELS[0] + 172.0 * column, BOTTOM + 64.0 + 22.0 * line);
        if let Some(pen) = style.line {
            svg.line((x, y), (x + 28.0, y), pen);
        }
        if let Some((marker, size, colour, filled)) = style.marker {
            svg.marker(marker, (x + 14.0, y), size, colour, filled);
        }
        let font = Font::new(11.5, Anchor::Start);
        svg.words((x + 35.0, y + 4.0), font, style.label);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(estimator: &str, noise_px: f64, error: Option<f64>) -> Row {
        Row {
            estimator: estimator.into(),
            noise_px,
            position_pct: error,
            orientation_pct: error.map(|e| 10.0 * e),
            position_m: None,
            orientation_deg: None,
            us_per_pose: None,
            failures: None,
            effective_samples: None,
        }
    }

    #[test]
    fn each_estimator_is_drawn_once_a_panel_and_once_in_the_legend() {
        let rows = [
            row("crb", 1.0, Some(1.4)),
            row("crb", 3.0, Some(4.1)),
            row("ml", 0.0, Some(1e-13)),
            row("ml", 1.0, Some(1.5)),
            row("paper", 0.0, Some(2.6)),
        ];
        let text = picture(&rows, "landing");
        for name in ["crb", "ml", "paper"] {
            assert_eq!(
                text.matches(&format!("<g><title>{name}</title>")).count(),
                2
            );
        }
        assert!(!text.contains("<title>bayes</title>"));
        assert!(text.contains("errors below 0.001 % are not drawn"));
        // The axis is broken behind 0 px, in both panels.
        assert_eq!(text.matches(">0</text>").count(), 2);
    }

    #[test]
    fn odd_tables_make_pictures_of_numbers() {
        let tables = [
            vec![],
            vec![row("ml", 0.0, Some(0.0))],
            vec![row("ml", 0.0, Some(3.0))],
            vec![row("ml", 2.0, None)],
            vec![row("crb", 2.0, Some(1.0))],
            vec![row("ml", 1e-9, Some(1e9)), row("ml", 1e9, Some(1.0))],
        ];
        for rows in tables {
            let text = picture(&rows, "s");
            assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
        }
    }
}
