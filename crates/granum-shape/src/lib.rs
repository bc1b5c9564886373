//! Shapes of grains.
//!
//! - [`RigidShape`]: a rigid body of spheres in its principal axes, with the volume and the inertia of their union.
//! - [`union_of_spheres`]: those moments, exactly but for rounding.
//! - [`ShapeDescriptors`]: proportions, sphericity, convexity, roundness and sizes of a shape.
//! - [`family`]: families of shapes with their parameters, as case files name them. A new family needs a file in [`families`] and a line in
//!   [`family::ALL`].
//! - [`mesh`] and [`voxels`]: surfaces of triangles and labelled stacks of images, read from files and checked.
//! - [`cover`]: spheres that stand for such a body, and how well they do.

pub mod cover;
#[cfg(test)]
mod damaged_files_tests;
pub mod descriptors;
mod directions;
pub mod entry;
pub mod families;
pub mod family;
mod harmonics;
pub mod mesh;
mod principal_axes;
mod random;
mod rigid_shape;
mod shape_error;
pub mod union_of_spheres;
pub mod voxels;

pub use descriptors::{ShapeDescriptors, widest_seam};
pub use entry::{ShapeEntry, SizeMeasure};
pub use family::{ShapeDescription, ShapeError, ShapeFamily, ShapeKind, ShapeParameter, Spheres};
pub use rigid_shape::{RigidShape, ShapePiece, equivalent_radius};
pub use union_of_spheres::ShapeOfSpheres;
