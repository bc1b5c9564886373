//! A run under way as one text: what a page in a browser gives its reader, from which the program goes on in a folder.
//!
//! The text is JSON with the case, the record, the snapshots and the checkpoint (base64), which has the states so far and whose checksum its reader
//! compares. Numbers have as many digits as they need to come back with the same bits.

use std::collections::BTreeMap;
use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use granum_core::{Assembly, Table};
use granum_io::Case;
use granum_io::Error as FileError;
use granum_io::run::{OWN_ENGINE, RunFolder, RunRecord, RunSource, RunStatus};
use serde::{Deserialize, Serialize};

use super::laboratory_error::LaboratoryError;

/// What the text is, and the version of its layout.
const FORMAT: &str = "granum run 1";

/// A run under way, with all that its folder would have.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SavedRun {
    format: String,
    case: String,
    record: RunRecord,
    snapshots: BTreeMap<String, Assembly>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    preparation: Option<Table>,
    checkpoint: String,
}

impl SavedRun {
    pub(crate) fn new(
        case: &Case,
        record: RunRecord,
        snapshots: BTreeMap<String, Assembly>,
        preparation: Option<Table>,
        checkpoint: &[u8],
    ) -> SavedRun {
        SavedRun {
            format: FORMAT.into(),
            case: case.resolved_toml(),
            record: RunRecord { status: RunStatus::Running, ..record },
            snapshots,
            preparation,
            checkpoint: STANDARD.encode(checkpoint),
        }
    }

    /// The text.
    ///
    /// # Errors
    /// If it cannot be represented in JSON.
    pub fn to_json(&self) -> Result<String, LaboratoryError> {
        serde_json::to_string(self).map_err(|error| refused(Path::new("the run"), error.to_string()))
    }

    /// Reads the text of the file `path`.
    ///
    /// # Errors
    /// If it is not the text of a run under way that granum's own engine made from its case, or a part of it does not belong to the others.
    pub fn from_json(text: &str, path: &Path) -> Result<SavedRun, LaboratoryError> {
        let saved: SavedRun = serde_json::from_str(text).map_err(|error| {
            let hint = "granum resume continues the folder of a run, or the file of one that the laboratory page has saved";
            refused(path, format!("this is no saved run: {error}; {hint}"))
        })?;
        let wrong = |what: &str| Err(refused(path, what.to_string()));
        if saved.format != FORMAT {
            return wrong(&format!("its format is {:?}; this version reads {FORMAT:?}", saved.format));
        }
        let record = &saved.record;
        if record.packing.is_some() || record.source != RunSource::default() || record.engine != OWN_ENGINE {
            return wrong("a saved run has a sample that was made from its case by granum's own engine");
        }
        if !record.is_of(&saved.case(path)?) {
            return wrong("its record is that of another case");
        }
        let is_plain = |name: &String| {
            !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || "-_".contains(c))
        };
        if let Some(name) = saved.snapshots.keys().find(|name| !is_plain(name)) {
            return wrong(&format!("{name:?} is no name of a snapshot"));
        }
        saved.checkpoint(path)?;
        Ok(saved)
    }

    /// Writes what the folder of the run would have, as if the run had been interrupted there: [`Laboratory::resume`](crate::Laboratory::resume)
    /// goes on from it.
    ///
    /// # Errors
    /// If it cannot be written, or a part of it cannot be read.
    pub fn write_into(&self, folder: &RunFolder) -> Result<(), LaboratoryError> {
        let path = folder.path();
        let checkpoint = self.checkpoint(path)?;
        folder.write_record(&self.record)?;
        folder.write_case(&self.case(path)?, None)?;
        if let Some(preparation) = &self.preparation {
            folder.write_preparation(preparation)?;
        }
        for (name, assembly) in &self.snapshots {
            folder.write_snapshot(name, assembly)?;
        }
        folder.write_checkpoint(|out| out.write_all(&checkpoint))?;
        Ok(folder.write_record(&self.record)?)
    }

    fn case(&self, path: &Path) -> Result<Case, LaboratoryError> {
        let name = format!("{} (its case)", path.display());
        Ok(Case::parse(&self.case, &name)?)
    }

    fn checkpoint(&self, path: &Path) -> Result<Vec<u8>, LaboratoryError> {
        let bytes = STANDARD.decode(&self.checkpoint);
        bytes.map_err(|error| refused(path, format!("its checkpoint is no base64: {error}")))
    }
}

fn refused(path: &Path, message: String) -> LaboratoryError {
    FileError::content(path, message).into()
}
