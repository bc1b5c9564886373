//! Contact laws: a set consists of a normal law, a tangential law, a moment law and an additional adhesion law.
//!
//! To add a law: a file in [`normal`], [`tangential`], [`rolling`] or [`adhesion`] with its name, parameters, constants, formula and
//! tests, and its line in [`choice::kind`]. A program that uses this library does not need the line: it makes a [`NormalKind`],
//! [`TangentialKind`], [`RollingKind`] or [`AdhesionKind`] from its own law.
//!
//! - [`law`]: definition of a law, with its description, constants and energy channels;
//! - [`normal`], [`tangential`], [`rolling`], [`adhesion`]: the laws;
//! - [`choice`]: which laws a simulation has, by their names, with the values of their parameters;
//! - [`evaluation`]: the part that all laws have in common: kinematics, rotation of the history, damping, energy;
//! - [`slot`]: a law behind function pointers;
//! - [`pair`], [`impact`]: two grains by themselves.

pub mod adhesion;
pub mod choice;
pub mod evaluation;
pub mod impact;
pub mod law;
pub mod normal;
pub mod pair;
pub mod rolling;
pub mod slot;
pub mod tangential;

#[cfg(test)]
mod tests;

pub use choice::kind::{AdhesionKind, NormalKind, RollingKind, TangentialKind};
pub use choice::parameters::ParameterValues;
pub use evaluation::constants::PairConstants;
pub use law::constants::{LawConstants, NoConstants};
pub use law::description::{LawDescription, LawParameter, Mixing, Unit};
pub use law::energy_channel::{EnergyChannel, EnergyFate, LawEnergies};
pub use law::limits::{
    LAW_CHANNELS, LAW_CONSTANTS, MAX_ADHESION_HISTORY, MAX_HISTORY, MAX_MOMENT_HISTORY, MAX_NORMAL_HISTORY,
};
pub use law::pair_properties::PairProperties;
pub use law::{
    AdhesionLaw, AdhesionLosses, Attraction, Moment, MomentLaw, Normal, NormalLaw, NormalTraits,
    RelativeSpin, Tangential, TangentialLaw,
};
