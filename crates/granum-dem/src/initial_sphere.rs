//! Where a grain is before a simulation begins.

use crate::assembly::Vector;

/// Initial position of a grain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InitialSphere {
    /// Its id.
    pub id: u64,
    /// Centre, m.
    pub position: Vector,
    /// Radius, m.
    pub radius: f64,
}
