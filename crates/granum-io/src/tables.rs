//! An assembly from the tables of another program: what columns there are says which of its parts are known.

use std::path::Path;

use granum_core::assembly::{Assembly, Contact, Grain, Vector};
use granum_core::{Cell, Part, Parts, Table};

use crate::error::{Error, Result};
use crate::formats::read_table;
use crate::snapshot::{CONTACT, Entry, GRAIN, column_names, fill};

/// The part that a column of grains or contacts is, by its name; none for what no sensor reads.
fn part_of(name: &str) -> Option<Part> {
    Some(match name {
        "position" => Part::Positions,
        "velocity" => Part::Velocities,
        "spin" => Part::Spins,
        "radius" => Part::Radii,
        "mass" => Part::Masses,
        "force" => Part::ResultantForces,
        "approach" => Part::Overlaps,
        "normal_force" => Part::NormalForces,
        "tangential_force" => Part::TangentialForces,
        "normal_energy" => Part::ContactEnergies,
        _ => return None,
    })
}

/// Reads grains and contacts from tables with the columns of a snapshot, of which only `id` and the positions, and for contacts
/// `first` and `second`, must be there. The cell is a cuboid with a corner at the origin and these edges, m. A branch, normal or
/// overlap that is not given follows from the places and radii of the grains.
///
/// # Errors
/// If a table cannot be read, lacks one of those columns, or has an id twice or a contact of a grain that is not there.
pub fn read_assembly(grains: &Path, contacts: Option<&Path>, edges: Vector) -> Result<(Assembly, Parts)> {
    if edges.iter().any(|edge| !(edge.is_finite() && *edge > 0.0)) {
        let value = format!("{edges:?}");
        let message = "is not a cell; its three edges must be positive lengths in m".to_string();
        return Err(Error::Value { name: "cell".into(), value, message });
    }
    let table = read_table(grains)?;
    let in_file = |error: granum_core::TableError| Error::content(grains, error.to_string());
    let mut rows = vec![Grain::default(); table.rows()];
    for (grain, id) in rows.iter_mut().zip(table.column("id").map_err(in_file)?) {
        grain.id = whole(grains, "id", *id)?;
    }
    table.column("position_x").map_err(in_file)?;
    let mut parts = Parts::of(&[Part::Cell]);
    parts = fill_known(&mut rows, &GRAIN, &table, parts)?;
    rows.sort_by_key(|grain| grain.id);
    if let Some(pair) = rows.windows(2).find(|pair| pair[0].id == pair[1].id) {
        return Err(Error::content(grains, format!("grain {} occurs twice", pair[0].id)));
    }
    let mut assembly = Assembly { cell: Cell::cuboid(edges).edges, grains: rows, ..Assembly::default() };
    if let Some(path) = contacts {
        parts = read_contacts(path, &edges, &mut assembly, parts)?;
    }
    Ok((assembly, parts))
}

fn read_contacts(path: &Path, edges: &Vector, assembly: &mut Assembly, parts: Parts) -> Result<Parts> {
    let table = read_table(path)?;
    let in_file = |error: granum_core::TableError| Error::content(path, error.to_string());
    let mut contacts = vec![Contact::default(); table.rows()];
    let mut parts = fill_known(&mut contacts, &CONTACT, &table, parts.with(Part::Contacts))?;
    let [first, second] = table.select(["first", "second"]).map_err(in_file)?;
    let grains = &assembly.grains;
    let index = |row: usize, id: f64| {
        let id = whole(path, "the id of a grain", id)?;
        let missing = |_| Error::content(path, format!("row {}: there is no grain {id}", row + 1));
        grains.binary_search_by_key(&id, |grain| grain.id).map_err(missing)
    };
    let sliding = table.values("sliding");
    let given = |name: &str| column_names(name, &CONTACT).iter().all(|name| table.has(name));
    let [branch, normal, overlap] = ["branch", "normal", "approach"].map(given);
    for (row, contact) in contacts.iter_mut().enumerate() {
        (contact.i, contact.j) = (index(row, first[row])?, index(row, second[row])?);
        let (i, j) = (&grains[contact.i], &grains[contact.j]);
        if !branch {
            contact.branch = std::array::from_fn(|a| {
                let apart = j.position[a] - i.position[a];
                apart - edges[a] * (apart / edges[a]).round()
            });
        }
        let length = contact.branch.iter().map(|x| x * x).sum::<f64>().sqrt();
        if !normal && length > 0.0 {
            contact.normal = contact.branch.map(|x| x / length);
        }
        if !overlap {
            contact.approach = i.radius + j.radius - length;
        }
        contact.sliding = sliding.is_some_and(|sliding| sliding[row] != 0.0);
    }
    if sliding.is_some() {
        parts = parts.with(Part::Sliding);
    }
    if parts.has(Part::Radii) {
        parts = parts.with(Part::Overlaps);
    }
    assembly.contacts = contacts;
    Ok(parts)
}

/// Reads the columns that the table has, and adds the corresponding parts.
fn fill_known<T>(rows: &mut [T], entries: &[Entry<T>], table: &Table, mut parts: Parts) -> Result<Parts> {
    for entry in entries {
        if column_names(entry.0, entries).iter().all(|name| table.has(name)) {
            fill(rows, std::slice::from_ref(entry), table)?;
            parts = part_of(entry.0).map_or(parts, |part| parts.with(part));
        }
    }
    Ok(parts)
}

fn whole(path: &Path, what: &str, value: f64) -> Result<u64> {
    if value >= 0.0 && value.fract() == 0.0 && value < 1e15 {
        return Ok(value as u64);
    }
    Err(Error::content(path, format!("{what} = {value} is not a whole number")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn read(grains: &str, contacts: Option<&str>) -> Result<(Assembly, Parts)> {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str, text: &str| {
            let path = folder.path().join(name);
            fs::write(&path, text).unwrap();
            path
        };
        let grains = file("grains.csv", grains);
        let contacts = contacts.map(|text| file("contacts.csv", text));
        read_assembly(&grains, contacts.as_deref(), [4.0, 4.0, 4.0])
    }

    const GRAINS: &str =
        "position_z,id,position_x,position_y,radius\n1,7,3.6,1,0.5\n1,2,0.5,1,0.5\n1,3,1.45,1,0.5\n";

    #[test]
    fn what_is_not_given_follows_from_places_and_radii() {
        let contacts = "first,second,normal_force\n2,7,3\n2,3,5\n";
        let (assembly, parts) = read(GRAINS, Some(contacts)).unwrap();
        assert_eq!(assembly.grains.iter().map(|grain| grain.id).collect::<Vec<_>>(), [2, 3, 7]);
        let across = assembly.contacts[0];
        assert_eq!((across.i, across.j, across.normal_force), (0, 2, 3.0));
        // The nearest image is on the other side of the cell.
        assert!((across.branch[0] + 0.9).abs() < 1e-12 && (across.normal[0] + 1.0).abs() < 1e-12);
        assert!((across.approach - 0.1).abs() < 1e-12);
        assert!((assembly.contacts[1].approach - 0.05).abs() < 1e-12);
        let missing = parts.missing(&Part::ALL);
        for part in
            [Part::Cell, Part::Positions, Part::Radii, Part::Contacts, Part::Overlaps, Part::NormalForces]
        {
            assert!(parts.has(part), "{}", part.name());
        }
        for part in [Part::TangentialForces, Part::Velocities, Part::Masses, Part::Strain, Part::Sliding] {
            assert!(missing.contains(&part), "{}", part.name());
        }
    }

    #[test]
    fn tables_that_are_none_are_refused_with_their_place() {
        let message = |grains: &str, contacts: Option<&str>| read(grains, contacts).unwrap_err().to_string();
        assert!(message("id,position_y\n1,2\n", None).contains("grains.csv: there is no column position_x"));
        assert!(message(&GRAINS.replace("1,3,", "1,2,"), None).contains("grain 2 occurs twice"));
        assert!(
            message(GRAINS, Some("first,second\n2,9\n")).contains("contacts.csv: row 1: there is no grain 9")
        );
        assert!(message(GRAINS, Some("first\n2\n")).contains("there is no column second"));
        assert!(message(&GRAINS.replace("1,3,", "1,3.5,"), None).contains("id = 3.5 is not a whole number"));
        let folder = Path::new("nowhere.csv");
        let error = read_assembly(folder, None, [1.0, 0.0, 1.0]).unwrap_err().to_string();
        assert!(error.contains("must be positive lengths"), "{error}");
    }
}
