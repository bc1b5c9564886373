//! Values of Python as the text of a case file, so that a case from Python is read, checked and refused by the rules of the file.

use std::fmt::Write;

use pyo3::prelude::*;
use pyo3::types::{
    PyBool, PyByteArray, PyBytes, PyDict, PyFloat, PyInt, PyList, PyMapping, PySequence, PyString,
};

use crate::errors;
use crate::place::short;
use crate::quantity;

/// Deepest nesting of tables and lists; a case has four.
const DEEPEST: usize = 16;

/// The text of a case file with these sections. Each key has a line of its own, `section.key = value`, from which the message of a
/// mistake is made. A value of `None` leaves its key out.
pub fn text_of(sections: &Bound<'_, PyMapping>) -> PyResult<String> {
    let mut text = String::new();
    lines(sections, "", 0, &mut text)?;
    Ok(text)
}

/// The text of one value, as the flags of the program take it: the elements of a list are separated by commas.
pub fn flag_text(key: &str, value: &Bound<'_, PyAny>) -> PyResult<String> {
    let value = plain(value)?;
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(text.to_cow()?.into_owned());
    }
    let mut text = String::new();
    if !is_list(&value) {
        written(key, &value, 0, &mut text)?;
        return Ok(text);
    }
    for part in value.try_iter()? {
        let part = plain(&part?)?;
        let separator = if text.is_empty() { "" } else { "," };
        text.push_str(separator);
        if let Ok(word) = part.cast::<PyString>() {
            text.push_str(&word.to_cow()?);
        } else if is_list(&part) {
            // A list of lists has brackets, as in a file.
            text.clear();
            written(key, &value, 0, &mut text)?;
            return Ok(text);
        } else {
            written(key, &part, 0, &mut text)?;
        }
    }
    Ok(text)
}

/// True for a list, a tuple, a range and what else is a sequence, but for words and bytes.
fn is_list(value: &Bound<'_, PyAny>) -> bool {
    value.is_instance_of::<PyList>()
        || (value.cast::<PySequence>().is_ok()
            && !value.is_instance_of::<PyString>()
            && !value.is_instance_of::<PyBytes>()
            && !value.is_instance_of::<PyByteArray>())
}

fn lines(table: &Bound<'_, PyMapping>, before: &str, depth: usize, text: &mut String) -> PyResult<()> {
    for item in table.items()?.iter() {
        let (key, value): (Bound<PyAny>, Bound<PyAny>) = item.extract()?;
        let path = format!("{before}{}", key_text(before, &key)?);
        check_depth(table.py(), &path, depth)?;
        if let Ok(inner) = value.cast::<PyMapping>() {
            lines(inner, &format!("{path}."), depth + 1, text)?;
        } else if !value.is_none() {
            let _ = write!(text, "{path} = ");
            written(&path, &value, depth, text)?;
            text.push('\n');
        }
    }
    Ok(())
}

fn check_depth(py: Python<'_>, path: &str, depth: usize) -> PyResult<()> {
    if depth < DEEPEST {
        return Ok(());
    }
    let message = "tables and lists are nested deeper than those of a case";
    Err(errors::of_value(py, path, "", message))
}

/// A key, whose parts may be joined by dots.
fn key_text(before: &str, key: &Bound<'_, PyAny>) -> PyResult<String> {
    let Ok(name) = key.cast::<PyString>() else {
        let kind = key.get_type().name()?;
        let message = format!("a key of a case is a text, not {kind}");
        return Err(errors::of_value(key.py(), before.trim_end_matches('.'), key.to_string(), message));
    };
    let name = name.to_cow()?;
    let is_bare = |part: &str| {
        !part.is_empty() && part.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '-'))
    };
    Ok(if name.split('.').all(is_bare) { name.into_owned() } else { quoted(&name) })
}

/// A text of TOML between quotes.
fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for character in text.chars() {
        match character {
            '"' => quoted.push_str("\\\""),
            '\\' => quoted.push_str("\\\\"),
            c if c.is_control() => {
                let _ = write!(quoted, "\\u{:04X}", u32::from(c));
            }
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}

/// Values of NumPy, pandas and pint as values of Python itself.
fn plain<'py>(value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let mut value = value.clone();
    // A table of pandas becomes an array, an array a list; what goes on like that for ever is refused as it is.
    for _ in 0..DEEPEST {
        // First, since such a quantity has the methods below as well, whatever it holds.
        if quantity::is_of_pint(&value)? {
            return quantity::of_pint(&value);
        }
        value = if value.hasattr("to_numpy")? {
            value.call_method0("to_numpy")?
        } else if value.hasattr("tolist")? {
            value.call_method0("tolist")?
        } else {
            return Ok(value);
        };
    }
    Ok(value)
}

fn written(path: &str, value: &Bound<'_, PyAny>, depth: usize, text: &mut String) -> PyResult<()> {
    check_depth(value.py(), path, depth)?;
    let value = plain(value)?;
    if let Ok(truth) = value.cast::<PyBool>() {
        text.push_str(if truth.is_true() { "true" } else { "false" });
    } else if value.is_instance_of::<PyInt>() {
        text.push_str(&quantity::whole_text(&value)?);
    } else if let Ok(number) = value.cast::<PyFloat>() {
        text.push_str(&quantity::real_text(number.value()));
    } else if let Ok(word) = value.cast::<PyString>() {
        text.push_str(&quoted(&word.to_cow()?));
    } else if let Ok(table) = value.cast::<PyMapping>() {
        let mut parts = Vec::new();
        for item in table.items()?.iter() {
            let (key, value): (Bound<PyAny>, Bound<PyAny>) = item.extract()?;
            if !value.is_none() {
                let mut part = format!("{} = ", key_text(path, &key)?);
                written(&format!("{path}.{key}"), &value, depth + 1, &mut part)?;
                parts.push(part);
            }
        }
        let _ = write!(text, "{{ {} }}", parts.join(", "));
    } else if is_list(&value) {
        let mut parts = Vec::new();
        for (k, value) in value.try_iter()?.enumerate() {
            let mut part = String::new();
            written(&format!("{path}[{k}]"), &value?, depth + 1, &mut part)?;
            parts.push(part);
        }
        let _ = write!(text, "[{}]", parts.join(", "));
    } else if value.hasattr("__index__")? {
        text.push_str(&quantity::whole_text(&value.call_method0("__index__")?)?);
    } else {
        let kind = value.get_type().name()?;
        let message = format!(
            "a value of a case is a number, a text such as \"0.2 mm\", True or False, a list or a dict, not {kind}"
        );
        return Err(errors::of_value(value.py(), path, short(&value.repr()?.to_cow()?), message));
    }
    Ok(())
}

/// The values of a TOML document as a dict.
pub fn dict_of<'py>(py: Python<'py>, document: &toml::de::DeTable<'_>) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (key, value) in document {
        dict.set_item(key.get_ref().as_ref(), value_of(py, value.get_ref())?)?;
    }
    Ok(dict)
}

fn value_of<'py>(py: Python<'py>, value: &toml::de::DeValue<'_>) -> PyResult<Bound<'py, PyAny>> {
    use pyo3::IntoPyObjectExt;
    use toml::de::DeValue;
    match value {
        DeValue::String(text) => text.as_ref().into_bound_py_any(py),
        DeValue::Integer(number) => match i64::from_str_radix(number.as_str(), number.radix()) {
            Ok(number) => number.into_bound_py_any(py),
            Err(_) => number.to_string().into_bound_py_any(py),
        },
        DeValue::Float(number) => number.as_str().parse::<f64>().unwrap_or(f64::NAN).into_bound_py_any(py),
        DeValue::Boolean(truth) => truth.into_bound_py_any(py),
        DeValue::Datetime(moment) => moment.to_string().into_bound_py_any(py),
        DeValue::Array(values) => {
            let values =
                values.iter().map(|value| value_of(py, value.get_ref())).collect::<PyResult<Vec<_>>>()?;
            PyList::new(py, values)?.into_bound_py_any(py)
        }
        DeValue::Table(table) => Ok(dict_of(py, table)?.into_any()),
    }
}
