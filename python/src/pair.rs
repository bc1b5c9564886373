//! Two grains on a prescribed path.

use std::path::PathBuf;

use granum_core::Column;
use granum_dem::config::{NormalKind, TangentialKind};
use granum_dem::contact::PairProperties;
use granum_dem::contact::pair::{PairError, PairRow, PathRow, drive_pair_refined};
use granum_io::Case;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

use crate::case::case_of;
use crate::detached::detached;
use crate::errors;
use crate::pair_law::{Functions, PythonNormal, PythonTangential, with_functions};
use crate::table::{self, Table};

/// Tolerated change of a force when the number of steps is doubled, over the largest force of its kind: as `granum pair`.
const TOLERANCE: f64 = 1e-5;

/// The path of an argument: a table, its columns, or its file.
fn path_of(path: &Bound<'_, PyAny>) -> PyResult<granum_core::Table> {
    let py = path.py();
    if let Ok(table) = path.cast::<Table>() {
        return Ok(table.get().copied());
    }
    if let Ok(file) = path.extract::<PathBuf>() {
        let found = detached(py, || granum_io::read_table(&file))?;
        return found.map_err(|error| errors::of_file(py, &error, false));
    }
    let made = py.get_type::<Table>().call1((path,))?;
    Ok(made.cast::<Table>()?.get().copied())
}

/// A function, if one is given.
fn function(name: &str, given: Option<&Bound<'_, PyAny>>) -> PyResult<Option<Py<PyAny>>> {
    match given {
        Some(given) if !given.is_callable() => {
            let kind = given.get_type().name()?;
            Err(PyTypeError::new_err(format!(
                "{name} is a function, not {kind}; the case names laws of granum"
            )))
        }
        given => Ok(given.map(|given| given.clone().unbind())),
    }
}

/// Moves two equal grains along a path and gives the forces between them, as `granum pair`.
///
/// `path` has the columns `normal_approach` (the overlap) and `tangential_displacement`, m, or is a file with them; the answer is the same
/// table with `normal_force` (N, compression positive), `tangential_force` (N, positive where it resists an increasing displacement) and
/// `contact_radius` (m). Between rows the grains move along a straight line, in steps whose number is doubled until no force changes by more
/// than 1e-5 of the largest of its kind. Laws and grains are those of the `case`.
///
/// A law can be a function instead, for a pair alone. `normal(overlap, kept)` returns the normal force, N, or a dict with `force`, `radius` of
/// the contact area (m; by default that of Hertz) and `kept`, at most four numbers that it is given in the next step, zero for a new
/// contact. A pair touches where grains overlap or the force is not zero. `tangential(force, slip, normal_force, radius, kept)` is called
/// while the pair touches, with the two components in the plane of contact of the force on the first grain, N, and of the displacement of the
/// second grain in this step, m. It returns the two components of the new force, or a dict with `force` and `kept`, at most eight numbers.
/// Each is called once a step, with steps before it repeated as they become finer.
#[pyfunction]
#[pyo3(signature = (path, case=None, *, normal=None, tangential=None))]
pub fn pair<'py>(
    py: Python<'py>,
    path: &Bound<'py, PyAny>,
    case: Option<&Bound<'py, PyAny>>,
    normal: Option<&Bound<'py, PyAny>>,
    tangential: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let case = case.map_or_else(|| Ok(Case::default()), |case| case_of(py, case))?;
    if !case.grains.mixture.is_empty() {
        let message = "a pair is of two grains of one material; give its properties under grains.material";
        return Err(errors::of_value(py, "material", "", message));
    }
    let functions =
        Functions { normal: function("normal", normal)?, tangential: function("tangential", tangential)? };
    let mut contact = case.contact;
    if functions.normal.is_some() {
        contact.normal = NormalKind::new(&PythonNormal);
    }
    if functions.tangential.is_some() {
        contact.tangential = TangentialKind::new(&PythonTangential);
    }
    let mut table = path_of(path)?;
    let columns = table.select(["normal_approach", "tangential_displacement"]);
    let [approach, displacement] =
        columns.map_err(|error| errors::of_value(py, "path", "", error.to_string()))?;
    let row = |(normal_approach, tangential_displacement): (&f64, &f64)| PathRow {
        normal_approach: *normal_approach,
        tangential_displacement: *tangential_displacement,
    };
    let rows: Vec<PathRow> = approach.iter().zip(displacement).map(row).collect();
    let side = (&case.grains.material, 0.5 * case.grains.diameter);
    let properties = PairProperties::new(side, side, case.contact.damping);
    let refined = detached(py, || {
        with_functions(functions, || drive_pair_refined(&contact, &properties, &rows, TOLERANCE))
    })?;
    let refined = refined.map_err(|error| match error {
        PairError::NotConverged { .. } => errors::of_running(py, &error.to_string()),
        error => errors::of_value(py, "path", "", error.to_string()),
    })?;
    let column = |name: &str, unit: &str, value: fn(&PairRow) -> f64| {
        Column::new(name, unit, refined.rows.iter().map(value).collect())
    };
    for column in [
        column("normal_force", "N", |row| row.normal_force),
        column("tangential_force", "N", |row| row.tangential_force),
        column("contact_radius", "m", |row| row.contact_radius),
    ] {
        table.set(column).map_err(|error| errors::of_value(py, "path", "", error.to_string()))?;
    }
    table::object(py, table)
}
