//! What answers are made from: the folder, the program, and what was drawn last.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use granum_io::Run;
use granum_run::runs_table::RunsTable;
use tokio::sync::Semaphore;

use crate::documents::Recent;
use crate::folder::Folder;
use crate::program::{Program, Report};
use crate::refused::Refused;

/// Reports and tables that are kept.
const KEPT: usize = 8;

/// What answers are made from.
pub struct Site {
    /// The folder that is served.
    pub folder: Folder,
    /// The program that serves it.
    pub program: Arc<dyn Program>,
    /// Permission to compute.
    pub places: Arc<Semaphore>,
    reports: Recent<Report>,
    tables: Recent<RunsTable>,
}

impl Site {
    pub fn new(folder: Folder, program: Arc<dyn Program>, working: usize) -> Site {
        let places = Arc::new(Semaphore::new(working));
        Site { folder, program, places, reports: Recent::new(KEPT), tables: Recent::new(KEPT) }
    }

    /// The place of a path of an address, after what is in it was looked at.
    pub fn place(&self, inside: &str) -> Result<PathBuf, Refused> {
        let place = self.folder.place(inside)?;
        self.folder.check_content(&place)?;
        Ok(place)
    }

    /// The run at a path of an address.
    pub fn run(&self, inside: &str) -> Result<Run, Refused> {
        let place = self.place(inside)?;
        self.program.run_at(&place).map_err(|why| Refused::not_found(self.without_root(why)))
    }

    /// The report of folders, as it is now.
    pub fn report(&self, folders: &[PathBuf]) -> Result<Arc<Report>, Refused> {
        let made = self.reports.get(folders, || self.program.report(folders));
        made.map_err(|why| Refused::unreadable(self.without_root(why)))
    }

    /// The table of the runs of a campaign, as it is now.
    pub fn table(&self, folder: &Path) -> Result<Arc<RunsTable>, Refused> {
        let made = self
            .tables
            .get(&[folder.to_path_buf()], || Ok(RunsTable::from_runs(&self.program.entries(folder)?)));
        made.map_err(|why| Refused::unreadable(self.without_root(why)))
    }

    /// A message in which the folder is named as the user named it.
    pub fn without_root(&self, message: impl ToString) -> String {
        let root = self.folder.root().to_string_lossy().into_owned();
        let named = self.folder.named().to_string_lossy().into_owned();
        message.to_string().replace(&root, &named)
    }
}
