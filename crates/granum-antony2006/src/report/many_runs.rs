//! Results with more training runs than in the paper: error as a function of the number of training runs.

use crate::learning_curve::{CurvePoint, PaperLearningCurve};
use granum_core::words;
use granum_learn::learning_curve::MeanError;
use maud::{Markup, html};

use granum_report::figure::palette::{GREY, color};
use granum_report::figure::{Axis, Figure, Layer, Legend, Panel, Plot, Shape, Stroke};
use granum_report::page::{Page, PageTable, paragraphs, rich};
use granum_report::symbols;

/// The section, with its figure, table and sentences.
pub fn section(page: &mut Page, curve: &PaperLearningCurve) -> Markup {
    let (figure, caption) = figure(curve);
    let figure = page.own_figure("more-runs", &caption, &figure);
    let label = page.own_table_label();
    let table = table(&label, curve).html();
    let sentences: Vec<String> = curve.interpretation().iter().map(|text| symbols::markup(text)).collect();
    html! {
        (paragraphs(&[
            "The paper trained on one run. On one path of one sample every quantity is a function of strain, and a \
             sensor has nothing to add; it could only tell how runs differ, which is learned from several runs. The \
             same networks are therefore trained on more runs and scored on further unseen runs. Whether a sensor is \
             *used* is seen when the networks are given the sensors of another unseen run at the same strain: their \
             error should then increase."
        ]))
        ul class="findings" { @for sentence in &sentences { li { (rich(sentence)) } } }
        (figure)
        (table)
    }
}

/// Names of the mappings, in order.
fn names(curve: &PaperLearningCurve) -> Vec<String> {
    let mut names: Vec<String> = curve.points.iter().map(|point| point.mapping.clone()).collect();
    names.dedup();
    names
}

fn figure(curve: &PaperLearningCurve) -> (Figure, String) {
    let panels: Vec<Panel> = names(curve).iter().map(|name| Panel::plot(plot(curve, name))).collect();
    let caption = format!(
        "Error on {} unseen runs against the number of training runs of {} grains. The band is one standard error over \
         the unseen runs. Where the circles lie below the dashed line, the sensors help; where the crosses lie above the \
         circles, they are used.",
        curve.unseen_runs, curve.grains
    );
    let figure = Figure::new("Error against number of training runs", 3.min(panels.len().max(1)), panels);
    (figure.sized(860.0, 250.0).legend(Legend::Above), caption)
}

fn plot(curve: &PaperLearningCurve, name: &str) -> Plot {
    let line = |value: &dyn Fn(&CurvePoint) -> Option<MeanError>| -> Vec<[f64; 2]> {
        let points = curve.points_of(name);
        points.filter_map(|p| Some([p.training_runs as f64, 100.0 * value(p)?.mean])).collect()
    };
    let band: Vec<[f64; 3]> = curve
        .points_of(name)
        .map(|p| {
            let MeanError { mean, standard_error, .. } = p.network;
            [p.training_runs as f64, 100.0 * (mean - standard_error), 100.0 * (mean + standard_error)]
        })
        .collect();
    let network = line(&|p| Some(p.network));
    let other = line(&|p| p.other_sensors);
    let formula = curve.points_of(name).next().map_or(String::new(), |point| symbols::markup(&point.formula));
    let x = Axis::new("Training runs").logarithmic();
    let y = Axis::new(&format!("{formula}, error (%)"));
    Plot::new(x, y)
        .with(Layer::band(band, color(1)))
        .with(
            Layer::stroked(line(&|p| Some(p.strain_only)), Stroke::new(GREY, 1.6).dashed(&[5.0, 3.0]))
                .named("strain only"),
        )
        .with(Layer::line(line(&|p| Some(p.ridge)), color(2)).named("ridge regression"))
        .with(Layer::dots(other, Shape::Cross, 3.6, color(3)).named("another run\u{2019}s sensors"))
        .with(Layer::line(network.clone(), color(1)).named("networks"))
        .with(Layer::dots(network, Shape::Circle, 3.6, color(1)).named("networks"))
}

fn table(label: &str, curve: &PaperLearningCurve) -> PageTable {
    let columns = [
        "Mapping",
        "Training runs",
        "Networks",
        "Strain only",
        "Ridge",
        "Another run\u{2019}s sensors",
        "Reduction by sensors",
    ];
    let caption = format!(
        "Relative RMSE on {} unseen runs of {} grains, with the standard error over these runs.",
        curve.unseen_runs, curve.grains
    );
    let mut table = PageTable { words: 1, ..PageTable::new(label, &caption, &columns) };
    let of = |estimate: MeanError| {
        format!("{:.2} \u{b1} {:.2} %", 100.0 * estimate.mean, 100.0 * estimate.standard_error)
    };
    for point in &curve.points {
        let mark = if point.helps() { "" } else { " (within scatter)" };
        table.row(vec![
            symbols::markup(&point.formula),
            point.training_runs.to_string(),
            of(point.network),
            of(point.strain_only),
            of(point.ridge),
            point.other_sensors.map_or("\u{2013}".to_owned(), of),
            format!(
                "{} \u{b1} {:.2} %{mark}",
                words::fixed(100.0 * point.help.mean, 2),
                100.0 * point.help.standard_error.unwrap_or(0.0)
            ),
        ]);
    }
    table
}
