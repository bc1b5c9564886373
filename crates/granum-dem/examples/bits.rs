//! Prints digests of short runs with several sets of laws, on every instruction set of the machine: what two builds of the engine must have
//! in common (`scripts/windows.sh --quick` and `scripts/aarch64.sh --quick` compare those for Windows and aarch64 with the native one).

use granum_core::digest::Digest;
use granum_dem::Isa;
use granum_dem::body_insertion::insert_bodies;
use granum_dem::bond::{BondKind, Bonding, StrengthScatter};
use granum_dem::config::{ContactModel, Grains, Material, NormalKind, RollingKind, TangentialKind};
use granum_dem::observer::NoObserver;
use granum_dem::random_insertion::random_insertion;
use granum_dem::servo::CellControl;
use granum_dem::shape::{ShapeEntry, ShapeKind};
use granum_dem::simulation::{Hardware, Properties, Simulation};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let sets = [
        (NormalKind::HERTZ, TangentialKind::NO_SLIP, RollingKind::NONE, 0.0),
        (NormalKind::HERTZ, TangentialKind::MINDLIN_DERESIEWICZ, RollingKind::NONE, 0.3),
        (NormalKind::JKR, TangentialKind::NO_SLIP, RollingKind::NONE, 0.3),
        (NormalKind::HOOKE, TangentialKind::NO_SLIP, RollingKind::NONE, 0.3),
        // Through slots.
        (NormalKind::HERTZ, TangentialKind::NO_SLIP, RollingKind::ELASTIC_PLASTIC, 0.3),
        (NormalKind::JKR_DMT, TangentialKind::NO_SLIP, RollingKind::NONE, 0.0),
    ];
    for (normal, tangential, rolling, spread) in sets {
        let mut contact = ContactModel::new(normal, tangential, 0.1);
        contact.rolling = rolling;
        let adhesive = [NormalKind::JKR, NormalKind::JKR_DMT].contains(&normal);
        let material = Material::default().with(|material| {
            material.interface_energy = if adhesive { material.interface_energy } else { 0.0 };
        });
        for isa in Isa::ALL.into_iter().filter(|isa| isa.available()) {
            let digest = run(Properties::new(material, contact), spread, Hardware { threads: 2, isa })?;
            let laws = [normal.name(), tangential.name(), rolling.name()].join(" ");
            println!("{}  {laws}, spread {spread}, {}", &digest[..16], isa.name());
        }
    }
    for isa in Isa::ALL.into_iter().filter(|isa| isa.available()) {
        let digest = run_shapes(Hardware { threads: 2, isa })?;
        println!("{}  hertz no-slip, grains of three shapes, {}", &digest[..16], isa.name());
    }
    for isa in Isa::ALL.into_iter().filter(|isa| isa.available()) {
        let (digest, left, broken) = run_bonds(Hardware { threads: 2, isa })?;
        println!("{}  hertz no-slip, {left} bonds left, {broken} broken, {}", &digest[..16], isa.name());
    }
    Ok(())
}

/// The same of bonded grains, with dashpots, of whose bonds some rupture; how many hold at the end, and how many do not.
fn run_bonds(hardware: Hardware) -> Result<(String, usize, usize), Box<dyn std::error::Error>> {
    let grains = Grains::default().with(|grains| (grains.count, grains.spread) = (100, 0.3));
    let (cell, spheres) = random_insertion(&grains, 0.35, 9)?;
    let material = Material::default().with(|material| material.interface_energy = 0.0);
    let contact = ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.1);
    let mut simulation = Simulation::new(cell, &spheres, Properties::new(material, contact))?;
    simulation.set_hardware(hardware);
    simulation.set_control(CellControl::isotropic(20e3, 2e4));
    simulation.advance(4000)?;
    for (law, gap) in [(BondKind::PARALLEL, 0.0), (BondKind::BEAM, 0.05)] {
        simulation.bond(&Bonding::default().with(|bonding| {
            (bonding.law, bonding.largest_gap, bonding.damping) = (law, gap, 0.1);
            bonding.scatter = StrengthScatter::Weibull { modulus: 3.0, reference_volume: None };
            for key in ["tensile_strength", "cohesion"] {
                bonding.parameters.insert(key.into(), 2e6);
            }
        }))?;
    }
    let digest = sheared_further(&mut simulation)?;
    let assembly = simulation.assembly();
    Ok((digest, assembly.bonds.len(), assembly.broken_bonds.len()))
}

/// The same of grains of several shapes.
fn run_shapes(hardware: Hardware) -> Result<String, Box<dyn std::error::Error>> {
    let shapes = [ShapeKind::SPHERE, ShapeKind::DIMER, ShapeKind::TETRAPOD];
    let grains = Grains::default().with(|grains| {
        (grains.count, grains.spread) = (100, 0.2);
        grains.shapes = shapes.map(|kind| ShapeEntry::new(kind).with_share(1.0 / 3.0)).to_vec();
    });
    let placed = insert_bodies(&grains, None, 0.3, 9, &mut NoObserver)?;
    let material = Material::default().with(|material| material.interface_energy = 0.0);
    let contact = ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.1);
    let properties = Properties::new(material, contact);
    let simulation =
        Simulation::of_bodies(placed.cell, &placed.shapes, &placed.bodies, &placed.materials, properties)?;
    sheared(simulation, hardware)
}

/// Digest of what a sample is after it was compressed and sheared.
fn run(
    properties: Properties,
    spread: f64,
    hardware: Hardware,
) -> Result<String, Box<dyn std::error::Error>> {
    let grains = Grains::default().with(|grains| (grains.count, grains.spread) = (100, spread));
    let (cell, spheres) = random_insertion(&grains, 0.35, 9)?;
    sheared(Simulation::new(cell, &spheres, properties)?, hardware)
}

/// Compresses and shears a sample; digest of what it is then.
fn sheared(mut simulation: Simulation, hardware: Hardware) -> Result<String, Box<dyn std::error::Error>> {
    simulation.set_hardware(hardware);
    simulation.set_control(CellControl::isotropic(20e3, 2e4));
    simulation.advance(4000)?;
    sheared_further(&mut simulation)
}

fn sheared_further(simulation: &mut Simulation) -> Result<String, Box<dyn std::error::Error>> {
    let mut shear = CellControl::fixed();
    shear.rate = [[2e3, 0.0, 0.0], [0.0, -1e3, 0.0], [0.0, 0.0, -1e3]];
    simulation.set_control(shear);
    simulation.advance(2000)?;
    let assembly = simulation.assembly();
    let mut digest = Digest::new();
    digest.count(assembly.contacts.len());
    for grain in &assembly.bodies {
        for vector in [grain.position, grain.velocity, grain.spin, grain.force, grain.torque] {
            digest.numbers(&vector);
        }
    }
    for contact in &assembly.contacts {
        digest.numbers(&contact.tangential_force);
        digest.numbers(&[contact.normal_force, contact.normal_energy]);
    }
    for bond in &assembly.bonds {
        digest.numbers(&bond.shear_force);
        digest.numbers(&bond.bending_couple);
        digest.numbers(&[bond.normal_force, bond.twisting_couple, bond.energy]);
    }
    for bond in &assembly.broken_bonds {
        digest.numbers(&[bond.id as f64, bond.energy, bond.time]);
    }
    Ok(digest.finish())
}
