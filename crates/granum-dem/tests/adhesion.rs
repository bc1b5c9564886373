//! Attraction beyond touch in the engine: liquid bridges.

mod common;

use granum_dem::Isa;
use granum_dem::assembly::Assembly;
use granum_dem::cell::Cell;
use granum_dem::config::{
    AdhesionKind, Component, ContactModel, Material, Mixture, NormalKind, RollingKind, TangentialKind,
};
use granum_dem::contact::adhesion::capillary_bridge::CapillaryBridgeConstants;
use granum_dem::contact::adhesion::capillary_bridge_films::CapillaryBridgeFilmsConstants;
use granum_dem::contact::adhesion::{CapillaryBridge, CapillaryBridgeFilms};
use granum_dem::contact::{
    AdhesionLaw, Attraction, LawDescription, LawEnergies, MAX_ADHESION_HISTORY, PairProperties,
};
use granum_dem::simulation::{Hardware, InitialSphere, Properties, Simulation, SimulationError};
use granum_simd::Real;

const DIAMETER: f64 = 1e-4;

fn plain() -> Material {
    Material::default().with(|material| material.interface_energy = 0.0)
}

fn wet(damping: f64) -> ContactModel {
    let mut contact = ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, damping);
    contact.adhesion = AdhesionKind::CAPILLARY_BRIDGE;
    contact.parameters.set("bridge_volume", 1e-3).unwrap();
    contact
}

/// Kinetic energy, and that of contacts and bridges, J.
fn stored(assembly: &Assembly) -> f64 {
    let square = |v: &[f64; 3]| v.iter().map(|x| x * x).sum::<f64>();
    let kinetic: f64 = assembly
        .bodies
        .iter()
        .map(|g| {
            0.5 * g.mass
                * (square(&g.velocity) + 0.4 * g.equivalent_radius * g.equivalent_radius * square(&g.spin))
        })
        .sum();
    let pairs = assembly.contacts.iter().chain(&assembly.apart);
    kinetic + pairs.map(|c| c.normal_energy + c.attraction_energy).sum::<f64>()
}

/// Two grains that meet at a speed, each at half of it, m/s.
fn meeting(contact: ContactModel, speed: f64) -> Simulation {
    let cell = Cell::cuboid([10.0 * DIAMETER, 3.0 * DIAMETER, 3.0 * DIAMETER]);
    let sphere =
        |id, x| InitialSphere { id, position: [x * DIAMETER, DIAMETER, DIAMETER], radius: 0.5 * DIAMETER };
    let spheres = [sphere(1, 4.0), sphere(2, 5.001)];
    let mut s = Simulation::new(cell, &spheres, Properties::new(plain(), contact)).unwrap();
    s.set_velocities(&[[0.5 * speed, 0.0, 0.0], [-0.5 * speed, 0.0, 0.0]], &[]);
    s.fix_time_step(Some(2e-10));
    s
}

/// The bridge forms at touch, pulls while the grains part, and takes its energy with it when it ruptures:
/// `v'^2 = v^2 - 2 E/m*` with the energy `E` of rupture, which is counted as lost.
#[test]
fn grains_that_part_lose_the_energy_of_their_bridge() {
    let contact = wet(0.0);
    let sphere = (&plain(), 0.5 * DIAMETER);
    let pair = PairProperties::new(sphere, sphere, 0.0);
    let constants = contact.constants(&pair);
    // In 2 pi R^2 gamma, for a volume of 1e-3 R^3 and wetted grains.
    let energy = 0.02244 * 2.0 * std::f64::consts::PI * 25e-10 * 0.072;
    let speed = 2.0 * (2.0 * energy / pair.effective_mass).sqrt();
    let mut s = meeting(contact, speed);
    let (start, rupture) = (stored(&s.assembly()), contact.range(&constants));
    let (mut touched, mut bridged) = (false, false);
    for _ in 0..20_000 {
        s.advance(50).unwrap();
        let assembly = s.assembly();
        touched |= !assembly.contacts.is_empty();
        if let [pair] = assembly.apart.as_slice() {
            assert!(touched && -pair.approach < rupture && pair.normal_force < 0.0);
            assert_eq!(pair.tangential_force, [0.0; 3]);
            bridged = true;
        }
        let (now, lost) = (stored(&assembly), assembly.energy.attraction_loss);
        assert!(((now + lost) / start - 1.0).abs() < 2e-3, "{now:e} + {lost:e}, {start:e}");
        if lost > 0.0 {
            break;
        }
    }
    assert!(touched && bridged);
    let end = s.assembly();
    assert!((end.energy.attraction_loss / energy - 1.0).abs() < 1e-3, "{:e}", end.energy.attraction_loss);
    assert!(end.apart.is_empty() && end.contacts.is_empty());
    let out = end.bodies[1].velocity[0] - end.bodies[0].velocity[0];
    assert!((out / speed - 0.75f64.sqrt()).abs() < 2e-3, "{}", out / speed);
    // Grains that only come near have no bridge.
    let mut near = meeting(contact, 0.0);
    near.advance(100).unwrap();
    assert!(near.assembly().apart.is_empty());
}

#[test]
fn slow_grains_stay_together() {
    let mut s = meeting(wet(0.1), 0.02);
    s.fix_time_step(Some(1e-9));
    s.advance(100_000).unwrap();
    let assembly = s.assembly();
    assert_eq!(assembly.contacts.len() + assembly.apart.len(), 1);
}

fn compressed(properties: Properties, spread: f64, hardware: Hardware) -> Simulation {
    let mut s = common::compressed(200, spread, properties, 4000, hardware);
    // The sample is then extended, so that contacts open and their bridges are stretched.
    s.set_control(common::growing(300.0));
    s.advance(3000).unwrap();
    s
}

/// With grains of two wettabilities, resistance to rolling and twisting, and bridges between separated grains.
fn everything() -> Properties {
    let mut contact = wet(0.1);
    contact.rolling = RollingKind::ELASTIC_PLASTIC_TWISTING;
    let mut repellent = Component::new("repellent", 0.5, plain());
    repellent.parameters.set("contact_angle", 1.2).unwrap();
    let mixture = Mixture::new([repellent, Component::new("wetted", 0.5, plain())]);
    Properties::new(plain(), contact).with_mixture(mixture)
}

#[test]
fn the_same_bits_on_threads_instruction_sets_and_through_a_checkpoint() {
    for (properties, spread) in [
        (Properties::new(plain(), wet(0.1)), 0.0),
        (Properties::new(plain(), wet(0.1)), 0.3),
        (everything(), 0.0),
    ] {
        let run = |hardware| compressed(properties.clone(), spread, hardware);
        let mut reference = run(Hardware { threads: 1, isa: Isa::detect() });
        let assembly = reference.assembly();
        assert!(assembly.apart.len() > 20, "{} {}", assembly.apart.len(), assembly.contacts.len());
        assert!(assembly.energy.attraction_loss > 0.0);
        // Without vector instructions a run takes long, so that one with several threads is enough.
        for isa in Isa::ALL.into_iter().filter(|isa| isa.available()) {
            let other = run(Hardware { threads: 3, isa });
            assert!(other.state() == reference.state(), "{}, 3 threads", isa.name());
        }
        let (mut restored, _) = Simulation::restore(&reference.checkpoint("").unwrap()).unwrap();
        reference.advance(700).unwrap();
        restored.advance(700).unwrap();
        assert!(restored.state() == reference.state());
    }
}

/// A wet sample in extension: the work of the boundary is either stored or lost.
#[test]
fn the_energy_is_in_balance() {
    let mut s = compressed(Properties::new(plain(), wet(0.1)), 0.0, Hardware::default());
    s.set_time_step_factor(0.05);
    s.reset_phase(0.0);
    let start = stored(&s.assembly());
    s.advance(20_000).unwrap();
    let (end, e) = (stored(&s.assembly()), s.assembly().energy);
    let lost = e.tangential_work + e.damping + e.attraction_loss;
    let size = e.boundary_work.abs() + (end - start).abs() + lost.abs();
    let gap = (e.boundary_work - lost - (end - start)) / size;
    assert!(e.attraction_loss > 0.01 * size, "{e:?}");
    assert!(gap.abs() < 0.01, "{gap}: {e:?}, stored {start:e} to {end:e}");
}

/// The same law without the statement that bridges begin at touch: the engine evaluates every pair within its range.
#[derive(Clone, Copy)]
struct Everywhere;

impl AdhesionLaw for Everywhere {
    const DESCRIPTION: LawDescription = LawDescription::new(
        "bridge-everywhere",
        "bridges",
        "bridges of which every pair in range is evaluated",
        CapillaryBridge::DESCRIPTION.parameters,
    );
    type Constants<R: Real> = CapillaryBridgeConstants<R>;
    const HISTORY: usize = CapillaryBridge::HISTORY;
    fn prepare(pair: &PairProperties, parameters: &[f64]) -> CapillaryBridgeConstants<f64> {
        CapillaryBridge::prepare(pair, parameters)
    }
    #[inline(always)]
    fn update<R: Real>(
        constants: &CapillaryBridgeConstants<R>,
        overlap: R,
        touching: R::Mask,
        history: &mut [R; MAX_ADHESION_HISTORY],
        energies: &mut LawEnergies<R>,
    ) -> Attraction<R> {
        CapillaryBridge::update(constants, overlap, touching, history, energies)
    }
    fn energy(
        constants: &CapillaryBridgeConstants<f64>,
        overlap: f64,
        history: &[f64; MAX_ADHESION_HISTORY],
    ) -> f64 {
        CapillaryBridge::energy(constants, overlap, history)
    }
    fn range(constants: &CapillaryBridgeConstants<f64>) -> f64 {
        CapillaryBridge::range(constants)
    }
}

/// Pairs within the range of a law that begins at touch are neither listed nor evaluated while it does not act on them. The
/// sample is the same as if they were, but for the order of sums.
#[test]
fn pairs_without_a_bridge_are_left_out() {
    for spread in [0.0, 0.3] {
        let run = |adhesion| {
            let mut contact = wet(0.1);
            contact.adhesion = adhesion;
            let mut s = common::dispersed(200, spread, Properties::new(plain(), contact));
            s.fix_time_step(Some(3e-9));
            for rate in [3e4, -3e4] {
                s.set_control(common::growing(-rate));
                s.advance(1500).unwrap();
            }
            s
        };
        let (few, all) = (run(AdhesionKind::CAPILLARY_BRIDGE), run(AdhesionKind::new(&Everywhere)));
        assert!(few.near_pairs() < all.near_pairs(), "{} {}", few.near_pairs(), all.near_pairs());
        let (few, all) = (few.assembly(), all.assembly());
        assert!(
            few.apart.len() > 20 && !few.contacts.is_empty(),
            "{} {}",
            few.apart.len(),
            few.contacts.len()
        );
        for (few, all) in [(&few.contacts, &all.contacts), (&few.apart, &all.apart)] {
            assert_eq!(few.len(), all.len());
            for (a, b) in few.iter().zip(all) {
                assert_eq!((a.i, a.j), (b.i, b.j));
                assert!((a.approach - b.approach).abs() < 1e-9 * DIAMETER, "{a:?} {b:?}");
            }
        }
    }
}

/// A law defined outside the crate, with the bridges of granum's law that shares films.
#[derive(Clone, Copy)]
struct OwnFilms;

impl AdhesionLaw for OwnFilms {
    const DESCRIPTION: LawDescription = LawDescription::new(
        "own-films",
        "bridges of the caller",
        "bridges that share films, of the caller",
        CapillaryBridgeFilms::DESCRIPTION.parameters,
    );
    const BEGINS_AT_TOUCH: bool = true;
    const SHARES_LIQUID: bool = true;
    type Constants<R: Real> = CapillaryBridgeFilmsConstants<R>;
    const HISTORY: usize = CapillaryBridgeFilms::HISTORY;
    fn prepare(pair: &PairProperties, parameters: &[f64]) -> CapillaryBridgeFilmsConstants<f64> {
        CapillaryBridgeFilms::prepare(pair, parameters)
    }
    #[inline(always)]
    fn update<R: Real>(
        constants: &CapillaryBridgeFilmsConstants<R>,
        overlap: R,
        touching: R::Mask,
        history: &mut [R; MAX_ADHESION_HISTORY],
        energies: &mut LawEnergies<R>,
    ) -> Attraction<R> {
        CapillaryBridgeFilms::update(constants, overlap, touching, history, energies)
    }
    fn film(radius: f64, parameters: &[f64]) -> f64 {
        CapillaryBridgeFilms::film(radius, parameters)
    }
    fn largest_bridge(constants: &CapillaryBridgeFilmsConstants<f64>) -> f64 {
        CapillaryBridgeFilms::largest_bridge(constants)
    }
    fn bridge(constants: &CapillaryBridgeFilmsConstants<f64>, volume: f64) -> [f64; MAX_ADHESION_HISTORY] {
        CapillaryBridgeFilms::bridge(constants, volume)
    }
    fn energy(
        constants: &CapillaryBridgeFilmsConstants<f64>,
        overlap: f64,
        history: &[f64; MAX_ADHESION_HISTORY],
    ) -> f64 {
        CapillaryBridgeFilms::energy(constants, overlap, history)
    }
    fn range(constants: &CapillaryBridgeFilmsConstants<f64>) -> f64 {
        CapillaryBridgeFilms::range(constants)
    }
}

#[test]
fn a_law_of_the_caller_can_share_liquid() {
    let run = |adhesion| {
        let mut contact = ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.1);
        contact.adhesion = adhesion;
        compressed(Properties::new(plain(), contact), 0.3, Hardware::default())
    };
    let [own, known] = [AdhesionKind::new(&OwnFilms), AdhesionKind::CAPILLARY_BRIDGE_FILMS].map(run);
    assert!(own.state() == known.state());
    let liquid = own.assembly().liquid.unwrap();
    assert!(liquid.count > 100 && liquid.bridges > 0.0, "{liquid:?}");
}

/// The stress of the engine is that of all pairs that act.
#[test]
fn pairs_apart_have_their_part_in_the_stress() {
    let s = compressed(everything(), 0.0, Hardware::default());
    let assembly = s.assembly();
    let mut stress = [[0.0; 3]; 3];
    for pair in assembly.contacts.iter().chain(&assembly.apart) {
        let force = pair.force();
        for (r, row) in stress.iter_mut().enumerate() {
            for (c, value) in row.iter_mut().enumerate() {
                *value -= force[r] * pair.branch[c] / assembly.volume();
            }
        }
    }
    let (found, scale) = (s.state().stress(), stress[0][0].abs());
    // The stress by which states are spaced is the same.
    let measured = granum_dem::loading::MacroState::from_assembly(&assembly).stress;
    for r in 0..3 {
        for c in 0..3 {
            assert!((measured[r][c] - stress[r][c]).abs() < 1e-9 * scale, "{measured:?} {stress:?}");
            assert!((found[r][c] - stress[r][c]).abs() < 1e-9 * scale, "{found:?} {stress:?}");
        }
    }
}

#[test]
fn laws_that_do_not_go_together_are_refused() {
    let mut contact = wet(0.1);
    contact.normal = NormalKind::JKR;
    let sphere = InitialSphere { id: 1, position: [0.0; 3], radius: 5e-5 };
    let refused = |contact| {
        let properties = Properties::new(plain(), contact);
        Simulation::new(Cell::cuboid([1e-3; 3]), &[sphere], properties).err().unwrap()
    };
    let said = refused(contact);
    assert!(matches!(said, SimulationError::Law(_)));
    let wanted = "contact.adhesion = \"capillary-bridge\" adds to a normal law without adhesion";
    assert!(said.to_string().starts_with(wanted), "{said}");
    let mut unused = wet(0.1);
    unused.adhesion = AdhesionKind::NONE;
    assert!(refused(unused).to_string().starts_with("contact.bridge_volume has no effect with"));
}
