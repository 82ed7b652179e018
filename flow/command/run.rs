//! `hwgen run`

use std::path::PathBuf;

use hwgen_gen::Source;
use hwgen_sim::model::Model;
use hwgen_sim::record::Recording;
use hwgen_sim::vcd;
use hwgen_spec::network::FloatNet;
use serde_json::{Map, Value, json};

use super::Outcome;
use crate::destination::{Destination, Precious};
use crate::failure::Failure;
use crate::inference::{self, Inference};
use crate::layout::{counted, significant};
use crate::output::Output;
use crate::table::{Table, outside_box, to_csv};

const EXAMPLES: &str = "\
Columns of the result: `<network>.<output>` in real units; with --raw `<network>.<output>#raw`, the
codes; `saturated`, 1 if a word inside was saturated; `outside_box`, 1 if an input lies outside of
the box and was clipped to it. The core's flag m_axis_tuser[0] is either of the two.

The values are those of the untimed model, which `hwgen verify` compares with the hardware.
With --cycle-accurate the model of every register computes them too, and the cycles are counted;
--vcd writes what the registers held, some 40 KB a clock for the landing design.
Without --out the table goes to standard output and the summary to standard error; with --json the
object then holds it as `columns` and `rows`.
A file that exists is replaced only with --force; the file of --inputs and those of the bundle never.

Examples:
  hwgen run build/landing --inputs vectors.csv --out result.csv
  hwgen run build/landing --inputs vectors.csv --raw | head
  hwgen run build/landing --inputs few.csv --cycle-accurate --vcd core.vcd";

/// What `run` takes.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Directory of the bundle
    #[arg(value_name = "DIR")]
    pub bundle: PathBuf,
    /// Raw inputs: a header with the input names in any order, other columns are ignored
    #[arg(long, value_name = "F.csv")]
    pub inputs: PathBuf,
    /// Where the results go [default: standard output]
    #[arg(long, value_name = "F.csv")]
    pub out: Option<PathBuf>,
    /// Add the integer codes of the outputs
    #[arg(long)]
    pub raw: bool,
    /// Step the model of every register, and count the clocks
    #[arg(long)]
    pub cycle_accurate: bool,
    /// Write every register after every clock as VCD, as the simulators' dumps name them
    #[arg(long, value_name = "F.vcd", requires = "cycle_accurate")]
    pub vcd: Option<PathBuf>,
    /// Replace a file that is there
    #[arg(long)]
    pub force: bool,
}

/// Infers, and prints or writes the results.
///
/// # Errors
/// If bundle or inputs are refused, or the results can't be written.
pub fn run(args: &Args, _: &Output) -> Result<Outcome, Failure> {
    let (out, vcd_out) = destinations(args)?;
    let source = Source::read(&args.bundle)?;
    let rows = Table::read(&args.inputs)?.numbers(source.design.input_names())?;
    let inference = if args.cycle_accurate {
        let mut trace = args.vcd.as_ref().map(|_| {
            let registers = Model::new(&source.design).registers();
            Recording::new(registers)
        });
        let inference = inference::cycle_accurate(&source.design, &rows, trace.as_mut())?;
        if let (Some(out), Some(trace)) = (&vcd_out, &trace) {
            let mut text = Vec::new();
            vcd::write(trace, source.design.name(), &mut text)
                .map_err(|e| Failure::io(out.path(), &e))?;
            out.write(&text)?;
        }
        inference
    } else {
        inference::untimed(&source.design, &rows)
    };
    let outside: Vec<bool> = rows
        .iter()
        .map(|row| outside_box(&source.net.inputs, row))
        .collect();
    let saturated = inference.answers.iter().filter(|a| a.saturated).count();
    let outside_count = outside.iter().filter(|o| **o).count();

    let header = header(&source.net, args.raw);
    let cells = cells(&source, &inference, &outside, args.raw);
    let mut json = Map::from_iter([
        ("frames".to_owned(), json!(rows.len())),
        ("cycles".to_owned(), json!(inference.cycles)),
        (
            "inferences_per_second".to_owned(),
            json!(inference.per_second),
        ),
        ("cycle_accurate".to_owned(), json!(args.cycle_accurate)),
        ("rows_outside_box".to_owned(), json!(outside_count)),
        ("rows_saturated".to_owned(), json!(saturated)),
    ]);
    let text = match &out {
        Some(out) => {
            let texts = cells.iter().map(|row| row.iter().map(text_of).collect());
            out.write(to_csv(&header, texts).as_bytes())?;
            json.insert("out".into(), json!(out.path().display().to_string()));
            String::new()
        }
        None => {
            let texts = cells.iter().map(|row| row.iter().map(text_of).collect());
            let text = to_csv(&header, texts);
            json.insert("columns".into(), json!(header));
            json.insert("rows".into(), json!(cells));
            text
        }
    };
    let mut summary = vec![format!(
        "{} in {} cycles{}; this computation made {} inferences a second",
        counted(rows.len(), "frame"),
        inference.cycles,
        if args.cycle_accurate {
            ", counted in the cycle-accurate model"
        } else {
            " of the core"
        },
        significant(inference.per_second),
    )];
    if outside_count > 0 {
        summary.push(format!(
            "note: {outside_count} of {} outside of the input box; their inputs were clipped to it",
            counted(rows.len(), "row")
        ));
    }
    if saturated > 0 {
        summary.push(format!(
            "note: in {saturated} of {} a word inside was saturated",
            counted(rows.len(), "row")
        ));
    }
    let (text, remarks) = match &out {
        Some(out) => {
            summary.push(format!("Written to {}.", out.path().display()));
            (summary.join("\n") + "\n", Vec::new())
        }
        None => (text, summary),
    };
    Ok(Outcome {
        text,
        json,
        remarks,
        failure: None,
    })
}

/// Where table and registers go: looked at before the work, not after it.
fn destinations(args: &Args) -> Result<(Option<Destination>, Option<Destination>), Failure> {
    let precious = Precious {
        bundle: Some(&args.bundle),
        inputs: &args.inputs,
        force: args.force,
    };
    let place = |path: &Option<PathBuf>| {
        let path = path.as_ref();
        path.map(|path| Destination::new(path, &precious))
            .transpose()
    };
    let (out, vcd) = (place(&args.out)?, place(&args.vcd)?);
    if let (Some(out), Some(vcd)) = (&out, &vcd)
        && out.is(vcd)
    {
        return Err(
            Failure::input("same-file", "another file than that of --out expected")
                .file(vcd.path().display().to_string())
                .help("give --out and --vcd a file each"),
        );
    }
    Ok((out, vcd))
}

fn header(net: &FloatNet, raw: bool) -> Vec<String> {
    let mut header = net.output_columns();
    if raw {
        let codes: Vec<String> = header.iter().map(|c| format!("{c}#raw")).collect();
        header.extend(codes);
    }
    header.extend(["saturated".to_owned(), "outside_box".to_owned()]);
    header
}

fn cells(source: &Source, inference: &Inference, outside: &[bool], raw: bool) -> Vec<Vec<Value>> {
    inference
        .answers
        .iter()
        .zip(outside)
        .map(|(answer, outside)| {
            let values = source.design.net().real_outputs(&answer.codes);
            let mut row: Vec<Value> = values.into_iter().map(Value::from).collect();
            if raw {
                row.extend(answer.codes.iter().map(|code| Value::from(*code)));
            }
            row.extend([answer.saturated, *outside].map(|flag| Value::from(u8::from(flag))));
            row
        })
        .collect()
}

/// A number in plain decimals: those of a double that is read back as the same one.
fn text_of(value: &Value) -> String {
    match (value.as_i64(), value.as_f64()) {
        (None, Some(real)) => real.to_string(),
        _ => value.to_string(),
    }
}
