//! The columns of a table of runs.

use std::collections::BTreeSet;

use granum_core::{Column, Table};
use granum_io::case::Vocabulary;
use granum_io::shell::ShowPath;
use granum_io::{RunRecord, RunStatus};

use super::entry::RunEntry;
use super::keys::{DifferingKey, KeyValue, differing_keys};
use super::units;

/// Measures of the sample, which come first.
const SAMPLE: [&str; 7] = [
    "solid_fraction",
    "void_ratio",
    "coordination_number",
    "mechanical_coordination_number",
    "backbone_coordination_number",
    "rattler_fraction",
    "mean_stress",
];

/// The measures that [`Selection::Main`] keeps, as far as the runs have them.
const MAIN: [&str; 22] = [
    "void_ratio",
    "mechanical_coordination_number",
    "peak_friction_angle",
    "critical_friction_angle",
    "cohesive",
    "largest_dilatancy_angle",
    "peak_stress_ratio",
    "late_stress_ratio",
    "peak_von_mises_ratio",
    "late_von_mises_ratio",
    "critical_void_ratio",
    "at_critical_state",
    "secant_modulus_50",
    "secant_modulus_50_at_least",
    "undrained_secant_modulus_50",
    "undrained_secant_modulus_50_at_least",
    "liquefied",
    "axial_strain_at_liquefaction",
    "cycles",
    "cycles_to_liquefaction",
    "largest_pore_pressure_ratio",
    "double_amplitude_axial_strain",
];

/// Which columns are shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Selection {
    /// All.
    All,
    /// What fits on a screen: the keys that differ, the main results, and the checks that failed.
    Main,
}

/// A table of runs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RunsTable {
    table: Table,
    /// For each column, true if it is a main one.
    main: Vec<bool>,
}

impl RunsTable {
    /// The table of runs, with a row for each in their order.
    pub fn from_runs(runs: &[RunEntry]) -> RunsTable {
        let mut table = RunsTable::default();
        let words = |of: &dyn Fn(&RunEntry) -> String| runs.iter().map(of).collect::<Vec<_>>();
        table.add(Column::of_words("name", words(&|run| run.name.clone())), true);
        let status = words(&|run| status(run.record.status).into());
        let unusual = runs.iter().any(|run| run.record.status != RunStatus::Finished);
        table.add(Column::of_words("status", status), unusual);
        for key in differing_keys(runs) {
            table.add(of_key(&key), true);
        }
        let number = |of: &dyn Fn(&RunEntry) -> f64| runs.iter().map(of).collect::<Vec<_>>();
        table.add(Column::new("grains", "", number(&|run| run.record.grains as f64)), false);
        for (name, unit) in measures(runs) {
            let values = number(&|run| measure(&run.record, &name));
            let main = MAIN.contains(&name.as_str()) || name.starts_with("k0_");
            table.add(Column::new(name, unit, values), main);
        }
        let checks = number(&|run| run.record.quality.len() as f64);
        table.add(Column::new("checks", "", checks), false);
        let failed_count =
            number(&|run| run.record.quality.iter().filter(|flag| !flag.passed).count() as f64);
        table.add(Column::new("checks_failed", "", failed_count), true);
        table.add(Column::of_words("failed_checks", words(&failed)), false);
        table.add(Column::of_words("case_digest", words(&|run| run.record.case_digest.clone())), false);
        if runs.iter().any(|run| run.digest.is_some()) {
            let digests = words(&|run| run.digest.clone().unwrap_or_default());
            table.add(Column::of_words("digest", digests), false);
        }
        table.add(Column::of_words("granum_version", words(&|run| run.record.granum_version.clone())), false);
        table.add(Column::of_words("folder", words(&|run| run.folder.shown())), false);
        table
    }

    fn add(&mut self, column: Column, main: bool) {
        // No two columns have the same name: keys of cases have a dot, and measures none of these names.
        if self.column(&column.name).is_none() {
            // This cannot fail: every column has one value for each run.
            let _ = self.table.set(column);
            self.main.push(main);
        }
    }

    /// The table with the selected columns.
    pub fn select(&self, selection: Selection) -> Table {
        let main = |column: &Column| {
            let named = self.table.names().zip(&self.main).find(|(name, _)| *name == column.name);
            named.is_some_and(|(_, main)| *main)
        };
        self.table.columns_where(|column| selection == Selection::All || main(column))
    }

    /// A column.
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.table.get(name)
    }
}

/// The column of a key: of numbers, or of words where it is a word in some run.
fn of_key(key: &DifferingKey) -> Column {
    let number = |value: &KeyValue| match value {
        KeyValue::Number(number) => Some(*number),
        KeyValue::Absent => Some(f64::NAN),
        KeyValue::Word(_) => None,
    };
    match key.values.iter().map(number).collect::<Option<Vec<f64>>>() {
        Some(numbers) => Column::new(&key.key, &key.unit, numbers),
        None => {
            let word = |value: &KeyValue| match value {
                KeyValue::Number(number) => granum_core::quantity::format_number(*number),
                KeyValue::Word(word) => word.clone(),
                KeyValue::Absent => String::new(),
            };
            Column::of_words(&key.key, key.values.iter().map(word))
        }
    }
}

fn status(status: RunStatus) -> &'static str {
    match status {
        RunStatus::Running => "running or killed",
        RunStatus::Interrupted => "interrupted",
        RunStatus::Finished => "finished",
        RunStatus::Failed => "failed",
    }
}

/// The names of the checks that a run did not pass.
fn failed(run: &RunEntry) -> String {
    let failed = run.record.quality.iter().filter(|flag| !flag.passed);
    failed.map(|flag| flag.name.as_str()).collect::<Vec<_>>().join(" ")
}

/// A measure of a run; NaN if it does not have it. The void ratio follows from the solid fraction.
fn measure(record: &RunRecord, name: &str) -> f64 {
    let of = |name: &str| record.measures.get(name).copied();
    let solid = || of("solid_fraction").filter(|solid| *solid > 0.0);
    match name {
        "void_ratio" => of(name).or_else(|| solid().map(|solid| (1.0 - solid) / solid)),
        _ => of(name),
    }
    .unwrap_or(f64::NAN)
}

/// The measures that some run has, with their units: those of the sample first, then the main ones, then the others by name.
fn measures(runs: &[RunEntry]) -> Vec<(String, String)> {
    let mut names: BTreeSet<String> =
        runs.iter().flat_map(|run| run.record.measures.keys().cloned()).collect();
    if names.contains("solid_fraction") {
        names.insert("void_ratio".into());
    }
    let place = |name: &str| {
        let first = SAMPLE.iter().position(|known| *known == name);
        let main = MAIN.iter().position(|known| *known == name);
        first.or(main.map(|place| SAMPLE.len() + place)).unwrap_or(SAMPLE.len() + MAIN.len())
    };
    let mut names: Vec<String> = names.into_iter().collect();
    names.sort_by_key(|name| place(name));
    let usual = Vocabulary::standard();
    let vocabulary = runs.first().map_or(&usual, |run| &run.case.vocabulary);
    let with_unit = |name: String| {
        let unit = units::of_measure(&name, vocabulary.sensors());
        (name, unit)
    };
    names.into_iter().map(with_unit).collect()
}
