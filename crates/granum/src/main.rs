//! The granum program.

use std::process::ExitCode;

use granum::prelude::Registry;

fn main() -> ExitCode {
    granum::program::run(Registry::standard())
}
