//! Packings: grains in a periodic cell, as CSV.
//!
//! ```text
//! # periodic box, m: xlo=-0.0008 ylo=-0.0008 zlo=-0.0008 xhi=0.0008 yhi=0.0008 zhi=0.0008
//! id,x,y,z,radius
//! 1,1.7e-05,0.0006,-0.0005,5e-05
//! ```
//!
//! The box may be tilted as in LAMMPS (`xy= xz= yz=` after `zhi`). A cell of any other shape is given by its corner
//! and its three edges: `# periodic cell, m: ox= oy= oz= ax= ay= az= bx= by= bz= cx= cy= cz=`. A column `material` gives the name
//! of the material of each grain. Other columns are ignored. Grains may be in any order; their ids must be 1, 2, ... without a gap.

mod cell;

use std::io::{BufRead, Write};
use std::path::Path;

use granum_core::quantity::format_number;

use crate::atomic::write_atomically;
use crate::error::{Error, Result};
use crate::formats::lines::{Lines, names, number, position};
use crate::formats::{FrameCell, PackingFormat};
use crate::material_name::is_material_name;
use crate::packing::{PackedGrain, PackedMaterials, Packing};

/// The format.
pub struct PackingCsv;

impl PackingFormat for PackingCsv {
    fn name(&self) -> &'static str {
        "granum packing"
    }
    fn extensions(&self) -> &'static [&'static str] {
        &["csv"]
    }
    fn recognises(&self, head: &[u8]) -> bool {
        let text = String::from_utf8_lossy(head);
        text.lines().map(str::trim_start).any(|line| {
            line.strip_prefix('#').is_some_and(|comment| comment.trim_start().starts_with("periodic "))
        })
    }
    fn read(&self, path: &Path) -> Result<Packing> {
        read_lines(&mut Lines::open(path)?)
    }
    fn write(&self, path: &Path, packing: &Packing) -> Result<()> {
        write_atomically(path, |file| {
            writeln!(file, "{}", cell::text(&packing.origin, &packing.cell))?;
            let named = !packing.materials.of.is_empty();
            writeln!(file, "id,x,y,z,radius{}", if named { ",material" } else { "" })?;
            for (k, grain) in packing.grains.iter().enumerate() {
                let [x, y, z] = grain.position.map(format_number);
                write!(file, "{},{x},{y},{z},{}", grain.id, format_number(grain.radius))?;
                match packing.materials.name(k) {
                    Some(name) => writeln!(file, ",{name}")?,
                    None => writeln!(file)?,
                }
            }
            Ok(())
        })
    }
}

/// Reads and checks a packing from any reader of text; `file` is its name for messages.
///
/// # Errors
/// As for [`Packing::checked`]; also [`Error::Input`] for a missing cell and for text that is not a number.
pub fn read_from(reader: impl BufRead, file: &str) -> Result<Packing> {
    read_lines(&mut Lines::new(reader, file))
}

/// The cell that comments before the first row give, and the names of the columns of a CSV.
pub(super) fn cell_and_names(path: &Path) -> Result<(Option<FrameCell>, Vec<String>)> {
    let mut lines = Lines::open(path)?;
    let mut found = None;
    while lines.advance()? {
        if !lines.is_empty() {
            return Ok((found, names(&lines)?));
        }
        let given = cell::parse(&lines)?.map(|(origin, edges)| FrameCell { origin, edges });
        found = given.or(found);
    }
    Err(Error::content(path, "is empty; the first line must name the columns"))
}

fn read_lines<R: BufRead>(lines: &mut Lines<R>) -> Result<Packing> {
    let mut cell = None;
    let mut columns = None;
    let mut grains: Vec<(PackedGrain, usize)> = Vec::new();
    // Materials by id, since grains may stand in any order.
    let mut materials = PackedMaterials::default();
    let mut of: Vec<(u64, u8)> = Vec::new();
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
        if cell.is_none() {
            let message = "the periodic cell is not given".to_string();
            return Err(lines.error(0..0, message).with_help(cell::EXAMPLE).into());
        }
        let grain = columns.grain(lines)?;
        if let Some(place) = columns.material {
            of.push((grain.id, material(lines, grain.id, place, &mut materials)?));
        }
        grains.push((grain, lines.number()));
    }
    let Some((origin, cell)) = cell else {
        let message = "is not a packing: it needs a cell and grains";
        return Err(Error::content(Path::new(lines.file()), message));
    };
    let packing = Packing::checked(lines.file(), origin, cell, grains)?;
    of.sort_unstable();
    Ok(Packing { materials: materials.in_order(of.into_iter().map(|(_, material)| material)), ..packing })
}

/// The material that a row names.
fn material<R: BufRead>(
    lines: &Lines<R>,
    id: u64,
    place: usize,
    materials: &mut PackedMaterials,
) -> Result<u8> {
    let Some((start, name)) = lines.cells().nth(place) else { return Ok(0) };
    let wrong = |what: &str| {
        let message = format!("grain {id}: material = {name:?} {what}");
        Error::from(lines.cell_error(start, name, message))
    };
    if !is_material_name(name) {
        return Err(wrong("is not a name of letters, digits, - and _"));
    }
    materials.place(name).ok_or_else(|| wrong("is one material too many"))
}

/// Positions of the five columns.
struct Columns {
    header: Vec<String>,
    places: [usize; 5],
    /// Where the names of materials are, if there are any.
    material: Option<usize>,
}

impl Columns {
    const NAMES: [&'static str; 5] = ["id", "x", "y", "z", "radius"];

    fn from_header<R: BufRead>(lines: &Lines<R>) -> Result<Columns> {
        let header = names(lines)?;
        let mut places = [0; 5];
        for (place, name) in places.iter_mut().zip(Self::NAMES) {
            *place = position(lines.file(), &header, name)?;
        }
        let material = header.iter().position(|name| name == "material");
        Ok(Columns { header, places, material })
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
            let message = format!("id = {text:?} is not a whole number from 1");
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
