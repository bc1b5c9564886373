//! Single bonds: up to rupture, vibrations, momenta, and what is refused.

use granum_core::assembly::{Assembly, Rupture, Vector};
use granum_core::cell::Cell;
use granum_core::geometry::{cross, dot};
use granum_dem::bond::{BondKind, BondPlaces, BondRadius, Bonding};
use granum_dem::config::{AdhesionKind, NormalKind};
use granum_dem::simulation::{InitialBody, InitialSphere, Properties, Simulation};
use granum_shape::ShapeOfSpheres;

use crate::samples::*;

/// Angular momentum about the first body.
fn angular_momentum(assembly: &Assembly) -> Vector {
    let origin = assembly.bodies[0].position;
    let mut total = [0.0; 3];
    for body in &assembly.bodies {
        let place: Vector = std::array::from_fn(|a| body.position[a] - origin[a]);
        let orbital = cross(&place, &body.velocity);
        for a in 0..3 {
            total[a] += body.mass * (orbital[a] + 0.4 * body.equivalent_radius.powi(2) * body.spin[a]);
        }
    }
    total
}

/// Two unit spheres that tumble about each other for 20 units of time: momentum is exact, and the error of the energy falls with the
/// square of the step.
#[test]
fn a_tumbling_pair_keeps_its_momenta_and_its_energy() {
    let error = |dt: f64| {
        let mut s = two(0.5, soft(6.0 / std::f64::consts::PI));
        s.bond(&Bonding::default().with(|bonding| bonding.law = BondKind::new(&Given))).unwrap();
        assert!((s.assembly().bodies[0].mass - 1.0).abs() < 1e-12);
        s.set_velocities(
            &[[0.02, 0.05, -0.03], [-0.02, -0.05, 0.03]],
            &[[0.05, 0.02, 0.1], [-0.06, 0.04, 0.02]],
        );
        s.fix_time_step(Some(dt));
        let momentum = angular_momentum(&s.assembly());
        let (mut before, mut worst, mut most) = (None, 0.0f64, 0.0f64);
        for _ in 0..(20.0 / (50.0 * dt)) as usize {
            s.advance(49).unwrap();
            let (assembly, energy) = synchronous(&mut s);
            let start = *before.get_or_insert(energy);
            worst = worst.max((energy - start).abs());
            most = most.max(assembly.bonds[0].energy);
            let now = angular_momentum(&assembly);
            for a in 0..3 {
                assert!((now[a] - momentum[a]).abs() < 2e-13, "{now:?} {momentum:?}");
                let whole: f64 = assembly.bodies.iter().map(|b| b.mass * b.velocity[a]).sum();
                assert!(whole.abs() < 5e-14, "{whole}");
            }
        }
        assert!(most > 1e-4, "{most}");
        worst / most
    };
    let errors = [2e-3, 1e-3, 5e-4].map(error);
    // An independent integration found 1.0e-3, 2.6e-4 and 6.5e-5 at angles of about 0.01 rad.
    assert!(errors[0] < 2e-3 && errors[1] < 0.35 * errors[0] && errors[2] < 0.35 * errors[1], "{errors:?}");
}

/// Makes a step; the state before it, and its energy with velocities of the same instant: those of a state are half a step old.
fn synchronous(s: &mut Simulation) -> (Assembly, f64) {
    let before = s.assembly();
    s.advance(1).unwrap();
    let after = s.assembly();
    let mut now = before.clone();
    for (body, later) in now.bodies.iter_mut().zip(&after.bodies) {
        for a in 0..3 {
            body.velocity[a] = 0.5 * (body.velocity[a] + later.velocity[a]);
            body.spin[a] = 0.5 * (body.spin[a] + later.spin[a]);
        }
    }
    let energy = stored(&now);
    (before, energy)
}

/// Heavy spheres are moved as a mode asks for, until the bond ruptures.
fn rupture(velocities: [Vector; 2], spins: [Vector; 2]) -> (Rupture, f64, f64) {
    let mut s = two(50e-6, soft(1e24));
    s.bond(&golden()).unwrap();
    s.set_velocities(&velocities, &spins);
    s.fix_time_step(Some(1e-3));
    for _ in 0..20_000 {
        s.advance(1).unwrap();
        let assembly = s.assembly();
        if let Some(broken) = assembly.broken_bonds.first() {
            assert!(assembly.bonds.is_empty() && s.bonds() == 0);
            return (broken.rupture, broken.energy, broken.time);
        }
    }
    panic!("nothing ruptured");
}

#[test]
fn a_single_bond_ruptures_in_each_mode_at_the_golden_energy() {
    let v = 1e-6;
    let near = |found: f64, right: f64| assert!((found / right - 1.0).abs() < 3e-3, "{found} {right}");
    let (mode, energy, time) = rupture([[-0.5 * v, 0.0, 0.0], [0.5 * v, 0.0, 0.0]], [[0.0; 3]; 2]);
    assert_eq!(mode, Rupture::Tension);
    near(energy, 2.513_274_122_9e-8);
    near(time * v, 2e-6);
    let (mode, energy, time) = rupture([[0.0, -0.5 * v, 0.0], [0.0, 0.5 * v, 0.0]], [[0.0; 3]; 2]);
    assert_eq!(mode, Rupture::Shear);
    near(energy, 3.534_291_735_3e-8);
    near(time * v, 3.75e-6);
    // Both turn against each other, so that neither end leaves the middle.
    let w = 0.02;
    let (mode, energy, _) = rupture(
        [[0.0, 0.5 * w * 50e-6, 0.0], [0.0, 0.5 * w * 50e-6, 0.0]],
        [[0.0, 0.0, -0.5 * w], [0.0, 0.0, 0.5 * w]],
    );
    assert_eq!(mode, Rupture::Tension);
    // The ends leave the middle by R (1 - cos a) each as they turn by a, which adds a little tension: the bond ruptures where both together
    // reach the strength, before the 6.28e-9 J of bending alone.
    let (radius, modulus, length) = (50e-6, 1e9, 1e-4);
    let at = |a: f64| (2.0 * radius * (1.0 - a.cos()), 2.0 * a.tan());
    let stress = |a: f64| modulus / length * (at(a).0 + at(a).1 * 20e-6);
    let (mut low, mut high) = (0.0, 0.06);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if stress(middle) < 20e6 { low = middle } else { high = middle }
    }
    let (u, phi) = at(low);
    near(energy, 0.5 * (1.256_637_061_4e4 * u * u + 1.256_637_061_4e-6 * phi * phi));
    let (mode, energy, time) = rupture([[0.0; 3]; 2], [[-0.5 * w, 0.0, 0.0], [0.5 * w, 0.0, 0.0]]);
    assert_eq!(mode, Rupture::Shear);
    near(energy, 1.767_145_867_6e-8);
    near(time * w, 0.186_953_6);
    // Pressed together it holds.
    let mut s = two(50e-6, soft(1e24));
    s.bond(&golden()).unwrap();
    s.set_velocities(&[[0.5 * v, 0.0, 0.0], [-0.5 * v, 0.0, 0.0]], &[]);
    s.fix_time_step(Some(1e-3));
    s.advance(4000).unwrap();
    let bond = s.assembly().bonds[0];
    assert!((bond.normal_force / 5.026_548_2e-2 - 1.0).abs() < 1e-6, "{}", bond.normal_force);
}

/// `omega^2 = 2 k_n A / m`, `2 k_n I / I_s`, `2 k_s J / I_s`.
#[test]
fn a_pair_vibrates_with_its_frequencies() {
    let half_period = |velocities: [Vector; 2], spins: [Vector; 2], of: &dyn Fn(&Assembly) -> f64| {
        let mut s = two(0.5, soft(6.0 / std::f64::consts::PI));
        s.bond(&Bonding::default().with(|bonding| bonding.law = BondKind::new(&Given))).unwrap();
        s.set_velocities(&velocities, &spins);
        s.fix_time_step(Some(1e-4));
        let mut before = of(&s.assembly());
        for step in 1..20_000 {
            s.advance(1).unwrap();
            let now = of(&s.assembly());
            if step > 1 && before > 0.0 && now <= 0.0 {
                return (step as f64 - 1.0 + before / (before - now)) * 1e-4;
            }
            before = now;
        }
        panic!("no oscillation");
    };
    let stretch =
        half_period([[-1e-4, 0.0, 0.0], [1e-4, 0.0, 0.0]], [[0.0; 3]; 2], &|a| -a.bonds[0].normal_force);
    let twist =
        half_period([[0.0; 3]; 2], [[-1e-3, 0.0, 0.0], [1e-3, 0.0, 0.0]], &|a| a.bonds[0].twisting_couple);
    for (found, square) in [(stretch, 2000.0f64), (twist, 320.0)] {
        let right = std::f64::consts::PI / square.sqrt();
        assert!((found / right - 1.0).abs() < 2e-3, "{found} {right}");
    }
}

/// Five bonded spheres in a row that bend freely, across the boundary of a skewed cell: the frequency of a free beam of the same springs,
/// from the eigenvalues of textbook matrices.
#[test]
fn a_free_chain_in_a_skewed_cell_bends_with_its_frequency() {
    let (radius, edge) = (50e-6, 1e-3);
    let along = [0.6, 0.64, 0.48];
    let across = [0.8, -0.48, -0.36];
    let about = cross(&along, &across);
    let cell = Cell { edges: [[edge, 0.3 * edge, 0.1 * edge], [0.0, edge, -0.2 * edge], [0.0, 0.0, edge]] };
    let spheres: Vec<InitialSphere> = (0..5)
        .map(|k| {
            let place = std::array::from_fn(|a| (2.0 * k as f64 - 4.0) * radius * along[a]);
            InitialSphere { id: k as u64 + 1, position: place, radius }
        })
        .collect();
    let mut s = Simulation::new(cell, &spheres, soft(2650.0)).unwrap();
    assert_eq!(s.bond(&golden()).unwrap(), 4);
    let (frequency, size) = (263_093.268_843_673_3, 1e-5);
    let shape = [1.0, -0.464_967_328_534, -1.070_065_342_932, -0.464_967_328_534, 1.0];
    let turns = [-17_019.703_008_617, -11_897.502_144_371, 0.0, 11_897.502_144_371, 17_019.703_008_617];
    let velocities = shape.map(|x| across.map(|a| size * x * a));
    let spins = turns.map(|x| about.map(|a| size * x * a));
    s.set_velocities(&velocities, &spins);
    let dt = 2e-3 / frequency;
    s.fix_time_step(Some(dt));
    // The velocity of an end is a cosine: five half periods end at its fifth zero.
    let end = |s: &Simulation| dot(&s.assembly().bodies[0].velocity, &across);
    let (mut before, mut zeros, mut step) = (end(&s), 0, 0.0);
    while zeros < 5 {
        s.advance(1).unwrap();
        let now = end(&s);
        zeros += usize::from(before * now < 0.0);
        step += if zeros < 5 { 1.0 } else { before / (before - now) };
        before = now;
    }
    // The first zero comes after a quarter of a period.
    let found = 4.5 * std::f64::consts::PI / (step * dt);
    assert!((found / frequency - 1.0).abs() < 1e-3, "{found} {frequency}");
}

/// A fault of other programs: the image of a bond was lost when its grains went round the cell.
#[test]
fn a_bond_goes_round_the_cell() {
    let mut s = two(50e-6, soft(2650.0));
    s.bond(&golden()).unwrap();
    let edge = 100.0 * 50e-6;
    s.set_velocities(&[[0.3, 0.2, 0.1]; 2], &[]);
    let dt = 1e-7;
    s.fix_time_step(Some(dt));
    s.advance((3.2 * edge / 0.1 / dt) as u64).unwrap();
    let assembly = s.assembly();
    assert!(s.rebuilds() > 5, "{}", s.rebuilds());
    let bond = assembly.bonds[0];
    assert!(bond.energy < 1e-9 * 2.5e-8, "{}", bond.energy);
    assert!((dot(&bond.branch, &bond.branch).sqrt() / 1e-4 - 1.0).abs() < 1e-9);
}

/// A fault of other programs: strength belonged to the grain.
#[test]
fn the_strength_of_a_bond_is_its_own() {
    let radius = 50e-6;
    let edge = 100.0 * radius;
    let sphere =
        |id: u64, x: f64| InitialSphere { id, position: [0.5 * edge + x, 0.5 * edge, 0.5 * edge], radius };
    let spheres = [sphere(1, -2.0 * radius), sphere(2, 0.0), sphere(3, 2.0 * radius)];
    let mut s = Simulation::new(Cell::cuboid([edge; 3]), &spheres, soft(1e24)).unwrap();
    s.bond_pieces(&golden(), &[[0, 1]]).unwrap();
    let weak = golden().with(|bonding| {
        bonding.parameters.insert("tensile_strength".into(), 2e6);
    });
    s.bond_pieces(&weak, &[[1, 2]]).unwrap();
    let v = 1e-6;
    s.set_velocities(&[[-v, 0.0, 0.0], [0.0; 3], [v, 0.0, 0.0]], &[]);
    s.fix_time_step(Some(1e-3));
    let mut largest = [0.0f64; 2];
    for _ in 0..20_000 {
        if s.bonds() == 0 {
            break;
        }
        for bond in s.assembly().bonds {
            largest[bond.id as usize] = -bond.normal_force;
        }
        s.advance(1).unwrap();
    }
    assert!((largest[0] / 2.513_274_1e-2 - 1.0).abs() < 2e-3, "{largest:?}");
    assert!((largest[1] / 2.513_274_1e-3 - 1.0).abs() < 2e-2, "{largest:?}");
    let order: Vec<u64> = s.assembly().broken_bonds.iter().map(|bond| bond.id).collect();
    assert_eq!(order, [1, 0]);
}

#[test]
fn what_cannot_be_bonded_is_refused_by_name() {
    let refused = |bonding: Bonding, properties: Properties| {
        two(50e-6, properties).bond(&bonding).unwrap_err().to_string()
    };
    let said = |message: String, text: &str| assert!(message.contains(text), "{message}");
    let mut wet = soft(2650.0);
    wet.contact.adhesion = AdhesionKind::CAPILLARY_BRIDGE;
    said(refused(golden(), wet), "contact.adhesion = \"capillary-bridge\" attracts grains");
    let mut sticky = soft(2650.0);
    sticky.material.interface_energy = 1e-9;
    sticky.contact.normal = NormalKind::JKR;
    sticky.material.youngs_modulus = 1e9;
    said(refused(golden(), sticky), "it must be 0");
    let mut given = golden();
    given.parameters.insert("modulus".into(), -1.0);
    said(refused(given, soft(2650.0)), "modulus is -1 Pa; it must be between 1");
    let wide = golden().with(|bonding| bonding.radius = BondRadius::Share(1.5));
    said(refused(wide, soft(2650.0)), "the share of the radius is 1.5");
    let full = golden().with(|bonding| bonding.radius = BondRadius::Cement { content: 0.9, density: 2650.0 });
    said(refused(full, soft(2650.0)), "more than the 1 necks hold");
    let mut s = two(50e-6, soft(2650.0));
    said(s.bond_pieces(&golden(), &[[0, 2]]).unwrap_err().to_string(), "there are 2 pieces, counted from 0");
}

/// Two dimers, joined by a bond between two of their pieces, that tumble: momenta are exact, and a common rotation loads nothing.
#[test]
fn bonds_join_grains_of_several_pieces() {
    let dimer = [([-0.25, 0.0, 0.0], 0.5), ([0.25, 0.0, 0.0], 0.5)];
    let shape = ShapeOfSpheres::new(&dimer).unwrap().shape;
    let body = |id: u64, x: f64| InitialBody {
        id,
        position: [25.0 + x, 25.0, 25.0],
        orientation: granum_core::rotation::IDENTITY,
        shape: 0,
        scale: 1.0,
    };
    let bodies = [body(1, -0.75), body(2, 0.75)];
    let pair = |velocities: &[Vector], spins: &[Vector]| {
        let cell = Cell::cuboid([50.0; 3]);
        let mut s =
            Simulation::of_bodies(cell, std::slice::from_ref(&shape), &bodies, &[], soft(1.0)).unwrap();
        let given = Bonding::default().with(|bonding| bonding.law = BondKind::new(&Given));
        assert_eq!(s.bond(&given).unwrap(), 1, "the touching pieces of different bodies");
        s.set_velocities(velocities, spins);
        s.fix_time_step(Some(5e-4));
        s
    };
    let momentum = |assembly: &Assembly| -> Vector {
        let mut total = [0.0; 3];
        for body in &assembly.bodies {
            let rigid = assembly.rigid[body.rigid.unwrap() as usize];
            let axes = granum_core::rotation::matrix(&rigid.orientation);
            let spin = granum_core::rotation::to_body(&axes, &body.spin);
            let own =
                granum_core::rotation::to_space(&axes, &std::array::from_fn(|k| rigid.inertia[k] * spin[k]));
            let place: Vector = std::array::from_fn(|a| body.position[a] - 25.0);
            let orbital = cross(&place, &body.velocity);
            for a in 0..3 {
                total[a] += own[a] + body.mass * orbital[a];
            }
        }
        total
    };
    let mut s = pair(&[[0.02, 0.05, -0.03], [-0.02, -0.05, 0.03]], &[[0.05, 0.02, 0.1], [-0.06, 0.04, 0.02]]);
    let before = momentum(&s.assembly());
    s.advance(8000).unwrap();
    let assembly = s.assembly();
    assert!(assembly.bonds[0].energy > 1e-6);
    for (now, before) in momentum(&assembly).into_iter().zip(before) {
        assert!((now - before).abs() < 1e-11, "{now} {before}");
    }
    // About the third axis through the middle: the bond is pulled by the centripetal force alone.
    let w = 0.01;
    let mut s = pair(&[[0.0, -0.75 * w, 0.0], [0.0, 0.75 * w, 0.0]], &[[0.0, 0.0, w]; 2]);
    s.advance(8000).unwrap();
    let bond = s.assembly().bonds[0];
    let mass = s.assembly().bodies[0].mass;
    assert!((-bond.normal_force).abs() < 2.1 * mass * w * w * 0.75, "{}", bond.normal_force);
    assert!(
        dot(&bond.bending_couple, &bond.bending_couple).sqrt() < 1e-6 && bond.twisting_couple.abs() < 1e-9
    );
}

/// Bonds that cannot be made leave a simulation as it was, whatever was changed on the way.
#[test]
fn bonds_that_are_refused_change_nothing() {
    let dimer = [([-0.5e-4, 0.0, 0.0], 0.5e-4), ([0.5e-4, 0.0, 0.0], 0.5e-4)];
    let shape = ShapeOfSpheres::new(&dimer).unwrap().shape;
    let body = InitialBody {
        id: 1,
        position: [1e-3; 3],
        orientation: granum_core::rotation::IDENTITY,
        shape: 0,
        scale: 1.0,
    };
    let mut s = Simulation::of_bodies(Cell::cuboid([2e-3; 3]), &[shape], &[body], &[], soft(2650.0)).unwrap();
    let before = s.clone();
    let full = golden().with(|bonding| {
        bonding.places = BondPlaces::Inside;
        bonding.radius = BondRadius::Cement { content: 0.9, density: 2650.0 };
    });
    assert!(s.bond(&full).is_err());
    assert!(s.state() == before.state() && s.state().grains() == 1);
    s.bond(&golden().with(|bonding| bonding.places = BondPlaces::Inside)).unwrap();
    assert_eq!((s.state().grains(), s.bonds()), (2, 1));
}
