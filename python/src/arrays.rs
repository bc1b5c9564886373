//! Arrays of NumPy over data of granum, without a copy: NumPy reads them through `__array_interface__`, which needs nothing of NumPy to
//! compile and works with every version of Python. They are read-only, and keep what they show alive.

use std::sync::Arc;

use granum_core::Table;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// What an array shows.
enum Storage {
    /// A column of a table.
    Column(Arc<Table>, usize),
    Reals(Vec<f64>),
    Integers(Vec<i64>),
    Booleans(Vec<bool>),
}

/// Numbers that never change, with their shape.
#[pyclass(frozen, module = "granum._granum")]
pub struct Values {
    storage: Storage,
    shape: Vec<usize>,
}

#[pymethods]
impl Values {
    /// The address, the shape and the type of the numbers, by which NumPy makes an array of them.
    #[getter]
    fn __array_interface__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (address, kind) = match &self.storage {
            Storage::Column(table, column) => {
                let values = table.columns().get(*column).map_or(&[][..], |column| &column.values);
                (values.as_ptr().addr(), "f8")
            }
            Storage::Reals(values) => (values.as_ptr().addr(), "f8"),
            Storage::Integers(values) => (values.as_ptr().addr(), "i8"),
            Storage::Booleans(values) => (values.as_ptr().addr(), "b1"),
        };
        let order = if kind == "b1" {
            '|'
        } else if cfg!(target_endian = "big") {
            '>'
        } else {
            '<'
        };
        let interface = PyDict::new(py);
        interface.set_item("shape", pyo3::types::PyTuple::new(py, &self.shape)?)?;
        interface.set_item("typestr", format!("{order}{kind}"))?;
        // True: read-only.
        interface.set_item("data", (address, true))?;
        interface.set_item("version", 3)?;
        Ok(interface)
    }
}

/// An array of NumPy.
pub type Array<'py> = Bound<'py, PyAny>;

fn array(py: Python<'_>, storage: Storage, shape: Vec<usize>) -> PyResult<Array<'_>> {
    let values = Bound::new(py, Values { storage, shape })?;
    py.import("numpy")?.call_method1("asarray", (values,))
}

/// Real numbers in the given shape.
pub fn reals(py: Python<'_>, values: Vec<f64>, shape: Vec<usize>) -> PyResult<Array<'_>> {
    array(py, Storage::Reals(values), shape)
}

/// Whole numbers in the given shape.
pub fn integers(py: Python<'_>, values: Vec<i64>, shape: Vec<usize>) -> PyResult<Array<'_>> {
    array(py, Storage::Integers(values), shape)
}

/// Truth values in a row.
pub fn booleans(py: Python<'_>, values: Vec<bool>) -> PyResult<Array<'_>> {
    let shape = vec![values.len()];
    array(py, Storage::Booleans(values), shape)
}

/// The numbers of a column of a table, without a copy.
pub fn column(py: Python<'_>, table: Arc<Table>, column: usize) -> PyResult<Array<'_>> {
    let rows = table.rows();
    array(py, Storage::Column(table, column), vec![rows])
}

/// The numbers of anything of which NumPy makes an array of real numbers, in order of rows, with its shape.
pub fn numbers(values: &Bound<'_, PyAny>) -> PyResult<(Vec<f64>, Vec<usize>)> {
    let numpy = values.py().import("numpy")?;
    let options = PyDict::new(values.py());
    options.set_item("dtype", "<f8")?;
    let array = numpy.call_method("ascontiguousarray", (values,), Some(&options))?;
    let shape: Vec<usize> = array.getattr("shape")?.extract()?;
    let bytes = array.call_method0("tobytes")?;
    let bytes = bytes.cast::<pyo3::types::PyBytes>()?.as_bytes();
    let values = bytes.as_chunks::<8>().0.iter().map(|number| f64::from_le_bytes(*number)).collect();
    Ok((values, shape))
}
