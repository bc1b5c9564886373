//! Errors of granum as exceptions, with key, value and remedy. The classes are in `granum/errors.py`.

use std::sync::Arc;

use granum_io::{Error, InputError};
use granum_learn::LearnError;
use granum_run::LaboratoryError;
use granum_sensors::SensorError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use toml::Spanned;
use toml::de::DeTable;

use crate::place::{self, Place, short};

/// What is wrong in a case or a file.
#[derive(Default)]
pub struct Mistake {
    pub message: String,
    pub key: Option<String>,
    pub value: Option<String>,
    pub remedy: Option<String>,
    /// File, line and column, where there is a file.
    pub place: Option<(String, usize, usize)>,
}

impl Mistake {
    /// A mistake in the text of a case, which was read as this document. A text that was made from Python's values has no file that a
    /// user knows.
    fn in_text(error: &InputError, document: Option<&DeTable<'_>>, made: bool) -> Mistake {
        let position = error.span.start;
        let found = document.and_then(|document| place::at(&error.source_text, document, position));
        let mut message = error.message.clone();
        let (key, value) = match found {
            Some(Place { key, value, cell }) => {
                match cell.as_slice() {
                    [row, column] => message += &format!(" (row {row}, column {column})"),
                    [row] if value.as_ref().is_some_and(|value| value.starts_with('[')) => {
                        message += &format!(" (row {row})");
                    }
                    _ => {}
                }
                (Some(key), value)
            }
            None => key_of_line(&error.source_text, position),
        };
        let remedy = error.help.clone();
        let place = (!made).then(|| (error.file.clone(), error.line, error.column));
        Mistake { message, key, value, remedy, place }
    }

    /// All mistakes in the text of a case.
    fn all_in_text(errors: &[InputError], made: bool) -> Vec<Mistake> {
        let text = errors.first().map(|error| error.source_text.clone()).unwrap_or_default();
        let document = DeTable::parse(&text).ok();
        let document = document.as_ref().map(Spanned::get_ref);
        let of = |error: &InputError| document.filter(|_| Arc::ptr_eq(&error.source_text, &text));
        errors.iter().map(|error| Mistake::in_text(error, of(error), made)).collect()
    }

    fn text(&self) -> String {
        let place = self.place.as_ref();
        let place =
            place.map_or_else(String::new, |(file, line, column)| format!("{file}:{line}:{column}: "));
        let remedy = self.remedy.as_ref().map_or_else(String::new, |remedy| format!("; {remedy}"));
        format!("{place}{}{remedy}", self.message)
    }

    fn object<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let (file, line, column) = match &self.place {
            Some((file, line, column)) => (Some(file), Some(*line), Some(*column)),
            None => (None, None, None),
        };
        let fields = PyDict::new(py);
        fields.set_item("message", &self.message)?;
        fields.set_item("key", &self.key)?;
        fields.set_item("value", &self.value)?;
        fields.set_item("remedy", &self.remedy)?;
        fields.set_item("file", file)?;
        fields.set_item("line", line)?;
        fields.set_item("column", column)?;
        py.import("granum.errors")?.getattr("Mistake")?.call((), Some(&fields))
    }
}

/// The key and the value of the line of a text that holds a position, where the text is not one of TOML: the key with the table in
/// which it is.
fn key_of_line(text: &str, position: usize) -> (Option<String>, Option<String>) {
    let Some(before) = text.get(..position) else { return (None, None) };
    let start = before.rfind('\n').map_or(0, |at| at + 1);
    let line = text[start..].lines().next().unwrap_or_default().trim();
    if line.starts_with('[') {
        return (Some(line.trim_matches(['[', ']']).trim().to_string()), None);
    }
    let Some((key, value)) = line.split_once('=') else { return (None, None) };
    let table = before[..start].lines().rev().map(str::trim).find(|line| line.starts_with('['));
    let table = table.map(|table| table.split(']').next().unwrap_or_default().trim_matches('['));
    let key = match table {
        Some(table) => format!("{}.{}", table.trim(), key.trim()),
        None => key.trim().to_string(),
    };
    (Some(key), Some(short(value.trim().trim_matches('"'))))
}

/// An exception of `granum.errors` of the given class.
fn exception(py: Python<'_>, class: &str, message: &str) -> PyErr {
    let made = py.import("granum.errors").and_then(|errors| errors.getattr(class)?.call1((message,)));
    made.map_or_else(|error| error, PyErr::from_value)
}

/// A `granum.Error` of the general kind.
pub fn general(py: Python<'_>, message: impl AsRef<str>) -> PyErr {
    exception(py, "Error", message.as_ref())
}

/// An `InternalError`: a mistake of granum itself.
pub fn internal(py: Python<'_>, message: &str) -> PyErr {
    exception(py, "InternalError", message)
}

/// A `KeyError` that names what comes nearest: for what is like a dict.
pub fn of_key<'a>(what: &str, key: &str, known: impl Iterator<Item = &'a str> + Clone) -> PyErr {
    let advice = granum_core::names::suggestion(key, known);
    pyo3::exceptions::PyKeyError::new_err(format!("{what} {key}; {advice}"))
}

/// A `RunError`.
pub fn of_running(py: Python<'_>, message: &str) -> PyErr {
    exception(py, "RunError", message)
}

/// A `CaseError` with its mistakes.
pub fn of_case(py: Python<'_>, mistakes: &[Mistake]) -> PyErr {
    let make = || -> PyResult<PyErr> {
        let message = mistakes.iter().map(Mistake::text).collect::<Vec<_>>().join("\n");
        let objects = mistakes.iter().map(|mistake| mistake.object(py)).collect::<PyResult<Vec<_>>>()?;
        let class = py.import("granum.errors")?.getattr("CaseError")?;
        Ok(PyErr::from_value(class.call1((message, PyList::new(py, objects)?))?))
    };
    make().unwrap_or_else(|error| error)
}

/// An error about a value that a user gave for a key.
pub fn of_value(py: Python<'_>, key: &str, value: impl Into<String>, message: impl AsRef<str>) -> PyErr {
    of_mistake(py, key, value.into(), format!("{key}: {}", message.as_ref()), None)
}

/// An error about a value for a key, with what would be right, where that is known and not empty.
pub fn of_mistake(
    py: Python<'_>,
    key: &str,
    value: String,
    message: String,
    remedy: Option<String>,
) -> PyErr {
    let (key, value) = (Some(key.to_string()), Some(short(&value)));
    let remedy = remedy.filter(|remedy| !remedy.is_empty());
    of_case(py, &[Mistake { message, key, value, remedy, place: None }])
}

/// An error of `granum-io`; `made` is true if its text was made from Python's values.
pub fn of_file(py: Python<'_>, error: &Error, made: bool) -> PyErr {
    match error {
        Error::Input(_) | Error::Inputs(_) => of_case(py, &Mistake::all_in_text(error.inputs(), made)),
        Error::Value { name, value, message } => {
            // What would be right follows what is wrong.
            let (wrong, remedy) = match message.split_once("; ") {
                Some((wrong, remedy)) => (wrong, Some(remedy.to_string())),
                None => (message.as_str(), None),
            };
            let message = format!("{name} = {value:?} {wrong}");
            let (key, value) = (Some(name.clone()), Some(short(value)));
            of_case(py, &[Mistake { message, key, value, remedy, place: None }])
        }
        Error::Rule(message) => of_case(py, &[Mistake { message: message.clone(), ..Mistake::default() }]),
        Error::Exists(path) => {
            let message =
                format!("{} exists already; give force=True to replace it, or another name", path.display());
            exception(py, "FileError", &message)
        }
        other => exception(py, "FileError", &other.to_string()),
    }
}

/// An error of learning.
pub fn of_learning(py: Python<'_>, error: &LearnError) -> PyErr {
    match error {
        LearnError::Files(error) => of_file(py, error, false),
        LearnError::Stopped { .. } => of_running(py, &error.to_string()),
        LearnError::SurrogateFile { .. } => exception(py, "FileError", &error.to_string()),
        other => general(py, other.to_string()),
    }
}

/// The key of a case that names sensors.
const SENSORS: &str = "recording.sensors";

/// An error of the laboratory.
pub fn of_laboratory(py: Python<'_>, error: &LaboratoryError) -> PyErr {
    match error {
        LaboratoryError::File(error) => of_file(py, error, false),
        LaboratoryError::Sensor(SensorError::Unknown { name, suggestion }) => {
            let message = format!("{SENSORS}: there is no sensor {name:?}");
            of_mistake(py, SENSORS, name.clone(), message, Some(suggestion.clone()))
        }
        LaboratoryError::Sensor(SensorError::Lacks { sensor, .. }) => {
            of_mistake(py, SENSORS, (*sensor).to_string(), error.to_string(), None)
        }
        other => of_running(py, &other.to_string()),
    }
}
