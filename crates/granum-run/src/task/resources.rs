//! What the simulations of a laboratory may use of a computer.

use std::sync::Arc;
use std::time::Duration;

use granum_dem::simulation::Hardware;

use crate::task::shared::Shared;

/// Smallest number of grains for which a thread of its own is worthwhile.
pub const GRAINS_PER_THREAD: usize = 1500;
/// Default wall time between two checkpoints.
pub const CHECKPOINT_EVERY: Duration = Duration::from_secs(30);

/// What the simulations of a laboratory may use of a computer. Results do not depend on it.
#[derive(Clone, Debug)]
pub struct Resources {
    /// Threads and instruction set.
    pub hardware: Hardware,
    /// Smallest number of grains for each thread; with 1, all threads of `hardware` are used.
    pub grains_per_thread: usize,
    /// The other runs with which a run shares the processors, if there are any.
    pub shared: Option<Arc<Shared>>,
    /// Wall time between two checkpoints.
    pub checkpoint_every: Duration,
}

impl Resources {
    /// Of a run that shares the processors with no other and writes checkpoints at the default interval.
    pub fn new(hardware: Hardware) -> Resources {
        Resources {
            hardware,
            grains_per_thread: GRAINS_PER_THREAD,
            shared: None,
            checkpoint_every: CHECKPOINT_EVERY,
        }
    }

    /// All processors of this computer.
    pub fn here() -> Resources {
        let threads = granum_core::parallel::available_threads();
        Resources::new(Hardware { threads, ..Hardware::default() })
    }

    /// The threads and instruction set for a simulation of a number of grains, given the runs that share the processors at present.
    pub fn hardware_for(&self, grains: usize) -> Hardware {
        let running = self.shared.as_ref().map_or(1, |s| s.running().max(1));
        let useful = grains / self.grains_per_thread.max(1);
        Hardware { threads: (self.hardware.threads / running).min(useful).max(1), ..self.hardware }
    }
}
