//! The sample of a test that another engine carries out: granum's own engine prepares and consolidates it.

use std::sync::Arc;

use granum_dem::observer::SimulationObserver;
use granum_dem::simulation::Simulation;
use granum_io::Case;
use granum_io::run::{RunFolder, RunRecord};

use super::run::{self, Begun, Left};
use super::run_state::{self, RunState};
use super::task_execution::TaskExecution;
use crate::task::definition::Task;
use crate::task::laboratory_error::LaboratoryError;
use crate::task::sink::Sink;
use crate::task::source::Source;

/// Makes the sample of a test, with checkpoints in the folder of the run.
pub(in crate::engine) struct SampleMaker {
    execution: TaskExecution,
    /// The state from which it goes on; `None` to begin with what the record names.
    run_state: Option<RunState>,
}

impl SampleMaker {
    /// Reads and checks the inputs of the sample; the record is that of the whole run.
    ///
    /// # Errors
    /// As for a run of granum's own engine.
    pub(in crate::engine) fn plan(
        task: &Task,
        observer: &mut dyn SimulationObserver,
    ) -> Result<(SampleMaker, RunRecord), LaboratoryError> {
        let Begun { execution, run_state, record } = run::begin(task, false, observer)?;
        Ok((SampleMaker { execution, run_state: Some(run_state) }, record))
    }

    /// Reads the last usable checkpoint of a folder.
    ///
    /// # Errors
    /// As for a run of granum's own engine.
    pub(in crate::engine) fn resume(
        task: &Task,
        record: &RunRecord,
        folder: &RunFolder,
        observer: &mut dyn SimulationObserver,
    ) -> Result<SampleMaker, LaboratoryError> {
        let execution = TaskExecution::new(task);
        let run_state = run_state::last_good(folder, record, &task.case, &execution.vocabulary, observer)?;
        Ok(SampleMaker { execution, run_state })
    }

    /// Makes the sample; `None` if the observer stopped it, in which case the record says so.
    ///
    /// # Errors
    /// As for a run of granum's own engine.
    pub(in crate::engine) fn make(
        self,
        case: &Case,
        sink: &mut dyn Sink,
        observer: &mut dyn SimulationObserver,
    ) -> Result<Option<Simulation>, LaboratoryError> {
        let SampleMaker { execution, run_state } = self;
        let run_state = match run_state {
            Some(run_state) => run_state,
            None => {
                let source = Source::recorded(&sink.record().source)?;
                execution.start(case, &source, None, sink.record(), observer)?
            }
        };
        Ok(match execution.go_on_to(case, run_state, true, sink, observer)? {
            Left::Sample(run_state) => Some(run_state.simulation),
            Left::Stopped(run_state) => {
                sink.keep(Arc::new(run_state.simulation));
                None
            }
            Left::Complete => None,
        })
    }
}
