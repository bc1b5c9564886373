//! Packings: grains in a periodic cell, as CSV.
//!
//! ```text
//! # periodic box, m: xlo=-0.0008 ylo=-0.0008 zlo=-0.0008 xhi=0.0008 yhi=0.0008 zhi=0.0008
//! id,x,y,z,radius
//! 1,1.7e-05,0.0006,-0.0005,5e-05
//! ```
//!
//! The box may be tilted as in LAMMPS (`xy= xz= yz=` after `zhi`). A cell of any other shape is given by its corner
//! and its three edges: `# periodic cell, m: ox= oy= oz= ax= ay= az= bx= by= bz= cx= cy= cz=`. Other columns than the
//! five are passed over. Grains may stand in any order; their ids must be 1, 2, ... without a gap.

mod cell;
mod overlap;
mod repeat;

use std::io::{BufRead, Write};
use std::path::Path;

use granum_core::Cell;
use granum_core::assembly::{Assembly, Matrix, Vector};
use granum_core::geometry::{apply, determinant};

use crate::atomic::write_atomically;
use crate::csv::{Lines, names, number, position};
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

    /// Reads and checks a packing.
    ///
    /// # Errors
    /// If the file cannot be read; [`Error::Input`] with line and grain for a cell that is missing or flat, numbers
    /// that are not finite, radii that are not positive, grains outside the cell, ids that are missing or doubled,
    /// and overlaps above [`GROSS_OVERLAP`] of the smaller diameter.
    pub fn read(path: impl AsRef<Path>) -> Result<Packing> {
        Packing::read_lines(&mut Lines::open(path.as_ref())?)
    }

    /// Reads and checks a packing from any reader of text; `file` is its name for messages.
    ///
    /// # Errors
    /// As [`Packing::read`].
    pub fn read_from(reader: impl BufRead, file: &str) -> Result<Packing> {
        Packing::read_lines(&mut Lines::new(reader, file))
    }

    fn read_lines<R: BufRead>(lines: &mut Lines<R>) -> Result<Packing> {
        let mut cell = None;
        let mut columns = None;
        let mut grains: Vec<(PackedGrain, usize)> = Vec::new();
        while lines.advance()? {
            if lines.is_empty() {
                if let Some(found) = cell::parse(lines)? {
                    cell = Some(found);
                }
                continue;
            }
            let Some(columns) = &columns else {
                columns = Some(Columns::from_header(lines)?);
                continue;
            };
            let Some((origin, edges, inverse)) = &cell else {
                let message = "the periodic cell is not given".to_string();
                return Err(lines.error(0..0, message).with_help(cell::EXAMPLE).into());
            };
            let grain = columns.grain(lines)?;
            check_inside(lines, &grain, origin, edges, inverse)?;
            grains.push((grain, lines.number()));
        }
        let (Some((origin, cell, _)), false) = (cell, grains.is_empty()) else {
            return Err(Error::content(
                Path::new(lines.file()),
                "holds no packing: it needs a cell and grains",
            ));
        };
        let grains = check_ids(lines.file(), grains)?;
        overlap::check(lines.file(), &cell, &grains)?;
        Ok(Packing { origin, cell, grains: grains.into_iter().map(|(grain, _)| grain).collect() })
    }

    /// Writes the packing beside and renames it; it reads back bit for bit.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be written.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<()> {
        write_atomically(path.as_ref(), |file| {
            writeln!(file, "{}", cell::text(&self.origin, &self.cell))?;
            writeln!(file, "id,x,y,z,radius")?;
            for grain in &self.grains {
                let [x, y, z] = grain.position.map(format_number);
                writeln!(file, "{},{x},{y},{z},{}", grain.id, format_number(grain.radius))?;
            }
            Ok(())
        })
    }
}

/// Where the five columns are.
struct Columns {
    header: Vec<String>,
    places: [usize; 5],
}

impl Columns {
    const NAMES: [&'static str; 5] = ["id", "x", "y", "z", "radius"];

    fn from_header<R: BufRead>(lines: &Lines<R>) -> Result<Columns> {
        let header = names(lines)?;
        let mut places = [0; 5];
        for (place, name) in places.iter_mut().zip(Self::NAMES) {
            *place = position(lines.file(), &header, name)?;
        }
        Ok(Columns { header, places })
    }

    fn grain<R: BufRead>(&self, lines: &Lines<R>) -> Result<PackedGrain> {
        let cells: Vec<(usize, &str)> = lines.cells().collect();
        if cells.len() != self.header.len() {
            let message =
                format!("the row has {} cells, but the header names {}", cells.len(), self.header.len());
            return Err(lines.error(0..lines.line().len(), message).into());
        }
        let [id, numbers @ ..] = self.places;
        let (start, text) = cells[id];
        let id: u64 = text.parse().ok().filter(|id| *id > 0).ok_or_else(|| {
            let message = format!("id = {text:?} is no whole number from 1");
            Error::from(lines.cell_error(start, text, message))
        })?;
        let mut values = [0.0; 4];
        for ((value, place), name) in values.iter_mut().zip(numbers).zip(&Self::NAMES[1..]) {
            let (start, text) = cells[place];
            *value = number(lines, name, start, text)?;
            let wrong = if !value.is_finite() {
                "must be finite"
            } else if *name == "radius" && *value <= 0.0 {
                "must be positive"
            } else {
                continue;
            };
            return Err(lines.cell_error(start, text, format!("grain {id}: {name} = {text} {wrong}")).into());
        }
        let [x, y, z, radius] = values;
        Ok(PackedGrain { id, position: [x, y, z], radius })
    }
}

/// A grain must be inside the cell, and the cell wide enough to hold it.
fn check_inside<R: BufRead>(
    lines: &Lines<R>,
    grain: &PackedGrain,
    origin: &Vector,
    edges: &Matrix,
    inverse: &Matrix,
) -> Result<()> {
    let from_corner: Vector = std::array::from_fn(|a| grain.position[a] - origin[a]);
    let place = apply(inverse, from_corner);
    let whole = 0..lines.line().len();
    if let Some(axis) = (0..3).find(|k| !(-ROUNDING..=1.0 + ROUNDING).contains(&place[*k])) {
        let [x, y, z] = grain.position;
        let message = format!(
            "grain {}: ({x:e}, {y:e}, {z:e}) is outside the cell: {} of edge {} from its corner",
            grain.id,
            format_number(place[axis]),
            ["a", "b", "c"][axis]
        );
        return Err(lines.error(whole, message).with_help("wrap it into the periodic cell").into());
    }
    let narrow = Cell { edges: *edges }.heights().into_iter().fold(f64::INFINITY, f64::min);
    if 2.0 * grain.radius > narrow {
        let message = format!(
            "grain {}: radius = {:e} m does not fit in the cell, {narrow:e} m wide",
            grain.id, grain.radius
        );
        return Err(lines.error(whole, message).with_help("lengths are in m").into());
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
