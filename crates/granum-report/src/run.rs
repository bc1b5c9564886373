//! The report of one run.

use granum_run::strength::symmetry::shear_at_constant_p;
use maud::{Markup, html};

use super::case_details::{case_details, whose_grains};
use super::data::RunReport;
use super::figure::literal;
use super::forces;
use super::further;
use super::material;
use super::numbers::quantity;
use super::page::{Document, Page, rich, tiles};
use super::presented::Presented;
use super::viewer::folded;
use super::{path, preparation, sample, shapes, trust};

/// Writes the report of a run.
pub fn report(run: &RunReport) -> Document {
    let mut page = Page::default();
    let runs = std::slice::from_ref(run);
    let behaviour = behaviour(&mut page, runs);
    let further: Vec<Markup> = (further::figures(run).iter())
        .map(|(file, figure, caption)| page.own_figure(file, caption, figure))
        .collect();
    let presented = Presented::of_run(run);
    let strength = presented.strength.as_ref().map(|table| page.own_table(table.clone()));
    let behaviour = html! {
        @if let Some(strength) = strength { (strength) }
        (behaviour)
        @for figure in further { (figure) }
    };
    page.section("behaviour", "Stress, volume and contacts", behaviour);
    let spread = force_section(&mut page, run);
    page.section("forces", "Distribution of the contact forces", spread);
    let trust = trust::section(&mut page, runs);
    page.section("quality", "Can it be trusted?", trust);
    let preparation =
        preparation::figure(run).map(|(figure, caption)| page.own_figure("preparation", &caption, &figure));
    let label = page.own_table_label();
    let shapes = shapes::section(&mut page, run);
    page.section(
        "case",
        "The sample and the case",
        html! {
            (sample::own_table(&label, run).html())
            @if let Some(shapes) = shapes { (shapes) }
            @if let Some(preparation) = preparation { (preparation) }
            (case_details(run))
        },
    );
    let head = html! {
        (tiles(&presented.tiles))
        p { (rich(&presented.signs)) }
        @if let Some(remark) = &presented.unfinished { p class="callout" { (remark) } }
    };
    page.finish(&literal(&run.name), &subtitle(run), head)
}

fn subtitle(run: &RunReport) -> String {
    let case = &run.case;
    let mut parts = vec![whose_grains(run), sample::law(&case.contact), test_of(run)];
    if !run.run.granum_version.is_empty() {
        parts.push(format!("granum {}", run.run.granum_version));
    }
    parts.join(" · ")
}

/// Description of the test: what it is, if it is like the paper's, or the names of its stages.
fn test_of(run: &RunReport) -> String {
    let stages = run.case.test_stages();
    if let Some(target) = shear_at_constant_p(&stages) {
        let stress = target.value.unwrap_or(run.case.preparation.mean_stress);
        return format!("axisymmetric compression at *p* = {}", quantity(stress, "Pa"));
    }
    let names: Vec<String> =
        stages.iter().filter(|stage| !stage.is_mark()).map(|stage| literal(&stage.name)).collect();
    match names.len() {
        0..=6 => names.join(", "),
        count => format!("{count} stages: {}, ...", names[..3].join(", ")),
    }
}

/// The section on stress, volume, contacts and fabric of one or several runs.
pub fn behaviour(page: &mut Page, runs: &[RunReport]) -> Markup {
    let Some(first) = runs.first() else { return html! {} };
    if !first.is_at_constant_p() {
        let path = path::behaviour(page, first);
        let (coordination, caption) = material::coordination(first);
        let coordination = page.own_figure("coordination", &caption, &coordination);
        let (fabric, caption) = material::principal_fabric(first);
        return html! { (path) (coordination) (page.own_figure("fabric", &caption, &fabric)) };
    }
    let (stress, stress_caption) = material::stress_and_volume(runs);
    let (shares, shares_caption) = material::stress_shares(first);
    let (coordination, coordination_caption) = material::coordination(first);
    let (fabric, fabric_caption) = material::fabric(runs);
    html! {
        (page.own_figure("stress", &stress_caption, &stress))
        (page.own_figure("stress-parts", &shares_caption, &shares))
        (page.own_figure("coordination", &coordination_caption, &coordination))
        (page.own_figure("fabric", &fabric_caption, &fabric))
    }
}

/// The section on P(f), roses and force chains of a run.
pub fn force_section(page: &mut Page, run: &RunReport) -> Markup {
    let (distribution, caption) = forces::distribution(run);
    let distribution = page.own_figure("forces", &caption, &distribution);
    let (roses, caption) = forces::roses(run);
    let roses = page.own_figure("roses", &caption, &roses);
    let slices = forces::slices(run.start.as_ref(), run.end.as_ref())
        .map(|(figure, caption)| page.own_figure("force-chains", &caption, &figure));
    let network = run.end.as_ref().map(|end| {
        let (figure, caption) = forces::strong_network(end);
        page.own_figure("strong-network", &caption, &figure)
    });
    let viewer = run.end.as_ref().and_then(folded);
    html! {
        (distribution) (roses)
        @if let Some(slices) = slices { (slices) }
        @if let Some(network) = network { (network) }
        @if let Some(viewer) = viewer { (viewer) }
    }
}
