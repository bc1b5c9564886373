//! The laboratory: makes samples and tests them, and leaves run folders.
//!
//! ```text
//! Case --> prepare --> sample folder --> shear --> run folder
//! ```
//!
//! A run is a [`Standing`] that goes from stage to stage: preparation, sample, test. It is written down as a
//! checkpoint at an interval of wall time and when the user stops it, and everything that decides what comes next is in
//! it: a run that is killed at any instant goes on to the same bits. Before the first checkpoint there are the case and
//! where the sample comes from.

pub mod memory;
mod quality;
mod sample;
mod standing;
mod test;

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use granum_dem::preparation::{Phase, PreparationError};
use granum_dem::simulation::{Hardware, Simulation, SimulationError};
use granum_io::run::{Machine, RunFolder, RunRecord, RunStatus};
use granum_io::{Case, Error as FileError};
use thiserror::Error;

use self::standing::{Stage, Standing};
use crate::error::HybridError;
use crate::files::write_record;

pub use granum_io::run::{CHECKPOINT, PREVIOUS_CHECKPOINT};
pub use sample::{Source, cell, simulation, sites};
pub use standing::check_beside;

/// Name of the snapshot of a sample.
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
    /// The record.
    #[error(transparent)]
    Record(#[from] HybridError),
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
        "{what}: no checkpoint can be used; run it again, e.g. `granum shear {0}/case.toml --out OTHER`",
        folder.display()
    )]
    Unusable {
        /// The folder.
        folder: PathBuf,
        /// What is wrong with each.
        what: String,
    },
}

/// What a running phase tells.
pub struct Status<'a> {
    /// Which phase.
    pub phase: Phase,
    /// Which trial of the preparation friction, from 1.
    pub trial: usize,
    /// Fraction of the phase done, where it can be told.
    pub fraction: Option<f64>,
    /// Grain-steps per second of the last stretch.
    pub grain_steps_per_second: f64,
    /// The simulation, for looking.
    pub simulation: &'a Simulation,
}

impl Status<'_> {
    /// Where it stands, in one line for people.
    pub fn line(&self) -> String {
        let s = self.simulation.state();
        let stress = s.stress();
        let p = s.mean_stress();
        let rate = self.grain_steps_per_second / 1e6;
        let common = format!(
            "p {:.2} kPa  solid fraction {:.4}  {rate:.1} M grain-steps/s",
            p / 1e3,
            s.solid_fraction()
        );
        match self.phase {
            Phase::Shear => {
                let q = stress[0][0] - 0.5 * (stress[1][1] + stress[2][2]);
                let ratio = if p == 0.0 { 0.0 } else { q / p };
                format!("strain {:.4}  q/p {ratio:.3}  {common}", s.deviator_strain())
            }
            _ if self.trial > 1 => format!("trial {}  {common}", self.trial),
            _ => common,
        }
    }
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

/// How a stretch of a run ended.
enum Stretch {
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
        self.begin("prepare", case, source, folder, observer)
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
        self.begin("shear", case, source, folder, observer)
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
        if case.digest() != record.case_digest {
            let message =
                "the case was changed since the run began; run the changed case anew in another folder";
            return Err(FileError::content(&folder.path().join("case.toml"), message).into());
        }
        let standing = standing::last_good(folder, &case, observer)?;
        if record.status == RunStatus::Finished && standing.as_ref().is_none_or(|s| !s.older) {
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
                folder.write_case(&case)?;
            }
            let standing = match standing {
                Some(standing) => standing,
                None => {
                    let source = Source::recorded(&record.source)?;
                    self.start(&case, &source, record)?
                }
            };
            self.go_on(&case, standing, folder, record, observer)
        })
    }

    /// Begins a run. The record goes first and holds the case until that has its own file: from then on the run can be
    /// resumed.
    fn begin(
        &self,
        kind: &str,
        case: &Case,
        source: &Source,
        folder: &RunFolder,
        observer: &mut dyn RunObserver,
    ) -> Result<RunRecord, LaboratoryError> {
        if *source == Source::Case {
            memory::check(case)?;
        }
        let machine = Machine::here(self.hardware.isa.name(), self.hardware.threads);
        let mut record = RunRecord::new(kind, &self.version, case, machine);
        record.source = source.record()?;
        record.unwritten_case = Some(case.resolved_toml());
        folder.write_record(&record)?;
        folder.write_case(case)?;
        record.unwritten_case = None;
        self.finish(folder, &mut record, |record| {
            let standing = self.start(case, source, record)?;
            self.go_on(case, standing, folder, record, observer)
        })
    }

    /// Goes from stage to stage until the run is complete or the observer stops it.
    fn go_on(
        &self,
        case: &Case,
        mut standing: Standing,
        folder: &RunFolder,
        record: &mut RunRecord,
        observer: &mut dyn RunObserver,
    ) -> Result<(), LaboratoryError> {
        // At once, so that nothing outside the folder is needed from here on.
        save(folder, &standing, record)?;
        loop {
            let started = Instant::now();
            let phase = standing.phase();
            let stretch = match standing.stage {
                Stage::Preparation(_) => {
                    let (next, stretch) = self.prepare_on(case, standing, observer)?;
                    standing = next;
                    stretch
                }
                Stage::Sample => {
                    folder.write_snapshot(SAMPLE, &standing.simulation.assembly())?;
                    if record.kind == "prepare" {
                        return Ok(());
                    }
                    self.begin_test(case, &mut standing)?
                }
                Stage::Test(_) => self.test_on(&mut standing, observer)?,
            };
            if let Some(phase) = phase {
                *record.wall_seconds.entry(phase.into()).or_default() += started.elapsed().as_secs_f64();
            }
            match stretch {
                Stretch::Complete => return complete(&standing, folder, record),
                Stretch::GoOn if phase.is_none() => {}
                Stretch::GoOn => save(folder, &standing, record)?,
                Stretch::Stop => {
                    save(folder, &standing, record)?;
                    record.status = RunStatus::Interrupted;
                    return Ok(());
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
fn save(folder: &RunFolder, standing: &Standing, record: &mut RunRecord) -> Result<(), LaboratoryError> {
    standing.write(folder)?;
    if let Stage::Test(test) = &standing.stage {
        write_record(folder, &test.recorder.record())?;
    }
    standing.tell(record);
    folder.write_record(record)?;
    Ok(())
}

/// The end of a test: last snapshot, judgement.
fn complete(standing: &Standing, folder: &RunFolder, record: &mut RunRecord) -> Result<(), LaboratoryError> {
    let Stage::Test(test) = &standing.stage else { return Ok(()) };
    let end = standing.simulation.assembly();
    folder.write_snapshot(END, &end)?;
    save(folder, standing, record)?;
    let seen = test.recorder.record();
    record.quality.extend(quality::judge(&standing.simulation, &end, &seen, &test.before));
    record.phase.clear();
    Ok(())
}

/// Says when a checkpoint is due. Never at the first look of a stretch: a stretch must get on, however short the interval.
pub(crate) struct Interval {
    since: Option<Instant>,
    every: Duration,
}

impl Interval {
    pub(crate) fn new(every: Duration) -> Interval {
        Interval { since: None, every }
    }

    pub(crate) fn is_over(&mut self) -> bool {
        match self.since {
            Some(since) => since.elapsed() > self.every,
            None => {
                self.since = Some(Instant::now());
                false
            }
        }
    }
}

/// Grain-steps per second, from stretch to stretch.
pub(crate) struct Speedometer {
    since: Instant,
    /// Step at that time; none before the first look.
    step: Option<u64>,
    rate: f64,
}

impl Speedometer {
    pub(crate) fn new() -> Self {
        Speedometer { since: Instant::now(), step: None, rate: 0.0 }
    }

    pub(crate) fn rate(&mut self, simulation: &Simulation) -> f64 {
        let step = simulation.state().step();
        let seconds = self.since.elapsed().as_secs_f64();
        match self.step {
            Some(before) if before <= step => {
                if seconds > 0.5 {
                    let steps = (step - before) as f64;
                    let rate = steps * simulation.state().grains() as f64 / seconds;
                    *self = Speedometer { step: Some(step), rate, since: Instant::now() };
                }
            }
            // Another phase has begun.
            _ => *self = Speedometer { step: Some(step), rate: self.rate, since: Instant::now() },
        }
        self.rate
    }
}

#[cfg(test)]
mod interruption_tests;
#[cfg(test)]
mod tests;
