use granum_simd::Isa;

use crate::assembly::Assembly;
use crate::cell::Cell;
use crate::config::{
    AdhesionKind, Component, ContactModel, Grains, Material, Mixture, NormalKind, RollingKind, TangentialKind,
};
use crate::random_insertion::random_insertion;
use crate::servo::CellControl;
use crate::simulation::{Hardware, InitialSphere, Properties, Simulation};

const DIAMETER: f64 = 1e-4;

fn plain() -> Material {
    Material { interface_energy: 0.0, ..Material::default() }
}

/// Bridges with so much liquid on the grains.
fn wet(content: f64, largest: f64) -> ContactModel {
    let mut contact = ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.1);
    contact.adhesion = AdhesionKind::CAPILLARY_BRIDGE_FILMS;
    contact.parameters.set("liquid_content", content).unwrap();
    contact.parameters.set("largest_bridge_volume", largest).unwrap();
    contact
}

fn properties(content: f64, largest: f64) -> Properties {
    Properties::new(plain(), wet(content, largest))
}

fn volume(radius: f64) -> f64 {
    4.0 / 3.0 * std::f64::consts::PI * radius.powi(3)
}

/// Films in the order of the ids.
fn films(s: &Simulation) -> Vec<f64> {
    let state = s.state();
    let mut order: Vec<usize> = (0..state.grains()).collect();
    order.sort_unstable_by_key(|&grain| state.ids[grain]);
    order.into_iter().map(|grain| state.films[grain]).collect()
}

fn total(assembly: &Assembly) -> f64 {
    let liquid = assembly.liquid.unwrap();
    liquid.films + liquid.bridges
}

/// A sample that is compressed and then sheared to and fro while it expands and contracts, so that bridges form and rupture.
fn sheared(properties: &Properties, spread: f64, hardware: Hardware, half_cycles: usize) -> Simulation {
    let grains = Grains { count: 150, spread, ..Grains::default() };
    let (cell, spheres) = random_insertion(&grains, 0.35, 9).unwrap();
    let mut s = Simulation::new(cell, &spheres, properties.clone()).unwrap();
    s.set_hardware(hardware);
    s.fix_time_step(Some(3e-9));
    let phases = std::iter::once([3e4, 3e4, 3e4]);
    let cycle = [[-2e4, -2e4, 2e4], [2e4, 2e4, -2e4]].into_iter().cycle();
    for rates in phases.chain(cycle).take(half_cycles) {
        let mut control = CellControl::fixed();
        control.rate = std::array::from_fn(|r| std::array::from_fn(|c| if r == c { rates[r] } else { 0.0 }));
        s.set_control(control);
        s.advance(2000).unwrap();
    }
    s
}

/// Liquid is moved and not made, through hundreds of ruptures, new lists and sorted grains, with grains that run dry.
#[test]
fn liquid_is_conserved() {
    for (spread, content) in [(0.0, 0.01), (0.3, 2e-4)] {
        let s = sheared(&properties(content, 0.01), spread, Hardware::default(), 8);
        let assembly = s.assembly();
        let wanted: f64 =
            content * assembly.bodies.iter().map(|grain| volume(grain.equivalent_radius)).sum::<f64>();
        let liquid = assembly.liquid.unwrap();
        assert!((total(&assembly) / wanted - 1.0).abs() < 1e-12, "{:e}", total(&assembly) / wanted - 1.0);
        assert!(liquid.count > 100 && liquid.bridges > 0.0, "{liquid:?}");
        let ruptures = assembly.energy.attraction_loss;
        assert!(ruptures > 0.0 && s.rebuilds() > 10, "{ruptures:e} {}", s.rebuilds());
        // Films differ: liquid has wandered, and with little of it there are dry contacts.
        let first = content * volume(0.5 * DIAMETER);
        let films = films(&s);
        assert!(films.iter().any(|film| *film < 0.5 * first) && films.iter().all(|film| *film >= 0.0));
        let bridged = assembly.contacts.iter().filter(|c| c.attraction_energy != 0.0).count();
        assert_eq!(bridged < assembly.contacts.len(), content < 1e-3, "{bridged}");
        assert_eq!(liquid.count, bridged + assembly.apart.len());
    }
}

#[test]
fn the_same_bits_on_threads_instruction_sets_and_through_a_checkpoint() {
    let mut repellent = Component::new("repellent", 0.5, plain());
    repellent.parameters.set("contact_angle", 1.2).unwrap();
    let mixture = Mixture::new([repellent, Component::new("wetted", 0.5, plain())]);
    let mut contact = wet(1e-3, 0.01);
    contact.rolling = RollingKind::ELASTIC_PLASTIC_TWISTING;
    for (properties, spread) in
        [(properties(1e-3, 0.01), 0.3), (Properties::new(plain(), contact).with_mixture(mixture), 0.0)]
    {
        let run = |hardware| sheared(&properties, spread, hardware, 3);
        let mut reference = run(Hardware { threads: 1, isa: Isa::detect() });
        assert!(reference.assembly().energy.attraction_loss > 0.0);
        // Without vector instructions a run takes long, so that one with several threads is enough.
        for isa in Isa::ALL.into_iter().filter(|isa| isa.available()) {
            let other = run(Hardware { threads: 3, isa });
            assert!(other.state() == reference.state(), "{}, 3 threads", isa.name());
        }
        let bytes = reference.checkpoint("").unwrap();
        let (mut restored, _) = Simulation::restore(&bytes).unwrap();
        assert!(restored.state() == reference.state());
        reference.advance(700).unwrap();
        // In pieces, with an observation after each, which changes nothing.
        for _ in 0..7 {
            restored.advance(100).unwrap();
            let _ = restored.assembly();
        }
        assert!(restored.state() == reference.state());
    }
}

/// Two grains that meet and part, each at half of a speed, m/s.
fn meeting(properties: Properties, radii: [f64; 2], speed: f64) -> Simulation {
    let cell = Cell::cuboid([20.0 * DIAMETER, 5.0 * DIAMETER, 5.0 * DIAMETER]);
    let far = radii[0] + radii[1] + 1e-3 * DIAMETER;
    let sphere = |id, x, radius| InitialSphere { id, position: [x, DIAMETER, DIAMETER], radius };
    let spheres = [sphere(1, 8.0 * DIAMETER, radii[0]), sphere(2, 8.0 * DIAMETER + far, radii[1])];
    let mut s = Simulation::new(cell, &spheres, properties).unwrap();
    s.set_velocities(&[[0.5 * speed, 0.0, 0.0], [-0.5 * speed, 0.0, 0.0]], &[]);
    s.fix_time_step(Some(5e-10));
    s
}

/// A bridge takes the same from both, as much as the drier has, and returns one half to each.
#[test]
fn a_bridge_takes_equally_and_returns_halves() {
    let radii = [0.5 * DIAMETER, 0.3 * DIAMETER];
    let content = 1e-3;
    let own = radii.map(|radius| content * volume(radius));
    let effective = 2.0 * radii[0] * radii[1] / (radii[0] + radii[1]);
    for largest in [0.1, 1e-4] {
        let taken = own[1].min(0.5 * largest * effective.powi(3));
        let mut s = meeting(properties(content, largest), radii, 1.0);
        assert!(films(&s).iter().zip(own).all(|(film, own)| (film / own - 1.0).abs() < 1e-15));
        let (mut bridged, mut forces) = (0, 0);
        for _ in 0..4000 {
            s.advance(20).unwrap();
            let liquid = s.assembly().liquid.unwrap();
            if liquid.count == 1 {
                bridged += 1;
                let left = films(&s);
                for (left, own) in left.iter().zip(own) {
                    assert!(
                        (left + taken - own).abs() < 1e-15 * own,
                        "{largest}: {left:e} {taken:e} {own:e}"
                    );
                }
                assert!((liquid.bridges / (2.0 * taken) - 1.0).abs() < 1e-15);
                forces += usize::from(s.assembly().apart.iter().any(|pair| pair.normal_force < 0.0));
            } else if bridged > 0 {
                break;
            }
        }
        assert!(bridged > 3 && forces > 0, "{bridged} {forces}");
        assert!(s.assembly().contacts.is_empty() && s.assembly().energy.attraction_loss > 0.0);
        for (film, own) in films(&s).iter().zip(own) {
            assert!((film / own - 1.0).abs() < 1e-15, "{film:e} {own:e}");
        }
    }
}

/// A dry grain makes no bridge with a wet one, and no film belongs to another grain after the grains were sorted.
#[test]
fn dry_grains_stay_dry() {
    let mut dry = Component::new("dry", 0.5, plain());
    dry.parameters.set("liquid_content", 0.0).unwrap();
    let mixture = Mixture::new([dry, Component::new("wet", 0.5, plain())]);
    let properties = properties(0.01, 0.01).with_mixture(mixture);
    let s = sheared(&properties, 0.2, Hardware::default(), 12);
    assert!(s.rebuilds() > 64, "the grains were not sorted again: {} lists", s.rebuilds());
    let assembly = s.assembly();
    let films = films(&s);
    let is_dry = |grain: usize| assembly.materials[assembly.bodies[grain].material as usize] == "dry";
    assert!((0..films.len()).all(|grain| (films[grain] == 0.0) == is_dry(grain)), "{films:?}");
    let pairs = || assembly.contacts.iter().chain(&assembly.apart);
    let bridged = |c: &&crate::assembly::Contact| c.attraction_energy != 0.0;
    assert!(pairs().filter(bridged).all(|c| !is_dry(c.i) && !is_dry(c.j)));
    assert!(pairs().filter(bridged).count() > 10);
    assert!(assembly.contacts.iter().any(|c| is_dry(c.i) && !is_dry(c.j)));
}

/// Other properties keep the liquid: a law without bridges lets the films have it, and smaller bridges return the rest.
#[test]
fn other_properties_keep_the_liquid() {
    let mut s = sheared(&properties(0.01, 0.01), 0.3, Hardware::default(), 2);
    let before = s.assembly();
    let all = total(&before);
    s.set_properties(properties(0.01, 0.01)).unwrap();
    let (held, same) = (before.liquid.unwrap(), s.assembly().liquid.unwrap());
    assert!(same.count == held.count && (same.bridges / held.bridges - 1.0).abs() < 1e-14);
    // The new list reaches hardly farther than the smaller bridges.
    s.integrator.state.skin = 1e-3 * DIAMETER;
    s.set_properties(properties(0.01, 1e-4)).unwrap();
    let smaller = s.assembly();
    assert!((total(&smaller) / all - 1.0).abs() < 1e-14);
    assert!(smaller.liquid.unwrap().bridges < 0.02 * before.liquid.unwrap().bridges);
    s.advance(200).unwrap();
    let mut plainly = wet(0.01, 1e-4);
    (plainly.adhesion, plainly.parameters) = (AdhesionKind::NONE, ContactModel::default().parameters);
    s.set_properties(Properties::new(plain(), plainly)).unwrap();
    let dry = s.assembly().liquid.unwrap();
    assert!((dry.films / all - 1.0).abs() < 1e-14 && dry.count == 0 && dry.bridges == 0.0);
    s.fix_time_step(Some(1e-12));
    s.advance(2).unwrap();
    let lost = s.assembly().energy.attraction_loss;
    s.set_properties(properties(0.01, 0.01)).unwrap();
    s.advance(2).unwrap();
    let again = s.assembly();
    let (liquid, contacts) = (again.liquid.unwrap(), again.contacts.len());
    assert!((total(&again) / all - 1.0).abs() < 1e-14, "{:e}", total(&again) / all - 1.0);
    assert!(liquid.count == contacts && contacts > 10, "{liquid:?}, {contacts} contacts");
    // What bridges at loaded contacts release when they form is counted as lost.
    let energy: f64 = again.contacts.iter().map(|c| c.attraction_energy).sum();
    let lost = again.energy.attraction_loss - lost;
    assert!(energy < 0.0 && (lost / -energy - 1.0).abs() < 1e-3, "{lost:e} {energy:e}");
    // Twice as wet.
    s.set_properties(properties(0.02, 0.01)).unwrap();
    assert!((total(&s.assembly()) / (2.0 * all) - 1.0).abs() < 1e-14);
}

/// The work of the boundary is stored and lost, with bridges of many volumes and dry contacts.
#[test]
fn the_energy_is_in_balance() {
    let (cell, spheres) = random_insertion(&Grains { count: 200, ..Grains::default() }, 0.35, 9).unwrap();
    let mut s = Simulation::new(cell, &spheres, properties(2e-4, 1e-3)).unwrap();
    s.set_control(CellControl::isotropic(20e3, 2e4));
    s.advance(4000).unwrap();
    let mut control = CellControl::fixed();
    control.rate = [[-300.0, 0.0, 0.0], [0.0, -300.0, 0.0], [0.0, 0.0, -300.0]];
    s.set_control(control);
    s.advance(3000).unwrap();
    s.set_time_step_factor(0.05);
    s.reset_phase(0.0);
    let stored = |assembly: &Assembly| {
        let square = |v: &[f64; 3]| v.iter().map(|x| x * x).sum::<f64>();
        let kinetic: f64 = (assembly.bodies.iter())
            .map(|g| {
                0.5 * g.mass
                    * (square(&g.velocity)
                        + 0.4 * g.equivalent_radius * g.equivalent_radius * square(&g.spin))
            })
            .sum();
        let pairs = assembly.contacts.iter().chain(&assembly.apart);
        kinetic + pairs.map(|c| c.normal_energy + c.attraction_energy).sum::<f64>()
    };
    let start = stored(&s.assembly());
    s.advance(20_000).unwrap();
    let (end, e) = (stored(&s.assembly()), s.assembly().energy);
    let lost = e.tangential_work + e.damping + e.attraction_loss;
    let size = e.boundary_work.abs() + (end - start).abs() + lost.abs();
    let gap = (e.boundary_work - lost - (end - start)) / size;
    assert!(e.attraction_loss > 2e-3 * size, "{e:?}, {size:e}");
    assert!(gap.abs() < 0.01, "{gap}: {e:?}, stored {start:e} to {end:e}");
}

/// A checkpoint whose films do not belong to its grains is refused.
#[test]
fn checkpoints_without_films_are_refused() {
    let mut s = meeting(properties(0.01, 0.01), [0.5 * DIAMETER; 2], 0.1);
    for films in [vec![], vec![1e-16], vec![1e-16, f64::NAN], vec![-1e-16, 1e-16]] {
        s.integrator.state.films = films;
        let said = Simulation::restore(&s.checkpoint("").unwrap()).err().unwrap().to_string();
        assert!(said.contains("films of liquid"), "{said}");
    }
}
