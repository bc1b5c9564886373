//! How a laboratory is set up.

use std::time::Duration;

use granum_dem::simulation::Hardware;

use crate::engine::engine_trait::{Engine, Laboratory};
use crate::engine::native::Native;
use crate::registry::Registry;

/// Smallest number of grains for which a thread of its own is worthwhile.
pub const GRAINS_PER_THREAD: usize = 1500;
/// Default wall time between two checkpoints.
pub const CHECKPOINT_EVERY: Duration = Duration::from_secs(30);

impl Laboratory {
    /// A laboratory that shares its processors with no other run and writes checkpoints at the default interval.
    pub fn new(hardware: Hardware, version: impl Into<String>) -> Laboratory {
        Laboratory {
            hardware,
            grains_per_thread: GRAINS_PER_THREAD,
            shared: None,
            checkpoint_every: CHECKPOINT_EVERY,
            version: version.into(),
            engine: Native.name().to_string(),
            registry: Registry::standard(),
        }
    }

    /// The same laboratory with other laws, paths, sensors, formats and engines.
    pub fn with_registry(self, registry: Registry) -> Laboratory {
        Laboratory { registry, ..self }
    }
}
