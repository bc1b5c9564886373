//! The runs of one element of a job, as the element executes them on the machine that it was given.

use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};

use granum_dem::observer::Flow;
use granum_io::Result;
use granum_run::Laboratory;
use granum_run::queue::{Executor, Outcome, Queue, QueueError, QueueObserver, QueuedRun};

use super::recorder::CampaignObserver;
use crate::campaign::Campaign;
use crate::journal::{JournalEvent, LineWriter};

/// Executes runs and samples of a campaign by their names, so many at once, with the samples that they need. What happens is noted in a
/// journal that this process alone writes. Returns the runs that failed, with their reasons; `None` in place of a reason is a run that was
/// stopped.
///
/// # Errors
/// If the campaign has no such run, or the runs contradict each other.
pub fn execute_element(
    campaign: &Campaign,
    names: &[String],
    journal: LineWriter,
    executor: &dyn Executor,
    laboratory: &Laboratory,
    at_once: usize,
    observer: &dyn CampaignObserver,
) -> std::result::Result<Vec<(String, Option<String>)>, QueueError> {
    let queue = Queue::new(with_samples(campaign, names)?)?;
    let noting = Noting { queue: &queue, journal: Mutex::new(journal), observer };
    let outcomes = queue.run_by(executor, laboratory, at_once.max(1), &noting);
    let left = |(run, outcome): (&QueuedRun, &Outcome)| match outcome {
        outcome if outcome.is_finished() => None,
        outcome => Some((run.name.clone(), outcome.failure())),
    };
    Ok(queue.runs().iter().zip(&outcomes).filter_map(left).collect())
}

/// The runs of these names, with the samples for which they wait before them.
fn with_samples(campaign: &Campaign, names: &[String]) -> Result<Vec<QueuedRun>> {
    // An element that begins again may have runs that were taken in since, and whose folders are gone.
    let rows = campaign.rows_kept()?;
    let taken: BTreeSet<&str> = campaign
        .runs()
        .iter()
        .filter(|run| campaign.has_rows(&rows, run))
        .map(|run| run.name.as_str())
        .collect();
    let left = names.iter().filter(|name| !taken.contains(name.as_str()));
    let asked = left.map(|name| campaign.queued(name)).collect::<Result<Vec<_>>>()?;
    let mut seen: BTreeSet<String> = names.iter().cloned().collect();
    let mut all = Vec::new();
    for sample in asked.iter().filter_map(|run| run.after.as_ref()) {
        if seen.insert(sample.clone()) {
            all.push(campaign.queued(sample)?);
        }
    }
    all.extend(asked);
    Ok(all)
}

/// Notes what happens to the runs.
struct Noting<'a> {
    queue: &'a Queue,
    journal: Mutex<LineWriter>,
    observer: &'a dyn CampaignObserver,
}

impl Noting<'_> {
    fn note(&self, run: usize, event: JournalEvent) {
        let mut journal = self.journal.lock().unwrap_or_else(PoisonError::into_inner);
        // What cannot be noted is found in the folder of the run.
        if let Err(error) = journal.note(&self.queue.runs()[run].name, event) {
            self.observer.warn(&format!("cannot write the journal of the job: {error}"));
        }
    }
}

impl QueueObserver for Noting<'_> {
    fn begins(&self, run: usize) {
        self.note(run, JournalEvent::Begun);
    }

    fn warn(&self, run: usize, text: &str) {
        self.observer.warn(&format!("{}: {text}", self.queue.runs()[run].name));
    }

    fn ends(&self, run: usize, outcome: &Outcome) {
        if let Some(event) = JournalEvent::of_outcome(outcome) {
            self.note(run, event);
        }
    }

    fn flow(&self) -> Flow {
        self.observer.flow()
    }
}
