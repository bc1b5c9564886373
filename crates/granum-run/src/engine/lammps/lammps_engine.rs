//! LAMMPS as an engine.

use std::path::Path;
use std::time::SystemTime;

use granum_dem::config::NormalKind;
use granum_dem::observer::SimulationObserver;
use granum_io::Case;
use granum_io::case::Vocabulary;
use granum_io::run::{RunFolder, RunRecord, RunStatus};

use super::frame;
use super::place::Place;
use super::program::{self, NAME};
use super::run::{self, Test};
use super::unknown::Unknown;
use crate::engine::engine_run::EngineRun;
use crate::engine::engine_trait::Engine;
use crate::engine::native::{SampleMaker, note};
use crate::lammps_deck::LammpsDeck;
use crate::task::definition::Task;
use crate::task::engine_error::EngineError;
use crate::task::laboratory_error::LaboratoryError;

/// Found with two spheres that were pulled apart: `compute pair/local` gives no force at overlaps below the distance across which the
/// contact holds, nor beyond, where the sphere itself has the force of the law (LAMMPS 29 Sep 2021).
const WITHOUT_FORCES: &str = "contact.normal = \"jkr\" cannot be recorded: LAMMPS does not tell the forces of contacts in tension whose overlap \
                              is small, nor which of them hold across a gap. Choose hertz; or write the deck with `granum export --to lammps`, \
                              of which LAMMPS itself makes the curve";

/// LAMMPS, which runs the [deck](crate::lammps_deck) of a case, also on several processors or computers by MPI. Samples are prepared by
/// granum's own engine.
///
/// ```
/// use granum_run::Engine;
/// use granum_run::engine::Lammps;
///
/// let four = Lammps::on_ranks(4);
/// assert_eq!((four.name(), four.command().join(" ")), ("lammps", "mpirun -np 4 lmp".to_string()));
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lammps {
    command: Vec<String>,
    /// True if the user chose the command, so that a run that goes on takes it and not the one with which it began.
    chosen: bool,
}

impl Default for Lammps {
    /// The program `lmp` on one processor.
    fn default() -> Lammps {
        Lammps { command: vec!["lmp".into()], chosen: false }
    }
}

impl Lammps {
    /// A command with its arguments, such as `mpirun -np 4 lmp`, to which those of the run are added.
    pub fn with_command(command: impl IntoIterator<Item = impl Into<String>>) -> Lammps {
        Lammps { command: command.into_iter().map(Into::into).collect(), chosen: true }
    }

    /// The program `lmp` on a number of processors, started by `mpirun`.
    pub fn on_ranks(ranks: usize) -> Lammps {
        Lammps::with_command(["mpirun", "-np", &ranks.to_string(), "lmp"])
    }

    /// The command.
    pub fn command(&self) -> &[String] {
        &self.command
    }

    /// When the last restart file in the folder of a run was written, if there is one.
    pub fn last_restart(folder: &Path) -> Option<SystemTime> {
        Place::last_restart_of(folder)
    }

    /// The command for a run that goes on.
    fn command_in(&self, folder: &RunFolder) -> Vec<String> {
        let before = Place::command_of(folder.path()).filter(|_| !self.chosen);
        before.unwrap_or_else(|| self.command.clone())
    }
}

fn refused(what: String) -> LaboratoryError {
    EngineError::Refused { engine: NAME.into(), what }.into()
}

impl Engine for Lammps {
    fn name(&self) -> &'static str {
        NAME
    }

    fn help(&self) -> &'static str {
        "LAMMPS, also on several processors by MPI: its deck is written, run and read back; samples are granum's"
    }

    fn version(&self) -> Result<String, EngineError> {
        Ok(program::about(&self.command)?.version)
    }

    /// LAMMPS is not asked to compact samples.
    fn makes_samples(&self) -> bool {
        false
    }

    fn check(&self, case: &Case, vocabulary: &Vocabulary) -> Result<(), LaboratoryError> {
        LammpsDeck::check(case).map_err(|error| refused(error.to_string()))?;
        if case.contact.normal == NormalKind::JKR {
            return Err(refused(WITHOUT_FORCES.into()));
        }
        Unknown::new(case, vocabulary.sensors(), frame::parts()).map(drop)
    }

    fn plan(&self, task: Task, observer: &mut dyn SimulationObserver) -> Result<EngineRun, LaboratoryError> {
        self.check(&task.case, &task.vocabulary)?;
        let test = Test::new(&task, self.command.clone(), true)?;
        program::about(&self.command)?;
        let (sample, mut record) = SampleMaker::plan(&task, observer)?;
        if let Some(remark) = test.remark() {
            note(&mut record, remark);
        }
        let text = "carried out by LAMMPS: the results are not the same bits on another computer, with another number of processors, or \
                    after a restart; the sample begins without tangential forces, since data files of LAMMPS have none, and comes to \
                    rest again before the test";
        note(&mut record, text.into());
        Ok(EngineRun::new(record, move |sink, observer| run::run(test, sample, sink, observer)))
    }

    fn resume(
        &self,
        task: Task,
        record: RunRecord,
        folder: &RunFolder,
        observer: &mut dyn SimulationObserver,
    ) -> Result<Option<EngineRun>, LaboratoryError> {
        if record.status == RunStatus::Finished {
            if let Some(fault) = folder.run().faults()?.first() {
                return Err(LaboratoryError::Damaged { what: fault.to_string() });
            }
            return Ok(None);
        }
        let command = self.command_in(folder);
        let about = program::about(&command)?;
        let mut test = Test::new(&task, command, false)?;
        if about.version != record.engine_version {
            let text = format!(
                "began with LAMMPS {} and goes on with LAMMPS {}",
                record.engine_version, about.version
            );
            observer.warn(&text);
            test.note = Some(text);
        }
        let sample = SampleMaker::resume(&task, &record, folder, observer)?;
        Ok(Some(EngineRun::new(record, move |sink, observer| run::run(test, sample, sink, observer))))
    }
}
