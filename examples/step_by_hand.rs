//! Advances a simulation step by step, with access to all positions, velocities and contacts.

use granum::dem::random_insertion::random_insertion;
use granum::prelude::*;

/// The whole program.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    // ANCHOR: place
    let grains = Grains::default().with(|grains| grains.count = 200);
    // Grains without contacts at a solid fraction of 0.35, placed with the seed 1.
    let (cell, spheres) = random_insertion(&grains, 0.35, 1)?;
    let properties = Properties::new(grains.material, ContactModel::default());
    let mut simulation = Simulation::new(cell, &spheres, properties)?;
    // ANCHOR_END: place
    // ANCHOR: steps
    // All three axes are driven to 20 kPa; no rate may exceed 3e4 /s.
    simulation.set_control(CellControl::isotropic(20e3, 3e4));
    for _ in 0..10 {
        simulation.advance(1000)?;
        let state = simulation.state();
        let assembly = simulation.assembly();
        let fastest =
            assembly.bodies.iter().map(|grain| grain.velocity.map(f64::abs).into_iter().fold(0.0, f64::max));
        println!(
            "{:.2e} s: solid fraction {:.3}, {} contacts, p = {:.1} kPa, fastest grain {:.3} m/s",
            state.time(),
            state.solid_fraction(),
            assembly.contacts.len(),
            state.mean_stress() / 1e3,
            fastest.fold(0.0, f64::max),
        );
    }
    // ANCHOR_END: steps
    assert!(simulation.state().solid_fraction() > 0.4);
    Ok(())
}
