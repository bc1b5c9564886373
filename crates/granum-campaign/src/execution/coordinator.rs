//! The coordinator of a campaign: it gives out the runs, the longest first, until all are finished.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use granum_io::OutputFolder;
use granum_run::Laboratory;
use granum_run::queue::{Executor, Outcome, Queue, QueueError, QueuedRun};

use super::recorder::{CampaignObserver, CampaignProgress, Recorder};
use crate::campaign::{Campaign, RUNS, SAMPLES};
use crate::journal::{Event, last_events};

/// Executes the runs of a campaign.
pub struct Coordinator<'a> {
    /// The campaign.
    pub campaign: &'a Campaign,
    /// The laboratory, which says which runs are those of this version.
    pub laboratory: &'a Laboratory,
    /// Who executes a run.
    pub executor: &'a dyn Executor,
    /// Number of runs at once; by default as many as the laboratory has threads and the memory can hold.
    pub workers: Option<usize>,
    /// The time after which all runs end in good order.
    pub stop_after: Option<Duration>,
    /// True if runs that failed for a reason that lies in their case are tried again.
    pub again: bool,
}

/// How a campaign ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// What was counted.
    pub progress: CampaignProgress,
    /// The runs that failed, with their reasons; those of earlier calls are among them.
    pub failed: Vec<(String, String)>,
    /// True if it was stopped before all runs were done.
    pub stopped: bool,
    /// Number of runs that had been finished before.
    pub reused: usize,
}

impl Coordinator<'_> {
    /// Checks all runs before any begins. Nothing is written.
    ///
    /// # Errors
    /// [`QueueError`] with the name of the run.
    pub fn check(&self, replace_others: bool) -> Result<(), QueueError> {
        Queue::new(self.campaign.all_queued()?)?.check(self.laboratory, replace_others)
    }

    /// Executes all runs that are not finished in the folder of the campaign, which this process alone uses.
    ///
    /// # Errors
    /// [`QueueError`] if the runs contradict each other or the journal cannot be written. Runs that fail are in the summary.
    pub fn run(
        &self,
        folder: &OutputFolder,
        replace_others: bool,
        observer: &dyn CampaignObserver,
    ) -> Result<Summary, QueueError> {
        folder.refuse_links(&[RUNS, SAMPLES])?;
        let known = last_events(folder.path());
        let all = self.campaign.all_queued()?;
        let kept = |run: &&QueuedRun| match known.get(&run.name) {
            Some(Event::Failed { reason, lasting: true }) if !self.again => {
                Some((run.name.clone(), reason.clone()))
            }
            _ => None,
        };
        let failed_before: Vec<(String, String)> = all.iter().filter_map(|run| kept(&run)).collect();
        let queue = Queue::new(without(all, &failed_before))?;
        if replace_others {
            queue.replace_others(self.laboratory)?;
        }
        let planned = self.campaign.runs().len();
        let is_test = |name: &str| self.campaign.runs().iter().any(|run| run.name == name);
        let counts = CampaignProgress {
            runs: planned,
            failed: failed_before.iter().filter(|(name, _)| is_test(name)).count(),
            ..CampaignProgress::default()
        };
        let accept = self.campaign.accept();
        let recorder =
            Recorder::new(&queue, folder.path(), accept, known, counts, self.stop_after, observer)?;
        let at_once =
            self.workers.unwrap_or_else(|| queue.at_once(self.laboratory.resources.hardware.threads));
        let outcomes = queue.run_by(self.executor, self.laboratory, at_once, &recorder);
        let progress = recorder.end();
        Ok(summary(&queue, &outcomes, progress, failed_before))
    }
}

/// The runs without those that failed before and those that wait for them; samples that none needs any more are left out too.
fn without(all: Vec<QueuedRun>, failed: &[(String, String)]) -> Vec<QueuedRun> {
    let failed: BTreeSet<&str> = failed.iter().map(|(name, _)| name.as_str()).collect();
    let is_out = |run: &QueuedRun| {
        failed.contains(run.name.as_str()) || run.after.as_deref().is_some_and(|after| failed.contains(after))
    };
    let left: Vec<QueuedRun> = all.into_iter().filter(|run| !is_out(run)).collect();
    let mut waited_for: BTreeMap<&str, usize> = BTreeMap::new();
    left.iter()
        .filter_map(|run| run.after.as_deref())
        .for_each(|name| *waited_for.entry(name).or_default() += 1);
    let needed: Vec<bool> = left
        .iter()
        .map(|run| !run.name.starts_with("sample ") || waited_for.contains_key(run.name.as_str()))
        .collect();
    left.into_iter().zip(needed).filter_map(|(run, needed)| needed.then_some(run)).collect()
}

fn summary(
    queue: &Queue,
    outcomes: &[Outcome],
    progress: CampaignProgress,
    mut failed: Vec<(String, String)>,
) -> Summary {
    let runs = queue.runs().iter().zip(outcomes);
    failed.extend(runs.filter_map(|(run, outcome)| Some((run.name.clone(), outcome.failure()?))));
    let reused = |outcome: &&Outcome| matches!(outcome, Outcome::Finished { reused: true, .. });
    Summary {
        progress,
        failed,
        stopped: outcomes.iter().any(Outcome::is_stopped),
        reused: outcomes.iter().filter(reused).count(),
    }
}
