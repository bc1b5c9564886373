//! A state of a material point.

use std::sync::Arc;

use granum_core::geometry::Matrix;
use granum_core::{ObservedState, Table};
use granum_dem::simulation::Simulation;
use granum_learn::surrogate::Outside;
use granum_run::stiffness::Tensor;
use granum_sensors::{Measurement, Sensors};

use crate::identity::Identity;
use crate::path_so_far::{PathPart, table};
use crate::rotated::{stiffness_to_space, to_space};
use crate::surrogate_state::SurrogateState;

/// A state of a material point: a value that is never changed. A copy is a reference, and costs nothing.
#[derive(Clone)]
pub struct State {
    content: Arc<Content>,
}

/// What is in a state: grains, or what a surrogate keeps in their place.
#[derive(Clone)]
pub(crate) enum Matter {
    Grains(Box<Simulation>),
    Surrogate(SurrogateState),
}

/// What a state consists of. Stress and stiffness are in the axes of the cell, which does not rotate.
pub(crate) struct Content {
    pub(crate) identity: Identity,
    pub(crate) matter: Matter,
    /// Rotation of the cell since the start.
    pub(crate) rotation: Matrix,
    /// Stress, averaged as the controls say, Pa.
    pub(crate) stress: Matrix,
    /// Standard deviation of the stress over the steps of the average, Pa.
    pub(crate) noise: Matrix,
    /// Secant stiffness kept up along the path.
    pub(crate) secant: Tensor,
    /// The path since the start, of a state of a hybrid point alone.
    pub(crate) path: Option<Arc<PathPart>>,
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

    /// Standard deviation of each component of the stress, Pa, in the axes of the cell. Of grains it is that over the steps of the average: what is left of
    /// their motion, which says nothing of how far another sample of the same material would be. Of a surrogate it is that of its prediction for a new
    /// sample; zero if it does not know it.
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

    /// Edges of the periodic cell as the columns of a matrix, m, without the rotation of the sample; `None` for a surrogate.
    pub fn cell(&self) -> Option<&Matrix> {
        Some(&self.simulation()?.state().cell().edges)
    }

    /// Void ratio: volume of the voids over that of the grains; `None` for a surrogate that neither predicts it nor has it as an input.
    pub fn void_ratio(&self) -> Option<f64> {
        match &self.content.matter {
            Matter::Grains(simulation) => Some(1.0 / simulation.state().solid_fraction() - 1.0),
            Matter::Surrogate(state) => state.void_ratio(),
        }
    }

    /// Mean number of contacts of a grain; `None` for a surrogate that does not predict it.
    pub fn coordination_number(&self) -> Option<f64> {
        match &self.content.matter {
            Matter::Grains(simulation) => {
                let state = simulation.state();
                Some(2.0 * state.contacts() as f64 / state.grains() as f64)
            }
            Matter::Surrogate(state) => state.value("coordination_number"),
        }
    }

    /// What of this state is outside of what its surrogate was trained on, and then not to be trusted: inputs, and the length and turns of the path. Nothing
    /// for grains.
    pub fn outside(&self) -> &[Outside] {
        match &self.content.matter {
            Matter::Grains(_) => &[],
            Matter::Surrogate(state) => &state.outside,
        }
    }

    /// The secant stiffness in the axes of space, Pa: from the affine stiffness of the sample at its start by Broyden's updates along the
    /// path of this state and no other.
    pub fn secant(&self) -> Tensor {
        stiffness_to_space(&self.content.rotation, &self.content.secant)
    }

    /// The values of all sensors that can be measured on one state; `None` for a surrogate. Directions are those of the cell, without its rotation.
    pub fn measure(&self, sensors: &Sensors) -> Option<Measurement> {
        let simulation = self.simulation()?;
        let sensors = sensors.for_clumps(simulation.state().has_clumps());
        Some(sensors.measure_state(simulation))
    }

    /// The value of a column: of the sensors that can be measured on one state, or of the outputs of a surrogate; `None` if there is none of that name.
    pub fn value(&self, column: &str, sensors: &Sensors) -> Option<f64> {
        match &self.content.matter {
            Matter::Grains(_) => self.measure(sensors)?.value(column),
            Matter::Surrogate(state) => state.value(column),
        }
    }

    /// The grains, which can be observed, or copied and continued by a program of one's own; `None` for a surrogate.
    pub fn simulation(&self) -> Option<&Simulation> {
        match &self.content.matter {
            Matter::Grains(simulation) => Some(simulation),
            Matter::Surrogate(_) => None,
        }
    }

    /// True if grains are behind this state, and not a surrogate.
    pub fn is_live(&self) -> bool {
        self.simulation().is_some()
    }

    /// The path that led to this state of a hybrid point ([`crate::MaterialPoint::hybrid`]) as a table, a row for each part that was carried out after that of the start, whose
    /// stress is given: the six logarithmic strains since the start and the six stresses, by the names of the columns that surrogates have. Where the state is live, all
    /// of its stresses are those of the grains, also from before they took over, so that the table is a test from which a surrogate can learn. `None` for other
    /// points, and before any increment.
    pub fn path(&self, start: &State) -> Option<Table> {
        table(self.content.path.as_ref()?, &start.content.stress)
    }

    /// The grains for observers that work with any engine; `None` for a surrogate.
    pub fn observed(&self) -> Option<&dyn ObservedState> {
        Some(self.simulation()?)
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
