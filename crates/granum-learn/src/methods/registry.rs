//! The registry of methods. A new method needs a file in this folder and a line in [`SurrogateMethods::standard`].

use std::path::Path;
use std::sync::Arc;

use super::boosted_trees::BoostedTrees;
use super::cascade::Cascade;
use super::curve_process::GaussianProcessOfCurves;
use super::feed_forward::FeedForward;
use super::mean_curve::MeanCurve;
use super::nearest_run::NearestRun;
use super::path::{PathCell, PathNetworks};
use super::recurrent::Recurrent;
use super::ridge::RidgeRegression;
use crate::error::{LearnError, Result};
use crate::methods::networks::{NetworkSettings, NetworksBySubModel};
use crate::surrogate::file::{self, Opened};
use crate::surrogate::surrogate_trait::{Surrogate, SurrogateMethod};
use granum_core::RegistrationError;
use granum_io::shell::ShowPath;

/// A registry of methods by name, for fitting and for reading files.
///
/// ```
/// use granum_learn::SurrogateMethods;
///
/// let methods = SurrogateMethods::standard();
/// assert_eq!(methods.names(), [
///     "feed-forward", "ridge", "mean-curve", "nearest-run", "boosted-trees", "gaussian-process", "cascade", "recurrent", "path-gru",
///     "path-lstm", "path-state-space", "path-window", "path-tensor", "sub-models",
/// ]);
/// let error = methods.by_name("rigde").err().unwrap().to_string();
/// assert_eq!(error, "there is no surrogate method `rigde`; did you mean ridge?");
/// ```
#[derive(Clone)]
pub struct SurrogateMethods {
    methods: Vec<Arc<dyn SurrogateMethod>>,
}

impl std::fmt::Debug for SurrogateMethods {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_tuple("SurrogateMethods").field(&self.names()).finish()
    }
}

impl Default for SurrogateMethods {
    fn default() -> Self {
        SurrogateMethods::standard()
    }
}

impl SurrogateMethods {
    /// The methods of this crate with their default settings.
    pub fn standard() -> SurrogateMethods {
        SurrogateMethods {
            methods: vec![
                Arc::new(FeedForward::default()),
                Arc::new(RidgeRegression::default()),
                Arc::new(MeanCurve),
                Arc::new(NearestRun),
                Arc::new(BoostedTrees::default()),
                Arc::new(GaussianProcessOfCurves::default()),
                Arc::new(Cascade::default()),
                Arc::new(Recurrent::default()),
                Arc::new(PathNetworks::new(PathCell::Gru)),
                Arc::new(PathNetworks::new(PathCell::Lstm)),
                Arc::new(PathNetworks::new(PathCell::StateSpace)),
                Arc::new(PathNetworks::new(PathCell::Window)),
                Arc::new(PathNetworks::new(PathCell::TensorStateSpace)),
                Arc::new(NetworksBySubModel::default()),
            ],
        }
    }

    /// The same methods, those with networks with the given settings.
    ///
    /// # Errors
    /// If there is no trainer of the given name.
    pub fn with_networks(&self, settings: &NetworkSettings) -> Result<SurrogateMethods> {
        let set = |method: &Arc<dyn SurrogateMethod>| {
            Ok(method.with_networks(settings)?.unwrap_or_else(|| method.clone()))
        };
        Ok(SurrogateMethods { methods: self.methods.iter().map(set).collect::<Result<_>>()? })
    }

    /// Adds a method.
    ///
    /// # Errors
    /// [`RegistrationError::Name`] if there is already a method of the same name, or the name is not a word.
    pub fn with(
        self,
        method: impl SurrogateMethod + 'static,
    ) -> std::result::Result<SurrogateMethods, RegistrationError> {
        RegistrationError::check_name("surrogate method", method.name(), self.names())?;
        Ok(self.replaced_by(method))
    }

    /// The same methods, with this one in place of that of its name, as to give it other settings.
    pub fn replaced_by(mut self, method: impl SurrogateMethod + 'static) -> SurrogateMethods {
        self.methods.retain(|known| known.name() != method.name());
        self.methods.push(Arc::new(method));
        self
    }

    /// All methods.
    pub fn all(&self) -> impl Iterator<Item = &dyn SurrogateMethod> {
        self.methods.iter().map(AsRef::as_ref)
    }

    /// Their names.
    pub fn names(&self) -> Vec<&str> {
        self.all().map(SurrogateMethod::name).collect()
    }

    /// The method of the given name.
    ///
    /// # Errors
    /// [`LearnError::Unknown`] with the existing names.
    pub fn by_name(&self, name: &str) -> Result<&dyn SurrogateMethod> {
        self.found(name).map(AsRef::as_ref)
    }

    /// As [`SurrogateMethods::by_name`], to be kept.
    ///
    /// # Errors
    /// As [`SurrogateMethods::by_name`].
    pub fn shared(&self, name: &str) -> Result<Arc<dyn SurrogateMethod>> {
        self.found(name).cloned()
    }

    fn found(&self, name: &str) -> Result<&Arc<dyn SurrogateMethod>> {
        self.methods.iter().find(|method| method.name() == name).ok_or_else(|| LearnError::Unknown {
            kind: "surrogate method",
            name: name.to_owned(),
            known: self.names().join(", "),
        })
    }

    /// Reads a surrogate that was written by [`crate::surrogate::save`].
    ///
    /// # Errors
    /// If the file cannot be read, was altered, is of a newer version, or belongs to a method that is not in the registry;
    /// the message names the file.
    pub fn load(&self, path: &Path) -> Result<Box<dyn Surrogate>> {
        self.assembled(file::read(path)?, &path.shown())
    }

    /// Reads a surrogate from the text of its file; `name` is used in error messages.
    ///
    /// # Errors
    /// As [`SurrogateMethods::load`].
    pub fn from_json(&self, text: &str, name: &str) -> Result<Box<dyn Surrogate>> {
        self.assembled(file::parse(text, name)?, name)
    }

    fn assembled(&self, opened: Opened, name: &str) -> Result<Box<dyn Surrogate>> {
        let damaged = |reason: String| LearnError::SurrogateFile { file: name.to_owned(), reason };
        if opened.columns.inputs.is_empty() || opened.columns.outputs.is_empty() {
            return Err(damaged("it has no inputs or no outputs".into()));
        }
        let method = self.by_name(&opened.method).map_err(|error| {
            damaged(format!("{error}; a user-defined method must be registered before its files are read"))
        })?;
        method.load(opened.columns, &opened.content).map_err(|error| damaged(error.to_string()))
    }
}
