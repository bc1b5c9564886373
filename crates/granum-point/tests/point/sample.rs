//! The sample that the tests share.

use std::sync::OnceLock;

use granum_core::geometry::Matrix;
use granum_dem::simulation::Simulation;
use granum_io::{Case, RunKind};
use granum_point::{Controls, MaterialPoint};
use granum_run::{Laboratory, NoObserver, Source};

/// 150 grains without adhesion at 100 kPa.
pub fn simulation() -> &'static Simulation {
    static SAMPLE: OnceLock<Simulation> = OnceLock::new();
    SAMPLE.get_or_init(|| {
        let case = Case::parse(
            "grains.count = 150\ngrains.material.interface_energy = 0\ngrains.material.friction = 0.5\npreparation.friction = 0.1\n\
             preparation.solid_fraction = 'none'\npreparation.inertial_number = 5e-3\npreparation.mean_stress = '100 kPa'\n\
             preparation.unbalanced_force = 0.01",
            "case",
        );
        let plan = Laboratory::here().plan(RunKind::Sample, &case.unwrap(), &Source::Case, &mut NoObserver);
        plan.unwrap().in_memory(&mut NoObserver).unwrap().simulation().unwrap().clone()
    })
}

/// Controls that are quick enough for tests.
pub fn quick() -> Controls {
    Controls::default().with(|controls| {
        controls.inertial_number = 5e-3;
        controls.relaxation = 200;
        controls.averaging = 100;
    })
}

pub fn point() -> MaterialPoint {
    MaterialPoint::new(simulation().clone(), quick()).unwrap()
}

/// Largest entry of a difference.
pub fn difference(a: &Matrix, b: &Matrix) -> f64 {
    (0..9).fold(0.0f64, |most, k| most.max((a[k / 3][k % 3] - b[k / 3][k % 3]).abs()))
}
