//! Assemblies in the file that a user names: as a packing, as a table, or in the format of another program.

use std::path::Path;

use granum_core::Table;

use super::Formats;
use super::beginning::extension;
use super::result::{FrameCell, ObservedAssembly, ResultFormat};
use super::stored_cell::{CELL, cell_text};
use crate::error::{Error, Result};

/// What a file of assemblies holds.
#[derive(Clone, Copy)]
pub enum AssemblyFile<'a> {
    /// The packing of the last of them.
    Packing,
    /// The table of the grains of the last of them.
    Grains,
    /// All of them in this format.
    Results(&'a dyn ResultFormat),
}

impl Formats {
    /// What a file holds, by the format of that name, or else by the extension of its own name.
    ///
    /// # Errors
    /// If no format that is written has that name or extension.
    pub fn assembly_file(&self, path: &Path, format: Option<&str>) -> Result<AssemblyFile<'_>> {
        let own = extension(path);
        if format.is_none() && self.packings().any(|known| known.extensions().contains(&own.as_str())) {
            return Ok(AssemblyFile::Packing);
        }
        if format.is_none() && self.table(path).is_ok() {
            return Ok(AssemblyFile::Grains);
        }
        self.written_format(path, format).map(AssemblyFile::Results)
    }

    /// Writes the instants of an assembly in the format of that name, or else in that of the file's extension, with ids from 1, and returns
    /// what was written. `source` is the name of the data in messages.
    ///
    /// # Errors
    /// If there is no instant; [`Error::Instants`] if there are several and the format holds one; as for [`Formats::assembly_file`],
    /// [`ObservedAssembly::packing`] and [`ResultFormat::write`].
    pub fn write_assemblies(
        &self,
        path: &Path,
        format: Option<&str>,
        observations: Vec<ObservedAssembly>,
        source: &Path,
    ) -> Result<AssemblyFile<'_>> {
        let file = self.assembly_file(path, format)?;
        let mut all: Vec<ObservedAssembly> =
            observations.into_iter().map(ObservedAssembly::numbered_from_one).collect();
        let count = all.len();
        let nothing = || Error::content(source, "there is nothing to write");
        match file {
            AssemblyFile::Packing => {
                let last = all.last().ok_or_else(nothing)?;
                self.write_packing(path, &last.packing(source)?)?;
            }
            AssemblyFile::Grains => {
                self.write_grains(path, all.pop().ok_or_else(nothing)?)?;
            }
            AssemblyFile::Results(_) if count == 0 => return Err(nothing()),
            AssemblyFile::Results(format) if format.holds_one_instant() && count > 1 => {
                let format = format.name().to_string();
                return Err(Error::Instants { path: path.to_path_buf(), format, count });
            }
            AssemblyFile::Results(format) => {
                if !format.holds_bodies() {
                    all.iter().try_for_each(|observation| observation.check_spheres(path))?;
                }
                format.write(path, &all)?;
            }
        }
        Ok(file)
    }

    /// Writes what is known of the grains as a table, with ids from 1, and returns its number of rows. Places are those of the file that
    /// was read, and Parquet holds the cell as well.
    ///
    /// # Errors
    /// As for [`ObservedAssembly::grains_table`], [`Formats::table`] and [`super::TableFormat::write`].
    pub fn write_grains(&self, path: &Path, observation: ObservedAssembly) -> Result<usize> {
        let mut own = observation.numbered_from_one();
        let origin = own.origin;
        if origin != [0.0; 3] {
            own.assembly.move_positions(|place| std::array::from_fn(|a| origin[a] + place[a]));
        }
        self.write_in_cell(path, &own.grains_table()?, own.frame_cell())
    }

    /// Writes what is known of the contacts as a table, with ids of grains from 1, and returns its number of rows. Parquet holds the cell as
    /// well.
    ///
    /// # Errors
    /// As for [`ObservedAssembly::contacts_table`], [`Formats::table`] and [`super::TableFormat::write`].
    pub fn write_contacts(&self, path: &Path, observation: ObservedAssembly) -> Result<usize> {
        let own = observation.numbered_from_one();
        self.write_in_cell(path, &own.contacts_table()?, own.frame_cell())
    }

    fn write_in_cell(&self, path: &Path, table: &Table, cell: Option<FrameCell>) -> Result<usize> {
        let format = self.table(path)?;
        match cell {
            Some(cell) => format.write_with_metadata(path, table, &[(CELL, cell_text(path, &cell)?)])?,
            None => format.write(path, table)?,
        }
        Ok(table.rows())
    }
}

#[cfg(test)]
mod tests {
    use granum_core::assembly::{Assembly, Sphere};
    use granum_core::{Part, Parts};

    use super::*;
    use crate::formats::{JoinOptions, ReadOptions, csv, parquet};

    /// Two grains in a sheared cell with a corner away from the origin, and their contact.
    fn observation() -> ObservedAssembly {
        let grain =
            |id: u64, x: f64| Sphere { id, position: [x, 0.25, 0.5], radius: 0.25, ..Sphere::default() };
        let assembly = Assembly {
            cell: [[2.0, 0.25, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]],
            contacts: vec![granum_core::assembly::Contact {
                i: 0,
                j: 1,
                branch: [0.5, 0.0, 0.0],
                normal: [1.0, 0.0, 0.0],
                normal_force: 2.0,
                ..Default::default()
            }],
            ..Assembly::default()
        }
        .with_spheres(vec![grain(3, 0.5), grain(8, 1.0)]);
        let parts =
            Parts::new(&[Part::Cell, Part::Positions, Part::Radii, Part::Contacts, Part::NormalForces]);
        ObservedAssembly::new(assembly, parts, [-1.0, 0.5, 4.0])
    }

    fn read(path: &Path) -> ObservedAssembly {
        let files = [(path.to_path_buf(), ReadOptions::default())];
        Formats::standard().read_results(&files, &JoinOptions::default()).unwrap().remove(0)
    }

    #[test]
    fn a_parquet_of_grains_keeps_cell_and_corner() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("grains.parquet");
        let (formats, written) = (Formats::standard(), observation());
        let file = formats.write_assemblies(&path, None, vec![written.clone()], &path).unwrap();
        assert!(matches!(file, AssemblyFile::Grains));
        let found = read(&path);
        assert_eq!((found.origin, found.assembly.cell), (written.origin, written.assembly.cell));
        assert_eq!(found.assembly.bodies, written.assembly.bodies);
        // A table of the grains alone, in their own places.
        assert_eq!(formats.read_table(&path, None).unwrap().column("position_x").unwrap(), [-0.5, 0.0]);
        // The contacts have it as well, for grains from a table without.
        let (contacts, bare) = (folder.path().join("contacts.parquet"), folder.path().join("bare.parquet"));
        assert_eq!(formats.write_contacts(&contacts, written.clone()).unwrap(), 1);
        parquet::write(&bare, &formats.read_table(&path, None).unwrap()).unwrap();
        assert!(!read(&bare).parts.has(Part::Cell));
        let files = [bare, contacts].map(|path| (path, ReadOptions::default()));
        let joined = formats.read_results(&files, &JoinOptions::default()).unwrap().remove(0);
        assert_eq!((joined.origin, joined.assembly.cell), (written.origin, written.assembly.cell));
        assert_eq!(joined.assembly.contacts[0].normal_force, 2.0);
    }

    #[test]
    fn a_cell_that_is_none_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("grains.parquet");
        let table = observation().grains_table().unwrap();
        for (text, part) in [("{", "granum.cell"), ("{\"origin\":[0,0,0],\"edges\":[[1]]}", "granum.cell")] {
            parquet::write_with_metadata(&path, &table, &[(CELL, text.to_string())]).unwrap();
            let files = [(path.clone(), ReadOptions::default())];
            let error = Formats::standard().read_results(&files, &JoinOptions::default()).unwrap_err();
            assert!(error.to_string().contains(part), "{error}");
        }
    }

    #[test]
    fn the_name_of_the_file_or_of_the_format_says_what_it_holds() {
        let folder = tempfile::tempdir().unwrap();
        let (formats, one) = (Formats::standard(), observation());
        let write = |name: &str, format: Option<&str>, observations: &[ObservedAssembly]| {
            let path = folder.path().join(name);
            formats.write_assemblies(&path, format, observations.to_vec(), Path::new("data")).map(|file| {
                match file {
                    AssemblyFile::Packing => "packing",
                    AssemblyFile::Grains => "grains",
                    AssemblyFile::Results(format) => format.name(),
                }
            })
        };
        let two = [one.clone(), one.clone()];
        assert_eq!(write("a.csv", None, &two).unwrap(), "packing");
        assert_eq!(write("a.parquet", None, &two).unwrap(), "grains");
        assert_eq!(write("a.xyz", None, &two).unwrap(), "extended XYZ");
        assert_eq!(write("a", Some("vtp"), &two[..1]).unwrap(), "VTP");
        assert!(matches!(write("a.vtp", None, &two), Err(Error::Instants { count: 2, .. })));
        assert!(write("a.vtp", None, &[]).err().unwrap().to_string().contains("data: there is nothing"));
        let bare = ObservedAssembly::new(one.assembly.clone(), Parts::new(&[Part::Positions]), [0.0; 3]);
        assert!(write("a.csv", None, &[bare]).err().unwrap().to_string().contains("data: has no cell"));
        let table = csv::read(&folder.path().join("a.csv"), None).unwrap();
        assert_eq!(table.rows(), 2);
    }
}
