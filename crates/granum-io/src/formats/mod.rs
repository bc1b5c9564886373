//! File formats, one file each: tables and packings. A new one needs its file and its line in [`Formats::standard`]; other
//! programs add their own formats with [`Formats::with_table`] and [`Formats::with_packing`].
//!
//! ```
//! use granum_io::formats::Formats;
//!
//! let names: Vec<&str> = Formats::standard().tables().map(|format| format.name()).collect();
//! assert_eq!(names, ["CSV", "Parquet"]);
//! ```

use std::path::Path;
use std::sync::Arc;

use granum_core::{RegistrationError, Table};

use self::beginning::{extension, head};
use crate::error::{Error, Result};
use crate::packing::Packing;

mod arrays;
mod atoms;
mod beginning;
mod bodies;
mod column_names;
mod computed_contacts;
pub mod contact_table;
pub mod csv;
mod csv_columns;
mod csv_words;
mod export;
pub mod extended_xyz;
mod file_bond;
mod file_bonds;
pub mod grain_table;
pub mod gsd;
pub mod hdf5;
mod ids;
pub mod join;
mod lammps_bonds;
pub mod lammps_data;
pub mod lammps_dump;
mod lammps_dump_text;
pub(crate) mod lines;
mod meanings;
pub mod mercury_data;
pub mod mercury_fstat;
pub mod mercury_restart;
pub mod packing_csv;
mod packing_format;
pub mod parquet;
mod places;
mod quaternion;
mod remark;
mod result;
mod rounding;
mod snapshot_json;
mod stored_cell;
mod strain;
mod table_format;
pub mod vtk_legacy;
pub mod vtk_xml;
pub mod vtp;
pub mod vtp_bodies;
pub mod vtp_bonds;
mod words;
pub mod yade_text;

pub use arrays::PairOfGrains;
pub use contact_table::ContactOptions;
pub use export::AssemblyFile;
pub use file_bond::FileBond;
pub use join::JoinOptions;
pub use packing_format::PackingFormat;
pub use remark::Remark;
pub use result::{FileContact, Frame, FrameCell, ObservedAssembly, ReadOptions, ResultFormat, known_columns};
pub use table_format::TableFormat;

/// The formats that a program supports.
#[derive(Clone)]
pub struct Formats {
    tables: Vec<Arc<dyn TableFormat>>,
    packings: Vec<Arc<dyn PackingFormat>>,
    results: Vec<Arc<dyn ResultFormat>>,
    /// True if files may name files outside their own folders.
    outside: bool,
}

impl std::fmt::Debug for Formats {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let names =
            self.tables().map(|format| format.name()).chain(self.packings().map(|format| format.name()));
        f.debug_list().entries(names).finish()
    }
}

impl Formats {
    /// No formats: for a program that reads no files.
    pub fn none() -> Formats {
        Formats { tables: Vec::new(), packings: Vec::new(), results: Vec::new(), outside: false }
    }

    /// The formats that come with granum.
    pub fn standard() -> Formats {
        Formats {
            tables: vec![Arc::new(csv::Csv), Arc::new(parquet::Parquet)],
            packings: vec![Arc::new(packing_csv::PackingCsv)],
            results: vec![
                Arc::new(lammps_dump::LammpsDump),
                Arc::new(lammps_data::LammpsData),
                Arc::new(yade_text::YadeText),
                Arc::new(vtk_legacy::VtkLegacy),
                Arc::new(vtk_xml::VtkXml),
                Arc::new(mercury_data::MercuryData),
                Arc::new(mercury_fstat::MercuryFstat),
                Arc::new(mercury_restart::MercuryRestart),
                Arc::new(extended_xyz::ExtendedXyz),
                Arc::new(gsd::Gsd),
                Arc::new(vtp::Vtp),
                Arc::new(vtp_bodies::VtpBodies),
                Arc::new(vtp_bonds::VtpBonds),
                Arc::new(snapshot_json::SnapshotJson),
                Arc::new(grain_table::GrainTable),
            ],
            outside: false,
        }
    }

    /// The same formats; a file that names others (`.vtm`) may name files outside its own folder if `outside` is true.
    pub fn allowing_outside(self, outside: bool) -> Formats {
        Formats { outside, ..self }
    }

    /// The same formats and one more for tables.
    ///
    /// # Errors
    /// [`RegistrationError`] if there is already a format of tables of the same name, or one of its extensions belongs to another.
    pub fn with_table(
        mut self,
        format: impl TableFormat + 'static,
    ) -> std::result::Result<Formats, RegistrationError> {
        let (names, taken) =
            (self.tables().map(|known| known.name()), self.tables().flat_map(|known| known.extensions()));
        check_format("format of tables", format.name(), format.extensions(), names, taken)?;
        self.tables.push(Arc::new(format));
        Ok(self)
    }

    /// The same formats and one more for packings.
    ///
    /// # Errors
    /// [`RegistrationError`] if there is already a format of packings of the same name, or one of its extensions belongs to another.
    pub fn with_packing(
        mut self,
        format: impl PackingFormat + 'static,
    ) -> std::result::Result<Formats, RegistrationError> {
        let (names, taken) =
            (self.packings().map(|known| known.name()), self.packings().flat_map(|known| known.extensions()));
        check_format("format of packings", format.name(), format.extensions(), names, taken)?;
        self.packings.push(Arc::new(format));
        Ok(self)
    }

    /// The same formats and one more for results of other programs.
    ///
    /// # Errors
    /// [`RegistrationError`] if there is already a format of results of the same name, or an extension has a form that none can have. Formats of results may share
    /// an extension, since files are told apart by how they begin.
    pub fn with_result(
        mut self,
        format: impl ResultFormat + 'static,
    ) -> std::result::Result<Formats, RegistrationError> {
        let (names, taken) = (self.results().map(|known| known.name()), []);
        check_format("format of results", format.name(), format.extensions(), names, taken)?;
        self.results.push(Arc::new(format));
        Ok(self)
    }

    /// The formats of results of other programs.
    pub fn results(&self) -> impl Iterator<Item = &dyn ResultFormat> {
        self.results.iter().map(|format| &**format)
    }

    /// The formats of tables.
    pub fn tables(&self) -> impl Iterator<Item = &dyn TableFormat> {
        self.tables.iter().map(|format| &**format)
    }

    /// The formats of packings.
    pub fn packings(&self) -> impl Iterator<Item = &dyn PackingFormat> {
        self.packings.iter().map(|format| &**format)
    }

    /// The format of tables that belongs to the extension of a file name.
    ///
    /// # Errors
    /// If no format has that extension.
    pub fn table(&self, path: &Path) -> Result<&dyn TableFormat> {
        let wanted = extension(path);
        self.tables().find(|format| format.extensions().contains(&wanted.as_str())).ok_or_else(|| {
            let known = self.tables().flat_map(|format| format.extensions());
            Error::content(path, format!("the name of a table must end in {}", any_of(known)))
        })
    }

    /// Reads the named columns of a table, or all numeric ones.
    ///
    /// # Errors
    /// As for [`Formats::table`] and [`TableFormat::read`].
    pub fn read_table(&self, path: &Path, names: Option<&[&str]>) -> Result<Table> {
        self.table(path)?.read(path, names)
    }

    /// Writes a table.
    ///
    /// # Errors
    /// As for [`Formats::table`] and [`TableFormat::write`].
    pub fn write_table(&self, path: &Path, table: &Table) -> Result<()> {
        self.table(path)?.write(path, table)
    }

    /// Reads a packing. Its format is the one that recognises the beginning of the file, or otherwise that of its extension. Of
    /// results of another program it is the last instant, with its grains numbered from 1 in the order of their ids.
    ///
    /// # Errors
    /// If no format fits, as for [`PackingFormat::read`], or if results lack a periodic cell or radii.
    pub fn read_packing(&self, path: &Path) -> Result<Packing> {
        // Neither has a way to a page, whose module then has none of what joins the files of other programs.
        if cfg!(all(target_arch = "wasm32", target_os = "unknown")) {
            return Err(Error::content(path, "a page in a browser reads no packings"));
        }
        let head = head(path)?;
        if let Some(format) = self.packings().find(|format| format.recognises(&head)) {
            return format.read(path);
        }
        if let Some(format) = self.result_format(path, &head) {
            let frames = format.read(path, &ReadOptions::default().with_outside(self.outside))?;
            let found = join::join(vec![(path.to_path_buf(), frames)], &JoinOptions::default())?;
            return match found.last() {
                Some(last) => last.packing(path),
                None => Err(Error::content(path, "has no grains")),
            };
        }
        self.packing(path)?.read(path)
    }

    /// The format of results that recognises a file, or else the one that has its extension.
    fn result_format(&self, path: &Path, head: &[u8]) -> Option<&dyn ResultFormat> {
        let wanted = extension(path);
        let recognised = self.results().find(|format| format.recognises(head));
        // A packing format of the same extension goes first.
        let taken = self.packings().any(|format| format.extensions().contains(&wanted.as_str()));
        recognised.or_else(|| {
            self.results().find(|format| !taken && format.extensions().contains(&wanted.as_str()))
        })
    }

    /// True if a file is read as results of another program, not as a packing in granum's own format.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn is_result(&self, path: &Path) -> Result<bool> {
        let head = head(path)?;
        let result = self.results().any(|format| format.recognises(&head));
        let packing = self.packings().any(|format| format.recognises(&head));
        Ok(result || (!packing && self.result_format(path, &head).is_some()))
    }

    /// Reads results of another program, and packings, from one or several files, each with its options, and joins what belongs
    /// together.
    ///
    /// # Errors
    /// If a file is in no known format, as for [`ResultFormat::read`], and as for [`join::join`].
    pub fn read_results(
        &self,
        files: &[(std::path::PathBuf, ReadOptions)],
        options: &JoinOptions,
    ) -> Result<Vec<ObservedAssembly>> {
        if let [(path, _)] = files
            && !self.is_result(path)?
        {
            let packing = self.read_packing(path)?;
            // As they are: put together again, bodies would have other bits.
            if !packing.bodies.is_empty() && !options.separate_spheres {
                return Ok(vec![ObservedAssembly::of_packing_with(&packing, options.density)]);
            }
        }
        let mut read = Vec::with_capacity(files.len());
        for (path, file_options) in files {
            let head = head(path)?;
            let frames = match self.result_format(path, &head) {
                Some(format) => {
                    if file_options.columns.is_some() && !format.names_columns() {
                        let message = format!(
                            "--columns: the quantities of a file of this format ({}) have names of their own",
                            format.name()
                        );
                        return Err(Error::content(path, message));
                    }
                    let outside = file_options.outside || self.outside;
                    format.read(path, &file_options.clone().with_outside(outside))?
                }
                None => vec![Frame::of_packing(&self.read_packing(path)?)],
            };
            read.push((path.clone(), frames));
        }
        join::join(read, options)
    }

    /// The format in which results are written: of the given name, or of the file's extension.
    ///
    /// # Errors
    /// If no format that is written has that name or extension.
    pub fn written_format(&self, path: &Path, name: Option<&str>) -> Result<&dyn ResultFormat> {
        let wanted = extension(path);
        let fits = |format: &&dyn ResultFormat| match name {
            Some(name) => {
                short_name(format.name()) == short_name(name) || format.extensions().contains(&name)
            }
            None => format.is_written() && format.extensions().contains(&wanted.as_str()),
        };
        self.results().find(fits).ok_or_else(|| {
            let written = || self.results().filter(|format| format.is_written());
            let Some(name) = name else {
                let tables = self.tables().flat_map(|format| format.extensions());
                let packings = self.packings().flat_map(|format| format.extensions());
                let known = written().flat_map(|format| format.extensions()).chain(tables).chain(packings);
                let what =
                    if wanted.is_empty() { "has no extension".into() } else { format!("ends in .{wanted}") };
                let message =
                    format!("its name {what}; it must end in {}, which says its format", any_of(known));
                return Error::content(path, message);
            };
            let known: Vec<String> = written().map(|format| short_name(format.name())).collect();
            let known = known.join(", ");
            Error::content(
                path,
                format!("no format that granum writes is called {name:?}; known are {known}"),
            )
        })
    }

    /// Writes observations in the format of that name, or else in that of the file's extension.
    ///
    /// # Errors
    /// If no format has the name or the extension, or as for [`ResultFormat::write`].
    pub fn write_results(
        &self,
        path: &Path,
        name: Option<&str>,
        observations: &[ObservedAssembly],
    ) -> Result<()> {
        let format = self.written_format(path, name)?;
        if !format.holds_bodies() {
            observations.iter().try_for_each(|observation| observation.check_spheres(path))?;
        }
        format.write(path, observations)
    }

    /// Writes a packing in the format of the file's extension.
    ///
    /// # Errors
    /// If no format has that extension, or as for [`PackingFormat::write`].
    pub fn write_packing(&self, path: &Path, packing: &Packing) -> Result<()> {
        match self.packing(path) {
            Ok(format) => format.write(path, packing),
            Err(_) => self.write_results(path, None, &[ObservedAssembly::of_packing(packing)]),
        }
    }

    fn packing(&self, path: &Path) -> Result<&dyn PackingFormat> {
        let wanted = extension(path);
        self.packings().find(|format| format.extensions().contains(&wanted.as_str())).ok_or_else(|| {
            let known = self.packings().flat_map(|format| format.extensions());
            let results = self.results().flat_map(|format| format.extensions());
            let known = known.chain(results);
            Error::content(
                path,
                format!("is not a known packing format: its name should end in {}", any_of(known)),
            )
        })
    }
}

/// Refuses a format whose name or extension belongs to another, or which has none, or an extension that is never looked for.
fn check_format<'n>(
    what: &'static str,
    name: &str,
    extensions: &[&str],
    mut names: impl Iterator<Item = &'n str>,
    taken: impl IntoIterator<Item = &'n &'static str>,
) -> std::result::Result<(), RegistrationError> {
    if names.any(|known| short_name(known) == short_name(name)) {
        return Err(RegistrationError::name_taken(what, name));
    }
    // A name may have blanks: it is chosen on the command line with hyphens for them.
    RegistrationError::check_name(what, &short_name(name), []).map_err(|_| RegistrationError::Name {
        what,
        name: name.into(),
        reason: "its name is not one of letters, digits and blanks",
    })?;
    let taken: Vec<&str> = taken.into_iter().copied().collect();
    for extension in extensions {
        if *extension != extension.to_lowercase() {
            let (name, part, key) = (name.into(), "extension", extension.to_string());
            let reason = "is not in lower case";
            return Err(RegistrationError::Key { what, name, part, key, reason });
        }
        RegistrationError::check_key(what, name, "extension", extension, taken.contains(extension))?;
    }
    Ok(())
}

/// A name without capitals and blanks: "LAMMPS data" and "lammps-data" are one.
fn short_name(name: &str) -> String {
    name.to_lowercase().replace([' ', '_'], "-")
}

/// ".csv or .parquet", each once.
fn any_of<'a>(extensions: impl Iterator<Item = &'a &'static str>) -> String {
    let mut all: Vec<String> = Vec::new();
    for extension in extensions.map(|extension| format!(".{extension}")) {
        if !all.contains(&extension) {
            all.push(extension);
        }
    }
    match all.split_last() {
        Some((last, [])) => last.clone(),
        Some((last, others)) => format!("{} or {last}", others.join(", ")),
        None => "a known extension".into(),
    }
}

/// Reads all numeric columns of a table in one of the [standard formats](Formats::standard).
///
/// # Errors
/// As for [`Formats::read_table`].
pub fn read_table(path: impl AsRef<Path>) -> Result<Table> {
    Formats::standard().read_table(path.as_ref(), None)
}

/// Reads the named columns of a table, in the requested order; others are ignored.
///
/// # Errors
/// As for [`Formats::read_table`].
pub fn read_columns(path: impl AsRef<Path>, names: &[&str]) -> Result<Table> {
    Formats::standard().read_table(path.as_ref(), Some(names))
}

/// Reads the named columns of a table, in the requested order, or all: columns of numbers and columns of words.
///
/// # Errors
/// As for [`Formats::table`] and [`TableFormat::read_with_words`].
pub fn read_table_with_words(path: impl AsRef<Path>, names: Option<&[&str]>) -> Result<Table> {
    let path = path.as_ref();
    Formats::standard().table(path)?.read_with_words(path, names)
}

/// Writes a table under a temporary name and renames it. Equal tables give equal bytes.
///
/// # Errors
/// As for [`Formats::write_table`].
pub fn write_table(path: impl AsRef<Path>, table: &Table) -> Result<()> {
    Formats::standard().write_table(path.as_ref(), table)
}

/// Reads and checks a packing in one of the [standard formats](Formats::standard).
///
/// # Errors
/// As for [`Formats::read_packing`].
pub fn read_packing(path: impl AsRef<Path>) -> Result<Packing> {
    Formats::standard().read_packing(path.as_ref())
}

/// Writes a packing under a temporary name and renames it.
///
/// # Errors
/// As for [`Formats::write_packing`].
pub fn write_packing(path: impl AsRef<Path>, packing: &Packing) -> Result<()> {
    Formats::standard().write_packing(path.as_ref(), packing)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extension_chooses_the_format() {
        let formats = Formats::standard();
        let name = |file: &str| formats.table(Path::new(file)).map(|format| format.name());
        assert_eq!(name("x/Y.CSV").unwrap(), "CSV");
        assert_eq!(name("y.parquet").unwrap(), "Parquet");
        let error = name("y.xlsx").unwrap_err().to_string();
        assert_eq!(error, "y.xlsx: the name of a table must end in .csv or .parquet");
    }

    struct Pair;
    impl PackingFormat for Pair {
        fn name(&self) -> &'static str {
            "pair"
        }
        fn extensions(&self) -> &'static [&'static str] {
            &["pair"]
        }
        fn recognises(&self, head: &[u8]) -> bool {
            head.starts_with(b"pair")
        }
        fn read(&self, path: &Path) -> Result<Packing> {
            let grain =
                |id: u64| crate::packing::PackedGrain { id, position: [id as f64, 1.0, 1.0], radius: 0.5 };
            let cell = [[4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
            let file = path.display().to_string();
            Packing::checked(&file, [0.0; 3], cell, vec![(grain(1), 1), (grain(2), 2)])
        }
        fn write(&self, _: &Path, _: &Packing) -> Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_format_of_ones_own_is_recognised_by_how_a_file_begins() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("data.pack");
        std::fs::write(&file, "pair").unwrap();
        let error = read_packing(&file).unwrap_err().to_string();
        assert!(
            error.contains("data.pack: is not a known packing format: its name should end in .csv, .dump"),
            "{error}"
        );
        let formats = Formats::standard().with_packing(Pair).unwrap();
        assert_eq!(formats.read_packing(&file).unwrap().grains.len(), 2);
        let twice = formats.with_packing(Pair).err();
        assert_eq!(twice, Some(RegistrationError::name_taken("format of packings", "pair")));
    }
}
