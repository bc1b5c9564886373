//! Branches and normals of a table: they lie along the line of the centres, from the first grain to the second.

use granum_core::assembly::Vector;
use granum_core::geometry::{dot, length};

use super::row::Row;
use super::table::{ContactTable, Outcome, count_of};
use crate::formats::remark::Remark;
use crate::packing::{Implausible, ImplausiblePlace};

/// How far a branch may be from the distance of the centres, in sums of the radii: programs find contacts a step before they move grains.
const FARTHEST: f64 = 0.02;
/// Least cosine of the angle between the normal of two spheres and the line of their centres.
const LEAST_COSINE: f64 = 0.99;

pub(super) fn check(table: &ContactTable, mut rows: Vec<Row>, remarks: &mut Vec<Remark>) -> Outcome {
    if rows.iter().any(|row| length(&row.branch) == 0.0) {
        // Both grains at one place: what adds the contacts refuses it.
        return Ok(rows);
    }
    let turned = check_branches(table, &mut rows)?;
    if turned > 0 {
        let pairs = count_of(turned, "branch points", "branches point");
        remarks.push(Remark::set_right(format!(
            "{pairs} from the second grain to the first, by the places of the grains, and {} turned round",
            if turned == 1 { "is" } else { "are" }
        )));
    }
    check_normals(&mut rows, remarks)?;
    Ok(rows)
}

/// Takes the branches of the table where it has them, and returns how many had to be turned round.
fn check_branches(table: &ContactTable, rows: &mut [Row]) -> Result<usize, Implausible> {
    let mut turned = 0;
    for row in rows.iter_mut() {
        let Some(given) = row.pair.branch else {
            along_the_normal(table, row);
            continue;
        };
        let allowed = FARTHEST * row.radii.unwrap_or_else(|| length(&row.branch)) + table.rounding;
        let differs = |branch: &Vector| {
            let difference = std::array::from_fn(|a| branch[a] - row.branch[a]);
            length(&table.images.nearest(difference))
        };
        let back = given.map(|x| -x);
        if differs(&given) <= allowed || is_of_touching(table, row, &given) {
            row.branch = given;
        } else if differs(&back) <= allowed {
            row.branch = back;
            turned += 1;
        } else {
            let message = format!(
                "has a branch that differs by {:.3e} m from the distance of their centres: grains and contacts are not of one instant, or of \
                 another cell; leave its columns out to take the distance of the centres",
                differs(&given)
            );
            return Err(Implausible::new(ImplausiblePlace::Contact(row.number), message, ""));
        }
    }
    Ok(turned)
}

/// Without a cell a pair may touch across a boundary that is periodic in some directions: its branch is then as long as the radii say.
fn is_of_touching(table: &ContactTable, row: &Row, branch: &Vector) -> bool {
    !table.has_cell() && row.radii.is_some_and(|radii| (length(branch) - radii).abs() < 0.2 * radii)
}

/// Without a cell a pair that is apart may touch across a boundary: normal and overlap say its branch.
fn along_the_normal(table: &ContactTable, row: &mut Row) {
    let (Some(radii), Some(normal), Some(overlap)) = (row.radii, row.pair.normal, row.pair.approach) else {
        return;
    };
    if table.has_cell() || row.gap().is_none_or(|gap| gap <= radii) {
        return;
    }
    row.branch = normal.map(|x| (radii - overlap) * x);
}

fn check_normals(rows: &mut [Row], remarks: &mut Vec<Remark>) -> Result<(), Implausible> {
    let mut turned = 0;
    for row in rows.iter_mut() {
        let Some(normal) = row.pair.normal else { continue };
        let size = length(&normal) * length(&row.branch);
        let cosine = dot(&normal, &row.branch) / size;
        if cosine < -LEAST_COSINE {
            row.pair.normal = Some(normal.map(|x| -x));
            turned += 1;
        } else if cosine < LEAST_COSINE || !cosine.is_finite() {
            let message = format!(
                "has a normal that is no direction along the line of their centres (the cosine of the angle between them is {cosine:.3}): grains \
                 and contacts are not of one instant, or of another cell; leave its columns out to take that line"
            );
            return Err(Implausible::new(ImplausiblePlace::Contact(row.number), message, ""));
        }
    }
    if turned > 0 {
        let normals = count_of(turned, "normal points", "normals point");
        remarks.push(Remark::set_right(format!(
            "{normals} from the second grain to the first, by the places of the grains, and {} turned round; forces count as those on the first",
            if turned == 1 { "is" } else { "are" }
        )));
    }
    Ok(())
}
