//! The `hwgen` command. All of it is in the library, where it can be tested.

use std::process::ExitCode;

fn main() -> ExitCode {
    hwgen::interrupt::heed();
    hwgen::run(std::env::args_os())
}
