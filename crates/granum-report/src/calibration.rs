//! The report of a calibration: what the tests tell of each parameter, the posterior, and its curves over those of the laboratory.

use granum_calibration::posterior::confirmation::Confirmed;
use granum_calibration::posterior::outcome::Outcome;
use granum_calibration::questions::next_run::NextRun;
use granum_calibration::questions::next_test::NextTest;
use granum_calibration::questions::telling::WhatTestsTell;
use granum_core::Table as Numbers;
use granum_core::words;
use maud::html;

use super::figure::marks::Shape;
use super::figure::palette::{GREY, INK, color};
use super::figure::{Axis, Figure, Layer, Legend, Panel, Plot, SHAPES, literal};
use super::numbers::{quantity, significant};
use super::page::{Document, Page, PageTable, paragraphs};

/// Most coordinates of a corner plot.
const MOST_COORDINATES: usize = 6;
/// Most draws that are drawn as dots.
const MOST_DOTS: usize = 400;
/// Bars of a histogram.
const BARS: usize = 24;

/// A compared curve with what the posterior predicts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CalibratedCurve {
    /// The test.
    pub test: String,
    /// The quantity, such as `deviator_stress`.
    pub quantity: String,
    /// SI unit; empty for a pure number.
    pub unit: String,
    /// Readings of the laboratory over the axial strain.
    pub measured: Vec<[f64; 2]>,
    /// Axial strain, and the ends of the interval of 90 % of predictions; empty without a surrogate.
    pub band: Vec<[f64; 3]>,
    /// Curves of simulations at draws from the posterior.
    pub simulated: Vec<Vec<[f64; 2]>>,
}

/// What a calibration found.
pub struct CalibrationReport<'a> {
    /// What it was made of, in a line.
    pub subtitle: String,
    /// How the tests were understood, a sentence for each.
    pub understood: Vec<String>,
    /// What the tests tell; not known without a surrogate.
    pub telling: Option<&'a WhatTestsTell>,
    /// What further tests would tell; not known without a surrogate.
    pub next_test: Option<&'a NextTest>,
    /// The simulation that would tell most; not known without a surrogate.
    pub next_run: Option<&'a NextRun>,
    /// The posterior.
    pub outcome: &'a Outcome,
    /// Its table.
    pub table: &'a Numbers,
    /// The curves.
    pub curves: Vec<CalibratedCurve>,
    /// The simulations at draws from the posterior.
    pub confirmed: &'a [Confirmed],
    /// What a reader must know.
    pub remarks: Vec<String>,
}

/// Total Sobol indices of each parameter: a panel for each quantity, marks for each test.
pub fn telling_figure(telling: &WhatTestsTell) -> Figure {
    let names: Vec<String> = telling.parameters.iter().map(|name| literal(&name.replace('_', " "))).collect();
    let panel = |wanted: &String| {
        let y = Axis::new("Total Sobol index").between(0.0, 1.05);
        let mut plot = Plot::new(Axis::new("").named(&names), y);
        let own = telling.curves.iter().enumerate().filter(|(_, [_, known])| known == wanted);
        let own: Vec<(usize, &String)> = own.map(|(k, [test, _])| (k, test)).collect();
        for (place, (k, test)) in own.iter().enumerate() {
            // Beside each other, so that tests do not hide each other.
            let shift = 0.5 * ((place as f64 + 0.5) / own.len() as f64 - 0.5);
            let total = telling.sensitivities[*k].total.iter().enumerate();
            for (parameter, index) in total.clone() {
                let x = parameter as f64 + shift;
                plot = plot.with(Layer::line(vec![[x, index.low.max(0.0)], [x, index.high.min(1.05)]], GREY));
            }
            let marks = total.map(|(parameter, index)| [parameter as f64 + shift, index.value]).collect();
            let layer = Layer::dots(marks, SHAPES[place % SHAPES.len()], 3.2, color(place));
            plot = plot.with(layer.named(&literal(test)));
        }
        Panel::plot(plot).titled(&literal(&wanted.replace('_', " ")))
    };
    let panels: Vec<Panel> = telling.by_quantity.iter().map(|(name, _)| panel(name)).collect();
    let description = "Total Sobol indices of the compared curves, with intervals of 90 %: the share of the variance of a curve that \
                       would remain if all other parameters were known.";
    Figure::new(description, panels.len().clamp(1, 2), panels).legend(Legend::Above)
}

/// The posterior: histograms of the coordinates, and draws of each pair.
pub fn corner_figure(outcome: &Outcome) -> Figure {
    let count = outcome.names.len().min(MOST_COORDINATES);
    let draws = outcome.spread(MOST_DOTS);
    let mut panels = Vec::new();
    for row in 0..count {
        for column in 0..count {
            let axis = |k: usize| Axis::new(&literal(&outcome.names[k].replace('_', " ")));
            if row == column {
                let plot = Plot::new(axis(column), Axis::new("Density").including(0.0));
                panels.push(Panel::plot(plot.with(Layer::line(histogram(&outcome.sorted(row)), color(0)))));
                continue;
            }
            let dots = draws.iter().map(|draw| [draw[column], draw[row]]).collect();
            let plot = Plot::new(axis(column), axis(row));
            panels.push(Panel::plot(plot.with(Layer::dots(dots, Shape::Circle, 1.2, color(0)))));
        }
    }
    let description = "Posterior: histograms on the diagonal, and draws of each pair of parameters.";
    Figure::new(description, count, panels).sized(760.0, (760.0 / count.max(1) as f64).clamp(130.0, 270.0))
}

/// The density of sorted values as steps.
fn histogram(sorted: &[f64]) -> Vec<[f64; 2]> {
    let (Some(first), Some(last)) = (sorted.first(), sorted.last()) else { return Vec::new() };
    let width = ((last - first) / BARS as f64).max(f64::MIN_POSITIVE);
    let mut counts = [0usize; BARS];
    for value in sorted {
        counts[(((value - first) / width) as usize).min(BARS - 1)] += 1;
    }
    let density = |count: usize| count as f64 / (sorted.len() as f64 * width);
    let step = |(k, count): (usize, &usize)| {
        let left = first + width * k as f64;
        [[left, density(*count)], [left + width, density(*count)]]
    };
    let mut line = vec![[*first, 0.0]];
    line.extend(counts.iter().enumerate().flat_map(step));
    line.push([*last, 0.0]);
    line
}

/// The curves: readings as marks, the interval of predictions as a band, simulations as lines.
pub fn curves_figure(curves: &[CalibratedCurve]) -> Figure {
    let panel = |curve: &CalibratedCurve| {
        let label = literal(&curve.quantity.replace('_', " "));
        let mut plot = Plot::new(Axis::new("Axial strain *ε*_{1}"), Axis::new(&label).unit(&curve.unit));
        if !curve.band.is_empty() {
            plot = plot.with(Layer::band(curve.band.clone(), color(0)).named("90 % of predictions"));
        }
        for (k, line) in curve.simulated.iter().enumerate() {
            let layer = Layer::line(line.clone(), color(1));
            plot = plot.with(if k == 0 { layer.named("simulations") } else { layer });
        }
        let every = curve.measured.len().div_ceil(40).max(1);
        let marks = curve.measured.iter().copied().step_by(every).collect();
        plot = plot.with(Layer::points(marks, SHAPES[0], INK).named("laboratory"));
        Panel::plot(plot).titled(&literal(&curve.test))
    };
    let panels: Vec<Panel> = curves.iter().map(panel).collect();
    let description = "Laboratory (marks), predictions of the posterior (band of 90 %) and simulations at draws from it (lines).";
    Figure::new(description, panels.len().clamp(1, 2), panels).legend(Legend::Above)
}

/// The report.
pub fn report(about: &CalibrationReport) -> Document {
    let mut page = Page::default();
    let escaped = |lines: &[String]| lines.iter().map(|line| literal(line)).collect::<Vec<_>>();
    page.section("tests", "Tests", paragraphs(&escaped(&about.understood)));
    if let Some(telling) = about.telling {
        let caption = "Total Sobol indices of the compared curves: the share of the variance of a curve that would remain if all other \
                       parameters were known. Lines: intervals of 90 %.";
        let figure = page.own_figure("sensitivity", caption, &telling_figure(telling));
        let warnings = escaped(&telling.warnings());
        let mut lines = escaped(&telling.lines());
        lines.extend(about.next_test.map(|next| escaped(&next.lines())).unwrap_or_default());
        page.section(
            "telling",
            "What the tests tell",
            html! {
                (paragraphs(&warnings)) (figure) (paragraphs(&lines))
            },
        );
    }
    let label = page.own_table_label();
    let mut table = PageTable::new(
        &label,
        "Posterior, in SI units.",
        &["Parameter", "Mean", "Deviation", "5 %", "Median", "95 %", "R-hat", "Effective"],
    );
    let numbers = |name: &str| about.table.values(name).unwrap_or_default();
    for (k, name) in about.outcome.names.iter().enumerate() {
        let columns =
            ["mean", "standard_deviation", "quantile_5", "median", "quantile_95", "r_hat", "effective_bulk"];
        let unit = about.table.get("unit").and_then(|units| units.word(k)).unwrap_or_default();
        let cell = |column: &&str| match numbers(column).get(k).filter(|value| value.is_finite()) {
            Some(value) if unit.is_empty() || column.starts_with(['r', 'e']) => significant(*value, 4),
            Some(value) => quantity(*value, unit),
            None => String::new(),
        };
        table.row(std::iter::once(literal(name)).chain(columns.iter().map(cell)).collect());
    }
    let caption = "Posterior: histograms on the diagonal, and draws of each pair.";
    let corner = page.own_figure("posterior", caption, &corner_figure(about.outcome));
    page.section("posterior", "Posterior", html! { (table.html()) (corner) });
    let caption = "Laboratory (marks), predictions of the posterior (band of 90 %) and simulations at draws from it (lines).";
    let curves = page.own_figure("curves", caption, &curves_figure(&about.curves));
    let label = page.own_table_label();
    let mut table = PageTable::new(
        &label,
        "Simulations at draws from the posterior: root mean square difference from the laboratory over its largest reading, that of the \
         surrogate, and the difference between both over the surrogate's standard deviation.",
        &["Test", "Quantity", "Run", "Simulation", "Surrogate", "Deviations"],
    );
    table.words = 3;
    for one in about.confirmed {
        let percent = |value: f64| words::percent(value, 1);
        table.row(vec![
            literal(&one.test),
            literal(&one.quantity.replace('_', " ")),
            literal(&one.run),
            percent(one.misfit),
            one.misfit_of_surrogate.map_or(String::new(), percent),
            one.deviations.map_or(String::new(), |deviations| format!("{deviations:.2}")),
        ]);
    }
    let next: Vec<String> = about.next_run.map(NextRun::line).into_iter().collect();
    page.section(
        "confirmation",
        "Confirmed by simulations",
        html! { (curves) (table.html()) (paragraphs(&escaped(&next))) },
    );
    page.finish("Calibration", &literal(&about.subtitle), paragraphs(&escaped(&about.remarks)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use granum_calibration::inference::prior::Prior;

    #[test]
    fn the_page_draws_the_posterior_and_its_curves() {
        let priors = [Prior::Uniform { from: 0.0, to: 1.0 }, Prior::Uniform { from: 1.0, to: 2.0 }];
        let points: Vec<Vec<f64>> =
            (0..50).map(|k| vec![f64::from(k) / 50.0, f64::from(k * 7 % 50) / 50.0]).collect();
        let names = vec!["friction".to_string(), "rolling_friction".to_string()];
        let outcome = Outcome::from_weighted(names, &priors, &points, &[0.02; 50], 1);
        let table = outcome.table(&priors, &[]).unwrap();
        let curve = CalibratedCurve {
            test: "A_1".into(),
            quantity: "deviator_stress".into(),
            unit: "Pa".into(),
            measured: vec![[0.0, 0.0], [0.1, 1e5]],
            band: vec![[0.0, 0.0, 1e3], [0.1, 9e4, 1.1e5]],
            simulated: vec![vec![[0.0, 0.0], [0.1, 9.5e4]]],
        };
        let confirmed = [Confirmed {
            test: "A_1".into(),
            quantity: "deviator_stress".into(),
            run: "abc".into(),
            misfit: 0.05,
            misfit_of_surrogate: Some(0.04),
            deviations: Some(0.5),
        }];
        let document = report(&CalibrationReport {
            subtitle: "1 test".into(),
            understood: vec!["A_1: 100 kPa".into()],
            telling: None,
            next_test: None,
            next_run: Some(&NextRun { test: "A_1".into(), values: Vec::new(), now: 0.31, then: 0.24 }),
            outcome: &outcome,
            table: &table,
            curves: vec![curve],
            confirmed: &confirmed,
            remarks: Vec::new(),
        });
        assert_eq!(document.figures.len(), 2);
        assert!(document.html.contains("rolling friction") && document.html.contains("5.0 %"));
        assert!(document.html.contains("31 % now and 24 % after it"));
        assert!(
            document.figures[0].1.matches("<circle").count() + document.figures[0].1.matches("<path").count()
                > 4
        );
    }
}
