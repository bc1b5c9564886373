//! Figures of a test under way.

use granum_report::figure::palette::color;
use granum_report::figure::{Axis, Figure, Layer, Legend, Panel, Plot, literal};
use serde::Deserialize;
use serde_json::{Value, json};

use crate::answer::CallError;
use crate::page::{Arguments, Page};

/// A curve of a run: its name in the legend, and its points.
#[derive(Deserialize)]
struct Curve {
    name: String,
    points: Vec<[f64; 2]>,
}

/// A panel: what its axes show with their SI units, and a curve for each run.
#[derive(Deserialize)]
struct Shown {
    x: String,
    y: String,
    #[serde(default)]
    x_unit: String,
    #[serde(default)]
    y_unit: String,
    curves: Vec<Curve>,
}

/// A figure of `panels`, two in a row.
pub(super) fn curves(_: &mut Page, arguments: &Arguments) -> Result<Value, CallError> {
    let shown: Vec<Shown> = Vec::deserialize(arguments.value("panels"))
        .map_err(|error| CallError::Message(format!("these are no panels of a figure: {error}")))?;
    let panels = shown.iter().map(|panel| {
        let axis = |name: &str, unit: &str| Axis::new(&literal(name)).unit(unit);
        let plot = Plot::new(axis(&panel.x, &panel.x_unit), axis(&panel.y, &panel.y_unit));
        let lines = panel.curves.iter().enumerate().map(|(number, curve)| {
            Layer::line(curve.points.clone(), color(number)).named(&literal(&curve.name))
        });
        Panel::plot(plot.with_all(lines))
    });
    let description =
        format!("Curves of {}", shown.iter().map(|panel| panel.y.as_str()).collect::<Vec<_>>().join(", "));
    let figure = Figure::new(&description, 2, panels.collect()).legend(Legend::Above);
    Ok(json!({ "figure": figure.to_svg() }))
}
