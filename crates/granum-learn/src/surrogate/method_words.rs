//! Methods with settings in words.

use std::sync::Arc;

use super::path::{PathCell, PathNetworks};
use super::registry::SurrogateMethods;
use super::surrogate_trait::SurrogateMethod;
use crate::error::{LearnError, Result};

fn method_error(method: &str, reason: String) -> LearnError {
    LearnError::Surrogate { method: method.into(), reason }
}

/// A method of a registry by its name, or networks with a state and settings: `path-tensor:hidden=12,internal=0`. The settings are `hidden`, `internal`,
/// `window`, `networks`, `rotations`, `epochs` and `rate` (of learning).
///
/// ```
/// use granum_learn::surrogate::{SurrogateMethods, method_of_words};
///
/// let methods = SurrogateMethods::standard();
/// assert_eq!(method_of_words("path-window:window=5,epochs=20", &methods)?.name(), "path-window");
/// assert!(method_of_words("path-window:size=5", &methods).is_err());
/// # Ok::<(), granum_learn::LearnError>(())
/// ```
///
/// # Errors
/// If there is no such method or setting, or its value is no number.
pub fn method_of_words(words: &str, methods: &SurrogateMethods) -> Result<Arc<dyn SurrogateMethod>> {
    let Some((name, settings)) = words.split_once(':') else { return methods.shared(words) };
    methods.by_name(name)?;
    let known = PathCell::ALL.into_iter().find(|cell| cell.name() == name);
    let cell = known.ok_or_else(|| LearnError::Surrogate {
        method: name.into(),
        reason: "it has no settings; networks of paths have them".into(),
    })?;
    let mut method = PathNetworks::new(cell);
    let mut adam = PathNetworks::adam(cell);
    for setting in settings.split(',') {
        let bad = || {
            let known = "hidden, internal, window, networks, rotations, epochs, rate";
            method_error(
                name,
                format!(
                    "`{setting}` is no setting: each is a word and a number, as hidden=12; there are {known}"
                ),
            )
        };
        let (key, value) = setting.split_once('=').ok_or_else(bad)?;
        let whole = || value.parse::<usize>().map_err(|_| bad());
        match key {
            "hidden" => method.hidden = whole()?,
            "internal" => method.internal = whole()?,
            "window" => method.window = whole()?,
            "networks" => method.networks = whole()?,
            "rotations" => method.rotations = whole()?,
            "epochs" => (adam.epochs, adam.maximum_failures) = (whole()? as u64, whole()? as u64),
            "rate" => adam.learning_rate = value.parse().map_err(|_| bad())?,
            _ => return Err(bad()),
        }
    }
    method.trainer = adam.into();
    Ok(Arc::new(method))
}
