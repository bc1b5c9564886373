//! Grains of several spheres: tetrapods are compressed from a gas to 100 kPa, and measured.

use granum::core::assembly::Vector;
use granum::core::rotation::about;
use granum::dem::servo::CellControl;
use granum::dem::simulation::{InitialBody, RigidShape};
use granum::prelude::*;
use granum::sensors::Sensors;
use granum::shape::ShapeOfSpheres;

/// Four spheres of 0.2 mm whose centres are at the corners of a tetrahedron.
fn tetrapod() -> Vec<(Vector, f64)> {
    let (a, radius) = (5e-5, 1e-4);
    vec![([a, a, a], radius), ([a, -a, -a], radius), ([-a, a, -a], radius), ([-a, -a, a], radius)]
}

/// The whole program.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let tetrapod = ShapeOfSpheres::new(&tetrapod())?;
    println!(
        "a tetrapod: volume {:.4e} m3 (its four spheres alone: {:.4e}), sphericity {:.3}",
        tetrapod.shape.volume,
        4.0 * RigidShape::sphere(1e-4).volume,
        tetrapod.sphericity()
    );

    // A loose lattice of grains that point anywhere.
    let (edge, spacing) = (6, 2.1 * tetrapod.shape.reach());
    let place = |k: usize| [k % edge, k / edge % edge, k / edge / edge].map(|n| (n as f64 + 0.5) * spacing);
    let axis = |k: f64| [(1.7 * k).sin(), (2.3 * k).cos(), (0.9 * k).sin()];
    let body = |k: usize| InitialBody {
        id: k as u64 + 1,
        position: place(k),
        orientation: about(&axis(k as f64), k as f64),
        shape: 0,
        scale: 1.0,
    };
    let bodies: Vec<InitialBody> = (0..edge.pow(3)).map(body).collect();
    let material = Material::default().with(|material| {
        material.youngs_modulus = 1e9;
        material.interface_energy = 0.0;
    });
    let contact = ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.3);
    let cell = Cell::cuboid([spacing * edge as f64; 3]);
    let properties = Properties::new(material, contact);
    let mut simulation = Simulation::of_bodies(cell, &[tetrapod.shape], &bodies, &[], properties)?;

    let pressure = 100e3;
    simulation.expect_force(pressure * 4e-8);
    simulation.set_control(CellControl::isotropic(pressure, 2e3));
    simulation.advance(30_000)?;
    simulation.set_global_damping(5e3);
    simulation.advance(30_000)?;

    let assembly = simulation.assembly();
    let grains = assembly.bodies.len() as f64;
    let neighbours = 2.0 * assembly.pairs_of_bodies().len() as f64 / grains;
    let measured = Sensors::standard().measure_state(&simulation);
    for column in ["mean_stress", "void_ratio", "coordination_number", "unbalanced_force"] {
        println!("{column}: {:.4}", measured.value(column).unwrap_or(f64::NAN));
    }
    println!("each grain touches {neighbours:.2} others");
    let p = measured.value("mean_stress").ok_or("the mean stress is measured")?;
    assert!((p / pressure - 1.0).abs() < 0.02, "the servo holds the stress: {p}");
    assert!(measured.value("coordination_number") > Some(neighbours), "some pairs touch more than once");
    Ok(())
}
