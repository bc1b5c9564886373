//! Contact laws: a normal law, a tangential law, a law of moments and a law of adhesion on top make a set.
//!
//! To add a law: a file in [`normal`], [`tangential`], [`rolling`] or [`adhesion`] with its name, parameters, formula and tests,
//! and its line in [`registry`]. A program that uses this library does without the line: it makes a [`NormalKind`],
//! [`TangentialKind`], [`RollingKind`] or [`AdhesionKind`] of a law of its own.
//!
//! - [`law`]: what a law is;
//! - [`interaction`]: what all laws share: kinematics, rotation of the history, damping, energy;
//! - [`kind`], [`slot`], [`slots`]: a law as a value that is chosen at run time, and how it is called then;
//! - [`set`]: what the engine asks of the laws of a set together.

pub mod adhesion;
pub mod check;
pub mod columns;
pub mod constants;
pub mod elementary;
pub mod frame;
pub mod impact;
pub mod interaction;
pub mod kind;
pub mod law;
pub mod limits;
pub mod memory;
pub mod normal;
pub mod pair;
pub mod pair_properties;
pub mod parameters;
pub mod refined;
pub mod registry;
pub mod rolling;
pub mod selection;
pub mod set;
pub mod slot;
pub mod slots;
mod steps;
pub mod tangential;
pub mod vectors;

#[cfg(test)]
mod tests;

pub use constants::PairConstants;
pub use kind::{AdhesionKind, NormalKind, RollingKind, TangentialKind};
pub use law::{
    AdhesionLaw, AdhesionLosses, Attraction, Description, Mixing, Moment, MomentLaw, Normal, NormalLaw,
    NormalTraits, Parameter, RelativeSpin, Tangential, TangentialLaw, Unit,
};
pub use limits::{LAW_CONSTANTS, MAX_ADHESION_HISTORY, MAX_HISTORY, MAX_MOMENT_HISTORY, MAX_NORMAL_HISTORY};
pub use pair_properties::PairProperties;
pub use parameters::ParameterValues;
