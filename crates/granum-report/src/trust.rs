//! The section on the quality of the runs.

use granum_io::run::QualityFlag;
use maud::{Markup, html};

use super::data::RunReport;
use super::energy;
use super::figure::literal;
use super::figure::palette::{GREY, color};
use super::figure::{Axis, Figure, Layer, Panel, Plot};
use super::material::strain_axis;
use super::numbers::{percent, significant};
use super::page::{self, Check, Page, PageTable, rich};
use granum_core::words::listed;

/// Figure of the servo error, the inertial number and the unbalanced force.
fn figure(run: &RunReport) -> (Figure, String) {
    let axis = || strain_axis(std::slice::from_ref(run));
    let percentage = |column: &str| -> Vec<[f64; 2]> {
        run.against_strain(column).into_iter().map(|[x, y]| [x, 100.0 * y]).collect()
    };
    let limits = ["servo_error_rms", "servo_error_largest"].into_iter().filter_map(|name| {
        let limit = run.run.quality.iter().find(|flag| flag.name == name)?.limit;
        Some(Layer::horizontal(100.0 * limit, GREY).named("limits, rms and worst"))
    });
    let servo = Plot::new(axis(), Axis::new("Error of the mean stress (%)").including(0.0))
        .with_all(limits)
        .with(Layer::line(percentage("servo_error_largest"), color(1)).named("worst"))
        .with(Layer::line(percentage("servo_error_rms"), color(0)).named("rms"));
    // The sample at rest is excluded, since both quantities vanish there.
    let sheared = |column: &str| -> Vec<[f64; 2]> {
        run.against_strain(column).into_iter().filter(|[strain, _]| *strain > 1e-9).collect()
    };
    let rate = Plot::new(axis(), Axis::new("Dimensionless number").logarithmic())
        .with(Layer::line(sheared("unbalanced_force"), color(1)).named("unbalanced force"))
        .with(Layer::line(sheared("inertial_number"), color(0)).named("inertial number"));
    // Stages that hold another stress than p say in their notes how well they held it.
    let judged = run.column("servo_error_rms").iter().any(|error| error.is_finite() && *error != 0.0);
    if !run.is_at_constant_p() && !judged {
        let caption = "Was the test quasi-static? Inertial number of the strain rate and mean unbalanced force over the mean contact \
                       force.";
        return (
            Figure::new("Inertial number and unbalanced force", 1, vec![Panel::plot(rate)]),
            caption.to_owned(),
        );
    }
    let panels = vec![Panel::plot(servo), Panel::plot(rate)];
    let caption = "Was the test quasi-static and on its path? (a) Deviation of the mean stress from its target around \
                   each state; (b) inertial number of the strain rate and mean unbalanced force over the mean contact \
                   force.";
    (Figure::new("Servo error, inertial number and unbalanced force", 2, panels), caption.to_owned())
}

/// Readable names of quality flags, and whether their values are fractions.
const NAMES: [(&str, &str, bool); 18] = [
    ("sample_unbalanced_force", "Unbalanced force of the sample at rest", false),
    ("sample_mean_stress_missed_by", "Mean stress of the sample, deviation from its target", true),
    ("sample_largest_overlap", "Largest overlap in the sample over the sum of the radii", true),
    ("sample_time_step_fraction", "Time step over √(*m*/*k*) of the sample\u{2019}s stiffest contact", false),
    ("consolidation_unbalanced_force", "Unbalanced force after consolidation", false),
    (
        "consolidation_mean_stress_missed_by",
        "Mean stress after consolidation, deviation from its target",
        true,
    ),
    ("consolidation_largest_overlap", "Largest overlap after consolidation over the sum of the radii", true),
    (
        "consolidation_time_step_fraction",
        "Time step over √(*m*/*k*) of the stiffest contact after consolidation",
        false,
    ),
    ("solid_fraction_missed_by", "Solid fraction, deviation from its target", false),
    ("servo_error_rms", "Error of the mean stress, rms", true),
    ("servo_error_largest", "Error of the mean stress, worst", true),
    ("inertial_number", "Inertial number", false),
    ("unbalanced_force", "Unbalanced force over the mean contact force", false),
    ("largest_overlap", "Largest overlap over the sum of the radii", true),
    ("energy_gap", "Energy balance, residual over boundary work", true),
    ("momentum_drift", "Net momentum over the sum of momenta", false),
    ("time_step_fraction", "Time step over √(*m*/*k*) of the stiffest contact", false),
    ("mean_stress_lost", "Mean stress lost at the end", true),
];

fn name(flag: &QualityFlag) -> String {
    let known = NAMES.iter().find(|(key, _, _)| *key == flag.name);
    known.map_or_else(|| flag.name.replace('_', " "), |(_, name, _)| (*name).to_owned())
}

fn number(flag: &QualityFlag, value: f64) -> String {
    let is_share = NAMES.iter().any(|(key, _, share)| *key == flag.name && *share);
    if is_share { percent(value) } else { significant(value, 2) }
}

/// The quality flags of a run in words.
pub(crate) fn checks(flags: &[QualityFlag]) -> Vec<Check> {
    let check = |flag: &QualityFlag| Check {
        passed: flag.passed,
        name: name(flag),
        before: String::new(),
        value: number(flag, flag.value),
        after: format!(" (at most {})", number(flag, flag.limit)),
        advice: if flag.passed { String::new() } else { flag.advice.to_string() },
    };
    flags.iter().map(check).collect()
}

/// The quality flags of several runs as a table.
fn table(label: &str, runs: &[RunReport]) -> PageTable {
    let mut heads = vec!["Check".to_owned(), "Limit".to_owned()];
    heads.extend(runs.iter().map(|run| literal(&run.name)));
    let mut table = PageTable { columns: heads, ..PageTable::new(label, "Checks on each run.", &[]) };
    let mut seen = std::collections::BTreeSet::new();
    for flag in runs.iter().flat_map(|run| &run.run.quality).filter(|flag| seen.insert(flag.name.clone())) {
        let mut cells = vec![name(flag), number(flag, flag.limit)];
        for run in runs {
            cells.push(match run.run.quality.iter().find(|other| other.name == flag.name) {
                Some(other) if other.passed => number(other, other.value),
                Some(other) => format!("{} !", number(other, other.value)),
                None => "–".to_owned(),
            });
        }
        table.row(cells);
    }
    table.note = "An exclamation mark: the value is beyond the limit.".to_owned();
    table
}

/// A sentence on the energy balance.
fn energy_sentence(run: &RunReport) -> Option<String> {
    let shares = energy::shares(run);
    let named: Vec<String> = (shares.iter())
        .filter(|(_, share)| *share >= 0.005)
        .map(|(name, share)| format!("{name} {}", percent(*share)))
        .collect();
    // A report should use a single definition: if the run has quality flags, the value is that of the flag.
    let judged = run.run.quality.iter().find(|flag| flag.name == "energy_gap").map(|flag| flag.value);
    let closes = match judged {
        Some(gap) => {
            format!(
                "At the end the energy balance closes to within {} of that work (the check above)",
                percent(gap)
            )
        }
        None if !run.run.quality.is_empty() => {
            "The energy balance is not judged, since global damping took energy while the sample came to rest"
                .into()
        }
        None => format!(
            "At every recorded state the energy balance closes to within {} of that work",
            percent(energy::closure(run)?)
        ),
    };
    Some(format!("Shares of the boundary work: {}. {closes}.", listed(&named)))
}

/// The section for a sample that was not sheared.
pub fn sample_section(run: &RunReport) -> Markup {
    html! { p { (verdict(std::slice::from_ref(run))) } (page::checks(&checks(&run.run.quality))) }
}

/// A sentence that states whether runs are within their limits.
pub(crate) fn verdict(runs: &[RunReport]) -> String {
    let broken: Vec<String> = runs.iter().filter(|r| !r.run.is_good()).map(|r| literal(&r.name)).collect();
    let unjudged = runs.iter().any(|r| r.run.quality.is_empty());
    match (runs.len(), broken.len()) {
        (_, 0) if unjudged => "The checks are made when a run ends; one of these has not ended.".to_owned(),
        (1, 0) => "The run passed every check.".to_owned(),
        (_, 0) => "All runs passed every check.".to_owned(),
        (1, _) => "The run did not pass every check: read its results with care.".to_owned(),
        (all, broken) if broken > 6 => {
            format!("{broken} of {all} runs did not pass every check: read their results with care.")
        }
        _ => format!("Not every check was passed by {}: read their results with care.", broken.join(", ")),
    }
}

/// The section for several runs without figures: the checks that some of them did not pass, each with its worst value.
pub fn of_several(runs: &[RunReport]) -> Markup {
    let mut failed: Vec<(&QualityFlag, usize)> = Vec::new();
    for flag in runs.iter().flat_map(|run| &run.run.quality).filter(|flag| !flag.passed) {
        match failed.iter_mut().find(|(worst, _)| worst.name == flag.name) {
            Some((worst, count)) => {
                *count += 1;
                if flag.value > worst.value {
                    *worst = flag;
                }
            }
            None => failed.push((flag, 1)),
        }
    }
    let check = |(flag, count): (&QualityFlag, usize)| Check {
        passed: false,
        name: name(flag),
        before: format!(
            "{count} of {} runs are beyond the limit of {}, the worst with ",
            runs.len(),
            number(flag, flag.limit)
        ),
        value: number(flag, flag.value),
        after: String::new(),
        advice: flag.advice.to_string(),
    };
    let failed: Vec<Check> = failed.into_iter().map(check).collect();
    html! {
        p { (verdict(runs)) }
        (page::checks(&failed))
    }
}

/// The section, with figures of the first run.
pub fn section(page: &mut Page, runs: &[RunReport]) -> Markup {
    let Some(run) = runs.first() else { return html! {} };
    let judged = if runs.len() == 1 {
        page::checks(&checks(&run.run.quality))
    } else {
        let label = page.own_table_label();
        table(&label, runs).html()
    };
    let (servo, servo_caption) = figure(run);
    let servo = page.own_figure("servo", &servo_caption, &servo);
    let energy = energy::figure(run).map(|(figure, caption)| page.own_figure("energy", &caption, &figure));
    html! {
        p { (verdict(runs)) }
        (judged)
        (servo)
        @if let Some(sentence) = energy_sentence(run) { p { (rich(&sentence)) } }
        @if let Some(energy) = energy { (energy) }
    }
}
