//! Contact laws: a set consists of a normal law, a tangential law, a moment law and an additional adhesion law.
//!
//! To add a law: a file in [`normal`], [`tangential`], [`rolling`] or [`adhesion`] with its name, parameters, formula and tests,
//! and its line in [`registry`]. A program that uses this library does not need the line: it makes a [`NormalKind`],
//! [`TangentialKind`], [`RollingKind`] or [`AdhesionKind`] from its own law.
//!
//! - [`law`]: definition of a law; [`description`]: its name and parameters;
//! - [`interaction`]: the part that all laws have in common: kinematics, rotation of the history, damping, energy;
//! - [`kind`], [`slot`], [`slots`]: a law as a value that is chosen at run time, and its call through function pointers;
//! - [`set`]: the interface between the engine and a set of laws.

pub mod adhesion;
pub mod check;
pub mod columns;
pub mod constants;
pub mod description;
pub mod elementary;
pub mod entry;
pub mod frame;
pub mod impact;
pub mod interaction;
pub mod kind;
pub mod law;
pub mod limits;
pub mod memory;
pub mod normal;
pub mod observed;
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
pub use description::{Description, Mixing, Parameter, Unit};
pub use kind::{AdhesionKind, NormalKind, RollingKind, TangentialKind};
pub use law::{
    AdhesionLaw, AdhesionLosses, Attraction, Moment, MomentLaw, Normal, NormalLaw, NormalTraits,
    RelativeSpin, Tangential, TangentialLaw,
};
pub use limits::{LAW_CONSTANTS, MAX_ADHESION_HISTORY, MAX_HISTORY, MAX_MOMENT_HISTORY, MAX_NORMAL_HISTORY};
pub use pair_properties::PairProperties;
pub use parameters::ParameterValues;
