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
//!
//! Where grains have several pieces, each row is a piece with its number as `id`, and [further columns](bodies) say of which body it is.

mod bodies;
pub(super) mod cell;

use std::io::{BufRead, Write};
use std::path::Path;

use granum_core::quantity::format_number;

use crate::atomic::write_atomically;
use crate::error::{Error, Result};
use crate::formats::grain_table::GrainTable;
use crate::formats::join::join;
use crate::formats::{JoinOptions, PackingFormat, ReadOptions, ResultFormat};
use crate::material_name::is_material_name;
use crate::packing::{PackedGrain, PackedMaterials, Packing};
use crate::sheet::{Rows, Sheet, Sought};

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
        cell::is_given(head)
    }
    fn read(&self, path: &Path) -> Result<Packing> {
        if bodies::are_only_named(&cell::cell_and_names(path)?.1) {
            return put_together(path);
        }
        with_header(|sought| packing(&Sheet::open(path, sought)?))
    }
    fn write(&self, path: &Path, packing: &Packing) -> Result<()> {
        write_atomically(path, |file| {
            writeln!(file, "{}", cell::text(&packing.origin, &packing.cell))?;
            if !packing.bodies.is_empty() {
                return bodies::write(file, packing);
            }
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

/// The packing of a file that says which spheres are one body, and no more of the bodies.
fn put_together(path: &Path) -> Result<Packing> {
    let frames = GrainTable.read(path, &ReadOptions::default())?;
    match join(vec![(path.to_path_buf(), frames)], &JoinOptions::default())?.pop() {
        Some(found) => found.packing(path),
        None => Err(Error::content(path, "has no grains")),
    }
}

/// Reads and checks a packing from any reader of text; `file` is its name for messages.
///
/// # Errors
/// As for [`Packing::checked`]; also [`Error::Input`] for a missing cell and for text that is not a number.
pub fn read_from(reader: impl BufRead, file: &str) -> Result<Packing> {
    with_header(|sought| packing(&Sheet::read(reader, file, sought)?))
}

/// Reads what has a header with the columns of a packing.
fn with_header<T>(read: impl FnOnce(&Sought) -> Result<T>) -> Result<T> {
    let is_name = |cell: &str| Columns::NAMES.contains(&cell);
    read(&Sought { is_name: &is_name, count: Columns::NAMES.len(), may_have_units: false })
}

fn packing(sheet: &Sheet) -> Result<Packing> {
    let columns = Columns::from_header(sheet)?;
    let Some((origin, cell)) = cell::cell_of(sheet, sheet.comments())? else {
        let message = "the periodic cell is not given".to_string();
        return Err(sheet.whole_header_error(message).with_help(cell::EXAMPLE).into());
    };
    let further = bodies::Further::from_header(sheet)?;
    let mut gathered = bodies::Rows::default();
    let mut grains: Vec<(PackedGrain, usize)> = Vec::new();
    // Materials by id, since grains may stand in any order.
    let mut materials = PackedMaterials::default();
    let mut of: Vec<(u64, u8)> = Vec::new();
    let needed = [&columns.places[..], further.as_ref().map_or(&[], |further| &further.places[..])].concat();
    let mut rows = sheet.rows(&needed)?;
    while rows.advance()? {
        let grain = columns.grain(&rows)?;
        if let Some(place) = columns.material {
            of.push((grain.id, material(&rows, grain.id, place, &mut materials)?));
        }
        if let Some(further) = &further {
            gathered.push(further.row(&rows, &grain)?);
        }
        grains.push((grain, rows.line()));
    }
    if further.is_some() {
        let (packing, of) = gathered.packing(sheet.file(), (origin, cell), grains, of)?;
        return Ok(Packing { materials: materials.in_order(of.into_iter()), ..packing });
    }
    let packing = Packing::checked(sheet.file(), origin, cell, grains)?;
    of.sort_unstable();
    Ok(Packing { materials: materials.in_order(of.into_iter().map(|(_, material)| material)), ..packing })
}

/// The material that a row names.
fn material(rows: &Rows, id: u64, place: usize, materials: &mut PackedMaterials) -> Result<u8> {
    let name = rows.cell(place);
    let wrong = |what: &str| {
        let message = format!("grain {id}: material = {name:?} {what}");
        Error::from(rows.cell_error(place, message))
    };
    if !is_material_name(name) {
        return Err(wrong("is not a name of letters, digits, - and _"));
    }
    materials.place(name).ok_or_else(|| wrong("is one material too many"))
}

/// Positions of the five columns.
struct Columns {
    places: [usize; 5],
    /// Where the names of materials are, if there are any.
    material: Option<usize>,
}

impl Columns {
    const NAMES: [&'static str; 5] = ["id", "x", "y", "z", "radius"];

    fn from_header(sheet: &Sheet) -> Result<Columns> {
        let mut places = [0; 5];
        for (place, name) in places.iter_mut().zip(Self::NAMES) {
            *place = sheet.position(name)?;
        }
        let material = sheet.header().iter().position(|name| name == "material");
        Ok(Columns { places, material })
    }

    fn grain(&self, rows: &Rows) -> Result<PackedGrain> {
        let [id_place, numbers @ ..] = self.places;
        let text = rows.cell(id_place);
        let id: u64 = text.parse().ok().filter(|id| *id > 0).ok_or_else(|| {
            let message = format!("id = {text:?} is not a whole number from 1");
            Error::from(rows.cell_error(id_place, message))
        })?;
        let mut values = [0.0; 4];
        for ((value, place), name) in values.iter_mut().zip(numbers).zip(&Self::NAMES[1..]) {
            *value = rows.number(place, name)?;
            let wrong = if !value.is_finite() {
                "must be finite"
            } else if *name == "radius" && *value <= 0.0 {
                "must be positive"
            } else {
                continue;
            };
            let message = format!("grain {id}: {name} = {} {wrong}", rows.cell(place));
            return Err(rows.cell_error(place, message).into());
        }
        let [x, y, z, radius] = values;
        Ok(PackedGrain { id, position: [x, y, z], radius })
    }
}
