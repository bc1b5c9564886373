//! Laws of bonds: how stiff and how strong a bond is. One file each.

pub mod additive;
pub mod beam;
pub mod bond_law;
pub mod kind;
pub mod parallel;
mod strengths;
