//! The command line.

use clap::{Args, CommandFactory, Parser, Subcommand};

use crate::command::{
    Outcome, demo, doctor, emit, estimate, evaluate, run, sample, schema, synth, train, verify,
};
use crate::failure::Failure;
use crate::output::Output;

const EXAMPLES: &str = "\
Examples:
  hwgen demo                                   a trained design, from weights to checked Verilog
  hwgen emit --weights w.json                  the bundle build/<name>: Verilog, bench, manifest
  hwgen verify build/<name> --random 200       compare it with the model, clock by clock
  hwgen run build/<name> --inputs in.csv       infer with it, in fixed point
  hwgen synth build/<name> --device ecp5-85k   place and route it with open tools

Exit codes: 0 done and true; 1 a check found a difference; 2 bad usage or bad input;
3 an external tool is missing, failed or ran out of time; 128 + signal if one stopped it.";

/// Trained neural networks to synthesizable Verilog, checked clock by clock.
#[derive(Debug, Parser)]
#[command(name = "hwgen", version, after_help = EXAMPLES)]
pub struct Cli {
    /// What every command takes.
    #[command(flatten)]
    pub global: Global,
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// What every command takes.
#[derive(Clone, Debug, Args)]
pub struct Global {
    /// Print the result as one JSON object on standard output
    #[arg(long, global = true)]
    pub json: bool,
    /// Print no messages and no progress, errors aside
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// Print more: each file, each step, each tool
    #[arg(long, short, global = true, conflicts_with = "quiet")]
    pub verbose: bool,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Turn trained weights into a bundle: Verilog, bench, scripts, manifest
    Emit(emit::Args),
    /// Estimate what a bundle will take of a device, without any tool
    Estimate(estimate::Args),
    /// Compare a bundle with the model in simulators, register by register, clock by clock
    Verify(verify::Args),
    /// Infer with a bundle's fixed-point arithmetic, in software
    Run(run::Args),
    /// Draw poses of a scene, and the pixels that its camera sees of them
    Sample(sample::Args),
    /// Train the networks of a scene
    Train(train::Args),
    /// Compare estimators of the pose, and the limits of any, at levels of noise
    Evaluate(evaluate::Args),
    /// Synthesise, place and route a bundle: what it takes of a device, and how fast it is
    Synth(synth::Args),
    /// List the external tools: version, what each enables, how to install it
    Doctor(doctor::Args),
    /// Print the JSON Schema of the weights file
    Schema(schema::Args),
    /// Build and check the landing design, and measure its errors in metres and degrees
    Demo(demo::Args),
}

impl Command {
    /// The name on the command line.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Emit(_) => "emit",
            Self::Estimate(_) => "estimate",
            Self::Verify(_) => "verify",
            Self::Run(_) => "run",
            Self::Sample(_) => "sample",
            Self::Train(_) => "train",
            Self::Evaluate(_) => "evaluate",
            Self::Synth(_) => "synth",
            Self::Doctor(_) => "doctor",
            Self::Schema(_) => "schema",
            Self::Demo(_) => "demo",
        }
    }

    /// Does it.
    ///
    /// # Errors
    /// What is to be told instead of a result.
    pub fn run(&self, output: &Output) -> Result<Outcome, Failure> {
        match self {
            Self::Emit(args) => emit::run(args, output),
            Self::Estimate(args) => estimate::run(args),
            Self::Verify(args) => verify::run(args, output),
            Self::Run(args) => run::run(args, output),
            Self::Sample(args) => sample::run(args, output),
            Self::Train(args) => train::run(args, output),
            Self::Evaluate(args) => evaluate::run(args, output),
            Self::Synth(args) => synth::run(args, output),
            Self::Doctor(args) => doctor::run(args),
            Self::Schema(args) => schema::run(args),
            Self::Demo(args) => demo::run(args, output),
        }
    }
}

/// The names of all commands.
pub fn names() -> impl Iterator<Item = String> {
    let names: Vec<String> = Cli::command()
        .get_subcommands()
        .map(|c| c.get_name().to_owned())
        .collect();
    names.into_iter()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_sound() {
        Cli::command().debug_assert();
    }
}
