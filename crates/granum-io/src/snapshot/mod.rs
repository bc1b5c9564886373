//! Snapshots of an assembly: `NAME.grains.parquet`, `NAME.contacts.parquet`, and `NAME.json` with cell, strain, time and
//! energy. The JSON file is written last, so that a snapshot is complete where this file exists. Where grains have several pieces there is
//! also `NAME.pieces.parquet`.

pub(crate) mod bonds;
pub(crate) mod pieces;

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use granum_core::assembly::{Assembly, Body, Contact, Piece, Vector};
use serde::{Deserialize, Serialize};

use crate::atomic::write_atomically;
use crate::error::{Error, Result};
use crate::format::{check_format, damaged};
use crate::packing::plausible::{self, Found};
use crate::shell::ShowPath;
use granum_core::{Column, ColumnKind, Table};

/// The layout of spheres, and the newest one: with grains of several pieces.
const OF_SPHERES: u32 = 1;
const FORMAT: u32 = 2;

/// Access to a number or a vector in a `T`.
enum Place<T> {
    Scalar(fn(&mut T) -> &mut f64),
    Vector(fn(&mut T) -> &mut Vector),
}

/// Name, unit and access of one column, or of three that end in `_x`, `_y` and `_z`.
type Entry<T> = (&'static str, &'static str, Place<T>);

/// Columns of the table of grains in addition to `id`.
const GRAIN: [Entry<Body>; 7] = [
    ("position", "m", Place::Vector(|grain| &mut grain.position)),
    ("velocity", "m/s", Place::Vector(|grain| &mut grain.velocity)),
    ("spin", "rad/s", Place::Vector(|grain| &mut grain.spin)),
    ("radius", "m", Place::Scalar(|grain| &mut grain.equivalent_radius)),
    ("mass", "kg", Place::Scalar(|grain| &mut grain.mass)),
    ("force", "N", Place::Vector(|grain| &mut grain.force)),
    ("torque", "N m", Place::Vector(|grain| &mut grain.torque)),
];

/// Columns of the table of contacts in addition to the ids of their grains and `sliding`.
const CONTACT: [Entry<Contact>; 8] = [
    ("branch", "m", Place::Vector(|contact| &mut contact.branch)),
    ("normal", "", Place::Vector(|contact| &mut contact.normal)),
    ("approach", "m", Place::Scalar(|contact| &mut contact.approach)),
    ("normal_force", "N", Place::Scalar(|contact| &mut contact.normal_force)),
    ("tangential_force", "N", Place::Vector(|contact| &mut contact.tangential_force)),
    ("contact_radius", "m", Place::Scalar(|contact| &mut contact.radius)),
    ("normal_energy", "J", Place::Scalar(|contact| &mut contact.normal_energy)),
    ("tangential_energy", "J", Place::Scalar(|contact| &mut contact.tangential_energy)),
];

/// An additional column of contacts, written only if some value is not zero: for contacts that resist rolling.
const ROLLING: [Entry<Contact>; 1] =
    [("rolling_energy", "J", Place::Scalar(|contact| &mut contact.rolling_energy))];

/// A further column, written only with an additional law of adhesion; it is followed by `touching`, which is 0 for pairs that
/// attract each other without touching.
const ATTRACTION: [Entry<Contact>; 1] =
    [("attraction_energy", "J", Place::Scalar(|contact| &mut contact.attraction_energy))];

/// The column that states which pairs touch, and that of the material of a grain if there are several.
const TOUCHING: &str = "touching";
const MATERIAL: &str = "material";

const AXES: [&str; 3] = ["x", "y", "z"];

/// The endings of the three files of a snapshot; the last one is written last.
pub(crate) const PARTS: [&str; 3] = ["grains.parquet", "contacts.parquet", "json"];

/// The rows as columns.
fn columns<T: Copy>(rows: &[T], entries: &[Entry<T>]) -> Vec<Column> {
    let mut columns = Vec::new();
    for (name, unit, place) in entries {
        match place {
            Place::Scalar(place) => {
                let values = rows.iter().map(|row| *place(&mut { *row })).collect();
                columns.push(Column::new(*name, *unit, values));
            }
            Place::Vector(place) => columns.extend((0..3).map(|a| {
                let values = rows.iter().map(|row| place(&mut { *row })[a]).collect();
                Column::new(format!("{name}_{}", AXES[a]), *unit, values)
            })),
        }
    }
    columns
}

/// Transfers the columns of a table to rows.
fn fill<T>(rows: &mut [T], entries: &[Entry<T>], table: &Table) -> Result<()> {
    for (name, _, place) in entries {
        match place {
            Place::Scalar(place) => {
                for (row, value) in rows.iter_mut().zip(table.column(name)?) {
                    *place(row) = *value;
                }
            }
            Place::Vector(place) => {
                for (a, axis) in AXES.iter().enumerate() {
                    for (row, value) in rows.iter_mut().zip(table.column(&format!("{name}_{axis}"))?) {
                        place(row)[a] = *value;
                    }
                }
            }
        }
    }
    Ok(())
}

/// The grains of an assembly: `id`, `position_x`... `torque_z`, in SI units; where there are several materials also `material`, the
/// place in [`Assembly::materials`].
///
/// # Errors
/// None in practice: the columns fit together by construction.
pub fn grains_table(assembly: &Assembly) -> Result<Table> {
    grain_rows(assembly, 0..assembly.bodies.len())
}

fn grain_rows(assembly: &Assembly, rows: Range<usize>) -> Result<Table> {
    let grains = &assembly.bodies[rows.clone()];
    let mut table = vec![whole_numbers("id", grains.iter().map(|grain| grain.id as f64).collect())];
    if !assembly.materials.is_empty() {
        let materials = grains.iter().map(|grain| f64::from(grain.material)).collect();
        table.push(whole_numbers(MATERIAL, materials));
    }
    table.extend(columns(grains, &GRAIN));
    if !assembly.all_spheres() {
        table.extend(pieces::columns_of_grains(assembly, rows));
    }
    Ok(Table::new(table)?)
}

/// The contacts of an assembly: `first` and `second` (ids of the grains), `branch_x`... `tangential_energy`, and
/// `sliding` (0 or 1), in SI units. Where grains attract each other beyond touch the pairs that are held apart follow, with
/// `touching` = 0.
///
/// # Errors
/// [`Error::Rule`] if a contact refers to a grain that does not exist.
pub fn contacts_table(assembly: &Assembly) -> Result<Table> {
    contact_rows(assembly, 0..assembly.contacts.len() + assembly.apart.len(), FurtherColumns::new(assembly))
}

/// Which of the further columns a table of contacts has.
#[derive(Clone, Copy)]
struct FurtherColumns {
    rolling: bool,
    attraction: bool,
}

impl FurtherColumns {
    fn new(assembly: &Assembly) -> FurtherColumns {
        let attraction = !assembly.apart.is_empty()
            || assembly.contacts.iter().any(|contact| contact.attraction_energy != 0.0);
        FurtherColumns { rolling: resists_rolling(assembly), attraction }
    }
}

/// True if a contact stores energy by rolling.
fn resists_rolling(assembly: &Assembly) -> bool {
    assembly.contacts.iter().any(|contact| contact.rolling_energy != 0.0)
}

fn contact_rows(assembly: &Assembly, rows: Range<usize>, further: FurtherColumns) -> Result<Table> {
    let id = |index: usize| {
        let grain = assembly.body_of(index).and_then(|body| assembly.bodies.get(body));
        grain
            .map(|grain| grain.id as f64)
            .ok_or_else(|| Error::Rule(format!("a contact names grain index {index}")))
    };
    let touching = assembly.contacts.len();
    let pair =
        |row: usize| assembly.contacts.get(row).or_else(|| assembly.apart.get(row - touching)).copied();
    let contacts: Vec<Contact> = rows.clone().filter_map(pair).collect();
    let contacts = contacts.as_slice();
    let first = contacts.iter().map(|contact| id(contact.i)).collect::<Result<_>>()?;
    let second = contacts.iter().map(|contact| id(contact.j)).collect::<Result<_>>()?;
    let mut table = vec![whole_numbers("first", first), whole_numbers("second", second)];
    if !assembly.all_spheres() {
        table.extend(pieces::columns_of_contacts(assembly, contacts));
    }
    table.extend(columns(contacts, &CONTACT));
    if further.rolling {
        table.extend(columns(contacts, &ROLLING));
    }
    if further.attraction {
        table.extend(columns(contacts, &ATTRACTION));
        let touches = rows.map(|row| f64::from(u8::from(row < touching))).collect();
        table.push(Column::new(TOUCHING, "", touches).of_kind(ColumnKind::Boolean));
    }
    let sliding = contacts.iter().map(|contact| f64::from(u8::from(contact.sliding))).collect();
    table.push(Column::new("sliding", "", sliding).of_kind(ColumnKind::Boolean));
    Ok(Table::new(table)?)
}

fn whole_numbers(name: &str, values: Vec<f64>) -> Column {
    Column::new(name, "", values).of_kind(ColumnKind::Integer)
}

/// The part that is neither grain nor contact: an assembly with empty lists, and the lengths of the lists.
#[derive(Serialize, Deserialize)]
struct State {
    format: u32,
    grains: usize,
    /// Number of pieces, where grains have several.
    #[serde(default, skip_serializing_if = "is_zero")]
    pieces: usize,
    contacts: usize,
    /// Pairs that are held without touching; they follow the contacts in their table.
    #[serde(default, skip_serializing_if = "is_zero")]
    apart: usize,
    assembly: Assembly,
}

fn is_zero(count: &usize) -> bool {
    *count == 0
}

fn part(folder: &Path, name: &str, end: &str) -> PathBuf {
    folder.join(format!("{name}.{end}"))
}

/// Writes a snapshot into a folder, which is created if necessary.
///
/// # Errors
/// [`Error::File`] if a file cannot be written; [`Error::Rule`] for an assembly without grains or with a contact of a grain
/// that does not exist.
pub fn write_snapshot(folder: &Path, name: &str, assembly: &Assembly) -> Result<()> {
    fs::create_dir_all(folder).map_err(Error::file("create the folder", folder))?;
    // In parts, since the tables of a large sample would need as much memory as its simulation.
    let path = part(folder, name, "grains.parquet");
    crate::formats::parquet::write_parts(&path, assembly.bodies.len(), |rows| grain_rows(assembly, rows))?;
    let path = part(folder, name, "contacts.parquet");
    let further = FurtherColumns::new(assembly);
    crate::formats::parquet::write_parts(&path, assembly.contacts.len() + assembly.apart.len(), |rows| {
        contact_rows(assembly, rows, further)
    })?;
    if !assembly.all_spheres() {
        let path = part(folder, name, pieces::FILE);
        let table = |rows| pieces::table(assembly, rows);
        crate::formats::parquet::write_parts(&path, assembly.pieces.len(), table)?;
    }
    bonds::write(&part(folder, name, bonds::FILE), assembly)?;
    let bare = Assembly {
        time: assembly.time,
        step: assembly.step,
        time_step: assembly.time_step,
        cell: assembly.cell,
        velocity_gradient: assembly.velocity_gradient,
        strain: assembly.strain,
        arc_length: assembly.arc_length,
        target_mean_stress: assembly.target_mean_stress,
        energy: assembly.energy.clone(),
        materials: assembly.materials.clone(),
        liquid: assembly.liquid,
        ..Assembly::default()
    };
    let state = State {
        format: if assembly.all_spheres() { OF_SPHERES } else { FORMAT },
        grains: assembly.bodies.len(),
        pieces: if assembly.all_spheres() { 0 } else { assembly.pieces.len() },
        contacts: assembly.contacts.len(),
        apart: assembly.apart.len(),
        assembly: bare,
    };
    let path = part(folder, name, "json");
    write_atomically(&path, |file| serde_json::to_writer_pretty(file, &state).map_err(std::io::Error::from))
}

/// Reads a snapshot; the assembly equals the one that was written, bit for bit.
///
/// # Errors
/// If a file is missing, damaged, newer than this version, or the three do not belong together.
pub fn read_snapshot(folder: &Path, name: &str) -> Result<Assembly> {
    let path = part(folder, name, "json");
    let text = crate::text::read_small(&path, 1 << 20)?;
    check_format(&path, &text, FORMAT)?;
    let state: State = serde_json::from_str(&text).map_err(|error| damaged(&path, &error))?;
    let mut assembly = state.assembly;
    let grains = part(folder, name, "grains.parquet");
    let table = read_rows(&grains, state.grains)?;
    assembly.bodies = read_grains(&grains, &table)?;
    if state.pieces == 0 {
        let sphere = |(body, of): (usize, &Body)| Piece {
            body,
            position: of.position,
            radius: of.equivalent_radius,
            ..Piece::default()
        };
        assembly.pieces = assembly.bodies.iter().enumerate().map(sphere).collect();
    } else {
        pieces::add_rigid(&grains, &table, &mut assembly)?;
        let path = part(folder, name, pieces::FILE);
        pieces::add_pieces(&path, &read_rows(&path, state.pieces)?, &mut assembly)?;
    }
    check_plausible(&grains, &assembly)?;
    let contacts = part(folder, name, "contacts.parquet");
    let pairs = state.contacts.saturating_add(state.apart);
    assembly.contacts = read_contacts(&contacts, pairs, &assembly)?;
    let ids = |contact: &Contact| {
        [contact.i, contact.j].map(|k| {
            let body = assembly.body_of(k).and_then(|body| assembly.bodies.get(body));
            body.map_or(0, |body| body.id)
        })
    };
    let branches = assembly.contacts.iter().map(|contact| (ids(contact), contact.branch));
    plausible::check_branches(&contacts.shown(), &assembly.cell, branches)?;
    assembly.apart = assembly.contacts.split_off(state.contacts);
    bonds::read(&part(folder, name, bonds::FILE), &mut assembly)?;
    Ok(assembly)
}

/// The check that all readers of grains share.
fn check_plausible(path: &Path, assembly: &Assembly) -> Result<()> {
    let found = |grain: &Body| Found {
        id: grain.id,
        position: grain.position,
        radius: Some(grain.equivalent_radius),
        line: 0,
    };
    let grains: Vec<Found> = assembly.bodies.iter().map(found).collect();
    plausible::check(&path.shown(), Some(([0.0; 3], assembly.cell)), &grains)
}

fn read_rows(path: &Path, rows: usize) -> Result<Table> {
    let table = crate::formats::parquet::read(path, None)?;
    if table.rows() == rows {
        return Ok(table);
    }
    Err(Error::content(path, format!("has {} rows, but its snapshot states {rows}", table.rows())))
}

fn read_grains(path: &Path, table: &Table) -> Result<Vec<Body>> {
    let mut grains = vec![Body::default(); table.rows()];
    let ids = table.column("id")?;
    for (at, (grain, id)) in grains.iter_mut().zip(ids).enumerate() {
        if !(*id >= 1.0 && id.fract() == 0.0) || (at > 0 && ids[at - 1] >= *id) {
            return Err(Error::content(
                path,
                format!("row {}: id = {id} is not greater than the one before", at + 1),
            ));
        }
        grain.id = *id as u64;
    }
    fill(&mut grains, &GRAIN, table)?;
    if table.columns().iter().any(|column| column.name == MATERIAL) {
        for (row, (grain, material)) in grains.iter_mut().zip(table.column(MATERIAL)?).enumerate() {
            if !(*material >= 0.0 && material.fract() == 0.0 && *material < f64::from(u32::MAX)) {
                let message = format!("row {}: material = {material} is not an index of a material", row + 1);
                return Err(Error::content(path, message));
            }
            grain.material = *material as u32;
        }
    }
    Ok(grains)
}

fn read_contacts(path: &Path, rows: usize, assembly: &Assembly) -> Result<Vec<Contact>> {
    let table = read_rows(path, rows)?;
    let mut contacts = vec![Contact::default(); rows];
    let index = |row: usize, id: f64| {
        (assembly.bodies)
            .binary_search_by(|grain| (grain.id as f64).total_cmp(&id))
            .map_err(|_| Error::content(path, format!("row {}: there is no grain {id}", row + 1)))
    };
    let [first, second, sliding] = table.select(["first", "second", "sliding"])?;
    for (row, contact) in contacts.iter_mut().enumerate() {
        contact.i = index(row, first[row])?;
        contact.j = index(row, second[row])?;
        contact.sliding = sliding[row] != 0.0;
    }
    if !assembly.all_spheres() {
        pieces::place_contacts(path, &table, assembly, &mut contacts)?;
    }
    fill(&mut contacts, &CONTACT, &table)?;
    if table.columns().iter().any(|column| column.name == ROLLING[0].0) {
        fill(&mut contacts, &ROLLING, &table)?;
    }
    if table.columns().iter().any(|column| column.name == ATTRACTION[0].0) {
        fill(&mut contacts, &ATTRACTION, &table)?;
    }
    Ok(contacts)
}

/// Names of the complete snapshots in a folder, sorted; empty if the folder does not exist.
///
/// # Errors
/// [`Error::File`] if the folder cannot be read.
pub fn list_snapshots(folder: &Path) -> Result<Vec<String>> {
    if !folder.exists() {
        return Ok(Vec::new());
    }
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).map_err(Error::file("read", folder))? {
        let name = entry.map_err(Error::file("read", folder))?.file_name();
        let name = name.to_string_lossy();
        if let Some(name) = name.strip_suffix(".json").filter(|name| !name.starts_with('.')) {
            names.push(name.to_string());
        }
    }
    names.sort();
    Ok(names)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use granum_core::assembly::{EnergyBalance, Liquid, Rigid, Sphere};

    /// Three grains and two contacts in which no number occurs twice.
    pub(crate) fn assembly() -> Assembly {
        let mut count = 0.0;
        let mut next = || {
            count += 1.0;
            (count * 0.37_f64).sin() * 1e-5
        };
        let mut next3 = || [next(), next(), next()];
        let grain = |id, next3: &mut dyn FnMut() -> [f64; 3]| Sphere {
            id,
            position: next3(),
            velocity: next3(),
            spin: next3(),
            radius: 5e-5,
            mass: 1.3875e-9,
            force: next3(),
            torque: next3(),
            material: 0,
        };
        let grains = vec![grain(1, &mut next3), grain(2, &mut next3), grain(4, &mut next3)];
        let contact = |i, j, sliding, next3: &mut dyn FnMut() -> [f64; 3]| Contact {
            i,
            j,
            branch: next3(),
            normal: next3(),
            approach: next3()[0],
            normal_force: next3()[0],
            tangential_force: next3(),
            radius: next3()[0],
            sliding,
            normal_energy: next3()[0],
            tangential_energy: next3()[0],
            rolling_energy: 0.0,
            attraction_energy: 0.0,
        };
        let contacts = vec![contact(0, 1, false, &mut next3), contact(0, 2, true, &mut next3)];
        // Wide enough for the grains, and skew.
        let mut cell = [next3(), next3(), next3()];
        (0..3).for_each(|axis| cell[axis][axis] += 1e-3);
        Assembly {
            time: 0.1,
            step: 12,
            time_step: 1.0 / 3.0,
            cell,
            velocity_gradient: [next3(), next3(), next3()],
            strain: [next3(), next3(), next3()],
            arc_length: 0.375,
            target_mean_stress: Some(2e4),
            contacts,
            apart: Vec::new(),
            materials: Vec::new(),
            liquid: Some(Liquid { films: 0.3e-15, bridges: 0.1e-15, count: 2 }),
            energy: EnergyBalance { boundary_work: 0.1 + 0.2, ..EnergyBalance::default() },
            ..Assembly::default()
        }
        .with_spheres(grains)
    }

    /// The same with a second grain of two pieces, of which the second touches.
    pub(crate) fn with_a_dimer() -> Assembly {
        let mut assembly = assembly();
        let rigid = Rigid { orientation: [0.6, 0.0, 0.8, 0.0], inertia: [1e-19, 2e-19, 2.5e-19] };
        assembly.rigid.push(rigid);
        assembly.bodies[1].rigid = Some(0);
        let first = assembly.pieces[1];
        assembly.pieces[1].arm = [1e-6, -2e-6, 3e-6];
        assembly.pieces.insert(2, Piece { radius: 4e-5, arm: [-2e-6, 1e-6, 0.0], ..first });
        assembly.pieces[3].body = 2;
        assembly.contacts[0].j = 2;
        assembly.contacts[1].j = 3;
        assembly
    }

    #[test]
    fn grains_of_several_pieces_come_back_bit_for_bit_and_what_does_not_fit_is_refused() {
        let base = tempfile::tempdir().unwrap();
        let folder = base.path();
        write_snapshot(folder, "end", &with_a_dimer()).unwrap();
        assert_eq!(read_snapshot(folder, "end").unwrap(), with_a_dimer());
        let grains = grains_table(&with_a_dimer()).unwrap();
        assert_eq!(grains.column("pieces").unwrap(), [1.0, 2.0, 1.0]);
        let contacts = contacts_table(&with_a_dimer()).unwrap();
        assert_eq!(contacts.column("second").unwrap(), [2.0, 4.0]);
        assert_eq!(contacts.column("second_piece").unwrap(), [1.0, 0.0]);
        let refused = |change: fn(&mut Assembly), text: &str| {
            let mut other = with_a_dimer();
            change(&mut other);
            write_snapshot(folder, "other", &other).unwrap();
            let message = read_snapshot(folder, "other").unwrap_err().to_string();
            assert!(message.contains(text), "{message}");
        };
        refused(|a| a.rigid[0].orientation[0] = 2.0, "must have length 1");
        refused(|a| a.pieces[1].radius = 0.0, "the radius of a piece is 0");
        refused(|a| a.pieces.swap(0, 3), "not in the order of the grains");
        std::fs::remove_file(folder.join("end.pieces.parquet")).unwrap();
        assert!(read_snapshot(folder, "end").unwrap_err().to_string().contains("end.pieces.parquet"));
    }

    #[test]
    fn an_assembly_comes_back_bit_for_bit() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().join("snapshots");
        assert!(list_snapshots(&folder).unwrap().is_empty());
        write_snapshot(&folder, "end", &assembly()).unwrap();
        assert_eq!(read_snapshot(&folder, "end").unwrap(), assembly());
        let mut rolling = assembly();
        rolling.contacts[1].rolling_energy = 1e-12;
        rolling.energy.rolling = 2e-12;
        write_snapshot(&folder, "rolling", &rolling).unwrap();
        assert_eq!(read_snapshot(&folder, "rolling").unwrap(), rolling);
        let mut wet = assembly();
        wet.materials = vec!["glass".into(), "steel".into()];
        wet.bodies[1].material = 1;
        wet.contacts[0].attraction_energy = -1e-12;
        wet.apart = vec![wet.contacts.pop().unwrap()];
        write_snapshot(&folder, "wet", &wet).unwrap();
        assert_eq!(read_snapshot(&folder, "wet").unwrap(), wet);
        assert_eq!(contacts_table(&wet).unwrap().column("touching").unwrap(), [1.0, 0.0]);
        assert_eq!(grains_table(&wet).unwrap().column("material").unwrap(), [0.0, 1.0, 0.0]);
        std::fs::remove_file(folder.join("wet.json")).unwrap();
        std::fs::remove_file(folder.join("rolling.json")).unwrap();
        assert_eq!(list_snapshots(&folder).unwrap(), ["end"]);
    }

    #[test]
    fn every_number_of_grains_and_contacts_has_a_column() {
        fn numbers(value: &serde_json::Value) -> usize {
            match value {
                serde_json::Value::Object(map) => map.values().map(numbers).sum(),
                serde_json::Value::Array(items) => items.iter().map(numbers).sum(),
                _ => 1,
            }
        }
        let of = |value: serde_json::Value| numbers(&value);
        let assembly = assembly();
        let grains = grains_table(&assembly).unwrap();
        assert_eq!(grains.columns().len(), of(serde_json::to_value(assembly.bodies[0]).unwrap()));
        let contacts = contacts_table(&assembly).unwrap();
        assert_eq!(contacts.columns().len(), of(serde_json::to_value(assembly.contacts[0]).unwrap()));
        assert_eq!(contacts.column("second").unwrap(), [2.0, 4.0]);
    }

    #[test]
    fn parts_that_do_not_belong_together_are_refused() {
        let base = tempfile::tempdir().unwrap();
        let folder = base.path();
        let message = || read_snapshot(folder, "end").unwrap_err().to_string();
        write_snapshot(folder, "end", &assembly()).unwrap();
        let mut fewer = assembly();
        fewer.bodies.pop();
        fewer.pieces.pop();
        fewer.contacts.pop();
        write_snapshot(folder, "other", &fewer).unwrap();
        fs::copy(folder.join("other.grains.parquet"), folder.join("end.grains.parquet")).unwrap();
        assert!(
            message().contains("end.grains.parquet: has 2 rows, but its snapshot states 3"),
            "{}",
            message()
        );
        fs::remove_file(folder.join("end.grains.parquet")).unwrap();
        assert!(message().contains("cannot read") && message().contains("end.grains.parquet"));
        fs::write(folder.join("end.json"), "{\"format\": 7}").unwrap();
        assert!(message().contains("was written by a newer granum"), "{}", message());
    }
}
