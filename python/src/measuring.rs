//! Every sensor on arrays of anyone, on an assembly, or on a series of assemblies.

use granum_core::{Assembly, Column, Parts, Table};
use granum_sensors::Sensors;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

use crate::assembly::{self, answer};
use crate::detached::detached;
use crate::errors;
use crate::observed::{Arrays, from_arrays, warned};
use crate::table;

/// The values of every sensor for which arrays of anyone suffice, by column.
///
/// `positions` are rows of three, `radii` one a grain, `contacts` rows of the indices, from 0, of two grains, `forces` the force on the
/// first grain of each contact (without `contacts` grains that overlap touch), and `cell` three lengths of a periodic cell or the matrix whose columns are its edges. All in SI units, or
/// in a consistent system of units.
#[pyfunction]
#[pyo3(signature = (positions, radii=None, contacts=None, forces=None, cell=None))]
pub fn measure<'py>(
    py: Python<'py>,
    positions: &Bound<'py, PyAny>,
    radii: Option<&Bound<'py, PyAny>>,
    contacts: Option<&Bound<'py, PyAny>>,
    forces: Option<&Bound<'py, PyAny>>,
    cell: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    if let Some(radii) = radii {
        let found = warned(py, from_arrays(&Arrays { positions, radii, contacts, forces, cell })?)?;
        let measured = detached(py, || Sensors::standard().measure(&found.assembly, found.parts))?;
        return answer(py, &measured).map(Bound::into_any);
    }
    if contacts.is_some() || forces.is_some() || cell.is_some() {
        return Err(PyTypeError::new_err("arrays are measured with their radii; these are missing"));
    }
    if let Ok(one) = positions.cast::<assembly::Assembly>() {
        return one.call_method0("measure");
    }
    let wrong = || {
        PyTypeError::new_err(
            "arrays of positions and radii, an assembly or a list of assemblies are measured",
        )
    };
    let all: Vec<PyRef<'_, assembly::Assembly>> = positions.extract().map_err(|_| wrong())?;
    let all: Vec<_> = all.iter().map(|one| (one.inner(), one.known())).collect();
    if all.is_empty() {
        return Err(errors::of_value(py, "positions", "[]", "there is no assembly to measure"));
    }
    let measured = detached(py, || {
        let views: Vec<(&Assembly, Parts)> = all.iter().map(|(one, parts)| (&**one, *parts)).collect();
        let columns = Sensors::standard().measure_series(&views).columns.into_iter();
        let unit = |unit: &'static str| if unit == "1" { "" } else { unit };
        Table::new(
            columns.map(|(column, values)| Column::new(column.name, unit(column.unit), values)).collect(),
        )
    })?;
    table::object(py, measured.map_err(|error| errors::general(py, error.to_string()))?)
}
