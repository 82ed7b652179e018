//! The error of fixed point in words, and as a machine reads it.

use hwgen_spec::deviation::{Deviation, FrameSource, OutputDeviation};
use serde_json::{Map, Value, json};

use crate::command::fields;
use crate::layout::{columns, counted, rounded, row, significant};

/// The greatest error that goes without a warning, in per cent of an output's spread.
pub const TOLERANCE_PCT: f64 = 1.0;

/// Longer lists are cut short.
const MOST_NAMED: usize = 8;

/// What is said of points of the box.
const BOX: &str =
    "box: independent points of the input box; they say little about correlated inputs\n";

/// The error against a tolerance.
#[derive(Clone, Copy, Debug)]
pub struct Judged<'a> {
    deviation: &'a Deviation,
    tolerance_pct: f64,
}

impl<'a> Judged<'a> {
    /// Against a tolerance in per cent.
    pub fn new(deviation: &'a Deviation, tolerance_pct: f64) -> Self {
        Self {
            deviation,
            tolerance_pct,
        }
    }

    /// Whether every output keeps the tolerance, where that can be told.
    pub fn within(&self) -> Option<bool> {
        self.deviation.within(self.tolerance_pct / 100.0)
    }

    /// The object `error`.
    pub fn json(&self) -> Map<String, Value> {
        let mut object = fields(self.deviation);
        object.insert("tolerance_pct".into(), json!(self.tolerance_pct));
        object.insert("within_tolerance".into(), json!(self.within()));
        object
    }

    /// A table of the outputs, and what is to be said of the frames.
    pub fn text(&self) -> String {
        let Deviation {
            frames,
            source,
            clipped_frames,
            outputs,
        } = self.deviation;
        let mut rows = vec![row![
            "output",
            "rms",
            "greatest",
            "rms, % of spread",
            "unit"
        ]];
        rows.extend(outputs.iter().map(|o| {
            let share = o.rms_over_spread.map_or("-".into(), percent);
            row![
                o.output,
                significant(o.rms),
                significant(o.max),
                share,
                o.unit
            ]
        }));
        let mut text = format!(
            "Error against float, {}\n\n{}",
            self.frames(),
            columns("lrrrl", &rows)
        );
        if *source == FrameSource::Box {
            text.push_str(&format!("\n{BOX}"));
        }
        if *clipped_frames > 0 {
            let counted = match source {
                FrameSource::Vectors => counted(*clipped_frames, "row") + " of the vectors",
                _ => format!("{clipped_frames} of {}", counted(*frames, "frame")),
            };
            text.push_str(&format!(
                "\nnote: {counted} outside of the input box; the core clips the inputs, float does \
                 not, and the error holds the difference\n"
            ));
        }
        text
    }

    /// A line for each output whose error is too great, or can't be judged.
    pub fn warnings(&self) -> Vec<String> {
        let Deviation {
            frames,
            source,
            outputs,
            ..
        } = self.deviation;
        let over = self.frames();
        match source {
            FrameSource::Box => return Vec::new(),
            _ if *frames < 2 => {
                return vec![format!(
                    "warning: at least 2 frames expected for a spread of the outputs, {over} found"
                )];
            }
            _ => {}
        }
        let most = self.tolerance_pct;
        let warning = |o: &OutputDeviation| match o.rms_over_spread {
            Some(share) if 100.0 * share > most => Some(format!(
                "warning: output {}: rms error {} % of its spread over {over}, expected at most \
                 {most} %",
                o.output,
                percent(share)
            )),
            None if o.has_no_share() => Some(format!(
                "warning: output {}: constant in float over {over}, so that its rms error of {} is \
                 no share of a spread",
                o.output,
                with_unit(o)
            )),
            _ => None,
        };
        let mut warnings: Vec<String> = outputs.iter().filter_map(warning).collect();
        if warnings.len() > MOST_NAMED {
            let more = counted(warnings.len() - MOST_NAMED, "more output");
            warnings.truncate(MOST_NAMED);
            warnings.push(format!("warning: the same of {more}"));
        }
        warnings
    }

    /// The figure in one line: the greatest error of all outputs, and over what.
    pub fn figure(&self) -> String {
        let over = self.frames();
        let outputs = &self.deviation.outputs;
        let greatest = self.deviation.greatest_share().map(|share| {
            let mut text = format!("at most {} % of an output's spread", percent(share));
            if self.within() == Some(false) {
                text.push_str(&format!(", expected at most {} %", self.tolerance_pct));
            }
            text
        });
        let mut apart: Vec<String> = outputs
            .iter()
            .filter(|o| o.has_no_share())
            .map(|o| format!("{} in {}", with_unit(o), o.output))
            .collect();
        if apart.len() > MOST_NAMED {
            apart.truncate(MOST_NAMED);
            apart.push("...".into());
        }
        let apart = (!apart.is_empty()).then(|| format!("{}, without a spread", apart.join(", ")));
        let parts: Vec<String> = greatest.into_iter().chain(apart).collect();
        if parts.is_empty() {
            format!("equal ({over})")
        } else {
            format!("{} (rms, {over})", parts.join("; "))
        }
    }

    /// `250 calibration frames`, and the like.
    fn frames(&self) -> String {
        let count = self.deviation.frames;
        match self.deviation.source {
            FrameSource::Vectors => counted(count, "frame") + " of the vectors",
            FrameSource::Calibration => counted(count, "calibration frame"),
            FrameSource::Box => format!("box: {}", counted(count, "independent point")),
        }
    }
}

/// A share in per cent.
fn percent(share: f64) -> String {
    rounded(100.0 * share, 3)
}

/// An rms error with its unit.
fn with_unit(output: &OutputDeviation) -> String {
    let text = format!("{} {}", significant(output.rms), output.unit);
    text.trim_end().to_owned()
}
