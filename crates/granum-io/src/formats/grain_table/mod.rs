//! Tables of grains or of contacts, as CSV or Parquet, with the columns of a snapshot or the usual names of other programs; capitals do
//! not matter, and other columns are passed over.
//!
//! | quantity | columns |
//! |---|---|
//! | grains | `id`; `position_x`, `pos_x`, `x` or `Points:0`; `radius`, `r` or `rad`, `diameter` or `d`; `mass`; `velocity_x`, `vx` or `v_x`; `spin_x`, `omegax`, `omega_x` or `wx`; `force_x`, `fx` or `f_x`; `torque_x` |
//! | contacts | `first` and `second`, `id1` and `id2`, or `i` and `j`; `branch_x`; `normal_x` or `nx`; `normal_force` or `fn`; `tangential_force_x`, `ftx` or `ft_x`; `force_x`, `fx` or `f_x`, the whole force on the first grain; `approach` or `overlap`; `normal_energy` with `tangential_energy`; `sliding`; pairs whose `touching` is 0 are passed over |
//! | instants | `step` or `timestep`, `time`: rows that follow each other with the same values are one instant |
//!
//! Only the positions are required, and for contacts the two ids. Without ids grains are numbered from 1, and contacts may count them from 0.
//! Spheres of one body (`clump`, `mol`, `body`) and several types (`type`, `material`) are taken as grains of one material, which is said. A CSV may give the cell as a
//! [packing](super::packing_csv) does, and a [Parquet](super::parquet) of granum has it in its metadata.

pub(super) mod names;
#[cfg(test)]
mod tests;

use std::ops::Range;
use std::path::Path;

use granum_core::assembly::{Sphere, Vector};
use granum_core::{Column, Part, Table};

use self::names::*;
use super::beginning::{extension, head};
use super::column_names;
use super::meanings::{self, Meanings};
use super::packing_csv::cell;
use super::result::{FileContact, Frame, FrameCell, ReadOptions, ResultFormat};
use super::{csv, csv_words, parquet, stored_cell};
use crate::error::{Error, Result};

/// The format.
pub struct GrainTable;

/// Extension and first bytes of Parquet files; a CSV is recognised by its columns.
const PARQUET: &str = "parquet";
const MAGIC: &[u8] = b"PAR1";

impl ResultFormat for GrainTable {
    fn name(&self) -> &'static str {
        "table of grains or contacts"
    }
    fn extensions(&self) -> &'static [&'static str] {
        &[PARQUET]
    }
    fn recognises(&self, head: &[u8]) -> bool {
        if head.starts_with(MAGIC) {
            return true;
        }
        let text = String::from_utf8_lossy(head);
        let mut lines = text.lines().map(|line| line.trim().trim_start_matches('\u{feff}'));
        let Some(line) = lines.find(|line| !line.is_empty() && !line.starts_with('#')) else { return false };
        let names = Names::new(line.split([',', ';', '\t']).map(|name| name.trim().trim_matches('"')));
        // A packing that has nothing but places and radii is read as one.
        names.are_of_contacts() || (names.are_of_grains() && (names.say_more() || !cell::is_given(head)))
    }
    fn names_columns(&self) -> bool {
        true
    }
    fn read(&self, path: &Path, options: &ReadOptions) -> Result<Vec<Frame>> {
        if let Some(given) = &options.columns {
            let given: Vec<String> = given.iter().map(|name| name.to_ascii_lowercase()).collect();
            let (known, vectors) = known_names();
            column_names::check(path, &given, &known, &vectors)?;
        }
        let source = Source::open(path, options)?;
        let contacts = source.names.are_of_contacts();
        if !contacts && !source.names.are_of_grains() {
            let message = "is a table neither of grains, with position_x, position_y and position_z or x, y and z, nor of contacts, with \
                           first and second";
            return Err(Error::content(path, message));
        }
        let steps = source.scalar(STEP);
        let times = source.scalar(TIME);
        let instants = instants(source.rows(), [steps, times]);
        let frame = |rows: Range<usize>| {
            let mut frame = Frame { cell: source.cell, ..Frame::default() };
            let first = rows.start;
            frame.step = steps.map(|steps| source.whole("step", first, steps[first])).transpose()?;
            frame.time = times.map(|times| times[first]);
            if contacts {
                frame.contacts = Some(source.contacts(rows)?);
            } else {
                source.grains(rows, &mut frame)?;
            }
            Ok(frame)
        };
        instants.into_iter().map(frame).collect()
    }
}

/// The numbers of a file.
struct Source<'a> {
    path: &'a Path,
    names: Names,
    /// Each column by its place among the names; none for a column that is not needed.
    columns: Vec<Option<usize>>,
    table: Table,
    /// The type or material of each row, if there is such a column.
    kinds: Option<Column>,
    cell: Option<FrameCell>,
}

impl<'a> Source<'a> {
    fn open(path: &'a Path, options: &ReadOptions) -> Result<Source<'a>> {
        if head(path)?.starts_with(MAGIC) || extension(path) == PARQUET {
            let table = parquet::read(path, None)?;
            let names = table.names().map(str::to_string).collect();
            let cell = stored_cell::read_cell(path)?;
            return Source::from_columns(
                path,
                options,
                names,
                cell,
                |_| Ok(table),
                |name| parquet::read_with_words(path, Some(&[name])),
            );
        }
        let (cell, names) = cell::cell_and_names(path)?;
        let numbers = |wanted: &[&str]| csv::read(path, Some(wanted));
        Source::from_columns(path, options, names, cell, numbers, |name| csv_words::read(path, Some(&[name])))
    }

    /// Names the columns as the options say, and reads those that are needed.
    fn from_columns(
        path: &'a Path,
        options: &ReadOptions,
        own: Vec<String>,
        cell: Option<FrameCell>,
        read: impl FnOnce(&[&str]) -> Result<Table>,
        read_words: impl FnOnce(&str) -> Result<Table>,
    ) -> Result<Source<'a>> {
        let given = options.columns.as_ref().unwrap_or(&own);
        if given.len() != own.len() {
            let message = format!("has {} columns; {} names are given for them", own.len(), given.len());
            return Err(Error::content(path, message));
        }
        let names = Names::new(given.iter().map(String::as_str));
        let needed = needed(&names);
        let wanted: Vec<&str> = needed.iter().map(|at| own[*at].as_str()).collect();
        let table = read(&wanted)?;
        let place = |at: usize| table.names().position(|name| name == own[at]);
        let columns = (0..own.len()).map(|at| needed.contains(&at).then(|| place(at)).flatten()).collect();
        let kinds = names.scalar(KIND).filter(|_| !names.are_of_contacts()).map(|at| read_words(&own[at]));
        let kinds = kinds.transpose()?.and_then(|table| table.into_columns().pop());
        Ok(Source { path, names, columns, table, kinds, cell })
    }

    fn rows(&self) -> usize {
        self.table.rows()
    }

    fn column(&self, at: usize) -> Option<&[f64]> {
        Some(&self.table.columns()[self.columns[at]?].values)
    }

    fn scalar(&self, names: Scalar) -> Option<&[f64]> {
        self.column(self.names.scalar(names)?)
    }

    fn triple(&self, names: Triple) -> Option<[&[f64]; 3]> {
        let [x, y, z] = self.names.triple(names)?.map(|at| self.column(at));
        Some([x?, y?, z?])
    }

    fn error(&self, row: usize, message: &str) -> Error {
        Error::content(self.path, format!("row {}: {message}", row + 1))
    }

    fn whole(&self, what: &str, row: usize, value: f64) -> Result<u64> {
        if value >= 0.0 && value.fract() == 0.0 && value < 9e15 {
            return Ok(value as u64);
        }
        Err(self.error(row, &format!("{what} = {value} is not a whole number")))
    }

    /// Refuses what is no number; granum's own tables have none.
    fn check(&self, rows: Range<usize>) -> Result<()> {
        for (name, at) in self.names.0.iter().zip(0..) {
            let Some(values) = self.column(at) else { continue };
            if let Some(row) = rows.clone().find(|row| !values[*row].is_finite()) {
                return Err(self.error(row, &format!("{name} = {} is not finite", values[row])));
            }
        }
        Ok(())
    }

    fn grains(&self, rows: Range<usize>, frame: &mut Frame) -> Result<()> {
        self.check(rows.clone())?;
        let ids = self.scalar(ID);
        let radii = self.scalar(RADIUS).map(|values| (values, 1.0));
        let radii = radii.or_else(|| self.scalar(DIAMETER).map(|values| (values, 0.5)));
        let masses = self.scalar(MASS);
        let vectors = [POSITION, VELOCITY, SPIN, FORCE, TORQUE].map(|names| self.triple(names));
        frame.counts_from_one = ids.is_none();
        let [clumps, molecules] = [CLUMP, MOLECULE].map(|names| self.scalar(names));
        let mut meanings = Vec::with_capacity(rows.len());
        for row in rows.clone() {
            let body = clumps.or(molecules).map(|values| values[row]);
            meanings.push(Meanings { body, kind: self.kinds.as_ref().map(|kinds| kinds.text(row)) });
            let at = |k: usize| vectors[k].map_or([0.0; 3], |columns| vector(columns, row));
            let number = (row - rows.start) as u64 + 1;
            let radius = radii.map_or(0.0, |(values, factor)| factor * values[row]);
            if radii.is_some() && radius <= 0.0 {
                return Err(self.error(row, &format!("radius = {radius} must be positive")));
            }
            frame.grains.push(Sphere {
                id: ids.map_or(Ok(number), |ids| self.whole("id", row, ids[row]))?,
                position: at(0),
                velocity: at(1),
                spin: at(2),
                force: at(3),
                torque: at(4),
                radius,
                mass: masses.map_or(0.0, |masses| masses[row]),
                ..Sphere::default()
            });
        }
        let no_body = if clumps.is_some() { -1.0 } else { 0.0 };
        let name = |names: Scalar| self.names.scalar(names).map_or("", |at| &self.names.0[at]);
        let of_bodies = if clumps.is_some() { CLUMP } else { MOLECULE };
        meanings::note(frame, &meanings, (name(of_bodies), no_body), name(KIND));
        let known = [
            (Part::Positions, true),
            (Part::Radii, radii.is_some()),
            (Part::Masses, masses.is_some()),
            (Part::Velocities, vectors[1].is_some()),
            (Part::Spins, vectors[2].is_some()),
            (Part::ResultantForces, vectors[3].is_some()),
        ];
        for (part, _) in known.iter().filter(|(_, known)| *known) {
            frame.knows(&[*part]);
        }
        Ok(())
    }

    fn contacts(&self, rows: Range<usize>) -> Result<Vec<FileContact>> {
        self.check(rows.clone())?;
        let Some([Some(first), Some(second)]) = self.names.pair().map(|pair| pair.map(|at| self.column(at)))
        else {
            return Err(Error::content(self.path, "the ids of the grains of its contacts are not numbers"));
        };
        let scalars = [NORMAL_FORCE, APPROACH, NORMAL_ENERGY, TANGENTIAL_ENERGY, SLIDING, TOUCHING];
        let [normal_force, approach, normal_energy, tangential_energy, sliding, touching] =
            scalars.map(|names| self.scalar(names));
        let vectors = [BRANCH, NORMAL, TANGENTIAL_FORCE, FORCE].map(|names| self.triple(names));
        let mut pairs = Vec::with_capacity(rows.len());
        for row in rows {
            if touching.is_some_and(|touching| touching[row] == 0.0) {
                continue;
            }
            let scalar = |values: Option<&[f64]>| values.map(|values| values[row]);
            let [branch, normal, tangential_force, force] =
                vectors.map(|columns| columns.map(|columns| vector(columns, row)));
            pairs.push(FileContact {
                first: self.whole("the id of a grain", row, first[row])?,
                second: self.whole("the id of a grain", row, second[row])?,
                branch,
                normal,
                force,
                normal_force: scalar(normal_force),
                tangential_force,
                approach: scalar(approach),
                energies: scalar(normal_energy).zip(scalar(tangential_energy)).map(|(n, t)| [n, t]),
                sliding: scalar(sliding).map(|sliding| sliding != 0.0),
            });
        }
        Ok(pairs)
    }
}

fn vector(columns: [&[f64]; 3], row: usize) -> Vector {
    columns.map(|values| values[row])
}

/// Ranges of rows in which steps and times do not change.
fn instants(rows: usize, marks: [Option<&[f64]>; 2]) -> Vec<Range<usize>> {
    let changes =
        |row: &usize| marks.iter().flatten().any(|mark| mark[*row].to_bits() != mark[*row - 1].to_bits());
    let mut starts = vec![0];
    starts.extend((1..rows).filter(changes));
    let ends = starts.iter().skip(1).copied().chain([rows]).collect::<Vec<usize>>();
    starts.into_iter().zip(ends).map(|(start, end)| start..end).filter(|range| !range.is_empty()).collect()
}
