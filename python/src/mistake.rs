//! A mistake on purpose, by which the tests see what becomes of one.

use pyo3::prelude::*;

use crate::detached::detached;
use crate::simulation::Simulation;

/// Panics where granum computes. A simulation is lost, as by a mistake that happens while it is advanced.
#[pyfunction]
#[pyo3(name = "_mistake", signature = (simulation=None))]
pub fn mistake(py: Python<'_>, simulation: Option<&Bound<'_, Simulation>>) -> PyResult<()> {
    let taken = simulation.and_then(|simulation| simulation.get().taken());
    detached(py, move || {
        let _lost = taken;
        panic!("on purpose")
    })
}
