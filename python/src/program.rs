//! The command-line program.

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;

use granum::Registry;
use pyo3::prelude::*;

use crate::detached::detached;

/// Runs the program granum with a command line, whose first word is the name of the program, and returns its exit status. `starts` is the
/// file that starts it.
///
/// # Errors
/// After a panic.
#[pyfunction]
#[pyo3(name = "_program", signature = (arguments, starts=None))]
pub fn program(py: Python<'_>, arguments: Vec<OsString>, starts: Option<PathBuf>) -> PyResult<u8> {
    let code = detached(py, || granum::program::run_with(Registry::standard(), arguments, starts))?;
    // The only way from a code to its number.
    Ok((0..=u8::MAX).find(|number| ExitCode::from(*number) == code).unwrap_or(1))
}
