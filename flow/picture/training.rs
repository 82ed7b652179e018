//! Losses against epochs.

use super::axis::{Axis, decades};
use super::svg::{Anchor, Font, Marker, Pen, Point, Svg};
use super::{BLACK, BLUE, GREY, RULE, VERMILLION};

const WIDTH: f64 = 920.0;
const HEIGHT: f64 = 400.0;
const TOP: f64 = 44.0;
const BOTTOM: f64 = 316.0;
const LEFT: f64 = 70.0;
const RIGHT: f64 = 900.0;
/// Between one panel and the axis of the next.
const GAP: f64 = 74.0;

const SMALL: Font = Font::new(11.0, Anchor::Middle);
const TRAIN: Pen = Pen::new(BLUE, 1.6);
const VALIDATION: Pen = Pen::new(VERMILLION, 1.6).dashed("6 3");

/// Name of a network, its losses of training and validation, and the epoch that was kept.
pub type Curve<'a> = (&'a str, &'a [(f64, f64)], usize);

/// The training of some networks: name, losses of training and validation after each epoch, and
/// the epoch, from 1, whose weights were kept (0 if none was).
pub fn training_curve(curves: &[Curve<'_>]) -> String {
    let description = "Loss on the samples that were learnt from and on those kept back, on a \
                       logarithmic axis, against epochs; a panel for each network.";
    let mut svg = Svg::new(WIDTH, HEIGHT, "Training curves", description);
    #[expect(clippy::cast_precision_loss, reason = "a few networks")]
    let count = curves.len().max(1) as f64;
    let width = (RIGHT - LEFT - GAP * (count - 1.0)) / count;
    let mut left = LEFT;
    for curve in curves {
        panel(&mut svg, (left, left + width), *curve);
        left += width + GAP;
    }
    let y = BOTTOM + 62.0;
    let font = Font::new(11.5, Anchor::Start);
    for (x, pen, label) in [
        (LEFT, TRAIN, "training"),
        (LEFT + 130.0, VALIDATION, "validation"),
    ] {
        svg.line((x, y), (x + 28.0, y), pen);
        svg.words((x + 35.0, y + 4.0), font, label);
    }
    svg.marker(Marker::Circle, (LEFT + 284.0, y), 4.0, BLACK, false);
    svg.words(
        (LEFT + 296.0, y + 4.0),
        font,
        "epoch whose weights were kept",
    );
    svg.finish()
}

#[expect(clippy::cast_precision_loss, reason = "epochs far below 2^53")]
fn panel(svg: &mut Svg, (left, right): (f64, f64), (name, losses, best): Curve<'_>) {
    let all = losses
        .iter()
        .flat_map(|(train, validation)| [*train, *validation]);
    let loss = Axis::logarithmic(decades(all).unwrap_or((1e-3, 1.0)), (BOTTOM, TOP));
    let epoch = Axis::linear((0.0, losses.len().max(1) as f64), (left, right));
    svg.begin_group(name);
    svg.words(
        (left, TOP - 14.0),
        Font::new(13.0, Anchor::Start).bold(),
        name,
    );
    for tick in loss.ticks(0) {
        let y = loss.at(tick);
        svg.line((left, y), (right, y), Pen::new(RULE, 1.0));
        let label = if tick < 1e-3 {
            format!("{tick:e}")
        } else {
            tick.to_string()
        };
        svg.words(
            (left - 6.0, y + 4.0),
            Font {
                anchor: Anchor::End,
                ..SMALL
            },
            &label,
        );
    }
    for tick in epoch
        .ticks(6)
        .into_iter()
        .filter(|tick| tick.fract() == 0.0)
    {
        let x = epoch.at(tick);
        svg.line((x, TOP), (x, BOTTOM), Pen::new(RULE, 1.0));
        svg.words((x, BOTTOM + 16.0), SMALL, &tick.to_string());
    }
    svg.rectangle(
        (left, TOP),
        (right - left, BOTTOM - TOP),
        "none",
        Some(Pen::new(GREY, 1.0)),
    );
    svg.words(((left + right) / 2.0, BOTTOM + 34.0), SMALL, "epoch");
    svg.words((left - 50.0, (TOP + BOTTOM) / 2.0), SMALL.upright(), "loss");

    let place = |i: usize, value: f64| {
        (value > 0.0 && loss.holds(value)).then(|| (epoch.at(i as f64 + 1.0), loss.at(value)))
    };
    for (pen, of) in [
        (TRAIN, (|pair| pair.0) as fn(&(f64, f64)) -> f64),
        (VALIDATION, |pair| pair.1),
    ] {
        let points: Vec<Point> = thinned(losses.len())
            .filter_map(|i| place(i, of(&losses[i])))
            .collect();
        svg.curve(&points, pen);
    }
    let kept = best.checked_sub(1).and_then(|i| place(i, losses.get(i)?.1));
    if let Some((x, y)) = kept {
        svg.line((x, TOP), (x, BOTTOM), Pen::new(BLACK, 1.0).dashed("2 3"));
        svg.marker(Marker::Circle, (x, y), 4.0, BLACK, false);
        let far_right = x > (left + right) / 2.0;
        let (at, anchor) = if far_right {
            (x - 7.0, Anchor::End)
        } else {
            (x + 7.0, Anchor::Start)
        };
        svg.words(
            (at, TOP + 16.0),
            Font { anchor, ..SMALL },
            &format!("epoch {best}"),
        );
    }
    svg.end_group();
}

/// Indices of a curve, the last one among them, no more than a page can show.
fn thinned(count: usize) -> impl Iterator<Item = usize> {
    const MOST: usize = 1000;
    let step = count.div_ceil(MOST).max(1);
    (0..count).filter(move |i| i % step == 0 || i + 1 == count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kept_epoch_is_marked() {
        let losses: Vec<(f64, f64)> = (1..=5000)
            .map(|i| (1.0 / f64::from(i), 1.1 / f64::from(i.min(3000))))
            .collect();
        let text = training_curve(&[("position", &losses, 3000), ("orientation", &losses, 17)]);
        assert!(text.contains(">epoch 3000</text>") && text.contains(">epoch 17</text>"));
        assert_eq!(text.matches("<polyline").count(), 4);
        assert!(text.len() < 100_000, "{} bytes", text.len());
    }

    #[test]
    fn odd_trainings_make_pictures_of_numbers() {
        let odd: [&[(f64, f64)]; 4] = [&[], &[(0.0, 0.0)], &[(1.0, f64::NAN)], &[(1.0, 1.0); 2]];
        for losses in odd {
            for best in [0, 1, 7] {
                let text = training_curve(&[("position", losses, best)]);
                assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
            }
        }
        assert!(!training_curve(&[]).contains("NaN"));
    }
}
