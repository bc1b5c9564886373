//! Order and stability of the time integration.

use granum_core::cell::Cell;
use granum_dem::simulation::{InitialSphere, Simulation};

use super::sample::properties;

const SPACING: f64 = 1e-4 * (1.0 - 1e-3);

/// A compressed cubic lattice of 27 grains with six contacts each.
fn lattice(friction: f64, damping: f64) -> Simulation {
    let spheres: Vec<InitialSphere> = (0..27)
        .map(|k| InitialSphere {
            id: k + 1,
            position: [k % 3, k / 3 % 3, k / 9].map(|n| n as f64 * SPACING),
            radius: 5e-5,
        })
        .collect();
    Simulation::new(Cell::cuboid([3.0 * SPACING; 3]), &spheres, properties(friction, damping)).unwrap()
}

/// Lets the lattice vibrate for 2 microseconds, about three periods, and returns the overlaps of its contacts.
fn vibrated(friction: f64, damping: f64, steps: u64) -> Vec<f64> {
    let mut s = lattice(friction, damping);
    // The velocities are so small that no contact opens.
    let velocities: Vec<[f64; 3]> = (0..27)
        .map(|k| [f64::from(k) * 0.7, f64::from(k) * 1.3, f64::from(k) * 2.1].map(|x| 0.03 * x.sin()))
        .collect();
    s.set_velocities(&velocities, &[]);
    s.fix_time_step(Some(2e-6 / steps as f64));
    s.advance(steps).unwrap();
    assert_eq!(s.state().contacts(), 81);
    // Positions may have been wrapped into the cell, which does not change distances.
    s.assembly().contacts.iter().map(|c| c.approach).collect()
}

/// Ratio of the changes of the result in two successive halvings of the time step: 4 for second order, 2 for first order.
fn gain(friction: f64, damping: f64) -> f64 {
    let runs = [500, 1000, 2000].map(|steps| vibrated(friction, damping, steps));
    let change = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum::<f64>().sqrt();
    change(&runs[0], &runs[1]) / change(&runs[1], &runs[2])
}

#[test]
fn elastic_motion_is_of_second_order() {
    let elastic = gain(0.0, 0.0);
    let rough = gain(1e3, 0.0);
    let damped = gain(0.0, 0.1);
    println!("gain: elastic {elastic:.3}, with tangential forces {rough:.3}, with dashpots {damped:.3}");
    assert!((elastic - 4.0).abs() < 0.1, "{elastic}");
    assert!((rough - 4.0).abs() < 0.3, "{rough}");
    // Dashpots use velocities that are half a step old, so that the integration is of first order.
    assert!((damped - 2.0).abs() < 0.2, "{damped}");
}

/// Ratio of the largest spin after 400 steps to the initial one, with all grains spinning in phase; the time step is the
/// given share of the theoretical stability limit.
fn growth(damping: f64, share: f64) -> f64 {
    let mut s = lattice(1e3, damping);
    // The first step determines the stiffness and with it the stability limit.
    s.fix_time_step(Some(1e-12));
    s.advance(1).unwrap();
    let inverse_root = 1e-12 / s.state().time_step_fraction();
    let limit = s.properties().contact.stable_fraction(6.0);
    s.fix_time_step(Some(share * limit * inverse_root));
    let start = 1e-6;
    s.set_velocities(&[[0.0; 3]; 27], &[[0.0, 0.0, start]; 27]);
    s.advance(400).unwrap();
    s.assembly().bodies.iter().map(|g| g.spin[2].abs()).fold(0.0, f64::max) / start
}

/// The stability limit of the time step is the value at which spinning in phase begins to grow, for any damping.
#[test]
fn spinning_grains_are_stable_up_to_the_limit() {
    for damping in [0.0, 0.03, 0.1, 0.33, 1.0] {
        let (below, above) = (growth(damping, 0.98), growth(damping, 1.02));
        println!("damping {damping}: {below:.2e} below, {above:.2e} above the limit");
        assert!(below < 10.0 && above > 1e3, "damping {damping}: {below:e}, {above:e}");
    }
}
