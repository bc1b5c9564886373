//! An engine: it gives the measurements of a test that was made before, as one that starts another program gives what it reads.

use granum::dem::observer::SimulationObserver;
use granum::prelude::*;
use granum::run::{EngineError, LaboratoryError};

/// The measurements that it gives.
pub struct Replay(pub Record);

impl Engine for Replay {
    fn name(&self) -> &'static str {
        "replay"
    }

    fn help(&self) -> &'static str {
        "the measurements of a test that was made before"
    }

    fn plan(&self, task: Task, _: &mut dyn SimulationObserver) -> Result<EngineRun, LaboratoryError> {
        if task.kind == RunKind::Sample {
            let what = "it makes no samples; use the engine granum".to_string();
            return Err(EngineError::Refused { engine: self.name().into(), what }.into());
        }
        let record = self.0.clone();
        Ok(EngineRun::new(task.record()?, move |sink, _| Ok(sink.save_measurements(&record)?)))
    }
}
