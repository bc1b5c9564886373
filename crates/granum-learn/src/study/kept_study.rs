//! The surrogates of an unfinished study in a folder, so that its training can be resumed.

use std::path::{Path, PathBuf};
use std::time::Duration;

use granum_io::Error;

use super::files::member_file;
use super::plan::StudyPlan;
use crate::error::Result;
use crate::networks::KeptNetworks;
use crate::surrogate::{Surrogate, SurrogateMethods, save};

/// Keeps the surrogates of a study in a folder, and the networks of those that are unfinished.
pub struct KeptStudy {
    folder: PathBuf,
    methods: SurrogateMethods,
    /// The networks.
    pub networks: KeptNetworks,
}

impl KeptStudy {
    /// Keeps the study of a plan in an existing folder. What the folder holds of a study with another plan is removed; the state
    /// of an unfinished network is stored at the given interval.
    ///
    /// # Errors
    /// If a file cannot be written or removed.
    pub fn begin(
        folder: &Path,
        plan: &StudyPlan,
        methods: &SurrogateMethods,
        every: Duration,
    ) -> Result<KeptStudy> {
        let known = StudyPlan::is_in(folder).then(|| StudyPlan::read(folder)).transpose()?;
        if known.as_ref().is_none_or(|known| !known.differences(plan).is_empty()) {
            remove(folder, known.iter().chain([plan]).flat_map(|plan| plan.files_in(folder)))?;
            plan.write(folder)?;
        }
        Ok(KeptStudy {
            folder: folder.to_path_buf(),
            methods: methods.clone(),
            networks: KeptNetworks::new(folder, every),
        })
    }

    /// The surrogate of the given name, if it is finished.
    ///
    /// # Errors
    /// If its file is damaged.
    pub fn finished(&self, name: &str) -> Result<Option<Box<dyn Surrogate>>> {
        let path = self.folder.join(member_file(name));
        if path.is_file() { self.methods.load(&path).map(Some) } else { Ok(None) }
    }

    /// Stores a surrogate, and removes the networks from which it was put together.
    ///
    /// # Errors
    /// If a file cannot be written or removed.
    pub fn fitted(&self, name: &str, surrogate: &dyn Surrogate) -> Result<()> {
        save(&self.folder.join(member_file(name)), surrogate)?;
        remove(&self.folder, network_files(&self.folder, &[name.to_owned()]))
    }
}

fn remove(folder: &Path, names: impl IntoIterator<Item = String>) -> Result<()> {
    for path in names.into_iter().map(|name| folder.join(name)).filter(|path| path.exists()) {
        std::fs::remove_file(&path).map_err(Error::file("remove", &path))?;
    }
    Ok(())
}

/// The files in a folder with networks of the given surrogates, finished or not, also those that a killed process left
/// half-written.
pub(super) fn network_files(folder: &Path, surrogates: &[String]) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().filter_map(|entry| entry.ok());
    let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
    let mut found: Vec<String> = names.filter(|name| surrogates.iter().any(|own| is_of(name, own))).collect();
    found.sort();
    found
}

/// True if a file is that of a network of a surrogate: `NAME-1.json`, `NAME-1.unfinished`.
fn is_of(file: &str, surrogate: &str) -> bool {
    let rest = file.strip_prefix(surrogate).and_then(|rest| rest.strip_prefix('-'));
    let Some((number, ending)) = rest.and_then(|rest| rest.split_once('.')) else { return false };
    let endings = ["json", "json.part", "unfinished", "unfinished.part"];
    number.parse::<usize>().is_ok() && endings.contains(&ending)
}
