//! The complete engine: forces in lattices, conservation laws, and the same bits on any hardware.

use granum_dem::Isa;
use granum_dem::cell::Cell;
use granum_dem::config::{
    ContactModel, Grains, Material, NormalKind, Preparation, Rate, Recording, RollingKind, Shear,
    TangentialKind,
};
use granum_dem::loading::{begin, follow, preset};
use granum_dem::observer::{NoObserver, SimulationObserver};
use granum_dem::preparation::{SampleSpecification, prepare};
use granum_dem::random_insertion::random_insertion;
use granum_dem::servo::CellControl;
use granum_dem::simulation::{Hardware, InitialSphere, Properties, Simulation, SimulationError};

const DIAMETER: f64 = 1e-4;

fn properties(normal: NormalKind, tangential: TangentialKind) -> Properties {
    Properties::new(Material::default(), ContactModel::new(normal, tangential, 0.1))
}

fn lattice(spheres: &[[f64; 3]], cell: Cell, normal: NormalKind) -> Simulation {
    let spheres: Vec<InitialSphere> = spheres
        .iter()
        .enumerate()
        .map(|(k, &position)| InitialSphere { id: k as u64 + 1, position, radius: 0.5 * DIAMETER })
        .collect();
    Simulation::new(cell, &spheres, properties(normal, TangentialKind::NO_SLIP)).unwrap()
}

/// Mean stress and affine bulk modulus of simple cubic and face-centred cubic lattices (case vi of the table in the chapter on
/// contact laws of the book).
#[test]
fn lattices_have_their_stress() {
    let table = [
        (1e-5, NormalKind::HERTZ, 810.8566, 2293.449),
        (1e-4, NormalKind::HERTZ, 25646.15, 72538.28),
        (1e-3, NormalKind::HERTZ, 812464.5, 2297997.0),
    ];
    for (strain, normal, simple, face_centred) in table {
        let l = DIAMETER * (1.0 - strain);
        let s = lattice(&[[0.0; 3]], Cell::cuboid([l; 3]), normal);
        let p = s.state().mean_stress();
        assert!((p / simple - 1.0).abs() < 2e-7, "simple cubic {strain}: {p} {simple}");
        assert_eq!(s.state().contacts(), 3);
        let h = l / 2f64.sqrt();
        let cell = Cell { edges: [[0.0, h, h], [h, 0.0, h], [h, h, 0.0]] };
        let s = lattice(&[[0.0; 3]], cell, normal);
        let p = s.state().mean_stress();
        assert!((p / face_centred - 1.0).abs() < 3e-7, "face-centred {strain}: {p} {face_centred}");
        assert_eq!(s.state().contacts(), 6);
    }
    for (strain, simple) in [(1e-5, -5023.745), (1e-4, 20503.37), (1e-3, 807649.2)] {
        let s = lattice(&[[0.0; 3]], Cell::cuboid([DIAMETER * (1.0 - strain); 3]), NormalKind::JKR);
        let p = s.state().mean_stress();
        assert!((p / simple - 1.0).abs() < 2e-7, "adhesive {strain}: {p} {simple}");
    }
}

fn small_sample(hardware: Hardware, spread: f64) -> Simulation {
    let grains = Grains::default().with(|grains| {
        grains.count = 200;
        grains.spread = spread;
    });
    let preparation = Preparation::default().with(|preparation| {
        preparation.friction = Some(0.1);
        preparation.solid_fraction = None;
        preparation.inertial_number = 5e-3;
        preparation.unbalanced_force = 1e-2;
    });
    let contact = ContactModel::default();
    let specification =
        SampleSpecification { hardware, ..SampleSpecification::new(&grains, &contact, &preparation) };
    prepare(&specification, &mut NoObserver).unwrap().simulation
}

/// An observer that measures often and thoroughly.
struct Everything(f64);
impl SimulationObserver for Everything {
    fn next_observation(&self) -> f64 {
        self.0
    }
    fn observe(&mut self, state: &dyn granum_core::ObservedState) {
        assert!(!state.assembly().contacts.is_empty());
        self.0 += 1.7e-5;
    }
}

fn sheared(sample: &Simulation, hardware: Hardware, observer: &mut dyn SimulationObserver) -> String {
    let mut s = sample.clone();
    s.set_hardware(hardware);
    let rate = Rate::StrainRate { strain_rate: 100.0, density_scaling: 1.0 };
    let shear = Shear::default().with(|shear| {
        shear.rate = rate;
        shear.mean_stress = Some(20e3);
        shear.deviator_strain = 0.0005;
    });
    let stage = preset::antony2006(&shear, &Recording::default(), 20e3);
    let mut stage_progress = begin(&stage, &mut s).unwrap();
    follow(&stage, &mut stage_progress, &mut s, observer).unwrap();
    // Debug formatting of floats is exact.
    format!("{:?}", s.state())
}

#[test]
fn same_bits_on_any_machine_and_whoever_looks() {
    for spread in [0.0, 0.2] {
        let sample = small_sample(Hardware::default(), spread);
        let reference = sheared(&sample, Hardware { threads: 1, isa: Isa::detect() }, &mut NoObserver);
        for isa in Isa::ALL.into_iter().filter(|i| i.available()) {
            for threads in [1, 2, 4] {
                let other = sheared(&sample, Hardware { threads, isa }, &mut Everything(0.0));
                assert!(other == reference, "{} with {threads} threads, spread {spread}", isa.name());
            }
        }
    }
}

#[test]
fn momentum_and_energy_of_an_elastic_gas_are_kept() {
    let grains = Grains::default().with(|grains| grains.count = 100);
    let (cell, spheres) = random_insertion(&grains, 0.3, 5).unwrap();
    let material = Material::default().with(|material| {
        material.friction = 0.0;
        material.interface_energy = 0.0;
    });
    let contact = ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.0);
    let mut s = Simulation::new(cell, &spheres, Properties::new(material, contact)).unwrap();
    let velocities: Vec<[f64; 3]> =
        (0..100).map(|k| [k as f64 * 0.7, k as f64 * 1.3, k as f64 * 2.1].map(f64::sin)).collect();
    s.set_velocities(&velocities, &[]);
    s.fix_time_step(Some(2e-9));
    let energy = |s: &Simulation| {
        let a = s.assembly();
        let kinetic: f64 =
            a.bodies.iter().map(|g| 0.5 * g.mass * g.velocity.iter().map(|v| v * v).sum::<f64>()).sum();
        kinetic + a.contacts.iter().map(|c| c.normal_energy).sum::<f64>()
    };
    let momentum = |s: &Simulation| -> [f64; 3] {
        let a = s.assembly();
        std::array::from_fn(|k| a.bodies.iter().map(|g| g.mass * g.velocity[k]).sum())
    };
    let (start, push) = (energy(&s), momentum(&s));
    let mut worst = 0.0f64;
    for _ in 0..20 {
        s.advance(1000).unwrap();
        worst = worst.max((energy(&s) / start - 1.0).abs());
    }
    assert!(worst < 3e-3, "energy off by {worst}");
    let scale = s.assembly().bodies[0].mass * 10.0;
    for (a, b) in momentum(&s).iter().zip(push) {
        assert!((a - b).abs() < 1e-12 * scale, "{a} {b}");
    }
}

#[test]
fn forces_are_in_balance_with_torques() {
    let s = small_sample(Hardware::default(), 0.1);
    let a = s.assembly();
    let mut force = vec![[0.0; 3]; a.bodies.len()];
    for c in &a.contacts {
        let f = c.force();
        for k in 0..3 {
            force[c.i][k] += f[k];
            force[c.j][k] -= f[k];
        }
    }
    // The resultants of the engine include the dashpot forces, which are tiny at rest.
    let mean = a.contacts.iter().map(|c| c.normal_force).sum::<f64>() / a.contacts.len() as f64;
    for (g, f) in a.bodies.iter().zip(&force) {
        for k in 0..3 {
            assert!((g.force[k] - f[k]).abs() < 0.05 * mean, "grain {}", g.id);
        }
    }
    assert!((s.state().mean_stress() / 20e3 - 1.0).abs() < 0.02);
}

#[test]
fn a_rigidly_rotating_cell_feels_nothing() {
    let mut s = small_sample(Hardware::default(), 0.0);
    s.set_control(CellControl::fixed());
    s.advance(3000).unwrap();
    let before = s.state().mean_stress();
    assert!(before > 15e3);
    let mut control = CellControl::fixed();
    let rate = 50.0;
    control.rate[0][1] = rate;
    control.rate[1][0] = -rate;
    // The gradient rotates the cell; the grains must rotate with it, since they would otherwise roll and cause tangential
    // forces.
    let spins = vec![[0.0, 0.0, rate]; 200];
    s.set_velocities(&[], &spins);
    s.set_control(control);
    let work = s.state().energy().tangential_work;
    s.advance(2000).unwrap();
    let after = s.state().mean_stress();
    assert!((after / before - 1.0).abs() < 0.02, "{before} {after}");
    assert!((s.state().energy().tangential_work - work).abs() < 1e-9);
}

#[test]
fn impossible_grains_are_refused_by_id() {
    let sphere = |id, x: f64, radius| InitialSphere { id, position: [x, 0.0, 0.0], radius };
    let p = properties(NormalKind::HERTZ, TangentialKind::NO_SLIP);
    let cell = Cell::cuboid([1e-3; 3]);
    let message = |spheres: &[InitialSphere]| match Simulation::new(cell, spheres, p.clone()) {
        Err(e @ SimulationError::Grain { .. }) => e.to_string(),
        Err(e) => panic!("{e}"),
        Ok(_) => panic!("accepted"),
    };
    assert!(message(&[sphere(7, f64::NAN, 5e-5)]).contains("grain 7"));
    assert!(message(&[sphere(8, 0.0, -1.0)]).contains("grain 8"));
    assert!(message(&[sphere(9, 0.0, 5e-5), sphere(9, 2e-4, 5e-5)]).contains("grain 9"));
    assert!(matches!(Simulation::new(cell, &[], p.clone()), Err(SimulationError::NoGrains)));
}

#[test]
fn divergence_is_reported() {
    let mut s = small_sample(Hardware::default(), 0.0);
    s.fix_time_step(Some(1e-2));
    let mut control = CellControl::fixed();
    control.rate[0][0] = 1e300;
    s.set_control(control);
    assert!(matches!(s.advance(10), Err(SimulationError::Diverged { .. })));
}

/// Laws called through their slots give the same bits as laws compiled into the loop.
#[test]
fn both_ways_of_calling_laws_give_the_same_bits() {
    use NormalKind as N;
    use RollingKind as R;
    use TangentialKind as T;
    let sets = [
        (N::HERTZ, T::MINDLIN_DERESIEWICZ, R::NONE),
        (N::HERTZ, T::NO_SLIP, R::NONE),
        (N::JKR, T::MINDLIN_DERESIEWICZ, R::NONE),
        (N::JKR, T::NO_SLIP, R::NONE),
        (N::JKR, T::PEELING, R::NONE),
        (N::HERTZ, T::NO_SLIP, R::ELASTIC_PLASTIC),
        (N::HERTZ, T::NO_SLIP, R::SPRING_DASHPOT_SLIDER),
    ];
    for spread in [0.0, 0.3] {
        let grains = Grains::default().with(|grains| (grains.count, grains.spread) = (120, spread));
        let (cell, spheres) = random_insertion(&grains, 0.35, 3).unwrap();
        for (normal, tangential, rolling) in sets {
            let contact = ContactModel::new(normal, tangential, 0.1).with(|c| c.rolling = rolling);
            let properties = Properties::new(Material::default(), contact);
            let mut compiled = Simulation::new(cell, &spheres, properties).unwrap();
            compiled.set_control(CellControl::isotropic(20e3, 3e4));
            let mut called = compiled.clone();
            called.call_laws_through_slots();
            for s in [&mut compiled, &mut called] {
                s.advance(3000).unwrap();
            }
            assert!(compiled.state().contacts() > 10, "{} contacts", compiled.state().contacts());
            assert!(compiled.state() == called.state(), "{contact:?}, spread {spread}");
        }
    }
}

/// The first vector of a tangential law is the tangential force on the first grain, contact by contact as in the assembly.
#[test]
fn histories_are_in_the_order_of_the_contacts() {
    let mut s = small_sample(Hardware::default(), 0.1);
    s.set_control(CellControl::constant_mean_stress(0, 100.0, 20e3, 1e3));
    s.advance(300).unwrap();
    let (assembly, history) = (s.assembly(), s.contact_history());
    assert_eq!(history.contacts, assembly.contacts.len());
    let kept = history.tangential.vectors_kept;
    assert_eq!((kept, history.tangential.scalars_kept, history.moments.vectors_kept), (3, 2, 0));
    assert_eq!(history.tangential.vectors.len(), kept * history.contacts);
    assert!(assembly.contacts.iter().any(|contact| contact.tangential_force != [0.0; 3]));
    for (contact, vectors) in assembly.contacts.iter().zip(history.tangential.vectors.chunks(kept)) {
        assert_eq!(vectors[0], contact.tangential_force);
    }
}

/// Two images of one grain touch another: their histories are in the order of their contacts too.
#[test]
fn histories_of_images_are_in_the_order_of_the_contacts() {
    let l = DIAMETER * (1.0 - 1e-4);
    let mut s = lattice(&[[0.0; 3], [l, 0.0, 0.0]], Cell::cuboid([2.0 * l, l, l]), NormalKind::HERTZ);
    let mut control = CellControl::fixed();
    control.rate = [[0.0, 50.0, 3.0], [50.0, 20.0, 0.0], [3.0, 0.0, -20.0]];
    s.set_control(control);
    s.advance(40).unwrap();
    let (assembly, history) = (s.assembly(), s.contact_history());
    let both = assembly.contacts.iter().filter(|contact| contact.i != contact.j).count();
    assert_eq!((both, history.contacts), (2, assembly.contacts.len()));
    for (contact, force) in assembly.contacts.iter().zip(&history.tangential.vectors) {
        assert_eq!(*force, contact.tangential_force);
    }
}

/// A control that is set again and again, as by a program that steers a test, gives the same bits as one that stays; the servo is not begun anew.
#[test]
fn a_control_that_changes_to_itself_changes_nothing() {
    let control = CellControl::constant_mean_stress(0, 50.0, 20e3, 1e3);
    let sample = small_sample(Hardware::default(), 0.0);
    let after = |change: fn(&mut Simulation, CellControl)| {
        let mut s = sample.clone();
        s.set_control(control);
        for _ in 0..20 {
            change(&mut s, control);
            s.advance(20).unwrap();
        }
        (s.state().stress(), s.state().strain())
    };
    assert_eq!(after(Simulation::change_control), after(|_, _| ()));
    assert_ne!(after(Simulation::set_control), after(|_, _| ()));
}

/// Grains of different sizes that are far from each other at the start have no pairs, and the constants of their pairs must not be taken for
/// those of equal grains when they meet later.
#[test]
fn unequal_grains_that_meet_later_collide_as_what_they_are() {
    let run = |parts: &[u64]| {
        let sphere = |id, x: f64, radius: f64| InitialSphere { id, position: [x, 5e-4, 5e-4], radius };
        let spheres = [sphere(1, 3e-4, 5e-5), sphere(2, 6e-4, 1e-4)];
        let mut s = Simulation::new(
            Cell::cuboid([1e-3; 3]),
            &spheres,
            properties(NormalKind::HERTZ, TangentialKind::NO_SLIP),
        )
        .unwrap();
        s.set_velocities(&[[0.5, 0.0, 0.0], [-0.5, 0.0, 0.0]], &[]);
        s.fix_time_step(Some(2e-9));
        parts.iter().for_each(|steps| s.advance(*steps).unwrap());
        let assembly = s.assembly();
        assert!(assembly.bodies[0].velocity[0] < -0.5, "the small grain bounces off");
        assembly
    };
    let at_once = run(&[76_000]);
    // They are listed as near, but do not touch yet, when the second part begins.
    let in_parts = run(&[74_500, 1_500]);
    assert_eq!(at_once, in_parts);
}
