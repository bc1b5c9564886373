//! The surrogates of an unfinished study in a folder, so that its training can be resumed.

use std::path::{Path, PathBuf};
use std::time::Duration;

use granum_io::Error;

use super::names::{member_file, network_files};
use super::plan::{PLAN_FILE, StudyPlan};
use crate::error::Result;
use crate::methods::networks::KeptNetworks;
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
            // The plan is replaced last: it tells the names of the files, so that what a process leaves that is killed here is removed
            // the next time.
            let files = known.iter().chain([plan]).flat_map(|plan| plan.files_in(folder));
            remove(folder, files.filter(|name| name != PLAN_FILE))?;
            plan.write(folder)?;
        }
        Ok(KeptStudy {
            folder: folder.to_path_buf(),
            methods: methods.clone(),
            networks: KeptNetworks::new(folder, every),
        })
    }

    /// The surrogate of the given name, if it is finished. Networks from which it was put together are removed: a process may
    /// have been killed after it had stored the surrogate and before it had removed them.
    ///
    /// # Errors
    /// If its file is damaged, or a file cannot be removed.
    pub fn finished(&self, name: &str) -> Result<Option<Box<dyn Surrogate>>> {
        let path = self.folder.join(member_file(name));
        if !path.is_file() {
            return Ok(None);
        }
        let surrogate = self.methods.load(&path)?;
        remove(&self.folder, network_files(&self.folder, &[name.to_owned()]))?;
        Ok(Some(surrogate))
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
