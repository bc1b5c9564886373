//! The page that shows grains in three dimensions.

use granum_report::viewer::{Colour, GrainColour, View, page};
use pyo3::prelude::*;

use crate::assembly::Assembly;
use crate::detached::detached;

/// The quantities of grains by which a view colours them.
#[pyfunction]
pub fn view_colours() -> Vec<&'static str> {
    GrainColour::ALL.iter().map(|colour| colour.name()).collect()
}

/// The page that shows an assembly; grains are coloured by a quantity, or by values of which there is one for each.
#[pyfunction]
#[pyo3(signature = (of, *, title, colour, values, opacity, forces, chains, cracks, strongest))]
#[expect(clippy::too_many_arguments, reason = "they are the named arguments of granum.view")]
pub fn view_page(
    py: Python<'_>,
    of: &Bound<'_, Assembly>,
    title: Option<String>,
    colour: &str,
    values: Option<Vec<f64>>,
    opacity: f64,
    forces: bool,
    chains: bool,
    cracks: bool,
    strongest: i64,
) -> PyResult<String> {
    let (assembly, parts) = (of.get().inner(), of.get().known());
    let named = || GrainColour::named(colour).map(Colour::Grain);
    let view = View::default().with(|view| {
        view.colour = values.map(Colour::Values).or_else(named).unwrap_or(View::default().colour);
        (view.title, view.opacity) = (title, opacity);
        (view.forces, view.chains, view.cracks) = (forces, chains, cracks);
        view.strongest = usize::try_from(strongest).unwrap_or(0);
    });
    detached(py, || page(&assembly, parts, &view))
}
