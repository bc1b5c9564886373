//! `cargo bench -p granum`: the measurements of `granum bench`, whose flags are given after `--`.

use std::process::{Command, ExitCode};

fn main() -> ExitCode {
    // Cargo adds the flag `--bench`, which the program does not have.
    let flags = std::env::args().skip(1).filter(|flag| flag != "--bench");
    let done = Command::new(env!("CARGO_BIN_EXE_granum")).arg("bench").args(flags).status();
    if done.is_ok_and(|status| status.success()) { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
