//! The simulation of a packing: its grains at rest in its cell.

use granum_core::cell::Cell;
use granum_dem::simulation::{InitialSphere, Properties, Simulation};
use granum_io::Packing;

use crate::laboratory::laboratory_error::LaboratoryError;
use crate::laboratory::memory;

/// Largest ratio of the radii in a packing. The search for neighbours uses the size of the largest grain, and its skin must
/// not contain a large number of the smallest grains.
const WIDEST_RADII: f64 = 100.0;
/// Largest ratio of an edge of the cell to the largest radius, sufficient for 10^9 grains.
const WIDEST_CELL: f64 = 1e5;

/// The grains of a packing at rest, with the forces of their geometry.
///
/// # Errors
/// If the memory does not suffice, if the radii differ too much or the cell is too large for them, or as
/// [`Simulation::new`].
pub fn simulation(packing: &Packing, properties: Properties) -> Result<Simulation, LaboratoryError> {
    memory::check_grains(packing.grains.len())?;
    let radii = packing.grains.iter().map(|grain| grain.radius);
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
    let (cell, spheres) = (cell(packing), spheres(packing));
    match materials(packing, &properties)? {
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
}
