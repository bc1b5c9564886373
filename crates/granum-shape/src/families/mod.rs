//! The families of shapes, a file each.

pub mod agglomerate;
pub mod capsule;
pub mod dimer;
pub mod ellipsoid;
pub mod mesh;
pub mod pieces;
pub mod sand;
pub mod sphere;
pub mod tetrapod;
pub mod voxels;
