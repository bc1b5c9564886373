//! Designs of experiments: which points of the space of the variables are run. One file each; a new one needs a file and a line in [`ALL`].

mod full_factorial;
mod latin_hypercube;
mod point_design;
pub(super) mod rows;
mod sobol;

/// The designs that make their points by themselves, in the order in which they are listed.
pub(super) const ALL: [&PointDesign; 3] =
    [&sobol::SOBOL, &latin_hypercube::LATIN_HYPERCUBE, &full_factorial::FULL_FACTORIAL];

pub(super) use point_design::{Axis, Coordinate, Point};
pub use point_design::{DesignSize, PointDesign};
pub(super) use sobol::{MOST_AXES, MOST_POINTS, sobol};
