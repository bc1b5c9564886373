//! A run of a table.

use granum_io::RunKind;

use std::path::PathBuf;

use granum_io::shell::ShowPath;
use granum_io::{Case, Result, Run, RunRecord};

use crate::record::read_record;
use crate::strength;

/// Measures of which every test has one, if its strength was found.
const STRENGTH: [&str; 3] = ["peak_friction_angle", "critical_void_ratio", "critical_mean_stress"];

/// A run with what a table needs of it.
#[derive(Clone, Debug, PartialEq)]
pub struct RunEntry {
    /// Its name in the table.
    pub name: String,
    /// Its folder.
    pub folder: PathBuf,
    /// The case.
    pub case: Case,
    /// The record.
    pub record: RunRecord,
    /// Digest of the results, if it is known.
    pub digest: Option<String>,
}

impl RunEntry {
    /// A run from its parts.
    pub fn new(
        name: impl Into<String>,
        folder: impl Into<PathBuf>,
        case: Case,
        record: RunRecord,
    ) -> RunEntry {
        RunEntry { name: name.into(), folder: folder.into(), case, record, digest: None }
    }

    /// Reads a run; its name is that of its folder.
    ///
    /// # Errors
    /// If the case or the record cannot be read; the message names the file.
    pub fn from_run(run: &Run) -> Result<RunEntry> {
        let (folder, case, record) = (run.path(), run.case()?, run.record()?);
        let whole = std::path::absolute(folder).unwrap_or_else(|_| folder.to_path_buf());
        let name =
            whole.file_name().map_or_else(|| folder.shown(), |name| name.to_string_lossy().into_owned());
        Ok(RunEntry::new(name, folder, case, record))
    }

    /// The same run with the strength of its test, found from the series where the record was written by a version that did not
    /// tell it.
    ///
    /// # Errors
    /// If the series cannot be read.
    pub fn with_strength(mut self) -> Result<RunEntry> {
        let run = Run::at(&self.folder)?.with_vocabulary(&self.case.vocabulary);
        let told = self.record.measures.keys().any(|name| STRENGTH.contains(&name.as_str()));
        if !told && run.has_series() && self.record.kind != RunKind::Sample {
            let found = strength::of_run(&self.case, &self.record, &read_record(&run)?);
            self.record.measures.extend(found);
        }
        if self.record.measures.contains_key("peak_friction_angle") {
            self.record.measures.extend(strength::cohesion_of(&self.case));
        }
        Ok(self)
    }

    /// The same run with the digest of its results, which reads all of its files.
    ///
    /// # Errors
    /// As [`crate::digest::of_run`].
    pub fn with_digest(self) -> Result<RunEntry> {
        let digest = crate::digest::of_run(&Run::at(&self.folder)?.with_vocabulary(&self.case.vocabulary))?;
        Ok(RunEntry { digest: Some(digest), ..self })
    }
}
