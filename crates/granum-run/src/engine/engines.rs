//! The registry of the engines of a program.

use std::sync::Arc;

use granum_core::RegistrationError;
use granum_core::names::suggestion;

use super::engine_trait::Engine;
use super::lammps::Lammps;
use super::native::Native;
use crate::task::engine_error::EngineError;

/// The registry of the engines of a program.
///
/// ```
/// let engines = granum_run::Engines::standard();
/// assert_eq!(engines.names().collect::<Vec<_>>(), ["granum", "lammps"]);
/// let error = engines.named("gramun").err().map(|error| error.to_string());
/// assert_eq!(error.as_deref(), Some("there is no engine \"gramun\"; did you mean granum?"));
/// ```
#[derive(Clone)]
pub struct Engines(Vec<Arc<dyn Engine>>);

impl Engines {
    /// Granum's own engine alone: for a program that starts no other.
    pub fn own() -> Engines {
        Engines(vec![Arc::new(Native)])
    }

    /// The engines that come with granum.
    pub fn standard() -> Engines {
        Engines(vec![Arc::new(Native), Arc::new(Lammps::default())])
    }

    /// Adds an engine.
    ///
    /// # Errors
    /// [`RegistrationError::Name`] if there is already an engine of the same name, or the name is not a word.
    pub fn with(mut self, engine: impl Engine + 'static) -> Result<Engines, RegistrationError> {
        RegistrationError::check_name("engine", engine.name(), self.names())?;
        self.0.push(Arc::new(engine));
        Ok(self)
    }

    /// The same engines, with this one in place of that of its name, as to give it other settings.
    pub fn replaced_by(mut self, engine: impl Engine + 'static) -> Engines {
        self.0.retain(|known| known.name() != engine.name());
        self.0.push(Arc::new(engine));
        self
    }

    /// Their names.
    pub fn names(&self) -> impl Iterator<Item = &'static str> + Clone {
        self.0.iter().map(|engine| engine.name())
    }

    /// The engine of the given name.
    ///
    /// # Errors
    /// [`EngineError::Unknown`] with the most similar name.
    pub fn named(&self, name: &str) -> Result<&dyn Engine, EngineError> {
        let found = self.0.iter().find(|engine| engine.name() == name);
        found.map(|engine| &**engine).ok_or_else(|| EngineError::Unknown {
            name: name.to_string(),
            suggestion: suggestion(name, self.names()),
        })
    }
}

impl std::fmt::Debug for Engines {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_list().entries(self.names()).finish()
    }
}
