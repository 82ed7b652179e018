//! `hwgen sample`

use std::fmt::Write;
use std::io;
use std::ops::Range;
use std::path::PathBuf;

use hwgen_pose::sample::{NoiseShape, Sample, Sampler};
use rayon::prelude::*;
use serde_json::{Map, Value, json};

use super::Outcome;
use crate::aside::Aside;
use crate::destination::{Destination, Precious};
use crate::failure::Failure;
use crate::layout::{counted, significant};
use crate::output::Output;
use crate::scene::SceneFile;

const EXAMPLES: &str = "\
A row a sample: the noisy pixel coordinates u0,v0,u1,v1,... in the order of the scene's landmarks,
then the true pose: the camera's position x_m,y_m,z_m and the rotation vector rx_rad,ry_rad,rz_rad.
The same scene, seed and shape of noise give the same poses at any level of noise, on any machine.

Without --out the table goes to standard output and the summary to standard error; with --json the
object then holds it as `columns` and `rows`, so that large tables want --out.

Examples:
  hwgen sample --scene designs/landing/scene.toml --count 1000 --noise 1 --seed 7 --out poses.csv
  hwgen sample --scene scene.toml --count 5 --noise 0
  hwgen run build/landing --inputs poses.csv   the table is what `run` and `verify` take";

const POSE_COLUMNS: [&str; 6] = ["x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad"];

/// Samples that one task draws.
const CHUNK: u64 = 512;
/// Chunks that are in memory at once.
const CHUNKS: u64 = 32;

/// What `sample` takes.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// The scene file: landmarks, camera, poses
    #[arg(long, value_name = "S.toml")]
    pub scene: PathBuf,
    /// How many samples
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    pub count: u64,
    /// Noise on each pixel coordinate, in px: standard deviation, or greatest if uniform
    #[arg(long, value_name = "SIGMA", value_parser = noise, allow_negative_numbers = true)]
    pub noise: f64,
    /// Distribution of the noise
    #[arg(long, value_name = "SHAPE", default_value = "gaussian")]
    pub noise_shape: Shape,
    /// Seed of the random numbers
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub seed: u64,
    /// Where the table goes [default: standard output]
    #[arg(long, value_name = "F.csv")]
    pub out: Option<PathBuf>,
    /// Replace a file that is there already
    #[arg(long)]
    pub force: bool,
}

/// Most samples of a table.
const MOST: u64 = 1_000_000_000;

/// Distribution of the noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Shape {
    /// Normal, with SIGMA as its standard deviation
    Gaussian,
    /// Even from -SIGMA to SIGMA
    Uniform,
}

impl Shape {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Gaussian => "gaussian",
            Self::Uniform => "uniform",
        }
    }
}

impl From<Shape> for NoiseShape {
    fn from(shape: Shape) -> Self {
        match shape {
            Shape::Gaussian => Self::Gaussian,
            Shape::Uniform => Self::Uniform,
        }
    }
}

fn count(text: &str) -> Result<u64, String> {
    match text.parse() {
        Ok(count) if (1..=MOST).contains(&count) => Ok(count),
        _ => Err(format!("a whole number from 1 to {MOST} expected")),
    }
}

pub(super) fn noise(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(noise) if noise.is_finite() && noise >= 0.0 => Ok(noise),
        _ => Err("a finite number of pixels, zero or more, expected".into()),
    }
}

/// Draws samples, and prints or writes them as they come.
///
/// # Errors
/// If the scene is refused or its landmarks are almost never in view, or the table can't be
/// written.
pub fn run(args: &Args, output: &Output) -> Result<Outcome, Failure> {
    let file = SceneFile::read(&args.scene)?;
    let sampler = file.sampler(args.noise_shape.into(), args.seed)?;
    let mut header = file.scene().input_names();
    header.extend(POSE_COLUMNS.map(str::to_owned));

    let mut sink = Sink::open(args, output)?;
    sink.header(&header)?;
    let mut drawn = 0;
    let mut done = 0;
    let mut line = output.progress();
    while done < args.count && sink.wanted() {
        let end = args.count.min(done + CHUNK * CHUNKS);
        line.show("drawing samples", number(done), number(args.count));
        let chunks: Vec<Chunk> = chunks(done..end)
            .into_par_iter()
            .map(|indices| sink.draw(&sampler, args.noise, indices))
            .collect();
        for chunk in chunks {
            drawn += chunk.drawn;
            sink.take(chunk)?;
        }
        done = end;
    }
    drop(line);

    #[expect(
        clippy::cast_precision_loss,
        reason = "a fraction for people and statistics"
    )]
    let accepted = done as f64 / drawn as f64;
    let mut json = Map::from_iter([
        ("scene".to_owned(), json!(file.scene().name())),
        ("count".to_owned(), json!(args.count)),
        ("accepted_fraction".to_owned(), json!(accepted)),
        ("seed".to_owned(), json!(args.seed)),
        ("noise_px".to_owned(), json!(args.noise)),
        ("noise_shape".to_owned(), json!(args.noise_shape.name())),
        ("columns".to_owned(), json!(header)),
    ]);
    let mut summary = format!(
        "{} of the scene {}, {} noise of {} px, seed {}; {} % of the poses drawn were in view",
        counted(number(done), "sample"),
        file.scene().name(),
        args.noise_shape.name(),
        args.noise,
        args.seed,
        significant(100.0 * accepted),
    );
    let (text, remarks) = match sink.close(&mut json)? {
        Some(out) => {
            let _ = write!(summary, "\nWritten to {out}.\n");
            (summary, Vec::new())
        }
        None => (String::new(), vec![summary]),
    };
    Ok(Outcome {
        text,
        json,
        remarks,
        failure: None,
    })
}

/// Some samples, in order.
struct Chunk {
    rows: Rows,
    /// Poses drawn for them.
    drawn: u64,
}

/// Samples in the form in which they leave.
enum Rows {
    Text(String),
    Values(Vec<Value>),
}

fn chunks(indices: Range<u64>) -> Vec<Range<u64>> {
    let starts = indices.clone().step_by(usize::try_from(CHUNK).unwrap_or(1));
    starts
        .map(|start| start..indices.end.min(start + CHUNK))
        .collect()
}

fn cells(sample: &Sample, noise_px: f64) -> impl Iterator<Item = f64> {
    let position = sample.pose.position_m;
    let turn = sample.pose.rodrigues_rad();
    let pose = [position.x, position.y, position.z, turn.x, turn.y, turn.z];
    sample.noisy_px(noise_px).into_iter().chain(pose)
}

/// Where the table goes.
enum Sink<'a> {
    File(PathBuf, Aside),
    /// Standard output, until its reader goes away.
    Stream(&'a Output, bool),
    /// The object that is printed at the end.
    Object(Vec<Value>),
}

impl<'a> Sink<'a> {
    fn open(args: &Args, output: &'a Output) -> Result<Self, Failure> {
        match &args.out {
            Some(out) => {
                let precious = Precious {
                    bundle: None,
                    inputs: &args.scene,
                    force: args.force,
                };
                let place = Destination::new(out, &precious)?;
                Ok(Self::File(out.clone(), place.begin()?))
            }
            None if output.json() => Ok(Self::Object(Vec::new())),
            None => Ok(Self::Stream(output, true)),
        }
    }

    /// Whether anybody still takes rows.
    fn wanted(&self) -> bool {
        !matches!(self, Self::Stream(_, false))
    }

    fn header(&mut self, names: &[String]) -> Result<(), Failure> {
        match self {
            Self::Object(_) => Ok(()),
            _ => self.text(&(names.join(",") + "\n")),
        }
    }

    fn draw(&self, sampler: &Sampler<'_>, noise_px: f64, indices: Range<u64>) -> Chunk {
        let mut drawn = 0;
        let samples = indices.map(|index| {
            let sample = sampler.draw(index);
            drawn += u64::from(sample.drawn);
            sample
        });
        let rows = match self {
            Self::Object(_) => {
                let row = |sample| cells(&sample, noise_px).map(Value::from).collect();
                Rows::Values(samples.map(row).collect())
            }
            _ => {
                let mut text = String::new();
                for sample in samples {
                    for (i, cell) in cells(&sample, noise_px).enumerate() {
                        let comma = if i == 0 { "" } else { "," };
                        // Writing to memory does not fail.
                        let _ = write!(text, "{comma}{cell}");
                    }
                    text.push('\n');
                }
                Rows::Text(text)
            }
        };
        Chunk { rows, drawn }
    }

    fn take(&mut self, chunk: Chunk) -> Result<(), Failure> {
        match (self, chunk.rows) {
            (Self::Object(all), Rows::Values(rows)) => all.extend(rows),
            (sink, Rows::Text(text)) => sink.text(&text)?,
            (_, Rows::Values(_)) => unreachable!("values are drawn for an object"),
        }
        Ok(())
    }

    fn text(&mut self, text: &str) -> Result<(), Failure> {
        match self {
            Self::File(_, aside) => aside.write(text.as_bytes()),
            Self::Stream(_, false) | Self::Object(_) => Ok(()),
            Self::Stream(output, wanted) => match output.write(text) {
                Err(e) if e.kind() == io::ErrorKind::BrokenPipe => {
                    *wanted = false;
                    Ok(())
                }
                other => other
                    .map_err(|e| Failure::input("output", e.to_string()).file("standard output")),
            },
        }
    }

    /// Finishes, and says where the file is if there is one.
    fn close(self, json: &mut Map<String, Value>) -> Result<Option<String>, Failure> {
        match self {
            Self::File(path, aside) => {
                aside.keep()?;
                let out = path.display().to_string();
                json.insert("out".into(), json!(out));
                Ok(Some(out))
            }
            Self::Stream(..) => Ok(None),
            Self::Object(rows) => {
                json.insert("rows".into(), Value::Array(rows));
                Ok(None)
            }
        }
    }
}

fn number(count: u64) -> usize {
    usize::try_from(count).unwrap_or(usize::MAX)
}
