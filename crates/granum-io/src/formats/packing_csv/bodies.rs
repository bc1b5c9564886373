//! Columns of packings whose grains have several pieces. Each row is a piece: `id`, `x`, `y`, `z` and `radius` are its own, and
//!
//! - `body`: the id of its grain, from 1;
//! - `body_x`, `body_y`, `body_z`: the centre of mass of the grain, m, and `body_radius` the radius of the sphere of its volume, m;
//! - `orientation_w`, `orientation_x`, `orientation_y`, `orientation_z`: the rotation from its principal axes to those of space;
//! - `inertia_over_mass_1`, `_2`, `_3`: its principal moments of inertia over its mass, m2;
//! - `arm_x`, `arm_y`, `arm_z`: from the centre of the grain to that of the piece, in the axes of space, m.
//!
//! Without all but one column, as `body` or `clump`, the bodies are [put together](crate::formats) from their spheres. With them all,
//! a grain that is one sphere has one row, whose arm is zero. All of this is read back bit for bit; the places of the pieces must agree
//! with it, but for images.

use std::collections::BTreeMap;
use std::io::Write;

use granum_core::geometry::{Matrix, Vector, apply, invert, length};
use granum_core::quantity::format_number;
use granum_core::rotation::IDENTITY;

use crate::error::{Result, in_file};
use crate::formats::grain_table::names::names_of_bodies;
use crate::packing::{PackedBody, PackedGrain, PackedPiece, Packing, check_ids};
use crate::sheet::{Rows as SheetRows, Sheet};

/// The column by which a packing has bodies, and the others.
const BODY: &str = "body";
const OF_BODY: [&str; 11] = [
    "body_x",
    "body_y",
    "body_z",
    "body_radius",
    "orientation_w",
    "orientation_x",
    "orientation_y",
    "orientation_z",
    "inertia_over_mass_1",
    "inertia_over_mass_2",
    "inertia_over_mass_3",
];
const ARM: [&str; 3] = ["arm_x", "arm_y", "arm_z"];
/// Largest distance of a piece from the end of its arm, as a share of its radius.
const AGREEMENT: f64 = 1e-6;

/// What the rows of a body have in common: centre, radius, orientation and moments, in the order of the columns.
type OfBody = [f64; OF_BODY.len()];

/// One row.
pub(super) struct Row {
    body: u64,
    of_body: OfBody,
    arm: Vector,
}

/// True if a column gives the body of each sphere and the columns that describe bodies are missing, so that these follow from the spheres.
pub(super) fn are_only_named(header: &[String]) -> bool {
    let has = |name: &str| header.iter().any(|known| known.eq_ignore_ascii_case(name));
    names_of_bodies().any(has) && !OF_BODY.iter().any(|name| has(name))
}

/// Where the further columns stand: `body`, then the others in their order.
pub(super) struct Further {
    pub(super) places: Vec<usize>,
}

impl Further {
    /// The columns, if the file has bodies.
    pub(super) fn from_header(sheet: &Sheet) -> Result<Option<Further>> {
        if !sheet.header().iter().any(|name| name == BODY) {
            return Ok(None);
        }
        let mut places = vec![sheet.position(BODY)?];
        for name in OF_BODY.iter().chain(&ARM) {
            places.push(sheet.position(name)?);
        }
        Ok(Some(Further { places }))
    }

    /// What a row says of the body of a piece.
    pub(super) fn row(&self, rows: &SheetRows, piece: &PackedGrain) -> Result<Row> {
        let (place, text) = (self.places[0], rows.cell(self.places[0]));
        let Some(body) = text.parse().ok().filter(|body| *body > 0u64) else {
            let message = format!("grain {}: body = {text:?} is not a whole number from 1", piece.id);
            return Err(rows.cell_error(place, message).into());
        };
        let mut values = [0.0; OF_BODY.len() + ARM.len()];
        for ((value, place), name) in values.iter_mut().zip(&self.places[1..]).zip(OF_BODY.iter().chain(&ARM))
        {
            *value = rows.number(*place, name)?;
            if !value.is_finite() {
                let message = format!("body {body}: {name} = {} must be finite", rows.cell(*place));
                return Err(rows.cell_error(*place, message).into());
            }
        }
        let of_body = std::array::from_fn(|k| values[k]);
        Ok(Row { body, of_body, arm: std::array::from_fn(|a| values[OF_BODY.len() + a]) })
    }
}

/// The row and the line of each piece of a body, by the id of the piece.
type PiecesById<'a> = BTreeMap<u64, (&'a Row, &'a (PackedGrain, usize))>;

/// The rows of a file.
#[derive(Default)]
pub(super) struct Rows(Vec<Row>);

impl Rows {
    pub(super) fn push(&mut self, row: Row) {
        self.0.push(row);
    }

    /// The packing of the pieces of these rows, and the materials of its grains by the ids of their pieces; `pieces` are given in the order of
    /// the rows.
    pub(super) fn packing(
        self,
        file: &str,
        (origin, cell): (Vector, Matrix),
        pieces: Vec<(PackedGrain, usize)>,
        materials: Vec<(u64, u8)>,
    ) -> Result<(Packing, Vec<u8>)> {
        check_ids(file, pieces.clone())?;
        let material: BTreeMap<u64, u8> = materials.into_iter().collect();
        // The pieces of each body in the order of their ids.
        let mut of: BTreeMap<u64, PiecesById> = BTreeMap::new();
        for (row, piece) in self.0.iter().zip(&pieces) {
            of.entry(row.body).or_default().insert(piece.0.id, (row, piece));
        }
        let (mut grains, mut bodies, mut of_grains) = (Vec::new(), Vec::new(), Vec::new());
        for (id, members) in &of {
            let Some((_, (first, (piece, line)))) = members.first_key_value() else { continue };
            let [x, y, z, radius, w, i, j, k, inertia @ ..] = first.of_body;
            for (row, (piece, line)) in members.values() {
                check_row(file, &cell, first, row, piece, *line)?;
            }
            if members.len() > 1 {
                let sphere = |(row, (piece, _)): &(&Row, &(PackedGrain, usize))| PackedPiece {
                    arm: row.arm,
                    radius: piece.radius,
                };
                bodies.push(PackedBody {
                    grain: grains.len(),
                    orientation: [w, i, j, k],
                    inertia_over_mass: inertia,
                    pieces: members.values().map(sphere).collect(),
                });
            }
            of_grains.extend(material.get(&piece.id));
            grains.push((PackedGrain { id: *id, position: [x, y, z], radius }, *line));
        }
        Ok((Packing::checked_bodies(file, origin, cell, grains, bodies)?, of_grains))
    }
}

/// Refuses a row that says something else of its body than the first one of that body, or of its place than its arm.
fn check_row(
    file: &str,
    cell: &Matrix,
    first: &Row,
    row: &Row,
    piece: &PackedGrain,
    line: usize,
) -> Result<()> {
    if let Some(k) = (0..OF_BODY.len()).find(|k| first.of_body[*k].to_bits() != row.of_body[*k].to_bits()) {
        let message = format!(
            "body {}: {} is {} here and {} in its first row",
            row.body, OF_BODY[k], row.of_body[k], first.of_body[k]
        );
        return Err(in_file(file, line, message, "all rows of a body say the same of it"));
    }
    if row.of_body[3] <= 0.0 {
        let message = format!("body {}: body_radius = {} must be positive", row.body, row.of_body[3]);
        return Err(in_file(file, line, message, "it is the radius of the sphere of its volume"));
    }
    let apart: Vector = std::array::from_fn(|a| piece.position[a] - (row.of_body[a] + row.arm[a]));
    let images = apply(&invert(cell), apart).map(f64::round);
    let whole = apply(cell, images);
    let rest: Vector = std::array::from_fn(|a| apart[a] - whole[a]);
    if length(&rest) > AGREEMENT * piece.radius {
        let message = format!(
            "grain {}: its place is not at the end of its arm from the centre of body {}",
            piece.id, row.body
        );
        return Err(in_file(
            file,
            line,
            message,
            "x, y, z are body_x, body_y, body_z plus arm_x, arm_y, arm_z, or an image of that place",
        ));
    }
    Ok(())
}

/// Writes the header and a row for each piece.
pub(super) fn write(file: &mut impl Write, packing: &Packing) -> std::io::Result<()> {
    let named = !packing.materials.of.is_empty();
    let further: Vec<&str> = [BODY].into_iter().chain(OF_BODY).chain(ARM).collect();
    let material = if named { ",material" } else { "" };
    writeln!(file, "id,x,y,z,radius,{}{material}", further.join(","))?;
    let inverse = invert(&packing.cell);
    let mut bodies = packing.bodies.iter().peekable();
    let mut id = 0;
    for (at, grain) in packing.grains.iter().enumerate() {
        let body = bodies.next_if(|body| body.grain == at);
        let (orientation, inertia, pieces) = match body {
            Some(body) => (body.orientation, body.inertia_over_mass, body.pieces.clone()),
            None => {
                let sphere = PackedPiece { arm: [0.0; 3], radius: grain.radius };
                (IDENTITY, [0.4 * grain.radius * grain.radius; 3], vec![sphere])
            }
        };
        let of_body: Vec<f64> = [&grain.position[..], &[grain.radius], &orientation, &inertia].concat();
        for piece in pieces {
            id += 1;
            let place = match body {
                Some(_) => inside(packing, &inverse, grain, &piece),
                None => grain.position,
            };
            write!(file, "{id}")?;
            let own = place.iter().chain([&piece.radius]);
            own.copied().try_for_each(|x| write!(file, ",{}", format_number(x)))?;
            write!(file, ",{}", grain.id)?;
            let rest = of_body.iter().chain(&piece.arm);
            rest.copied().try_for_each(|x| write!(file, ",{}", format_number(x)))?;
            match packing.materials.name(at) {
                Some(name) => writeln!(file, ",{name}")?,
                None => writeln!(file)?,
            }
        }
    }
    Ok(())
}

/// The place of a piece in the cell.
fn inside(packing: &Packing, inverse: &Matrix, grain: &PackedGrain, piece: &PackedPiece) -> Vector {
    let from_corner: Vector = std::array::from_fn(|a| grain.position[a] + piece.arm[a] - packing.origin[a]);
    let back = apply(&packing.cell, apply(inverse, from_corner).map(f64::floor));
    std::array::from_fn(|a| packing.origin[a] + (from_corner[a] - back[a]))
}
