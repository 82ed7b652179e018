//! `hwgen evaluate`

use std::path::{Path, PathBuf};

use hwgen_gen::Source;
use hwgen_pose::evaluate::{Evaluation, FloatEstimator, Method, Misfit, Row, Wiring};
use hwgen_pose::sample::Sampler;
use hwgen_spec::design::Design;
use hwgen_spec::network::FloatNet;
use hwgen_spec::options::Options;
use serde_json::{Map, Value, json};

use super::sample::{Shape, noise};
use super::{Outcome, fields, request};
use crate::destination::{Destination, Precious};
use crate::failure::Failure;
use crate::fixed::FixedEstimator;
use crate::output::Output;
use crate::picture::{errors, view};
use crate::scene::SceneFile;
use crate::table::to_csv;

mod text;

const EXAMPLES: &str = "\
All estimators answer the same poses, and at every level the same noise but for its size. Errors are
means of |estimate - truth| / |truth| in percent, for the position and for the rotation vector, then
of distances in m and angles in deg. Poses that an estimator fails on are counted, and are not in
its means. Times are those of one thread, the least of some passes over at most 128 of the poses.

  paper          what was published of the method, at its levels; its scene is not known
  crb            Cramer-Rao bound: the least expected error of an unbiased estimate
  ml             maximum likelihood: least squares in the image, to convergence
  bayes          mean of all poses that the pixels may come from, for a known size of noise
  epnp, sqpnp    closed forms
  p3p-ransac     consensus of triples of landmarks, refined
  network-float  the networks of --weights or --bundle in floating point
  network-fixed  the same as the hardware computes them; --weights with the options of `hwgen emit`

Examples:
  hwgen evaluate --scene designs/landing/scene.toml --weights designs/landing/weights.json
  hwgen evaluate --scene scene.toml --bundle build/landing --noise 0.5,1,2 --count 10000
  hwgen evaluate --scene scene.toml --estimators crb,bayes,epnp --picture errors.svg --csv errors.csv
  hwgen evaluate --scene scene.toml --view view.svg";

/// What `evaluate` takes.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// The scene file: landmarks, camera, poses
    #[arg(long, value_name = "S.toml")]
    pub scene: PathBuf,
    /// Trained weights for the scene
    #[arg(long, value_name = "W.json", conflicts_with = "bundle")]
    pub weights: Option<PathBuf>,
    /// Directory of a bundle made from them
    #[arg(long, value_name = "DIR")]
    pub bundle: Option<PathBuf>,
    /// Levels of noise on each pixel coordinate, in px: standard deviation, or greatest if uniform
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = noise,
        allow_negative_numbers = true, default_value = "0,0.1,1,3,5")]
    pub noise: Vec<f64>,
    /// Distribution of the noise
    #[arg(long, value_name = "SHAPE", default_value = "gaussian")]
    pub noise_shape: Shape,
    /// How many poses
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true,
        default_value = "1000")]
    pub count: u64,
    /// Seed of the poses and their noise
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub seed: u64,
    /// Which rows [default: all, those of networks if there are some]
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub estimators: Vec<Contender>,
    /// Write the rows as a table
    #[arg(long, value_name = "F.csv")]
    pub csv: Option<PathBuf>,
    /// Draw errors against noise
    #[arg(long, value_name = "F.svg")]
    pub picture: Option<PathBuf>,
    /// Draw what the camera sees in some poses
    #[arg(long, value_name = "F.svg")]
    pub view: Option<PathBuf>,
    /// Replace files that are there
    #[arg(long)]
    pub force: bool,
}

/// Most poses.
const MOST: u64 = 10_000_000;

fn count(text: &str) -> Result<u64, String> {
    match text.parse() {
        Ok(count) if (1..=MOST).contains(&count) => Ok(count),
        _ => Err(format!("a whole number from 1 to {MOST} expected")),
    }
}

/// A row of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Contender {
    /// It needs no trained networks.
    Method(Method),
    /// The networks in floating point.
    NetworkFloat,
    /// The networks as the hardware computes them.
    NetworkFixed,
}

impl Contender {
    fn name(self) -> &'static str {
        match self {
            Self::Method(method) => method.name(),
            Self::NetworkFloat => "network-float",
            Self::NetworkFixed => "network-fixed",
        }
    }

    fn needs_networks(self) -> bool {
        !matches!(self, Self::Method(_))
    }
}

impl clap::ValueEnum for Contender {
    fn value_variants<'a>() -> &'a [Self] {
        use Method::{Bayes, Crb, Epnp, Ml, P3pRansac, Paper, Sqpnp};
        &[
            Self::Method(Paper),
            Self::Method(Crb),
            Self::Method(Ml),
            Self::Method(Bayes),
            Self::Method(Epnp),
            Self::Method(Sqpnp),
            Self::Method(P3pRansac),
            Self::NetworkFloat,
            Self::NetworkFixed,
        ]
    }

    fn to_possible_value(&self) -> Option<clap::builder::PossibleValue> {
        Some(clap::builder::PossibleValue::new(self.name()))
    }
}

/// Trained networks for the scene.
struct Networks {
    net: FloatNet,
    design: Design,
    wiring: Wiring,
}

/// Measures, and prints, writes and draws what came of it.
///
/// # Errors
/// If scene, networks or arguments are refused, or a result can't be written.
pub fn run(args: &Args, output: &Output) -> Result<Outcome, Failure> {
    let contenders = contenders(args)?;
    check_levels(&args.noise)?;
    let [csv, picture, seen] = destinations(args)?;
    let file = SceneFile::read(&args.scene)?;
    let networks = networks(args, &file)?;
    let sampler = file.sampler(args.noise_shape.into(), args.seed)?;
    let rows = measure(args, &contenders, &sampler, networks.as_ref(), output);

    let mut written = Vec::new();
    let mut write = |key: &str, to: &Option<Destination>, text: &dyn Fn() -> String| {
        if let Some(to) = to {
            to.write(text().as_bytes())?;
            written.push((key.to_owned(), to.path().display().to_string()));
        }
        Ok::<(), Failure>(())
    };
    write("csv", &csv, &|| csv_of(&rows))?;
    write("picture", &picture, &|| {
        errors::picture(&rows, file.scene().name())
    })?;
    let largest = args.noise.iter().copied().fold(0.0, f64::max);
    write("view", &seen, &|| view::picture(&sampler, largest))?;

    let notes = text::notes(
        &rows,
        args.noise_shape,
        networks.as_ref().map(|n| &n.design),
    );
    let mut report = format!(
        "{}: {} landmarks, {} poses, {} noise, seed {}\n",
        file.scene().name(),
        file.scene().landmarks_m().len(),
        args.count,
        args.noise_shape.name(),
        args.seed,
    );
    report.push_str(&text::tables(&rows, &args.noise));
    for note in &notes {
        report.push_str(&format!("note: {note}\n"));
    }
    for (_, path) in &written {
        report.push_str(&format!("Written to {path}.\n"));
    }
    let mut json = Map::from_iter([
        ("scene".to_owned(), json!(file.scene().name())),
        (
            "landmarks".to_owned(),
            json!(file.scene().landmarks_m().len()),
        ),
        ("count".to_owned(), json!(args.count)),
        ("seed".to_owned(), json!(args.seed)),
        ("noise_shape".to_owned(), json!(args.noise_shape.name())),
        ("rows".to_owned(), json!(rows)),
        ("notes".to_owned(), json!(notes)),
    ]);
    if let Some(networks) = &networks {
        let design = &networks.design;
        json.insert("latency_cycles".into(), json!(design.latency_cycles()));
        json.insert("interval_cycles".into(), json!(design.interval_cycles()));
    }
    json.extend(written.into_iter().map(|(key, path)| (key, json!(path))));
    Ok(Outcome {
        text: report,
        json,
        ..Outcome::default()
    })
}

/// The rows that are asked for, in the order of the table.
fn contenders(args: &Args) -> Result<Vec<Contender>, Failure> {
    let networks = args.weights.is_some() || args.bundle.is_some();
    let all = <Contender as clap::ValueEnum>::value_variants().iter();
    let wanted: Vec<Contender> = if args.estimators.is_empty() {
        all.filter(|c| networks || !c.needs_networks())
            .copied()
            .collect()
    } else {
        all.filter(|c| args.estimators.contains(c))
            .copied()
            .collect()
    };
    match wanted.iter().find(|c| c.needs_networks() && !networks) {
        Some(contender) => {
            let message = format!(
                "--weights or --bundle expected for the estimator {}, neither found",
                contender.name()
            );
            Err(Failure::input("no-networks", message)
                .help("name the weights file, or leave the estimator out"))
        }
        None => Ok(wanted),
    }
}

fn check_levels(levels_px: &[f64]) -> Result<(), Failure> {
    let twice = (1..levels_px.len()).find(|i| levels_px[..*i].contains(&levels_px[*i]));
    match twice {
        Some(i) => {
            let message = format!(
                "--noise: levels that differ expected, {} found twice",
                levels_px[i]
            );
            Err(Failure::input("usage", message).help("name each level once, as in 0,0.1,1,3,5"))
        }
        None => Ok(()),
    }
}

/// Where table, picture and view go: looked at before the work, not after it.
fn destinations(args: &Args) -> Result<[Option<Destination>; 3], Failure> {
    let read = [Some(&args.scene), args.weights.as_ref()];
    let mut placed: Vec<Option<Destination>> = Vec::new();
    for (option, path) in [
        ("--csv", &args.csv),
        ("--picture", &args.picture),
        ("--view", &args.view),
    ] {
        let Some(path) = path else {
            placed.push(None);
            continue;
        };
        let mut place = None;
        for inputs in read.iter().flatten() {
            place = Some(Destination::new(
                path,
                &Precious {
                    bundle: args.bundle.as_deref(),
                    inputs,
                    force: args.force,
                },
            )?);
        }
        let taken = |other: &Destination| place.as_ref().is_some_and(|place| place.is(other));
        if placed.iter().flatten().any(taken) {
            let message = format!("another file for {option} expected, one that is taken found");
            return Err(Failure::input("same-file", message)
                .file(path.display().to_string())
                .help("give --csv, --picture and --view a file each"));
        }
        placed.push(place);
    }
    Ok(placed.try_into().expect("three options"))
}

fn networks(args: &Args, file: &SceneFile) -> Result<Option<Networks>, Failure> {
    let (net, design, path) = match (&args.weights, &args.bundle) {
        (Some(weights), _) => {
            let net = request::read_weights(weights)?;
            let design = Design::new(&net, &Options::default())?;
            (net, design, weights.clone())
        }
        (None, Some(bundle)) => {
            let source = Source::read(bundle)?;
            (source.net, source.design, bundle.join("weights.json"))
        }
        (None, None) => return Ok(None),
    };
    let wiring = Wiring::new(&net, file.scene()).map_err(|error| misfit(&path, &error))?;
    Ok(Some(Networks {
        net,
        design,
        wiring,
    }))
}

fn misfit(path: &Path, error: &Misfit) -> Failure {
    let mut failure = Failure::input("misfit", error.to_string())
        .file(path.display().to_string())
        .help(error.help());
    failure.path = Some(error.path().to_owned());
    failure
}

fn measure(
    args: &Args,
    contenders: &[Contender],
    sampler: &Sampler<'_>,
    networks: Option<&Networks>,
    output: &Output,
) -> Vec<Row> {
    let evaluation = Evaluation::new(sampler, args.count);
    let fixed = networks.map(|n| FixedEstimator::new(&n.design, &n.wiring));
    let float = networks.map(|n| FloatEstimator::new(&n.net, &n.wiring));
    let mut line = output.progress();
    let mut rows = Vec::new();
    for (done, contender) in contenders.iter().enumerate() {
        line.show(contender.name(), done, contenders.len());
        rows.extend(args.noise.iter().filter_map(|noise_px| match contender {
            Contender::Method(method) => evaluation.row(*method, *noise_px),
            Contender::NetworkFloat => Some(evaluation.measure(float.as_ref()?, *noise_px)),
            Contender::NetworkFixed => Some(evaluation.measure(fixed.as_ref()?, *noise_px)),
        }));
    }
    rows
}

fn csv_of(rows: &[Row]) -> String {
    const COLUMNS: [&str; 9] = [
        "estimator",
        "noise_px",
        "position_pct",
        "orientation_pct",
        "position_m",
        "orientation_deg",
        "us_per_pose",
        "failures",
        "effective_samples",
    ];
    let cells = rows.iter().map(|row| {
        let row = fields(row);
        let cell = |name: &str| match row.get(name) {
            None | Some(Value::Null) => String::new(),
            Some(Value::String(text)) => text.clone(),
            Some(number) => number.to_string(),
        };
        COLUMNS.map(cell).to_vec()
    });
    to_csv(&COLUMNS.map(str::to_owned), cells)
}
