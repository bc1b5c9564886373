//! Designs of experiments: which points of the space of the variables are run. One file each; a new one needs a file and an arm in
//! `points`.

mod full_factorial;
mod latin_hypercube;
pub(super) mod rows;
mod sobol;

/// A variable as a design sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Axis {
    /// A range without levels.
    Continuous,
    /// A number of values.
    Levels(usize),
}

/// The place of a point on an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Coordinate {
    /// From 0 to 1.
    Share(f64),
    /// The number of a value, from 0.
    Level(usize),
}

impl Coordinate {
    /// A drawn number from 0 to 1 on an axis.
    fn drawn(share: f64, axis: Axis) -> Coordinate {
        match axis {
            Axis::Continuous => Coordinate::Share(share),
            Axis::Levels(count) => {
                Coordinate::Level(((share * count as f64) as usize).min(count.saturating_sub(1)))
            }
        }
    }
}

/// A point: its place on each axis.
pub(super) type Point = Vec<Coordinate>;

pub(super) use full_factorial::full_factorial;
pub(super) use latin_hypercube::latin_hypercube;
pub(super) use sobol::{MOST_AXES, MOST_POINTS, sobol};
