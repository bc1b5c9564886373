//! Packings: grains in a periodic cell, and the checks that every format of them shares.

mod overlap;
mod repeat;

use std::path::Path;

use granum_core::Cell;
use granum_core::assembly::{Assembly, Matrix, Vector};
use granum_core::geometry::{apply, determinant, invert};

use crate::error::{Error, InputError, Result};
use granum_core::quantity::format_number;

pub use overlap::GROSS_OVERLAP;

/// How far outside the cell, relative to its edge, a grain may be by rounding.
const ROUNDING: f64 = 1e-9;

/// One grain of a packing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PackedGrain {
    /// Its number, from 1.
    pub id: u64,
    /// Centre, m.
    pub position: Vector,
    /// Radius, m.
    pub radius: f64,
}

/// Grains in a periodic cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Packing {
    /// Corner of the cell, m.
    pub origin: Vector,
    /// Edge matrix of the cell: column k is edge k, m.
    pub cell: Matrix,
    /// The grains, in order of their ids.
    pub grains: Vec<PackedGrain>,
}

impl Packing {
    /// The grains and cell of an assembly, whose cell has a corner at the origin.
    pub fn from_assembly(assembly: &Assembly) -> Packing {
        let grain = |g: &granum_core::assembly::Grain| PackedGrain {
            id: g.id,
            position: g.position,
            radius: g.radius,
        };
        Packing { origin: [0.0; 3], cell: assembly.cell, grains: assembly.grains.iter().map(grain).collect() }
    }

    /// Position of a grain from the corner of the cell, m.
    pub fn from_corner(&self, grain: &PackedGrain) -> Vector {
        std::array::from_fn(|a| grain.position[a] - self.origin[a])
    }

    /// Volume of the grains over the volume of the cell (overlaps counted twice).
    pub fn solid_fraction(&self) -> f64 {
        let cubes: f64 = self.grains.iter().map(|grain| grain.radius.powi(3)).sum();
        4.0 / 3.0 * std::f64::consts::PI * cubes / determinant(&self.cell).abs()
    }

    /// A packing from what a file holds: corner and edges of the cell, and the grains, each with the number of its line (or
    /// record) for messages.
    ///
    /// # Errors
    /// [`Error::Input`] with line and grain for a flat cell, grains outside the cell, ids that are missing or doubled,
    /// and overlaps above [`GROSS_OVERLAP`] of the smaller diameter; [`Error::Content`] if there are no grains.
    pub fn checked(
        file: &str,
        origin: Vector,
        cell: Matrix,
        grains: Vec<(PackedGrain, usize)>,
    ) -> Result<Packing> {
        if grains.is_empty() {
            let message = "holds no packing: it needs a cell and grains";
            return Err(Error::content(Path::new(file), message));
        }
        let inverse = invert(&cell);
        if inverse.iter().flatten().any(|x| !x.is_finite()) {
            let volume = determinant(&cell);
            let message = format!("the cell has the volume {volume:e} m3; it must be positive");
            return Err(Error::content(Path::new(file), message));
        }
        for (grain, line) in &grains {
            check_inside(file, *line, grain, &origin, &cell, &inverse)?;
        }
        let grains = check_ids(file, grains)?;
        overlap::check(file, &cell, &grains)?;
        Ok(Packing { origin, cell, grains: grains.into_iter().map(|(grain, _)| grain).collect() })
    }
}

/// A grain must be inside the cell, and the cell wide enough to hold it.
fn check_inside(
    file: &str,
    line: usize,
    grain: &PackedGrain,
    origin: &Vector,
    edges: &Matrix,
    inverse: &Matrix,
) -> Result<()> {
    let from_corner: Vector = std::array::from_fn(|a| grain.position[a] - origin[a]);
    let place = apply(inverse, from_corner);
    let error = |message: String| InputError::in_line(file, line, "", 0..0, message);
    if let Some(axis) = (0..3).find(|k| !(-ROUNDING..=1.0 + ROUNDING).contains(&place[*k])) {
        let [x, y, z] = grain.position;
        let message = format!(
            "grain {}: ({x:e}, {y:e}, {z:e}) is outside the cell: {} of edge {} from its corner",
            grain.id,
            format_number(place[axis]),
            ["a", "b", "c"][axis]
        );
        return Err(error(message).with_help("wrap it into the periodic cell").into());
    }
    let narrow = Cell { edges: *edges }.heights().into_iter().fold(f64::INFINITY, f64::min);
    if 2.0 * grain.radius > narrow {
        let message = format!(
            "grain {}: radius = {:e} m does not fit in the cell, {narrow:e} m wide",
            grain.id, grain.radius
        );
        return Err(error(message).with_help("lengths are in m").into());
    }
    Ok(())
}

/// Sorts by id and refuses ids that are doubled or missing.
fn check_ids(file: &str, mut grains: Vec<(PackedGrain, usize)>) -> Result<Vec<(PackedGrain, usize)>> {
    grains.sort_by_key(|(grain, line)| (grain.id, *line));
    for (at, (grain, line)) in grains.iter().enumerate() {
        let wanted = at as u64 + 1;
        if grain.id == wanted {
            continue;
        }
        let message = if grain.id < wanted {
            format!("grain {} stands in line {} already", grain.id, grains[at - 1].1)
        } else {
            format!("grain {wanted} is missing: after {} comes {}", wanted - 1, grain.id)
        };
        let error = InputError::in_line(file, *line, "", 0..0, message);
        return Err(error.with_help("ids must be 1, 2, ... each once").into());
    }
    Ok(grains)
}

#[cfg(test)]
mod tests;
