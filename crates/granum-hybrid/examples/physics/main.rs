//! Studies behind `VALIDATION.md` that are too long for a test:
//!
//! ```sh
//! cargo run --release -p granum-hybrid --example physics -- STUDY
//! ```
//!
//! `lammps`, `time-step`, `rate`, `size`, `critical-state`: each prints its table and takes one core for some
//! minutes.

mod convergence;
mod critical_state;
mod lammps;
mod runs;

use std::error::Error;

/// Prints its table.
type Study = fn() -> Result<(), Box<dyn Error>>;

/// The studies by their names.
const STUDIES: [(&str, Study); 5] = [
    ("lammps", lammps::study),
    ("time-step", convergence::time_step),
    ("rate", convergence::rate),
    ("size", convergence::size),
    ("critical-state", critical_state::study),
];

fn main() -> Result<(), Box<dyn Error>> {
    let wanted = std::env::args().nth(1).unwrap_or_default();
    match STUDIES.iter().find(|(name, _)| *name == wanted) {
        Some((_, study)) => study(),
        None => {
            let names: Vec<&str> = STUDIES.iter().map(|(name, _)| *name).collect();
            Err(format!("`{wanted}` is no study; there are {}", names.join(", ")).into())
        }
    }
}
