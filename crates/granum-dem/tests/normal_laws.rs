//! DMT, JKR–DMT, rough, elastic-plastic contacts and van der Waals attraction in the engine: the same bits everywhere, with grains
//! of two materials, and the energy in balance.

mod common;

use granum_dem::Isa;
use granum_dem::assembly::Assembly;
use granum_dem::config::{
    AdhesionKind, Component, ContactModel, Material, Mixture, NormalKind, RollingKind, TangentialKind,
};
use granum_dem::servo::CellControl;
use granum_dem::simulation::{Hardware, Properties, Simulation};

const DIAMETER: f64 = 1e-4;

fn glass(interface_energy: f64) -> Material {
    Material::default().with(|material| material.interface_energy = interface_energy)
}

/// A set of laws, and the properties in which the second material differs.
struct Case {
    contact: ContactModel,
    interface_energy: f64,
    other: &'static [(&'static str, f64)],
}

fn case(
    normal: NormalKind,
    tangential: TangentialKind,
    given: &[(&'static str, f64)],
    other: &'static [(&'static str, f64)],
) -> Case {
    let mut contact = ContactModel::new(normal, tangential, 0.1);
    for (key, value) in given {
        contact.parameters.set(key, *value).unwrap();
    }
    let adhesive = normal == NormalKind::DMT || normal == NormalKind::JKR_DMT;
    Case { contact, interface_energy: if adhesive { 0.1 } else { 0.0 }, other }
}

fn cases() -> Vec<Case> {
    let [no_slip, curves] = [TangentialKind::NO_SLIP, TangentialKind::MINDLIN_DERESIEWICZ];
    let plastic = [("normal_stiffness", 2e4), ("plasticity_depth", 1e-3), ("cohesion_ratio", 0.5)];
    let mut all = vec![
        case(NormalKind::DMT, no_slip, &[], &[]),
        case(NormalKind::JKR_DMT, curves, &[], &[("equilibrium_separation", 2e-9)]),
        case(NormalKind::ROUGH_HERTZ, curves, &[("roughness", 5e-8)], &[("roughness", 3e-7)]),
        case(NormalKind::LUDING, no_slip, &plastic, &[("unloading_ratio", 2.0)]),
        case(NormalKind::HERTZ, no_slip, &[("hamaker_constant", 1e-18)], &[("hamaker_constant", 1e-19)]),
    ];
    all[3].contact.rolling = RollingKind::ELASTIC_PLASTIC_TWISTING;
    all[4].contact.adhesion = AdhesionKind::VAN_DER_WAALS;
    // Grains of 0.1 mm: so that the attraction matters at their stiffness, and the time step stays long.
    all[4].contact.parameters.set("least_separation", 2e-9).unwrap();
    all[4].contact.parameters.set("attraction_cutoff", 1e-7).unwrap();
    all
}

impl Case {
    fn one(&self) -> Properties {
        Properties::new(glass(self.interface_energy), self.contact)
    }

    fn two(&self) -> Properties {
        let soft = glass(2.0 * self.interface_energy).with(|material| {
            material.youngs_modulus = 2e10;
            material.friction = 0.5;
        });
        let mut other = Component::new("other", 0.4, soft);
        for (key, value) in self.other {
            other.parameters.set(key, *value).unwrap();
        }
        let first = Component::new("first", 0.6, glass(self.interface_energy));
        self.one().with_mixture(Mixture::new([first, other]))
    }
}

/// Compressed for a number of steps, then extended a little, so that contacts form and break.
fn sample(properties: Properties, spread: f64, steps: u64, hardware: Hardware) -> Simulation {
    let mut s = common::compressed(150, spread, properties, steps, hardware);
    s.set_control(common::growing(2.0));
    s.advance(200).unwrap();
    s
}

/// Kinetic energy, and that of contacts and attractions, J.
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

#[test]
fn the_same_bits_on_threads_instruction_sets_and_through_a_checkpoint() {
    for case in cases() {
        for (properties, spread) in [(case.one(), 0.0), (case.two(), 0.3)] {
            let name = case.contact.normal.name();
            let mut reference =
                sample(properties.clone(), spread, 6500, Hardware { threads: 1, isa: Isa::detect() });
            let assembly = reference.assembly();
            let acting = assembly.contacts.len() + assembly.apart.len();
            assert!(acting >= 40, "{name}: {acting} pairs act on each other");
            let broken = assembly.contacts.iter().filter(|c| c.normal_force < 0.0).count();
            println!(
                "{name}: {} contacts, {broken} in tension, {} apart",
                assembly.contacts.len(),
                assembly.apart.len()
            );
            // Without vector instructions a run takes long, so that one with several threads is enough.
            for isa in Isa::ALL.into_iter().filter(|isa| isa.available()) {
                let other = sample(properties.clone(), spread, 6500, Hardware { threads: 3, isa });
                assert!(other.state() == reference.state(), "{name}: {}, 3 threads", isa.name());
            }
            let (mut restored, _) = Simulation::restore(&reference.checkpoint("").unwrap()).unwrap();
            assert_eq!(restored.properties(), reference.properties());
            reference.advance(500).unwrap();
            restored.advance(500).unwrap();
            assert!(restored.state() == reference.state(), "{name}");
        }
    }
}

/// A sample that is compressed, then strained slowly in both directions: the work of the boundary is either stored or lost.
#[test]
fn the_energy_is_in_balance() {
    for case in cases() {
        let name = case.contact.normal.name();
        let mut s = sample(case.one(), 0.3, 4500, Hardware::default());
        s.set_control(CellControl::isotropic(20e3, 2e4));
        s.advance(3000).unwrap();
        s.set_time_step_factor(0.05);
        let mut control = CellControl::fixed();
        control.rate[0][0] = 20.0;
        s.set_control(control);
        s.advance(1000).unwrap();
        s.reset_phase(0.0);
        let start = stored(&s.assembly());
        s.advance(8000).unwrap();
        control.rate[0][0] = -20.0;
        s.set_control(control);
        s.advance(8000).unwrap();
        let (end, e) = (stored(&s.assembly()), s.assembly().energy);
        let lost = e.tangential_work
            + e.rolling_work
            + e.damping
            + e.adhesion_made
            + e.adhesion_broken
            + e.attraction_loss
            + e.channel("plastic_loss");
        let size = e.boundary_work.abs() + lost.abs() + (end - start).abs();
        let gap = (e.boundary_work - lost - (end - start)) / size;
        println!("{name}: gap {gap:.1e}, plastic {:.2}", e.channel("plastic_loss") / size);
        assert!(gap.abs() < 0.01, "{name}: {gap}: {e:?}, stored {start:e} to {end:e}");
        let plastic = case.contact.normal == NormalKind::LUDING;
        let plastic_loss = e.channel("plastic_loss");
        assert!(if plastic { plastic_loss > 0.05 * size } else { plastic_loss == 0.0 }, "{name}: {e:?}");
    }
}

/// Grains of 0.1 mm that are separated up to the end of the attraction: separated pairs have its force and its energy.
#[test]
fn van_der_waals_holds_pairs_apart_in_the_list() {
    let s = sample(cases().pop().unwrap().one(), 0.0, 4500, Hardware::default());
    let assembly = s.assembly();
    assert!(!assembly.apart.is_empty());
    for pair in &assembly.apart {
        let gap = -pair.approach;
        assert!(0.0 < gap && gap < 1e-7 && pair.normal_force < 0.0 && pair.attraction_energy < 0.0);
        let at = gap.max(2e-9);
        let strength = 1e-18 * 0.25 * DIAMETER / 6.0;
        let force = strength * (1.0 / (at * at) - 1e14);
        assert!(
            (pair.normal_force / -force - 1.0).abs() < 1e-6,
            "{gap:e}: {:e} {force:e}",
            pair.normal_force
        );
    }
}
