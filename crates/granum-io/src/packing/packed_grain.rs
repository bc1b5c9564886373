//! One grain of a packing.

use granum_core::assembly::Vector;

/// One grain of a packing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PackedGrain {
    /// Its id, from 1.
    pub id: u64,
    /// Centre, m.
    pub position: Vector,
    /// Radius, m.
    pub radius: f64,
}
