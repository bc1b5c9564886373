//! What runs know by name: laws, paths, sensors, formats, engines.

use std::path::Path;

use granum_core::RegistrationError;
use granum_dem::bond::BondKind;
use granum_dem::contact::choice::registry::Law;
use granum_dem::loading::preset::Preset;
use granum_io::case::Vocabulary;
use granum_io::formats::{PackingFormat, ResultFormat, TableFormat};
use granum_io::{Case, Formats, Reading, Run};
use granum_sensors::Sensor;

use crate::engine::engine_trait::Engine;
use crate::engine::engines::Engines;

/// What runs know by name: contact laws, named paths, sensors, formats and engines. A program builds it once and passes it on, with
/// methods of surrogates as `granum::Registry`.
///
/// ```
/// use granum_run::RunRegistry;
///
/// let registry = RunRegistry::standard();
/// let case = registry.parse_case("[[stage]]\npath = 'oedometer'\n", "case")?;
/// assert_eq!(case.test_stages().len(), 1);
/// assert!(registry.vocabulary.sensors().named("overlap_distribution").is_ok());
/// assert!(registry.engines.named("granum").is_ok());
/// # Ok::<(), granum_io::Error>(())
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct RunRegistry {
    /// The laws, paths and sensors that case files can name.
    pub vocabulary: Vocabulary,
    /// The formats of tables, packings and results.
    pub formats: Formats,
    /// The engines.
    pub engines: Engines,
}

impl Default for RunRegistry {
    fn default() -> RunRegistry {
        RunRegistry::standard()
    }
}

impl RunRegistry {
    /// Everything that comes with granum.
    pub fn standard() -> RunRegistry {
        RunRegistry {
            vocabulary: Vocabulary::standard(),
            formats: Formats::standard(),
            engines: Engines::standard(),
        }
    }

    /// What a program needs that reads no files and starts no other program: laws, paths and sensors, and granum's own engine.
    pub fn without_files() -> RunRegistry {
        RunRegistry { vocabulary: Vocabulary::standard(), formats: Formats::none(), engines: Engines::own() }
    }

    /// Adds a contact law, which case files can then name.
    ///
    /// # Errors
    /// [`RegistrationError`] if its name or a key of it is taken, or there is no room for its parameters.
    pub fn with_law(mut self, law: impl Into<Law>) -> Result<RunRegistry, RegistrationError> {
        self.vocabulary = self.vocabulary.with_law(law)?;
        Ok(self)
    }

    /// Adds a law of bonds, which a table `[[bond]]` of a case can then name, with its parameters as keys of the table.
    ///
    /// # Errors
    /// [`RegistrationError`] if its name is taken.
    pub fn with_bond_law(mut self, law: BondKind) -> Result<RunRegistry, RegistrationError> {
        self.vocabulary = self.vocabulary.with_bond_law(law)?;
        Ok(self)
    }

    /// Adds a path, which case files can then name.
    ///
    /// # Errors
    /// [`RegistrationError`] if its name is taken, or its parameters are not declared correctly.
    pub fn with_path(mut self, path: &'static Preset) -> Result<RunRegistry, RegistrationError> {
        self.vocabulary = self.vocabulary.with_path(path)?;
        Ok(self)
    }

    /// Adds a sensor, which a case requests by its name in `recording.sensors`, with its parameters as keys of `[recording]`.
    ///
    /// # Errors
    /// [`RegistrationError`] as [`granum_sensors::Sensors::with`].
    pub fn with_sensor(mut self, sensor: impl Sensor + 'static) -> Result<RunRegistry, RegistrationError> {
        self.vocabulary = self.vocabulary.with_sensor(sensor)?;
        Ok(self)
    }

    /// Adds a format of tables.
    ///
    /// # Errors
    /// As [`Formats::with_table`].
    pub fn with_table_format(
        mut self,
        format: impl TableFormat + 'static,
    ) -> Result<RunRegistry, RegistrationError> {
        self.formats = self.formats.with_table(format)?;
        Ok(self)
    }

    /// Adds a format of packings.
    ///
    /// # Errors
    /// As [`Formats::with_packing`].
    pub fn with_packing_format(
        mut self,
        format: impl PackingFormat + 'static,
    ) -> Result<RunRegistry, RegistrationError> {
        self.formats = self.formats.with_packing(format)?;
        Ok(self)
    }

    /// Adds a format of results.
    ///
    /// # Errors
    /// As [`Formats::with_result`].
    pub fn with_result_format(
        mut self,
        format: impl ResultFormat + 'static,
    ) -> Result<RunRegistry, RegistrationError> {
        self.formats = self.formats.with_result(format)?;
        Ok(self)
    }

    /// Adds an engine; [`Laboratory::engine`](crate::Laboratory::engine) selects it.
    ///
    /// # Errors
    /// [`RegistrationError`] if there is already an engine of the same name.
    pub fn with_engine(mut self, engine: impl Engine + 'static) -> Result<RunRegistry, RegistrationError> {
        self.engines = self.engines.with(engine)?;
        Ok(self)
    }

    /// Reads the text of a case file that can name these laws, paths and sensors; `file` is its name for messages.
    ///
    /// # Errors
    /// As [`Case::parse`].
    pub fn parse_case(&self, text: &str, file: &str) -> granum_io::Result<Case> {
        Case::parse_as(text, file, self.reading())
    }

    /// Reads a case file that can name these laws, paths and sensors.
    ///
    /// # Errors
    /// As [`Case::read`].
    pub fn read_case(&self, path: impl AsRef<Path>) -> granum_io::Result<Case> {
        Case::read_as(path, self.reading())
    }

    /// How case files are read that can name these laws, paths and sensors.
    pub fn reading(&self) -> Reading {
        Reading::default().with_vocabulary(&self.vocabulary)
    }

    /// The run in a folder, whose case can name these laws, paths and sensors.
    ///
    /// # Errors
    /// As [`Run::at`].
    pub fn run_at(&self, folder: impl AsRef<Path>) -> granum_io::Result<Run> {
        Ok(Run::at(folder)?.with_vocabulary(&self.vocabulary))
    }
}
