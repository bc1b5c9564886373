//! Quantities: numbers, texts with a unit, and quantities of pint, which granum does not import.

use granum_core::quantity::{Dimension, is_unit, parse_quantity};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString};

use crate::errors;

/// Base dimensions of pint with their units, and those of granum.
const BASE: [(&str, &str, &str); 3] =
    [("[mass]", "kilogram", "kg"), ("[length]", "meter", "m"), ("[time]", "second", "s")];

/// True for a quantity of pint, and for what is like one.
pub fn is_of_pint(value: &Bound<'_, PyAny>) -> PyResult<bool> {
    Ok(value.hasattr("magnitude")? && value.hasattr("units")? && value.hasattr("dimensionality")?)
}

/// A quantity of pint as a text with a unit, or as a list of these if it is an array. It stays in its own unit where granum knows that one,
/// so that `50 * units.kPa` is bit by bit the same as `"50 kPa"`, and is converted by pint to SI units otherwise.
pub fn of_pint<'py>(value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let compact: String = value.getattr("units")?.call_method1("__format__", ("~C",))?.extract()?;
    let unit = compact.replace("**", "^");
    if is_unit(&unit) {
        return texts(&value.getattr("magnitude")?, &unit);
    }
    match si_unit(value)? {
        Some((of_pint, unit)) => {
            let converted = value.call_method1("to", (of_pint,))?;
            texts(&converted.getattr("magnitude")?, &unit)
        }
        // granum says that it does not know the unit.
        None => texts(&value.getattr("magnitude")?, &unit),
    }
}

/// The SI unit of the dimension of a quantity, as pint and as granum write it, if the dimension is one of mechanics.
fn si_unit(value: &Bound<'_, PyAny>) -> PyResult<Option<(String, String)>> {
    let powers = value.py().get_type::<PyDict>().call1((value.getattr("dimensionality")?,))?;
    let (mut of_pint, mut of_granum) = (Vec::new(), Vec::new());
    for (name, power) in powers.cast::<PyDict>()? {
        let (name, power): (String, f64) = (name.extract()?, power.extract()?);
        let Some((_, long, short)) = BASE.iter().find(|(base, _, _)| *base == name) else { return Ok(None) };
        of_pint.push(format!("{long} ** {power}"));
        of_granum.push(format!("{short}^{power}"));
    }
    if of_pint.is_empty() {
        of_pint.push("dimensionless".into());
    }
    Ok(Some((of_pint.join(" * "), of_granum.join(" "))))
}

/// A number with a unit, or each number of an array.
fn texts<'py>(magnitude: &Bound<'py, PyAny>, unit: &str) -> PyResult<Bound<'py, PyAny>> {
    let py = magnitude.py();
    let magnitude =
        if magnitude.hasattr("tolist")? { magnitude.call_method0("tolist")? } else { magnitude.clone() };
    if let Ok(items) = magnitude.cast::<PyList>() {
        let items = items.iter().map(|item| texts(&item, unit)).collect::<PyResult<Vec<_>>>()?;
        return Ok(PyList::new(py, items)?.into_any());
    }
    let number = if magnitude.is_instance_of::<PyInt>() {
        whole_text(&magnitude)?
    } else {
        real_text(magnitude.extract()?)
    };
    Ok(PyString::new(py, format!("{number} {unit}").trim_end()).into_any())
}

/// The digits of a whole number, whatever class it has.
pub fn whole_text(number: &Bound<'_, PyAny>) -> PyResult<String> {
    number.py().get_type::<PyInt>().call_method1("__repr__", (number,))?.extract()
}

/// A number as the text that is read back to the same bits.
pub fn real_text(number: f64) -> String {
    if number.is_nan() { "nan".into() } else { format!("{number:?}") }
}

/// The value of a quantity of the given dimension in SI units.
///
/// # Errors
/// `granum.CaseError` with the key, if it has another dimension, is no number or is not finite; `TypeError` if it is no quantity at all.
pub fn in_si(key: &str, value: &Bound<'_, PyAny>, dimension: Dimension) -> PyResult<f64> {
    let py = value.py();
    let value = if is_of_pint(value)? { of_pint(value)? } else { value.clone() };
    if let Ok(text) = value.cast::<PyString>() {
        let text = text.to_cow()?;
        return parse_quantity(&text, dimension).map_err(|why| errors::of_value(py, key, &*text, &why));
    }
    let is_number =
        value.is_instance_of::<PyFloat>() || value.hasattr("__index__")? || value.hasattr("__float__")?;
    if !is_number || value.is_instance_of::<PyBool>() {
        let kind = value.get_type().name()?;
        let message = format!("{key}: a number or a text with a unit is needed, not {kind}");
        return Err(pyo3::exceptions::PyTypeError::new_err(message));
    }
    let number: f64 = value.extract()?;
    if number.is_finite() {
        return Ok(number);
    }
    Err(errors::of_value(py, key, number.to_string(), format!("{number} is not finite")))
}

/// A whole number between two bounds.
///
/// # Errors
/// `granum.CaseError` with the key, if it is out of bounds; `TypeError` if it is no whole number.
pub fn whole(key: &str, value: &Bound<'_, PyAny>, least: u64, most: u64) -> PyResult<u64> {
    let py = value.py();
    if value.is_instance_of::<PyBool>() || !value.hasattr("__index__")? {
        let kind = value.get_type().name()?;
        return Err(pyo3::exceptions::PyTypeError::new_err(format!(
            "{key}: a whole number is needed, not {kind}"
        )));
    }
    let number = value.call_method0("__index__")?;
    match number.extract::<u64>() {
        Ok(number) if (least..=most).contains(&number) => Ok(number),
        _ => {
            let text = whole_text(&number)?;
            let message = format!("{text} is not between {least} and {most}");
            Err(errors::of_value(py, key, text, message))
        }
    }
}
