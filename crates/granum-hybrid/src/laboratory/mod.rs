//! The laboratory: makes samples and tests them, and leaves run folders.
//!
//! ```text
//! Case --> prepare --> sample folder --> shear --> run folder
//! ```
//!
//! A folder is usable at any moment: the case is written first, the record of the run says how far it got, and what the
//! sensors saw so far is there after an interruption.

mod quality;
mod sample;
mod test;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use granum_dem::preparation::{Phase, PreparationError};
use granum_dem::simulation::{Hardware, Simulation, SimulationError};
use granum_io::run::{Machine, RunFolder, RunRecord, RunStatus};
use granum_io::{Case, atomic::write_atomically};
use thiserror::Error;

use crate::error::HybridError;

pub use sample::{Source, cell, sites};

/// Name of the checkpoint in a run folder.
pub const CHECKPOINT: &str = "checkpoint";
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
    /// A checkpoint.
    #[error("{}: {what}", path.display())]
    Checkpoint {
        /// Its file.
        path: PathBuf,
        /// What is wrong, and what would be right.
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
const GRAINS_PER_THREAD: usize = 1500;

/// Makes samples and tests them.
#[derive(Clone, Debug)]
pub struct Laboratory {
    /// What runs the simulations; results do not depend on it.
    pub hardware: Hardware,
    /// Set where several runs share the processors.
    pub shared: Option<Arc<Shared>>,
    /// Version to write into records.
    pub version: String,
}

impl Laboratory {
    /// What to run a simulation of so many grains on just now.
    pub(crate) fn hardware_for(&self, grains: usize) -> Hardware {
        let running = self.shared.as_ref().map_or(1, |s| s.running.load(Ordering::Relaxed).max(1));
        let threads = (self.hardware.threads / running).min(grains / GRAINS_PER_THREAD).max(1);
        Hardware { threads, ..self.hardware }
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
        let mut record = self.begin("prepare", case, folder)?;
        self.finish(folder, &mut record, |record| {
            self.make_sample(case, source, folder, record, observer)?;
            Ok(())
        })
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
        let mut record = self.begin("shear", case, folder)?;
        self.finish(folder, &mut record, |record| {
            if let Some(sample) = self.make_sample(case, source, folder, record, observer)? {
                self.run_test(case, sample, folder, record, observer)?;
            }
            Ok(())
        })
    }

    /// Goes on with a test that was interrupted or killed, from its last checkpoint.
    ///
    /// # Errors
    /// [`LaboratoryError`] if there is no checkpoint of a test, or it fails again.
    pub fn resume(
        &self,
        folder: &RunFolder,
        observer: &mut dyn RunObserver,
    ) -> Result<RunRecord, LaboratoryError> {
        let run = folder.run();
        let case = run.case()?;
        let mut record = run.record()?;
        if record.status == RunStatus::Finished {
            return Ok(record);
        }
        record.status = RunStatus::Running;
        self.finish(folder, &mut record, |record| self.resume_test(&case, folder, record, observer))
    }

    fn begin(&self, kind: &str, case: &Case, folder: &RunFolder) -> Result<RunRecord, LaboratoryError> {
        folder.write_case(case)?;
        let machine = Machine::here(self.hardware.isa.name(), self.hardware.threads);
        let record = RunRecord::new(kind, &self.version, case, machine);
        folder.write_record(&record)?;
        Ok(record)
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
        folder.write_record(record)?;
        result.map(|()| record.clone())
    }
}

/// Writes a checkpoint into a run folder.
pub(crate) fn write_checkpoint(
    folder: &Path,
    simulation: &Simulation,
    attachment: &str,
) -> Result<(), LaboratoryError> {
    let path = folder.join(CHECKPOINT);
    let bytes = simulation
        .checkpoint(attachment)
        .map_err(|e| LaboratoryError::Checkpoint { path: path.clone(), what: e.to_string() })?;
    write_atomically(&path, |file| std::io::Write::write_all(file, &bytes))?;
    Ok(())
}

/// Reads the checkpoint of a run folder.
pub(crate) fn read_checkpoint(folder: &Path) -> Result<(Simulation, String), LaboratoryError> {
    let path = folder.join(CHECKPOINT);
    let bad = |what: String| LaboratoryError::Checkpoint { path: path.clone(), what };
    let bytes = std::fs::read(&path).map_err(|e| {
        bad(format!(
            "cannot be read ({e}); a folder that `granum prepare` or `granum shear` made has a checkpoint"
        ))
    })?;
    Simulation::restore(&bytes).map_err(|e| bad(e.to_string()))
}

/// Grain-steps per second, from stretch to stretch.
pub(crate) struct Speedometer {
    since: Instant,
    step: u64,
    rate: f64,
}

impl Speedometer {
    pub(crate) fn new() -> Self {
        Speedometer { since: Instant::now(), step: 0, rate: 0.0 }
    }

    pub(crate) fn rate(&mut self, simulation: &Simulation) -> f64 {
        let step = simulation.state().step();
        let seconds = self.since.elapsed().as_secs_f64();
        if step < self.step {
            *self = Speedometer { step, rate: self.rate, since: Instant::now() };
        } else if seconds > 0.5 {
            self.rate = (step - self.step) as f64 * simulation.state().grains() as f64 / seconds;
            self.since = Instant::now();
            self.step = step;
        }
        self.rate
    }
}

#[cfg(test)]
mod tests;
