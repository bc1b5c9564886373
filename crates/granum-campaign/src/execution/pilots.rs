//! Pilot runs: a few runs of a campaign, executed for a short while somewhere else, by which the time, the memory and the disk of the
//! whole are estimated.

use std::path::Path;
use std::time::{Duration, Instant};

use granum_dem::observer::Flow;
use granum_io::{OutputFolder, RunStatus};
use granum_run::Laboratory;
use granum_run::queue::{Outcome, Queue, QueueError, QueueObserver, QueuedRun, RunKind, TEST_BEGINS_AT};

use super::child_processes::ChildProcesses;
use crate::campaign::Campaign;

/// How pilot runs are made.
#[derive(Clone, Copy, Debug)]
pub struct PilotOptions {
    /// Number of pilot runs.
    pub count: usize,
    /// Longest time of a pilot run; one that is not finished by then is judged by its completed share.
    pub longest: Duration,
    /// Number of runs at once, in the pilots and in the campaign.
    pub workers: usize,
}

/// What a pilot run showed.
#[derive(Clone, Debug, PartialEq)]
pub struct Pilot {
    /// Name of the run.
    pub name: String,
    /// Seconds that the whole run takes.
    pub seconds: f64,
    /// True if it was finished, so that the seconds were measured.
    pub finished: bool,
    /// True if it reached its test; otherwise the seconds are uncertain.
    pub in_test: bool,
    /// Largest memory of its process, bytes, if the system tells.
    pub memory: Option<u64>,
    /// Size of its folder, bytes.
    pub disk: u64,
    /// Seconds for each unit of expected work.
    pace: f64,
}

/// The estimate for a campaign.
#[derive(Clone, Debug, PartialEq)]
pub struct CampaignEstimate {
    /// The pilot runs.
    pub pilots: Vec<Pilot>,
    /// Number of runs at once.
    pub workers: usize,
    /// Seconds of wall time, by the mean pace of the pilots.
    pub seconds: f64,
    /// The same by the fastest and by the slowest pilot.
    pub between: [f64; 2],
    /// Largest memory of a run, bytes, if the system tells.
    pub memory: Option<u64>,
    /// Size of all folders, bytes.
    pub disk: f64,
    /// Pilot runs that failed, with their reasons.
    pub failed: Vec<(String, String)>,
}

/// Makes pilot runs of a campaign in an empty folder elsewhere, and estimates the whole from them; `None` if every pilot failed or the
/// observer stopped them. The pilots are the run with the least work, that with the most, and some between.
///
/// # Errors
/// If the folder cannot be written.
pub fn pilots(
    campaign: &Campaign,
    folder: &Path,
    laboratory: &Laboratory,
    executor: &ChildProcesses,
    options: PilotOptions,
    flow: &(dyn Fn() -> Flow + Sync),
) -> Result<Option<CampaignEstimate>, QueueError> {
    let all = campaign.all_queued()?;
    let work: Vec<f64> = all.iter().map(QueuedRun::expected_work).collect();
    let whole: f64 = work.iter().sum();
    let elsewhere = campaign.elsewhere(folder);
    let _locked = OutputFolder::create(folder, false)?;
    elsewhere.write()?;
    let chosen = chosen(campaign, &all, options.count);
    let runs = chosen.iter().map(|name| elsewhere.queued(name)).collect::<granum_io::Result<Vec<_>>>()?;
    let (mut found, mut failed) = (Vec::new(), Vec::new());
    // So many at once as in the campaign, each with its full time.
    for together in runs.chunks(options.workers.max(1)) {
        // Each pilot prepares its sample itself.
        let alone = together.iter().map(|run| QueuedRun { after: None, ..run.clone() });
        let queue = Queue::new(alone.collect())?;
        let watch = Watch { longest: options.longest, begun: Instant::now(), flow };
        let outcomes = queue.run_by(executor, laboratory, together.len(), &watch);
        for (number, (run, outcome)) in queue.runs().iter().zip(&outcomes).enumerate() {
            match outcome.failure() {
                Some(why) => failed.push((run.name.clone(), why)),
                None => found.extend(pilot(number, run, outcome, executor)),
            }
        }
    }
    if found.is_empty() && failed.is_empty() {
        return Ok(None);
    }
    let paces: Vec<f64> = found.iter().map(|pilot: &Pilot| pilot.pace).collect();
    let count = paces.len().max(1) as f64;
    let seconds = |pace: f64| whole * pace / options.workers.max(1) as f64;
    let runs = all.len() as f64;
    Ok(Some(CampaignEstimate {
        workers: options.workers,
        seconds: seconds(paces.iter().sum::<f64>() / count),
        between: [
            seconds(paces.iter().copied().fold(f64::INFINITY, f64::min)),
            seconds(paces.iter().copied().fold(0.0, f64::max)),
        ],
        memory: found.iter().filter_map(|pilot| pilot.memory).max(),
        disk: found.iter().map(|pilot| pilot.disk as f64).sum::<f64>() / count * runs,
        pilots: found,
        failed,
    }))
}

/// The names of the pilots, at equal steps of the order by expected work.
fn chosen(campaign: &Campaign, all: &[QueuedRun], count: usize) -> Vec<String> {
    let mut tests: Vec<&QueuedRun> = all.iter().filter(|run| run.kind == RunKind::Test).collect();
    tests.sort_by(|a, b| a.expected_work().total_cmp(&b.expected_work()));
    let last = campaign.runs().len().min(tests.len()).saturating_sub(1);
    let count = count.min(last + 1);
    let mut places: Vec<usize> =
        (0..count).map(|k| if count > 1 { k * last / (count - 1) } else { last / 2 }).collect();
    places.dedup();
    places.into_iter().filter_map(|place| Some(tests.get(place)?.name.clone())).collect()
}

fn pilot(number: usize, run: &QueuedRun, outcome: &Outcome, executor: &ChildProcesses) -> Option<Pilot> {
    let followed = executor.followed(number)?;
    let record = outcome.record();
    let finished = record.is_some_and(|record| record.status == RunStatus::Finished);
    let seconds = match followed.test_begun {
        _ if finished => followed.seconds,
        // The share of the test that is done is known from its strain.
        Some(begun) if followed.share > TEST_BEGINS_AT => {
            let done = (followed.share - TEST_BEGINS_AT) / (1.0 - TEST_BEGINS_AT);
            begun + (followed.seconds - begun) / done
        }
        _ if followed.share > 0.0 => followed.seconds / followed.share,
        _ => return None,
    };
    Some(Pilot {
        name: run.name.clone(),
        seconds,
        finished,
        in_test: followed.test_begun.is_some() || finished,
        memory: followed.memory,
        disk: size_of(&run.folder),
        pace: seconds / run.expected_work(),
    })
}

/// The size of all files below a folder, bytes.
fn size_of(folder: &Path) -> u64 {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let size = |entry: std::fs::DirEntry| match entry.metadata() {
        Ok(about) if about.is_dir() => size_of(&entry.path()),
        Ok(about) => about.len(),
        Err(_) => 0,
    };
    entries.map(size).sum()
}

/// Stops the pilots when their time is over.
struct Watch<'a> {
    longest: Duration,
    begun: Instant,
    flow: &'a (dyn Fn() -> Flow + Sync),
}

impl QueueObserver for Watch<'_> {
    fn flow(&self) -> Flow {
        if self.begun.elapsed() >= self.longest { Flow::Stop } else { (self.flow)() }
    }
}

impl CampaignEstimate {
    /// Seconds of one run for each unit of its expected work, by the mean of the pilots; `None` if all of them failed.
    pub fn pace(&self) -> Option<f64> {
        let count = self.pilots.len() as f64;
        (count > 0.0).then(|| self.pilots.iter().map(|pilot| pilot.pace).sum::<f64>() / count)
    }

    /// The number of pilots that were not finished in their time.
    pub fn unfinished(&self) -> usize {
        self.pilots.iter().filter(|pilot| !pilot.finished).count()
    }
}
