//! The predicted curves of a test as a figure.

use granum_learn::family::{FamilyModel, FamilyPrediction};
use granum_report::figure::palette::color;
use granum_report::figure::{Axis, Figure, Layer, Panel, Plot};

/// A density that is next to nothing.
const NOTHING: f64 = 1e-6;

/// What the legend of a curve says for which there are no runs.
const EXTRAPOLATED: &str = "outside of the runs";

/// The figure: a panel for each output, a distribution in its first and its last state.
pub fn svg(model: &FamilyModel, prediction: &FamilyPrediction) -> String {
    let family = model.definition();
    let last = prediction.points.len() - 1;
    let flag = if prediction.is_extrapolated() { EXTRAPOLATED } else { "" };
    let panels = family.outputs.iter().map(|output| {
        let columns = model.columns_of(output);
        let label = capital(output.meaning);
        let layers = |points: Vec<[f64; 4]>, number: usize, name: &str| {
            let band = points.iter().map(|[x, _, lower, upper]| [*x, *lower, *upper]).collect();
            let mean = points.iter().map(|[x, mean, ..]| [*x, *mean]).collect();
            let line = Layer::line(mean, color(number));
            let line = if name.is_empty() { line } else { line.named(name) };
            [Layer::band(band, color(number)), line]
        };
        if let [column] = columns[..] {
            let curve = &prediction.curves[column];
            let point = |k: usize| [prediction.points[k], curve.mean[k], curve.lower[k], curve.upper[k]];
            let axis = Axis::new(&capital(&family.coordinate.replace('_', " ")));
            let plot = Plot::new(axis, Axis::new(&label));
            return Panel::plot(plot.with_all(layers((0..=last).map(point).collect(), 0, flag)));
        }
        let at = |k: usize| -> Vec<[f64; 4]> {
            let bin = |column: &usize| {
                let curve = &prediction.curves[*column];
                let centre = curve.column.rsplit('_').next().and_then(|centre| centre.parse().ok());
                [centre.unwrap_or(f64::NAN), curve.mean[k], curve.lower[k], curve.upper[k]]
            };
            // Forces that do not occur, such as tensile ones without adhesion, need no room.
            columns.iter().map(bin).skip_while(|[_, _, _, upper]| *upper < NOTHING).collect()
        };
        let plot = Plot::new(Axis::new("Force over its mean"), Axis::new("Probability density"));
        Panel::plot(plot.with_all(layers(at(0), 1, "start")).with_all(layers(at(last), 0, "end")))
    });
    let description = format!(
        "Curves of the family {} ({}) with intervals that should contain {:.0} % of the states of new samples{}",
        family.name,
        family.title,
        100.0 * prediction.level,
        if flag.is_empty() { String::new() } else { format!("; {flag}") }
    );
    Figure::new(&description, 2, panels.collect()).to_svg()
}

fn capital(text: &str) -> String {
    let mut text = text.to_string();
    if let Some(first) = text.get_mut(..1) {
        first.make_ascii_uppercase();
    }
    text
}
