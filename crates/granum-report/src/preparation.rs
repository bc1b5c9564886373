//! The preparation of a sample: the compression curve and the approach to rest, and the report of a sample.

use maud::html;

use super::case_details::{case_details, whose_grains};
use super::data::RunReport;
use super::figure::literal;
use super::figure::palette::color;
use super::figure::{Axis, Figure, Layer, Panel, Plot};
use super::numbers::quantity;
use super::page::{Document, Page, tiles};
use super::presented::Presented;
use super::{sample, shapes, trust};

/// Names of the phases by their numbers in the table.
const PHASES: [&str; 6] = ["compaction", "relaxation", "consolidation", "", "cycles", "stages"];

/// The rows of a phase of the last trial, which gave the sample.
fn points(run: &RunReport, phase: usize, x: &str, y: &str) -> Vec<[f64; 2]> {
    let column = |name: &str| run.preparation.values(name).unwrap_or(&[]);
    let last = column("trial").iter().copied().fold(1.0, f64::max);
    (column("trial").iter().zip(column("phase")).zip(column(x).iter().zip(column(y))))
        .filter(|((trial, of), _)| **trial == last && **of == phase as f64 || phase == 2 && **of == 2.0)
        .map(|(_, (x, y))| [*x, *y])
        .collect()
}

/// Figure of the compression curve and the unbalanced force; `None` if the history of the preparation was not recorded.
pub fn figure(run: &RunReport) -> Option<(Figure, String)> {
    if run.preparation.rows() == 0 {
        return None;
    }
    let lines = |mut plot: Plot, x: &str, y: &str| {
        for (phase, name) in PHASES.iter().enumerate() {
            let points = points(run, phase, x, y);
            if !points.is_empty() {
                plot = plot.with(Layer::line(points, color(phase)).named(name));
            }
        }
        Panel::plot(plot)
    };
    let stress = Axis::new("Mean stress *p*").unit("Pa").logarithmic();
    let curve = lines(Plot::new(stress, Axis::new("Solid fraction")), "mean_stress", "solid_fraction");
    let rest = Plot::new(Axis::new("Step"), Axis::new("Unbalanced force").logarithmic());
    let panels = vec![curve, lines(rest, "step", "unbalanced_force")];
    let caption = "Preparation of the sample, last trial of the preparation friction. (a) Compression curve; (b) mean \
                   unbalanced force over the mean contact force while the sample comes to rest.";
    Some((
        Figure::new("Solid fraction against mean stress, and unbalanced force", 2, panels),
        caption.to_owned(),
    ))
}

/// Writes the report of a sample.
pub fn report(run: &RunReport) -> Document {
    let mut page = Page::default();
    if let Some((figure, caption)) = figure(run) {
        let body = page.own_figure("preparation", &caption, &figure);
        page.section("preparation", "Preparation", body);
    }
    page.section("quality", "Can it be trusted?", trust::sample_section(run));
    let label = page.own_table_label();
    let shapes = shapes::section(&mut page, run);
    let body = html! {
        (sample::own_table(&label, run).html())
        @if let Some(shapes) = shapes { (shapes) }
        (case_details(run))
    };
    page.section("case", "The sample and the case", body);
    let law = sample::law(&run.case.contact);
    let stress = quantity(run.case.preparation.mean_stress, "Pa");
    let subtitle = format!("sample · {} · {law} · *p* = {stress}", whose_grains(run));
    page.finish(&literal(&run.name), &subtitle, html! { (tiles(&Presented::of_run(run).tiles)) })
}
