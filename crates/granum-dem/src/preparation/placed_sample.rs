//! The grains of a random insertion, from which every trial of a preparation starts.

use super::{PreparationError, SampleSpecification};
use crate::body_insertion::{PlacedGrains, insert_bodies};
use crate::cell::Cell;
use crate::initial_sphere::InitialSphere;
use crate::observer::{Phase, SimulationObserver};
use crate::random_insertion::{InsertionError, followed_insertion};
use crate::simulation::{Properties, Simulation};
use crate::simulation_error::SimulationError;

/// The cell and the grains of a random insertion.
pub(super) enum PlacedSample {
    /// Spheres.
    Spheres(Cell, Vec<InitialSphere>),
    /// Grains of any shape.
    Bodies(Box<PlacedGrains>),
}

impl PlacedSample {
    /// The grains at rest.
    pub(super) fn simulation(&self, properties: Properties) -> Result<Simulation, SimulationError> {
        match self {
            PlacedSample::Spheres(cell, spheres) => Simulation::new(*cell, spheres, properties),
            PlacedSample::Bodies(placed) => {
                let PlacedGrains { cell, shapes, bodies, materials, .. } = &**placed;
                Simulation::of_bodies(*cell, shapes, bodies, materials, properties)
            }
        }
    }
}

/// Places the grains at random, unless the observer stops it.
pub(super) fn place(
    specification: &SampleSpecification,
    observer: &mut dyn SimulationObserver,
) -> Result<PlacedSample, PreparationError> {
    let (grains, p) = (&specification.grains, &specification.preparation);
    let (fraction, seed) = (p.initial_solid_fraction, p.seed);
    let placed = if grains.are_spheres() {
        followed_insertion(grains, fraction, seed, observer)
            .map(|(cell, spheres)| PlacedSample::Spheres(cell, spheres))
    } else {
        insert_bodies(grains, p.bedding, fraction, seed, observer)
            .map(|placed| PlacedSample::Bodies(Box::new(placed)))
    };
    placed.map_err(|error| match error {
        InsertionError::Stopped { .. } => PreparationError::Stopped { phase: Phase::Placing },
        error => error.into(),
    })
}
