//! Tables by column.

use std::sync::Arc;

use granum_campaign::data_set::meaning_of_column;
use granum_core::{Column, ColumnKind};
use granum_io::Case;
use granum_sensors::Sensors;
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::{PyKeyError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyCapsule, PyDict, PyList, PyMapping, PyString};

use crate::arrays;
use crate::arrow;
use crate::detached::detached;
use crate::errors;

/// The columns of a table and their units, from which it is made again.
type Parts<'py> = (Bound<'py, PyDict>, Bound<'py, PyDict>);

/// Named columns, each with its values.
type Columns<'py> = Vec<(String, Bound<'py, PyAny>)>;

/// The name of the table of the states of a test.
pub const SERIES: &str = "series";

/// A `KeyError` for a table that is not there.
pub fn no_table(what: &str, name: &str, known: &[String]) -> PyErr {
    errors::of_key(what, name, known.iter().map(String::as_str))
}

/// A table of named columns, each with its unit. A column is a read-only array of NumPy, of real numbers without a copy.
///
/// `columns` maps names to values of one length: numbers, truth values or words; it can also be a frame of pandas or polars. `units` gives
/// SI units of some of them. Whatever reads Arrow takes a table as it is, without a copy of its real numbers: `polars.DataFrame(table)`,
/// `pyarrow.table(table)`, DuckDB.
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
    /// The table itself.
    pub fn copied(&self) -> granum_core::Table {
        (*self.inner).clone()
    }

    fn array<'py>(&self, py: Python<'py>, place: usize) -> PyResult<Bound<'py, PyAny>> {
        let Some(column) = self.inner.columns().get(place) else {
            return Err(errors::internal(py, "a column beyond the table"));
        };
        match column.kind {
            ColumnKind::Integer if arrow::is_whole(column) => {
                let whole: Vec<i64> = column.values.iter().map(|value| *value as i64).collect();
                let rows = whole.len();
                arrays::integers(py, whole, vec![rows])
            }
            ColumnKind::Real | ColumnKind::Integer => arrays::column(py, self.inner.clone(), place),
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

/// The columns of a mapping, or of a frame of pandas or polars; `None` for anything else.
pub fn columns_of<'py>(columns: &Bound<'py, PyAny>) -> PyResult<Option<Columns<'py>>> {
    if let Ok(mapping) = columns.cast::<PyMapping>() {
        let items: PyResult<Vec<_>> = mapping.items()?.iter().map(|item| item.extract()).collect();
        return items.map(Some);
    }
    if !(columns.hasattr("columns")? && columns.hasattr("__getitem__")?) {
        return Ok(None);
    }
    let column = |name: PyResult<Bound<'py, PyAny>>| {
        let name = name?;
        let values = columns.get_item(&name)?;
        Ok((name.extract()?, values))
    };
    columns.getattr("columns")?.try_iter()?.map(column).collect::<PyResult<Vec<_>>>().map(Some)
}

/// A column from values of Python: words, truth values, whole numbers or real numbers.
fn column_from(name: &str, unit: String, values: &Bound<'_, PyAny>) -> PyResult<Column> {
    let py = values.py();
    let array = py.import("numpy")?.call_method1("asarray", (values,))?;
    if array.getattr("ndim")?.extract::<usize>()? != 1 {
        return Err(errors::of_value(py, name, "", "a column has one dimension"));
    }
    let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
    if matches!(kind.as_str(), "U" | "O" | "T") {
        let list = array.call_method0("tolist")?;
        let word = |(row, word): (usize, Bound<'_, PyAny>)| match word.cast::<PyString>() {
            Ok(word) => Ok(word.to_cow()?.into_owned()),
            Err(_) => {
                let kind = word.get_type().name()?;
                let message = format!("row {row} is {kind}; a column has numbers, truth values or words");
                Err(errors::of_value(py, name, "", message))
            }
        };
        let words = list.cast::<PyList>()?.iter().enumerate().map(word).collect::<PyResult<Vec<String>>>()?;
        return Ok(Column::of_words(name, words));
    }
    let kind = match kind.as_str() {
        "b" => ColumnKind::Boolean,
        "i" | "u" => ColumnKind::Integer,
        _ => ColumnKind::Real,
    };
    Ok(Column::new(name, unit, arrays::numbers(name, &array)?.0).of_kind(kind))
}

#[pymethods]
impl Table {
    #[new]
    #[pyo3(signature = (columns, units=None))]
    fn new(
        py: Python<'_>,
        columns: &Bound<'_, PyAny>,
        units: Option<&Bound<'_, PyMapping>>,
    ) -> PyResult<Table> {
        let mut made = Vec::new();
        let Some(columns) = columns_of(columns)? else {
            let kind = columns.get_type().name()?;
            return Err(PyTypeError::new_err(format!("a table is made of a dict or a frame, not of {kind}")));
        };
        for (name, values) in &columns {
            let unit = match units {
                Some(units) if units.contains(name)? => units.get_item(name)?.extract()?,
                _ => String::new(),
            };
            made.push(column_from(name, unit, values)?);
        }
        // A unit of no column is a mistake in its name.
        if let Some(units) = units {
            for name in units.keys()?.iter() {
                let name: String = name.extract()?;
                if !columns.iter().any(|(known, _)| *known == name) {
                    let message = format!("there is no column {name} that could have a unit");
                    return Err(errors::of_value(py, "units", name, message));
                }
            }
        }
        let table = granum_core::Table::new(made);
        Ok(table.map_err(|error| errors::general(py, error.to_string()))?.into())
    }

    /// Reads a table from CSV or Parquet.
    #[classmethod]
    fn read(
        _class: &Bound<'_, pyo3::types::PyType>,
        py: Python<'_>,
        path: std::path::PathBuf,
    ) -> PyResult<Table> {
        let table = detached(py, || granum_io::read_table_with_words(path, None))?;
        table.map(Table::from).map_err(|error| errors::of_file(py, &error, false))
    }

    /// Writes the table in the format of the name of the file (CSV, Parquet). With `force` an existing file is replaced.
    #[pyo3(signature = (path, *, force=false))]
    fn write(&self, py: Python<'_>, path: std::path::PathBuf, force: bool) -> PyResult<()> {
        let written = detached(py, || {
            granum_io::check_output_file(&path, force)?;
            granum_io::write_table(&path, &self.inner)
        })?;
        written.map_err(|error| errors::of_file(py, &error, false))
    }

    /// The names of the columns.
    #[getter]
    fn columns(&self) -> Vec<&str> {
        self.inner.names().collect()
    }

    /// The SI unit of each column; an empty text for a pure number.
    #[getter]
    fn units<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let units = PyDict::new(py);
        for column in self.inner.columns() {
            units.set_item(&column.name, &column.unit)?;
        }
        Ok(units)
    }

    /// The names of the columns.
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

    pub fn __getitem__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        match self.inner.names().position(|known| known == name) {
            Some(place) => self.array(py, place),
            None => match self.inner.column(name) {
                Err(error) => Err(PyKeyError::new_err(error.to_string())),
                Ok(_) => Err(PyKeyError::new_err(name.to_string())),
            },
        }
    }

    /// The columns as arrays.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for (place, name) in self.inner.names().enumerate() {
            dict.set_item(name, self.array(py, place)?)?;
        }
        Ok(dict)
    }

    /// The meaning of each column that granum knows.
    #[getter]
    fn descriptions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let found = PyDict::new(py);
        let (usual, sensors) = (Case::default(), Sensors::standard());
        for name in self.inner.names() {
            let meaning = meaning_of_column(name, &usual, &sensors);
            if !meaning.is_empty() {
                found.set_item(name, meaning)?;
            }
        }
        Ok(found)
    }

    /// A DataFrame of pandas, with the units in `attrs["units"]` and the meanings in `attrs["descriptions"]`.
    fn to_pandas<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("granum._frames")?.call_method1("to_pandas", (slf,))
    }

    /// A DataFrame of polars.
    fn to_polars<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("granum._frames")?.call_method1("to_polars", (slf,))
    }

    /// A Dataset of xarray, with units and meanings as attributes of its variables. The table of a histogram gets the dimensions `row`,
    /// of the states, and that of its bins.
    fn to_xarray<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("granum._frames")?.call_method1("to_xarray", (slf,))
    }

    fn __arrow_c_schema__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyCapsule>> {
        arrow::schema_capsule(py, &self.inner)
    }

    /// The columns have one type each, so that there is nothing to choose for who asks for another schema.
    #[pyo3(signature = (requested_schema=None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        let _ = requested_schema;
        arrow::stream(py, &self.inner)
    }

    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("granum._plots")?.call_method1("of_table", (slf,))
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
