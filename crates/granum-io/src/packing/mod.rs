//! Packings: grains in a periodic cell, and the checks that all formats of them share.

mod assembled_bodies;
mod body_check;
pub(crate) mod lattice;
pub(crate) mod near;
mod overlap;
mod packed_body;
mod packed_bond;
mod packed_grain;
pub(crate) mod plausible;
mod repeat;

use std::path::Path;

use granum_core::assembly::{Assembly, Body, Matrix, Vector};
use granum_core::geometry::{apply, determinant, invert};
use granum_dem::mixture::MOST_MATERIALS;

use crate::error::{Error, Result, in_file};
use crate::formats::Remark;
use granum_core::quantity::format_number;

pub use overlap::GROSS_OVERLAP;
pub use packed_body::{PackedBody, PackedPiece};
pub use packed_bond::PackedBond;
pub use packed_grain::PackedGrain;
pub use plausible::{Implausible, ImplausiblePlace};

/// Tolerance for the position of a grain outside the cell, relative to the edge of the cell, because of rounding.
const ROUNDING: f64 = 1e-9;

/// The materials of the grains of a packing, if its file contains them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PackedMaterials {
    /// Names of the materials, each once.
    pub names: Vec<String>,
    /// Index of the material of each grain in the list of names, in the order of the grains; empty if the file contains none.
    pub of: Vec<u8>,
}

impl PackedMaterials {
    /// The name of the material of a grain, by the index of the grain.
    pub fn name(&self, grain: usize) -> Option<&str> {
        let name = self.names.get(*self.of.get(grain)? as usize)?;
        Some(name)
    }

    /// The index of a name in the list, to which a new name is added; `None` if there are too many.
    pub(crate) fn place(&mut self, name: &str) -> Option<u8> {
        let known = self.names.iter().position(|known| known == name);
        let place = known.unwrap_or(self.names.len());
        if known.is_none() && place < MOST_MATERIALS {
            self.names.push(name.to_string());
        }
        (place < MOST_MATERIALS).then_some(place as u8)
    }

    /// The same names in the order in which the grains, given by their places among the names, first use them.
    pub(crate) fn in_order(&self, of: impl Iterator<Item = u8>) -> PackedMaterials {
        let mut ordered = PackedMaterials::default();
        for place in of {
            let name = self.names.get(usize::from(place));
            let place = name.and_then(|name| ordered.place(name)).unwrap_or_default();
            ordered.of.push(place);
        }
        ordered
    }
}

/// Grains in a periodic cell.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Packing {
    /// Corner of the cell, m.
    pub origin: Vector,
    /// Edge matrix of the cell: column k is edge k, m.
    pub cell: Matrix,
    /// The grains, in order of their ids: of one of several pieces its centre of mass and the sphere of equal volume.
    pub grains: Vec<PackedGrain>,
    /// The grains that have several pieces, in the same order; empty if every grain is a sphere.
    pub bodies: Vec<PackedBody>,
    /// The pairs of spheres that the file lists as bonded; empty if it lists none.
    pub bonds: Vec<PackedBond>,
    /// Their materials, if the file contains them.
    pub materials: PackedMaterials,
    /// What of the file a packing has no place for, or what was set right in it.
    pub remarks: Vec<Remark>,
}

impl Packing {
    /// Grains, in order of their ids, in a cell with a corner and an edge matrix (column k is edge k), m. Nothing is checked: see
    /// [`Packing::checked`].
    pub fn new(origin: Vector, cell: Matrix, grains: Vec<PackedGrain>) -> Packing {
        let (bodies, materials, remarks) = (Vec::new(), PackedMaterials::default(), Vec::new());
        Packing { origin, cell, grains, bodies, bonds: Vec::new(), materials, remarks }
    }

    /// The grains and cell of an assembly, whose cell has a corner at the origin.
    pub fn from_assembly(assembly: &Assembly) -> Packing {
        let grain = |body: &Body| PackedGrain {
            id: body.id,
            position: body.position,
            radius: body.equivalent_radius,
        };
        let materials = match assembly.materials.as_slice() {
            [] => PackedMaterials::default(),
            names => PackedMaterials {
                names: names.to_vec(),
                of: assembly.bodies.iter().map(|g| g.material.min(u32::from(u8::MAX)) as u8).collect(),
            },
        };
        let grains = assembly.bodies.iter().map(grain).collect();
        let bodies = PackedBody::of_assembly(assembly);
        Packing { materials, bodies, ..Packing::new([0.0; 3], assembly.cell, grains) }
    }

    /// Position of a grain relative to the corner of the cell, m.
    pub fn from_corner(&self, grain: &PackedGrain) -> Vector {
        std::array::from_fn(|a| grain.position[a] - self.origin[a])
    }

    /// Volume of the grains over the volume of the cell (overlaps of grains counted twice, those of pieces of one grain once).
    pub fn solid_fraction(&self) -> f64 {
        let cubes: f64 = self.grains.iter().map(|grain| grain.radius.powi(3)).sum();
        4.0 / 3.0 * std::f64::consts::PI * cubes / determinant(&self.cell).abs()
    }

    /// A packing from the content of a file: corner and edges of the cell, and the grains, each with the number of its line for
    /// messages (0 in files that have no lines). Their ids must be 1, 2, ... each once.
    ///
    /// # Errors
    /// [`Error::Input`] with line and grain (without a line [`Error::Content`]) for a flat cell, grains outside the cell, ids that
    /// are missing or repeated, and overlaps above [`GROSS_OVERLAP`] of the smaller diameter; [`Error::Content`] if there are no
    /// grains.
    pub fn checked(
        file: &str,
        origin: Vector,
        cell: Matrix,
        grains: Vec<(PackedGrain, usize)>,
    ) -> Result<Packing> {
        Packing::checked_bodies(file, origin, cell, grains, Vec::new())
    }

    /// As [`Packing::checked`] for grains of which some have several pieces; each of these names its grain by its place in the order of the ids.
    ///
    /// # Errors
    /// As [`Packing::checked`]; also for a body larger than half the cell, an orientation that is no rotation and moments of inertia that are
    /// not positive. Overlaps are those of pieces of two grains.
    pub fn checked_bodies(
        file: &str,
        origin: Vector,
        cell: Matrix,
        grains: Vec<(PackedGrain, usize)>,
        bodies: Vec<PackedBody>,
    ) -> Result<Packing> {
        check_cell(file, &origin, &cell, &grains)?;
        let (cell, grains) = in_usual_cell(&origin, cell, check_ids(file, grains)?);
        body_check::check(file, &cell, &grains, &bodies)?;
        overlap::check(file, &cell, &grains, &bodies)?;
        let grains = grains.into_iter().map(|(grain, _)| grain).collect();
        Ok(Packing { bodies, ..Packing::new(origin, cell, grains) })
    }

    /// As [`Packing::checked_bodies`] for grains with any ids, by which messages name them; in the packing they are 1, 2, ... in the order
    /// given.
    ///
    /// # Errors
    /// As for [`Packing::checked_bodies`], except that ids may be any.
    pub(crate) fn numbered_from_one(
        file: &str,
        origin: Vector,
        cell: Matrix,
        grains: Vec<(PackedGrain, usize)>,
        bodies: Vec<PackedBody>,
    ) -> Result<Packing> {
        check_cell(file, &origin, &cell, &grains)?;
        let (cell, grains) = in_usual_cell(&origin, cell, grains);
        body_check::check(file, &cell, &grains, &bodies)?;
        overlap::check(file, &cell, &grains, &bodies)?;
        let numbered =
            |(k, (grain, _)): (usize, (PackedGrain, usize))| PackedGrain { id: k as u64 + 1, ..grain };
        let grains = grains.into_iter().enumerate().map(numbered).collect();
        Ok(Packing { bodies, ..Packing::new(origin, cell, grains) })
    }
}

/// Checks that there are grains, that the cell has a volume, and that the grains are in it.
fn check_cell(file: &str, origin: &Vector, cell: &Matrix, grains: &[(PackedGrain, usize)]) -> Result<()> {
    if grains.is_empty() {
        let message = "is not a packing: it needs a cell and grains";
        return Err(Error::content(Path::new(file), message));
    }
    let found = |(grain, line): &(PackedGrain, usize)| plausible::Found {
        id: grain.id,
        position: grain.position,
        radius: Some(grain.radius),
        line: *line,
    };
    plausible::check(file, Some((*origin, *cell)), &grains.iter().map(found).collect::<Vec<_>>())?;
    let inverse = invert(cell);
    grains.iter().try_for_each(|(grain, line)| check_inside(file, *line, grain, origin, &inverse))
}

/// The cell as it is, or the least skewed one of its lattice with the grains moved into it, if its edges are so nearly parallel that images
/// of a grain are found through many others, or a grain fits only into the latter.
fn in_usual_cell(
    origin: &Vector,
    cell: Matrix,
    mut grains: Vec<(PackedGrain, usize)>,
) -> (Matrix, Vec<(PackedGrain, usize)>) {
    let largest = grains.iter().map(|(grain, _)| grain.radius).fold(0.0, f64::max);
    let Some(cell) = lattice::less_skewed(&cell, largest) else { return (cell, grains) };
    let inverse = invert(&cell);
    for (grain, _) in &mut grains {
        let place = apply(&inverse, std::array::from_fn(|a| grain.position[a] - origin[a]));
        let shift = apply(&cell, place.map(f64::floor));
        grain.position = std::array::from_fn(|a| grain.position[a] - shift[a]);
    }
    (cell, grains)
}

/// Checks that a grain is inside the cell.
fn check_inside(
    file: &str,
    line: usize,
    grain: &PackedGrain,
    origin: &Vector,
    inverse: &Matrix,
) -> Result<()> {
    let from_corner: Vector = std::array::from_fn(|a| grain.position[a] - origin[a]);
    let place = apply(inverse, from_corner);
    if let Some(axis) = (0..3).find(|k| !(-ROUNDING..=1.0 + ROUNDING).contains(&place[*k])) {
        let [x, y, z] = grain.position;
        let message = format!(
            "grain {}: ({x:e}, {y:e}, {z:e}) is outside the cell: {} of edge {} from its corner",
            grain.id,
            format_number(place[axis]),
            ["a", "b", "c"][axis]
        );
        return Err(in_file(file, line, message, "wrap it into the periodic cell"));
    }
    Ok(())
}

/// Sorts by id and rejects ids that are repeated or missing.
pub(crate) fn check_ids(
    file: &str,
    mut grains: Vec<(PackedGrain, usize)>,
) -> Result<Vec<(PackedGrain, usize)>> {
    grains.sort_by_key(|(grain, line)| (grain.id, *line));
    for (at, (grain, line)) in grains.iter().enumerate() {
        let wanted = at as u64 + 1;
        if grain.id == wanted {
            continue;
        }
        let message = if grain.id < wanted {
            match grains[at - 1].1 {
                0 => format!("grain {} is already given", grain.id),
                before => format!("grain {} is already given in line {before}", grain.id),
            }
        } else {
            format!("grain {wanted} is missing: after {} comes {}", wanted - 1, grain.id)
        };
        return Err(in_file(file, *line, message, "ids must be 1, 2, ... each once"));
    }
    Ok(grains)
}

#[cfg(test)]
mod tests;
