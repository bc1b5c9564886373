//! The coordinator of a campaign: it gives out the runs, the longest first, until all are finished.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use granum_dem::observer::Flow;
use granum_io::OutputFolder;
use granum_run::Laboratory;
use granum_run::queue::{Executor, Outcome, Queue, QueueError, QueuedRun, RunKind};

use super::recorder::{
    CAMPAIGN_CLAIM, CampaignObserver, CampaignProgress, Recorder, forget_request, steady_clock,
};
use super::taking_in::TakingIn;
use crate::acceptance::is_accepted;
use crate::campaign::{Campaign, RUNS, SAMPLES, holds_finished};
use crate::claim::{CLAIMS, Claimant};
use crate::journal::{JournalEvent, last_events};
use crate::plan::Keep;
use crate::rows::{RowFiles, StoredHead, forget_leftovers};

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
        let rows = self.campaign.rows_kept()?;
        let (_, left) = self.divided(&rows, replace_others)?;
        Queue::new(left)?.check(self.laboratory, replace_others)
    }

    /// The runs that have been taken in, and the others with the samples that these need.
    fn divided<'r>(
        &self,
        rows: &'r RowFiles,
        replace_others: bool,
    ) -> Result<(Vec<&'r StoredHead>, Vec<QueuedRun>), QueueError> {
        let all = self.campaign.all_queued()?;
        let mut taken = Vec::new();
        for run in self.campaign.runs() {
            let Some(head) = rows.head(&run.name) else { continue };
            let is_of_here =
                head.granum_version == self.laboratory.version && head.engine == self.laboratory.engine;
            if head.case_digest == run.case_digest && is_of_here {
                taken.push(head);
            } else if !replace_others {
                let (folder, version) = (self.campaign.folder_of(&run.name), head.granum_version.clone());
                return Err(QueueError::OtherRun { folder, version });
            }
        }
        let names: BTreeSet<&str> = taken.iter().map(|head| head.run.as_str()).collect();
        let left = without(all, &names, |_| false);
        Ok((taken, left))
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
        folder.refuse_links(&[RUNS, SAMPLES, CLAIMS])?;
        // The lock of the folder may hold on this machine only.
        let mut claimant = Claimant::new(folder.path(), CAMPAIGN_CLAIM);
        let stops = || observer.flow() == Flow::Stop;
        let Some(_claim) =
            claimant.take_unless_alive(&stops, &|words| observer.warn(&format!("the campaign {words}")))?
        else {
            let (path, holder) = (folder.path().to_path_buf(), claimant.holder());
            return Err(granum_io::Error::Locked { path, holder }.into());
        };
        forget_request(folder.path());
        forget_leftovers(folder.path())?;
        let known = last_events(folder.path());
        let rows = self.campaign.rows_kept()?;
        let (taken, all) = self.divided(&rows, replace_others)?;
        let kept = |run: &&QueuedRun| match known.get(&run.name) {
            // Another process, perhaps on another machine, may have made an end of it since.
            Some(JournalEvent::Failed { reason, lasting: true })
                if !self.again && !holds_finished(&run.folder) =>
            {
                Some((run.name.clone(), reason.clone()))
            }
            _ => None,
        };
        let failed_before: Vec<(String, String)> = all.iter().filter_map(|run| kept(&run)).collect();
        let failed: BTreeSet<&str> = failed_before.iter().map(|(name, _)| name.as_str()).collect();
        let queue = Queue::new(without(all, &failed, |after| failed.contains(after)))?;
        if replace_others {
            queue.replace_others(self.laboratory)?;
        }
        let planned = self.campaign.runs().len();
        let accept = self.campaign.accept();
        let flags = |head: &&StoredHead| match &head.event {
            JournalEvent::Finished { flags, .. } => flags.clone(),
            _ => Vec::new(),
        };
        let flagged: Vec<_> = taken.iter().map(flags).filter(|flags| !flags.is_empty()).collect();
        let counts = CampaignProgress {
            runs: planned,
            finished: taken.len(),
            flagged: flagged.len(),
            refused: flagged.iter().filter(|flags| !is_accepted(flags, &accept)).count(),
            failed: failed_before.iter().filter(|(name, _)| !name.starts_with("sample ")).count(),
            ..CampaignProgress::default()
        };
        let taking_in = (self.campaign.keep() == Keep::Dataset).then(|| TakingIn::new(folder.path(), &queue));
        let recorder = Recorder::new(
            &queue,
            folder.path(),
            accept,
            known,
            counts,
            self.stop_after,
            steady_clock(),
            taking_in,
            observer,
        )?;
        let at_once =
            self.workers.unwrap_or_else(|| queue.at_once(self.laboratory.resources.hardware.threads));
        let outcomes = queue.run_by(self.executor, self.laboratory, at_once, &recorder);
        let progress = recorder.end();
        Ok(summary(&queue, &outcomes, progress, failed_before, taken.len()))
    }
}

/// The runs without those of these names and those that wait for one that `fails`; samples that none needs any more are left out too.
fn without(all: Vec<QueuedRun>, names: &BTreeSet<&str>, fails: impl Fn(&str) -> bool) -> Vec<QueuedRun> {
    let is_out =
        |run: &QueuedRun| names.contains(run.name.as_str()) || run.after.as_deref().is_some_and(&fails);
    let left: Vec<QueuedRun> = all.into_iter().filter(|run| !is_out(run)).collect();
    let mut waited_for: BTreeMap<&str, usize> = BTreeMap::new();
    left.iter()
        .filter_map(|run| run.after.as_deref())
        .for_each(|name| *waited_for.entry(name).or_default() += 1);
    let needed: Vec<bool> = left
        .iter()
        .map(|run| run.kind == RunKind::Test || waited_for.contains_key(run.name.as_str()))
        .collect();
    left.into_iter().zip(needed).filter_map(|(run, needed)| needed.then_some(run)).collect()
}

fn summary(
    queue: &Queue,
    outcomes: &[Outcome],
    progress: CampaignProgress,
    mut failed: Vec<(String, String)>,
    taken: usize,
) -> Summary {
    let runs = queue.runs().iter().zip(outcomes);
    failed.extend(runs.filter_map(|(run, outcome)| Some((run.name.clone(), outcome.failure()?))));
    let reused = |outcome: &&Outcome| matches!(outcome, Outcome::Finished { reused: true, .. });
    Summary {
        progress,
        failed,
        stopped: outcomes.iter().any(Outcome::is_stopped),
        reused: taken + outcomes.iter().filter(reused).count(),
    }
}
