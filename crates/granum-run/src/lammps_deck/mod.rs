//! A complete input deck for LAMMPS: the sample of a case and the script that tests it as the case does.

mod deck;
mod deck_error;
mod formula;
mod head;
mod laws;
mod names;
mod stage;

pub use deck::{Confinement, LammpsDeck};
pub use deck_error::DeckError;
pub use names::{CURVE, DATA, SCRIPT};

#[cfg(test)]
mod tests;
