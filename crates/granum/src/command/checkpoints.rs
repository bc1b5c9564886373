//! The flag for the interval of checkpoints.

use std::time::Duration;

use clap::Args;
use granum_run::laboratory::CHECKPOINT_EVERY;

use crate::failure::Failure;

/// The interval of checkpoints.
#[derive(Args, Clone, Debug)]
pub struct CheckpointFlags {
    /// Wall time between two checkpoints, s (0: as often as possible). Results do not depend on it.
    #[arg(long, value_name = "SECONDS", default_value_t = CHECKPOINT_EVERY.as_secs_f64(), allow_negative_numbers = true)]
    checkpoint_every: f64,
}

impl Default for CheckpointFlags {
    fn default() -> Self {
        CheckpointFlags { checkpoint_every: CHECKPOINT_EVERY.as_secs_f64() }
    }
}

impl CheckpointFlags {
    pub fn every(&self) -> Result<Duration, Failure> {
        let seconds = self.checkpoint_every;
        if !(0.0..=1e6).contains(&seconds) {
            return Err(Failure::new(format!(
                "--checkpoint-every {seconds}: it must be from 0 to 1e6 seconds"
            )));
        }
        Ok(Duration::from_secs_f64(seconds))
    }
}
