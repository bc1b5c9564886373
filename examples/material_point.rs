//! A material point: a sample that is strained step by step, whose states are values that a program can go back to.

use granum::point::{Controls, Increment, MaterialPoint, Recipe, Store, Tangent};
use granum::prelude::*;

/// The whole program.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    // ANCHOR: point
    let case = Case::parse(
        "grains.count = 100\ngrains.material.interface_energy = 0\npreparation.solid_fraction = 'none'\n\
         preparation.friction = 0.1\npreparation.mean_stress = '100 kPa'\npreparation.unbalanced_force = 0.02",
        "case",
    )?;
    let point = MaterialPoint::from_case(&case, Controls::default())?;
    let start = point.start();
    // Compression along z, by components xx, yy, zz, yz, zx, xy; a simple shear by its velocity gradient brings a rotation with it.
    let compression = Increment::from_components([0.0, 0.0, 1e-4, 0.0, 0.0, 0.0]);
    let shear = Increment::from_velocity_gradient(&[[0.0, 0.0, 2e-4], [0.0; 3], [0.0; 3]], 1.0)?;
    let answer = point.advance(&start, &compression)?;
    let sheared = point.advance(&answer.state, &shear)?;
    println!(
        "along z {:.1} kPa (noise {:.2} kPa), then in shear {:.2} kPa, void ratio {:.4}",
        answer.stress()[2][2] / 1e3,
        answer.noise()[2][2] / 1e3,
        sheared.stress()[2][0] / 1e3,
        sheared.state.void_ratio().unwrap_or(f64::NAN)
    );
    // ANCHOR_END: point

    // ANCHOR: values
    // The first state is what it was: another increment from it, and the first one again, which costs nothing and has the same bits.
    let unloading = point.advance(&start, &Increment::from_components([0.0, 0.0, -1e-4, 0.0, 0.0, 0.0]))?;
    assert!(unloading.stress()[2][2] < start.stress()[2][2]);
    assert_eq!(point.advance(&start, &compression)?.stress(), answer.stress());
    let stiffness = point.tangent(&start, Tangent::Probes { strain: 1e-5 })?;
    println!("stiffness C_zz,zz of the start {:.0} MPa", stiffness.0[2][2] / 1e6);
    // ANCHOR_END: values

    // ANCHOR: store
    // A host carries two numbers for each of its points: a name and a ticket.
    let store = Store::new();
    let first = store.put(7, start.clone());
    let tried = store.advance(7, first, &point, None, &Increment::from_components([3e-4; 6]))?;
    let taken = store.advance(7, first, &point, None, &compression)?;
    // The ticket that comes in was accepted; the trial, and the state before, are dropped.
    let next = store.advance(7, taken.ticket, &point, None, &shear)?;
    assert!(store.state(7, tried.ticket, &point).is_err());
    assert_eq!(next.state.stress(), sheared.stress());
    // ANCHOR_END: store
    store.accept(7, next.ticket, &point)?;
    assert_eq!(store.accepted(7)?.1, [Recipe::Advance(compression), Recipe::Advance(shear)]);
    Ok(())
}
