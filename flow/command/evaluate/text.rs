//! The error table for people.

use hwgen_pose::evaluate::Row;
use hwgen_spec::design::Design;

use super::super::sample::Shape;
use crate::layout::{columns, rounded};

/// Clock of the example that turns cycles into time.
const CYCLES_PER_US: f64 = 100.0;

/// An error below this, in whatever unit, is one of rounding.
const ROUNDING: f64 = 1e-6;

/// Estimators as rows, levels of noise as columns: relative errors, errors, times, failures.
pub fn tables(rows: &[Row], levels_px: &[f64]) -> String {
    let grid = Grid { rows, levels_px };
    let mut text = String::new();
    text.push_str("\nMean relative error: position / orientation, %\n\n");
    text.push_str(&grid.pairs(|row| (row.position_pct, row.orientation_pct)));
    text.push_str("\nMean error: position, m / orientation, deg\n\n");
    text.push_str(&grid.pairs(|row| (row.position_m, row.orientation_deg)));
    text.push_str("\nTime of a pose on one thread, us\n\n");
    text.push_str(&grid.singles(|row| row.us_per_pose.map(|us| rounded(us, 3))));
    if rows.iter().any(|row| row.failures.is_some_and(|n| n > 0)) {
        text.push_str("\nPoses without an answer\n\n");
        text.push_str(&grid.singles(|row| row.failures.map(|count| count.to_string())));
    }
    text.push('\n');
    text
}

struct Grid<'a> {
    rows: &'a [Row],
    levels_px: &'a [f64],
}

impl Grid<'_> {
    fn estimators(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.rows.iter().map(|r| r.estimator.as_str()).collect();
        names.dedup();
        names
    }

    fn at(&self, estimator: &str, noise_px: f64) -> Option<&Row> {
        self.rows
            .iter()
            .find(|row| row.estimator == estimator && row.noise_px == noise_px)
    }

    /// Estimators that have a cell, with the cells of all levels.
    fn singles(&self, cell: impl Fn(&Row) -> Option<String>) -> String {
        let mut header = vec!["estimator".to_owned()];
        header.extend(
            self.levels_px
                .iter()
                .map(|noise_px| format!("{noise_px} px")),
        );
        let mut lines = vec![header];
        for estimator in self.estimators() {
            let cells: Vec<Option<String>> = self
                .levels_px
                .iter()
                .map(|noise_px| self.at(estimator, *noise_px).and_then(&cell))
                .collect();
            if cells.iter().any(Option::is_some) {
                let mut line = vec![estimator.to_owned()];
                line.extend(cells.into_iter().map(|cell| cell.unwrap_or("-".into())));
                lines.push(line);
            }
        }
        let alignment = "l".to_owned() + &"r".repeat(self.levels_px.len());
        columns(&alignment, &lines)
    }

    /// The same with two numbers a cell, each aligned below the others of its level.
    fn pairs(&self, pair: impl Fn(&Row) -> (Option<f64>, Option<f64>)) -> String {
        let texts = |row: &Row| {
            let text = |value: Option<f64>| match value {
                None => "-".to_owned(),
                Some(value) if value != 0.0 && value < ROUNDING => "~0".to_owned(),
                Some(value) => rounded(value, 3),
            };
            let (first, second) = pair(row);
            (first.is_some() || second.is_some()).then(|| (text(first), text(second)))
        };
        let widest = |row: &Row| {
            self.rows
                .iter()
                .filter(|other| other.noise_px == row.noise_px)
                .filter_map(&texts)
                .fold((0, 0), |(a, b), (first, second)| {
                    (a.max(first.len()), b.max(second.len()))
                })
        };
        self.singles(|row| {
            let (first, second) = texts(row)?;
            let (a, b) = widest(row);
            Some(format!("{first:>a$} / {second:>b$}"))
        })
    }
}

/// What the numbers do not say.
pub fn notes(rows: &[Row], shape: Shape, design: Option<&Design>) -> Vec<String> {
    let has = |name: &str| rows.iter().any(|row| row.estimator == name);
    let network = has("network-float") || has("network-fixed");
    let mut notes = Vec::new();
    if has("crb") && (has("bayes") || network) && rows.iter().any(|row| row.noise_px >= 1.0) {
        notes.push(
            "from about 1 px on an estimator that knows where poses come from, as bayes or a \
             network trained on them, may pass the Cramer-Rao bound: the prior is information"
                .into(),
        );
    }
    if has("paper") {
        notes.push(
            "paper: published without its scene and without its definition of the error".into(),
        );
    }
    let drawn: Vec<String> = rows
        .iter()
        .filter_map(|row| {
            let samples = row.effective_samples?;
            Some(format!("{samples:.0} at {} px", row.noise_px))
        })
        .collect();
    if !drawn.is_empty() {
        let drawn = drawn.join(", ");
        notes.push(format!(
            "bayes knows the size of the noise; effective samples a pose: {drawn}"
        ));
    }
    if shape == Shape::Uniform && (has("crb") || has("bayes")) {
        notes.push(
            "crb and bayes take the noise for Gaussian of the same standard deviation, 1/1.73 of \
             its size: for uniform noise they are no limits"
                .into(),
        );
    }
    if rows.iter().any(|row| row.failures.is_some_and(|n| n > 0)) {
        notes.push("poses without an answer are not in the means".into());
    }
    if let Some(design) = design.filter(|_| has("network-fixed")) {
        #[expect(clippy::cast_precision_loss, reason = "counts far below 2^53")]
        let us = |cycles: usize| cycles as f64 / CYCLES_PER_US;
        let (latency, interval) = (design.latency_cycles(), design.interval_cycles());
        notes.push(format!(
            "network-fixed is timed in software; the core answers after {latency} clocks, a pose \
             every {interval}: at 100 MHz, for example, {:.2} us and {:.2} us",
            us(latency),
            us(interval),
        ));
    }
    notes
}
