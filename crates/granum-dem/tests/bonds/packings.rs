//! Bonded packings: cement that sets under a load, energies, the same bits, agglomerates.

use granum_core::assembly::{Assembly, Rupture, Vector};
use granum_core::cell::Cell;
use granum_dem::bond::{BondPlaces, StrengthScatter};
use granum_dem::config::{ContactModel, Material, NormalKind, TangentialKind};
use granum_dem::servo::CellControl;
use granum_dem::simulation::{Hardware, InitialBody, Properties, Simulation};
use granum_shape::ShapeOfSpheres;
use granum_simd::Isa;

use crate::samples::*;

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
