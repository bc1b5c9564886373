//! The laboratory of a campaign and what a process of a run is given, from the flags of the command.

use std::ffi::OsString;

use granum_dem::Isa;
use granum_dem::simulation::Hardware;
use granum_run::Laboratory;

use super::flags::CarryOutFlags;
use crate::command::checkpoints::CheckpointFlags;
use crate::command::hardware::processors;
use crate::context::Context;
use crate::failure::Failure;

/// Most runs at once.
const MOST_WORKERS: usize = 4096;

/// A laboratory with so many threads.
pub fn laboratory(
    context: &Context,
    threads: usize,
    checkpoints: &CheckpointFlags,
) -> Result<Laboratory, Failure> {
    let hardware = Hardware { threads, isa: Isa::detect() };
    let mut laboratory =
        Laboratory::new(hardware, env!("CARGO_PKG_VERSION")).with_registry(context.run_registry());
    laboratory.resources.checkpoint_every = checkpoints.every()?;
    Ok(laboratory)
}

impl CarryOutFlags {
    /// Those of a campaign that is resumed.
    pub fn resumed(checkpoints: &CheckpointFlags) -> CarryOutFlags {
        CarryOutFlags { workers: None, stop_after: None, again: false, checkpoints: checkpoints.clone() }
    }

    /// The number of runs at once, if it is given.
    pub fn workers(&self) -> Result<Option<usize>, Failure> {
        match self.workers {
            Some(0) => Err(Failure::new("--workers 0: at least one run at once is needed")),
            Some(count) if count > MOST_WORKERS => Err(Failure::new(format!(
                "--workers {count}: at most {MOST_WORKERS} runs at once are possible"
            ))),
            workers => Ok(workers),
        }
    }

    /// The laboratory of the coordinator, which has a thread for each processor.
    pub fn laboratory(&self, context: &Context) -> Result<Laboratory, Failure> {
        laboratory(context, processors(), &self.checkpoints)
    }

    /// The flags with which this program executes a run.
    pub fn arguments(&self, context: &Context) -> Result<Vec<OsString>, Failure> {
        let seconds = self.checkpoints.every()?.as_secs_f64();
        let mut arguments: Vec<OsString> = vec!["--checkpoint-every".into(), seconds.to_string().into()];
        if context.allow_outside {
            arguments.push("--allow-outside".into());
        }
        Ok(arguments)
    }
}
