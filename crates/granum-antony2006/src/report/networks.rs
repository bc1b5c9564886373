//! Figures 3-8: networks as lines, unseen DEM as points, the seed scatter as a band; and the scores.

use crate::PaperSummary;
use crate::figures::{Band, Curve, PaperFigure, PaperPanel};
use crate::mapping::PaperQuantity;

use granum_report::figure::palette::{COLORS, GREY, INK, PALE, color};
use granum_report::figure::ticks::{fixed, power_of_ten};
use granum_report::figure::{Axis, Figure, Layer, Legend, Note, Panel, Plot, SHAPES, Shape, Stroke};
use granum_report::numbers::{percent, points};
use granum_report::page::PageTable;
use granum_report::symbols::{self, STRAIN};

/// Number of the figure of a mapping in the paper: F1 is Figure 3, F6 is Figure 8.
pub fn figure_number(mapping: &str) -> Option<usize> {
    let number: usize = mapping.strip_prefix('F')?.parse().ok()?;
    (1..=6).contains(&number).then_some(number + 2)
}

/// Largest number of points that are drawn for one run; longer runs are thinned.
const MOST_POINTS: usize = 45;

/// One of Figures 3-8 with its caption.
pub fn figure(data: &PaperFigure) -> (Figure, String) {
    let formula = symbols::markup(&data.formula);
    if data.output == PaperQuantity::ForceDistribution {
        distributions(data, &formula)
    } else {
        scalar(data, &formula)
    }
}

fn pairs(curve: &Curve) -> Vec<[f64; 2]> {
    curve.x.iter().zip(&curve.y).map(|(&x, &y)| [x, y]).collect()
}

fn triples(band: &Band) -> Vec<[f64; 3]> {
    band.x.iter().zip(&band.low).zip(&band.high).map(|((&x, &low), &high)| [x, low, high]).collect()
}

/// The runs of a panel, in order.
fn runs(panel: &PaperPanel) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for curve in &panel.points {
        if !names.contains(&curve.run.as_str()) {
            names.push(&curve.run);
        }
    }
    names
}

fn thinned(points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    let stride = points.len().div_ceil(MOST_POINTS).max(1);
    points.into_iter().step_by(stride).collect()
}

/// A scalar as a function of strain, and next to it the errors of the networks: Figures 3, 5 and 8.
fn scalar(data: &PaperFigure, formula: &str) -> (Figure, String) {
    let (label, symbol) = match data.output {
        PaperQuantity::DeviatorFabric => ("Deviator fabric *φ*_{d}", "*φ*_{d}"),
        _ => ("Stress ratio *q*/*p*", "*q*/*p*"),
    };
    let mut panels = Vec::new();
    let mut stride = 1;
    for panel in &data.panels {
        panels.push(Panel::plot(values(panel, label)));
        panels.push(Panel::plot(differences(panel, symbol)));
        let lengths = panel.points.iter().map(|curve| curve.x.len().div_ceil(MOST_POINTS));
        stride = lengths.fold(stride, usize::max);
    }
    let thin =
        if stride > 1 { format!(" In (a) one DEM state in {stride} is drawn.") } else { String::new() };
    let caption = format!(
        "{formula}. (a) Networks (lines) on soft sensors of DEM runs that they were not trained on (points); the band is \
         one standard deviation between DEM runs that differ in the seed; dotted: borders of the sub-models.{thin} (b) The \
         networks minus the run whose soft sensors they were given, with the same band around zero."
    );
    (Figure::new(&format!("Networks and DEM: {}", data.formula), 2, panels).sized(720.0, 330.0), caption)
}

fn values(panel: &PaperPanel, label: &str) -> Plot {
    let mut plot = Plot::new(strain_axis(panel), Axis::new(label).including(0.0));
    for band in &panel.bands {
        plot = plot.with(Layer::band(triples(band), BAND).named("scatter of DEM with the seed"));
    }
    for (k, run) in runs(panel).into_iter().enumerate() {
        let name = format!("DEM, unseen run {}", k + 1);
        for curve in panel.points.iter().filter(|curve| curve.run == run) {
            let points = thinned(pairs(curve));
            plot = plot.with(Layer::points(points, SHAPES[k % SHAPES.len()], color(k)).named(&name));
        }
    }
    for (k, run) in runs(panel).into_iter().enumerate() {
        for curve in panel.lines.iter().filter(|curve| curve.run == run) {
            plot = plot.with(Layer::line(pairs(curve), color(k)).named(&format!("networks, run {}", k + 1)));
        }
    }
    // Strain-only networks give the same curve for every run.
    let first = panel.strain_only.first().map(|curve| curve.run.as_str());
    for curve in panel.strain_only.iter().filter(|curve| Some(curve.run.as_str()) == first) {
        let stroke = Stroke::new(INK, 1.1).dashed(&[4.0, 2.5]);
        plot = plot.with(Layer::stroked(pairs(curve), stroke).named("networks, strain only"));
    }
    plot.with_all(borders(panel))
}

fn differences(panel: &PaperPanel, symbol: &str) -> Plot {
    let label = format!("Networks minus DEM, Δ({symbol})");
    let mut plot = Plot::new(strain_axis(panel), Axis::new(&label).including(0.0));
    for band in &panel.bands {
        let around_zero =
            triples(band).into_iter().map(|[x, low, high]| [x, -0.5 * (high - low), 0.5 * (high - low)]);
        plot = plot.with(Layer::band(around_zero.collect(), BAND));
    }
    plot = plot.with(Layer::stroked(vec![[0.0, 0.0], [1e3, 0.0]], Stroke::new(GREY, 0.8)));
    plot.x = strain_axis(panel);
    for (k, run) in runs(panel).into_iter().enumerate() {
        for dem in panel.points.iter().filter(|curve| curve.run == run) {
            for line in panel.lines.iter().filter(|curve| curve.run == run) {
                let missed: Vec<[f64; 2]> = pairs(dem)
                    .into_iter()
                    .filter_map(|[x, y]| Some([x, interpolated(line, x)? - y]))
                    .collect();
                plot = plot.with(Layer::stroked(missed, Stroke::new(color(k), 1.3)));
            }
        }
    }
    plot.with_all(borders(panel))
}

/// Colour of the seed scatter.
const BAND: &str = "#5a5a5a";

fn strain_axis(panel: &PaperPanel) -> Axis {
    Axis::new(STRAIN).between(0.0, panel.strain_range[1])
}

fn borders(panel: &PaperPanel) -> Vec<Layer> {
    boundaries(panel).into_iter().map(|strain| Layer::vertical(strain, "#a8a8a8")).collect()
}

/// The value of a line at x; `None` outside its range.
fn interpolated(curve: &Curve, x: f64) -> Option<f64> {
    let k = curve.x.windows(2).position(|pair| pair[0] <= x && x <= pair[1])?;
    let (x0, x1) = (curve.x[k], curve.x[k + 1]);
    let (y0, y1) = (*curve.y.get(k)?, *curve.y.get(k + 1)?);
    Some(if x1 > x0 { y0 + (y1 - y0) * (x - x0) / (x1 - x0) } else { y0 })
}

/// Strains at the boundaries between sub-models.
fn boundaries(panel: &PaperPanel) -> Vec<f64> {
    let Some(first) = panel.lines.first() else { return Vec::new() };
    let starts = panel.lines.iter().filter(|curve| curve.run == first.run && curve.sub_model > 1);
    starts.filter_map(|curve| curve.x.first().copied()).collect()
}

/// P(f) as a function of f with one panel per sub-model: Figures 4, 6 and 7. Curves of larger strains are shifted down by
/// decades.
fn distributions(data: &PaperFigure, formula: &str) -> (Figure, String) {
    let legend = [
        Layer::band(Vec::new(), BAND).named("scatter of DEM with the seed"),
        Layer::points(Vec::new(), SHAPES[0], INK).named("DEM, unseen run 1"),
        Layer::points(Vec::new(), SHAPES[1], INK).named("DEM, unseen run 2"),
        Layer::line(Vec::new(), INK).named("networks"),
    ];
    let range = density_range(&data.panels);
    let shown = data.panels.iter().map(|panel| runs(panel).len()).max().unwrap_or(0);
    let panels: Vec<Panel> = (data.panels.iter().enumerate())
        .map(|(k, panel)| {
            let [low, high] = panel.strain_range;
            let title = format!("{} ≤ *ε*_{{d}} < {}", short(low), short(high));
            let mut plot = distribution_panel(panel, k == 0, range);
            if k == 0 {
                let kept = legend.iter().enumerate().filter(|(at, _)| *at != 1 + shown.max(1) || shown >= 2);
                plot = plot.with_all(kept.map(|(_, layer)| layer.clone()));
            }
            Panel::plot(plot).titled(&title)
        })
        .collect();
    let columns = panels.len().max(1);
    let caption = format!(
        "{formula}, one panel per sub-model. Networks (lines) on soft sensors of DEM runs that they were not trained \
         on (points), with the scatter of DEM between seeds (band), at three strains each; for clarity the curves of \
         later strains are shifted down by one and two decades."
    );
    let figure = Figure::new(&format!("Networks and DEM: {}", data.formula), columns, panels);
    (figure.sized(720.0, 400.0).legend(Legend::Above), caption)
}

/// The vertical range of all panels: that of the DEM values, including a shift of two decades. Curves of networks that
/// deviate strongly leave the frame.
fn density_range(panels: &[PaperPanel]) -> Option<[f64; 2]> {
    let values = panels.iter().flat_map(|panel| &panel.points).flat_map(|curve| &curve.y).copied();
    let shown = values.filter(|y| y.is_finite() && *y > 0.0);
    let [low, high] = shown.fold([f64::INFINITY, 0.0f64], |[low, high], y| [low.min(y), high.max(y)]);
    let decades = power_of_ten(libm::log10(low).floor() as i32) * 0.01;
    (low <= high).then(|| {
        [
            if low < 3e2 * decades { 0.3 * decades } else { decades },
            power_of_ten(libm::log10(1.05 * high).ceil() as i32),
        ]
    })
}

fn short(value: f64) -> String {
    granum_report::numbers::trimmed(value)
}

/// The strains of a panel: those of its bands, or those of its points if there is no scatter.
fn strains(panel: &PaperPanel) -> Vec<f64> {
    let of_points = || {
        let first = panel.points.first().map(|curve| curve.run.clone());
        panel.points.iter().filter(|c| Some(&c.run) == first.as_ref()).filter_map(|c| c.strain).collect()
    };
    if panel.bands.is_empty() {
        of_points()
    } else {
        panel.bands.iter().filter_map(|band| band.strain).collect()
    }
}

fn distribution_panel(panel: &PaperPanel, labelled: bool, range: Option<[f64; 2]>) -> Plot {
    let density = if labelled { "Probability density *P*(*f*), shifted" } else { "" };
    let mut plot = Plot::new(
        Axis::new("Normal force *f* = *N*/⟨*N*⟩"),
        Axis { range, ..Axis::new(density).logarithmic() },
    );
    let strains = strains(panel);
    let names = runs(panel);
    let nearest = |strain: Option<f64>| {
        let strain = strain?;
        (0..strains.len())
            .min_by(|&a, &b| (strains[a] - strain).abs().total_cmp(&(strains[b] - strain).abs()))
    };
    let shift = |k: usize| power_of_ten(-(k as i32));
    for band in &panel.bands {
        if let Some(k) = nearest(band.strain) {
            let points = triples(band).into_iter().map(|[x, low, high]| [x, low * shift(k), high * shift(k)]);
            plot = plot.with(Layer::band(points.collect(), COLORS[k % COLORS.len()]));
        }
    }
    let moved = |curve: &Curve, k: usize| pairs(curve).into_iter().map(|[x, y]| [x, y * shift(k)]).collect();
    for curve in &panel.points {
        if let Some(k) = nearest(curve.strain) {
            let run = names.iter().position(|name| *name == curve.run).unwrap_or(0);
            plot = plot.with(Layer::points(moved(curve, k), SHAPES[run % SHAPES.len()], color(k)));
        }
    }
    for curve in &panel.lines {
        if let Some(k) = nearest(curve.strain) {
            plot = plot.with(Layer::stroked(moved(curve, k), Stroke::new(color(k), 1.4)));
        }
    }
    for (k, strain) in strains.iter().enumerate() {
        let at = panel.points.iter().find(|curve| nearest(curve.strain) == Some(k));
        let Some(place) = at.and_then(first_point) else { continue };
        let text = format!("*ε*_{{d}} = {}", fixed(*strain, 3));
        // The note is placed below the curve where the curve is high and leaves room.
        let note = Note::new(&text, [place[0], place[1] * shift(k)]).color(color(k));
        plot = plot.note(note.shifted([-2.0, 42.0]));
    }
    plot
}

/// The first point at a positive force that a logarithmic axis can show.
fn first_point(curve: &Curve) -> Option<[f64; 2]> {
    pairs(curve).into_iter().find(|point| point[0] > 0.0 && point[1] > 0.0 && point[1].is_finite())
}

/// The scores as a table: the networks, the baselines, and the networks with sensor values from other runs or states.
pub fn score_table(label: &str, summary: &PaperSummary) -> PageTable {
    let caption = "Relative RMSE of the mappings on unseen DEM runs (if there are none, on held-out states): root mean \
                   square error over the root mean square of the DEM values. Strain only: networks of the same size \
                   whose only input is strain. Ridge: linear regression on the same sensors and splines over strain. \
                   Mean curve: the mean of the training runs as the prediction. Scatter: between DEM runs that differ \
                   in the seed. Another run\u{2019}s, permuted: the same networks with the sensors of another unseen \
                   run at the same strain, or with those of the run itself in another order.";
    let columns = [
        "Mapping",
        "Networks",
        "Strain only",
        "Ridge",
        "Mean curve",
        "Seed scatter",
        "Another run\u{2019}s sensors",
        "Permuted sensors",
    ];
    let mut table = PageTable::new(label, caption, &columns);
    let share = |value: Option<f64>| value.map_or("–".to_owned(), percent);
    for mapping in summary.mappings.values() {
        table.row(vec![
            symbols::markup(&mapping.formula),
            percent(mapping.relative_rmse.unseen.unwrap_or(mapping.relative_rmse.held_out)),
            percent(mapping.relative_rmse.strain_only),
            share(mapping.ridge),
            share(mapping.mean_curve),
            share(mapping.seed_scatter),
            share(mapping.with_other_sensors),
            share(mapping.with_permuted_sensors),
        ]);
    }
    table.note = "Networks that use their sensors have larger errors with those of another run.".to_owned();
    table
}

/// Table on the use of the sensors by the mappings; `None` without unseen runs.
pub fn sensor_table(label: &str, summary: &PaperSummary) -> Option<PageTable> {
    let runs = summary.mappings.values().filter_map(|mapping| mapping.help).map(|test| test.runs).max()?;
    let caption = format!(
        "Do the networks use their sensors? Use: error with another unseen run\u{2019}s sensors minus error with the run\u{2019}s \
         own. Help: error of the strain-only networks minus error of the networks. In percentage points of relative RMSE, \
         mean and standard error over {runs} unseen run{}; † above zero by a one-sided *t* test at 5{}%.",
        if runs == 1 { "" } else { "s" },
        '\u{202f}',
    );
    let columns =
        ["Mapping", "Use", "Use, against permuted", "Help", "Held-out", "*R*^{2}, unseen", "Verdict"];
    let mut table = PageTable::new(label, &caption, &columns);
    for mapping in summary.mappings.values() {
        table.row(vec![
            symbols::markup(&mapping.formula),
            points(mapping.sensor_use),
            points(mapping.use_against_permuted),
            points(mapping.help),
            percent(mapping.relative_rmse.held_out),
            mapping.r2.unseen.map_or("–".to_owned(), |r2| fixed(r2, 3)),
            mapping.verdict.to_string(),
        ]);
    }
    table.note =
        "Held-out: relative RMSE on states of the training runs that were not used in training. *R*^{2} means little \
         where a curve is flat. Fewer than three unseen runs are too few to test."
            .to_owned();
    Some(table)
}

/// The scores as a figure.
pub fn score_figure(summary: &PaperSummary) -> (Figure, String) {
    let count = summary.mappings.len();
    let row = |k: usize| (count - 1 - k) as f64;
    let names: Vec<String> = summary
        .mappings
        .iter()
        .rev()
        .map(|(name, mapping)| {
            let output = mapping.formula.split('=').next().unwrap_or("").trim();
            format!("{}: {}", symbols::mapping(name), symbols::markup(output))
        })
        .collect();
    let points = |value: &dyn Fn(&crate::summary::MappingSummary) -> Option<f64>| -> Vec<[f64; 2]> {
        let values = summary.mappings.values().enumerate();
        values.filter_map(|(k, mapping)| Some([100.0 * value(mapping)?, row(k)])).collect()
    };
    let mut plot = Plot::new(Axis::new("Relative RMSE (%)").logarithmic(), Axis::new("").named(&names));
    for k in 0..count {
        plot = plot.with(Layer::stroked(vec![[1e-9, row(k)], [1e9, row(k)]], Stroke::new(PALE, 0.8)));
    }
    let drawn = [
        Layer::dots(points(&|m| m.best_without_sensors), Shape::Bar, 8.0, INK)
            .named("mean of the training runs"),
        Layer::dots(points(&|m| Some(m.relative_rmse.strain_only)), Shape::Diamond, 4.0, "#8a8a8a")
            .named("strain only"),
        Layer::dots(points(&|m| m.ridge), Shape::Square, 3.4, "#8a8a8a").named("ridge"),
        Layer::points(points(&|m| Some(m.relative_rmse.held_out)), Shape::Circle, color(0))
            .named("held-out states"),
        Layer::points(points(&|m| m.with_other_sensors), Shape::Circle, color(1))
            .named("unseen runs, another run\u{2019}s sensors"),
        Layer::dots(points(&|m| m.relative_rmse.unseen), Shape::Circle, 4.4, color(1)).named("unseen runs"),
    ];
    // The range of the axis is that of the marks and does not depend on the lines of the rows.
    let values: Vec<f64> = drawn
        .iter()
        .flat_map(|layer| {
            let mut seen = Vec::new();
            layer.visit([true, false], |[x, _]| seen.extend(x));
            seen
        })
        .collect();
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(0.0, f64::max);
    let range = Axis::new("").logarithmic().resolve((low <= high).then_some([low, high]));
    plot.x = plot.x.between(range.low, range.high);
    let plot = plot.with_all(drawn);
    let caption = "Errors of the networks. The bar is the error if an unseen run is predicted by the mean of *n* \
                   training runs: the seed scatter times √(1 + 1/*n*). A network to the left of the bar may merely be \
                   a smooth curve; networks that use their soft sensors have larger errors with those of another run.";
    let figure = Figure::new("Relative errors of the mappings", 1, vec![Panel::plot(plot)]);
    (figure.sized(640.0, 60.0 + 36.0 * count.max(2) as f64).legend(Legend::Above), caption.to_owned())
}

/// Figure of the error as a function of the size of the networks, for the claim of the paper that the fabric permits smaller
/// networks.
pub fn size_figure(summary: &PaperSummary) -> Option<(Figure, String)> {
    let study = summary.size_study.as_ref()?;
    let mut panels = Vec::new();
    let has_unseen = study.curves.iter().any(|curve| curve.points.iter().any(|p| p.median_unseen.is_some()));
    for unseen in [false, true] {
        if unseen && !has_unseen {
            continue;
        }
        let error = if unseen { "Relative RMSE, unseen (%)" } else { "Relative RMSE, held-out (%)" };
        let mut plot = Plot::new(
            Axis::new("Neurons in each hidden layer").logarithmic(),
            Axis::new(error).logarithmic(),
        );
        let target = if unseen { study.unseen_target } else { Some(study.held_out_target) };
        if let Some(target) = target {
            plot = plot.with(Layer::horizontal(100.0 * target, GREY).named("target error"));
        }
        for (k, curve) in study.curves.iter().enumerate() {
            let name = symbols::mapping(&curve.mapping);
            let mut band = Vec::new();
            let mut line = Vec::new();
            for point in &curve.points {
                let (values, median) = if unseen {
                    (&point.unseen, point.median_unseen)
                } else {
                    (&point.held_out, Some(point.median_held_out))
                };
                let low = values.iter().copied().fold(f64::INFINITY, f64::min);
                let high = values.iter().copied().fold(0.0, f64::max);
                let neurons = point.neurons as f64;
                band.push([neurons, 100.0 * low, 100.0 * high]);
                line.extend(median.map(|median| [neurons, 100.0 * median]));
            }
            plot = plot
                .with(Layer::band(band, color(k)))
                .with(Layer::line(line.clone(), color(k)).named(&name))
                .with(Layer::dots(line, SHAPES[k % SHAPES.len()], 3.2, color(k)).named(&name));
        }
        panels.push(Panel::plot(plot));
    }
    let seeds =
        study.curves.iter().flat_map(|c| c.points.first()).map(|p| p.held_out.len()).max().unwrap_or(0);
    let columns = panels.len();
    let caption = format!(
        "Does the deviator fabric allow a smaller network? Error against the number of neurons without it (*F*_{{1}}) \
         and with it (*F*_{{3}}): median and range over {seeds} seeds of the weights. The dashed line is {} above the \
         lowest median of the first.",
        percent(study.tolerance)
    );
    Some((Figure::new("Error against size of the networks", columns, panels), caption))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_read_between_their_points_only() {
        let curve = Curve {
            run: String::new(),
            sub_model: 1,
            strain: None,
            x: vec![0.0, 0.1, 0.2],
            y: vec![1.0, 3.0, 2.0],
            outside: vec![false; 3],
        };
        assert_eq!(interpolated(&curve, 0.05), Some(2.0));
        assert_eq!(interpolated(&curve, 0.2), Some(2.0));
        assert_eq!(interpolated(&curve, 0.21), None);
        assert_eq!(interpolated(&curve, f64::NAN), None);
    }

    #[test]
    fn mappings_have_the_papers_numbers() {
        assert_eq!([figure_number("F1"), figure_number("F6"), figure_number("F7")], [Some(3), Some(8), None]);
        assert_eq!(figure_number("G1"), None);
    }
}
