//! A law of bonds: a thread, which carries tension alone and tears.

use granum::dem::bond::{BondKind, BondLaw, BondLoads, BondShape, BondStiffness, Bonding, Eight, LIMITS};
use granum::law::{LawDescription, LawParameter, Unit};
use granum::prelude::*;

/// A thread between two grains.
#[derive(Debug)]
pub struct Thread;

/// The choice of this law.
pub const THREAD: BondKind = BondKind::new(&Thread);

const PARAMETERS: &[LawParameter] = &[
    LawParameter::new("thread_modulus", Unit::STRESS, 1e9, [1.0, f64::INFINITY], "Modulus of the thread."),
    LawParameter::new("tearing_stress", Unit::STRESS, 1e6, [0.0, f64::INFINITY], "Stress that tears it."),
];

impl BondLaw for Thread {
    fn description(&self) -> &'static LawDescription {
        const { &LawDescription::new("thread", "thread", "a thread that tears", PARAMETERS) }
    }

    fn stiffness(&self, shape: &BondShape, parameters: &[f64]) -> BondStiffness {
        BondStiffness { normal: parameters[0] * shape.area() / shape.length, ..BondStiffness::default() }
    }

    fn limits(&self, shape: &BondShape, parameters: &[f64], strength: f64) -> [f64; LIMITS] {
        [parameters[1] * strength * shape.area(), 0.0, 0.0, 0.0, 0.0, 0.0]
    }

    fn utilisation(&self, loads: &BondLoads, limits: &[Eight; LIMITS]) -> [Eight; 2] {
        [std::array::from_fn(|lane| loads.tension[lane] / limits[0][lane]), [0.0; 8]]
    }
}

/// Two grains on a thread fly apart: it tears at its strength.
///
/// # Errors
/// If the thread does not tear, or tears elsewhere.
pub fn try_it() -> Result<String, Box<dyn std::error::Error>> {
    let sphere = |id: u64, x: f64| InitialSphere { id, position: [x, 5e-3, 5e-3], radius: 1e-4 };
    let material = Material::default().with(|material| material.interface_energy = 0.0);
    let contact = ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.1);
    let grains = [sphere(1, 4.9e-3), sphere(2, 5.1e-3)];
    let mut simulation = Simulation::new(Cell::cuboid([1e-2; 3]), &grains, Properties::new(material, contact))?;
    simulation.bond_pieces(&Bonding::default().with(|bonding| bonding.law = THREAD), &[[0, 1]])?;
    simulation.fix_time_step(Some(2e-9));
    simulation.set_velocities(&[[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]], &[]);
    for _ in 0..10_000 {
        simulation.advance(1)?;
        if let Some(torn) = simulation.assembly().broken_bonds.first() {
            // The energy at the tearing stress: sigma^2 / 2 E times the volume.
            let right = 0.5 * 1e12 / 1e9 * std::f64::consts::PI * torn.radius * torn.radius * 2e-4;
            let ratio = torn.energy / right;
            return if (1.0..1.2).contains(&ratio) {
                Ok(format!("a thread tears with {ratio:.3} of the energy at its strength"))
            } else {
                Err(format!("the thread tears with {ratio} of the energy at its strength").into())
            };
        }
    }
    Err("the thread does not tear".into())
}
