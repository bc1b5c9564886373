//! The predicted curves of the tests of a family as a figure.

use super::figure::palette::{INK, color};
use super::figure::{Axis, Figure, Layer, Legend, Panel, Plot, literal};
use granum_learn::family::{FamilyModel, FamilyPrediction, InputSource, UsedInput};

use super::numbers::rounded;

/// A density that is next to nothing.
const NOTHING: f64 = 1e-6;

/// What the legend of a curve says for which there are no runs.
const EXTRAPOLATED: &str = "outside of the runs";

/// A prediction that is drawn.
pub struct Shown<'a> {
    /// The prediction.
    pub prediction: &'a FamilyPrediction,
    /// What makes it differ from the others; empty for a single one.
    pub label: String,
    /// The test that it is compared with, by column and point, and what it is.
    pub measured: Option<(&'a [Vec<f64>], String)>,
}

/// The figure: a panel for each output, a distribution in its first and its last state. What was asked and what the bands are stands above.
pub fn svg(model: &FamilyModel, shown: &[Shown]) -> String {
    let family = model.definition();
    let level = shown.first().map_or(0.0, |first| first.prediction.level);
    let band = format!("{:.0} % of the states of new samples", 100.0 * level);
    let panels = family.outputs.iter().map(|output| {
        let columns = model.columns_of(output);
        let label = capital(output.meaning);
        match columns[..] {
            [column] => {
                let axis = Axis::new(&capital(&family.coordinate.replace('_', " ")));
                let plot = Plot::new(axis, Axis::new(&label));
                let layers = shown.iter().enumerate().flat_map(|(k, one)| curve(one, column, k, &band));
                Panel::plot(plot.with_all(layers))
            }
            _ => {
                let plot = Plot::new(Axis::new("Force over its mean"), Axis::new("Probability density"));
                let layers = shown
                    .iter()
                    .enumerate()
                    .flat_map(|(k, one)| distribution(one, &columns, k, shown.len() == 1));
                Panel::plot(plot.with_all(layers))
            }
        }
    });
    let is_far = shown.iter().any(|one| one.prediction.is_extrapolated());
    let asked = heading(model, shown);
    let description = format!(
        "Curves of the family {} ({}) with bands that should contain {band}{}. {}",
        family.name,
        family.title,
        if is_far { format!("; {EXTRAPOLATED}") } else { String::new() },
        asked.join("; ")
    );
    Figure::new(&description, 2, panels.collect()).legend(Legend::Above).headed(&asked).to_svg()
}

/// What was asked, in parts: the family, the inputs that all tests have, and what the bands are.
fn heading(model: &FamilyModel, shown: &[Shown]) -> Vec<String> {
    let family = model.definition();
    let mut parts = vec![capital(family.title)];
    let Some(first) = shown.first() else { return parts };
    for (k, input) in first.prediction.inputs.iter().enumerate() {
        if shown.iter().all(|one| one.prediction.inputs[k] == *input) {
            parts.push(literal(&input_words(input)));
        }
    }
    if let Some((_, what)) = &first.measured {
        parts.push(literal(&format!("a prediction for the sample of {what}")));
    }
    parts.push(format!("bands: {:.0} % of the states of new samples", 100.0 * first.prediction.level));
    parts
}

/// `friction = 0.4`, `void ratio = 0.68 ± 0.03 (typical)` or `friction 0.1 to 0.8 (not known, integrated over)`.
fn input_words(input: &UsedInput) -> String {
    let name = input.name.trim_start_matches("sample.").replace('_', " ");
    match input.source {
        InputSource::Given => format!("{name} = {}", rounded(input.value, 4)),
        InputSource::Typical(typical) => {
            format!("{name} = {} ± {} (typical)", rounded(input.value, 3), rounded(typical.deviation, 2))
        }
        InputSource::Integrated([low, high]) => {
            format!("{name} {} to {} (not known, integrated over)", rounded(low, 3), rounded(high, 3))
        }
    }
}

/// The band and the mean of an output, and the test over them.
fn curve(one: &Shown, column: usize, number: usize, band: &str) -> Vec<Layer> {
    let (curve, xs) = (&one.prediction.curves[column], &one.prediction.points);
    let points = |values: &[f64]| -> Vec<[f64; 2]> { xs.iter().zip(values).map(|(x, y)| [*x, *y]).collect() };
    let ends = xs.iter().zip(curve.lower.iter().zip(&curve.upper));
    let area = Layer::band(ends.map(|(x, (lower, upper))| [*x, *lower, *upper]).collect(), color(number));
    let area = if number == 0 { area.named(band) } else { area };
    let line = Layer::line(points(&curve.mean), color(number)).named(&line_name(one));
    let mut layers = vec![area, line];
    if let Some((measured, what)) = &one.measured {
        layers.push(Layer::line(points(&measured[column]), INK).named(&literal(what)));
    }
    layers
}

fn line_name(one: &Shown) -> String {
    let flag = if one.prediction.is_extrapolated() { EXTRAPOLATED } else { "" };
    match (one.label.is_empty(), flag.is_empty()) {
        (true, true) => "mean".into(),
        (true, false) => format!("mean, {flag}"),
        (false, true) => literal(&one.label),
        (false, false) => format!("{} ({flag})", literal(&one.label)),
    }
}

/// A distribution in the last state, and in the first one if it is drawn alone.
fn distribution(one: &Shown, columns: &[usize], number: usize, is_alone: bool) -> Vec<Layer> {
    let prediction = one.prediction;
    let last = prediction.points.len() - 1;
    let centre = |column: usize| -> f64 {
        let name = &prediction.curves[column].column;
        name.rsplit('_').next().and_then(|centre| centre.parse().ok()).unwrap_or(f64::NAN)
    };
    let at = |point: usize, number: usize, name: &str| {
        let bin = |column: &usize| {
            let curve = &prediction.curves[*column];
            [centre(*column), curve.mean[point], curve.lower[point], curve.upper[point]]
        };
        // Forces that do not occur, such as tensile ones without adhesion, need no room.
        let bins: Vec<[f64; 4]> =
            columns.iter().map(bin).skip_while(|[_, _, _, upper]| *upper < NOTHING).collect();
        let band = bins.iter().map(|[x, _, lower, upper]| [*x, *lower, *upper]).collect();
        let line = Layer::line(bins.iter().map(|[x, mean, ..]| [*x, *mean]).collect(), color(number));
        [Layer::band(band, color(number)), if name.is_empty() { line } else { line.named(name) }]
    };
    let mut layers = Vec::new();
    if is_alone {
        layers.extend(at(0, 1, "distribution at the start"));
        layers.extend(at(last, 0, "distribution at the end"));
    } else {
        layers.extend(at(last, number, ""));
    }
    if let Some((measured, _)) = &one.measured {
        // A test under way has not come to its end.
        let at_end = |column: &usize| Some([centre(*column), *measured.get(*column)?.get(last)?]);
        let bins: Vec<[f64; 2]> = columns.iter().filter_map(at_end).collect();
        if !bins.is_empty() {
            let bins = bins.into_iter().skip_while(|[_, density]| *density < NOTHING).collect();
            layers.push(Layer::line(bins, INK));
        }
    }
    layers
}

fn capital(text: &str) -> String {
    let mut text = text.to_string();
    if let Some(first) = text.get_mut(..1) {
        first.make_ascii_uppercase();
    }
    text
}
