//! What a snapshot holds beyond its tables of grains and contacts where grains have several pieces: `NAME.pieces.parquet`, and further
//! columns of the other two.

use std::ops::Range;
use std::path::Path;

use granum_core::assembly::{Assembly, Body, Contact, Piece, Rigid};
use granum_core::{Column, ColumnKind, Table};

use crate::error::{Error, Result};

/// The ending of the file of the pieces.
pub(crate) const FILE: &str = "pieces.parquet";

/// The columns of grains: of the number of pieces, the orientation and the principal moments of inertia.
const PIECES: &str = "pieces";
const ORIENTATION: [&str; 4] = ["orientation_w", "orientation_x", "orientation_y", "orientation_z"];
const INERTIA: [&str; 3] = ["principal_inertia_1", "principal_inertia_2", "principal_inertia_3"];
/// The columns of pieces: the id of the grain, the centre, the radius, and the arm from the centre of the grain.
const GRAIN: &str = "grain";
const POSITION: [&str; 3] = ["position_x", "position_y", "position_z"];
const RADIUS: &str = "radius";
const ARM: [&str; 3] = ["arm_x", "arm_y", "arm_z"];
/// The columns of contacts: the pieces of their grains that touch, counted from 0 on each grain.
const CONTACT: [&str; 2] = ["first_piece", "second_piece"];

fn whole_numbers(name: &str, values: Vec<f64>) -> Column {
    Column::new(name, "", values).of_kind(ColumnKind::Integer)
}

/// The first piece of each body.
fn first_pieces(assembly: &Assembly) -> Vec<usize> {
    let mut first = vec![0; assembly.bodies.len()];
    for (k, piece) in assembly.pieces.iter().enumerate().rev() {
        if let Some(first) = first.get_mut(piece.body) {
            *first = k;
        }
    }
    first
}

/// The further columns of grains. A sphere has no orientation, which stands as no rotation, and one piece.
pub(super) fn columns_of_grains(assembly: &Assembly, rows: Range<usize>) -> Vec<Column> {
    let mut count = vec![0.0; assembly.bodies.len()];
    for piece in &assembly.pieces {
        if let Some(count) = count.get_mut(piece.body) {
            *count += 1.0;
        }
    }
    let bodies = &assembly.bodies[rows.clone()];
    let rigid = |body: &Body| body.rigid.and_then(|rigid| assembly.rigid.get(rigid as usize));
    let orientation = |body: &Body, k| rigid(body).map_or([1.0, 0.0, 0.0, 0.0][k], |own| own.orientation[k]);
    let inertia = |body: &Body, k: usize| rigid(body).map_or(0.0, |own| own.inertia[k]);
    let mut columns = vec![whole_numbers(PIECES, count[rows].to_vec())];
    columns.extend(
        (0..4).map(|k| {
            Column::new(ORIENTATION[k], "", bodies.iter().map(|body| orientation(body, k)).collect())
        }),
    );
    columns.extend(
        (0..3)
            .map(|k| Column::new(INERTIA[k], "kg m2", bodies.iter().map(|body| inertia(body, k)).collect())),
    );
    columns
}

/// The further columns of contacts.
pub(super) fn columns_of_contacts(assembly: &Assembly, contacts: &[Contact]) -> Vec<Column> {
    let first = first_pieces(assembly);
    let place = |piece: usize| {
        let body = assembly.body_of(piece).and_then(|body| first.get(body));
        body.map_or(0.0, |first| (piece - first) as f64)
    };
    let ends: [fn(&Contact) -> usize; 2] = [|contact| contact.i, |contact| contact.j];
    (CONTACT.iter().zip(ends))
        .map(|(name, end)| whole_numbers(name, contacts.iter().map(|contact| place(end(contact))).collect()))
        .collect()
}

/// The table of the pieces of some rows.
pub(super) fn table(assembly: &Assembly, rows: Range<usize>) -> Result<Table> {
    let pieces = &assembly.pieces[rows];
    let id = |piece: &Piece| assembly.bodies.get(piece.body).map_or(0.0, |body| body.id as f64);
    let mut columns = vec![whole_numbers(GRAIN, pieces.iter().map(id).collect())];
    columns.extend(
        (0..3).map(|a| Column::new(POSITION[a], "m", pieces.iter().map(|piece| piece.position[a]).collect())),
    );
    columns.push(Column::new(RADIUS, "m", pieces.iter().map(|piece| piece.radius).collect()));
    columns
        .extend((0..3).map(|a| Column::new(ARM[a], "m", pieces.iter().map(|piece| piece.arm[a]).collect())));
    Ok(Table::new(columns)?)
}

/// Adds what the table of grains says of bodies of several pieces.
pub(super) fn add_rigid(path: &Path, table: &Table, assembly: &mut Assembly) -> Result<()> {
    let orientation = table.select(ORIENTATION)?;
    let inertia = table.select(INERTIA)?;
    let count = table.column(PIECES)?;
    for (row, body) in assembly.bodies.iter_mut().enumerate() {
        if count[row] == 1.0 {
            continue;
        }
        let rigid = Rigid {
            orientation: std::array::from_fn(|k| orientation[k][row]),
            inertia: std::array::from_fn(|k| inertia[k][row]),
        };
        let length: f64 = rigid.orientation.iter().map(|x| x * x).sum();
        if (length - 1.0).abs() > 1e-9 || rigid.inertia.iter().any(|moment| *moment <= 0.0) {
            let message = format!(
                "row {}: the orientation {:?} must have length 1 and the moments of inertia {:?} must be positive",
                row + 1,
                rigid.orientation,
                rigid.inertia
            );
            return Err(Error::content(path, message));
        }
        body.rigid = Some(assembly.rigid.len() as u32);
        assembly.rigid.push(rigid);
    }
    Ok(())
}

/// Adds the pieces of a table, which stand body by body.
pub(super) fn add_pieces(path: &Path, table: &Table, assembly: &mut Assembly) -> Result<()> {
    let position = table.select(POSITION)?;
    let arm = table.select(ARM)?;
    let (grain, radius) = (table.column(GRAIN)?, table.column(RADIUS)?);
    let mut body = 0;
    for row in 0..table.rows() {
        // The next grain begins, or the same goes on.
        let is = |body: usize| assembly.bodies.get(body).is_some_and(|body| body.id as f64 == grain[row]);
        let first = assembly.pieces.is_empty();
        body = match [body, body + 1].into_iter().find(|&body| is(body)) {
            Some(next) if !first || next == 0 => next,
            _ => {
                let message = format!(
                    "row {}: the pieces of the grain {} are not in the order of the grains",
                    row + 1,
                    grain[row]
                );
                return Err(Error::content(path, message));
            }
        };
        if radius[row] <= 0.0 {
            let message =
                format!("row {}: the radius of a piece is {}; it must be positive", row + 1, radius[row]);
            return Err(Error::content(path, message));
        }
        assembly.pieces.push(Piece {
            body,
            position: std::array::from_fn(|a| position[a][row]),
            radius: radius[row],
            arm: std::array::from_fn(|a| arm[a][row]),
        });
    }
    let last = assembly.pieces.last().map(|piece| piece.body + 1);
    if last.unwrap_or(0) != assembly.bodies.len() {
        return Err(Error::content(path, "has no pieces of the last grains"));
    }
    Ok(())
}

/// The pieces of contacts whose grains are known: those of their places on the grains.
pub(super) fn place_contacts(
    path: &Path,
    table: &Table,
    assembly: &Assembly,
    contacts: &mut [Contact],
) -> Result<()> {
    let first = first_pieces(assembly);
    let places = table.select(CONTACT)?;
    for (row, contact) in contacts.iter_mut().enumerate() {
        for (end, places) in [&mut contact.i, &mut contact.j].into_iter().zip(places) {
            let piece = first[*end] + places[row] as usize;
            if assembly.body_of(piece) != Some(*end) || places[row] < 0.0 {
                let message = format!("row {}: its grain has no piece {}", row + 1, places[row]);
                return Err(Error::content(path, message));
            }
            *end = piece;
        }
    }
    Ok(())
}
