//! The strength of tests at a glance, with the scatter of several runs.

use std::collections::BTreeMap;

use granum_core::Column;
use granum_run::runs_table::{RunEntry, RunGroup, groups};
use granum_run::strength::{COHESIVE, MEASURES, Meaning, SECANT_REMARK};

use super::data::RunReport;
use super::numbers::{percent, quantity, significant};
use super::page::PageTable;

/// The measures of a run, by name.
pub type Measures = BTreeMap<String, f64>;

/// Mean and standard deviation (with n - 1) of the values of a measure; the deviation is missing for a single value, and the mean if
/// there is none.
pub fn scatter(values: &[f64]) -> Option<(f64, Option<f64>)> {
    let count = values.len() as f64;
    if values.is_empty() {
        return None;
    }
    let mean = values.iter().sum::<f64>() / count;
    let square: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    Some((mean, (values.len() > 1).then(|| (square / (count - 1.0)).sqrt())))
}

/// A value with its unit, marked up.
fn shown(meaning: &Meaning, value: f64) -> String {
    match (meaning.unit, meaning.name) {
        ("deg", _) => format!("{value:.1}°"),
        ("Pa", _) => quantity(value, "Pa"),
        (_, name) if name.contains("strain") && !name.contains("void") => percent(value),
        _ => significant(value, 3),
    }
}

/// The table of the measures of a test; `None` if there are none.
pub(crate) fn table(run: &RunReport) -> Option<PageTable> {
    let measures = run.measures();
    let known = MEASURES.iter().filter_map(|known| Some((known, *measures.get(known.name)?)));
    let rows: Vec<Vec<String>> = known
        .map(|(known, value)| vec![capital(known.meaning), known.symbol.to_owned(), shown(known, value)])
        .collect();
    if rows.is_empty() {
        return None;
    }
    let mut table =
        PageTable { rows, ..PageTable::new("", "Strength at a glance.", &["Measure", "Symbol", "Value"]) };
    table.note = "States that carry less than 5 % of the mean stress at the start of the test do not count for peaks. Late values are \
                  those of the critical state only as far as their drift is small."
        .into();
    if measures.contains_key(COHESIVE) {
        table.note += &format!(" {}.", capital(SECANT_REMARK));
    }
    Some(table)
}

/// The measures of several runs, a row for each, and below them the mean and the standard deviation (with n - 1) of every group of runs
/// that differ in the seeds of their samples alone.
pub fn scatter_table(entries: &[RunEntry], measures: &[Measures]) -> granum_core::Table {
    let groups: Vec<RunGroup> = groups(entries).into_iter().filter(|group| group.runs.len() > 1).collect();
    let mut names: Vec<String> = entries.iter().map(|entry| entry.name.clone()).collect();
    for group in &groups {
        let label = if group.label.is_empty() { "all runs" } else { &group.label };
        let count = group.runs.len();
        names.extend([format!("mean of {count}: {label}"), format!("standard deviation: {label}")]);
    }
    let mut columns = vec![Column::of_words("name", names)];
    for known in MEASURES.iter().filter(|known| measures.iter().any(|of| of.contains_key(known.name))) {
        let of = |run: usize| measures.get(run).and_then(|of| of.get(known.name)).copied();
        let mut values: Vec<f64> = (0..entries.len()).map(|run| of(run).unwrap_or(f64::NAN)).collect();
        for group in &groups {
            let found: Vec<f64> = group.runs.iter().filter_map(|run| of(*run)).collect();
            let (mean, deviation) = scatter(&found).unwrap_or((f64::NAN, None));
            values.extend([mean, deviation.unwrap_or(f64::NAN)]);
        }
        let unit = if known.unit == "1" { "" } else { known.unit };
        columns.push(Column::new(known.name, unit, values));
    }
    // This cannot fail: the names of measures differ, and every column has a value for each run and two for each group.
    granum_core::Table::new(columns).unwrap_or_default()
}

/// A text with a large first letter.
pub(crate) fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// A tile that says whether and when a sample liquefied; `None` for a drained test.
pub(crate) fn liquefaction(measures: &Measures) -> Option<[String; 3]> {
    let value = |name: &str| measures.get(name).copied();
    let largest = value("largest_pore_pressure_ratio")
        .map(|ratio| format!("*r*_{{u}} up to {}", significant(ratio, 2)));
    let what = if value("liquefied")? == 0.0 {
        return Some(["no".into(), "liquefaction".into(), largest.unwrap_or_default()]);
    } else if let Some(cycles) = value("cycles_to_liquefaction") {
        [significant(cycles, 3), "cycles to liquefaction".into()]
    } else {
        let strain = value("axial_strain_at_liquefaction").or(value("deviatoric_strain_at_liquefaction"));
        [strain.map_or("yes".into(), percent), "strain at liquefaction".into()]
    };
    let [number, name] = what;
    Some([number, name, largest.unwrap_or_default()])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scatter_is_the_sample_standard_deviation() {
        assert_eq!(scatter(&[]), None);
        assert_eq!(scatter(&[2.0]), Some((2.0, None)));
        let (mean, deviation) = scatter(&[1.0, 2.0, 3.0]).unwrap();
        assert_eq!((mean, deviation), (2.0, Some(1.0)));
    }

    #[test]
    fn runs_that_differ_in_their_seeds_have_a_scatter() {
        let entry = |seed: u64, friction: f64| {
            let mut case = granum_io::Case::default();
            case.preparation.seed = seed;
            case.set("grains.material.friction", &friction.to_string()).unwrap();
            RunEntry::new(format!("run-{seed}-{friction}"), "x", case, Default::default())
        };
        let entries = [entry(1, 0.3), entry(2, 0.3), entry(1, 0.5)];
        let angle = |value: f64| Measures::from([("peak_friction_angle".to_owned(), value)]);
        let table = scatter_table(&entries, &[angle(30.0), angle(32.0), Measures::new()]);
        assert_eq!(table.rows(), 5);
        let values = table.columns()[1].numbers().unwrap();
        assert!(
            values[2].is_nan() && values[3] == 31.0 && (values[4] - 2f64.sqrt()).abs() < 1e-12,
            "{values:?}"
        );
        assert_eq!(
            (table.columns()[1].name.as_str(), table.columns()[1].unit.as_str()),
            ("peak_friction_angle", "deg")
        );
    }
}
