//! Cases as objects.

use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash, Hasher};
use std::path::PathBuf;

use granum::Registry;
use granum_campaign::data_set::meaning_of_column;
use granum_core::quantity::format_number;
use granum_core::{Column, ColumnKind};
use granum_dem::config::Recording;
use granum_io::case::{CaseParameter, ParameterValue, SetKey};
use granum_io::{Error, Reading};
use granum_sensors::Sensors;
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyMapping, PyType};
use toml::de::DeTable;

use crate::case_text;
use crate::detached::detached;
use crate::errors;
use crate::table;
use crate::values;

/// The name of a case that was made in Python, for messages.
const MADE: &str = "case";
/// Keywords and the keys of the file for which they stand.
const PLURALS: [[&str; 2]; 4] =
    [["stages", "stage"], ["materials", "material"], ["pairs", "pair"], ["bonds", "bond"]];

/// A case: all the input that determines a result. It never changes; `with_values` and `with_path` give another.
///
/// The keywords are the sections of a case file, each a dict of its keys (`granum.keys` has them with meaning, bounds and unit); `stages`,
/// `materials`, `pairs` and `bonds` are the lists of tables `[[stage]]`, `[[material]]`, `[[pair]]` and `[[bond]]`. Keys that are left out have their defaults,
/// and so has a key whose value is `None`. A value is a number in SI units, a text with a unit (`"0.2 mm"`), or a quantity of pint. Files that
/// keywords name may lie anywhere; those of `from_dict`, `from_toml` and `read` in the folder of the case or below it.
///
/// Raises `granum.CaseError` with all mistakes at once.
#[pyclass(frozen, module = "granum")]
pub struct Case {
    pub inner: granum_io::Case,
}

fn parse(py: Python<'_>, text: &str, file: &str, made: bool) -> PyResult<Case> {
    // It may read the files that it names.
    let case = detached(py, || Registry::standard().parse_case(text, file))?;
    case.map(|inner| Case { inner }).map_err(|error| errors::of_file(py, &error, made))
}

fn from_mapping(sections: &Bound<'_, PyMapping>) -> PyResult<Case> {
    parse(sections.py(), &case_text::text_of(sections)?, MADE, true)
}

impl Case {
    /// The case with other values of some keys, which are checked as the flags of the program.
    fn changed<'py>(
        &self,
        py: Python<'py>,
        pairs: impl Iterator<Item = (Bound<'py, PyAny>, Bound<'py, PyAny>)>,
    ) -> PyResult<Case> {
        let mut case = self.inner.clone();
        let mut set: Vec<(String, String)> = Vec::new();
        for (key, value) in pairs {
            let key: String = key.extract()?;
            let text = case_text::flag_text(&key, &value)?;
            case.set(&key, &text).map_err(|error| errors::of_file(py, &error, true))?;
            set.push((key, text));
        }
        let keys: Vec<SetKey> = set.iter().map(|(key, text)| SetKey { flag: key, path: key, text }).collect();
        let checked = case.check().and_then(|()| case.check_bare_numbers(&self.inner, &keys));
        checked.map_err(|error| errors::of_file(py, &error, true))?;
        Ok(Case { inner: case })
    }

    /// The case with a named path as its test.
    pub fn along<'py>(
        &self,
        py: Python<'py>,
        path: &str,
        parameters: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Case> {
        let mut given: Vec<(String, String)> = Vec::new();
        for (key, value) in parameters.into_iter().flatten() {
            let key: String = key.extract()?;
            if !value.is_none() {
                let text = case_text::flag_text(&key, &value)?;
                given.push((key, text));
            }
        }
        let pairs: Vec<(&str, &str)> =
            given.iter().map(|(key, text)| (key.as_str(), text.as_str())).collect();
        let named = |error| errors::of_file(py, &of_parameter(error), true);
        let inner = self.inner.with_path(path, &pairs).map_err(named)?;
        let paths: Vec<String> = given.iter().map(|(key, _)| format!("{FIRST_STAGE}{key}")).collect();
        let keys: Vec<SetKey> =
            pairs.iter().zip(&paths).map(|((flag, text), path)| SetKey { flag, path, text }).collect();
        let checked = inner.check().and_then(|()| inner.check_bare_numbers(&self.inner, &keys));
        checked.map_err(named)?;
        Ok(Case { inner })
    }

    /// The case with stages as its test, in place of the one that it has.
    pub fn in_stages<'py>(&self, py: Python<'py>, stages: &Bound<'py, PyAny>) -> PyResult<Case> {
        if stages.len()? == 0 {
            return Err(errors::of_value(py, "stage", "[]", "a test has at least one stage"));
        }
        let alone = PyDict::new(py);
        alone.set_item("stage", stages)?;
        let mut inner = self.inner.clone();
        inner.test = from_mapping(alone.as_mapping())?.inner.test;
        // As with a named path, the states that a test records are said by its stages.
        inner.recording = Recording::default().with(|recording| {
            recording.observations_per_state = self.inner.recording.observations_per_state;
            recording.sensors.clone_from(&self.inner.recording.sensors);
            recording.parameters.clone_from(&self.inner.recording.parameters);
        });
        inner.check().map_err(|error| errors::of_file(py, &error, true))?;
        Ok(Case { inner })
    }

    fn text(&self, py: Python<'_>) -> PyResult<String> {
        self.inner.readable_toml(None).map_err(|error| errors::of_file(py, &error, true))
    }

    fn dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let text = self.text(py)?;
        let document = DeTable::parse(&text).map_err(|error| errors::internal(py, error.message()))?;
        case_text::dict_of(py, document.get_ref())
    }
}

/// The beginning of the keys of a named path, which is the only stage of its case.
const FIRST_STAGE: &str = "stage.1.";

/// The same error with the name of the parameter instead of the key.
fn of_parameter(error: Error) -> Error {
    match error {
        Error::Value { name, value, message } => {
            let name = name.strip_prefix(FIRST_STAGE).unwrap_or(&name).to_string();
            Error::Value { name, value, message }
        }
        other => other,
    }
}

#[pymethods]
impl Case {
    #[new]
    #[pyo3(signature = (**sections))]
    fn new(py: Python<'_>, sections: Option<&Bound<'_, PyDict>>) -> PyResult<Case> {
        let renamed = PyDict::new(py);
        for (key, value) in sections.into_iter().flatten() {
            let name: String = key.extract()?;
            let name =
                PLURALS.iter().find(|[plural, _]| *plural == name).map_or(name.as_str(), |[_, name]| name);
            renamed.set_item(name, value)?;
        }
        let text = case_text::text_of(renamed.as_mapping())?;
        // Who writes a case in a program may name any file of his own: nothing comes from elsewhere.
        let reading = Reading::default().with_outside(true);
        let case = detached(py, || granum_io::Case::parse_as(&text, MADE, reading))?;
        case.map(|inner| Case { inner }).map_err(|error| errors::of_file(py, &error, true))
    }

    /// The case of a dict with the keys of a case file. Keys may be joined by dots: `{"grains.count": 2000}`.
    #[classmethod]
    fn from_dict(_class: &Bound<'_, PyType>, mapping: &Bound<'_, PyMapping>) -> PyResult<Case> {
        from_mapping(mapping)
    }

    /// The case of the text of a case file; `name` is the name of the file for messages.
    #[classmethod]
    #[pyo3(signature = (text, name="case.toml"))]
    fn from_toml(_class: &Bound<'_, PyType>, py: Python<'_>, text: &str, name: &str) -> PyResult<Case> {
        parse(py, text, name, false)
    }

    /// Reads a case file. With `allow_outside` it may name files outside its own folder (histories, sieve curves).
    #[classmethod]
    #[pyo3(signature = (path, *, allow_outside=false))]
    fn read(
        _class: &Bound<'_, PyType>,
        py: Python<'_>,
        path: PathBuf,
        allow_outside: bool,
    ) -> PyResult<Case> {
        let reading = Reading::default().with_outside(allow_outside);
        let case = detached(py, || granum_io::Case::read_as(path, reading))?;
        case.map(|inner| Case { inner }).map_err(|error| errors::of_file(py, &error, false))
    }

    /// The whole case as a case file in SI units, which is read back as the same case, bit for bit.
    fn to_toml(&self, py: Python<'_>) -> PyResult<String> {
        self.text(py)
    }

    /// The same as a dict, in SI units.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.dict(py)
    }

    /// SHA-256 of all that determines a result: the same as the program gives.
    #[getter]
    fn digest(&self) -> String {
        self.inner.digest()
    }

    /// The case with other values of some keys, by their full names: `case.with_values({"grains.count": 500})`. A parameter of the
    /// first stage is `stage.1.axial_strain`.
    fn with_values<'py>(&self, py: Python<'py>, values: &Bound<'py, PyMapping>) -> PyResult<Case> {
        let pairs = values.items()?.iter().map(|item| item.extract()).collect::<PyResult<Vec<_>>>()?;
        self.changed(py, pairs.into_iter())
    }

    /// The case with a named path as its test; `granum.paths()` has the paths with their parameters.
    #[pyo3(signature = (path, **parameters))]
    fn with_path<'py>(
        &self,
        py: Python<'py>,
        path: &str,
        parameters: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Case> {
        self.along(py, path, parameters)
    }

    /// The case with these stages, one after the other, as its test; each is a dict with the keys of a table `[[stage]]`.
    fn with_stages(&self, py: Python<'_>, stages: &Bound<'_, PyAny>) -> PyResult<Case> {
        self.in_stages(py, stages)
    }

    /// The names of all keys.
    fn keys(&self) -> Vec<String> {
        self.inner.parameters().into_iter().map(|parameter| parameter.key).collect()
    }

    fn __getitem__<'py>(&self, py: Python<'py>, key: &str) -> PyResult<Bound<'py, PyAny>> {
        let found = self.inner.parameters().into_iter().find(|parameter| parameter.key == key);
        let Some(found) = found else {
            let known = self.keys();
            return Err(errors::of_key("the case has no key", key, known.iter().map(String::as_str)));
        };
        match found.value {
            ParameterValue::Number(number) => number.into_bound_py_any(py),
            ParameterValue::Word(word) => word.into_bound_py_any(py),
            ParameterValue::List(numbers) => numbers.into_bound_py_any(py),
        }
    }

    /// Every key with its `value`, `unit` and `meaning`, and whether it has its default (`is_default`).
    fn table<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let parameters = self.inner.parameters();
        let usual = granum_io::Case::default().parameters();
        let (fields, sensors) = (&self.inner, Sensors::standard());
        let word = |value: &ParameterValue| match value {
            ParameterValue::Number(number) => format_number(*number),
            ParameterValue::Word(word) => word.clone(),
            ParameterValue::List(numbers) => {
                numbers.iter().map(|number| format_number(*number)).collect::<Vec<_>>().join(", ")
            }
        };
        let is_usual = |parameter: &CaseParameter| f64::from(u8::from(usual.contains(parameter)));
        let columns = vec![
            Column::of_words("key", parameters.iter().map(|parameter| parameter.key.as_str())),
            Column::of_words("value", parameters.iter().map(|parameter| word(&parameter.value))),
            Column::of_words("unit", parameters.iter().map(|parameter| parameter.unit.as_str())),
            Column::of_words(
                "meaning",
                parameters.iter().map(|parameter| meaning_of_column(&parameter.key, fields, &sensors)),
            ),
            Column::new("is_default", "", parameters.iter().map(is_usual).collect())
                .of_kind(ColumnKind::Boolean),
        ];
        let found = granum_core::Table::new(columns);
        table::object(py, found.map_err(|error| errors::general(py, error.to_string()))?)
    }

    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("granum._plots")?.call_method1("of_case", (slf,))
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other.cast::<Case>().is_ok_and(|other| other.get().inner == self.inner)
    }

    fn __hash__(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        self.inner.digest().hash(&mut hasher);
        hasher.finish()
    }

    fn __copy__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __deepcopy__(slf: Py<Self>, _memo: &Bound<'_, PyAny>) -> Py<Self> {
        slf
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, (String,))> {
        Ok((slf.get_type().getattr("from_toml")?, (slf.get().text(slf.py())?,)))
    }

    /// The keys that differ from the default, if the case is read again from them, and else all.
    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let all = self.dict(py)?;
        let usual = Case { inner: granum_io::Case::default() }.dict(py)?;
        let short = difference(&all, &usual)?;
        let is_same = from_mapping(short.as_mapping()).is_ok_and(|case| case.inner == self.inner);
        let shown = if is_same { short } else { all };
        let mut parts = Vec::new();
        for (key, value) in &shown {
            let key: String = key.extract()?;
            let name =
                PLURALS.iter().find(|[_, name]| *name == key).map_or(key.as_str(), |[plural, _]| plural);
            parts.push(format!("{name}={}", value.repr()?));
        }
        Ok(format!("granum.Case({})", parts.join(", ")))
    }
}

/// The entries of a dict that another does not have, or has with another value.
fn difference<'py>(all: &Bound<'py, PyDict>, usual: &Bound<'py, PyDict>) -> PyResult<Bound<'py, PyDict>> {
    let found = PyDict::new(all.py());
    for (key, value) in all {
        match usual.get_item(&key)? {
            Some(other) if other.eq(&value)? => {}
            Some(other) => match (value.cast::<PyDict>(), other.cast::<PyDict>()) {
                (Ok(inner), Ok(other)) => found.set_item(&key, difference(inner, other)?)?,
                _ => found.set_item(&key, &value)?,
            },
            None => found.set_item(&key, &value)?,
        }
    }
    Ok(found)
}

/// The case of an argument: a case, or a file, or a dict.
pub fn case_of(py: Python<'_>, value: &Bound<'_, PyAny>) -> PyResult<granum_io::Case> {
    if let Ok(case) = value.cast::<Case>() {
        return Ok(case.get().inner.clone());
    }
    if let Ok(mapping) = value.cast::<PyMapping>() {
        return Ok(from_mapping(mapping)?.inner);
    }
    let Ok(path) = value.extract::<PathBuf>() else {
        let kind = value.get_type().name()?;
        return Err(PyTypeError::new_err(format!("a case is a granum.Case, a dict or a file, not {kind}")));
    };
    let case = detached(py, || granum_io::Case::read(path))?;
    case.map_err(|error| errors::of_file(py, &error, false))
}

/// The JSON schema of a case file.
#[pyfunction]
pub fn schema(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    values::from_json(py, &granum_io::Case::schema())
}

/// A commented case file with every key.
#[pyfunction]
pub fn template() -> String {
    granum_io::Case::template()
}

/// The named paths: what each does (`help`), and its `parameters` with their meanings.
#[pyfunction]
pub fn paths(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let found = PyDict::new(py);
    for path in Registry::standard().runs.vocabulary.paths().all() {
        let parameters = PyDict::new(py);
        for parameter in path.parameters() {
            parameters.set_item(parameter.key, parameter.help)?;
        }
        let about = PyDict::new(py);
        about.set_item("help", path.help)?;
        about.set_item("parameters", parameters)?;
        found.set_item(path.name, about)?;
    }
    Ok(found)
}
