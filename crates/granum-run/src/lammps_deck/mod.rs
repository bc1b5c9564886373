//! A complete input deck for LAMMPS: the sample of a case and the script that tests it as the case does.

mod deck;
mod deck_error;
mod formula;
mod head;
mod laws;
mod stage;

pub use deck::{CURVE, Confinement, DATA, LammpsDeck, SCRIPT};
pub use deck_error::DeckError;

#[cfg(test)]
mod tests;
