//! Comparison of the sample with that of the paper.

use granum_io::RunKind;

use super::data::RunReport;
use super::figure::literal;
use super::numbers::{quantity, significant, whole};
use super::page::PageTable;
use granum_dem::config::{Component, ContactModel, Material};
use granum_dem::contact::choice::check::parameters_of;
use granum_dem::loading::{Speed, Stage};

/// Solid fraction of the sample of the paper.
pub const SOLID_FRACTION: f64 = 0.61;
/// Coordination number of the sample of the paper, "average number of load bearing contacts".
pub const COORDINATION: f64 = 4.8;
/// Tolerances within which the values agree, according to the digits given in the paper.
const SOLID_FRACTION_NEAR: f64 = 0.005;
const COORDINATION_NEAR: f64 = 0.1;

/// Definitions of the coordination number, with column and name.
const DEFINITIONS: [(&str, &str); 4] = [
    ("mechanical_coordination_number", "mechanical coordination number (grains with two contacts or more)"),
    ("coordination_number", "coordination number of all grains"),
    ("compressive_coordination_number", "coordination number of contacts in compression"),
    ("backbone_coordination_number", "coordination number of the backbone (rattlers removed repeatedly)"),
];

/// Mean over the runs of the first value of a column.
pub fn mean_start(runs: &[RunReport], column: &str) -> Option<f64> {
    let values: Vec<f64> =
        runs.iter().filter_map(|run| run.first(column)).filter(|v| v.is_finite()).collect();
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Name and value of the definition whose value is closest to that of the paper.
pub fn nearest_definition(runs: &[RunReport]) -> Option<(&'static str, f64)> {
    DEFINITIONS
        .into_iter()
        .filter_map(|(column, name)| Some((name, mean_start(runs, column)?)))
        .min_by(|a, b| (a.1 - COORDINATION).abs().total_cmp(&(b.1 - COORDINATION).abs()))
}

/// Sentences on the closest definition, and on the values that cannot be reached at the same time.
pub fn interpretation(runs: &[RunReport]) -> Vec<String> {
    let (Some(solid), Some((name, nearest))) = (mean_start(runs, "solid_fraction"), nearest_definition(runs))
    else {
        return Vec::new();
    };
    let mut sentences = vec![format!(
        "The paper calls its {COORDINATION} the mechanical coordination number, \u{201c}average number of load bearing \
         contacts\u{201d}. Of the usual definitions the {name} is closest here: {}.",
        significant(nearest, 3)
    )];
    let solid_met = (solid - SOLID_FRACTION).abs() <= SOLID_FRACTION_NEAR;
    let coordination_met = (nearest - COORDINATION).abs() <= COORDINATION_NEAR;
    let by = |value: f64, target: f64| {
        let side = if value > target { "above" } else { "below" };
        format!("{} {side}", significant((value - target).abs(), 2))
    };
    sentences.push(match (solid_met, coordination_met) {
        (true, true) => {
            format!("Solid fraction ({}) and coordination number are both met.", significant(solid, 3))
        }
        (true, false) => format!(
            "The solid fraction is met ({}), the coordination number is not ({} the paper\u{2019}s): with this law and \
             stress the two were not reached together, since any preparation that changes one also changes the other. \
             We chose the solid fraction, which has only one definition.",
            significant(solid, 3),
            by(nearest, COORDINATION)
        ),
        (false, true) => format!(
            "The coordination number is met, the solid fraction is not ({}, {} the paper\u{2019}s).",
            significant(solid, 3),
            by(solid, SOLID_FRACTION)
        ),
        (false, false) => format!(
            "Neither is met: the solid fraction is {} ({} the paper\u{2019}s), the coordination number {} the paper\u{2019}s.",
            significant(solid, 3),
            by(solid, SOLID_FRACTION),
            by(nearest, COORDINATION)
        ),
    });
    sentences
}

/// The rows for a single material.
fn of_one_material(material: &Material, row: &mut impl FnMut(&str, &str, String)) {
    row("Young\u{2019}s modulus *E*", "70 GPa", quantity(material.youngs_modulus, "Pa"));
    row("Poisson\u{2019}s ratio *ν*", "0.3", trimmed(material.poissons_ratio));
    row("Friction *μ*", "0.3", trimmed(material.friction));
    row("Interface energy *Γ*", "0.6 J/m^{2}", format!("{} J/m^{{2}}", trimmed(material.interface_energy)));
    row("Density", "–", format!("{} kg/m^{{3}}", whole(material.density)));
}

/// The row for one of several materials.
fn row_of_component(component: &Component, row: &mut impl FnMut(&str, &str, String)) {
    let own = &component.material;
    let name = format!("Material \u{201c}{}\u{201d}", literal(&component.name));
    let values = format!(
        "{} % of the grains: *E* {}, *ν* {}, *μ* {}, *Γ* {} J/m^{{2}}, {} kg/m^{{3}}",
        trimmed(100.0 * component.share),
        quantity(own.youngs_modulus, "Pa"),
        trimmed(own.poissons_ratio),
        trimmed(own.friction),
        trimmed(own.interface_energy),
        whole(own.density)
    );
    row(&name, "–", values);
}

/// Properties of a sample and its test: name, value in the paper and value here.
fn rows(runs: &[RunReport]) -> Vec<[String; 3]> {
    let Some(run) = runs.first() else { return Vec::new() };
    let (case, material) = (&run.case, &run.case.grains.material);
    let mut rows = Vec::new();
    let mut row = |name: &str, paper: &str, here: String| rows.push([name.into(), paper.into(), here]);
    if let Some(packing) = &run.run.packing {
        row("Packing", "–", literal(&packing.file_name));
    }
    row("Grains", "5000", whole(run.grains() as f64));
    row("Diameter", "0.1 mm", diameter(run));
    if case.grains.mixture.is_empty() {
        of_one_material(material, &mut row);
    }
    case.grains.mixture.components.iter().for_each(|component| row_of_component(component, &mut row));
    row("Contact law", "theoretical contact mechanics (Thornton and Yin 1991)", law(&case.contact));
    row("Contact damping", "–", format!("{} of critical", trimmed(case.contact.damping)));
    let test = run.case.test_definition();
    let is_at_constant_p = run.is_at_constant_p();
    let whose = if is_at_constant_p { "Mean stress *p*" } else { "Mean stress *p* of the sample" };
    row(whose, "20 kPa", quantity(run.mean_stress(), "Pa"));
    if !case.preparation_stages.is_empty() {
        row("Stages of the preparation", "–", whole(case.sample_stages().len() as f64));
    }
    match test.stages.as_slice() {
        _ if run.run.kind == RunKind::Sample => {}
        [stage] if is_at_constant_p => {
            row("Strain rate", "10^{−5} s^{−1}", rate(stage));
            let end = test.deviator_strain_end();
            row("Deviator strain at the end", "0.3", end.map_or("–".to_owned(), trimmed));
        }
        stages => row("Stages of the test", "–", whole(stages.len() as f64)),
    }
    let start =
        |column: &str| mean_start(runs, column).map_or("–".to_owned(), |value| significant(value, 3));
    row("Solid fraction", "0.61", start("solid_fraction"));
    for (column, name) in DEFINITIONS {
        let mut name = name.to_owned();
        name[..1].make_ascii_uppercase();
        let paper = if column == "mechanical_coordination_number" { "4.8" } else { "–" };
        row(&name, paper, start(column));
    }
    rows
}

/// Mean diameter, with the range of the diameters if they differ.
fn diameter(run: &RunReport) -> String {
    let (mean, spread) = run.diameter();
    let mean = significant(1e3 * mean, 3);
    let mean = if mean.contains('.') { mean.trim_end_matches('0').trim_end_matches('.') } else { &mean };
    if spread > 0.0 {
        format!("{mean} mm ± {} %", significant(100.0 * spread, 2))
    } else {
        format!("{mean} mm")
    }
}

/// Table that compares the sample with that of the paper; `None` without runs.
pub fn table(label: &str, runs: &[RunReport]) -> Option<PageTable> {
    runs.first()?;
    let caption = "The sample and the test compared with the paper\u{2019}s. Dash: not given in the paper.";
    let mut table = PageTable::new(label, caption, &["Quantity", "Paper", "Here"]);
    for row in rows(runs) {
        table.row(row.into());
    }
    if runs.len() > 1 {
        table.note =
            format!("Values of the sample are means over {} samples that differ in their seed.", runs.len());
    }
    Some(table)
}

/// Table of the sample and the test of one run, without comparison.
pub fn own_table(label: &str, run: &RunReport) -> PageTable {
    let caption = match run.run.kind {
        RunKind::Sample => "The sample.",
        RunKind::Test => "The sample at the start of the test, and the test.",
    };
    let mut table = PageTable::new(label, caption, &["Quantity", "Value"]);
    for [name, _, here] in rows(std::slice::from_ref(run)) {
        table.row(vec![name, here]);
    }
    table
}

fn trimmed(value: f64) -> String {
    super::numbers::trimmed(value)
}

/// The contact law in words, with the parameters of the laws.
pub fn law(contact: &ContactModel) -> String {
    let mut words = format!("{}, {}", contact.normal.label(), contact.tangential.label());
    if contact.rolling.law().acts() {
        words.push_str(&format!(", {}", contact.rolling.label()));
    }
    if contact.adhesion.law().acts() {
        words.push_str(&format!(", {}", contact.adhesion.label()));
    }
    for parameter in parameters_of(contact) {
        let value = significant(contact.parameters.value(parameter), 4);
        let unit = if parameter.unit.symbol.is_empty() { "" } else { " " };
        words.push_str(&format!(
            "; {} {value}{unit}{}",
            parameter.key.replace('_', " "),
            parameter.unit.symbol
        ));
    }
    words
}

fn rate(stage: &Stage) -> String {
    match stage.control.speed {
        Speed::InertialNumber { number, .. } => format!("*I* = {}", significant(number, 3)),
        Speed::StrainRate(strain_rate) => {
            let density_scaling = significant(stage.density_scaling, 2);
            format!("{} s^{{−1}}, density × {density_scaling}", significant(strain_rate, 2))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use granum_core::{Column, Table};
    use granum_sensors::Record;

    fn run(solid: f64, mechanical: f64, all: f64) -> RunReport {
        let column = |name: &str, value| Column::new(name, "", vec![value]);
        let series = Table::new(vec![
            column("solid_fraction", solid),
            column("mechanical_coordination_number", mechanical),
            column("coordination_number", all),
        ])
        .unwrap();
        RunReport { record: Record { series, histograms: Vec::new() }, ..Default::default() }
    }

    #[test]
    fn the_nearest_definition_is_named_and_the_rest_said() {
        let runs = [run(0.610, 5.2, 4.83)];
        assert_eq!(nearest_definition(&runs).unwrap().1, 4.83);
        assert!(interpretation(&runs)[1].contains("both met"));
        let runs = [run(0.608, 5.4, 5.1), run(0.612, 5.4, 5.1)];
        assert!(
            interpretation(&runs)[1].contains("not reached together")
                && interpretation(&runs)[1].contains("0.30 above")
        );
        assert!(interpretation(&[run(0.58, 4.8, 4.0)])[1].contains("0.030 below"));
        assert!(interpretation(&[run(0.58, 4.0, 3.0)])[1].starts_with("Neither"));
        assert!(interpretation(&[]).is_empty() && table("T", &[]).is_none());
    }
}
