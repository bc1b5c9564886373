//! What a program knows by name: all that runs know, the methods of surrogates, and the schedulers of campaigns.

use std::path::Path;

use granum_antony2006::MappingMethod;
use granum_campaign::scheduler::{SchedulerKind, Schedulers};
use granum_core::RegistrationError;
use granum_dem::bond::BondKind;
use granum_dem::contact::choice::registry::Law;
use granum_dem::loading::preset::Preset;
use granum_io::formats::{PackingFormat, ResultFormat, TableFormat};
use granum_io::{Case, Reading, Run};
use granum_learn::{SurrogateMethod, SurrogateMethods};
use granum_run::{Engine, RunRegistry};
use granum_sensors::Sensor;

/// What a program knows by name: contact laws, named paths, sensors, formats, engines, methods of surrogates and schedulers. A program
/// builds it once and passes it on: to a [`Laboratory`](granum_run::Laboratory), to a study, or to the whole command line of granum
/// ([`granum::program::run`](crate::program::run)).
///
/// ```
/// use granum::prelude::*;
///
/// let registry = Registry::standard();
/// let case = registry.parse_case("[[stage]]\npath = 'oedometer'\n", "case")?;
/// let laboratory = Laboratory::here().with_registry(&registry);
/// assert!(laboratory.registry.engines.named("granum").is_ok());
/// assert_eq!(registry.methods.by_name("ridge")?.name(), "ridge");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Registry {
    /// Laws, paths, sensors, formats and engines: what runs know.
    pub runs: RunRegistry,
    /// Methods of surrogates, for studies and for the files of surrogates.
    pub methods: SurrogateMethods,
    /// Schedulers of campaigns.
    pub schedulers: Schedulers,
}

impl Default for Registry {
    fn default() -> Registry {
        Registry::standard()
    }
}

impl From<Registry> for RunRegistry {
    fn from(registry: Registry) -> RunRegistry {
        registry.runs
    }
}

impl From<&Registry> for RunRegistry {
    fn from(registry: &Registry) -> RunRegistry {
        registry.runs.clone()
    }
}

impl Registry {
    /// Everything that comes with granum.
    pub fn standard() -> Registry {
        Registry {
            runs: RunRegistry::standard(),
            methods: SurrogateMethods::standard().replaced_by(MappingMethod::default()),
            schedulers: Schedulers::standard(),
        }
    }

    /// Adds a contact law, which case files can then name.
    ///
    /// # Errors
    /// As [`RunRegistry::with_law`].
    pub fn with_law(self, law: impl Into<Law>) -> Result<Registry, RegistrationError> {
        Ok(Registry { runs: self.runs.with_law(law)?, ..self })
    }

    /// Adds a law of bonds, which a table `[[bond]]` of a case can then name, with its parameters as keys of the table.
    ///
    /// # Errors
    /// As [`RunRegistry::with_bond_law`].
    pub fn with_bond_law(self, law: BondKind) -> Result<Registry, RegistrationError> {
        Ok(Registry { runs: self.runs.with_bond_law(law)?, ..self })
    }

    /// Adds a path, which case files can then name.
    ///
    /// # Errors
    /// As [`RunRegistry::with_path`].
    pub fn with_path(self, path: &'static Preset) -> Result<Registry, RegistrationError> {
        Ok(Registry { runs: self.runs.with_path(path)?, ..self })
    }

    /// Adds a sensor, which a case requests by its name in `recording.sensors`, with its parameters as keys of `[recording]`.
    ///
    /// # Errors
    /// As [`RunRegistry::with_sensor`].
    pub fn with_sensor(self, sensor: impl Sensor + 'static) -> Result<Registry, RegistrationError> {
        Ok(Registry { runs: self.runs.with_sensor(sensor)?, ..self })
    }

    /// Adds a format of tables.
    ///
    /// # Errors
    /// As [`RunRegistry::with_table_format`].
    pub fn with_table_format(
        self,
        format: impl TableFormat + 'static,
    ) -> Result<Registry, RegistrationError> {
        Ok(Registry { runs: self.runs.with_table_format(format)?, ..self })
    }

    /// Adds a format of packings.
    ///
    /// # Errors
    /// As [`RunRegistry::with_packing_format`].
    pub fn with_packing_format(
        self,
        format: impl PackingFormat + 'static,
    ) -> Result<Registry, RegistrationError> {
        Ok(Registry { runs: self.runs.with_packing_format(format)?, ..self })
    }

    /// Adds a format of results.
    ///
    /// # Errors
    /// As [`RunRegistry::with_result_format`].
    pub fn with_result_format(
        self,
        format: impl ResultFormat + 'static,
    ) -> Result<Registry, RegistrationError> {
        Ok(Registry { runs: self.runs.with_result_format(format)?, ..self })
    }

    /// Adds an engine; [`Laboratory::engine`](granum_run::Laboratory::engine) selects it.
    ///
    /// # Errors
    /// As [`RunRegistry::with_engine`].
    pub fn with_engine(self, engine: impl Engine + 'static) -> Result<Registry, RegistrationError> {
        Ok(Registry { runs: self.runs.with_engine(engine)?, ..self })
    }

    /// Adds a method of surrogates.
    ///
    /// # Errors
    /// As [`SurrogateMethods::with`].
    pub fn with_method(self, method: impl SurrogateMethod + 'static) -> Result<Registry, RegistrationError> {
        Ok(Registry { methods: self.methods.with(method)?, ..self })
    }

    /// Adds a scheduler, which `granum campaign --scheduler` then knows.
    ///
    /// # Errors
    /// As [`Schedulers::with`].
    pub fn with_scheduler(self, kind: SchedulerKind) -> Result<Registry, RegistrationError> {
        Ok(Registry { schedulers: self.schedulers.with(kind)?, ..self })
    }

    /// Reads the text of a case file that can name these laws, paths and sensors; `file` is its name for messages.
    ///
    /// # Errors
    /// As [`Case::parse`].
    pub fn parse_case(&self, text: &str, file: &str) -> granum_io::Result<Case> {
        self.runs.parse_case(text, file)
    }

    /// Reads a case file that can name these laws, paths and sensors.
    ///
    /// # Errors
    /// As [`Case::read`].
    pub fn read_case(&self, path: impl AsRef<Path>) -> granum_io::Result<Case> {
        self.runs.read_case(path)
    }

    /// How case files are read that can name these laws, paths and sensors.
    pub fn reading(&self) -> Reading {
        self.runs.reading()
    }

    /// The run in a folder, whose case can name these laws, paths and sensors.
    ///
    /// # Errors
    /// As [`Run::at`].
    pub fn run_at(&self, folder: impl AsRef<Path>) -> granum_io::Result<Run> {
        self.runs.run_at(folder)
    }
}
