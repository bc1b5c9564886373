//! Laws with additional parameters in the engine: granum's and a caller's.

mod channels;
#[path = "../common/mod.rs"]
mod common;

use granum_core::RegistrationError;
use granum_dem::Isa;
use granum_dem::assembly::Assembly;
use granum_dem::cell::Cell;
use granum_dem::config::{ContactModel, Material, NormalKind, RollingKind, TangentialKind};
use granum_dem::contact::choice::registry::Laws;
use granum_dem::contact::normal::Hertz;
use granum_dem::contact::normal::hertz::HertzConstants;
use granum_dem::contact::{LawDescription, LawParameter, Normal, NormalLaw, PairProperties, Unit};
use granum_dem::servo::CellControl;
use granum_dem::simulation::{Hardware, InitialSphere, Properties, Simulation, SimulationError};
use granum_simd::Real;

const DIAMETER: f64 = 1e-4;

fn plain() -> Material {
    Material::default().with(|material| material.interface_energy = 0.0)
}

/// A linear spring with rolling resistance.
fn soft(damping: f64, rolling_friction: f64, rolling_damping: f64) -> ContactModel {
    let mut contact = ContactModel::new(NormalKind::HOOKE, TangentialKind::NO_SLIP, damping);
    contact.rolling = RollingKind::ELASTIC_PLASTIC;
    for (key, value) in [
        ("normal_stiffness", 2e4),
        ("rolling_friction", rolling_friction),
        ("rolling_damping", rolling_damping),
    ] {
        contact.parameters.set(key, value).unwrap();
    }
    contact
}

/// A linear spring with a rolling spring of a constant stiffness, N/m, and a dashpot, N s/m.
fn constant(damping: f64, friction: f64, stiffness: f64, viscosity: f64) -> ContactModel {
    let mut contact = ContactModel::new(NormalKind::HOOKE, TangentialKind::NO_SLIP, damping);
    contact.rolling = RollingKind::SPRING_DASHPOT_SLIDER;
    for (key, value) in [
        ("normal_stiffness", 2e4),
        ("rolling_friction", friction),
        ("rolling_stiffness", stiffness),
        ("rolling_viscosity", viscosity),
    ] {
        contact.parameters.set(key, value).unwrap();
    }
    contact
}

/// Kinetic, normal, tangential and rolling energy, J.
fn stored(assembly: &Assembly) -> [f64; 4] {
    let square = |v: &[f64; 3]| v.iter().map(|x| x * x).sum::<f64>();
    let kinetic = assembly
        .bodies
        .iter()
        .map(|g| {
            0.5 * g.mass
                * (square(&g.velocity) + 0.4 * g.equivalent_radius * g.equivalent_radius * square(&g.spin))
        })
        .sum();
    let sum = |of: fn(&granum_dem::assembly::Contact) -> f64| assembly.contacts.iter().map(of).sum();
    [kinetic, sum(|c| c.normal_energy), sum(|c| c.tangential_energy), sum(|c| c.rolling_energy)]
}

/// Two grains in a periodic row, pressed together and spinning in opposite directions.
fn rocking(contact: ContactModel, spin: f64) -> Simulation {
    let gap = DIAMETER * 0.999;
    let cell = Cell::cuboid([2.0 * gap, 3.0 * DIAMETER, 3.0 * DIAMETER]);
    let sphere = |id, x| InitialSphere { id, position: [x, DIAMETER, DIAMETER], radius: 0.5 * DIAMETER };
    let properties = Properties::new(plain(), contact);
    let mut s = Simulation::new(cell, &[sphere(1, 0.2 * gap), sphere(2, 1.2 * gap)], properties).unwrap();
    s.set_velocities(&[], &[[0.0, 0.0, spin], [0.0, 0.0, -spin]]);
    s
}

/// Each grain has two contacts of stiffness k that rotate by twice its own angle: `w^2 = 4 k / I` with `I = 2/5 m R^2`.
#[test]
fn grains_rock_on_each_other_at_the_frequency_of_the_spring() {
    let lever = 0.25 * DIAMETER;
    check_rocking(soft(0.0, 0.5, 0.0), 2.25 * 2e4 * (0.5 * lever) * (0.5 * lever));
    check_rocking(constant(0.0, 0.5, 3e3, 0.0), 3e3 * lever * lever);
}

fn check_rocking(contact: ContactModel, stiffness: f64) {
    let (r, m) = (0.5 * DIAMETER, 2650.0 * std::f64::consts::PI / 6.0 * DIAMETER.powi(3));
    let frequency = (4.0 * stiffness / (0.4 * m * r * r)).sqrt();
    // Far below the limit mu_r R* N.
    let spin = 1e-3 * frequency * (0.5 * 0.5 * r * 2e4 * 1e-3 * DIAMETER) / stiffness;
    let mut s = rocking(contact, spin);
    let steps = 4000u32;
    s.fix_time_step(Some(2.0 * std::f64::consts::PI / frequency / f64::from(steps)));
    let start = stored(&s.assembly());
    for quarter in 1..=8u32 {
        s.advance(u64::from(steps) / 4).unwrap();
        let a = s.assembly();
        // The spin is known at the middle of the last step.
        let phase = std::f64::consts::TAU * (f64::from(quarter) / 4.0 - 0.5 / f64::from(steps));
        for (k, sign) in [(0, 1.0), (1, -1.0)] {
            let off = a.bodies[k].spin[2] - sign * spin * phase.cos();
            assert!(
                off.abs() < 2e-3 * spin,
                "quarter {quarter}: {} {}",
                a.bodies[k].spin[2],
                spin * phase.cos()
            );
        }
        assert!(a.bodies.iter().all(|g| g.velocity.iter().all(|v| v.abs() < 1e-6 * spin * r)));
        let now = stored(&a);
        let (all, first) = (now[0] + now[3], start[0]);
        assert!((all / first - 1.0).abs() < 2e-3, "quarter {quarter}: {all:e} {first:e}");
        assert!(a.energy.rolling.abs() < 1e-9 * first);
        assert!((a.energy.rolling_work - now[3]).abs() < 1e-9 * first);
    }
}

/// A grain that spins too fast for the spring rolls, and its energy is finally lost by rolling and in the dashpot.
#[test]
fn rolling_ends_in_losses_that_are_counted() {
    check_losses(soft(0.0, 0.05, 0.02), 2e-8);
    check_losses(constant(0.0, 0.05, 1e3, 6e-5), 1e-8);
}

fn check_losses(contact: ContactModel, step: f64) {
    let mut s = rocking(contact, 20_000.0);
    s.fix_time_step(Some(step));
    let start = stored(&s.assembly());
    s.advance((1.2e-3 / step) as u64).unwrap();
    let (a, end) = (s.assembly(), stored(&s.assembly()));
    assert!(end[0] < 1e-3 * start[0], "{:e} of {:e} left", end[0], start[0]);
    let e = a.energy;
    assert!(e.rolling > 0.5 * start[0] && e.damping > 0.0, "{e:?}");
    let accounted = e.rolling_work + e.tangential_work + e.damping + end[0] + end[1] - start[1];
    assert!((accounted / start[0] - 1.0).abs() < 1e-3, "{accounted:e} {:e}", start[0]);
    assert!((e.rolling_work - e.rolling - end[3]).abs() < 1e-9 * start[0]);
}

fn sample(properties: Properties, spread: f64, hardware: Hardware) -> Simulation {
    common::compressed(200, spread, properties, 4000, hardware)
}

/// On every instruction set, with several threads, and through a checkpoint; with the energy in balance.
#[test]
fn new_laws_have_the_same_bits_everywhere() {
    let old = soft(0.1, 0.2, 0.3);
    check_bits_and_energy(&Properties::new(plain(), old), &[0.0, 0.3]);
    check_bits_and_energy(&Properties::new(plain(), constant(0.1, 0.2, 1e3, 1e-3)), &[0.3]);
}

fn check_bits_and_energy(properties: &Properties, spreads: &[f64]) {
    for &spread in spreads {
        let mut reference = sample(properties.clone(), spread, Hardware { threads: 1, isa: Isa::detect() });
        assert!(reference.state().contacts() > 100, "{}", reference.state().contacts());
        // Without vector instructions a run takes long, so that one with several threads is enough.
        for isa in Isa::ALL.into_iter().filter(|isa| isa.available()) {
            let other = sample(properties.clone(), spread, Hardware { threads: 3, isa });
            assert!(other.state() == reference.state(), "{}, 3 threads", isa.name());
        }
        let (mut restored, _) = Simulation::restore(&reference.checkpoint("").unwrap()).unwrap();
        assert_eq!(restored.properties(), reference.properties());
        reference.advance(500).unwrap();
        restored.advance(500).unwrap();
        assert!(restored.state() == reference.state());
        let a = reference.assembly();
        let [_, _, _, rolling] = stored(&a);
        let e = a.energy;
        assert!(rolling > 0.0 && (e.rolling_work - e.rolling - rolling).abs() < 1e-9 * e.rolling_work.abs());
        energy_is_in_balance(reference);
    }
}

/// Checked while a sample is strained slowly.
fn energy_is_in_balance(mut s: Simulation) {
    s.set_time_step_factor(0.05);
    let mut control = CellControl::fixed();
    control.rate[0][0] = 20.0;
    s.set_control(control);
    s.advance(2000).unwrap();
    s.reset_phase(0.0);
    let start = stored(&s.assembly());
    s.advance(8000).unwrap();
    let (end, e) = (stored(&s.assembly()), s.assembly().energy);
    let accounted = end[0] - start[0] + end[1] - start[1] + e.tangential_work + e.rolling_work + e.damping;
    assert!(e.rolling > 0.0 && e.rolling_work > 1e-3 * e.boundary_work, "{e:?}");
    assert!((accounted / e.boundary_work - 1.0).abs() < 0.01, "{accounted:e} {e:?}");
}

/// A law that is switched on later starts without a couple, and the histories of the laws that stay are kept.
#[test]
fn laws_can_be_changed_in_the_middle() {
    let mut contact = soft(0.1, 0.2, 0.3);
    contact.rolling = RollingKind::NONE;
    let free = contact.with(|new| new.parameters = contact.parameters);
    let mut parameters = free.parameters;
    parameters.unset("rolling_friction");
    parameters.unset("rolling_damping");
    let free = free.with(|contact| contact.parameters = parameters);
    let mut s = sample(Properties::new(plain(), free), 0.3, Hardware::default());
    let before = s.assembly();
    s.set_properties(Properties::new(plain(), soft(0.1, 0.2, 0.3))).unwrap();
    let after = s.assembly();
    assert_eq!(before.contacts, after.contacts);
    s.advance(100).unwrap();
    assert!(stored(&s.assembly())[3] > 0.0);
    s.set_properties(Properties::new(plain(), free)).unwrap();
    assert_eq!(stored(&s.assembly())[3], 0.0);
    s.advance(100).unwrap();
}

/// Parameters that no law has, and values out of bounds.
#[test]
fn parameters_are_checked() {
    let refused = |contact: ContactModel| {
        let sphere = InitialSphere { id: 1, position: [0.0; 3], radius: 5e-5 };
        let properties = Properties::new(plain(), contact);
        Simulation::new(Cell::cuboid([1e-3; 3]), &[sphere], properties).err().map(|e| e.to_string()).unwrap()
    };
    let unused = soft(0.1, 0.2, 0.3).with(|contact| contact.rolling = RollingKind::NONE);
    assert!(refused(unused).contains("contact.rolling_damping has no effect with"), "{}", refused(unused));
    let rough = soft(0.1, 3.0, 0.3);
    assert_eq!(refused(rough), "contact.rolling_friction is 3; it must be from 0 to 2");
    let hertz = soft(0.1, 0.1, 0.3).with(|contact| contact.normal = NormalKind::HERTZ);
    assert!(matches!(
        Simulation::new(
            Cell::cuboid([1e-3; 3]),
            &[InitialSphere { id: 1, position: [0.0; 3], radius: 5e-5 }],
            Properties::new(plain(), hertz)
        ),
        Err(SimulationError::Law(_))
    ));
}

/// Hertz's law with an additional parameter for the modulus: an example of a caller's law.
#[derive(Clone, Copy)]
struct OtherModulus;

impl NormalLaw for OtherModulus {
    const DESCRIPTION: LawDescription = LawDescription::new(
        "other-modulus",
        "Hertz with another modulus",
        "elastic spheres whose modulus is a multiple of the material's",
        &[LawParameter::new(
            "modulus_factor",
            Unit::NUMBER,
            1.0,
            [0.1, 10.0],
            "The modulus over that of the material",
        )],
    );
    type Constants<R: Real> = HertzConstants<R>;
    fn prepare(pair: &PairProperties, parameters: &[f64]) -> HertzConstants<f64> {
        let effective_modulus = parameters[0] * pair.effective_modulus;
        Hertz::prepare(&PairProperties { effective_modulus, ..*pair }, &[])
    }
    #[inline(always)]
    fn evaluate<R: Real>(c: &HertzConstants<R>, overlap: R, touched: R::Mask) -> Normal<R> {
        Hertz::evaluate(c, overlap, touched)
    }
    fn loaded(pair: &PairProperties, _parameters: &[f64], load: f64) -> Normal<f64> {
        Hertz::loaded(pair, &[], load)
    }
    fn energy<R: Real>(c: &HertzConstants<R>, overlap: R) -> R {
        Hertz::energy(c, overlap)
    }
}

#[test]
fn a_law_of_the_callers_own_runs_and_is_remembered() {
    let own = NormalKind::new(&OtherModulus);
    let of = |normal| {
        Properties::new(plain(), ContactModel::new(normal, TangentialKind::MINDLIN_DERESIEWICZ, 0.1))
    };
    let hertz = sample(of(NormalKind::HERTZ), 0.3, Hardware::default());
    let same = sample(of(own), 0.3, Hardware::default());
    assert!(hertz.state() == same.state());
    let mut stiffer = of(own);
    stiffer.contact.parameters.set("modulus_factor", 2.0).unwrap();
    assert!(sample(stiffer, 0.3, Hardware::default()).state() != hertz.state());
    // Its name is unknown in files to a program that has not added it.
    let bytes = same.checkpoint("").unwrap();
    let error = Simulation::restore(&bytes).err().unwrap().to_string();
    assert!(error.contains("there is no normal law \"other-modulus\"; there are: hertz, jkr"), "{error}");
    let laws = Laws::standard().with(own).unwrap().with(own).unwrap();
    assert!(Simulation::restore_among(&bytes, &laws).unwrap().0.state() == same.state());
}

#[test]
fn names_stand_for_one_law() {
    #[derive(Clone, Copy)]
    struct Impostor;
    impl NormalLaw for Impostor {
        const DESCRIPTION: LawDescription =
            LawDescription::new("hertz", "Hertz", "another law of that name", &[]);
        type Constants<R: Real> = HertzConstants<R>;
        fn prepare(pair: &PairProperties, parameters: &[f64]) -> HertzConstants<f64> {
            Hertz::prepare(pair, parameters)
        }
        fn evaluate<R: Real>(c: &HertzConstants<R>, overlap: R, touched: R::Mask) -> Normal<R> {
            Hertz::evaluate(c, overlap, touched)
        }
        fn loaded(pair: &PairProperties, parameters: &[f64], load: f64) -> Normal<f64> {
            Hertz::loaded(pair, parameters, load)
        }
        fn energy<R: Real>(c: &HertzConstants<R>, overlap: R) -> R {
            Hertz::energy(c, overlap)
        }
    }
    let impostor = NormalKind::new(&Impostor);
    assert_ne!(impostor, NormalKind::HERTZ);
    let taken = Laws::standard().with(impostor).unwrap_err();
    assert_eq!(taken, RegistrationError::name_taken("normal law", "hertz"));
}
