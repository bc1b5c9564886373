//! A state of a material point.

use std::sync::Arc;

use granum_core::ObservedState;
use granum_core::geometry::Matrix;
use granum_dem::simulation::Simulation;
use granum_run::stiffness::Tensor;
use granum_sensors::{Measurement, Sensors};

use crate::identity::Identity;
use crate::rotated::{stiffness_to_space, to_space};

/// A state of a material point: a value that is never changed. A copy is a reference, and costs nothing.
#[derive(Clone)]
pub struct State {
    content: Arc<Content>,
}

/// What a state consists of. Stress and stiffness are in the axes of the cell, which does not rotate.
pub(crate) struct Content {
    pub(crate) identity: Identity,
    pub(crate) simulation: Simulation,
    /// Rotation of the cell since the start.
    pub(crate) rotation: Matrix,
    /// Stress, averaged as the controls say, Pa.
    pub(crate) stress: Matrix,
    /// Standard deviation of the stress over the steps of the average, Pa.
    pub(crate) noise: Matrix,
    /// Secant stiffness kept up along the path.
    pub(crate) secant: Tensor,
}

impl State {
    pub(crate) fn new(content: Content) -> State {
        State { content: Arc::new(content) }
    }

    pub(crate) fn content(&self) -> &Content {
        &self.content
    }

    /// The digest of sample, controls and path.
    pub fn identity(&self) -> Identity {
        self.content.identity
    }

    /// Stress in the axes of space, Pa, compression positive.
    pub fn stress(&self) -> Matrix {
        to_space(&self.content.rotation, &self.content.stress)
    }

    /// Standard deviation of each component of the stress over the steps of the average, Pa, in the axes of the cell: what is left of
    /// the motion of the grains. It says nothing of how far another sample of the same material would be.
    pub fn noise(&self) -> &Matrix {
        &self.content.noise
    }

    /// The rotation of the sample since its start.
    pub fn rotation(&self) -> &Matrix {
        &self.content.rotation
    }

    /// Mean stress p, Pa.
    pub fn mean_stress(&self) -> f64 {
        let stress = &self.content.stress;
        (stress[0][0] + stress[1][1] + stress[2][2]) / 3.0
    }

    /// Edges of the periodic cell as the columns of a matrix, m, without the rotation of the sample.
    pub fn cell(&self) -> &Matrix {
        &self.content.simulation.state().cell().edges
    }

    /// Void ratio: volume of the voids over that of the grains.
    pub fn void_ratio(&self) -> f64 {
        1.0 / self.content.simulation.state().solid_fraction() - 1.0
    }

    /// Mean number of contacts of a grain.
    pub fn coordination_number(&self) -> f64 {
        let state = self.content.simulation.state();
        2.0 * state.contacts() as f64 / state.grains() as f64
    }

    /// The secant stiffness in the axes of space, Pa: from the affine stiffness of the sample at its start by Broyden's updates along the
    /// path of this state and no other.
    pub fn secant(&self) -> Tensor {
        stiffness_to_space(&self.content.rotation, &self.content.secant)
    }

    /// The values of all sensors that can be measured on one state. Directions are those of the cell, without its rotation.
    pub fn measure(&self, sensors: &Sensors) -> Measurement {
        let sensors = sensors.for_clumps(self.content.simulation.state().has_clumps());
        sensors.measure_state(&self.content.simulation)
    }

    /// The grains, which can be observed, or copied and continued by a program of one's own.
    pub fn simulation(&self) -> &Simulation {
        &self.content.simulation
    }

    /// The grains for observers that work with any engine.
    pub fn observed(&self) -> &dyn ObservedState {
        &self.content.simulation
    }

    /// True if both are the same value in memory.
    pub fn is_same_value(&self, other: &State) -> bool {
        Arc::ptr_eq(&self.content, &other.content)
    }
}

impl std::fmt::Debug for State {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("State").field("identity", &self.identity()).field("stress", &self.stress()).finish()
    }
}
