//! Names of the files in the folder of a study, and the check of the names of mappings.

use std::path::Path;

use granum_io::Error;
use granum_io::sealed::{unseal, unseal_strictly, write_sealed};
use serde::Serialize;

use crate::mapping::Mapping;
use granum_learn::Result;

/// File that describes a study.
pub const STUDY_FILE: &str = "study.json";
/// File with the baselines of a study.
pub const BASELINES_FILE: &str = "baselines.json";

/// File with the manifest of the training in a folder.
pub const PLAN_FILE: &str = "training.json";
/// File with the training times of the networks. They are separate because all other files are reproducible byte by byte.
pub const TIMES_FILE: &str = "seconds.json";

/// File of a network in the folder of a study.
pub fn network_file(network: &str) -> String {
    format!("{network}.json")
}

/// Writes a value as readable JSON with its SHA-256.
///
/// # Errors
/// If the file cannot be written.
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<()> {
    Ok(write_sealed(path, value)?)
}

/// Reads the text of such a file without its SHA-256, which is required from the given version of the format on.
///
/// # Errors
/// If the file cannot be read, or was changed since it was written.
pub(crate) fn read_json(path: &Path, sealed_from: u64) -> Result<String> {
    #[derive(serde::Deserialize)]
    struct Head {
        version: u64,
    }
    let text = granum_core::input::read_text(path, granum_core::input::LARGEST_INPUT)
        .map_err(Error::file("read", path))?;
    // What is no JSON, or of another format, is told by the reader of the content.
    let head: Option<Head> = serde_json::from_str(&text).ok();
    Ok(match head {
        Some(Head { version }) if version >= sealed_from => unseal_strictly(path, &text)?,
        _ => unseal(path, &text)?.text,
    })
}

/// Largest number of networks of a mapping.
const MOST_SUB_MODELS: usize = 1000;

/// Checks the name of a mapping, which becomes a part of file names and must not lead out of the folder.
pub(crate) fn check_mapping(path: &Path, mapping: &Mapping) -> Result<()> {
    let wrong = |why: String| Error::content(path, format!("mapping {:?}: {why}", mapping.name)).into();
    granum_io::check_name("name", &mapping.name).map_err(|error| wrong(error.to_string()))?;
    match mapping.sub_models.len() {
        0..=MOST_SUB_MODELS => Ok(()),
        many => Err(wrong(format!("{many} sub-models; at most {MOST_SUB_MODELS} are possible"))),
    }
}
