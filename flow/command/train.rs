//! `hwgen train`

use std::path::PathBuf;
use std::time::{Duration, Instant};

use hwgen_pose::sample::{NoiseShape, Sampler};
use hwgen_pose::scene_file;
use hwgen_pose::train::learner::Learner;
use hwgen_pose::train::recipe::{Optimizer, Recipe};
use hwgen_pose::train::{BadCheckpoint, Checkpoint, NETWORKS, Training};
use hwgen_spec::weights::to_json;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use super::Outcome;
use crate::destination::{Destination, Precious};
use crate::failure::Failure;
use crate::interrupt;
use crate::layout::{columns, row, shell_word, significant};
use crate::output::Output;
use crate::picture::training::training_curve;
use crate::scene::SceneFile;

const EXAMPLES: &str = "\
The weights of the epoch that was best on the samples kept back are written, ready for `hwgen emit`.
The same scene, recipe and seed give the same weights on the same kind of processor, whatever the
number of threads.

The preset `best` puts the pixels along their principal axes (a linear layer that both networks
share), draws noise of each level in turn, teaches the mean of all poses that the noisy pixels may
come from, and takes Levenberg-Marquardt steps. The preset `paper` is the method's own recipe:
standardised pixels without noise, 10000 samples, RPROP, weight decay, early stopping.

Ctrl-C ends the training after the epoch under way and writes the best weights so far. The state is
kept beside them, in <W>.checkpoint, every half minute and at the end of an interrupted training;
--resume goes on from there as if nothing had happened.

Examples:
  hwgen train --scene designs/landing/scene.toml --out w.json
  hwgen train --scene scene.toml --hidden 24,16 --seed 7 --out small.json --curve small.svg
  hwgen train --scene scene.toml --preset paper --out paper.json
  hwgen train --scene scene.toml --out w.json --resume";

/// How often the state is kept.
const KEEP_EVERY: Duration = Duration::from_secs(30);

/// How often a line is printed where none is shown in place.
const SAY_EVERY: Duration = Duration::from_secs(10);

/// What `train` takes.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// The scene file: landmarks, camera, poses
    #[arg(long, value_name = "S.toml")]
    pub scene: PathBuf,
    /// Where the weights go
    #[arg(long, value_name = "W.json")]
    pub out: PathBuf,
    /// The recipe that the options below change
    #[arg(
        long,
        value_name = "NAME",
        default_value = "best",
        conflicts_with = "resume"
    )]
    pub preset: Preset,
    /// Neurons of each hidden layer of each network, layer by layer [default: 32,24; paper: 256]
    #[arg(
        long,
        value_name = "N,N",
        value_delimiter = ',',
        conflicts_with = "resume"
    )]
    pub hidden: Option<Vec<usize>>,
    /// Samples, one in five of them kept back for validation [default: 40000; paper: 10000]
    #[arg(long, value_name = "N", conflicts_with = "resume")]
    pub samples: Option<usize>,
    /// Noise levels in px, each for as many samples [default: 0 to 5; paper: 0]
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        allow_negative_numbers = true,
        conflicts_with = "resume"
    )]
    pub noise: Option<Vec<f64>>,
    /// Most passes over all samples, for each network [default: 40; with RPROP 5000]
    #[arg(long, value_name = "N", conflicts_with = "resume")]
    pub epochs: Option<usize>,
    /// Epochs without a better validation loss after which a network is done [default: 10; with
    /// RPROP 200]
    #[arg(long, value_name = "N", conflicts_with = "resume")]
    pub patience: Option<usize>,
    /// How the weights are sought [default: levenberg; paper: rprop]
    #[arg(long, value_name = "NAME", conflicts_with = "resume")]
    pub optimizer: Option<Method>,
    /// Noise in px with which a squared error counts half: less favours clear pixels, more noisy
    /// ones [default: 1]
    #[arg(
        long,
        value_name = "PX",
        allow_negative_numbers = true,
        conflicts_with = "resume"
    )]
    pub noise_half: Option<f64>,
    /// Half this times the weights' square is added to the loss [default: 0; paper: 1e-7]
    #[arg(long, value_name = "X", conflicts_with = "resume")]
    pub weight_decay: Option<f64>,
    /// Seed of samples and first weights
    #[arg(long, value_name = "S", default_value_t = 1, conflicts_with = "resume")]
    pub seed: u64,
    /// Go on with the training that <W.json>.checkpoint holds
    #[arg(long)]
    pub resume: bool,
    /// Draw the losses of all epochs
    #[arg(long, value_name = "F.svg")]
    pub curve: Option<PathBuf>,
    /// Replace files that are there already
    #[arg(long)]
    pub force: bool,
}

/// A named recipe.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Preset {
    /// What measures best
    Best,
    /// The method as it was published
    Paper,
}

/// How the weights are sought.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Method {
    /// Resilient propagation, iRPROP-
    Rprop,
    /// Levenberg and Marquardt's second-order steps
    Levenberg,
}

/// What a checkpoint file holds.
#[derive(Debug, Serialize, Deserialize)]
struct Kept {
    format: String,
    /// The scene, as a scene file says it.
    scene: String,
    #[serde(flatten)]
    checkpoint: Checkpoint,
    seconds: f64,
}

const FORMAT: &str = "hwgen-checkpoint/2";

/// Trains both networks and writes their weights.
///
/// # Errors
/// If scene, recipe or checkpoint are refused, the training diverges, or a result can't be
/// written.
pub fn run(args: &Args, output: &Output) -> Result<Outcome, Failure> {
    let file = SceneFile::read(&args.scene)?;
    let precious = Precious {
        bundle: None,
        inputs: &args.scene,
        // The best so far is beside the checkpoint, and better weights replace it.
        force: args.force || args.resume,
    };
    let out = Destination::new(&args.out, &precious)?;
    let curve = args
        .curve
        .as_ref()
        .map(|path| Destination::new(path, &precious))
        .transpose()?;
    if curve.as_ref().is_some_and(|curve| curve.is(&out)) {
        let message = "--curve: another file than that of --out expected, the same found";
        return Err(Failure::input("same-file", message)
            .file(out.path().display().to_string())
            .help("give --out and --curve a file each"));
    }
    let keeper = Keeper::new(args, &file)?;
    let (seed, checkpoint, before) = if args.resume {
        let kept = keeper.read()?;
        (kept.checkpoint.seed, Some(kept.checkpoint), kept.seconds)
    } else {
        (args.seed, None, 0.0)
    };
    let recipe = match &checkpoint {
        Some(checkpoint) => checkpoint.recipe.clone(),
        None => recipe(args)?,
    };
    let sampler = file.sampler(NoiseShape::Gaussian, seed)?;
    let start = Instant::now();
    let seconds = || before + start.elapsed().as_secs_f64();
    let mut line = output.progress();
    line.show("drawing samples", 0, 2 * recipe.epochs);
    let mut training = begin(&sampler, &recipe, checkpoint, seed).map_err(|error| {
        keeper.refused(
            "bad-checkpoint",
            error.to_string(),
            "begin anew without --resume",
        )
    })?;
    let stop = interrupt::soften();
    let mut kept = Instant::now();
    let mut said: Option<Instant> = None;
    let mut interrupted = false;
    loop {
        let more = training.epoch().map_err(|error| {
            Failure::input("diverged", error.to_string())
                .help("another seed, more samples or fewer neurons may do better")
        })?;
        if !more {
            break;
        }
        if output.in_place() || said.is_none_or(|said| said.elapsed() >= SAY_EVERY) {
            let learners = &training.checkpoint().learners;
            let done = learners.iter().map(|l| l.curve().len()).sum();
            line.show(&activity(learners), done, 2 * recipe.epochs);
            said = Some(Instant::now());
        }
        interrupted = stop.asked();
        if interrupted || kept.elapsed() >= KEEP_EVERY {
            keeper.write(training.checkpoint(), seconds())?;
            kept = Instant::now();
        }
        if interrupted {
            break;
        }
    }
    drop(line);
    drop(stop);
    out.write(to_json(&training.net()).as_bytes())?;
    if let Some(curve) = &curve {
        curve.write(drawn(&training.checkpoint().learners).as_bytes())?;
    }
    if !interrupted {
        keeper.forget();
    }
    Ok(outcome(args, &training, &keeper, interrupted, seconds()))
}

/// The losses of both networks as a picture.
fn drawn(learners: &[Learner; 2]) -> String {
    let losses = learners.each_ref().map(|learner| {
        let pairs = learner.curve().iter();
        pairs.map(|l| (l.train, l.validation)).collect::<Vec<_>>()
    });
    let curves: Vec<_> = NETWORKS
        .iter()
        .zip(&losses)
        .zip(learners)
        .map(|(((name, ..), losses), learner)| (*name, losses.as_slice(), learner.best_epoch()))
        .collect();
    training_curve(&curves)
}

/// Draws the samples, and puts the weights where they start.
fn begin<'a>(
    sampler: &Sampler<'a>,
    recipe: &Recipe,
    checkpoint: Option<Checkpoint>,
    seed: u64,
) -> Result<Training<'a>, BadCheckpoint> {
    match checkpoint {
        Some(checkpoint) => Training::resume(sampler, checkpoint),
        None => Ok(Training::new(sampler, recipe.clone(), seed)),
    }
}

fn recipe(args: &Args) -> Result<Recipe, Failure> {
    let mut recipe = match args.preset {
        Preset::Best => Recipe::best(),
        Preset::Paper => Recipe::paper(),
    };
    if let Some(method) = args.optimizer {
        recipe = recipe.with_optimizer(match method {
            Method::Rprop => Optimizer::Rprop,
            Method::Levenberg => Optimizer::Levenberg,
        });
    }
    let set = |field: &mut usize, value: Option<usize>| {
        if let Some(value) = value {
            *field = value;
        }
    };
    if let Some(hidden) = &args.hidden {
        recipe.hidden.clone_from(hidden);
    }
    set(&mut recipe.samples, args.samples);
    set(&mut recipe.epochs, args.epochs);
    set(&mut recipe.patience, args.patience);
    if let Some(noise) = &args.noise {
        recipe.noise_px.clone_from(noise);
    }
    if let Some(half) = args.noise_half {
        recipe.noise_half_px = half;
    }
    if let Some(decay) = args.weight_decay {
        recipe.weight_decay = decay;
    }
    recipe.check().map_err(|error| {
        let option = error.field.replace('_', "-");
        Failure::input("recipe", format!("--{option}: {}", error.reason))
            .help("`hwgen train --help` lists the defaults")
    })?;
    Ok(recipe)
}

/// What the line of progress says.
fn activity(learners: &[Learner; 2]) -> String {
    let networks = NETWORKS.iter().zip(learners);
    let words = networks.map(|((name, ..), learner)| {
        match (learner.curve().last(), learner.best_losses()) {
            (Some(last), Some(best)) => format!(
                "{name}: epoch {}, loss {}, validation {}, best {} at {}",
                learner.curve().len(),
                significant(last.train),
                significant(last.validation),
                significant(best.validation),
                learner.best_epoch(),
            ),
            _ => (*name).to_owned(),
        }
    });
    words.collect::<Vec<_>>().join("; ")
}

/// The checkpoint beside the weights.
#[derive(Debug)]
struct Keeper {
    path: PathBuf,
    scene_path: PathBuf,
    scene: String,
}

impl Keeper {
    fn new(args: &Args, file: &SceneFile) -> Result<Self, Failure> {
        let mut name = args.out.clone().into_os_string();
        name.push(".checkpoint");
        let keeper = Self {
            path: name.into(),
            scene_path: args.scene.clone(),
            scene: scene_file::write(file.scene()),
        };
        if !args.resume && !args.force && keeper.path.exists() {
            return Err(Failure::input(
                "exists",
                "no checkpoint expected, that of an interrupted training found",
            )
            .file(keeper.path.display().to_string())
            .help("go on with it with --resume, or drop it with --force"));
        }
        Ok(keeper)
    }

    fn refused(&self, code: &'static str, message: String, help: &str) -> Failure {
        let path = self.path.display().to_string();
        Failure::input(code, message).file(path).help(help)
    }

    fn read(&self) -> Result<Kept, Failure> {
        let path = &self.path;
        let refused = |code, message, help: &str| self.refused(code, message, help);
        let text = std::fs::read(path).map_err(|e| Failure::io(path, &e))?;
        let kept: Kept = serde_json::from_slice(&text).map_err(|e| {
            refused(
                "bad-checkpoint",
                format!("a checkpoint of `hwgen train` expected: {e}"),
                "begin anew without --resume",
            )
            .at(e.line(), Some(e.column()))
        })?;
        if kept.format != FORMAT {
            let message = format!("format {FORMAT} expected, {} found", kept.format);
            return Err(refused(
                "bad-checkpoint",
                message,
                "begin anew without --resume",
            ));
        }
        if kept.scene != self.scene {
            return Err(refused(
                "other-scene",
                "a training on this scene expected, one on another found".into(),
                "give the scene that it was begun with, or begin anew without --resume",
            ));
        }
        Ok(kept)
    }

    fn write(&self, checkpoint: &Checkpoint, seconds: f64) -> Result<(), Failure> {
        let kept = Kept {
            format: FORMAT.into(),
            scene: self.scene.clone(),
            checkpoint: checkpoint.clone(),
            seconds,
        };
        let text = serde_json::to_vec(&kept).expect("numbers and texts are always JSON");
        let precious = Precious {
            bundle: None,
            inputs: &self.scene_path,
            force: true,
        };
        Destination::new(&self.path, &precious)?.write(&text)
    }

    /// Nobody misses the state of a training that is done.
    fn forget(&self) {
        let _ = std::fs::remove_file(&self.path);
    }
}

fn outcome(
    args: &Args,
    training: &Training<'_>,
    keeper: &Keeper,
    interrupted: bool,
    seconds: f64,
) -> Outcome {
    let Checkpoint {
        recipe,
        seed,
        learners,
    } = training.checkpoint();
    let stopped_by = |learner: &Learner| learner.stop().map_or("interrupt", |stop| stop.name());
    let mut rows = vec![row![
        "network",
        "neurons",
        "epochs",
        "best",
        "stopped by",
        "training MSE",
        "validation MSE"
    ]];
    let mut networks = Vec::new();
    for ((name, ..), learner) in NETWORKS.iter().zip(learners) {
        // The loss is half the mean square.
        let mse = |loss: f64| 2.0 * loss;
        let best = learner.best_losses();
        let cell = |loss: Option<f64>| loss.map_or("-".into(), |l| significant(mse(l)));
        rows.push(row![
            name,
            sizes(&learner.shape().hidden),
            learner.curve().len(),
            learner.best_epoch(),
            stopped_by(learner),
            cell(best.map(|b| b.train)),
            cell(best.map(|b| b.validation)),
        ]);
        networks.push(json!({
            "name": name,
            "hidden": learner.shape().hidden,
            "epochs": learner.curve().len(),
            "best_epoch": learner.best_epoch(),
            "stopped_by": stopped_by(learner),
            "train_mse": best.map(|b| mse(b.train)),
            "validation_mse": best.map(|b| mse(b.validation)),
        }));
    }
    let out = args.out.display().to_string();
    let scene = shell_word(&args.scene.display().to_string());
    let weights = shell_word(&out);
    let mut text = columns("lrrrlrr", &rows);
    text.push_str(&format!(
        "\n{} samples, seed {seed}, {} s. Written to {out}.\n",
        recipe.samples,
        significant(seconds),
    ));
    if interrupted {
        text.push_str(&format!(
            "Interrupted: the best so far is written, the state is in {}.\n\
             Next: hwgen train --scene {scene} --out {weights} --resume\n",
            keeper.path.display()
        ));
    } else {
        text.push_str(&format!(
            "Next: hwgen evaluate --scene {scene} --weights {weights} --noise 0,0.1,1,3,5 --count 4000\n      \
             hwgen emit --weights {weights}\n"
        ));
    }
    let json = Map::from_iter([
        ("networks".to_owned(), Value::from(networks)),
        ("seconds".to_owned(), json!(seconds)),
        ("out".to_owned(), json!(out)),
        ("seed".to_owned(), json!(seed)),
        ("recipe".to_owned(), json!(recipe)),
        ("interrupted".to_owned(), json!(interrupted)),
    ]);
    Outcome {
        text,
        json,
        remarks: Vec::new(),
        failure: None,
    }
}

/// Neurons of the hidden layers, as they are told.
fn sizes(hidden: &[usize]) -> String {
    let sizes: Vec<String> = hidden.iter().map(usize::to_string).collect();
    sizes.join(", ")
}
