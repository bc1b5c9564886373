//! Why an addition, as a contact law, a path or a sensor, cannot be registered: one error for every registry.

use crate::names::is_word;

/// An addition that a registry refuses: a contact law, a named path, a sensor, a format, an engine, a method of surrogates or a scheduler.
///
/// ```
/// use granum_core::RegistrationError;
///
/// let error = RegistrationError::check_name("engine", "granum", ["granum", "lammps"]).unwrap_err();
/// assert_eq!(error, RegistrationError::name_taken("engine", "granum"));
/// assert_eq!(
///     error.to_string(),
///     "the engine \"granum\" cannot be registered: there is already another of this name; give it another name"
/// );
/// ```
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RegistrationError {
    /// Its name is taken, or files and command lines cannot have it: it needs another name.
    #[error("the {what} {name:?} cannot be registered: {reason}; give it another name")]
    Name {
        /// What it is, as "engine".
        what: &'static str,
        /// Its name.
        name: String,
        /// What is wrong with its name.
        reason: &'static str,
    },
    /// The name of a part of it, as of a parameter or of a column, is taken, or has a form that it cannot have: the part needs
    /// another name.
    #[error(
        "the {what} {name:?} cannot be registered: its {part} {key:?} {reason}; give the {part} another name"
    )]
    Key {
        /// What it is, as "sensor".
        what: &'static str,
        /// Its name.
        name: String,
        /// What the part is, as "parameter", "energy channel", "column", "histogram" or "extension".
        part: &'static str,
        /// The name of the part.
        key: String,
        /// What is wrong with the name of the part.
        reason: &'static str,
    },
    /// What it declares contradicts itself or has no room: the declaration has to be mended.
    #[error("the {what} {name:?} cannot be registered: {reason}")]
    Declaration {
        /// What it is, as "path".
        what: &'static str,
        /// Its name.
        name: String,
        /// What is wrong, and what would be right.
        reason: String,
    },
}

impl RegistrationError {
    /// There is already another of this name.
    pub fn name_taken(what: &'static str, name: &str) -> RegistrationError {
        RegistrationError::Name { what, name: name.into(), reason: "there is already another of this name" }
    }

    /// The name of a part is in use with another meaning.
    pub fn key_taken(
        what: &'static str,
        name: &str,
        part: &'static str,
        key: impl Into<String>,
    ) -> RegistrationError {
        let reason = "is in use with another meaning";
        RegistrationError::Key { what, name: name.into(), part, key: key.into(), reason }
    }

    /// Refuses the name of an addition that is no [word](is_word), or that one of the known names is equal to.
    ///
    /// # Errors
    /// [`RegistrationError::Name`].
    pub fn check_name<'n>(
        what: &'static str,
        name: &str,
        known: impl IntoIterator<Item = &'n str>,
    ) -> Result<(), RegistrationError> {
        if !is_word(name) {
            let reason = "its name is not a word of letters, digits, hyphens and underscores";
            return Err(RegistrationError::Name { what, name: name.into(), reason });
        }
        match known.into_iter().any(|known| known == name) {
            true => Err(RegistrationError::name_taken(what, name)),
            false => Ok(()),
        }
    }

    /// Refuses the name of a part that is no [word](is_word), or that is in use with another meaning.
    ///
    /// # Errors
    /// [`RegistrationError::Key`].
    pub fn check_key(
        what: &'static str,
        name: &str,
        part: &'static str,
        key: &str,
        is_taken: bool,
    ) -> Result<(), RegistrationError> {
        if !is_word(key) {
            let reason = "is not a word of letters, digits, hyphens and underscores";
            return Err(RegistrationError::Key { what, name: name.into(), part, key: key.into(), reason });
        }
        if is_taken { Err(RegistrationError::key_taken(what, name, part, key)) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_are_taken_or_cannot_be_written_are_refused() {
        assert_eq!(RegistrationError::check_name("path", "elastic-plastic_2", ["oedometer"]), Ok(()));
        let taken = RegistrationError::check_name("path", "oedometer", ["hold", "oedometer"]);
        assert_eq!(taken, Err(RegistrationError::name_taken("path", "oedometer")));
        for name in ["", "two words", "a.b", "ö"] {
            let error = RegistrationError::check_name("path", name, []).unwrap_err();
            assert!(
                matches!(&error, RegistrationError::Name { name: found, .. } if found == name),
                "{error}"
            );
            assert!(RegistrationError::check_key("path", "mine", "parameter", name, false).is_err());
        }
    }

    #[test]
    fn the_name_of_a_part_is_named_with_what_has_it() {
        let error = RegistrationError::check_key("sensor", "mine", "column", "q", true).unwrap_err();
        assert_eq!(
            error.to_string(),
            "the sensor \"mine\" cannot be registered: its column \"q\" is in use with another meaning; give the column another name"
        );
    }
}
