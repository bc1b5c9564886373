//! Assemblies of arrays of anyone, which are joined by the rules for the files of other programs.

use granum_core::assembly::{Matrix, Vector};
use granum_io::formats::{ObservedAssembly, PairOfGrains};
use granum_io::packing::ImplausiblePlace;
use pyo3::prelude::*;

use crate::arrays;
use crate::detached::detached;
use crate::errors;

/// Arrays of the grains and the contacts of anyone.
pub struct Arrays<'a, 'py> {
    pub positions: &'a Bound<'py, PyAny>,
    pub radii: &'a Bound<'py, PyAny>,
    pub contacts: Option<&'a Bound<'py, PyAny>>,
    pub forces: Option<&'a Bound<'py, PyAny>>,
    pub cell: Option<&'a Bound<'py, PyAny>>,
}

/// Vectors from an array of rows of three.
fn vectors(name: &str, values: &Bound<'_, PyAny>) -> PyResult<Vec<Vector>> {
    let (numbers, shape) = arrays::numbers(name, values)?;
    if shape.len() != 2 || shape[1] != 3 {
        let message = format!("rows of three numbers are needed, and the shape is {shape:?}");
        return Err(errors::of_value(values.py(), name, format!("{shape:?}"), message));
    }
    arrays::check_finite(values.py(), name, &numbers, &shape)?;
    Ok(numbers.as_chunks::<3>().0.to_vec())
}

/// The assembly that arrays are of.
///
/// # Errors
/// `granum.CaseError` with the name of the array that is wrong.
pub fn from_arrays(arrays: &Arrays<'_, '_>) -> PyResult<ObservedAssembly> {
    let py = arrays.positions.py();
    let positions = vectors("positions", arrays.positions)?;
    let (radii, shape) = arrays::numbers("radii", arrays.radii)?;
    arrays::check_finite(py, "radii", &radii, &shape)?;
    if positions.is_empty() {
        return Err(errors::of_value(py, "positions", "[]", "there are no grains"));
    }
    if shape.len() != 1 || radii.len() != positions.len() {
        let message =
            format!("there are {} positions, and the radii have the shape {shape:?}", positions.len());
        return Err(errors::of_value(py, "radii", format!("{shape:?}"), message));
    }
    let grains: Vec<(Vector, f64)> = positions.into_iter().zip(radii).collect();
    let cell = arrays.cell.map(edges).transpose()?;
    let forces = arrays.forces.map(|forces| vectors("forces", forces)).transpose()?;
    let mut contacts = arrays.contacts.map(|contacts| pairs(contacts, grains.len())).transpose()?;
    if let Some(forces) = forces {
        let contacts = contacts.as_deref_mut().unwrap_or_default();
        if forces.len() != contacts.len() {
            let message = format!("there are {} forces for {} contacts", forces.len(), contacts.len());
            return Err(errors::of_value(py, "forces", forces.len().to_string(), message));
        }
        contacts.iter_mut().zip(forces).for_each(|((_, own), force)| *own = Some(force));
    }
    let made = detached(py, || ObservedAssembly::of_arrays(&grains, cell, contacts.as_deref()))?;
    made.map_err(|wrong| {
        let (key, place, value) = match wrong.at {
            ImplausiblePlace::Cell => ("cell", None, format!("{:?}", cell.unwrap_or_default())),
            ImplausiblePlace::Position(k) => ("positions", Some(k), format!("{:?}", grains[k].0)),
            ImplausiblePlace::Radius(k) => ("radii", Some(k), grains[k].1.to_string()),
            ImplausiblePlace::Contacts => ("contacts", None, String::new()),
            ImplausiblePlace::Contact(k) => {
                let places = contacts.as_ref().map(|all| format!("{:?}", all[k].0));
                ("contacts", Some(k), places.unwrap_or_default())
            }
        };
        let place = place.map_or_else(|| key.to_string(), |k| format!("{key}[{k}]"));
        errors::of_mistake(py, key, value, format!("{place}: {}", wrong.message), Some(wrong.help))
    })
}

/// The assembly, after warnings of what is doubtful in it.
pub fn warned(py: Python<'_>, observed: ObservedAssembly) -> PyResult<ObservedAssembly> {
    let class = py.import("granum.errors")?.getattr("RunWarning")?;
    for remark in observed.remarks.iter().filter(|remark| remark.doubtful) {
        let text = std::ffi::CString::new(remark.text.replace('\0', " "))?;
        PyErr::warn(py, &class, &text, 1)?;
    }
    Ok(observed)
}

/// The edge matrix of a cell: three lengths, or a matrix whose columns are the edges.
pub fn edges(cell: &Bound<'_, PyAny>) -> PyResult<Matrix> {
    let (numbers, shape) = arrays::numbers("cell", cell)?;
    arrays::check_finite(cell.py(), "cell", &numbers, &shape)?;
    match (shape.as_slice(), numbers.as_slice()) {
        ([3], [x, y, z]) => Ok([[*x, 0.0, 0.0], [0.0, *y, 0.0], [0.0, 0.0, *z]]),
        ([3, 3], [a, b, c, d, e, f, g, h, i]) => Ok([[*a, *b, *c], [*d, *e, *f], [*g, *h, *i]]),
        _ => {
            let message = "three lengths or a matrix whose columns are the edges of the cell are needed";
            Err(errors::of_value(cell.py(), "cell", format!("{shape:?}"), message))
        }
    }
}

/// Contacts of pairs of grains, which are given by their places in the arrays, from 0.
fn pairs(pairs: &Bound<'_, PyAny>, grains: usize) -> PyResult<Vec<PairOfGrains>> {
    let (numbers, shape) = arrays::numbers("contacts", pairs)?;
    let wrong = |value: String, message: String| errors::of_value(pairs.py(), "contacts", value, message);
    if shape.len() != 2 || shape[1] != 2 {
        let message = format!("rows of the indices of two grains are needed, and the shape is {shape:?}");
        return Err(wrong(format!("{shape:?}"), message));
    }
    let index = |number: f64| -> PyResult<usize> {
        if number >= 0.0 && number.fract() == 0.0 && number < grains as f64 {
            return Ok(number as usize);
        }
        let message = format!("{number} is no index of a grain; there are {grains} grains, from 0");
        Err(wrong(number.to_string(), message))
    };
    let each = numbers.as_chunks::<2>().0.iter();
    each.map(|[i, j]| Ok(([index(*i)?, index(*j)?], None))).collect()
}
