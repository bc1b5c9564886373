//! The section of a study's report on the error as a function of the number of training runs.

use granum_learn::learning_curve::{LearningCurve, LearningPoint, MeanError};
use maud::{Markup, html};

use super::figure::palette::{GREY, color};
use super::figure::{Axis, Figure, Layer, Panel, Plot, Shape, Stroke, literal};
use super::numbers::{percent, points};
use super::page::{Page, PageTable, paragraphs};

/// Most panels of the figure.
const MOST_PANELS: usize = 6;

/// The section, with its figure and table.
pub fn section(page: &mut Page, curve: &LearningCurve) -> Markup {
    let groups: Vec<&[LearningPoint]> =
        curve.points.chunk_by(|a, b| a.fit == b.fit && a.method == b.method).collect();
    let panels: Vec<Panel> = groups.iter().take(MOST_PANELS).map(|group| Panel::plot(plot(group))).collect();
    let caption = format!(
        "Error on {} unseen runs against the number of training runs. The band is one standard error over the unseen runs. \
         Where the circles lie below the dashed line, the inputs besides the coordinate help; where the crosses lie above the \
         circles, the surrogate uses them.",
        curve.unseen_runs
    );
    let figure =
        page.own_figure("learning-curve", &caption, &Figure::new(&caption, panels.len().clamp(1, 2), panels));
    let table = table(&page.own_table_label(), curve).html();
    html! {
        (paragraphs(&[
            "On a single path of a single sample every quantity is a function of the coordinate, and another input has nothing to \
             add; it can only tell how runs differ, which is learned from several runs. The same surrogates were therefore \
             trained on fewer of the training runs as well."
        ]))
        (figure)
        (table)
    }
}

fn plot(group: &[LearningPoint]) -> Plot {
    let at = |value: &dyn Fn(&LearningPoint) -> Option<MeanError>| -> Vec<[f64; 2]> {
        let points = group.iter().filter_map(|point| Some((point.training_runs, value(point)?.mean)));
        points.map(|(runs, mean)| [runs as f64, 100.0 * mean]).collect()
    };
    let band = group.iter().map(|point| {
        let MeanError { mean, standard_error, .. } = point.error;
        let (low, high) = (mean - standard_error, mean + standard_error);
        [point.training_runs as f64, 100.0 * low, 100.0 * high]
    });
    let title = group
        .first()
        .map_or(String::new(), |point| format!("{}, {}", literal(&point.fit), literal(&point.method)));
    let mut plot = Plot::new(Axis::new("Training runs"), Axis::new(&format!("Error of {title}")).unit("%"))
        .with(Layer::band(band.collect(), color(0)))
        .with(Layer::stroked(at(&|point| Some(point.error)), Stroke::new(color(0), 1.6)))
        .with(Layer::points(at(&|point| Some(point.error)), Shape::Circle, color(0)).named("all inputs"))
        .with(
            Layer::stroked(
                at(&|point| Some(point.coordinate_only)),
                Stroke::new(color(1), 1.4).dashed(&[5.0, 3.0]),
            )
            .named("coordinate only"),
        )
        .with(Layer::stroked(at(&|point| point.ridge), Stroke::new(GREY, 1.2)).named("ridge"));
    let other = at(&|point| point.with_other);
    if !other.is_empty() {
        plot = plot.with(Layer::points(other, Shape::Cross, color(2)).named("inputs of another run"));
    }
    plot
}

fn table(label: &str, curve: &LearningCurve) -> PageTable {
    let columns = [
        "Fit",
        "Method",
        "Runs",
        "All inputs",
        "Coordinate only",
        "Ridge",
        "Another run\u{2019}s",
        "Use",
        "Help",
    ];
    let caption = "Relative RMSE on unseen runs; use and help in percentage points.";
    let mut table = PageTable { words: 2, ..PageTable::new(label, caption, &columns) };
    let error = |error: Option<MeanError>| error.map_or("–".into(), |error| percent(error.mean));
    for point in &curve.points {
        table.row(vec![
            literal(&point.fit),
            literal(&point.method),
            point.training_runs.to_string(),
            error(Some(point.error)),
            error(Some(point.coordinate_only)),
            error(point.ridge),
            error(point.with_other),
            points(point.lost_with_other),
            points(Some(point.help)),
        ]);
    }
    table.note = "† marks a mean above zero in a one-sided paired t test at 5\u{202f}% over the runs. Errors of up to two different \
                  sets of training runs are averaged."
        .into();
    table
}
