//! Takes runs in as they are finished, and throws their folders away, where the plan keeps the data set alone.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use granum_io::Result;
use granum_run::queue::Queue;

use crate::rows::{RowWriter, read_run, remove_folder};

/// Takes in the runs of a queue.
pub(super) struct TakingIn {
    campaign: PathBuf,
    held: Mutex<Held>,
}

struct Held {
    writer: RowWriter,
    /// For each sample the number of tests in the queue that have not been taken in.
    waiting: BTreeMap<String, usize>,
}

impl TakingIn {
    /// For the campaign in a folder.
    pub(super) fn new(campaign: &Path, queue: &Queue) -> TakingIn {
        let mut waiting = BTreeMap::new();
        for sample in queue.runs().iter().filter_map(|run| run.after.clone()) {
            *waiting.entry(sample).or_default() += 1;
        }
        let held = Held { writer: RowWriter::new(campaign), waiting };
        TakingIn { campaign: campaign.to_path_buf(), held: Mutex::new(held) }
    }

    /// Takes in a finished run, throws its folder away, and the folder of its sample where it was the last one that needs it.
    ///
    /// # Errors
    /// If the rows cannot be written or a folder cannot be removed; both are then tried again when the runs are collected.
    pub(super) fn take(&self, queue: &Queue, number: usize) -> Result<()> {
        let run = &queue.runs()[number];
        let stored = read_run(&run.folder, &run.case.vocabulary)?;
        let is_last = {
            let mut held = self.held.lock().unwrap_or_else(PoisonError::into_inner);
            // Its rows are on the disk before its folder goes.
            held.writer.append(&[(run.name.clone(), stored)])?;
            let waiting = run.after.as_ref().and_then(|sample| held.waiting.get_mut(sample));
            waiting.is_some_and(|count| {
                *count = count.saturating_sub(1);
                *count == 0
            })
        };
        remove_folder(&self.campaign, &run.folder)?;
        let sample = queue.runs().iter().find(|sample| is_last && Some(&sample.name) == run.after.as_ref());
        match sample.filter(|sample| sample.folder.is_dir()) {
            Some(sample) => remove_folder(&self.campaign, &sample.folder),
            None => Ok(()),
        }
    }
}
