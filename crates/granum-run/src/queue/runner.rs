//! The queue and its execution.

use std::collections::{BTreeMap, BTreeSet};
use std::convert::Infallible;
use std::path::Path;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;

use granum_core::parallel;
use granum_dem::observer::{Flow, NoObserver};
use granum_dem::preparation::PreparationError;
use granum_io::{OutputFolder, RunFolder, RunStatus};

use super::execution::{Held, check_folder};
use super::executor::{Executor, InThisProcess};
use super::outcome::{Outcome, RunError};
use super::queue_error::QueueError;
use super::queue_observer::QueueObserver;
use super::queued_run::QueuedRun;
use super::samples;
use super::schedule::{Next, Schedule};
use crate::laboratory::definition::Laboratory;
use crate::task::laboratory_error::LaboratoryError;
use crate::task::memory;
use crate::task::resources::GRAINS_PER_THREAD;
use crate::task::shared::Shared;
use crate::task::source::Source;

/// Planned runs that are executed together. See [the module](super) for an example.
#[derive(Clone, Debug, PartialEq)]
pub struct Queue {
    runs: Vec<QueuedRun>,
    /// For each run the number of the one that it waits for.
    after: Vec<Option<usize>>,
}

impl Queue {
    /// A queue of runs.
    ///
    /// # Errors
    /// [`QueueError`] if two runs have the same name or folder, or a run waits for one that is not there, or for itself.
    pub fn new(runs: Vec<QueuedRun>) -> Result<Queue, QueueError> {
        let (mut names, mut folders) = (BTreeSet::new(), BTreeSet::new());
        for run in &runs {
            if !names.insert(run.name.as_str()) {
                return Err(QueueError::SameName(run.name.clone()));
            }
            if !folders.insert(run.folder.as_path()) {
                return Err(QueueError::SameFolder(run.folder.clone()));
            }
        }
        let places: BTreeMap<&str, usize> =
            runs.iter().enumerate().map(|(k, run)| (run.name.as_str(), k)).collect();
        let number = |run: &QueuedRun| match &run.after {
            None => Ok(None),
            Some(after) => {
                let missing = || QueueError::NoSuchRun { run: run.name.clone(), after: after.clone() };
                places.get(after.as_str()).copied().map(Some).ok_or_else(missing)
            }
        };
        let after = runs.iter().map(number).collect::<Result<Vec<_>, _>>()?;
        for (k, run) in runs.iter().enumerate() {
            let way = std::iter::successors(after[k], |before| after[*before]);
            if way.take(runs.len()).any(|before| before == k) {
                return Err(QueueError::Circle(run.name.clone()));
            }
        }
        Ok(Queue { runs, after })
    }

    /// A queue of tests in which every sample that several of them would prepare is a run of its own, in a folder inside `samples`.
    /// The samples come first, then the tests in their order. The results of the tests are the same.
    ///
    /// # Errors
    /// As [`Queue::new`].
    pub fn with_shared_samples(runs: Vec<QueuedRun>, samples: &Path) -> Result<Queue, QueueError> {
        Queue::new(samples::share(runs, samples))
    }

    /// The runs.
    pub fn runs(&self) -> &[QueuedRun] {
        &self.runs
    }

    /// Checks every run before any begins: its case, sensors and sample, and that its folder holds no other run, unless these are to
    /// be replaced. Nothing is written.
    ///
    /// # Errors
    /// [`QueueError`] with the name of the run or the folder.
    pub fn check(&self, laboratory: &Laboratory, replace_others: bool) -> Result<(), QueueError> {
        let mut samples_seen = BTreeSet::new();
        let mut engines_seen = BTreeSet::new();
        for (k, run) in self.runs.iter().enumerate() {
            let in_run =
                |error: LaboratoryError| QueueError::Run { run: run.name.clone(), source: Box::new(error) };
            if matches!(
                check_folder(run, laboratory, replace_others)?,
                Held::Finished(_) | Held::Unfinished(_)
            ) {
                continue;
            }
            run.case.check().map_err(|error| in_run(error.into()))?;
            let engine =
                laboratory.engine_for(run.kind).and_then(|name| laboratory.engine(name)).map_err(in_run)?;
            if engines_seen.insert(engine.name()) {
                // A program that is not there fails every run.
                engine.version().map_err(|error| in_run(error.into()))?;
            }
            engine.check(&run.case, &laboratory.registry.vocabulary).map_err(in_run)?;
            let sensors = laboratory.registry.vocabulary.sensors();
            sensors
                .of_test(&run.case.recording, run.case.test_definition().columns)
                .map_err(|error| in_run(error.into()))?;
            match &run.source {
                Source::Case => memory::check(&run.case).map_err(in_run)?,
                // The sample is not there yet.
                _ if self.after[k].is_some() => {}
                source => {
                    // What is read depends on the preparation alone.
                    if samples_seen.insert(run.case.preparation_digest()) {
                        let planned = laboratory.plan(run.kind, &run.case, source, &mut NoObserver);
                        planned.map(drop).map_err(in_run)?;
                    }
                }
            }
        }
        Ok(())
    }

    /// Replaces the folders that hold a run of another case or version, or a record that cannot be read, by empty ones. All are
    /// replaced before any run begins, so that after a kill none is left that would be refused.
    ///
    /// # Errors
    /// If a folder cannot be replaced.
    pub fn replace_others(&self, laboratory: &Laboratory) -> Result<(), QueueError> {
        for run in &self.runs {
            if matches!(Held::by_record(run, laboratory), Ok(Held::Other(_)) | Err(_)) {
                RunFolder::create(&run.folder, true)?.remove_previous()?;
            }
        }
        Ok(())
    }

    /// True if all runs are finished.
    pub fn is_finished(&self, laboratory: &Laboratory) -> bool {
        self.runs.iter().all(|run| matches!(Held::by(run, laboratory), Ok(Held::Finished(_))))
    }

    /// Executes all runs that are not finished, as many at once as the laboratory has threads and the memory can hold, and returns
    /// how each ended. A single run that is left gets all threads. Results depend neither on the order nor on what runs beside.
    pub fn run(&self, laboratory: &Laboratory, observer: &dyn QueueObserver) -> Vec<Outcome> {
        let mut sharing = laboratory.clone();
        sharing.resources.shared = Some(Arc::new(Shared::default()));
        sharing.resources.grains_per_thread = GRAINS_PER_THREAD;
        let at_once = self.at_once(laboratory.resources.hardware.threads);
        self.run_by(&InThisProcess(&sharing), laboratory, at_once, observer)
    }

    /// The same with another executor of the runs, and with so many runs at once. The laboratory says which runs are those of this
    /// version and engine.
    pub fn run_by(
        &self,
        executor: &dyn Executor,
        laboratory: &Laboratory,
        at_once: usize,
        observer: &dyn QueueObserver,
    ) -> Vec<Outcome> {
        let held = |k: usize| {
            let held = Held::by(&self.runs[k], laboratory).unwrap_or(Held::Nothing);
            Ok::<_, Infallible>(held)
        };
        let Ok(held) = parallel::map(self.runs.len(), 0, held);
        let after: Vec<Option<usize>> =
            (0..held.len()).map(|k| self.after[k].filter(|_| held[k].needs_sample())).collect();
        let work: Vec<f64> = self.runs.iter().map(QueuedRun::expected_work).collect();
        let mut schedule = Schedule::new(&work, after.clone());
        let mut outcomes: Vec<Option<Outcome>> = held.iter().map(|_| None).collect();
        let waited_for: BTreeSet<usize> = self.after.iter().flatten().copied().collect();
        let still_waited_for: BTreeSet<usize> = after.iter().flatten().copied().collect();
        for (k, held) in held.into_iter().enumerate() {
            let outcome = match held {
                Held::Finished(record) => {
                    // A process that was killed after it had written the record may have left a temporary file. A folder that
                    // cannot be opened, because it can only be read or is in use, is used as it is.
                    drop(OutputFolder::open(&self.runs[k].folder));
                    Outcome::Finished { record, reused: true }
                }
                Held::Nothing if waited_for.contains(&k) && !still_waited_for.contains(&k) => {
                    Outcome::NotNeeded
                }
                _ => continue,
            };
            observer.ends(k, &outcome);
            schedule.over(k, true);
            outcomes[k] = Some(outcome);
        }
        let execution = Execution {
            queue: self,
            executor,
            observer,
            after: &after,
            progress: Mutex::new(InProgress { schedule, outcomes, stopped: false }),
            ended: Condvar::new(),
        };
        thread::scope(|scope| {
            for _ in 1..at_once {
                // Where the system refuses a thread, the others do its work.
                let _ = thread::Builder::new().spawn_scoped(scope, || execution.work());
            }
            execution.work();
        });
        let in_progress = execution.progress.into_inner().unwrap_or_else(PoisonError::into_inner);
        in_progress.outcomes.into_iter().map(|outcome| outcome.unwrap_or(Outcome::NotBegun)).collect()
    }

    /// The number of runs that are executed at once: at most one for each thread, and so many that the largest of them fit into
    /// the memory together.
    pub fn at_once(&self, threads: usize) -> usize {
        self.fitting(threads, memory::available())
    }

    fn fitting(&self, threads: usize, memory: Option<u64>) -> usize {
        let mut needed: Vec<u64> =
            self.runs.iter().map(|run| memory::needed(memory::spheres_of(&run.case))).collect();
        needed.sort_unstable_by(|a, b| b.cmp(a));
        let memory = memory.unwrap_or(u64::MAX);
        let sums = needed.iter().scan(0u64, |sum, needed| {
            *sum = sum.saturating_add(*needed);
            Some(*sum)
        });
        sums.take_while(|sum| *sum <= memory).count().min(threads).max(1)
    }
}

/// What the threads of an execution share.
struct Execution<'a> {
    queue: &'a Queue,
    executor: &'a dyn Executor,
    observer: &'a dyn QueueObserver,
    after: &'a [Option<usize>],
    progress: Mutex<InProgress>,
    /// Signalled when a run has ended.
    ended: Condvar,
}

struct InProgress {
    schedule: Schedule,
    outcomes: Vec<Option<Outcome>>,
    /// True if no further run is to begin.
    stopped: bool,
}

impl Execution<'_> {
    /// The work of one thread: one run after another until none is left.
    fn work(&self) {
        while let Some(next) = self.next() {
            let outcome = match next {
                Next::Run(run) => {
                    self.observer.begins(run);
                    let record = self.executor.execute(run, &self.queue.runs[run], self.observer);
                    (run, self.outcome(record))
                }
                Next::GiveUp(run) => (run, self.without_sample(run)),
                Next::Wait | Next::Nothing => return,
            };
            self.end(outcome);
        }
    }

    /// The next action; `None` if none is left.
    fn next(&self) -> Option<Next> {
        let mut held = self.lock();
        loop {
            held.stopped |= self.observer.flow() == Flow::Stop;
            if held.stopped {
                return None;
            }
            match held.schedule.next() {
                Next::Nothing => return None,
                Next::Wait => held = self.ended.wait(held).unwrap_or_else(PoisonError::into_inner),
                next => return Some(next),
            }
        }
    }

    fn outcome(&self, record: Result<granum_io::RunRecord, super::outcome::RunError>) -> Outcome {
        match record {
            Ok(record) if record.status == RunStatus::Interrupted => Outcome::Interrupted(Box::new(record)),
            Ok(record) => Outcome::Finished { record: Box::new(record), reused: false },
            // Stopped while its grains were placed: there is nothing to continue from yet.
            Err(
                RunError::NotBegun
                | RunError::Laboratory(LaboratoryError::Preparation(PreparationError::Stopped { .. })),
            ) => Outcome::NotBegun,
            Err(error) => Outcome::Failed(error),
        }
    }

    fn without_sample(&self, run: usize) -> Outcome {
        let sample = self.after[run].map_or_else(String::new, |before| self.queue.runs[before].name.clone());
        Outcome::WithoutSample { sample }
    }

    fn end(&self, (run, outcome): (usize, Outcome)) {
        self.observer.ends(run, &outcome);
        let mut held = self.lock();
        held.schedule.over(run, outcome.is_finished());
        held.stopped |= outcome.is_stopped();
        held.outcomes[run] = Some(outcome);
        drop(held);
        self.ended.notify_all();
    }

    fn lock(&self) -> MutexGuard<'_, InProgress> {
        self.progress.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use granum_io::Case;

    use super::*;

    fn run(name: &str, after: Option<&str>) -> QueuedRun {
        let run = QueuedRun::test(name, Case::default(), Source::Case, format!("runs/{name}"));
        QueuedRun { after: after.map(str::to_string), ..run }
    }

    #[test]
    fn a_queue_whose_runs_contradict_each_other_is_refused() {
        let message = |runs: Vec<QueuedRun>| Queue::new(runs).unwrap_err().to_string();
        assert_eq!(message(vec![run("a", None), run("a", None)]), "two runs have the name a");
        let other = QueuedRun { folder: "runs/a".into(), ..run("b", None) };
        assert_eq!(message(vec![run("a", None), other]), "two runs have the folder runs/a");
        assert_eq!(message(vec![run("a", Some("b"))]), "the run a waits for b, which is not in the queue");
        let circle = message(vec![run("a", Some("b")), run("b", Some("a"))]);
        assert_eq!(circle, "the run a waits for itself, directly or through other runs");
        assert!(Queue::new(vec![run("a", Some("b")), run("b", None)]).is_ok());
    }

    #[test]
    fn as_many_runs_at_once_as_threads_and_memory_allow() {
        let queue = Queue::new(vec![run("a", None), run("b", None), run("c", None)]).unwrap();
        let one = memory::needed(Case::default().grains.count);
        assert_eq!(queue.fitting(2, None), 2);
        assert_eq!(queue.fitting(8, Some(u64::MAX)), 3);
        assert_eq!(queue.fitting(8, Some(2 * one)), 2);
        assert_eq!(queue.fitting(8, Some(1)), 1);
    }
}
