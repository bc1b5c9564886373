//! The laboratory: makes samples and tests them, and leaves run folders.
//!
//! ```text
//! Case --> prepare --> sample folder --> shear --> run folder
//! ```
//!
//! A run is a [`RunState`] that goes from stage to stage: preparation, sample, consolidation (where the test is at another
//! mean stress than the sample), test. It is written down as a
//! checkpoint at an interval of wall time and when the user stops it, and everything that decides what comes next is in
//! it: a run that is killed at any instant goes on to the same bits. Before the first checkpoint there are the case and
//! where the sample comes from.

mod consolidation;
mod from_packing;
mod in_memory;
mod measures;
pub mod memory;
mod pace;
mod preparation_curve;
mod quality;
mod run_state;
mod sample;
mod saved_state;
mod status;
mod store;
mod test;

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use granum_dem::loading::{ControlError, StageEnd};
use granum_dem::preparation::PreparationError;
use granum_dem::simulation::{Hardware, SimulationError};
use granum_io::run::{Machine, RunFolder, RunRecord, RunSource, RunStatus};
use granum_io::shell::quoted_path;
use granum_io::{Case, Error as FileError};
use thiserror::Error;

pub(crate) use self::pace::Interval;
use self::run_state::{RunState, Stage};
use self::status::Speedometer;
use self::store::Store;
use self::test::Test;
use crate::record::write_record;

pub use granum_io::run::{CHECKPOINT, PREVIOUS_CHECKPOINT};
pub use in_memory::TestResult;
pub use measures::late_mean;
pub use preparation_curve::PREPARATION_COLUMNS;
pub use run_state::check_beside;
pub use sample::{Source, cell, simulation, spheres};
pub use status::{Field, Status};

/// Name of the snapshot of a sample, in the folder of a test as it is when the test begins.
pub const SAMPLE: &str = "start";
/// Name of the snapshot at the end of a test.
pub const END: &str = "end";

/// Why a run failed.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LaboratoryError {
    /// A file or folder.
    #[error(transparent)]
    File(#[from] granum_io::Error),
    /// The preparation.
    #[error(transparent)]
    Preparation(#[from] PreparationError),
    /// The engine.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// A stage of the test.
    #[error(transparent)]
    Control(#[from] ControlError),
    /// A state that stages go back to cannot be kept or used.
    #[error("the state that later stages go back to: {0}")]
    Kept(String),
    /// No stage kept a state.
    #[error("the stage {stage} goes back to a state, but no stage before it kept one (start = \"kept\")")]
    NothingKept {
        /// Name of the stage.
        stage: String,
    },
    /// The machine cannot hold it.
    #[error(
        "{grains} grains need up to {needed:.1} GB of memory, and this machine has {available:.1} GB free: grains.count can be \
         at most {fitting} here"
    )]
    Memory {
        /// Grains asked for.
        grains: usize,
        /// Estimate, GB.
        needed: f64,
        /// Free, GB.
        available: f64,
        /// Grains that would fit.
        fitting: usize,
    },
    /// A packing that cannot be simulated.
    #[error("the packing cannot be simulated: {0}")]
    Packing(String),
    /// A checkpoint.
    #[error("{}: {what}", path.display())]
    Checkpoint {
        /// Its file.
        path: PathBuf,
        /// What is wrong, and what would be right.
        what: String,
    },
    /// No checkpoint of a folder can be used.
    #[error(
        "{what}: no checkpoint can be used; run it again, e.g. `granum shear {} --out OTHER`",
        quoted_path(&folder.join("case.toml"))
    )]
    Unusable {
        /// The folder.
        folder: PathBuf,
        /// What is wrong with each.
        what: String,
    },
}

/// Who watches a run. Nothing that it does can change a result but to stop it.
pub trait RunObserver {
    /// Called every few hundred steps.
    fn status(&mut self, status: &Status);
    /// True to end the run in good order.
    fn stop(&self) -> bool {
        false
    }
    /// Something that the user should know and that does not end the run.
    fn warn(&mut self, _text: &str) {}
}

/// An observer that looks away.
pub struct Nobody;

impl RunObserver for Nobody {
    fn status(&mut self, _: &Status) {}
}

/// Processors that several runs share: a run that is alone gets all of them, many get one each.
#[derive(Debug, Default)]
pub struct Shared {
    running: AtomicUsize,
}

impl Shared {
    /// Counts a run in until the value returned is dropped.
    pub fn enter(self: &Arc<Self>) -> Entered {
        self.running.fetch_add(1, Ordering::Relaxed);
        Entered(self.clone())
    }
}

/// A run that counts.
pub struct Entered(Arc<Shared>);

impl Drop for Entered {
    fn drop(&mut self) {
        self.0.running.fetch_sub(1, Ordering::Relaxed);
    }
}

/// Fewest grains that are worth a thread of their own.
pub const GRAINS_PER_THREAD: usize = 1500;
/// Wall time between two checkpoints, where nothing else is asked for.
pub const CHECKPOINT_EVERY: Duration = Duration::from_secs(30);

/// Makes samples and tests them.
#[derive(Clone, Debug)]
pub struct Laboratory {
    /// What runs the simulations; results do not depend on it.
    pub hardware: Hardware,
    /// Fewest grains for each thread; 1 to take as many threads as `hardware` says.
    pub grains_per_thread: usize,
    /// Set where several runs share the processors.
    pub shared: Option<Arc<Shared>>,
    /// Wall time between two checkpoints; results do not depend on it.
    pub checkpoint_every: Duration,
    /// Version to write into records.
    pub version: String,
}

/// A run that is about to begin: what it begins with was found good, and nothing is written yet.
pub struct PlannedRun {
    case: Case,
    record: RunRecord,
    run_state: RunState,
}

/// How a segment of a run ended.
enum Segment {
    /// There is more to do.
    GoOn,
    /// The observer wants to stop.
    Stop,
    /// The run is complete.
    Complete,
}

impl Laboratory {
    /// A laboratory of its own, with checkpoints at the usual interval.
    pub fn new(hardware: Hardware, version: impl Into<String>) -> Laboratory {
        Laboratory {
            hardware,
            grains_per_thread: GRAINS_PER_THREAD,
            shared: None,
            checkpoint_every: CHECKPOINT_EVERY,
            version: version.into(),
        }
    }

    /// What to run a simulation of so many grains on just now.
    pub(crate) fn hardware_for(&self, grains: usize) -> Hardware {
        let running = self.shared.as_ref().map_or(1, |s| s.running.load(Ordering::Relaxed).max(1));
        let useful = grains / self.grains_per_thread.max(1);
        Hardware { threads: (self.hardware.threads / running).min(useful).max(1), ..self.hardware }
    }

    /// Makes a sample and leaves it in a folder: case, snapshot, checkpoint, record. The record's status tells whether it
    /// was interrupted.
    ///
    /// # Errors
    /// [`LaboratoryError`]; the record in the folder then has the status `failed`.
    pub fn prepare(
        &self,
        case: &Case,
        source: &Source,
        folder: &RunFolder,
        observer: &mut dyn RunObserver,
    ) -> Result<RunRecord, LaboratoryError> {
        self.run(self.plan("prepare", case, source, observer)?, folder, observer)
    }

    /// Makes or takes a sample and shears it as the case says; leaves a run folder.
    ///
    /// # Errors
    /// [`LaboratoryError`]; the record in the folder then has the status `failed`.
    pub fn shear(
        &self,
        case: &Case,
        source: &Source,
        folder: &RunFolder,
        observer: &mut dyn RunObserver,
    ) -> Result<RunRecord, LaboratoryError> {
        self.run(self.plan("shear", case, source, observer)?, folder, observer)
    }

    /// Goes on with a preparation or test that was interrupted, killed or failed: from its last good checkpoint, or from
    /// the case if there is none yet.
    ///
    /// # Errors
    /// [`LaboratoryError`] if what is there cannot be used, or it fails again.
    pub fn resume(
        &self,
        folder: &RunFolder,
        observer: &mut dyn RunObserver,
    ) -> Result<RunRecord, LaboratoryError> {
        let run = folder.run();
        let case = run.case()?;
        let mut record = run.record()?;
        if !record.is_of(&case) {
            let message =
                "the case was changed since the run began; run the changed case anew in another folder";
            return Err(FileError::content(&folder.path().join("case.toml"), message).into());
        }
        let run_state = run_state::last_good(folder, &case, observer)?;
        if record.status == RunStatus::Finished && run_state.as_ref().is_none_or(|s| !s.older) {
            return Ok(record);
        }
        if record.granum_version != self.version {
            let (old, new) = (&record.granum_version, &self.version);
            let text = format!(
                "begun by granum {old} and resumed by {new}: its results may differ in the last digits from those of either version"
            );
            observer.warn(&text);
            record.notes.push(text);
        }
        record.status = RunStatus::Running;
        self.finish(folder, &mut record, |record| {
            if record.unwritten_case.take().is_some() {
                write_case(folder, &case, record)?;
            }
            let run_state = match run_state {
                Some(run_state) => run_state,
                None => {
                    let source = Source::recorded(&record.source)?;
                    self.start(&case, &source, None, record, observer)?
                }
            };
            self.go_on(&case, run_state, Store(Some(folder)), record, observer).map(drop)
        })
    }

    /// Reads what a run of a `kind` (`prepare`, `shear`) begins with and refuses what cannot be run. Nothing is written, so that
    /// a mistake leaves no folder behind. The observer is told what the user should know of it.
    ///
    /// # Errors
    /// [`LaboratoryError`] if the machine cannot hold the case, or its sample or packing cannot be used.
    pub fn plan(
        &self,
        kind: &str,
        case: &Case,
        source: &Source,
        observer: &mut dyn RunObserver,
    ) -> Result<PlannedRun, LaboratoryError> {
        if *source == Source::Case {
            memory::check(case)?;
        }
        let packing = Self::packing(source)?;
        let machine = Machine::here(self.hardware.isa.name(), self.hardware.threads);
        let mut record = RunRecord::new(kind, &self.version, case, machine);
        record.source = source.record()?;
        if let (Some(packing), RunSource::Packing { file, sha256 }) = (&packing, &record.source) {
            let packing = from_packing::describe(file, packing, sha256);
            record.set_packing(case, packing);
        }
        let run_state = self.start(case, source, packing, &mut record, observer)?;
        Ok(PlannedRun { case: case.clone(), record, run_state })
    }

    /// Runs from a beginning to the end. The record goes first and holds the case until that has its own file: from then
    /// on the run can be resumed.
    ///
    /// # Errors
    /// [`LaboratoryError`]; the record in the folder then has the status `failed`.
    pub fn run(
        &self,
        planned: PlannedRun,
        folder: &RunFolder,
        observer: &mut dyn RunObserver,
    ) -> Result<RunRecord, LaboratoryError> {
        let PlannedRun { case, mut record, run_state } = planned;
        record.unwritten_case = Some(case.resolved_toml());
        folder.write_record(&record)?;
        write_case(folder, &case, &record)?;
        record.unwritten_case = None;
        self.finish(folder, &mut record, |record| {
            self.go_on(&case, run_state, Store(Some(folder)), record, observer).map(drop)
        })
    }

    /// Goes from stage to stage until the run is complete or the observer stops it.
    fn go_on(
        &self,
        case: &Case,
        mut run_state: RunState,
        store: Store,
        record: &mut RunRecord,
        observer: &mut dyn RunObserver,
    ) -> Result<RunState, LaboratoryError> {
        // At once, so that nothing outside the folder is needed from here on.
        save(store, &run_state, record)?;
        let mut speedometer = Speedometer::new();
        loop {
            let started = Instant::now();
            speedometer.begin();
            let phase = run_state.phase();
            let segment = match run_state.stage {
                Stage::Preparation(_) => {
                    let source = &record.source;
                    let (next, segment) =
                        self.prepare_on(case, run_state, source, &mut speedometer, observer)?;
                    run_state = next;
                    segment
                }
                Stage::Sample => {
                    write_sample(store, &run_state)?;
                    if record.kind == "prepare" {
                        return Ok(run_state);
                    }
                    match consolidation::wanted(case) {
                        None => self.begin_test(case, &mut run_state)?,
                        Some(preparation) => {
                            run_state = self.begin_consolidation(case, run_state, &preparation);
                            Segment::GoOn
                        }
                    }
                }
                Stage::Consolidation(_) => {
                    let (next, segment) = self.consolidate_on(case, run_state, &mut speedometer, observer)?;
                    run_state = next;
                    segment
                }
                Stage::Consolidated => {
                    write_sample(store, &run_state)?;
                    self.begin_test(case, &mut run_state)?
                }
                Stage::Test(_) => self.test_on(case, &mut run_state, store, &mut speedometer, observer)?,
            };
            if let Some(phase) = phase {
                *record.wall_seconds.entry(phase.into()).or_default() += started.elapsed().as_secs_f64();
            }
            match segment {
                Segment::Complete => {
                    complete(&run_state, store, record, observer)?;
                    return Ok(run_state);
                }
                Segment::GoOn if phase.is_none() => {}
                Segment::GoOn => save(store, &run_state, record)?,
                Segment::Stop => {
                    save(store, &run_state, record)?;
                    record.status = RunStatus::Interrupted;
                    return Ok(run_state);
                }
            }
        }
    }

    /// Does the work and writes the record with the status that it came to.
    fn finish(
        &self,
        folder: &RunFolder,
        record: &mut RunRecord,
        work: impl FnOnce(&mut RunRecord) -> Result<(), LaboratoryError>,
    ) -> Result<RunRecord, LaboratoryError> {
        let result = work(record);
        match &result {
            Ok(()) if record.status == RunStatus::Running => record.status = RunStatus::Finished,
            Ok(()) => {}
            Err(error) => {
                record.status = RunStatus::Failed;
                record.notes.push(format!("failed: {error}"));
            }
        }
        let written = folder.write_record(record);
        // Of two errors the first is the one to tell: a full disk fails twice.
        result?;
        written?;
        Ok(record.clone())
    }
}

/// Writes down where a run stands: checkpoint, what the sensors saw, record.
fn save(store: Store, run_state: &RunState, record: &mut RunRecord) -> Result<(), LaboratoryError> {
    store.write(|folder| run_state.write(folder))?;
    match &run_state.stage {
        Stage::Test(test) => store.write(|folder| write_record(folder, &test.record()))?,
        Stage::Preparation(_) | Stage::Consolidation(_) => write_curve(store, run_state)?,
        Stage::Sample | Stage::Consolidated => {}
    }
    run_state.write_into(record);
    store.write(|folder| folder.write_record(record))?;
    Ok(())
}

/// Writes the case; a packing in place of the random insertion is named in it.
fn write_case(folder: &RunFolder, case: &Case, record: &RunRecord) -> Result<(), LaboratoryError> {
    let packing = record.packing.as_ref().map(|packing| packing.file_name.as_str());
    Ok(folder.write_case(case, packing)?)
}

/// Writes how the sample was come by, as far as it is.
fn write_curve(store: Store, run_state: &RunState) -> Result<(), LaboratoryError> {
    let Some(folder) = store.0 else { return Ok(()) };
    if let Some(table) = run_state.results.curve.table()? {
        folder.write_preparation(&table)?;
    }
    Ok(())
}

/// Writes a sample that is there.
fn write_sample(store: Store, run_state: &RunState) -> Result<(), LaboratoryError> {
    write_curve(store, run_state)?;
    Ok(store.snapshot(SAMPLE, &run_state.simulation.assembly())?)
}

/// The end of a test: last snapshot, judgement.
fn complete(
    run_state: &RunState,
    store: Store,
    record: &mut RunRecord,
    observer: &mut dyn RunObserver,
) -> Result<(), LaboratoryError> {
    let Stage::Test(test) = &run_state.stage else { return Ok(()) };
    let end = run_state.simulation.assembly();
    store.snapshot(END, &end)?;
    save(store, run_state, record)?;
    let seen = test.record();
    record.quality.extend(quality::judge(&run_state.simulation, &end, &seen, test));
    measures::of_test(&seen, &mut record.measures);
    if test.staged {
        measures::of_oedometers(&seen, test.list(), &mut record.measures);
    }
    if test.staged {
        record_stages(test, record, observer);
    }
    if let Some(remark) = quality::remark_on_samples(&test.shortfall()) {
        observer.warn(&remark);
        record.notes.push(remark);
    }
    record.phase.clear();
    Ok(())
}

/// Writes down how each stage ended; a stage that did not come to its end is told at once. Of a test of very many stages only
/// those, and the number of the others.
fn record_stages(test: &Test, record: &mut RunRecord, observer: &mut dyn RunObserver) {
    let many = test.ends.len() > test::STAGES_TOLD;
    for (k, end) in test.ends.iter().enumerate() {
        let StageEnd { name, reason, steps, .. } = end;
        let mut note = format!("stage {} ({name}) ended after {steps} steps: {reason}", k + 1);
        if end.servo_error.rms() > 0.0 {
            let percent = 100.0 * end.servo_error.rms();
            note.push_str(&format!("; its stresses were held within {percent:.2} % of p (root mean square)"));
        }
        if !reason.is_asked_for() {
            let left = test.stages() - test.ends.len();
            let rest =
                if left > 0 { format!("; the {left} stages after it were not run") } else { String::new() };
            observer.warn(&format!("{note}{rest}"));
        } else if many || *steps == 0 {
            // A stage without a step only records where the one before it came to.
            continue;
        }
        record.notes.push(note);
    }
    if many {
        let good = test.ends.iter().filter(|end| end.reason.is_asked_for()).count();
        record.notes.push(format!("{good} of {} stages came to an end that was asked for", test.stages()));
    }
}

#[cfg(test)]
mod interruption_tests;
#[cfg(test)]
mod tests;
