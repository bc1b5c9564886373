//! Tables by column.

use std::sync::Arc;

use granum_core::{Column, ColumnKind};
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyMapping, PyString};

use crate::arrays;
use crate::errors;

/// The columns of a table and their units, from which it is made again.
type Parts<'py> = (Bound<'py, PyDict>, Bound<'py, PyDict>);

/// A table of named columns of numbers or of words.
#[pyclass(frozen, module = "granum")]
pub struct Table {
    inner: Arc<granum_core::Table>,
}

impl From<granum_core::Table> for Table {
    fn from(table: granum_core::Table) -> Table {
        Table { inner: Arc::new(table) }
    }
}

impl Table {
    fn array<'py>(&self, py: Python<'py>, place: usize) -> PyResult<Bound<'py, PyAny>> {
        let Some(column) = self.inner.columns().get(place) else {
            return Err(errors::internal(py, "a column beyond the table"));
        };
        match column.kind {
            ColumnKind::Real => arrays::column(py, self.inner.clone(), place),
            ColumnKind::Integer => {
                let whole: Vec<i64> = column.values.iter().map(|value| *value as i64).collect();
                let rows = whole.len();
                arrays::integers(py, whole, vec![rows])
            }
            ColumnKind::Boolean => {
                arrays::booleans(py, column.values.iter().map(|value| *value != 0.0).collect())
            }
            ColumnKind::Word => {
                let words: Vec<Option<&str>> = (0..self.inner.rows()).map(|row| column.word(row)).collect();
                let options = PyDict::new(py);
                options.set_item("dtype", "object")?;
                let words = py.import("numpy")?.call_method("array", (words,), Some(&options))?;
                words.call_method1("setflags", (false,))?;
                Ok(words)
            }
        }
    }
}

/// A column from values of Python: words, truth values, whole numbers or real numbers.
fn column_from(name: &str, unit: String, values: &Bound<'_, PyAny>) -> PyResult<Column> {
    let py = values.py();
    let array = py.import("numpy")?.call_method1("asarray", (values,))?;
    if array.getattr("ndim")?.extract::<usize>()? != 1 {
        return Err(errors::of_value(py, name, "", "a column has one dimension"));
    }
    let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
    if matches!(kind.as_str(), "U" | "O") {
        let list = array.call_method0("tolist")?;
        let words =
            list.cast::<PyList>()?.iter().map(|word| Ok(word.cast::<PyString>()?.to_cow()?.into_owned()));
        let words = words.collect::<PyResult<Vec<String>>>()?;
        return Ok(Column::of_words(name, words));
    }
    let kind = match kind.as_str() {
        "b" => ColumnKind::Boolean,
        "i" | "u" => ColumnKind::Integer,
        _ => ColumnKind::Real,
    };
    Ok(Column::new(name, unit, arrays::numbers(&array)?.0).of_kind(kind))
}

#[pymethods]
impl Table {
    #[new]
    #[pyo3(signature = (columns, units=None))]
    fn new(
        py: Python<'_>,
        columns: &Bound<'_, PyMapping>,
        units: Option<&Bound<'_, PyMapping>>,
    ) -> PyResult<Table> {
        let mut made = Vec::new();
        for item in columns.items()?.iter() {
            let (name, values): (String, Bound<PyAny>) = item.extract()?;
            let unit = match units {
                Some(units) if units.contains(&name)? => units.get_item(&name)?.extract()?,
                _ => String::new(),
            };
            made.push(column_from(&name, unit, &values)?);
        }
        let table = granum_core::Table::new(made);
        Ok(table.map_err(|error| errors::general(py, error.to_string()))?.into())
    }

    #[classmethod]
    fn read(
        _class: &Bound<'_, pyo3::types::PyType>,
        py: Python<'_>,
        path: std::path::PathBuf,
    ) -> PyResult<Table> {
        let table = granum_io::read_table_with_words(path, None);
        table.map(Table::from).map_err(|error| errors::of_file(py, &error, false))
    }

    #[pyo3(signature = (path, *, force=false))]
    fn write(&self, py: Python<'_>, path: std::path::PathBuf, force: bool) -> PyResult<()> {
        let written = granum_io::check_output_file(&path, force)
            .and_then(|()| granum_io::write_table(&path, &self.inner));
        written.map_err(|error| errors::of_file(py, &error, false))
    }

    #[getter]
    fn columns(&self) -> Vec<&str> {
        self.inner.names().collect()
    }

    #[getter]
    fn units<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let units = PyDict::new(py);
        for column in self.inner.columns() {
            units.set_item(&column.name, &column.unit)?;
        }
        Ok(units)
    }

    fn keys(&self) -> Vec<&str> {
        self.columns()
    }

    fn __len__(&self) -> usize {
        self.inner.rows()
    }

    fn __contains__(&self, name: &Bound<'_, PyAny>) -> bool {
        name.extract::<String>().is_ok_and(|name| self.inner.has(&name))
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(PyList::new(py, self.columns())?.try_iter()?.into_any())
    }

    fn __getitem__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        match self.inner.names().position(|known| known == name) {
            Some(place) => self.array(py, place),
            None => match self.inner.column(name) {
                Err(error) => Err(PyKeyError::new_err(error.to_string())),
                Ok(_) => Err(PyKeyError::new_err(name.to_string())),
            },
        }
    }

    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for (place, name) in self.inner.names().enumerate() {
            dict.set_item(name, self.array(py, place)?)?;
        }
        Ok(dict)
    }

    fn to_pandas<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let frame = py.import("pandas")?.call_method1("DataFrame", (self.to_dict(py)?,))?;
        frame.getattr("attrs")?.set_item("units", self.units(py)?)?;
        Ok(frame)
    }

    fn to_polars<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        py.import("polars")?.call_method1("DataFrame", (self.to_dict(py)?,))
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other.cast::<Table>().is_ok_and(|other| other.get().inner == self.inner)
    }

    #[classattr]
    fn __hash__(py: Python<'_>) -> Py<PyAny> {
        py.None()
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Parts<'py>)> {
        let (table, py) = (slf.get(), slf.py());
        Ok((slf.get_type().into_any(), (table.to_dict(py)?, table.units(py)?)))
    }

    fn __repr__(&self) -> String {
        let names: Vec<&str> = self.inner.names().take(6).collect();
        let more = self.inner.columns().len().saturating_sub(names.len());
        let more = if more > 0 { format!(", and {more} more") } else { String::new() };
        format!("<granum.Table of {} rows: {}{more}>", self.inner.rows(), names.join(", "))
    }
}

/// A table as an object of Python.
pub fn object<'py>(py: Python<'py>, table: granum_core::Table) -> PyResult<Bound<'py, PyAny>> {
    Table::from(table).into_bound_py_any(py)
}
