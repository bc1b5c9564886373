//! Methods with settings in words.

use std::sync::Arc;

use super::path::{PathCell, PathNetworks};
use super::registry::SurrogateMethods;
use crate::error::{LearnError, Result};
use crate::surrogate::surrogate_trait::SurrogateMethod;

/// Largest numbers of networks and of epochs.
const MOST_NETWORKS: usize = 1000;
const MOST_EPOCHS: usize = 1_000_000;

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
/// If there is no such method or setting, or its value is no number or outside of its bounds.
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
        let from_to = |least: usize, most: usize| {
            let found = whole()?;
            let reason = || format!("`{setting}`: it must be from {least} to {most}");
            if (least..=most).contains(&found) { Ok(found) } else { Err(method_error(name, reason())) }
        };
        match key {
            "hidden" => method.hidden = whole()?,
            "internal" => method.internal = whole()?,
            "window" => method.window = whole()?,
            "networks" => method.networks = from_to(1, MOST_NETWORKS)?,
            "rotations" => method.rotations = from_to(0, PathNetworks::MOST_ROTATIONS)?,
            "epochs" => {
                let epochs = from_to(1, MOST_EPOCHS)? as u64;
                (adam.epochs, adam.maximum_failures) = (epochs, epochs);
            }
            "rate" => {
                let rate: f64 = value.parse().map_err(|_| bad())?;
                if !(rate > 0.0 && rate <= 1.0) {
                    return Err(method_error(name, format!("`{setting}`: it must be above 0 and at most 1")));
                }
                adam.learning_rate = rate;
            }
            _ => return Err(bad()),
        }
    }
    method.trainer = adam.into();
    Ok(Arc::new(method))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_that_cannot_be_are_refused_with_their_bounds() {
        let methods = SurrogateMethods::standard();
        for (setting, expected) in [
            ("rate=nan", "above 0 and at most 1"),
            ("rate=0", "above 0 and at most 1"),
            ("rate=-1", "above 0 and at most 1"),
            ("rate=inf", "above 0 and at most 1"),
            ("epochs=0", "from 1 to 1000000"),
            ("epochs=99999999999999999999", "no setting"),
            ("networks=0", "from 1 to 1000"),
            ("rotations=100000000000", "from 0 to 1000"),
            ("rotations=-1", "no setting"),
            ("hidden", "no setting"),
        ] {
            let words = format!("path-gru:hidden=4,{setting}");
            let told = method_of_words(&words, &methods).err().map(|error| error.to_string());
            let told = told.unwrap_or_default();
            assert!(told.contains(&format!("`{setting}`")) && told.contains(expected), "{setting}: {told}");
        }
        assert!(method_of_words("path-gru:rate=0.01,epochs=1,rotations=0,networks=1", &methods).is_ok());
        let told = method_of_words("ridge:hidden=4", &methods).err().map(|error| error.to_string());
        assert!(told.unwrap_or_default().contains("has no settings"));
    }
}
