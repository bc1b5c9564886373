//! Arrays of NumPy over data of granum, without a copy: NumPy reads them through `__array_interface__`, which needs nothing of NumPy to
//! compile and works with every version of Python. They are read-only, and keep what they show alive.

use std::sync::Arc;

use granum_core::assembly::{Body, Contact, Piece};
use granum_core::{Assembly, Table};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors;

/// What an array shows, and keeps alive.
enum Storage {
    /// A column of a table.
    Column(Arc<Table>, usize),
    Reals(Vec<f64>),
    Integers(Vec<i64>),
    Booleans(Vec<bool>),
    /// A field of the grains or the contacts of an assembly.
    Field(Arc<Assembly>, Field),
}

/// The records of an assembly.
#[derive(Clone, Copy)]
pub enum Records {
    Grains,
    Pieces,
    Contacts,
}

/// A field of the grains or the contacts of an assembly: a number or a truth value of each, or a vector.
#[derive(Clone, Copy)]
pub struct Field {
    pub of: Records,
    /// Its offset in a grain or a contact, bytes.
    pub offset: usize,
    pub kind: FieldKind,
}

#[derive(Clone, Copy, PartialEq)]
pub enum FieldKind {
    Real,
    Vector,
    Boolean,
}

impl Field {
    /// The address of the field in the first record, the distance to that of the next, and the number of records.
    fn layout(&self, assembly: &Assembly) -> (usize, usize, usize) {
        let (start, stride, count) = match self.of {
            Records::Grains => (assembly.bodies.as_ptr().addr(), size_of::<Body>(), assembly.bodies.len()),
            Records::Pieces => (assembly.pieces.as_ptr().addr(), size_of::<Piece>(), assembly.pieces.len()),
            Records::Contacts => {
                (assembly.contacts.as_ptr().addr(), size_of::<Contact>(), assembly.contacts.len())
            }
        };
        (start + if count == 0 { 0 } else { self.offset }, stride, count)
    }
}

/// Numbers of granum that NumPy shows without a copy.
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
            Storage::Field(assembly, field) => {
                let kind = if field.kind == FieldKind::Boolean { "b1" } else { "f8" };
                (field.layout(assembly).0, kind)
            }
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
        if let Storage::Field(assembly, field) = &self.storage {
            let strides = [field.layout(assembly).1, size_of::<f64>()];
            interface.set_item("strides", pyo3::types::PyTuple::new(py, &strides[..self.shape.len()])?)?;
        }
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

/// A field of the grains or the contacts of an assembly, without a copy.
pub fn field(py: Python<'_>, assembly: Arc<Assembly>, field: Field) -> PyResult<Array<'_>> {
    let (_, _, count) = field.layout(&assembly);
    let shape = if field.kind == FieldKind::Vector { vec![count, 3] } else { vec![count] };
    array(py, Storage::Field(assembly, field), shape)
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

/// The whole number below which a real number holds every whole number: 2^53, which stands for its successor as well.
const FIRST_LOST: f64 = 9_007_199_254_740_992.0;

/// The numbers of anything of which NumPy makes an array of numbers, in order of rows, with its shape.
///
/// # Errors
/// `granum.CaseError` with the name, if they are words, objects or complex numbers, or whole numbers that a real number cannot hold: NumPy
/// would turn them into others.
pub fn numbers(name: &str, values: &Bound<'_, PyAny>) -> PyResult<(Vec<f64>, Vec<usize>)> {
    let py = values.py();
    let numpy = py.import("numpy")?;
    let given = numpy.call_method1("asarray", (values,))?;
    let shape: Vec<usize> = given.getattr("shape")?.extract()?;
    let is_empty = shape.contains(&0);
    let kind: String = given.getattr("dtype")?.getattr("kind")?.extract()?;
    if !(matches!(kind.as_str(), "f" | "i" | "u" | "b") || is_empty) {
        let what = given.getattr("dtype")?.str()?;
        let message = format!("real numbers are needed, and these are of the type {what} of NumPy");
        return Err(errors::of_value(py, name, "", message));
    }
    let options = PyDict::new(py);
    options.set_item("dtype", "<f8")?;
    let array = numpy.call_method("ascontiguousarray", (&given,), Some(&options))?;
    let bytes = array.call_method0("tobytes")?;
    let bytes = bytes.cast::<pyo3::types::PyBytes>()?.as_bytes();
    let numbers: Vec<f64> =
        py.detach(|| bytes.as_chunks::<8>().0.iter().map(|number| f64::from_le_bytes(*number)).collect());
    let is_lost = |number: &&f64| number.abs() >= FIRST_LOST;
    if matches!(kind.as_str(), "i" | "u")
        && let Some(number) = numbers.iter().find(is_lost)
    {
        let message = format!(
            "the whole number near {number:e} is not below 2^53, up to where real numbers hold whole ones"
        );
        return Err(errors::of_value(py, name, number.to_string(), message));
    }
    Ok((numbers, shape))
}

/// Refuses numbers that are not finite, with the row and the column of the first, from 0 as Python counts.
///
/// # Errors
/// `granum.CaseError` with the name.
pub fn check_finite(py: Python<'_>, name: &str, numbers: &[f64], shape: &[usize]) -> PyResult<()> {
    let Some(place) = numbers.iter().position(|number| !number.is_finite()) else { return Ok(()) };
    let at = match shape {
        [_, columns] if *columns > 0 => format!("{name}[{}, {}]", place / columns, place % columns),
        _ => format!("{name}[{place}]"),
    };
    let message = format!("{at} is {}, not a finite number", numbers[place]);
    Err(errors::of_value(py, name, numbers[place].to_string(), message))
}
