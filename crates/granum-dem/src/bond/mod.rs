//! Bonds: beams of cement or rock between pieces, which stretch, shear, bend, twist and rupture.
//!
//! A bond joins two pieces of two grains, beside their contact, which stays what it is. It is stress free when it is made, whatever the grains
//! carry, so that cement that sets under a load changes no force. Its loads follow from the present places and orientations of its ends
//! ([`motion`]): nothing is integrated, so that nothing drifts, and rigid motions of both ends load nothing.
//!
//! - [`law`]: how stiff and how strong bonds are, one file for each law;
//! - [`bonding`]: which pieces are joined, by what;
//! - `stage`: the two stages of a step.
//!
//! Bonds cost nothing where there are none. Within a step every bond is judged by its own loads, so that neither threads nor the order of the
//! list decide which one ruptures first.

#[cfg(test)]
mod beam_tests;
pub mod bonding;
mod bonds;
mod cement;
mod channels;
#[cfg(test)]
mod criterion_tests;
mod ends;
mod formation;
mod guard;
pub mod law;
mod listed;
mod listed_pair;
mod motion;
mod observed;
mod saved;
mod stage;
#[cfg(test)]
mod statics_tests;
mod steps;
mod strength;
mod summing;
mod turning;
mod views;
mod work;

pub use bonding::{BondAttachment, BondPlaces, BondRadius, Bonding};
pub use cement::cement_volume;
pub use channels::BOND_CHANNELS;
pub use granum_core::assembly::{Bond, BrokenBond, Rupture};
pub use law::bond_law::{BondLaw, BondLoads, BondShape, BondStiffness, Criterion, Eight, LIMITS};
pub use law::kind::BondKind;
pub use listed_pair::ListedPair;
pub use strength::StrengthScatter;

pub(crate) use bonds::Bonds;
pub(crate) use stage::bond_stage;
pub(crate) use summing::BondedStage;
pub(crate) use turning::TurningStage;
pub(crate) use views::BondViews;
pub(crate) use work::BondWork;
