//! Bonds in the engine: single bonds up to rupture, vibrations, cement that sets under a load, energies, the same bits on threads and after a
//! restart in the middle of a cascade, and what users of other programs ran into.

use granum_core::assembly::{Assembly, Rupture, Vector};
use granum_core::cell::Cell;
use granum_core::geometry::{cross, dot};
use granum_dem::bond::{
    BondKind, BondLaw, BondLoads, BondPlaces, BondRadius, BondShape, BondStiffness, Bonding, Eight, LIMITS,
    StrengthScatter,
};
use granum_dem::config::{AdhesionKind, ContactModel, Material, NormalKind, TangentialKind};
use granum_dem::contact::LawDescription;
use granum_dem::servo::CellControl;
use granum_dem::simulation::{Hardware, InitialBody, InitialSphere, Properties, Simulation};
use granum_shape::ShapeOfSpheres;
use granum_simd::Isa;

/// Properties of grains so soft that only bonds matter, of a density.
fn soft(density: f64) -> Properties {
    let material = Material::default().with(|m| {
        (m.youngs_modulus, m.poissons_ratio, m.friction, m.density) = (1e-6, 0.3, 0.3, density);
        m.interface_energy = 0.0;
    });
    Properties::new(material, ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.0))
}

/// Two spheres along the first axis, that touch, in the middle of a wide cell.
fn two(radius: f64, properties: Properties) -> Simulation {
    let edge = 100.0 * radius;
    let sphere =
        |id: u64, x: f64| InitialSphere { id, position: [0.5 * edge + x, 0.5 * edge, 0.5 * edge], radius };
    let spheres = [sphere(1, -radius), sphere(2, radius)];
    Simulation::new(Cell::cuboid([edge; 3]), &spheres, properties).unwrap()
}

/// The bond of the golden numbers, between spheres of radius 50 um.
fn golden() -> Bonding {
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
struct Given;

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
fn stored(assembly: &Assembly) -> f64 {
    let contact = |c: &granum_core::assembly::Contact| c.normal_energy;
    assembly.bonds.iter().map(|bond| bond.energy).sum::<f64>()
        + assembly.contacts.iter().map(contact).sum::<f64>()
        + assembly.kinetic_energy()
}

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

/// Quartz-like grains under pressure.
fn compressed(count: usize, pressure: f64, hardware: Hardware) -> Simulation {
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
fn cement(strength: f64) -> Bonding {
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
fn stretched(rate: f64) -> CellControl {
    let mut control = CellControl::fixed();
    control.rate[0][0] = -rate;
    control
}

#[test]
fn cement_that_sets_under_a_load_changes_no_force() {
    let mut s = compressed(300, 100e3, Hardware::default());
    let before = s.assembly();
    let (stress, unbalanced) = (s.state().stress(), s.state().unbalanced_force());
    let made = s.bond(&cement(1e6)).unwrap();
    let after = s.assembly();
    assert!(made > before.contacts.len() && after.bonds.len() == made && s.bonds() == made);
    assert_eq!(s.state().stress(), stress);
    assert!((s.state().unbalanced_force() / unbalanced - 1.0).abs() < 1e-9);
    for (one, two) in before.contacts.iter().zip(&after.contacts) {
        assert_eq!((one.i, one.j, one.tangential_force), (two.i, two.j, two.tangential_force));
    }
    assert!(after.bonds.iter().all(|bond| bond.normal_force.abs() < 1e-12 && bond.energy < 1e-24));
    // The ledger does not jump either.
    assert_eq!(before.energy, after.energy);
    let others = s.bond(&cement(1e6)).unwrap_err().to_string();
    assert!(others.contains("nothing to bond"), "{others}");
}

#[test]
fn the_energy_balance_of_bonds_that_rupture_closes() {
    let mut s = compressed(300, 100e3, Hardware::default());
    s.bond(&cement(2e6)).unwrap();
    s.set_global_damping(0.0);
    s.set_time_step_factor(0.05);
    s.reset_phase(0.0);
    let before = s.assembly();
    let tangential = |a: &Assembly| a.contacts.iter().map(|c| c.tangential_energy).sum::<f64>();
    s.set_control(stretched(-50.0));
    s.advance(30_000).unwrap();
    let after = s.assembly();
    assert!(after.broken_bonds.len() > 20, "{} ruptured", after.broken_bonds.len());
    let by = |rupture: Rupture| -> f64 {
        after.broken_bonds.iter().filter(|bond| bond.rupture == rupture).map(|bond| bond.energy).sum()
    };
    for (key, energy) in
        [("bond_tension_loss", by(Rupture::Tension)), ("bond_shear_loss", by(Rupture::Shear))]
    {
        assert!((after.energy.channel(key) - energy).abs() <= 1e-9 * energy, "{key}");
    }
    assert!(after.energy.channel("bond_damping_loss") > 0.0);
    let work = after.energy.boundary_work;
    let error = work - after.energy.accounted(stored(&after) - stored(&before));
    // Tangential energy is part of the work of tangential forces.
    assert!(work > 0.0 && tangential(&after) > 0.0);
    assert!(error.abs() < 2e-3 * work, "{error} of {work}");
}

#[test]
fn bonds_give_the_same_bits_on_threads_and_instruction_sets_and_after_a_restart_in_a_cascade() {
    let run = |hardware: Hardware, halfway: bool| {
        let mut s = compressed(300, 100e3, hardware);
        let made = s.bond(&cement(1e6)).unwrap();
        s.set_control(stretched(-30.0));
        s.advance(4000).unwrap();
        if halfway {
            let bytes = s.checkpoint("").unwrap();
            let (restored, _) = Simulation::restore(&bytes).unwrap();
            assert!(restored.state() == s.state());
            s = restored;
        }
        s.advance(4000).unwrap();
        assert_eq!(
            s.bonds() + s.assembly().broken_bonds.len(),
            made,
            "those that hold and those that ruptured"
        );
        s
    };
    let one = run(Hardware { threads: 1, isa: Isa::Portable }, false);
    let broken = one.assembly().broken_bonds.len();
    assert!(broken > 20 && one.bonds() > 20, "{broken} {}", one.bonds());
    for isa in Isa::ALL.into_iter().filter(|isa| isa.available()) {
        let other = run(Hardware { threads: 3, isa }, true);
        assert!(other.state() == one.state(), "{isa:?}");
    }
    // Content with a checksum that fits, but altered: it is refused, or can be inspected and run.
    let bytes = one.checkpoint("").unwrap();
    for at in (24..bytes.len()).step_by(997) {
        let mut forged = bytes.clone();
        forged[at] = forged[at].wrapping_add(77);
        let sum = crc32fast::hash(&forged[24..]);
        forged[20..24].copy_from_slice(&sum.to_le_bytes());
        if let Ok((mut s, _)) = Simulation::restore(&forged) {
            assert_eq!(s.assembly().pieces.len(), 300);
            let _ = s.advance(2);
        }
    }
}

/// A fault of other programs: a pair whose bond ruptured was no ordinary pair.
#[test]
fn where_all_bonds_rupture_at_once_grains_move_as_if_they_had_never_been_bonded() {
    let run = |bonded: bool| {
        let mut s = compressed(200, 100e3, Hardware::default());
        if bonded {
            let weak = cement(1e-3).with(|bonding| bonding.scatter = StrengthScatter::None);
            s.bond(&weak).unwrap();
        }
        s.fix_time_step(Some(1e-8));
        s.set_control(stretched(20.0));
        s.advance(400).unwrap();
        s
    };
    let (never, broken) = (run(false), run(true));
    assert_eq!(broken.bonds(), 0);
    let made = broken.assembly().broken_bonds.len();
    assert!(made > 200, "{made}");
    let (a, b) = (never.assembly(), broken.assembly());
    for (one, two) in a.bodies.iter().zip(&b.bodies) {
        for k in 0..3 {
            assert!((one.position[k] - two.position[k]).abs() < 1e-9 * 0.2e-3);
        }
    }
    assert_eq!(a.contacts.len(), b.contacts.len());
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

/// Grains of four spheres become agglomerates, which move as before and then come apart.
#[test]
fn grains_of_several_pieces_become_agglomerates() {
    let tetrahedron: Vec<(Vector, f64)> =
        [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]]
            .map(|x: Vector| (x.map(|x| x * 0.5e-4 / 2.0f64.sqrt()), 0.5e-4))
            .to_vec();
    let shape = ShapeOfSpheres::new(&tetrahedron).unwrap().shape;
    let bodies: Vec<InitialBody> = (0..64)
        .map(|k| InitialBody {
            id: k + 1,
            position: [k % 4, k / 4 % 4, k / 16].map(|n| (n as f64 + 0.5) * 2.4e-4),
            orientation: granum_core::rotation::about(&[1.0, k as f64, 2.0], k as f64),
            shape: 0,
            scale: 1.0,
        })
        .collect();
    let material = Material::default().with(|m| {
        (m.youngs_modulus, m.friction, m.interface_energy) = (1e9, 0.3, 0.0);
    });
    let properties =
        Properties::new(material, ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.1));
    let mut s = Simulation::of_bodies(Cell::cuboid([9.6e-4; 3]), &[shape], &bodies, &[], properties).unwrap();
    s.set_control(CellControl::isotropic(100e3, 500.0));
    s.advance(8000).unwrap();
    let before = s.assembly();
    let mass: f64 = before.bodies.iter().map(|body| body.mass).sum();
    let bonding = cement(3e6).with(|bonding| bonding.places = BondPlaces::Inside);
    let made = s.bond(&bonding).unwrap();
    let after = s.assembly();
    assert_eq!((made, after.bodies.len(), after.all_spheres()), (6 * 64, 256, true));
    let pieces: f64 = after.bodies.iter().map(|body| body.mass).sum();
    assert!((pieces / mass - 1.0).abs() < 1e-12);
    // The same motion: the kinetic energy of the pieces is that of the bodies.
    assert!((after.kinetic_energy() / before.kinetic_energy() - 1.0).abs() < 1e-6);
    s.set_control(CellControl::isotropic(20e6, 2000.0));
    s.advance(20_000).unwrap();
    assert!(s.assembly().broken_bonds.len() > 10);
    let again = s.bond(&bonding).unwrap_err().to_string();
    assert!(again.contains("all grains are spheres"), "{again}");
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

/// The time step against the largest frequency of a bonded packing, from its stiffness and masses: central differences are stable up to
/// `dt omega = 2`. The formula of the step is one by analogy with that of contacts.
#[test]
fn the_time_step_is_stable_for_a_bonded_packing() {
    for share in [0.3, 1.0] {
        let mut s = compressed(300, 100e3, Hardware::default());
        let bonding = Bonding::default().with(|bonding| {
            (bonding.radius, bonding.largest_gap) = (BondRadius::Share(share), 0.05);
            // So stiff that contacts hardly matter.
            bonding.parameters.insert("modulus".into(), 1e12);
        });
        s.bond(&bonding).unwrap();
        let dt = s.state().time_step();
        let assembly = s.assembly();
        let fraction = dt * largest_frequency(&assembly, 1e12);
        assert!((0.4..1.6).contains(&fraction), "radius {share}: dt omega = {fraction}");
    }
}

/// The largest frequency, rad/s, of the small vibrations of spheres that are joined by parallel bonds of a modulus, Pa: by iteration.
fn largest_frequency(assembly: &Assembly, modulus: f64) -> f64 {
    let count = assembly.bodies.len();
    let law = BondKind::PARALLEL.law();
    let stiffness: Vec<BondStiffness> = assembly
        .bonds
        .iter()
        .map(|bond| {
            let shape = BondShape { radius: bond.radius, length: bond.length };
            law.stiffness(&shape, &[modulus, 0.25, 0.0])
        })
        .collect();
    let along = |x: Vector, n: Vector| -> Vector {
        let part = dot(&x, &n);
        n.map(|k| k * part)
    };
    // Forces and couples over masses and moments for displacements and rotations.
    let apply = |moved: &[[Vector; 2]]| -> Vec<[Vector; 2]> {
        let mut out = vec![[[0.0; 3]; 2]; count];
        for (bond, k) in assembly.bonds.iter().zip(&stiffness) {
            let (i, j, n) = (bond.i, bond.j, bond.normal);
            let radii = [i, j].map(|grain| assembly.bodies[grain].equivalent_radius);
            let length = dot(&bond.branch, &bond.branch).sqrt() / (radii[0] + radii[1]);
            let levers = [n.map(|x| x * length * radii[0]), n.map(|x| -x * length * radii[1])];
            let turned = [cross(&moved[i][1], &levers[0]), cross(&moved[j][1], &levers[1])];
            let u: Vector =
                std::array::from_fn(|a| moved[j][0][a] + turned[1][a] - moved[i][0][a] - turned[0][a]);
            let phi: Vector = std::array::from_fn(|a| moved[j][1][a] - moved[i][1][a]);
            let (un, pn) = (along(u, n), along(phi, n));
            let force: Vector = std::array::from_fn(|a| k.normal * un[a] + k.shear * (u[a] - un[a]));
            let couple: Vector = std::array::from_fn(|a| k.twisting * pn[a] + k.bending * (phi[a] - pn[a]));
            for (grain, lever, sign) in [(i, levers[0], -1.0), (j, levers[1], 1.0)] {
                let turning = cross(&lever, &force);
                let body = &assembly.bodies[grain];
                let moment = 0.4 * body.mass * body.equivalent_radius.powi(2);
                for a in 0..3 {
                    out[grain][0][a] += sign * force[a] / body.mass;
                    out[grain][1][a] += sign * (couple[a] + turning[a]) / moment;
                }
            }
        }
        out
    };
    let mut moved: Vec<[Vector; 2]> = (0..count)
        .map(|k| {
            let wave = |a: usize| (1.3 * k as f64 + a as f64).sin();
            // Rotations of the order of displacements over the radius.
            [[wave(0), wave(1), wave(2)], [wave(3), wave(4), wave(5)].map(|x| 1e4 * x)]
        })
        .collect();
    let mut square = 0.0;
    for _ in 0..400 {
        let next = apply(&moved);
        let size = |of: &[[Vector; 2]]| {
            let grains = of.iter().zip(&assembly.bodies);
            let energy = |([x, w], body): (&[Vector; 2], &granum_core::assembly::Body)| {
                body.mass * (dot(x, x) + 0.4 * body.equivalent_radius.powi(2) * dot(w, w))
            };
            grains.map(energy).sum::<f64>().sqrt()
        };
        square = size(&next) / size(&moved);
        let scale = 1.0 / size(&next);
        moved = next.into_iter().map(|grain| grain.map(|x| x.map(|k| k * scale))).collect();
    }
    square.sqrt()
}

/// A fault of other programs: measuring the stiffness of a cemented cell broke its bonds. Probes work on copies.
#[test]
fn probes_of_a_copy_leave_bonds_and_bits_as_they_are() {
    let mut s = compressed(200, 100e3, Hardware::default());
    let made = s.bond(&cement(1e5)).unwrap();
    s.set_control(CellControl::fixed());
    s.advance(50).unwrap();
    let before = s.clone();
    assert!(s.bonds() > made / 2);
    for rate in [100.0, -100.0] {
        let mut probe = s.clone();
        probe.set_control(stretched(rate));
        let steps = (1e-3 / 100.0 / probe.state().time_step()) as u64;
        probe.advance(steps).unwrap();
        assert!(
            probe.bonds() < s.bonds(),
            "the probe itself ruptures bonds: {} of {}",
            probe.bonds(),
            s.bonds()
        );
    }
    assert!(s.state() == before.state() && s.bonds() == before.bonds());
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
