//! Pairs of a table whose grains do not touch.

use granum_core::quantity::format_number;

use super::options::{ContactOptions, PairsApart};
use super::row::Row;
use super::table::{ContactTable, Outcome, count_of};
use crate::formats::remark::Remark;
use crate::packing::{Implausible, ImplausiblePlace};

/// Widest gap across which adhesion and bridges of liquid usually act, in sums of the radii.
const USUAL_GAP: f64 = 0.1;

pub(super) fn check(table: &ContactTable, rows: Vec<Row>, remarks: &mut Vec<Remark>) -> Outcome {
    let all = rows.len();
    remark_on_unknown(&rows, remarks);
    let gap = |row: &Row| row.gap().filter(|gap| *gap > 0.0);
    let (without, rows): (Vec<Row>, Vec<Row>) =
        rows.into_iter().partition(|row| gap(row).is_some() && row.is_without_force());
    if !without.is_empty() {
        remarks.push(Remark::set_right(format!(
            "{} of {all} of the table {} touch and {} no force, as in a list of neighbours, and {} left out",
            count_of(without.len(), "pair", "pairs"),
            if without.len() == 1 { "does not" } else { "do not" },
            if without.len() == 1 { "has" } else { "have" },
            if without.len() == 1 { "is" } else { "are" },
        )));
    }
    if let Some(row) = rows.iter().find(|row| is_across_the_world(row)) {
        return Err(across_the_world(table, row));
    }
    let is_apart = |row: &Row| gap(row).is_some_and(|gap| gap > table.rounding);
    let forces: Vec<&Row> = rows.iter().filter(|row| is_apart(row) && row.has_force()).collect();
    if let Some(widest) = widest(&forces) {
        let text = format!(
            "{} of {} {} a force across a gap, at most {} m between {}: they count as contacts, as bridges of liquid or adhesion make them",
            count_of(forces.len(), "pair", "pairs"),
            rows.len(),
            if forces.len() == 1 { "has" } else { "have" },
            three_digits(widest.gap().unwrap_or(0.0)),
            widest.of_grains(),
        );
        let is_wide = widest.gap().zip(widest.radii).is_some_and(|(gap, radii)| gap > USUAL_GAP * radii);
        remarks.push(if is_wide { Remark::doubtful(text) } else { Remark::set_right(text) });
    }
    without_forces(table, rows, is_apart, remarks)
}

/// Without radii it cannot be seen whether pairs without a force touch.
fn remark_on_unknown(rows: &[Row], remarks: &mut Vec<Remark>) {
    let unknown = rows.iter().filter(|row| row.radii.is_none() && row.is_without_force()).count();
    if unknown > 0 {
        remarks.push(Remark::doubtful(format!(
            "{unknown} of {} pairs of the table have no force, and without radii it cannot be seen whether they touch: they count as contacts",
            rows.len()
        )));
    }
}

/// Pairs that are apart, of whose forces the table says nothing.
fn without_forces(
    table: &ContactTable,
    rows: Vec<Row>,
    is_apart: impl Fn(&Row) -> bool,
    remarks: &mut Vec<Remark>,
) -> Outcome {
    let all = rows.len();
    let (apart, touching): (Vec<Row>, Vec<Row>) =
        rows.iter().copied().partition(|row| is_apart(row) && !row.has_force());
    let views: Vec<&Row> = apart.iter().collect();
    let Some(widest) = widest(&views) else { return Ok(rows) };
    let what = format!(
        "{} of {all} {} touch, by up to {} m between {}",
        count_of(apart.len(), "pair", "pairs"),
        if apart.len() == 1 { "does not" } else { "do not" },
        three_digits(widest.gap().unwrap_or(0.0)),
        widest.of_grains()
    );
    match table.options.pairs_apart {
        Some(PairsApart::Contacts) => {
            remarks.push(Remark::doubtful(format!("{what}; they count as contacts")));
            Ok(rows)
        }
        Some(PairsApart::NoContacts) => {
            remarks.push(Remark::set_right(format!("{what}; they are left out")));
            Ok(touching)
        }
        None => {
            let option = ContactOptions::PAIRS_APART;
            let message = format!(
                "{what}, and the table has no forces: `--{option} no-contacts` leaves them out, as those of a list of neighbours, and \
                 `--{option} contacts` counts them, as bridges"
            );
            Err(Implausible::new(ImplausiblePlace::Contacts, message, ""))
        }
    }
}

/// True if the centres of a pair are more than twice as far apart as those of grains that touch.
fn is_across_the_world(row: &Row) -> bool {
    row.gap().zip(row.radii).is_some_and(|(gap, radii)| gap > radii)
}

fn across_the_world(table: &ContactTable, row: &Row) -> Implausible {
    let distance = row.gap().zip(row.radii).map_or(0.0, |(gap, radii)| (gap + radii) / radii);
    let remedy = if table.has_cell() {
        "grains and contacts are not of one instant, count their ids from another number, or are of another cell".to_string()
    } else {
        "if they touch across a periodic boundary, `--cell \"A, B, C\"` gives the cell; else grains and contacts are not of one instant, or \
         count their ids from another number"
            .to_string()
    };
    let message =
        format!("is one of centres that are {} sums of the radii apart: {remedy}", three_digits(distance));
    Implausible::new(ImplausiblePlace::Contact(row.number), message, "")
}

fn widest<'r>(rows: &[&'r Row]) -> Option<&'r Row> {
    let gap = |row: &Row| row.gap().unwrap_or(0.0);
    rows.iter().copied().max_by(|one, two| gap(one).total_cmp(&gap(two)))
}

pub(super) fn three_digits(value: f64) -> String {
    format!("{value:.2e}").parse().map_or_else(|_| value.to_string(), format_number)
}
