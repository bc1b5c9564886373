//! The section that says whether the runs can be trusted.

use maud::{Markup, html};

use super::data::RunReport;
use super::energy;
use super::figure::palette::{GREY, color};
use super::figure::{Axis, Figure, Layer, Panel, Plot};
use super::material::strain_axis;
use super::numbers::{listed, percent};
use super::page::{Page, Table, rich};
use super::quality::{self, Flag};

/// Servo, rate and balance.
fn figure(run: &RunReport) -> (Figure, String) {
    let axis = || strain_axis(std::slice::from_ref(run));
    let percentage = |column: &str| -> Vec<[f64; 2]> {
        run.against_strain(column).into_iter().map(|[x, y]| [x, 100.0 * y]).collect()
    };
    let servo = Plot::new(axis(), Axis::new("Error of the mean stress (%)").including(0.0))
        .with(Layer::horizontal(100.0 * quality::SERVO_RMS, GREY).named("limits, rms and worst"))
        .with(Layer::horizontal(100.0 * quality::SERVO_WORST, GREY).named("limits, rms and worst"))
        .with(Layer::line(percentage("servo_error_largest"), color(1)).named("worst"))
        .with(Layer::line(percentage("servo_error_rms"), color(0)).named("rms"));
    let rate = Plot::new(axis(), Axis::new("Dimensionless number").logarithmic())
        .with(Layer::line(run.against_strain("unbalanced_force"), color(1)).named("unbalanced force"))
        .with(Layer::line(run.against_strain("inertial_number"), color(0)).named("inertial number"));
    let panels = vec![Panel::plot(servo), Panel::plot(rate)];
    let caption = "Was the test quasi-static and on its path? (a) Distance of the mean stress from its target around each \
                   state; (b) inertial number of the strain rate and mean unbalanced force over the mean contact force.";
    (Figure::new("Servo error, inertial number and unbalanced force", 2, panels), caption.to_owned())
}

/// A list of flags.
fn list(flags: &[Flag]) -> Markup {
    html! {
        ul class="flags" { @for flag in flags {
            li class=(if flag.held { "held" } else { "broken" }) {
                (flag.name) ": " b { (rich(&flag.found)) } " (" (rich(&flag.limit)) ")"
                @if !flag.held { " " span class="advice" { (flag.advice) } }
            }
        } }
    }
}

/// Flags of several runs as a table.
fn table(label: &str, runs: &[RunReport]) -> Table {
    let mut heads = vec!["Check".to_owned(), "Limit".to_owned()];
    heads.extend(runs.iter().map(|run| run.name.clone()));
    let mut table = Table { columns: heads, words: 1, ..Table::new(label, "Checks on each run.", &[]) };
    let all: Vec<Vec<Flag>> = runs.iter().map(quality::flags).collect();
    for flag in all.first().into_iter().flatten() {
        let mut cells = vec![flag.name.to_owned(), flag.limit.clone()];
        for flags in &all {
            cells.push(match flags.iter().find(|other| other.name == flag.name) {
                Some(other) if other.held => other.found.clone(),
                Some(other) => format!("{} !", other.found),
                None => "–".to_owned(),
            });
        }
        table.row(cells);
    }
    table.note = "An exclamation mark: the limit is broken.".to_owned();
    table
}

/// Where the work of the boundary went, in a sentence.
fn energy_sentence(run: &RunReport) -> Option<String> {
    let shares = energy::shares(run);
    let named: Vec<String> = (shares.iter())
        .filter(|(_, share)| *share >= 0.005)
        .map(|(name, share)| format!("{name} {}", percent(*share)))
        .collect();
    let closure = energy::closure(run)?;
    Some(format!(
        "Of the work that the boundary did: {}. The ledger closes to {} of that work.",
        listed(&named),
        percent(closure)
    ))
}

/// The section, with figures of the first run.
pub fn section(page: &mut Page, runs: &[RunReport]) -> Markup {
    let Some(run) = runs.first() else { return html! {} };
    let broken: Vec<&str> =
        runs.iter().filter(|r| quality::flags(r).iter().any(|f| !f.held)).map(|r| r.name.as_str()).collect();
    let verdict = match (runs.len(), broken.len()) {
        (1, 0) => "The run keeps every limit.".to_owned(),
        (_, 0) => "All runs keep every limit.".to_owned(),
        (1, _) => "The run breaks a limit: read its results with care.".to_owned(),
        _ => format!("Limits are broken by {}: read them with care.", broken.join(", ")),
    };
    let flags = if runs.len() == 1 {
        list(&quality::flags(run))
    } else {
        let label = page.own_table_label();
        table(&label, runs).html()
    };
    let (servo, servo_caption) = figure(run);
    let servo = page.own_figure("servo", &servo_caption, &servo);
    let energy = energy::figure(run).map(|(figure, caption)| page.own_figure("energy", &caption, &figure));
    html! {
        p { (verdict) }
        (flags)
        (servo)
        @if let Some(sentence) = energy_sentence(run) { p { (rich(&sentence)) } }
        @if let Some(energy) = energy { (energy) }
    }
}
