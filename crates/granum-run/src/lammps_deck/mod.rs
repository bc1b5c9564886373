//! A complete input deck for LAMMPS: the sample of a case and the script that tests it as the case does.

mod bodies;
mod bonds;
mod check;
mod deck;
mod deck_error;
mod drive;
mod ends;
mod formula;
mod head;
pub(crate) mod hooks;
mod laws;
mod motion;
pub(crate) mod names;
mod stage;

pub use deck::{Confinement, LammpsDeck};
pub use deck_error::DeckError;
pub use names::{CURVE, DATA, SCRIPT};

#[cfg(test)]
mod bonds_tests;
#[cfg(test)]
mod tests;
