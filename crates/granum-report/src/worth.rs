//! The report of what each soft sensor is worth: a page of its own, and the first section of the report of a study.

use granum_learn::worth::{Answer, Worth};
use maud::{Markup, html};

use super::figure::palette::color;
use super::figure::{Axis, Figure, Layer, Panel, Plot, Shape, Stroke, literal};
use super::numbers::percent;
use super::page::{Document, Page, Table, paragraphs, tiles};

/// Most lines of a figure.
const MOST_LINES: usize = 6;

/// The page of the answers alone.
pub fn report(worth: &Worth) -> Document {
    let mut page = Page::default();
    let body = section(&mut page, worth);
    page.section("worth", "What each soft sensor is worth", body);
    let subtitle = "How well unseen tests are known from strain, soft sensors, and the properties of grains and packing.";
    let head = html! { (tiles(&summary(worth))) };
    page.finish("Soft sensors", subtitle, head)
}

/// The error of the first output from strain alone, with all sensors, and from the properties.
fn summary(worth: &Worth) -> Vec<[String; 3]> {
    let output = worth.plan.outputs.first().map_or("", String::as_str);
    let shown = ["strain alone", "strain + all sensors", "properties", "properties + all sensors"];
    let most = |name: &&str| {
        let own = worth.answers.iter().filter(|own| own.output == output && own.knowledge.name == **name);
        own.max_by_key(|answer| answer.training_runs)
    };
    let tile = |answer: &Answer| {
        [
            percent(answer.error.relative),
            literal(&answer.knowledge.name),
            format!("error of {}", literal(output)),
        ]
    };
    shown.iter().filter_map(most).map(tile).collect()
}

/// The tables of each path, and a figure where there are several numbers of training runs.
pub fn section(page: &mut Page, worth: &Worth) -> Markup {
    let mut parts = Vec::new();
    for path in worth.paths() {
        let of_path = || worth.answers.iter().filter(|answer| answer.path == path);
        let runs = of_path().map(|answer| answer.training_runs).max().unwrap_or(0);
        let unseen = of_path().map(|answer| answer.error.runs).max().unwrap_or(0);
        let named = if path.is_empty() { String::new() } else { format!(" Path: {}.", literal(path)) };
        let about = format!("{runs} training runs, {unseen} unseen runs.{named}");
        let caption =
            format!("Error of what a laboratory measures, from different knowledge of a test. {about}");
        parts.push(table(&page.own_table_label(), &caption, worth, path, &worth.plan.outputs));
        let caption = format!("Error of soft sensors, from what a laboratory measures. {about}");
        parts.push(table(&page.own_table_label(), &caption, worth, path, &worth.plan.sensors));
        let panels: Vec<Panel> = worth
            .plan
            .outputs
            .iter()
            .filter(|output| worth.by_runs(path, output).0.len() > 1)
            .map(|output| Panel::plot(plot(worth, path, output)))
            .collect();
        if !panels.is_empty() {
            let caption =
                format!("Error on {unseen} unseen runs against the number of training runs.{named}");
            let file = match path {
                "" => "worth".to_string(),
                path => format!("worth-{}", path.replace(|c: char| !c.is_ascii_alphanumeric(), "-")),
            };
            let figure = Figure::new(&caption, panels.len().clamp(1, 2), panels);
            parts.push(page.own_figure(&file, &caption, &figure));
        }
    }
    html! {
        (paragraphs(&[
            "A surrogate was fitted for each knowledge that one may have of a test, and asked for runs with other parameters and seeds \
             than those from which it learned. The error is the root mean square error over the root mean square of the values, \u{b1} \
             its standard error over the unseen runs; in brackets the share of values within intervals of the stated level, and the \
             method, which was chosen on training runs alone.",
            "Where a sensor of another run, or a permuted one, is as good as the measured one, its value tells nothing that \
             strain does not. The cascade predicts the sensors from the properties, and the output from them.",
        ]))
        @for part in &parts { (part) }
        @if !worth.remarks.is_empty() { (paragraphs(&worth.remarks.iter().map(|remark| literal(remark)).collect::<Vec<_>>())) }
    }
}

fn table(label: &str, caption: &str, worth: &Worth, path: &str, outputs: &[String]) -> Markup {
    let heads: Vec<String> =
        std::iter::once("Known".to_string()).chain(outputs.iter().map(|output| literal(output))).collect();
    let mut table = Table::new(label, caption, &heads.iter().map(String::as_str).collect::<Vec<_>>());
    let cell = |answer: Option<&Answer>| {
        let Some(Answer { error, coverage, method, .. }) = answer else { return "–".to_string() };
        let held = coverage.map_or(String::new(), |share| format!("{}, ", percent(share)));
        format!("{} ± {} ({held}{})", percent(error.relative), percent(error.standard_error), literal(method))
    };
    for (name, row) in worth.table(path, outputs) {
        table.row(std::iter::once(literal(name)).chain(row.into_iter().map(cell)).collect());
    }
    table.note = format!("Level of the intervals: {}.", percent(worth.plan.level));
    table.html()
}

fn plot(worth: &Worth, path: &str, output: &str) -> Plot {
    let (_, rows) = worth.by_runs(path, output);
    let shown = [
        "strain alone",
        "strain + all sensors",
        "properties",
        "cascade: properties, sensors predicted from them",
        "properties + all sensors",
    ];
    let mut plot =
        Plot::new(Axis::new("Training runs"), Axis::new(&format!("Error of {}", literal(output))).unit("%"));
    let rows = rows.into_iter().filter(|(name, _)| shown.contains(name)).take(MOST_LINES);
    for (k, (name, answers)) in rows.enumerate() {
        let points: Vec<[f64; 2]> = answers
            .into_iter()
            .flatten()
            .map(|answer| [answer.training_runs as f64, 100.0 * answer.error.relative])
            .collect();
        let name = name.split(':').next().unwrap_or(name);
        plot = plot
            .with(Layer::stroked(points.clone(), Stroke::new(color(k), 1.4)))
            .with(Layer::points(points, Shape::Circle, color(k)).named(&literal(name)));
    }
    plot
}
