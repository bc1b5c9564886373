//! granum's own engine ([`granum_dem`]): the parts of a run one after another, with checkpoints, by which a run that was
//! broken off goes on to the same bits.

use granum_dem::observer::Observer;
use granum_io::run::{RunFolder, RunRecord};

use super::{Engine, PlannedRun, Task};
use crate::laboratory::{Laboratory, LaboratoryError, run};

/// granum's own engine.
#[derive(Clone, Copy, Debug)]
pub struct Native;

impl Engine for Native {
    fn name(&self) -> &'static str {
        granum_io::run::OWN_ENGINE
    }

    fn help(&self) -> &'static str {
        "granum's own engine: the same bits on any number of threads, checkpoints"
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
