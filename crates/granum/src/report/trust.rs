//! The section that says whether the runs can be trusted.

use granum_io::run::QualityFlag;
use maud::{Markup, html};

use super::data::RunReport;
use super::energy;
use super::figure::palette::{GREY, color};
use super::figure::{Axis, Figure, Layer, Panel, Plot};
use super::material::strain_axis;
use super::numbers::{listed, percent, significant};
use super::page::{Page, Table, rich};
use super::quality;

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

/// Names of judgements for people, and whether they are shares.
const NAMES: [(&str, &str, bool); 6] = [
    ("servo_error_rms", "Error of the mean stress, rms", true),
    ("servo_error_largest", "Error of the mean stress, worst", true),
    ("inertial_number", "Inertial number, largest", false),
    ("unbalanced_force_mean", "Unbalanced force, mean over the test", false),
    ("largest_overlap", "Largest overlap over the sum of the radii", true),
    ("energy_closure", "Energy ledger, error over boundary work", true),
];

fn name(flag: &QualityFlag) -> String {
    let known = NAMES.iter().find(|(key, _, _)| *key == flag.name);
    known.map_or_else(|| flag.name.replace('_', " "), |(_, name, _)| (*name).to_owned())
}

fn number(flag: &QualityFlag, value: f64) -> String {
    let is_share = NAMES.iter().any(|(key, _, share)| *key == flag.name && *share);
    if is_share { percent(value) } else { significant(value, 2) }
}

/// What a run says of itself, or, where it says nothing, what its record says.
pub fn flags(run: &RunReport) -> Vec<QualityFlag> {
    if run.run.quality.is_empty() { quality::flags(&run.record) } else { run.run.quality.clone() }
}

/// A list of flags.
fn list(flags: &[QualityFlag]) -> Markup {
    html! {
        ul class="flags" { @for flag in flags {
            li class=(if flag.passed { "held" } else { "broken" }) {
                (name(flag)) ": " b { (rich(&number(flag, flag.value))) }
                " (at most " (rich(&number(flag, flag.limit))) ")"
                @if !flag.passed { " What to do: " span class="advice" { (flag.advice) "." } }
            }
        } }
    }
}

/// Flags of several runs as a table.
fn table(label: &str, runs: &[RunReport]) -> Table {
    let mut heads = vec!["Check".to_owned(), "Limit".to_owned()];
    heads.extend(runs.iter().map(|run| run.name.clone()));
    let mut table = Table { columns: heads, ..Table::new(label, "Checks on each run.", &[]) };
    let all: Vec<Vec<QualityFlag>> = runs.iter().map(flags).collect();
    for flag in all.first().into_iter().flatten() {
        let mut cells = vec![name(flag), number(flag, flag.limit)];
        for flags in &all {
            cells.push(match flags.iter().find(|other| other.name == flag.name) {
                Some(other) if other.passed => number(other, other.value),
                Some(other) => format!("{} !", number(other, other.value)),
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
    let shares = energy::shares(&run.record);
    let named: Vec<String> = (shares.iter())
        .filter(|(_, share)| *share >= 0.005)
        .map(|(name, share)| format!("{name} {}", percent(*share)))
        .collect();
    let closure = energy::closure(&run.record)?;
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
        runs.iter().filter(|r| flags(r).iter().any(|f| !f.passed)).map(|r| r.name.as_str()).collect();
    let verdict = match (runs.len(), broken.len()) {
        (1, 0) => "The run keeps every limit.".to_owned(),
        (_, 0) => "All runs keep every limit.".to_owned(),
        (1, _) => "The run breaks a limit: read its results with care.".to_owned(),
        _ => format!("Limits are broken by {}: read them with care.", broken.join(", ")),
    };
    let judged = if runs.len() == 1 {
        list(&flags(run))
    } else {
        let label = page.own_table_label();
        table(&label, runs).html()
    };
    let (servo, servo_caption) = figure(run);
    let servo = page.own_figure("servo", &servo_caption, &servo);
    let energy = energy::figure(run).map(|(figure, caption)| page.own_figure("energy", &caption, &figure));
    html! {
        p { (verdict) }
        (judged)
        (servo)
        @if let Some(sentence) = energy_sentence(run) { p { (rich(&sentence)) } }
        @if let Some(energy) = energy { (energy) }
    }
}
