//! Axisymmetric compression at constant mean stress, the test of Antony, Zhou and Wang (2006): axis 1 is strained
//! at a constant rate, axes 2 and 3 move together so that p = (sigma_1 + sigma_2 + sigma_3)/3 keeps its target.

use serde::{Deserialize, Serialize};

use super::{Path, strain_rate};
use crate::config::Shear;
use crate::servo::Control;
use crate::simulation::Simulation;
use crate::state::State;

/// Bound on what the servo adds, as a multiple of the axial strain rate.
const SERVO_LIMIT: f64 = 30.0;

/// Axisymmetric compression at constant mean stress.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AxisymmetricCompression {
    /// Axial strain rate, 1/s.
    pub strain_rate: f64,
    /// Mean stress, Pa.
    pub mean_stress: f64,
    /// Deviator strain eps_1 - eps_3 at the end.
    pub deviator_strain: f64,
}

impl AxisymmetricCompression {
    /// The test that a case asks for on a sample prepared at `sample_stress`, Pa.
    pub fn new(shear: &Shear, simulation: &Simulation, sample_stress: f64) -> Self {
        let mean_stress = shear.mean_stress.unwrap_or(sample_stress);
        AxisymmetricCompression {
            strain_rate: strain_rate(&shear.rate, simulation, mean_stress),
            mean_stress,
            deviator_strain: shear.deviator_strain,
        }
    }
}

impl Path for AxisymmetricCompression {
    fn control(&self, _simulation: &Simulation) -> Control {
        Control::constant_mean_stress(
            0,
            self.strain_rate,
            self.mean_stress,
            SERVO_LIMIT * self.strain_rate.abs(),
        )
    }
    fn coordinate(&self, state: &State) -> f64 {
        state.deviator_strain()
    }
    fn end(&self) -> f64 {
        self.deviator_strain
    }
    fn speed(&self, _simulation: &Simulation) -> f64 {
        1.5 * self.strain_rate.abs()
    }
}
