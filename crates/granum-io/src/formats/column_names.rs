//! Names that a user gives to the columns of a file: each must be known and mean something, and what belongs together must be whole.

use std::path::Path;

use granum_core::names::nearest;

use crate::error::{Error, Result};

/// The name of a column that is passed over.
pub(super) const PASSED_OVER: &str = "-";

/// Refuses names that are not known, names that are given twice, and vectors of which a component is missing.
///
/// # Errors
/// [`Error::Content`] with the name, and the list of those that are known.
pub(super) fn check(path: &Path, given: &[String], known: &[String], vectors: &[[String; 3]]) -> Result<()> {
    let wrong = |message: String| Err(Error::content(path, format!("--columns: {message}")));
    for (k, name) in given.iter().enumerate().filter(|(_, name)| *name != PASSED_OVER) {
        if !known.contains(name) {
            let near = nearest(name, known.iter().map(String::as_str));
            let near = near.map_or(String::new(), |near| format!(" (did you mean {near}?)"));
            let known = known.join(", ");
            return wrong(format!(
                "{name:?} is not the name of a quantity{near}; known are {known}, and {PASSED_OVER} for a column that is passed over"
            ));
        }
        if given[..k].contains(name) {
            return wrong(format!(
                "{name} is given twice; write {PASSED_OVER} for a column that is passed over"
            ));
        }
    }
    for vector in vectors {
        let missing: Vec<&str> =
            vector.iter().filter(|name| !given.contains(name)).map(String::as_str).collect();
        if (1..3).contains(&missing.len()) {
            let there: Vec<&str> =
                vector.iter().filter(|name| given.contains(name)).map(String::as_str).collect();
            return wrong(format!("there is {}, but no {}", there.join(" "), missing.join(" ")));
        }
    }
    Ok(())
}

/// Names as owned text.
pub(super) fn owned<const N: usize>(names: [&str; N]) -> [String; N] {
    names.map(str::to_string)
}
