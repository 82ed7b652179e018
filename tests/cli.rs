//! The command line: what is printed where, exit codes, error texts.

#[path = "cli/harness.rs"]
mod harness;

#[path = "cli/emit.rs"]
mod emit;
#[path = "cli/estimate.rs"]
mod estimate;
#[path = "cli/evaluate.rs"]
mod evaluate;
#[path = "cli/faults.rs"]
mod faults;
#[path = "cli/interrupt.rs"]
mod interrupt;
#[path = "cli/run.rs"]
mod run;
#[path = "cli/sample.rs"]
mod sample;
#[path = "cli/synth.rs"]
mod synth;
#[path = "cli/train.rs"]
mod train;
#[path = "cli/trust.rs"]
mod trust;
#[path = "cli/verify.rs"]
mod verify;
