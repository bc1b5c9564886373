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

use crate::config::Material;

pub mod adhesion;
pub mod columns;
mod constants;
pub mod elementary;
pub mod frame;
pub mod impact;
pub mod interaction;
pub mod kind;
pub mod law;
pub mod normal;
pub mod pair;
pub mod parameters;
pub mod refined;
pub mod registry;
pub mod rolling;
pub mod set;
pub mod slot;
pub mod slots;
pub mod tangential;

#[cfg(test)]
mod tests;

pub use constants::PairConstants;
pub use kind::{AdhesionKind, NormalKind, RollingKind, TangentialKind};
pub use law::{
    AdhesionLaw, AdhesionLosses, Attraction, Description, Mixing, Moment, MomentLaw, Normal, NormalLaw,
    NormalTraits, Parameter, RelativeSpin, Tangential, TangentialLaw, Unit,
};
pub use parameters::ParameterValues;

/// Largest number of history columns of a tangential law.
pub const MAX_HISTORY: usize = 10;
/// Largest number of history columns of a moment law.
pub const MAX_MOMENT_HISTORY: usize = 6;
/// Most columns of history that a law of adhesion may keep.
pub const MAX_ADHESION_HISTORY: usize = 4;
/// Largest number of history columns of a normal law.
pub const MAX_NORMAL_HISTORY: usize = 4;
/// Number of constants that a law may prepare for a pair.
pub const LAW_CONSTANTS: usize = 6;

/// Properties of a pair of spheres (section 1 of the theory chapter of the book).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairProperties {
    /// R_i + R_j, m.
    pub radius_sum: f64,
    /// R* = R_i R_j / (R_i + R_j), m.
    pub effective_radius: f64,
    /// m* = m_i m_j / (m_i + m_j), kg.
    pub effective_mass: f64,
    /// E*, Pa: 1/E* = (1 - nu_i^2)/E_i + (1 - nu_j^2)/E_j.
    pub effective_modulus: f64,
    /// G*, Pa: 1/G* = (2 - nu_i)/G_i + (2 - nu_j)/G_j.
    pub effective_shear_modulus: f64,
    /// Coefficient of friction mu.
    pub friction: f64,
    /// Interface energy Gamma (work of adhesion per area), J/m2.
    pub interface_energy: f64,
    /// Fraction zeta of critical damping.
    pub damping: f64,
    /// The smaller of the two radii, m.
    pub smaller_radius: f64,
    /// Rotational inertia against rolling, kg m2: `1/I_r = 1/(I_i + m_i R_i^2) + 1/(I_j + m_j R_j^2)` with `I = 2/5 m R^2`.
    pub rolling_inertia: f64,
}

impl PairProperties {
    /// Those of two spheres of given material and radius, m, with dashpots of a fraction of critical damping.
    ///
    /// Friction and interface energy of unlike materials are the geometric means of the two; moduli follow from the theory, in
    /// which the compliances of the two sides add.
    pub fn new(i: (&Material, f64), j: (&Material, f64), damping: f64) -> Self {
        let compliance = |m: &Material| (1.0 - m.poissons_ratio * m.poissons_ratio) / m.youngs_modulus;
        let shear_compliance =
            |m: &Material| (2.0 - m.poissons_ratio) * 2.0 * (1.0 + m.poissons_ratio) / m.youngs_modulus;
        let mass = |(m, r): (&Material, f64)| m.density * 4.0 / 3.0 * std::f64::consts::PI * r * r * r;
        PairProperties {
            radius_sum: i.1 + j.1,
            effective_radius: i.1 * j.1 / (i.1 + j.1),
            effective_mass: mass(i) * mass(j) / (mass(i) + mass(j)),
            effective_modulus: 1.0 / (compliance(i.0) + compliance(j.0)),
            effective_shear_modulus: 1.0 / (shear_compliance(i.0) + shear_compliance(j.0)),
            friction: (i.0.friction * j.0.friction).sqrt(),
            interface_energy: (i.0.interface_energy * j.0.interface_energy).sqrt(),
            damping,
            smaller_radius: i.1.min(j.1),
            rolling_inertia: {
                let inertia = |side: (&Material, f64)| 1.4 * mass(side) * side.1 * side.1;
                inertia(i) * inertia(j) / (inertia(i) + inertia(j))
            },
        }
    }
}
