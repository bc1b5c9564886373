//! Pairs of grains that overlap and that a table lacks.

use std::collections::HashSet;

use granum_core::Part;
use granum_core::assembly::Vector;

use super::apart::three_digits;
use super::options::{ContactOptions, MissingPairs};
use super::row::{Row, radii_of};
use super::table::{ContactTable, Outcome, count_of};
use crate::formats::remark::Remark;
use crate::formats::result::FileContact;
use crate::packing::near::{NearGrains, Neighbour};
use crate::packing::{Implausible, ImplausiblePlace};

/// A table lacks something only if an overlap that it lacks is larger than this part of the median of its own: programs find contacts a step
/// before they move grains.
const NOTABLE: f64 = 0.1;

pub(super) fn check(table: &ContactTable, mut rows: Vec<Row>, remarks: &mut Vec<Remark>) -> Outcome {
    if !table.parts.has(Part::Radii) {
        return Ok(rows);
    }
    let missing = missing_pairs(table, &rows);
    let overlap = |pair: &(usize, Neighbour)| pair.1.overlap;
    let Some((first, largest)) = missing.iter().copied().max_by(|a, b| overlap(a).total_cmp(&overlap(b)))
    else {
        return Ok(rows);
    };
    if largest.overlap <= table.rounding.max(NOTABLE * median_overlap(&rows)) {
        return Ok(rows);
    }
    let id = |grain: usize| table.assembly.bodies[grain].id;
    let what = format!(
        "{} {} that {} not in the table, the grains {} and {} by {} m",
        count_of(missing.len(), "pair of grains", "pairs of grains"),
        if missing.len() == 1 { "overlaps" } else { "overlap" },
        if missing.len() == 1 { "is" } else { "are" },
        id(first),
        id(largest.grain),
        three_digits(largest.overlap),
    );
    match table.options.missing_pairs {
        Some(MissingPairs::NoContacts) => {
            remarks.push(Remark::doubtful(format!("{what}; they do not count as contacts")));
        }
        Some(MissingPairs::WithoutForce) => {
            remarks.push(Remark::doubtful(format!("{what}; they count as contacts without a force")));
            let number = rows.len();
            rows.extend(missing.iter().map(|pair| without_force(table, number, pair)));
        }
        None => {
            let option = ContactOptions::MISSING_PAIRS;
            let message = format!(
                "{what}: is the table whole, and of the same instant? `--{option} without-force` counts them as contacts without a force, and \
                 `--{option} no-contacts` does not count them"
            );
            return Err(Implausible::new(ImplausiblePlace::Contacts, message, ""));
        }
    }
    Ok(rows)
}

/// The pairs that overlap by more than rounding, are not of one body, and are not in the table.
fn missing_pairs(table: &ContactTable, rows: &[Row]) -> Vec<(usize, Neighbour)> {
    let pieces = &table.assembly.pieces;
    let positions: Vec<Vector> = pieces.iter().map(|piece| piece.position).collect();
    let radii: Vec<f64> = pieces.iter().map(|piece| piece.radius).collect();
    let listed: HashSet<[usize; 2]> =
        rows.iter().map(|row| row.grains).map(|[i, j]| [i.min(j), i.max(j)]).collect();
    let near = NearGrains::new(table.has_cell().then_some(&table.assembly.cell), &positions, &radii);
    let mut missing = near.touching(table.rounding);
    missing.retain(|(at, near)| {
        let body = (table.body_of)(*at);
        !listed.contains(&[*at, near.grain]) && (body.is_none() || body != (table.body_of)(near.grain))
    });
    missing
}

/// Median of the overlaps of the rows, m.
fn median_overlap(rows: &[Row]) -> f64 {
    let mut overlaps: Vec<f64> =
        rows.iter().filter_map(|row| row.gap().map(|gap| -gap)).filter(|overlap| *overlap > 0.0).collect();
    let middle = overlaps.len() / 2;
    if overlaps.is_empty() {
        return 0.0;
    }
    *overlaps.select_nth_unstable_by(middle, f64::total_cmp).1
}

fn without_force(table: &ContactTable, number: usize, (at, near): &(usize, Neighbour)) -> Row {
    let grains = [*at, near.grain];
    let [first, second] = grains.map(|grain| table.assembly.bodies[grain].id);
    let pair = FileContact {
        first,
        second,
        branch: Some(near.branch),
        force: Some([0.0; 3]),
        ..FileContact::default()
    };
    Row { number, pair, grains, branch: near.branch, radii: Some(radii_of(table.assembly, grains)) }
}
