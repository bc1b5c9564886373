//! A boundary: a rigid plane on which grains come to rest. It presses by the law of Hertz, with a dashpot, and has no friction.

use std::sync::Arc;

use granum::dem::boundary::{Boundary, BoundedPiece, Load, Weight};
use granum::prelude::*;

/// The plane `z = height`; grains are above it.
#[derive(Debug)]
pub struct RigidPlane {
    /// Its height, m.
    pub height: f64,
    /// Modulus `E / (1 - nu^2)` of the grains, Pa.
    pub modulus: f64,
    /// Fraction of critical damping.
    pub damping: f64,
}

impl Boundary for RigidPlane {
    fn name(&self) -> &'static str {
        "rigid plane"
    }
    fn load(&self, piece: &BoundedPiece) -> Option<Load> {
        let overlap = self.height + piece.radius - piece.position[2];
        if overlap <= 0.0 {
            return None;
        }
        let stiffness = 2.0 * self.modulus * (piece.radius * overlap).sqrt();
        let dashpot = 2.0 * self.damping * (piece.mass * stiffness).sqrt() * piece.velocity[2];
        let force = [0.0, 0.0, stiffness * overlap / 1.5 - dashpot];
        Some(Load { force, stiffness, ..Load::default() })
    }
}

/// A grain falls onto the plane and comes to rest where the law of Hertz carries its weight.
pub fn comes_to_rest() -> Result<(), Box<dyn std::error::Error>> {
    let (radius, gravity) = (1e-3, 9.81);
    let material = Material::default();
    let modulus = material.youngs_modulus / (1.0 - material.poissons_ratio * material.poissons_ratio);
    let mass = material.density * 4.0 / 3.0 * std::f64::consts::PI * radius * radius * radius;
    let sphere = InitialSphere { id: 1, position: [5e-3, 5e-3, 1e-3 + 1.01e-3], radius };
    let properties = Properties::new(material, ContactModel::default());
    let mut simulation = Simulation::new(Cell::cuboid([1e-2; 3]), &[sphere], properties)?;
    simulation.add_boundary(Arc::new(RigidPlane { height: 1e-3, modulus, damping: 0.3 }));
    simulation.add_boundary(Arc::new(Weight { gravity: [0.0, 0.0, -gravity] }));
    simulation.fix_time_step(Some(1e-7));
    simulation.advance(200_000)?;
    let grain = simulation.assembly().bodies[0];
    let overlap = 1e-3 + radius - grain.position[2];
    // m g = 4/3 E' sqrt(R) overlap^(3/2)
    let carried = 4.0 / 3.0 * modulus * radius.sqrt() * overlap.max(0.0).powf(1.5);
    println!(
        "a grain rests on a plane: it overlaps by {overlap:.3e} m, which carries {:.6} of its weight",
        carried / (mass * gravity)
    );
    assert!((carried / (mass * gravity) - 1.0).abs() < 1e-3, "{overlap}");
    assert!(grain.velocity.iter().all(|v| v.abs() < 1e-7), "{:?}", grain.velocity);
    Ok(())
}
