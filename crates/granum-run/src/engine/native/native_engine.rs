//! The engine of granum ([`granum_dem`]): it executes the parts of a run one after another and writes checkpoints, from
//! which an interrupted run is resumed with bit-identical results.

use granum_dem::observer::SimulationObserver;
use granum_io::run::{RunFolder, RunRecord};

use super::run;
use crate::engine::engine_run::EngineRun;
use crate::engine::engine_trait::Engine;
use crate::task::definition::Task;
use crate::task::laboratory_error::LaboratoryError;

/// The engine of granum.
#[derive(Clone, Copy, Debug)]
pub struct Native;

impl Engine for Native {
    fn name(&self) -> &'static str {
        granum_io::run::OWN_ENGINE
    }

    fn help(&self) -> &'static str {
        "granum's own engine: the same bits on any number of threads, with checkpoints"
    }

    fn plan(&self, task: Task, observer: &mut dyn SimulationObserver) -> Result<EngineRun, LaboratoryError> {
        run::plan(task, observer)
    }

    fn resume(
        &self,
        task: Task,
        record: RunRecord,
        folder: &RunFolder,
        observer: &mut dyn SimulationObserver,
    ) -> Result<Option<EngineRun>, LaboratoryError> {
        run::resume(task, record, folder, observer)
    }
}
