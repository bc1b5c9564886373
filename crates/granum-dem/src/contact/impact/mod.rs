//! Collision of two equal grains.

pub mod collision;

#[cfg(test)]
mod oblique;
#[cfg(test)]
mod tests;

pub use collision::{AGREEMENT, Impact, ImpactError, collide};
