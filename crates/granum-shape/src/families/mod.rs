//! The families of shapes, a file each.

pub mod capsule;
pub mod dimer;
pub mod pieces;
pub mod sphere;
pub mod tetrapod;
