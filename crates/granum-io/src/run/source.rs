//! The origin of the sample of a run, in memory by paths that can be opened, and in the files of a folder by paths relative to it.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::file_digest::{RECORD, file_digest};
use crate::error::Result;
use crate::recordable::{moved_with, path_from, path_in};

/// The origin of the sample of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RunSource {
    /// It was prepared according to the case.
    #[default]
    Case,
    /// It is the sample in this run folder.
    Sample(PathBuf),
    /// A packing file.
    Packing {
        /// The file.
        file: PathBuf,
        /// SHA-256 of its bytes.
        sha256: String,
    },
}

impl RunSource {
    /// As a file in `folder` names it: by a path that is relative to the folder.
    ///
    /// # Errors
    /// If the path is not UTF-8 text, or the working directory no longer exists.
    pub fn relative_to(&self, folder: &Path) -> Result<RunSource> {
        Ok(match self {
            RunSource::Case => RunSource::Case,
            RunSource::Sample(path) => RunSource::Sample(path_from(folder, path)?),
            RunSource::Packing { file, sha256 } => {
                RunSource::Packing { file: path_from(folder, file)?, sha256: sha256.clone() }
            }
        })
    }

    /// As it is found from `folder`, a file of which names it. Earlier versions wrote absolute paths: if the folder was moved since, a
    /// sample of the same preparation (`preparation`, if it is known), or the same packing, is looked for in the same place near the
    /// folder. A packing is also found in the folder itself.
    pub fn in_folder(&self, folder: &Path, preparation: Option<&str>) -> RunSource {
        match self {
            RunSource::Case => RunSource::Case,
            RunSource::Sample(path) if path.is_absolute() => {
                let is_it = |place: &Path| {
                    let digest = preparation_in(place);
                    digest.is_some() && (preparation.is_none() || digest.as_deref() == preparation)
                };
                // What was copied with the folder comes before what is still in the old place.
                RunSource::Sample(moved_with(folder, path, &is_it).unwrap_or_else(|| path.clone()))
            }
            RunSource::Sample(path) => RunSource::Sample(path_in(folder, path)),
            RunSource::Packing { file, sha256 } => {
                RunSource::Packing { file: packing_in(folder, file, sha256), sha256: sha256.clone() }
            }
        }
    }
}

/// The file of a packing.
fn packing_in(folder: &Path, file: &Path, sha256: &str) -> PathBuf {
    let named = path_in(folder, file);
    if named.is_file() {
        return named;
    }
    let is_it = |place: &Path| place.is_file() && file_digest(place).is_ok_and(|digest| digest == sha256);
    let inside = file.file_name().map(|name| folder.join(name)).filter(|place| is_it(place));
    let near = || file.is_absolute().then(|| moved_with(folder, file, &is_it)).flatten();
    inside.or_else(near).unwrap_or(named)
}

/// The digest of the preparation by the record of a folder. The record itself is checked by whoever takes the sample.
fn preparation_in(folder: &Path) -> Option<String> {
    let text = crate::text::read_small(&folder.join(RECORD), 1 << 24).ok()?;
    let record: serde_json::Value = serde_json::from_str(&text).ok()?;
    Some(record.get("preparation_digest")?.as_str()?.to_string())
}
