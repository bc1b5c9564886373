//! Samples and bonds that the tests have in common.

use granum_core::assembly::Assembly;
use granum_core::cell::Cell;
use granum_dem::bond::{
    BondLaw, BondLoads, BondRadius, BondShape, BondStiffness, Bonding, Eight, LIMITS, StrengthScatter,
};
use granum_dem::config::{ContactModel, Material, NormalKind, TangentialKind};
use granum_dem::contact::LawDescription;
use granum_dem::servo::CellControl;
use granum_dem::simulation::{Hardware, InitialSphere, Properties, Simulation};

/// Properties of grains so soft that only bonds matter, of a density.
pub fn soft(density: f64) -> Properties {
    let material = Material::default().with(|m| {
        (m.youngs_modulus, m.poissons_ratio, m.friction, m.density) = (1e-6, 0.3, 0.3, density);
        m.interface_energy = 0.0;
    });
    Properties::new(material, ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.0))
}

/// Two spheres along the first axis, that touch, in the middle of a wide cell.
pub fn two(radius: f64, properties: Properties) -> Simulation {
    let edge = 100.0 * radius;
    let sphere =
        |id: u64, x: f64| InitialSphere { id, position: [0.5 * edge + x, 0.5 * edge, 0.5 * edge], radius };
    let spheres = [sphere(1, -radius), sphere(2, radius)];
    Simulation::new(Cell::cuboid([edge; 3]), &spheres, properties).unwrap()
}

/// The bond of the golden numbers, between spheres of radius 50 um.
pub fn golden() -> Bonding {
    Bonding::default().with(|bonding| {
        bonding.radius = BondRadius::Share(0.4);
        for (key, value) in
            [("modulus", 1e9), ("poissons_ratio", 0.25), ("tensile_strength", 20e6), ("cohesion", 15e6)]
        {
            bonding.parameters.insert(key.into(), value);
        }
        bonding.parameters.insert("friction_angle".into(), 0.5f64.atan());
    })
}

/// Stiffnesses that are given.
#[derive(Debug)]
pub struct Given;

impl BondLaw for Given {
    fn description(&self) -> &'static LawDescription {
        const { &LawDescription::new("given", "given", "given stiffnesses", &[]) }
    }
    fn stiffness(&self, _: &BondShape, _: &[f64]) -> BondStiffness {
        BondStiffness { normal: 1000.0, shear: 400.0, bending: 20.0, twisting: 16.0 }
    }
    fn limits(&self, _: &BondShape, _: &[f64], _: f64) -> [f64; LIMITS] {
        [0.0; LIMITS]
    }
    fn utilisation(&self, _: &BondLoads, _: &[Eight; LIMITS]) -> [Eight; 2] {
        [[0.0; 8]; 2]
    }
}

/// Elastic energy of bonds and contacts, and kinetic energy, J.
pub fn stored(assembly: &Assembly) -> f64 {
    let contact = |c: &granum_core::assembly::Contact| c.normal_energy;
    assembly.bonds.iter().map(|bond| bond.energy).sum::<f64>()
        + assembly.contacts.iter().map(contact).sum::<f64>()
        + assembly.kinetic_energy()
}

/// Quartz-like grains under pressure.
pub fn compressed(count: usize, pressure: f64, hardware: Hardware) -> Simulation {
    let material = Material::default().with(|m| {
        (m.youngs_modulus, m.poissons_ratio, m.friction, m.density) = (1e9, 0.2, 0.3, 2650.0);
        m.interface_energy = 0.0;
    });
    let properties =
        Properties::new(material, ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.2));
    let grains = granum_dem::config::Grains::default().with(|g| {
        (g.count, g.diameter, g.spread) = (count, 0.2e-3, 0.2);
    });
    let (cell, spheres) = granum_dem::random_insertion::random_insertion(&grains, 0.4, 5).unwrap();
    let mut s = Simulation::new(cell, &spheres, properties).unwrap();
    s.set_hardware(hardware);
    s.expect_force(pressure * 0.2e-3 * 0.2e-3);
    s.set_control(CellControl::isotropic(pressure, 200.0));
    s.set_global_damping(2e4);
    s.advance(6000).unwrap();
    s
}

/// Cement of a strength.
pub fn cement(strength: f64) -> Bonding {
    Bonding::default().with(|bonding| {
        bonding.largest_gap = 0.01;
        bonding.damping = 0.1;
        bonding.scatter = StrengthScatter::Weibull { modulus: 4.0, reference_volume: None };
        for (key, value) in [("modulus", 1e9), ("tensile_strength", strength), ("cohesion", strength)] {
            bonding.parameters.insert(key.into(), value);
        }
    })
}

/// Stretches the cell along the first axis.
pub fn stretched(rate: f64) -> CellControl {
    let mut control = CellControl::fixed();
    control.rate[0][0] = -rate;
    control
}
