//! Several materials in the engine.

mod common;

use granum_dem::Isa;
use granum_dem::assembly::Assembly;
use granum_dem::config::{
    Component, ContactModel, Material, Mixture, NormalKind, PairRule, RollingKind, TangentialKind,
};
use granum_dem::simulation::{Hardware, Properties, Simulation, SimulationError};

fn plain() -> Material {
    Material::default().with(|material| material.interface_energy = 0.0)
}

fn soft() -> Material {
    plain().with(|material| {
        material.youngs_modulus = 7e9;
        material.poissons_ratio = 0.4;
        material.density = 1200.0;
        material.friction = 0.6;
    })
}

fn hertz() -> ContactModel {
    ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.1)
}

/// A third of soft grains, with a rule of their own for pairs of unlike ones.
fn two(contact: ContactModel) -> Properties {
    let rule =
        PairRule { between: ["soft".into(), "hard".into()], friction: Some(0.1), ..PairRule::default() };
    let mixture =
        Mixture::new([Component::new("soft", 1.0 / 3.0, soft()), Component::new("hard", 2.0 / 3.0, plain())]);
    Properties::new(plain(), contact).with_mixture(mixture.with_pair(rule).with_seed(4))
}

fn compressed(properties: Properties, spread: f64, hardware: Hardware) -> Simulation {
    common::compressed(200, spread, properties, 5000, hardware)
}

#[test]
fn the_same_bits_on_threads_instruction_sets_and_through_a_checkpoint() {
    let mut contact = hertz();
    contact.rolling = RollingKind::ELASTIC_PLASTIC_TWISTING;
    for (contact, spread) in [(hertz(), 0.0), (hertz(), 0.3), (contact, 0.0)] {
        let properties = || two(contact);
        let mut reference = compressed(properties(), spread, Hardware { threads: 1, isa: Isa::detect() });
        assert!(reference.state().contacts() > 100, "{}", reference.state().contacts());
        // Without vector instructions a run takes long, so that one with several threads is enough.
        for isa in Isa::ALL.into_iter().filter(|isa| isa.available()) {
            let other = compressed(properties(), spread, Hardware { threads: 3, isa });
            assert!(other.state() == reference.state(), "{}, 3 threads", isa.name());
        }
        let (mut restored, _) = Simulation::restore(&reference.checkpoint("").unwrap()).unwrap();
        assert_eq!(restored.properties(), reference.properties());
        reference.advance(700).unwrap();
        restored.advance(700).unwrap();
        assert!(restored.state() == reference.state());
    }
}

/// Grains of two materials that are alike move as grains of one, to the bit, and so do those of two names for one.
#[test]
fn like_materials_are_one() {
    for spread in [0.0, 0.3] {
        let one = compressed(Properties::new(plain(), hertz()), spread, Hardware::default());
        let names = [Component::new("a", 0.3, plain()), Component::new("b", 0.7, plain())];
        let mixture = Properties::new(soft(), hertz()).with_mixture(Mixture::new(names));
        let two = compressed(mixture, spread, Hardware::default());
        let stripped = |mut assembly: Assembly| {
            assembly.materials.clear();
            assembly.bodies.iter_mut().for_each(|grain| grain.material = 0);
            assembly
        };
        assert_eq!(two.assembly().materials, ["a", "b"]);
        assert_eq!(two.assembly().bodies.iter().filter(|grain| grain.material == 0).count(), 60);
        assert!(stripped(two.assembly()) == stripped(one.assembly()), "spread {spread}");
    }
}

#[test]
fn the_order_of_materials_does_not_matter() {
    let forwards = two(hertz());
    let mut backwards = forwards.mixture.clone();
    backwards.components.reverse();
    backwards.pairs[0].between.reverse();
    let backwards = Properties::new(plain(), hertz()).with_mixture(backwards);
    let run = |properties| compressed(properties, 0.0, Hardware::default());
    assert!(run(forwards).state() == run(backwards).state());
}

/// Each contact has the force of its own two materials, and grains have the masses of theirs.
#[test]
fn contacts_follow_their_pair_of_materials() {
    let s = compressed(two(hertz()), 0.0, Hardware::default());
    let assembly = s.assembly();
    let names = &assembly.materials;
    assert_eq!(names, &["hard", "soft"]);
    let mut seen = [0; 3];
    for contact in &assembly.contacts {
        let [i, j] = [contact.i, contact.j].map(|grain| &assembly.bodies[grain]);
        let of = [i, j].map(|grain| names[grain.material as usize].as_str());
        let pair = s.properties().pair(of, [i.equivalent_radius, j.equivalent_radius]).unwrap();
        let radius = (pair.effective_radius * contact.approach).sqrt();
        let force = 4.0 / 3.0 * pair.effective_modulus * radius * contact.approach;
        assert!((contact.normal_force / force - 1.0).abs() < 1e-9, "{of:?}");
        let t = contact.tangential_force.iter().map(|x| x * x).sum::<f64>().sqrt();
        assert!(t <= pair.friction * contact.normal_force * (1.0 + 1e-9), "{of:?}");
        seen[(i.material + j.material) as usize] += 1;
    }
    assert!(seen.iter().all(|count| *count > 10), "{seen:?}");
    for grain in &assembly.bodies {
        let density = grain.mass / (4.0 / 3.0 * std::f64::consts::PI * grain.equivalent_radius.powi(3));
        let wanted = [2650.0, 1200.0][grain.material as usize];
        assert!((density / wanted - 1.0).abs() < 1e-12);
    }
    let soft = assembly.bodies.iter().filter(|grain| grain.material == 1).count();
    assert_eq!(soft, 67);
}

/// `rate = I sqrt(p / rho) / d` with the density of all grains together.
#[test]
fn densities_are_averaged_and_scaled() {
    let mut s = compressed(two(hertz()), 0.0, Hardware::default());
    let density = (67.0 * 1200.0 + 133.0 * 2650.0) / 200.0;
    let wanted = 1e-3 * (20e3f64 / density).sqrt() / 1e-4;
    assert!((s.strain_rate(1e-3, 20e3) / wanted - 1.0).abs() < 1e-9);
    let dt = s.state().time_step();
    s.set_properties(two(hertz()).with_densities(4.0)).unwrap();
    assert!((s.state().time_step() / dt - 2.0).abs() < 1e-12);
    assert!((s.strain_rate(1e-3, 20e3) / wanted - 0.5).abs() < 1e-9);
    let mut other = two(hertz());
    other.mixture.components[0].material.density = 9000.0;
    assert!(matches!(s.set_properties(other), Err(SimulationError::Assignment { .. })));
    let lost = s.set_properties(Properties::new(plain(), hertz())).unwrap_err().to_string();
    assert!(lost.contains("grains and 0 materials"), "{lost}");
}
