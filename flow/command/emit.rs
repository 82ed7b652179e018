//! `hwgen emit`

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use hwgen_gen::{Bundle, Manifest};
use hwgen_spec::design::{Design, Layer};
use hwgen_spec::deviation;
use hwgen_spec::network::Activation;
use serde_json::{Map, json};

use super::request::Request;
use super::{Outcome, fields};
use crate::deviation::{Judged, TOLERANCE_PCT};
use crate::failure::{Exit, Failure};
use crate::layout::{columns, counted, row, shell_word, significant};
use crate::output::Output;

const EXAMPLES: &str = "\
Examples:
  hwgen emit --weights w.json
  hwgen emit --weights w.json --out build/fast --interval 16
  hwgen emit --weights w.json --device ecp5-25k
  hwgen emit --weights w.json --multipliers 40 --weight-bits 12 --weight-bits position_l1=14
  hwgen emit --weights w.json --name second --device ice40-up5k
  hwgen emit --weights w.json --force --json

The directory is written whole or not at all. `hwgen schema` describes the weights file.

The error against float is measured over the frames under `calibration` in the weights file, or over
independent points of the input box: these say little, and give neither a warning nor a pass.";

/// What `emit` takes.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// What is to be built.
    #[command(flatten)]
    pub request: Request,
    /// Directory of the bundle
    #[arg(
        long,
        value_name = "DIR",
        help = "Directory of the bundle [default: build/<name>]"
    )]
    pub out: Option<PathBuf>,
    /// Name of the design and of its top module [default: the name in the weights file]
    #[arg(long, value_name = "NAME")]
    pub name: Option<String>,
    /// Prefix of all other modules, which are called PREFIX__PART [default: the design's name]
    #[arg(long, value_name = "PREFIX")]
    pub prefix: Option<String>,
    /// Replace a bundle that is there already
    #[arg(long)]
    pub force: bool,
    /// Greatest rms error of an output against float, in per cent of the standard deviation of the
    /// float output over the calibration's frames; more is a warning
    #[arg(long, value_name = "PCT", default_value_t = TOLERANCE_PCT, value_parser = tolerance)]
    pub tolerance: f64,
    /// Write nothing if the tolerance is missed: exit code 1
    #[arg(long)]
    pub strict: bool,
}

fn tolerance(text: &str) -> Result<f64, String> {
    let value: Option<f64> = text.parse().ok();
    value
        .filter(|v| v.is_finite() && *v >= 0.0)
        .ok_or_else(|| "a number of per cent from 0 on expected".into())
}

/// Writes the bundle.
///
/// # Errors
/// If weights or options are refused, the bundle can't be written, or a tolerance is missed that
/// must be kept.
pub fn run(args: &Args, output: &Output) -> Result<Outcome, Failure> {
    let (net, design) = args
        .request
        .design_called(args.name.as_deref(), args.prefix.as_deref())?;
    let out = match &args.out {
        Some(out) => out.clone(),
        None => Path::new("build").join(design.name()),
    };
    let deviation = deviation::measure(&design, &net, &[]);
    let error = Judged::new(&deviation, args.tolerance);
    let bundle = hwgen_gen::generate(&design, &net);
    let (notes, mut text) = (notes(&design), describe(&design, &bundle));
    for note in &notes {
        text.push_str(&format!("note: {note}\n"));
    }
    text.push_str(&format!("\n{}", error.text()));
    let missed = args.strict && error.within() == Some(false);
    if missed {
        let mut json = design_facts(&bundle)?;
        json.insert("notes".into(), json!(notes));
        json.insert("error".into(), json!(error.json()));
        return Ok(Outcome {
            text,
            json,
            remarks: error.warnings(),
            failure: Some(too_far(&error)),
        });
    }
    if args.force {
        bundle.replace(&out)?;
    } else {
        bundle.write(&out)?;
    }
    for file in bundle.files() {
        output.detail(&format!("wrote {}", out.join(&file.path).display()));
    }
    let out = out.display().to_string();
    text.push_str(&format!(
        "\nWritten to {out}: {}.\n",
        files_in_words(&bundle)
    ));
    let next = shell_word(&out);
    text.push_str(&format!("Next: hwgen verify {next} --random 200\n"));
    let mut json = facts(&bundle, &out)?;
    json.insert("notes".into(), json!(notes));
    json.insert("error".into(), json!(error.json()));
    Ok(Outcome {
        text,
        json,
        remarks: error.warnings(),
        failure: None,
    })
}

/// The failure that the tolerance is missed.
fn too_far(error: &Judged<'_>) -> Failure {
    let message = format!("fixed point against float: {}", error.figure());
    Failure::new(Exit::Difference, "tolerance", message)
        .help("nothing was written; give more bits, a greater --tolerance, or leave --strict out")
}

/// What a program may want to know of a bundle.
pub(crate) fn facts(bundle: &Bundle, out: &str) -> Result<Map<String, serde_json::Value>, Failure> {
    let (text, manifest) = manifest(bundle)?;
    let mut files = manifest.files.clone();
    files.push(hwgen_gen::ManifestFile {
        path: "manifest.json".into(),
        sha256: hwgen_gen::sha256(text),
    });
    let mut facts = design_facts(bundle)?;
    facts.insert("out".into(), json!(out));
    facts.insert("files".into(), json!(files));
    Ok(facts)
}

fn manifest(bundle: &Bundle) -> Result<(&str, Manifest), Failure> {
    let text = bundle.files().last().map_or("", |f| f.text.as_str());
    let manifest = serde_json::from_str(text)
        .map_err(|e| Failure::input("no-manifest", e.to_string()).file("manifest.json"))?;
    Ok((text, manifest))
}

/// The same without the files.
pub(crate) fn design_facts(bundle: &Bundle) -> Result<Map<String, serde_json::Value>, Failure> {
    let (_, manifest) = manifest(bundle)?;
    let mut facts = Map::new();
    facts.insert("design".into(), json!(manifest.design));
    facts.insert("digest".into(), json!(manifest.digest));
    let wanted = [
        "latency_cycles",
        "interval_cycles",
        "frames_in_flight",
        "multipliers",
        "activation_multipliers",
        "macs",
        "mac_utilization",
        "rom_bits",
        "layers",
        "streams",
        "options",
    ];
    let mut all = fields(&manifest);
    for key in wanted {
        facts.extend(all.remove(key).map(|value| (key.to_owned(), value)));
    }
    Ok(facts)
}

/// The design for people: a table of its layers, and totals.
pub(crate) fn describe(design: &Design, bundle: &Bundle) -> String {
    let networks = design.perceptron().networks.len();
    let mut text = format!(
        "{}: {}, {}, {}; digest {}\n\n",
        design.name(),
        counted(design.input_names().len(), "input"),
        counted(networks, "network"),
        counted(design.sink().words, "output"),
        &bundle.digest()[..bundle.digest().len().min(16)],
    );
    let mut rows = vec![row![
        "layer",
        "size",
        "activation",
        "PE x SIMD",
        "clocks",
        "inputs",
        "weights",
        "outputs",
        "proved range of the sums"
    ]];
    rows.extend(design.perceptron().layers().map(|layer| {
        let quant = &layer.quant;
        let (low, high) = quant.proved_range;
        row![
            quant.name,
            format!("{} x {}", quant.inputs(), quant.outputs()),
            quant.activation.name(),
            match layer.adders() {
                Some(sums) => counted(sums.adders.len(), "adder"),
                None => format!("{} x {}", layer.fold.pe, layer.fold.simd),
            },
            layer.folds(),
            quant.input,
            quant.weight_format,
            quant.output,
            format!("{} .. {}", significant(low), significant(high))
        ]
    }));
    text.push_str(&columns("lllrrllll", &rows));
    text.push_str(&format!(
        "\n  latency {} cycles, one frame every {} cycles\n  {} in the arrays, busy {:.0} %, and \
         {} in the activations\n  {} a frame, {} bits of ROM\n",
        design.latency_cycles(),
        design.interval_cycles(),
        counted(design.multipliers(), "multiplier"),
        100.0 * design.mac_utilization(),
        design.activation_multipliers(),
        counted(design.macs(), "multiplication"),
        design.rom_bits(),
    ));
    text
}

/// What of a design its user should know: inputs of few codes or without effect, and words that
/// can't hold all that interval analysis can't rule out.
pub(crate) fn notes(design: &Design) -> Vec<String> {
    let mut notes: Vec<String> = coarser_than_asked(design).into_iter().collect();
    notes.extend(coarse_inputs(design));
    notes.extend(design.perceptron().layers().filter_map(unread));
    notes.extend(design.perceptron().layers().filter_map(cut));
    notes
}

fn coarser_than_asked(design: &Design) -> Option<String> {
    let input = design.input();
    (input.dropped_bits > 0).then(|| {
        format!(
            "inputs are in steps of {} (format {}), {} bits coarser than the file's resolution: \
             multipliers of {} take no wider words",
            significant(input.format.step()),
            input.format,
            input.dropped_bits,
            design.device().name
        )
    })
}

/// Inputs with fewer codes than this deserve a note.
const FEW_CODES: i64 = 1 << 8;

fn coarse_inputs(design: &Design) -> impl Iterator<Item = String> {
    let input = design.input();
    let edges = input.low.iter().zip(&input.high).zip(&input.formats);
    edges
        .zip(design.input_names())
        .filter_map(|(((low, high), format), name)| {
            let codes = high - low + 1;
            (codes > 1 && codes < FEW_CODES).then(|| {
                format!(
                    "input {name}: its box has {codes} codes only, in steps of {} (format \
                     {format})",
                    significant(format.step())
                )
            })
        })
}

/// Longer lists are cut short.
const MOST_NAMED: usize = 8;

fn unread(layer: &Layer) -> Option<String> {
    let quant = &layer.quant;
    (!quant.unread.is_empty()).then(|| {
        let mut unread: Vec<String> = quant.unread.iter().map(usize::to_string).collect();
        if unread.len() > MOST_NAMED {
            unread.truncate(MOST_NAMED);
            unread.push("...".into());
        }
        format!(
            "{}: all weights of {} {} round to zero beside the greatest, which is held by {}",
            quant.name,
            if unread.len() == 1 { "input" } else { "inputs" },
            unread.join(", "),
            quant.weight_format
        )
    })
}

fn cut(layer: &Layer) -> Option<String> {
    let quant = &layer.quant;
    // A table's argument is clipped where the function is flat: that loses nothing.
    if quant.table.is_some() {
        return None;
    }
    let (mut low, high) = quant.proved_range;
    if quant.activation == Activation::Relu {
        low = low.max(0.0);
    }
    let format = quant.output;
    let (least, most) = (
        format.to_f64(format.min_code()),
        format.to_f64(format.max_code()),
    );
    // Half a step more still rounds to the last code.
    let half = format.step() / 2.0;
    (low < least - half || high >= most + half).then(|| {
        format!(
            "{}: words of {format} hold {} .. {}, the proved range is {} .. {}; beyond they \
             saturate, and the output's flag says so",
            quant.name,
            significant(least),
            significant(most),
            significant(low),
            significant(high),
        )
    })
}

/// `40 files, 31 of them in rtl`.
fn files_in_words(bundle: &Bundle) -> String {
    let mut directories: BTreeMap<&str, usize> = BTreeMap::new();
    let mut single = Vec::new();
    for file in bundle.files() {
        match file.path.split_once('/') {
            Some((directory, _)) => *directories.entry(directory).or_default() += 1,
            None => single.push(file.path.clone()),
        }
    }
    let mut parts: Vec<String> = directories
        .iter()
        .map(|(directory, count)| format!("{directory}/ ({count})"))
        .collect();
    parts.extend(single);
    format!(
        "{}: {}",
        counted(bundle.files().len(), "file"),
        parts.join(", ")
    )
}
