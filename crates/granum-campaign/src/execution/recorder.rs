//! What happens in a campaign, written into its journal and its file of progress, and passed on to whoever follows.

use std::collections::{BTreeMap, VecDeque};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use granum_dem::observer::{Flow, SimulationProgress};
use granum_io::Result;
use granum_run::queue::{Outcome, Queue, QueueObserver, RunKind, Shares};

use super::taking_in::TakingIn;
use crate::acceptance::is_accepted;
use crate::clock::readable;
use crate::journal::{JOURNAL, JournalEvent, LineWriter};
use crate::plan::Condition;

/// The file to which a line is added every minute.
pub const PROGRESS_FILE: &str = "progress.txt";
/// A file whose presence asks the coordinator to end all runs in good order.
pub const STOP_REQUEST: &str = "stop-requested";
/// The claim of the process that gives out the runs of a campaign. Runs are named by digits.
pub const CAMPAIGN_CLAIM: &str = "campaign";
/// How often it is looked for a request.
const LOOK_EVERY: Duration = Duration::from_secs(1);
/// Time between two lines of it.
const LINE_EVERY: Duration = Duration::from_secs(60);
/// The rate is that of so many minutes.
const MINUTES_OF_RATE: usize = 15;

/// Follows a campaign. It is called from several threads and cannot change a result.
pub trait CampaignObserver: Sync {
    /// How far the campaign is.
    fn progress(&self, progress: &CampaignProgress) {
        let _ = progress;
    }

    /// Something that the user should know.
    fn warn(&self, text: &str) {
        let _ = text;
    }

    /// Asked often: after [`Flow::Stop`] all runs end in good order.
    fn flow(&self) -> Flow {
        Flow::Continue
    }
}

/// The observer of a campaign that none follows.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoCampaignObserver;

impl CampaignObserver for NoCampaignObserver {}

/// How far a campaign is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CampaignProgress {
    /// Number of the runs of the plan; samples are not counted.
    pub runs: usize,
    /// Number of runs that are finished.
    pub finished: usize,
    /// Those of them that did not pass a check.
    pub flagged: usize,
    /// Those of them that did not pass a check and are not accepted.
    pub refused: usize,
    /// Number of runs that failed.
    pub failed: usize,
    /// Number of runs and samples that go on at present.
    pub running: usize,
    /// The completed share of all work, from 0 to 1.
    pub share: f64,
    /// Runs an hour, if it is known.
    pub runs_per_hour: Option<f64>,
    /// Time left, if it is known.
    pub left: Option<Duration>,
}

impl CampaignProgress {
    /// The progress in one line.
    pub fn line(&self) -> String {
        let mut parts = vec![format!("{} of {} runs finished", self.finished, self.runs)];
        if self.failed > 0 {
            parts.push(format!("{} failed", self.failed));
        }
        if self.flagged > 0 {
            parts.push(format!("{} flagged", self.flagged));
        }
        if self.running > 0 {
            parts.push(format!("{} running", self.running));
        }
        parts.extend(self.runs_per_hour.map(|rate| format!("{rate:.0} runs an hour")));
        parts.extend(self.left.map(|left| format!("{} left", readable(left))));
        parts.join(", ")
    }
}

/// Writes what happens.
pub(super) struct Recorder<'a> {
    queue: &'a Queue,
    observer: &'a dyn CampaignObserver,
    accept: Vec<Condition>,
    /// What the journal already knows.
    known: BTreeMap<String, JournalEvent>,
    /// Takes runs in whose folders are to go.
    taking_in: Option<TakingIn>,
    elapsed: Elapsed,
    /// The time by that clock at which all runs are to end.
    stop_after: Option<Duration>,
    request: Mutex<Request>,
    held: Mutex<Held>,
}

/// The request of another process to end all runs.
struct Request {
    file: PathBuf,
    looked: Duration,
    was_made: bool,
}

impl Request {
    fn is_made(&mut self, now: Duration) -> bool {
        if !self.was_made && now.saturating_sub(self.looked) >= LOOK_EVERY {
            self.looked = now;
            self.was_made = self.file.exists();
        }
        self.was_made
    }
}

/// Forgets a request that an earlier coordinator was not there to follow any more. What comes later concerns the one that now has the claim,
/// even while it still reads what its runs are.
pub(super) fn forget_request(folder: &Path) {
    let _ = std::fs::remove_file(folder.join(STOP_REQUEST));
}

/// The time since the coordinator began, by a clock that does not jump; a test has its own.
pub(super) type Elapsed = Box<dyn Fn() -> Duration + Send + Sync>;

/// The clock of the system that never goes back.
pub(super) fn steady_clock() -> Elapsed {
    let begun = Instant::now();
    Box::new(move || begun.elapsed())
}

struct Held {
    journal: LineWriter,
    progress_file: LineWriter,
    shares: Shares,
    counts: CampaignProgress,
    /// Share of the work that was done when this coordinator began.
    share_before: f64,
    begun: Duration,
    last_line: Duration,
    /// The numbers of finished runs at the last lines.
    pace: VecDeque<(Duration, usize)>,
    warned: bool,
}

impl<'a> Recorder<'a> {
    /// A recorder for a queue in the folder of a campaign.
    pub(super) fn new(
        queue: &'a Queue,
        folder: &Path,
        accept: Vec<Condition>,
        known: BTreeMap<String, JournalEvent>,
        counts: CampaignProgress,
        stop_after: Option<Duration>,
        elapsed: Elapsed,
        taking_in: Option<TakingIn>,
        observer: &'a dyn CampaignObserver,
    ) -> Result<Recorder<'a>> {
        let now = elapsed();
        let held = Held {
            journal: LineWriter::open(&folder.join(JOURNAL))?,
            progress_file: LineWriter::open(&folder.join(PROGRESS_FILE))?,
            shares: Shares::new(queue),
            counts,
            share_before: 0.0,
            begun: now,
            last_line: now,
            pace: VecDeque::new(),
            warned: false,
        };
        let request = Mutex::new(Request { file: folder.join(STOP_REQUEST), looked: now, was_made: false });
        let held = Mutex::new(held);
        Ok(Recorder { queue, observer, accept, known, taking_in, elapsed, stop_after, request, held })
    }

    /// What was counted; a last line is added to the file of progress.
    pub(super) fn end(self) -> CampaignProgress {
        let mut held = self.lock();
        self.write_line(&mut held);
        let _ = std::fs::remove_file(&self.request.lock().unwrap_or_else(PoisonError::into_inner).file);
        held.counts.clone()
    }

    /// Begins to measure the rate, when the first run begins and what was finished before is known.
    fn begin(&self, held: &mut Held) {
        if !held.pace.is_empty() {
            return;
        }
        held.share_before = held.shares.all();
        held.begun = (self.elapsed)();
        held.pace.push_back((held.begun, held.counts.finished));
        self.write_line(held);
    }

    fn lock(&self) -> MutexGuard<'_, Held> {
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn is_test(&self, run: usize) -> bool {
        self.queue.runs()[run].kind == RunKind::Test
    }

    /// Takes in a finished test that is part of the data set.
    fn take_in(&self, run: usize, outcome: &Outcome) {
        let (Some(taking_in), Outcome::Finished { record, .. }) = (&self.taking_in, outcome) else { return };
        let is_part = match JournalEvent::finished(record) {
            JournalEvent::Finished { flags, .. } => is_accepted(&flags, &self.accept),
            _ => false,
        };
        if is_part
            && self.is_test(run)
            && let Err(error) = taking_in.take(self.queue, run)
        {
            let name = &self.queue.runs()[run].name;
            self.observer.warn(&format!("{name}: its folder stays for now: {error}"));
        }
    }

    fn note(&self, held: &mut Held, run: usize, event: JournalEvent) {
        let result = held.journal.note(&self.queue.runs()[run].name, event);
        self.warn_once(held, JOURNAL, result);
    }

    /// The journal and the file of progress are no part of the results: a full disk is told once.
    fn warn_once(&self, held: &mut Held, file: &str, result: std::io::Result<()>) {
        if let Err(error) = result
            && !held.warned
        {
            held.warned = true;
            self.observer
                .warn(&format!("cannot write {file}: {error}; the runs themselves are not concerned"));
        }
    }

    fn write_line(&self, held: &mut Held) {
        held.last_line = (self.elapsed)();
        self.measure(held);
        let line = held.counts.line();
        let result = held.progress_file.append(|time| format!("{time} {line}"));
        self.warn_once(held, PROGRESS_FILE, result);
    }

    /// Share, rate and time left.
    fn measure(&self, held: &mut Held) {
        held.counts.share = held.shares.all();
        let now = (self.elapsed)();
        let elapsed = now.saturating_sub(held.begun);
        let done = held.counts.share - held.share_before;
        let is_known = done > 0.0 && elapsed > Duration::from_secs(2);
        held.counts.left = is_known
            .then(|| elapsed.mul_f64(((1.0 - held.counts.share) / done).clamp(0.0, 1e9)))
            .filter(|_| held.counts.share < 1.0);
        if let Some((since, before)) = held.pace.front() {
            let hours = now.saturating_sub(*since).as_secs_f64() / 3600.0;
            let finished = held.counts.finished.saturating_sub(*before);
            held.counts.runs_per_hour = (finished > 0 && hours > 0.0).then(|| finished as f64 / hours);
        }
    }

    fn follow(&self, held: &mut Held) {
        self.measure(held);
        self.observer.progress(&held.counts);
        let now = (self.elapsed)();
        if now.saturating_sub(held.last_line) >= LINE_EVERY {
            self.write_line(held);
            let finished = held.counts.finished;
            held.pace.push_back((now, finished));
            while held.pace.len() > MINUTES_OF_RATE {
                held.pace.pop_front();
            }
        }
    }
}

impl QueueObserver for Recorder<'_> {
    fn begins(&self, run: usize) {
        let mut held = self.lock();
        self.begin(&mut held);
        held.counts.running += 1;
        self.note(&mut held, run, JournalEvent::Begun);
        self.follow(&mut held);
    }

    fn progress(&self, run: usize, progress: &SimulationProgress) -> Flow {
        let mut held = self.lock();
        held.shares.update(run, progress);
        self.follow(&mut held);
        drop(held);
        self.flow()
    }

    fn share(&self, run: usize, share: f64) -> Flow {
        let mut held = self.lock();
        held.shares.set(run, share);
        self.follow(&mut held);
        drop(held);
        self.flow()
    }

    fn warn(&self, run: usize, text: &str) {
        self.observer.warn(&format!("{}: {text}", self.queue.runs()[run].name));
    }

    fn ends(&self, run: usize, outcome: &Outcome) {
        self.take_in(run, outcome);
        let mut held = self.lock();
        held.shares.end(run, outcome);
        let is_new = !matches!(outcome, Outcome::Finished { reused: true, .. } | Outcome::NotNeeded);
        held.counts.running -= usize::from(is_new && held.counts.running > 0);
        let event = JournalEvent::of_outcome(outcome);
        let name = &self.queue.runs()[run].name;
        if self.is_test(run) {
            match &event {
                Some(JournalEvent::Finished { flags, .. }) => {
                    held.counts.finished += 1;
                    held.counts.flagged += usize::from(!flags.is_empty());
                    held.counts.refused += usize::from(!is_accepted(flags, &self.accept));
                }
                Some(JournalEvent::Failed { .. }) => held.counts.failed += 1,
                _ => {}
            }
        }
        if let Some(event) = event.filter(|event| is_new || self.known.get(name) != Some(event)) {
            if let JournalEvent::Failed { reason, .. } = &event {
                self.observer.warn(&format!("{name}: failed: {reason}"));
            }
            self.note(&mut held, run, event);
        }
        if is_new {
            self.follow(&mut held);
        }
    }

    fn flow(&self) -> Flow {
        let now = (self.elapsed)();
        let is_over = self.stop_after.is_some_and(|time| now >= time);
        let is_asked = || self.request.lock().unwrap_or_else(PoisonError::into_inner).is_made(now);
        if is_over || is_asked() { Flow::Stop } else { self.observer.flow() }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicU64, Ordering};

    use granum_io::Case;
    use granum_run::laboratory::Source;
    use granum_run::queue::QueuedRun;

    use super::*;

    /// A clock that a test sets, in seconds.
    fn clock() -> (Arc<AtomicU64>, Elapsed) {
        let seconds = Arc::new(AtomicU64::new(0));
        let clock = seconds.clone();
        (seconds, Box::new(move || Duration::from_secs(clock.load(Ordering::Relaxed))))
    }

    fn recorder<'a>(
        queue: &'a Queue,
        folder: &Path,
        counts: CampaignProgress,
        stop_after: Option<Duration>,
        elapsed: Elapsed,
    ) -> Recorder<'a> {
        let (accept, known) = (Vec::new(), BTreeMap::new());
        Recorder::new(queue, folder, accept, known, counts, stop_after, elapsed, None, &NoCampaignObserver)
            .unwrap()
    }

    /// Three hours of a campaign of two runs, by a clock of the test that stands still, runs and leaps: a line at the beginning, one for
    /// each minute in which something was heard, and one at the end.
    #[test]
    fn the_file_of_progress_has_a_line_a_minute() {
        let folder = tempfile::tempdir().unwrap();
        let runs = ["a", "b"]
            .map(|name| QueuedRun::test(name, Case::default(), Source::Case, folder.path().join(name)));
        let queue = Queue::new(runs.into()).unwrap();
        let (seconds, elapsed) = clock();
        let counts = CampaignProgress { runs: 2, ..CampaignProgress::default() };
        let recorder = recorder(&queue, folder.path(), counts, Some(Duration::from_secs(10_000)), elapsed);
        let text = || std::fs::read_to_string(folder.path().join(PROGRESS_FILE)).unwrap();
        recorder.begins(0);
        recorder.begins(1);
        assert_eq!(text().lines().count(), 1);
        // Heard four times a second for an hour, by a clock of whole seconds.
        for quarter in 0..4 * 3600_u64 {
            seconds.store(quarter / 4, Ordering::Relaxed);
            recorder.share(0, quarter as f64 / 1e5);
        }
        assert_eq!(text().lines().count(), 60, "{}", text());
        // Nothing is heard for an hour and a half: one line, no sixty.
        seconds.store(9000, Ordering::Relaxed);
        assert_eq!(recorder.share(1, 0.5), Flow::Continue);
        assert_eq!(recorder.share(1, 0.5), Flow::Continue);
        assert_eq!(text().lines().count(), 61);
        // A clock that goes back does no harm.
        seconds.store(10, Ordering::Relaxed);
        recorder.share(1, 0.5);
        seconds.store(10_000, Ordering::Relaxed);
        assert_eq!(recorder.share(1, 0.6), Flow::Stop);
        let last = recorder.end();
        assert_eq!(text().lines().count(), 63);
        let line = text().lines().next_back().unwrap().to_string();
        assert!(line.ends_with(&last.line()) && line.contains("0 of 2 runs finished, 2 running"), "{line}");
        // No line is drawn over another.
        assert!(!text().contains(['\r', '\u{1b}']));
    }

    #[test]
    fn a_request_in_the_folder_ends_the_runs_and_goes_with_the_recorder() {
        let folder = tempfile::tempdir().unwrap();
        let request = folder.path().join(STOP_REQUEST);
        // One that is older than the coordinator does not concern it.
        std::fs::write(&request, "").unwrap();
        forget_request(folder.path());
        let queue = Queue::new(Vec::new()).unwrap();
        let (seconds, elapsed) = clock();
        let recorder = recorder(&queue, folder.path(), CampaignProgress::default(), None, elapsed);
        seconds.store(5, Ordering::Relaxed);
        assert_eq!(recorder.flow(), Flow::Continue);
        std::fs::write(&request, "").unwrap();
        assert_eq!(recorder.flow(), Flow::Continue, "it is not looked for at every step");
        seconds.store(7, Ordering::Relaxed);
        assert_eq!(recorder.flow(), Flow::Stop);
        recorder.end();
        assert!(!request.exists());
    }
}
