//! The runs of a campaign on a cluster with Slurm: arrays of jobs, each element with the runs that fit into the time of a job.
//!
//! Slurm alone knows which elements wait and go on, and is asked each time; what an element did is in the folders of its runs and in a
//! journal that it alone writes. An element that Slurm does not know any more is over, and those of its runs that are not finished are
//! submitted again, to go on from their checkpoints.

mod cluster;
mod script;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::time::Duration;

use granum_core::input::read_text;
use granum_io::Error;
use granum_run::Flow;
use granum_run::queue::{Queue, QueuedRun};

use self::cluster::Queued;
use super::job_record::{JOBS, JobRecord, element_journal, element_log};
use super::packing::{Filling, pack};
use super::scheduler_error::SchedulerError;
use super::scheduler_trait::{Order, Scheduler, SchedulerKind, SchedulerOptions, Submission, Submitted};
use crate::campaign::{Campaign, RUNS, SAMPLES, holds_finished};
use crate::claim::{CLAIMS, Claimant};
use crate::data_set::{self, Collected};
use crate::execution::{CAMPAIGN_CLAIM, CampaignObserver};
use crate::jobs::{JobState, Jobs, Place};
use crate::journal::{JournalEvent, last_events, last_events_in};

/// Its entry in the registry.
pub(super) const KIND: SchedulerKind = SchedulerKind {
    name: "slurm",
    help: "on a cluster with Slurm, many runs in each element of an array of jobs; the command ends when they are queued",
    make: |options| Box::new(Slurm(options)),
};

/// The time of a job if none is stated.
const USUAL_TIME: Duration = Duration::from_secs(3600);
/// The part of the time of a job that its runs are expected to take.
const FILLED: f64 = 0.8;
/// Longest log of an element that is looked into.
const LONGEST_LOG: u64 = 1 << 20;
/// Number of elements of a job of which it is told what they said last.
const MOST_SAID: usize = 3;

/// Executes runs by Slurm.
struct Slurm(SchedulerOptions);

impl Scheduler for Slurm {
    fn packs(&self) -> bool {
        true
    }

    fn check(&self) -> Result<(), SchedulerError> {
        cluster::queued().map(drop)
    }

    fn submit(
        &self,
        order: &Order<'_>,
        observer: &dyn CampaignObserver,
    ) -> Result<Submitted, SchedulerError> {
        order.folder.refuse_links(&[RUNS, SAMPLES, JOBS, CLAIMS])?;
        let campaign = order.campaign;
        let mut claimant = Claimant::new(campaign.folder(), CAMPAIGN_CLAIM);
        let stops = || observer.flow() == Flow::Stop;
        let Some(_claim) =
            claimant.take_unless_alive(&stops, &|words| observer.warn(&format!("the campaign {words}")))?
        else {
            let (path, holder) = (campaign.folder().to_path_buf(), claimant.holder());
            return Err(Error::Locked { path, holder }.into());
        };
        let limits = cluster::limits(self.0.account.as_deref(), self.0.partition.as_deref())?;
        let TakenUp { queued, mut open, .. } = self.take_up(campaign)?;
        if order.replace_others {
            Queue::new(campaign.all_queued()?)?.replace_others(order.laboratory)?;
        }
        let given: BTreeSet<String> =
            open.iter().flat_map(|(record, elements)| names_in(record, elements)).collect();
        let left = left(campaign, order.again, &given)?;
        let packing = pack(&left.tests, &left.samples, self.filling(order.pace)?);
        let mut room = Room {
            limits: limits.jobs,
            free: limits.jobs.map(|(most, _)| most.saturating_sub(queued.len())),
        };
        let mut done = Submission::default();
        for (elements, are_tests) in [(packing.samples, false), (packing.tests, true)] {
            let mut chunks = elements.chunks(limits.array);
            while let Some(chunk) = chunks.next() {
                let taken = room.take(chunk.len());
                let rest = chunk[taken..].iter().chain(chunks.clone().flatten());
                if taken > 0 {
                    let before = after(campaign, &chunk[..taken], &open, are_tests)?;
                    match self.submit_array(campaign, &chunk[..taken], &before) {
                        Ok(record) => {
                            done.note(&record, are_tests);
                            let running = (0..taken).map(|k| (k, Place::Queued)).collect();
                            open.push((record, running));
                        }
                        Err(error) if done.jobs.is_empty() => return Err(error),
                        Err(error) => {
                            observer.warn(&format!("no further jobs are taken at present: {error}"));
                            room = Room { limits: None, free: Some(0) };
                            let all = chunk.iter().chain(chunks.clone().flatten());
                            done.wait(all.map(Vec::len).sum(), are_tests, "the refusal");
                            break;
                        }
                    }
                }
                if taken < chunk.len() {
                    done.wait(rest.map(Vec::len).sum(), are_tests, &room.why());
                    break;
                }
            }
        }
        Ok(Submitted::Queued(done))
    }

    fn poll(&self, campaign: &Campaign) -> Result<Jobs, SchedulerError> {
        let records = records(campaign)?;
        if records.is_empty() {
            return Ok(Jobs::default());
        }
        let queued = cluster::queued()?;
        let mut all = Jobs::default();
        for record in &records {
            let known = elements_of(record, &queued);
            let count = |place: Place| known.values().filter(|known| known.place == place).count();
            let (waiting, running) = (count(Place::Queued), count(Place::Running));
            let reasons = known
                .values()
                .filter(|known| known.place == Place::Queued)
                .map(|known| known.reason.clone())
                .filter(|reason| reason != "None");
            let mut said = Vec::new();
            for (k, names) in record.elements.iter().enumerate() {
                let place = known.get(&k).map_or(Place::Over, |known| known.place);
                for name in names {
                    let held = all.places.entry(name.clone()).or_insert(place);
                    *held = place.max(*held);
                }
                if place == Place::Over
                    && said.len() < MOST_SAID
                    && !is_whole(campaign, names, record.number, k)
                {
                    said.extend(last_word(campaign.folder(), record, k));
                }
            }
            all.jobs.push(JobState {
                job: record.id.clone().unwrap_or_else(|| record.name.clone()),
                queued: waiting,
                running,
                over: record.elements.len().saturating_sub(waiting + running),
                reasons: reasons.collect::<BTreeSet<_>>().into_iter().collect(),
                said,
            });
        }
        Ok(all)
    }

    fn cancel(&self, campaign: &Campaign) -> Result<usize, SchedulerError> {
        let records = records(campaign)?;
        let queued = if records.is_empty() { Vec::new() } else { cluster::queued()? };
        let jobs: BTreeSet<String> = records
            .iter()
            .flat_map(|record| elements_of(record, &queued).into_values())
            .map(|known| known.job.clone())
            .collect();
        jobs.iter().try_for_each(|job| cluster::cancel(job))?;
        Ok(jobs.len())
    }

    fn collect(
        &self,
        campaign: &Campaign,
        flow: &(dyn Fn() -> Flow + Sync),
    ) -> Result<Collected, SchedulerError> {
        let added = self.take_up(campaign)?.added;
        let collected = data_set::collect(campaign, flow)?;
        Ok(Collected { added: added + collected.added, ..collected })
    }
}

/// What was taken up.
struct TakenUp {
    /// All that waits or goes on of this user.
    queued: Vec<Queued>,
    /// The jobs that are not over.
    open: Vec<Open>,
    /// Number of runs that are finished since the last time.
    added: usize,
}

/// An open job with the elements of it that wait or go on.
type Open = (JobRecord, BTreeMap<usize, Place>);

impl Slurm {
    /// Takes up what elements did, and closes the jobs of which Slurm knows no element any more.
    fn take_up(&self, campaign: &Campaign) -> Result<TakenUp, SchedulerError> {
        let folder = campaign.folder();
        let before = finished_in(&last_events(folder));
        let queued = cluster::queued()?;
        let mut open = Vec::new();
        let mut events = BTreeMap::new();
        let mut over = Vec::new();
        for mut record in records(campaign)? {
            let known = elements_of(&record, &queued);
            for k in 0..record.elements.len() {
                // Interruptions are no news: the folder of the run tells them.
                let ended = last_events_in(&element_journal(folder, record.number, k)).into_iter();
                events.extend(ended.filter(|(_, event)| {
                    matches!(event, JournalEvent::Finished { .. } | JournalEvent::Failed { .. })
                }));
            }
            if known.is_empty() {
                over.push(record);
                continue;
            }
            if record.id.is_none() {
                // The process that submitted it was killed before it had noted how Slurm calls it.
                record.id = known.values().next().map(|known| known.job.clone());
                record.write(folder)?;
            }
            let places = known.iter().map(|(k, known)| (*k, known.place)).collect();
            open.push((record, places));
        }
        campaign.take_up(events)?;
        campaign.collect()?;
        // What they did is in the journal now.
        let journal = last_events(folder);
        for mut record in over {
            let is_done = |name: &String| {
                name.starts_with("sample ")
                    || matches!(journal.get(name), Some(JournalEvent::Finished { .. }))
            };
            if record.elements.iter().flatten().all(is_done) {
                record.remove(folder);
            } else {
                record.closed = true;
                record.write(folder)?;
            }
        }
        Ok(TakenUp { queued, open, added: finished_in(&journal).saturating_sub(before) })
    }

    fn filling(&self, pace: Option<f64>) -> Result<Filling, SchedulerError> {
        let time = self.0.time.unwrap_or(USUAL_TIME);
        match (self.0.per_task, pace) {
            (Some(count), _) => Ok(Filling::Runs(count.max(1))),
            (None, Some(pace)) => {
                Ok(Filling::Seconds { of_element: FILLED * time.as_secs_f64(), of_work: pace })
            }
            (None, None) => Err(SchedulerError::Option(
                "it is not known how long the runs take; say how many of them a job has with --per-task"
                    .into(),
            )),
        }
    }

    fn submit_array(
        &self,
        campaign: &Campaign,
        elements: &[Vec<String>],
        after: &[String],
    ) -> Result<JobRecord, SchedulerError> {
        let folder =
            std::path::absolute(campaign.folder()).map_err(Error::file("find", campaign.folder()))?;
        let here = std::env::current_dir().map_err(Error::file("find", Path::new(".")))?;
        let mut record = JobRecord::new(&folder, KIND.name, elements.to_vec())?;
        record.write(&folder)?;
        let script = record.script(&folder);
        let text = script::script(&self.0, &here, &record);
        let submitted = std::fs::write(&script, text)
            .map_err(|error| Error::file("write", &script)(error).into())
            .and_then(|()| {
                let arguments = script::arguments(&self.0, &record, after);
                cluster::submit(&folder.join(JOBS), &arguments, script.file_name().unwrap_or_default())
            });
        match submitted {
            Ok(id) => {
                record.id = Some(id);
                record.write(&folder)?;
                Ok(record)
            }
            Err(error) => {
                record.remove(&folder);
                Err(error)
            }
        }
    }
}

/// The open jobs of Slurm.
fn records(campaign: &Campaign) -> Result<Vec<JobRecord>, SchedulerError> {
    let all = JobRecord::open_in(campaign.folder())?;
    Ok(all.into_iter().filter(|record| record.scheduler == KIND.name).collect())
}

/// The elements of a job that wait or go on.
fn elements_of<'a>(record: &JobRecord, queued: &'a [Queued]) -> BTreeMap<usize, &'a Queued> {
    let is_its = |known: &&Queued| known.name == record.name && known.place != Place::Over;
    queued.iter().filter(is_its).filter_map(|known| Some((known.element?, known))).collect()
}

/// The runs and samples of the elements of a job that wait or go on.
fn names_in(record: &JobRecord, elements: &BTreeMap<usize, Place>) -> Vec<String> {
    elements.keys().filter_map(|k| record.elements.get(*k)).flatten().cloned().collect()
}

fn finished_in(events: &BTreeMap<String, JournalEvent>) -> usize {
    events.values().filter(|event| matches!(event, JournalEvent::Finished { .. })).count()
}

/// True if the journal of an element tells that all of its runs are finished.
fn is_whole(campaign: &Campaign, names: &[String], job: usize, element: usize) -> bool {
    let events = last_events_in(&element_journal(campaign.folder(), job, element));
    names.iter().all(|name| matches!(events.get(name), Some(JournalEvent::Finished { .. })))
}

/// Why an element ended, as Slurm wrote it into its log, or otherwise the last line there.
fn last_word(folder: &Path, record: &JobRecord, element: usize) -> Option<String> {
    let text = read_text(&element_log(folder, record.number, element), LONGEST_LOG).ok()?;
    let lines = || text.lines().map(str::trim).filter(|line| !line.is_empty());
    let line = lines().rfind(|line| line.starts_with("slurmstepd")).or_else(|| lines().next_back())?;
    Some(format!("element {element}: {line}"))
}

/// What is left of a campaign.
struct Left {
    tests: Vec<QueuedRun>,
    /// Samples that are not finished and not given to Slurm, by their names.
    samples: BTreeMap<String, QueuedRun>,
}

/// The runs that are neither finished nor given to Slurm, and their samples. The folders of the runs and the rows of those that were taken
/// in decide, not the journal.
fn left(campaign: &Campaign, again: bool, given: &BTreeSet<String>) -> Result<Left, SchedulerError> {
    let (known, rows) = (last_events(campaign.folder()), campaign.rows_kept()?);
    let is_lasting =
        |name: &str| !again && matches!(known.get(name), Some(JournalEvent::Failed { lasting: true, .. }));
    let (mut tests, mut samples) = (Vec::new(), BTreeMap::new());
    for run in campaign.runs() {
        if given.contains(&run.name) || is_lasting(&run.name) || campaign.is_finished(run, &rows) {
            continue;
        }
        let queued = campaign.queued(&run.name)?;
        if let Some(name) = &queued.after
            && !given.contains(name)
            && !samples.contains_key(name)
        {
            let sample = campaign.queued(name)?;
            if !holds_finished(&sample.folder) {
                samples.insert(name.clone(), sample);
            }
        }
        tests.push(queued);
    }
    Ok(Left { tests, samples })
}

/// The jobs that must be over before elements begin: those that prepare samples which these need.
fn after(
    campaign: &Campaign,
    elements: &[Vec<String>],
    open: &[Open],
    are_tests: bool,
) -> Result<Vec<String>, SchedulerError> {
    if !are_tests {
        return Ok(Vec::new());
    }
    let mut samples = BTreeSet::new();
    for name in elements.iter().flatten() {
        samples.extend(campaign.queued(name)?.after);
    }
    let prepares =
        |(record, places): &&Open| names_in(record, places).iter().any(|name| samples.contains(name));
    Ok(open.iter().filter(prepares).filter_map(|(record, _)| record.id.clone()).collect())
}

/// How many elements Slurm still takes.
struct Room {
    limits: Option<(usize, &'static str)>,
    free: Option<usize>,
}

impl Room {
    /// Takes room for so many, or for fewer.
    fn take(&mut self, wanted: usize) -> usize {
        let taken = self.free.map_or(wanted, |free| free.min(wanted));
        self.free = self.free.map(|free| free - taken);
        taken
    }

    fn why(&self) -> String {
        self.limits.map_or_else(|| "the refusal".into(), |(most, name)| format!("{name} = {most}"))
    }
}

impl Submission {
    fn note(&mut self, record: &JobRecord, are_tests: bool) {
        self.jobs.extend(record.id.clone());
        self.elements += record.elements.len();
        if are_tests {
            self.runs += record.elements.iter().map(Vec::len).sum::<usize>();
        }
    }

    fn wait(&mut self, runs: usize, are_tests: bool, why: &str) {
        let runs = if are_tests { runs } else { 0 };
        let before = self.waiting.take().map_or(0, |(runs, _)| runs);
        self.waiting = Some((before + runs, why.to_string()));
    }
}
