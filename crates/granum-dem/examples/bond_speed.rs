//! What a bond costs: time of a step of a sample, as it is, with contacts that remember (Mindlin-Deresiewicz) and with bonds, and of larger
//! bonded samples.
//!
//! ```sh
//! cargo run --release -p granum-dem --example bond_speed
//! ```

use std::time::Instant;

use granum_dem::bond::Bonding;
use granum_dem::config::{ContactModel, Grains, Material, NormalKind, TangentialKind};
use granum_dem::random_insertion::random_insertion;
use granum_dem::servo::CellControl;
use granum_dem::simulation::{Hardware, Properties, Simulation};

/// A sample of equal grains under pressure.
fn sample(count: usize, threads: usize) -> Simulation {
    let material = Material::default().with(|m| {
        (m.youngs_modulus, m.friction, m.density, m.interface_energy) = (1e9, 0.3, 2650.0, 0.0);
    });
    let grains = Grains::default().with(|g| (g.count, g.diameter, g.spread) = (count, 0.2e-3, 0.2));
    let contact = ContactModel::new(NormalKind::HERTZ, TangentialKind::MINDLIN_DERESIEWICZ, 0.2);
    let (cell, spheres) = random_insertion(&grains, 0.4, 5).expect("grains");
    let mut s = Simulation::new(cell, &spheres, Properties::new(material, contact)).expect("sample");
    s.set_hardware(Hardware { threads, ..Hardware::default() });
    s.expect_force(4e-3);
    s.set_control(CellControl::isotropic(100e3, 400.0));
    s.set_global_damping(2e4);
    s.advance(4000).expect("compaction");
    s
}

/// Microseconds of a step, the least of several rounds.
fn step(s: &mut Simulation) -> f64 {
    let steps = (400_000 / s.state().grains()).max(20) as u64;
    let round = |s: &mut Simulation| {
        let start = Instant::now();
        s.advance(steps).expect("steps");
        start.elapsed().as_secs_f64() / steps as f64 * 1e6
    };
    (0..5).map(|_| round(s)).fold(f64::INFINITY, f64::min)
}

fn main() {
    println!("grains  contacts  bonds  us a step without, with bonds  ns a contact  ns a bond");
    for count in [1000, 5000, 30_000, 100_000] {
        let mut s = sample(count, 1);
        let without = step(&mut s);
        let contacts = s.state().contacts();
        let made = s.bond(&Bonding::default().with(|bonding| bonding.largest_gap = 0.02)).expect("bonds");
        let with = step(&mut s);
        let (a_contact, a_bond) = (1e3 * without / contacts as f64, 1e3 * (with - without) / made as f64);
        println!(
            "{count:6}  {contacts:8}  {made:5}  {without:9.1} {with:9.1}  {a_contact:8.1}  {a_bond:8.1}"
        );
    }
}
