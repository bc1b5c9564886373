//! The engine of granum ([`granum_dem`]): it executes the parts of a run one after another and writes checkpoints, from
//! which an interrupted run is resumed with bit-identical results.

use granum_dem::observer::Observer;
use granum_io::run::{RunFolder, RunRecord};

use super::run;
use crate::engine::engine_trait::{Engine, Laboratory, PlannedRun, Task};
use crate::laboratory::laboratory_error::LaboratoryError;

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

    fn begin<'a>(
        &'a self,
        task: Task<'a>,
        observer: &mut dyn Observer,
    ) -> Result<PlannedRun<'a>, LaboratoryError> {
        let begun = run::begin(&task, self, observer)?;
        Ok(PlannedRun::new(move |folder, observer| run::run(&task, begun, folder, observer)))
    }

    fn resume(
        &self,
        laboratory: &Laboratory,
        folder: &RunFolder,
        observer: &mut dyn Observer,
    ) -> Result<RunRecord, LaboratoryError> {
        run::resume(laboratory, folder, observer)
    }
}
