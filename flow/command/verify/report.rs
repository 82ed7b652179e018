//! The outcome of a check, judged and in words.

use std::fmt::Write;

use hwgen_sim::simulator::Simulator;
use hwgen_sim::verify::{Cycles, FirstDifference, Report, SimulatorRun, Verdict};
use serde_json::{Map, Value, json};

use crate::command::fields;
use crate::deviation::{Judged, TOLERANCE_PCT};
use crate::failure::{Exit, Failure};
use crate::layout::{columns, counted, row};

/// The last line of a check that found no difference. It never stands without the error of fixed
/// point: equal registers say nothing of that.
pub(crate) fn verified(report: &Report) -> String {
    let structure = match report.structure.checked {
        true => "the RTL has no other register or memory",
        false => "structure: not checked (no Yosys)",
    };
    // What one simulator reads otherwise than synthesis does, the other one may show.
    let alone = match &report.runs[..] {
        [run] => format!(", in {} alone", run.simulator),
        _ => String::new(),
    };
    format!(
        "\nverified: model and RTL are equal in every register at every cycle that was driven{alone}; \
         {structure}; fixed point against float: {}.\n",
        error(report).figure()
    )
}

/// The error of fixed point, judged.
pub(crate) fn error(report: &Report) -> Judged<'_> {
    Judged::new(&report.error, TOLERANCE_PCT)
}

/// The report for programs.
pub(crate) fn object(report: &Report) -> Map<String, Value> {
    let mut object = fields(report);
    let mut outputs = json!(report.error.outputs);
    for output in outputs.as_array_mut().into_iter().flatten() {
        output["frames"] = json!(report.error.frames);
    }
    object.insert("error_vs_float".into(), outputs);
    object.insert("error".into(), json!(error(report).json()));
    object
}

/// Why a report is no proof, if it isn't: a difference, or something that was not compared.
pub(crate) fn judge(report: &Report, simulators: &[Simulator]) -> Option<Failure> {
    if let Some(missing) = report.stimulus.missing.first() {
        let message = format!(
            "the stimulus has not driven all that it should: expected {missing}, found none"
        );
        return Some(
            Failure::new(Exit::Difference, "stimulus", message)
                .help("this is a fault of hwgen: please report the weights file and the seed"),
        );
    }
    if let Some((difference, note)) = report
        .first_difference
        .as_ref()
        .and_then(|d| Some((d, d.note.as_ref()?)))
    {
        let message = format!("{}: {note} ({})", difference.signal, difference.simulator);
        return Some(Failure::new(Exit::Difference, "difference", message));
    }
    if let Some(difference) = &report.first_difference {
        let message = format!(
            "{} differs in {} at cycle {} of {}: expected {}, found {}",
            difference.simulator,
            difference.signal,
            difference.cycle,
            difference.segment,
            difference.model,
            difference.rtl,
        );
        let mut failure = Failure::new(Exit::Difference, "difference", message);
        if !difference.files.is_empty() {
            let files: Vec<String> = difference
                .files
                .iter()
                .map(|f| f.display().to_string())
                .collect();
            failure = failure.help(format!("look at {}", files.join(", ")));
        }
        return Some(failure);
    }
    for (what, cycles) in [
        ("latency", &report.latency_cycles),
        ("interval", &report.interval_cycles),
    ] {
        if cycles.measured.is_some_and(|m| m != cycles.stated) {
            let message = format!(
                "{what}: {} cycles stated, {} measured",
                cycles.stated,
                measured(cycles)
            );
            return Some(Failure::new(Exit::Difference, "cycles", message));
        }
    }
    if report.runs.iter().any(|r| r.verdict == Verdict::Differs) {
        let message = "a simulator differs from the model";
        return Some(Failure::new(Exit::Difference, "difference", message));
    }
    let compared = |run: &SimulatorRun| {
        run.frames > 0 && run.edges > 0 && run.registers > 0 && run.values_compared > 0
    };
    let all_ran = simulators.iter().all(|s| {
        report
            .runs
            .iter()
            .any(|r| r.simulator == s.name() && compared(r))
    });
    let counted = report.latency_cycles.measured.is_some();
    if !all_ran || !counted || simulators.is_empty() {
        // A check that did not run is not a pass.
        let message = "the check came to its end without having compared everything";
        return Some(
            Failure::new(Exit::Tool, "tool-no-verdict", message)
                .help("`hwgen doctor` shows whether the simulators work"),
        );
    }
    if !report.verified {
        let message = "the check found a difference that it does not name";
        return Some(Failure::new(Exit::Difference, "difference", message));
    }
    None
}

/// The report for people, without the verdict.
pub(crate) fn text(design: &str, report: &Report) -> String {
    let mut text = format!("{design}\n\n");
    let mut rows = vec![row![
        "simulator",
        "version",
        "frames",
        "clocks",
        "registers",
        "values compared",
        "verdict",
        "seconds"
    ]];
    rows.extend(report.runs.iter().map(|run| {
        row![
            run.simulator,
            run.version,
            run.frames,
            run.edges,
            run.registers,
            run.values_compared,
            verdict(run.verdict),
            format!("{:.1}", run.seconds)
        ]
    }));
    text.push_str(&columns("llrrrrlr", &rows));
    text.push('\n');
    text.push_str(&cycle_table(
        &report.latency_cycles,
        &report.interval_cycles,
    ));
    let _ = write!(text, "\n{}", driven(report));
    let _ = write!(text, "\n{}", error(report).text());
    if report.frames_saturated > 0 {
        let _ = write!(
            text,
            "\nnote: {} raised the flag for a clipped input or word, as corners and random points of the box may\n",
            counted(report.frames_saturated, "frame")
        );
    }
    if let Some(difference) = &report.first_difference {
        text.push('\n');
        text.push_str(&in_full(difference));
    }
    text
}

/// What was driven and what was compared beside the registers, in figures.
fn driven(report: &Report) -> String {
    let stimulus = &report.stimulus;
    let structure = match (&report.structure.tool, report.structure.checked) {
        (Some(tool), true) => format!(
            "{}, {}: each one of the model ({tool})",
            counted(report.structure.registers, "register"),
            counted_as(report.structure.memories, "memory", "memories"),
        ),
        _ => "not checked".into(),
    };
    columns(
        "ll",
        &[
            row![
                "conditions",
                format!(
                    "{} of a frame, each {} or more",
                    counted(stimulus.pairs, "pair"),
                    counted(stimulus.least_of_a_pair, "time")
                )
            ],
            row![
                "resets",
                format!(
                    "{}, which change {} of registers",
                    stimulus.resets,
                    counted(stimulus.words_reset, "word")
                )
            ],
            row![
                "tables",
                format!(
                    "{} of {} read{}",
                    stimulus.segments_read,
                    counted(stimulus.segments, "segment"),
                    match stimulus.segments - stimulus.segments_read {
                        0 => "",
                        _ => "; a search found no frame that reads another",
                    }
                )
            ],
            row!["structure", structure],
        ],
    )
}

fn counted_as(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

fn verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Equal => "equal",
        Verdict::Differs => "differs",
    }
}

/// Latency and interval, as stated and as measured.
pub(crate) fn cycle_table(latency: &Cycles, interval: &Cycles) -> String {
    let rows = [
        row!["cycles", "stated", "measured"],
        cycles("latency", latency),
        cycles("interval", interval),
    ];
    columns("lrr", &rows)
}

fn cycles(what: &str, cycles: &Cycles) -> Vec<String> {
    row![what, cycles.stated, measured(cycles)]
}

fn measured(cycles: &Cycles) -> String {
    cycles
        .measured
        .map_or_else(|| "-".into(), |m| m.to_string())
}

fn in_full(difference: &FirstDifference) -> String {
    let mut rows = vec![
        row!["first difference", ""],
        row!["simulator", difference.simulator],
        row!["stimulus", difference.segment],
        row!["cycle", difference.cycle],
        row![
            "signal",
            format!("{}, lane {}", difference.signal, difference.lane)
        ],
    ];
    let mut add = |name: &str, value: Option<String>| {
        rows.extend(value.map(|value| row![name, value]));
    };
    add("network", difference.network.clone());
    add("layer", difference.layer.clone());
    add("neuron", difference.neuron.map(|n| n.to_string()));
    add("input", difference.input.map(|n| n.to_string()));
    let real = |code: String, real: Option<f64>| match real {
        Some(real) => format!("{code} ({real})"),
        None => code,
    };
    if let Some(note) = &difference.note {
        add("found", Some(note.clone()));
        return columns("ll", &rows);
    }
    add(
        "model",
        Some(real(difference.model.to_string(), difference.model_real)),
    );
    add(
        "rtl",
        Some(real(difference.rtl.clone(), difference.rtl_real)),
    );
    let mut text = columns("ll", &rows);
    if !difference.window.is_empty() {
        text.push('\n');
        for line in &difference.window {
            let _ = writeln!(text, "    {line}");
        }
    }
    text
}
