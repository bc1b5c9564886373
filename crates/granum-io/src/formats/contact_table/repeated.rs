//! Pairs that stand in a table more than once, in one direction or in both.

use std::collections::HashMap;

use granum_core::assembly::Vector;
use granum_core::geometry::length;

use super::options::{ContactOptions, RepeatedPairs};
use super::row::Row;
use super::table::{ContactTable, Outcome, count_of};
use crate::formats::remark::Remark;
use crate::packing::{Implausible, ImplausiblePlace};

/// Largest difference of two forces that are one, of the larger: files have six digits at least.
const ROUNDING: f64 = 1e-4;

pub(super) fn check(table: &ContactTable, rows: Vec<Row>, remarks: &mut Vec<Remark>) -> Outcome {
    let mut first_of: HashMap<[usize; 2], Vec<usize>> = HashMap::new();
    let mut kept: Vec<Row> = Vec::with_capacity(rows.len());
    let (mut equal, mut reversed, mut different) = (0, 0, 0);
    for row in rows {
        let [i, j] = row.grains;
        let others = first_of.entry([i.min(j), i.max(j)]).or_default();
        let same = others.iter().copied().find(|at| is_same_image(&kept[*at], &row));
        let Some(at) = same else {
            others.push(kept.len());
            kept.push(row);
            continue;
        };
        if kept[at].grains != row.grains {
            reversed += 1;
        }
        if have_one_force(&kept[at], &row) {
            equal += 1;
            continue;
        }
        different += 1;
        match table.options.repeated_pairs {
            Some(RepeatedPairs::First) => {}
            Some(RepeatedPairs::Sum) => add(&mut kept[at], &row),
            None => return Err(undecided(&row)),
        }
    }
    let directions = if reversed > 0 { ", in both directions" } else { "" };
    if equal > 0 {
        let rows = count_of(equal, "row repeats", "rows repeat");
        remarks.push(Remark::set_right(format!(
            "{rows} a pair that stands in the table before{directions}, and each pair counts once"
        )));
    }
    if different > 0 {
        let what = match table.options.repeated_pairs {
            Some(RepeatedPairs::First) => "the first row of each pair counts",
            _ => "the forces of each pair are added",
        };
        let rows = count_of(different, "row repeats", "rows repeat");
        remarks.push(Remark::doubtful(format!("{rows} a pair{directions} with another force; {what}")));
    }
    Ok(kept)
}

fn undecided(row: &Row) -> Implausible {
    let message = format!(
        "stands in the table before with another force; `--{0} first` takes the first row of each pair, and `--{0} sum` adds the forces",
        ContactOptions::REPEATED_PAIRS
    );
    Implausible::new(ImplausiblePlace::Contact(row.number), message, "")
}

/// In a small cell two grains may touch through several images of the cell, which their branches tell.
fn is_same_image(one: &Row, two: &Row) -> bool {
    let sign = if one.grains == two.grains { 1.0 } else { -1.0 };
    let difference: Vector = std::array::from_fn(|a| one.branch[a] - sign * two.branch[a]);
    length(&difference) <= 0.1 * length(&one.branch)
}

/// True if two rows of a pair say the same of its force: action and reaction, if they name the grains in different orders.
fn have_one_force(one: &Row, two: &Row) -> bool {
    let (normal, tangential) = one.forces();
    let (other_normal, mut other_tangential) = two.forces();
    if one.grains != two.grains {
        other_tangential = other_tangential.map(|force| force.map(|x| -x));
    }
    let size = |normal: Option<f64>, tangential: Option<Vector>| {
        normal.unwrap_or(0.0).abs() + tangential.map_or(0.0, |force| length(&force))
    };
    let allowed = ROUNDING * size(normal, tangential).max(size(other_normal, other_tangential));
    let normals = match (normal, other_normal) {
        (Some(a), Some(b)) => (a - b).abs() <= allowed,
        (a, b) => a.is_none() && b.is_none(),
    };
    let tangentials = match (tangential, other_tangential) {
        (Some(a), Some(b)) => length(&std::array::from_fn(|k| a[k] - b[k])) <= allowed,
        (a, b) => a.is_none() && b.is_none(),
    };
    normals && tangentials
}

/// Adds the force of another row of the same pair.
fn add(into: &mut Row, row: &Row) {
    let (Some(one), Some(two)) = (whole_force(into), whole_force(row)) else { return };
    let sign = if into.grains == row.grains { 1.0 } else { -1.0 };
    into.pair.force = Some(std::array::from_fn(|a| one[a] + sign * two[a]));
}

/// The whole force on the first grain, as far as a row has it.
fn whole_force(row: &Row) -> Option<Vector> {
    if let Some(force) = row.pair.force {
        return Some(force);
    }
    let (normal, tangential) = row.forces();
    let along = row.pair.normal.unwrap_or_else(|| row.branch.map(|x| x / length(&row.branch)));
    let tangential = tangential.unwrap_or_default();
    normal.map(|normal| std::array::from_fn(|a| tangential[a] - normal * along[a]))
}
