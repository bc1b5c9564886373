//! One run of a campaign, as its process executes it.

use std::path::Path;
use std::sync::Mutex;
use std::sync::PoisonError;
use std::thread;
use std::time::{Duration, Instant};

use granum_dem::observer::{Flow, SimulationProgress};
use granum_dem::preparation::Phase;
use granum_io::{OutputFolder, Result};
use granum_run::Laboratory;
use granum_run::LaboratoryError;
use granum_run::queue::{Outcome, Queue, QueueObserver, QueuedRun, RunError, RunKind, Shares};

use crate::campaign::{Campaign, holds_finished};
use crate::claim::{Claimant, Waiting};
use crate::message::{End, Message};

/// Time between two messages of progress.
const TELL_EVERY: Duration = Duration::from_millis(500);
/// How long a run waits for a process that is still at work in its folder: that of a coordinator that was killed ends within
/// seconds, when it has written its checkpoint.
const WAIT_FOR_FOLDER: Duration = Duration::from_secs(120);
/// How often it looks.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// Executes the run of a campaign in its folder, or continues it, and tells what happens. The run ends in good order when `flow` says so.
/// It can be called for any run at any time on any machine that sees the folder: a run that is finished is left as it is.
///
/// # Errors
/// If the campaign cannot be read or has no such run. A run that fails is told by the last message.
pub fn execute_run(
    folder: &Path,
    name: &str,
    laboratory: &Laboratory,
    flow: &(dyn Fn() -> Flow + Sync),
    tell: &(dyn Fn(&Message) + Sync),
) -> Result<End> {
    let campaign = Campaign::read(folder, &laboratory.registry.vocabulary)?.ok_or_else(|| {
        let message = "there is no campaign.json: the folder holds no campaign";
        granum_io::Error::content(folder, message)
    })?;
    let laboratory = &campaign.laboratory(laboratory);
    let run = campaign.queued(name)?;
    let execute = |run: &QueuedRun| execute(folder, run, laboratory, flow, tell);
    let end = match sample_of(&campaign, &run)? {
        // Another process may be at work on it, which is then waited for.
        Some(sample) => match execute(&sample) {
            End::Finished => execute(&run),
            other => other,
        },
        None => execute(&run),
    };
    tell(&Message::Ended { end: end.clone(), memory: peak_memory() });
    Ok(end)
}

/// The preparation of the sample that a run shares with others, unless it is finished or the run needs it no more.
fn sample_of(campaign: &Campaign, run: &QueuedRun) -> Result<Option<QueuedRun>> {
    match &run.after {
        Some(name) if !holds_finished(&run.folder) => {
            let sample = campaign.queued(name)?;
            Ok(Some(sample).filter(|sample| !holds_finished(&sample.folder)))
        }
        _ => Ok(None),
    }
}

/// Largest memory of this process so far, bytes; `None` where the system does not tell it in a file.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kilobytes| kilobytes << 10)
}

/// Executes a run alone, when it has the claim of it.
fn execute(
    campaign: &Path,
    run: &QueuedRun,
    laboratory: &Laboratory,
    flow: &(dyn Fn() -> Flow + Sync),
    tell: &(dyn Fn(&Message) + Sync),
) -> End {
    let mut claimant = Claimant::new(campaign, &run.name);
    let since = Instant::now();
    let mut waiting = Waiting::default();
    let claim = loop {
        match claimant.take() {
            Ok(Some(claim)) => break claim,
            Ok(None) => {}
            Err(error) => return End::Failed { reason: error.to_string(), lasting: false },
        }
        if flow() == Flow::Stop {
            return End::Interrupted;
        }
        // Whoever has claimed a sample is waited for as long as it works, since the tests need it; a test is left to it.
        let is_left = run.kind == RunKind::Test && claimant.is_at_work();
        if is_left && since.elapsed() > WAIT_FOR_FOLDER {
            let reason = format!("another process works on it{}", claimant.holder());
            return End::Failed { reason, lasting: false };
        }
        if let Some(words) = waiting.words(|_| claimant.in_the_way()) {
            tell(&Message::Warning { text: format!("{} {words}", run.name) });
        }
        thread::sleep(LOOK_EVERY);
    };
    let flow = || if claim.is_overruled() { Flow::Stop } else { flow() };
    match execute_claimed(run, laboratory, &flow, tell) {
        End::Interrupted if claim.is_overruled() => {
            let reason = "it was stopped, since its process had not been heard of for long and another one took it over";
            End::Failed { reason: reason.into(), lasting: false }
        }
        end => end,
    }
}

/// Executes a run alone, of which this process has the claim.
fn execute_claimed(
    run: &QueuedRun,
    laboratory: &Laboratory,
    flow: &(dyn Fn() -> Flow + Sync),
    tell: &(dyn Fn(&Message) + Sync),
) -> End {
    // A process that is no part of the campaign may be at work in the folder.
    let since = Instant::now();
    let mut waiting = Waiting::default();
    while let Some(user) = OutputFolder::user(&run.folder).filter(|_| since.elapsed() < WAIT_FOR_FOLDER) {
        if flow() == Flow::Stop {
            return End::Interrupted;
        }
        let most = WAIT_FOR_FOLDER.as_secs();
        if let Some(words) =
            waiting.words(|_| format!("{user}, which uses its folder; it waits {most} s at most"))
        {
            tell(&Message::Warning { text: format!("{} {words}", run.name) });
        }
        thread::sleep(LOOK_EVERY);
    }
    // Its sample is finished before.
    let alone = QueuedRun { after: None, ..run.clone() };
    let queue = match Queue::new(vec![alone]) {
        Ok(queue) => queue,
        Err(error) => return End::Failed { reason: error.to_string(), lasting: true },
    };
    loop {
        let teller = Teller { flow, tell, shown: Mutex::new((Shares::new(&queue), None)) };
        match queue.run(laboratory, &teller).pop() {
            Some(Outcome::Finished { .. }) => return End::Finished,
            // Another process was faster by an instant, or looked whether the folder is in use.
            Some(Outcome::Failed(error)) if is_locked(&error) && since.elapsed() < WAIT_FOR_FOLDER => {
                thread::sleep(LOOK_EVERY);
            }
            Some(Outcome::Failed(error)) => {
                return End::Failed { reason: error.to_string(), lasting: error.is_lasting() };
            }
            _ => return End::Interrupted,
        }
    }
}

/// True if another process has the folder of the run.
fn is_locked(error: &RunError) -> bool {
    matches!(
        error,
        RunError::File(granum_io::Error::Locked { .. })
            | RunError::Laboratory(LaboratoryError::File(granum_io::Error::Locked { .. }))
    )
}

/// Tells what happens to the run.
struct Teller<'a> {
    flow: &'a (dyn Fn() -> Flow + Sync),
    tell: &'a (dyn Fn(&Message) + Sync),
    /// The completed share, and when it was told last.
    shown: Mutex<(Shares, Option<Instant>)>,
}

impl QueueObserver for Teller<'_> {
    fn progress(&self, run: usize, progress: &SimulationProgress) -> Flow {
        let mut held = self.shown.lock().unwrap_or_else(PoisonError::into_inner);
        let (shares, last) = &mut *held;
        if last.is_none_or(|last| last.elapsed() >= TELL_EVERY) {
            *last = Some(Instant::now());
            shares.update(run, progress);
            (self.tell)(&Message::Progress { share: shares.all(), in_test: progress.phase == Phase::Test });
        }
        self.flow()
    }

    fn warn(&self, _: usize, text: &str) {
        (self.tell)(&Message::Warning { text: text.to_string() });
    }

    fn flow(&self) -> Flow {
        (self.flow)()
    }
}
