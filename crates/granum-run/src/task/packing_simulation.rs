//! The simulation of a packing: its grains, spheres or rigid bodies of several pieces, at rest in its cell.

use granum_core::cell::Cell;
use granum_core::geometry::Matrix;
use granum_core::rotation::{IDENTITY, matrix, to_body};
use granum_dem::bond::ListedPair;
use granum_dem::simulation::{InitialBody, InitialSphere, Properties, RigidShape, ShapePiece, Simulation};
use granum_io::Packing;
use granum_io::packing::{PackedBody, PackedBond, PackedGrain};

use crate::task::laboratory_error::LaboratoryError;
use crate::task::memory;

/// Largest ratio of the radii in a packing. The search for neighbours uses the size of the largest grain, and its skin must
/// not contain a large number of the smallest grains.
const WIDEST_RADII: f64 = 100.0;
/// Largest ratio of an edge of the cell to the largest radius, sufficient for 10^9 grains.
const WIDEST_CELL: f64 = 1e5;

/// The grains of a packing at rest, with the forces of their geometry and the list of the pairs that are to be bonded.
///
/// # Errors
/// If the memory does not suffice, if the radii differ too much or the cell is too large for them, or as
/// [`Simulation::new`] and [`Simulation::of_bodies`].
pub fn simulation(packing: &Packing, properties: Properties) -> Result<Simulation, LaboratoryError> {
    memory::check_grains(packing.grains.len())?;
    let radii = radii(packing).into_iter();
    let (smallest, largest) = radii.fold((f64::INFINITY, 0.0f64), |(a, b), r| (a.min(r), b.max(r)));
    if largest > WIDEST_RADII * smallest {
        return Err(LaboratoryError::Packing(format!(
            "its radii range from {smallest:e} m to {largest:e} m; the largest can be at most {WIDEST_RADII} times the \
             smallest"
        )));
    }
    let edge = packing.cell.iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
    if edge >= WIDEST_CELL * largest {
        return Err(LaboratoryError::Packing(format!(
            "its cell has an edge of {edge:e} m, but its largest grain a radius of {largest:e} m; at most \
             {WIDEST_CELL:e} times the radius is possible"
        )));
    }
    let mut simulation = grains_at_rest(packing, properties)?;
    if !packing.bonds.is_empty() {
        let pair = |bond: &PackedBond| ListedPair { pieces: bond.pieces, kind: bond.kind };
        simulation.list_pairs(packing.bonds.iter().map(pair).collect())?;
    }
    Ok(simulation)
}

fn grains_at_rest(packing: &Packing, properties: Properties) -> Result<Simulation, LaboratoryError> {
    let materials = materials(packing, &properties)?;
    if !packing.bodies.is_empty() {
        let (shapes, bodies) = bodies(packing);
        let materials = materials.unwrap_or_default();
        return Ok(Simulation::of_bodies(cell(packing), &shapes, &bodies, &materials, properties)?);
    }
    let (cell, spheres) = (cell(packing), spheres(packing));
    match materials {
        Some(materials) => Ok(Simulation::of_materials(cell, &spheres, &materials, properties)?),
        None => Ok(Simulation::new(cell, &spheres, properties)?),
    }
}

/// The material of each grain, if the packing names it and the case has several materials; otherwise `None`, and materials are
/// drawn at random.
fn materials(packing: &Packing, properties: &Properties) -> Result<Option<Vec<u8>>, LaboratoryError> {
    let mixture = &properties.mixture;
    if mixture.is_empty() || packing.materials.of.is_empty() {
        return Ok(None);
    }
    let place = |grain: usize| {
        let name = packing.materials.name(grain).unwrap_or_default();
        mixture.position(name).map(|place| place as u8).ok_or_else(|| {
            let known: Vec<&str> = mixture.components.iter().map(|c| c.name.as_str()).collect();
            LaboratoryError::Packing(format!(
                "its grain {} has the material {name:?}, but the case has {}; add a table [[material]] with this name",
                packing.grains[grain].id,
                known.join(", ")
            ))
        })
    };
    (0..packing.grains.len()).map(place).collect::<Result<_, _>>().map(Some)
}

/// The cell of a packing, with its corner moved to the origin.
pub fn cell(packing: &Packing) -> Cell {
    Cell { edges: packing.cell }
}

/// The grains of a packing, with positions relative to the corner of its cell.
pub fn spheres(packing: &Packing) -> Vec<InitialSphere> {
    packing
        .grains
        .iter()
        .map(|g| InitialSphere { id: g.id, position: packing.from_corner(g), radius: g.radius })
        .collect()
}

/// The radii of all spheres, those of pieces included, m.
fn radii(packing: &Packing) -> Vec<f64> {
    let pieces = packing.bodies.iter().flat_map(|body| body.pieces.iter().map(|piece| piece.radius));
    packing.grains.iter().map(|grain| grain.radius).chain(pieces).collect()
}

/// The grains of a packing as bodies, each with a shape of its own, with positions relative to the corner of its cell.
fn bodies(packing: &Packing) -> (Vec<RigidShape>, Vec<InitialBody>) {
    let mut clumps = packing.bodies.iter().peekable();
    let body = |(at, grain): (usize, &PackedGrain)| {
        let clump = clumps.next_if(|clump| clump.grain == at);
        let shape = clump.map_or_else(|| RigidShape::sphere(grain.radius), |clump| shape(grain, clump));
        let orientation = clump.map_or(IDENTITY, |clump| clump.orientation);
        let position = packing.from_corner(grain);
        (shape, InitialBody { id: grain.id, position, orientation, shape: at, scale: 1.0 })
    };
    packing.grains.iter().enumerate().map(body).unzip()
}

/// The shape of a grain of several pieces, in its principal axes.
fn shape(grain: &PackedGrain, clump: &PackedBody) -> RigidShape {
    let axes: Matrix = matrix(&clump.orientation);
    let pieces = (clump.pieces.iter())
        .map(|piece| ShapePiece { centre: to_body(&axes, &piece.arm), radius: piece.radius });
    RigidShape {
        pieces: pieces.collect(),
        volume: RigidShape::sphere(grain.radius).volume,
        inertia_over_mass: clump.inertia_over_mass,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use granum_dem::config::{ContactModel, Material};

    #[test]
    fn packings_that_no_machine_could_hold_are_refused() {
        let refused = |edge: f64, radius: f64| {
            let file = format!(
                "# periodic box, m: xlo=0 ylo=0 zlo=0 xhi={edge} yhi={edge} zhi={edge}\n\
                 id,x,y,z,radius\n1,0.1,0.1,0.1,1e-3\n2,0.2,0.2,0.2,{radius}\n"
            );
            let packing = granum_io::formats::packing_csv::read_from(file.as_bytes(), "p.csv").unwrap();
            let properties = Properties::new(Material::default(), ContactModel::default());
            simulation(&packing, properties).err().map(|error| error.to_string()).unwrap_or_default()
        };
        assert_eq!(refused(1.0, 1e-3), "");
        assert!(
            refused(1.0, 0.9e-5).contains("radii range from 9e-6 m to 1e-3 m"),
            "{}",
            refused(1.0, 0.9e-5)
        );
        assert!(refused(100.1, 1e-3).contains("an edge of 1.001e2 m"), "{}", refused(100.1, 1e-3));
    }

    /// Two dimers that touch, as a simulation made them, and the same through a packing file.
    #[test]
    fn bodies_of_a_packing_are_those_of_its_file() {
        let piece = |x: f64| ShapePiece { centre: [x, 0.0, 0.0], radius: 0.5e-3 };
        let dimer = RigidShape {
            pieces: vec![piece(-0.25e-3), piece(0.25e-3)],
            volume: 0.8835729338221e-9,
            inertia_over_mass: [0.10625e-6, 0.184375e-6, 0.184375e-6],
        };
        let body = |id: u64, position, shape| InitialBody {
            id,
            position,
            orientation: granum_core::rotation::about(&[1.0, 2.0, 3.0], 0.5 * id as f64),
            shape,
            scale: 1.0,
        };
        let cell = Cell { edges: [[5e-3, 1e-3, 0.0], [0.0, 5e-3, 0.0], [0.0, 0.0, 5e-3]] };
        let properties = || Properties::new(Material::default(), ContactModel::default());
        let shapes = [dimer, RigidShape::sphere(0.4e-3)];
        // The second is brought near the first, across the corner of the cell, until they touch.
        let at = |x: f64| {
            let bodies = [
                body(1, [0.1e-3, 0.1e-3, 0.1e-3], 0),
                body(2, [x, 0.15e-3, 0.1e-3], 0),
                body(3, [3e-3, 3e-3, 3e-3], 1),
            ];
            Simulation::of_bodies(cell, &shapes, &bodies, &[], properties()).unwrap().assembly()
        };
        let wanted = (0..100).map(|k| at(2e-3 - 1e-5 * f64::from(k))).find(|a| !a.contacts.is_empty());
        let wanted = wanted.expect("two bodies that touch");
        assert!(!wanted.contacts.is_empty());
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p.csv");
        granum_io::write_packing(&path, &Packing::from_assembly(&wanted)).unwrap();
        let packing = granum_io::read_packing(&path).unwrap();
        let found = simulation(&packing, properties()).unwrap().assembly();
        assert_eq!(found.bodies.len(), 3);
        for (one, two) in wanted.bodies.iter().zip(&found.bodies) {
            assert_eq!((one.id, one.position), (two.id, two.position));
            assert!((one.mass / two.mass - 1.0).abs() < 1e-14);
        }
        assert_eq!(wanted.rigid[0].orientation, found.rigid[0].orientation);
        assert_eq!(wanted.contacts.len(), found.contacts.len());
        for (one, two) in wanted.contacts.iter().zip(&found.contacts) {
            assert_eq!((one.i, one.j), (two.i, two.j));
            assert!((one.approach - two.approach).abs() < 1e-18, "{} {}", one.approach, two.approach);
        }
    }
}
