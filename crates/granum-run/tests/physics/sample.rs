//! The sample that the tests share, and operations on it.

use std::sync::OnceLock;

use granum_core::assembly::{Assembly, Matrix};
use granum_core::cell::Cell;
use granum_dem::config::{ContactModel, Grains, Material, NormalKind, Preparation, TangentialKind};
use granum_dem::observer::NoObserver;
use granum_dem::preparation::{SampleSpecification, prepare};
use granum_dem::servo::CellControl;
use granum_dem::simulation::{InitialSphere, Properties, Simulation};

pub const MEAN_STRESS: f64 = 20e3;

pub fn properties(friction: f64, damping: f64) -> Properties {
    let material = Material::default().with(|material| {
        material.friction = friction;
        material.interface_energy = 0.0;
    });
    Properties::new(material, ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, damping))
}

/// A sample of 300 equal grains at rest at 20 kPa: Hertz without micro-slip, friction 0.3.
pub fn sample() -> &'static Simulation {
    static SAMPLE: OnceLock<Simulation> = OnceLock::new();
    SAMPLE.get_or_init(|| {
        let Properties { material, contact, .. } = properties(0.3, 0.1);
        let grains = Grains::default().with(|grains| {
            grains.count = 300;
            grains.material = material;
        });
        prepared(&grains, &contact)
    })
}

/// A sample that was compacted with a friction coefficient of 0.1.
pub fn prepared(grains: &Grains, contact: &ContactModel) -> Simulation {
    let preparation = Preparation::default().with(|preparation| {
        preparation.friction = Some(0.1);
        preparation.solid_fraction = None;
        preparation.inertial_number = 3e-3;
        preparation.unbalanced_force = 2e-3;
    });
    let specification = SampleSpecification::new(grains, contact, &preparation);
    prepare(&specification, &mut NoObserver).unwrap().simulation
}

pub fn spheres(assembly: &Assembly) -> Vec<InitialSphere> {
    assembly
        .bodies
        .iter()
        .map(|g| InitialSphere { id: g.id, position: g.position, radius: g.equivalent_radius })
        .collect()
}

pub fn multiply(m: &Matrix, v: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|r| m[r][0] * v[0] + m[r][1] * v[1] + m[r][2] * v[2])
}

/// A simulation of the grains and the cell after a linear map, without contact history.
pub fn mapped(assembly: &Assembly, map: &Matrix, properties: Properties) -> Simulation {
    let edge = |k: usize| multiply(map, [0, 1, 2].map(|r| assembly.cell[r][k]));
    let edges = [edge(0), edge(1), edge(2)];
    let cell = Cell { edges: std::array::from_fn(|r| std::array::from_fn(|c| edges[c][r])) };
    let moved: Vec<InitialSphere> = spheres(assembly)
        .iter()
        .map(|s| InitialSphere { position: multiply(map, s.position), ..*s })
        .collect();
    Simulation::new(cell, &moved, properties).unwrap()
}

/// Axial compression at constant mean stress along an axis.
pub fn compress(simulation: &mut Simulation, axis: usize, inertial_number: f64) {
    let rate = simulation.strain_rate(inertial_number, MEAN_STRESS);
    simulation.reset_phase(0.0);
    simulation.set_control(CellControl::constant_mean_stress(axis, rate, MEAN_STRESS, 30.0 * rate));
}
