//! The families of shapes, a file each.

pub mod capsule;
pub mod dimer;
pub mod ellipsoid;
pub mod pieces;
pub mod sphere;
pub mod tetrapod;
