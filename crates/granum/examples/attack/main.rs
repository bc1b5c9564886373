//! Attacks the program as damaged files, hostile names and bad luck do, in random cases that follow from a seed.
//!
//! Each case damages a file that commands read (bits, bytes, numbers, lines, another run's file in its place, a device or a folder
//! in its place), gives a hostile name, or disturbs a work (signals, several starts at once, a full disk, lost outputs). Nothing may
//! end by a panic or a signal, take longer than ten seconds or more memory than a limit, fail without a message, leave half-written
//! files, or succeed with other results than those of the undamaged files where the record of a run vouches for them.
//!
//! ```text
//! cargo build -p granum && cargo run -p granum --example attack -- --seconds 3600 --seed 1
//! cargo run -p granum --example attack -- --seed 1 --only 17
//! ```
//!
//! A case that fails is kept in the folder `attack-faults` with what was done to it and the commands.

#[cfg(unix)]
mod damage;
#[cfg(unix)]
mod edits;
#[cfg(unix)]
mod files;
#[cfg(unix)]
mod ground;
#[cfg(unix)]
mod judge;
#[cfg(unix)]
mod names;
#[cfg(unix)]
mod options;
#[cfg(unix)]
mod process;
#[cfg(unix)]
mod random;
#[cfg(unix)]
mod rounds;
#[cfg(unix)]
mod targets;
#[cfg(unix)]
mod unlucky;

#[cfg(unix)]
use rounds::{Case, Fault};

#[cfg(unix)]
fn main() -> std::process::ExitCode {
    let result = options::Options::read(std::env::args().skip(1)).and_then(|options| rounds::all(&options));
    match result {
        Ok(0) => std::process::ExitCode::SUCCESS,
        Ok(_) => std::process::ExitCode::FAILURE,
        Err(why) => {
            eprintln!("{why}");
            std::process::ExitCode::from(2)
        }
    }
}

#[cfg(not(unix))]
fn main() {
    eprintln!("the attack needs a Unix system: it limits and signals processes");
}
