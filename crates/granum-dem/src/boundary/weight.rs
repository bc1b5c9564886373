//! The weight of grains: `m g`.

use super::{Boundary, BoundedBody};
use crate::assembly::Vector;

/// Weight in a field of gravity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weight {
    /// Acceleration g of gravity, m/s2.
    pub gravity: Vector,
}

impl Boundary for Weight {
    fn name(&self) -> &'static str {
        "weight"
    }
    fn force(&self, body: &BoundedBody) -> Vector {
        self.gravity.map(|g| body.mass * g)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::cell::Cell;
    use crate::config::{ContactModel, Material};
    use crate::simulation::{InitialBody, RigidShape, ShapePiece};
    use crate::simulation::{Properties, Simulation};
    use granum_core::rotation::IDENTITY;

    /// A sphere and a clump fall freely: the same for both, without turning, and the work of the weight is their kinetic energy.
    #[test]
    fn grains_of_any_shape_fall_alike() {
        let piece = |x: f64, radius| ShapePiece { centre: [x, 0.0, 0.0], radius };
        let clump = RigidShape {
            pieces: vec![piece(-2e-3, 1e-3), piece(0.0, 2e-3), piece(1e-3, 1.5e-3)],
            volume: 4e-8,
            inertia_over_mass: [1e-6, 2e-6, 2.5e-6],
        };
        let shapes = [RigidShape::sphere(1e-3), clump];
        let body = |shape: usize| InitialBody {
            id: shape as u64 + 1,
            position: [0.01 + 0.02 * shape as f64, 0.02, 0.05],
            orientation: IDENTITY,
            shape,
            scale: 1.0,
        };
        let properties = Properties::new(Material::default(), ContactModel::default());
        let cell = Cell::cuboid([0.06; 3]);
        let mut s = Simulation::of_bodies(cell, &shapes, &[body(0), body(1)], &[], properties).unwrap();
        s.add_boundary(Arc::new(Weight { gravity: [0.0, 0.0, -9.81] }));
        s.fix_time_step(Some(1e-5));
        s.advance(1000).unwrap();
        let assembly = s.assembly();
        for body in &assembly.bodies {
            assert!((body.velocity[2] / -0.0981 - 1.0).abs() < 2e-3, "{:?}", body.velocity);
            assert!(body.spin.iter().all(|w| w.abs() < 1e-9), "{:?}", body.spin);
            assert!((body.position[2] - (0.05 - 4.905e-4)).abs() < 2e-6, "{:?}", body.position);
        }
        let (work, kinetic) = (assembly.energy.boundary_work, assembly.kinetic_energy());
        assert!((work / kinetic - 1.0).abs() < 5e-3, "{work} {kinetic}");
    }
}
