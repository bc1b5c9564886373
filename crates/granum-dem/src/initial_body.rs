//! Where a body is before a simulation begins.

use granum_core::rotation::Quaternion;

use crate::assembly::Vector;

/// Where a body is before a simulation begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InitialBody {
    /// Its id.
    pub id: u64,
    /// Its centre of mass, m.
    pub position: Vector,
    /// Its orientation: the rotation from its principal axes to those of space.
    pub orientation: Quaternion,
    /// Its shape, as its place among the shapes of the simulation.
    pub shape: usize,
    /// Factor on the lengths of its shape.
    pub scale: f64,
}
