//! Forces that pull in every row, although the grains overlap.

use super::options::{ContactForces, ContactOptions};
use super::row::Row;
use super::table::{ContactTable, Outcome};
use crate::formats::remark::Remark;
use crate::packing::{Implausible, ImplausiblePlace};

pub(super) fn check(table: &ContactTable, mut rows: Vec<Row>, remarks: &mut Vec<Remark>) -> Outcome {
    // Without radii every pair counts as one that overlaps.
    let overlaps = |row: &&Row| row.gap().is_none_or(|gap| gap < -table.rounding);
    let normal = |row: &Row| row.forces().0.filter(|force| *force != 0.0);
    let mut normals = rows.iter().filter(overlaps).filter_map(normal).peekable();
    if normals.peek().is_none() || normals.any(|force| force > 0.0) {
        return Ok(rows);
    }
    let what = match rows.iter().any(|row| row.radii.is_some()) {
        true => "every pair that overlaps is in tension",
        false => "every pair is in tension",
    };
    match table.options.contact_forces {
        Some(ContactForces::AsGiven) => {
            remarks.push(Remark::doubtful(format!("{what}; the forces count as they are")));
        }
        Some(ContactForces::Reversed) => {
            rows.iter_mut().for_each(reverse);
            remarks.push(Remark::set_right(format!("{what}; the forces are turned round")));
        }
        None => {
            let option = ContactOptions::CONTACT_FORCES;
            let message = format!(
                "{what}: the forces are those on the second grain of each pair, or positive in tension, and `--{option} reversed` turns them \
                 round; or the sample is pulled, and `--{option} as-given` says so"
            );
            return Err(Implausible::new(ImplausiblePlace::Contacts, message, ""));
        }
    }
    Ok(rows)
}

fn reverse(row: &mut Row) {
    let pair = &mut row.pair;
    pair.force = pair.force.map(|force| force.map(|x| -x));
    pair.normal_force = pair.normal_force.map(|force| -force);
    pair.tangential_force = pair.tangential_force.map(|force| force.map(|x| -x));
}
