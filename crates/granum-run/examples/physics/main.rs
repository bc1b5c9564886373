//! Studies for `VALIDATION.md` that take too long for a test:
//!
//! ```sh
//! cargo run --release -p granum-run --example physics -- STUDY [paper]
//! ```
//!
//! `lammps`, `time-step`, `rate`, `size`, `critical-state`: each prints its table and takes some minutes. With `paper`
//! the convergence studies use the contact laws of the paper, otherwise Hertz without micro-slip.

mod convergence;
mod critical_state;
mod lammps;
mod runs;

use std::error::Error;

/// A study, which prints its table.
type Study = fn(runs::Laws) -> Result<(), Box<dyn Error>>;

/// The studies by their names.
const STUDIES: [(&str, Study); 5] = [
    ("lammps", |_| lammps::study()),
    ("time-step", convergence::time_step),
    ("rate", convergence::rate),
    ("size", convergence::size),
    ("critical-state", |_| critical_state::study()),
];

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let wanted = words.first().cloned().unwrap_or_default();
    let laws = match words.get(1).map(String::as_str) {
        None => runs::Laws::Plain,
        Some("paper") => runs::Laws::Paper,
        Some(other) => return Err(format!("`{other}` is no set of laws; there is paper").into()),
    };
    match STUDIES.iter().find(|(name, _)| *name == wanted) {
        Some((_, study)) => study(laws),
        None => {
            let names: Vec<&str> = STUDIES.iter().map(|(name, _)| *name).collect();
            Err(format!("`{wanted}` is no study; there are {}", names.join(", ")).into())
        }
    }
}
