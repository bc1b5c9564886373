//! How a laboratory is set up.

use std::time::Duration;

use granum_dem::simulation::Hardware;
use granum_io::Formats;
use granum_sensors::{Sensor, SensorError, Sensors};

use crate::engine::engine_error::EngineError;
use crate::engine::engine_trait::{Engine, Engines, Laboratory};
use crate::engine::native::Native;

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
            engines: Engines::standard(),
            sensors: Sensors::standard(),
            formats: Formats::standard(),
        }
    }

    /// Adds an engine and selects it for the execution of cases.
    ///
    /// # Errors
    /// [`EngineError::NameTaken`] if there is already an engine of the same name.
    pub fn with_engine(mut self, engine: impl Engine + 'static) -> Result<Laboratory, EngineError> {
        self.engine = engine.name().to_string();
        self.engines = self.engines.with(engine)?;
        Ok(self)
    }

    /// The same laboratory with other formats, by which it reads packings.
    pub fn with_formats(self, formats: Formats) -> Laboratory {
        Laboratory { formats, ..self }
    }

    /// Adds a sensor, which a case requests by its name in `recording.sensors`.
    ///
    /// # Errors
    /// As [`Sensors::with`].
    pub fn with_sensor(mut self, sensor: impl Sensor + 'static) -> Result<Laboratory, SensorError> {
        self.sensors = self.sensors.with(sensor)?;
        Ok(self)
    }
}
