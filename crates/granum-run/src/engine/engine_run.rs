//! A run of an engine whose inputs have been checked.

use granum_dem::observer::SimulationObserver;
use granum_io::run::RunRecord;

use crate::task::laboratory_error::LaboratoryError;
use crate::task::sink::Sink;

/// The work of an [`EngineRun`].
type Work = dyn FnOnce(&mut dyn Sink, &mut dyn SimulationObserver) -> Result<(), LaboratoryError> + Send;

/// A run of an engine whose inputs have been checked. Nothing has been written yet.
pub struct EngineRun {
    /// The record with which the run begins.
    pub record: RunRecord,
    work: Box<Work>,
    saves_first: bool,
}

impl EngineRun {
    /// A run that begins with a record. `work` computes the results and puts them into the sink, until its end or until the observer
    /// stops it: then it sets the status of the sink's record to [`RunStatus::Interrupted`](granum_io::RunStatus::Interrupted).
    pub fn new(
        record: RunRecord,
        work: impl FnOnce(&mut dyn Sink, &mut dyn SimulationObserver) -> Result<(), LaboratoryError>
        + Send
        + 'static,
    ) -> EngineRun {
        EngineRun { record, work: Box::new(work), saves_first: false }
    }

    /// The same run, whose work begins with saving a checkpoint: its folder then never depends on the folder or file that its sample comes
    /// from, since the checkpoint is there before its record.
    #[must_use]
    pub fn saving_first(self) -> EngineRun {
        EngineRun { saves_first: true, ..self }
    }

    /// True if its work begins with saving a checkpoint.
    pub(crate) fn saves_first(&self) -> bool {
        self.saves_first
    }

    /// Executes the run until its end, or until the observer stops it. The record of the sink must be that of the run.
    ///
    /// # Errors
    /// If the run fails, or the sink cannot take what it finds.
    pub fn run(
        self,
        sink: &mut dyn Sink,
        observer: &mut dyn SimulationObserver,
    ) -> Result<(), LaboratoryError> {
        (self.work)(sink, observer)
    }
}

impl std::fmt::Debug for EngineRun {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("EngineRun").field("record", &self.record).finish_non_exhaustive()
    }
}
