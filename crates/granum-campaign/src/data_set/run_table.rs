//! A table that is built row by row, with the columns that any of its rows has.

use std::collections::BTreeMap;

use granum_core::quantity::format_number;
use granum_io::case::{CaseParameter, ParameterValue};
use granum_io::{Case, Column, ColumnKind, Result, Table};
use granum_run::derived_columns::{sample_measures, single_parameters};
use granum_run::runs_table::unit_of_measure;
use granum_sensors::Sensors;

use super::layout::{BIN_WIDTH, BINS, CHECK, FIRST_BIN, LIMIT, MEASURE, QUANTITY, RUN, SETTINGS, VARIABLE};
use crate::campaign::Campaign;
use crate::campaign_file::CampaignRun;
use crate::plan::RunValue;
use crate::rows::StoredRun;

/// The value of a cell.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Cell {
    Number(f64),
    Word(String),
}

/// A column that is being filled.
struct Filling {
    name: String,
    unit: String,
    kind: ColumnKind,
    /// For each row that has it its number and the value.
    cells: Vec<(usize, Cell)>,
}

/// A table that is built row by row.
#[derive(Default)]
pub(super) struct RowTable {
    columns: Vec<Filling>,
    places: BTreeMap<String, usize>,
    rows: usize,
}

impl RowTable {
    /// Begins a row.
    pub fn begin_row(&mut self) {
        self.rows += 1;
    }

    /// Sets a cell of the row; the first one counts if it is set twice.
    pub fn set(&mut self, name: &str, unit: &str, kind: ColumnKind, cell: Cell) {
        let next = self.columns.len();
        let place = *self.places.entry(name.to_string()).or_insert(next);
        if place == next {
            let (name, unit) = (name.to_string(), unit.to_string());
            self.columns.push(Filling { name, unit, kind, cells: Vec::new() });
        }
        let row = self.rows.saturating_sub(1);
        let cells = &mut self.columns[place].cells;
        if cells.last().is_none_or(|(last, _)| *last != row) {
            cells.push((row, cell));
        }
    }

    fn number(&mut self, name: &str, unit: &str, value: f64) {
        self.set(name, unit, ColumnKind::Real, Cell::Number(value));
    }

    fn count(&mut self, name: &str, value: f64) {
        self.set(name, "", ColumnKind::Integer, Cell::Number(value));
    }

    pub fn word(&mut self, name: &str, word: &str) {
        self.set(name, "", ColumnKind::Word, Cell::Word(word.to_string()));
    }

    fn parameter(&mut self, found: &CaseParameter) {
        match &found.value {
            ParameterValue::Number(number) => self.number(&found.key, &found.unit, *number),
            ParameterValue::Word(word) => self.word(&found.key, word),
            // Lists have been taken apart.
            ParameterValue::List(_) => {}
        }
    }

    /// The values of the variables in a run.
    pub fn variables(&mut self, campaign: &Campaign, run: &CampaignRun) {
        for (variable, value) in campaign.variables().iter().zip(&run.values) {
            let name = format!("{VARIABLE}{}", variable.name);
            match value {
                RunValue::Number(number) => self.number(&name, &variable.unit, *number),
                RunValue::Word(word) => self.word(&name, word),
            }
        }
    }

    /// The row of a run among the runs.
    pub fn run(
        &mut self,
        campaign: &Campaign,
        run: &CampaignRun,
        case: &Case,
        stored: &StoredRun,
        sensors: &Sensors,
    ) {
        self.begin_row();
        self.word(RUN, &run.name);
        self.variables(campaign, run);
        let record = &stored.record;
        self.count("states", stored.measured.series.rows() as f64);
        self.count("grains", record.grains as f64);
        if let Some(seed) = record.seed {
            self.count("seed", seed as f64);
        }
        single_parameters(case).iter().for_each(|found| self.parameter(found));
        sample_measures(&stored.measured.series).iter().for_each(|found| self.parameter(found));
        for (name, value) in &record.measures {
            self.number(&format!("{MEASURE}{name}"), &unit_of_measure(name, sensors), *value);
        }
        let failed = record.quality.iter().filter(|check| !check.passed);
        let names: Vec<&str> = failed.map(|check| check.name.as_str()).collect();
        self.set("passed", "", ColumnKind::Boolean, Cell::Number(f64::from(u8::from(names.is_empty()))));
        self.count("checks_failed", names.len() as f64);
        self.word("failed_checks", &names.join(" "));
        for check in &record.quality {
            self.number(&format!("{CHECK}{}", check.name), "", check.value);
            self.number(&format!("{CHECK}{}{LIMIT}", check.name), "", check.limit);
        }
        for histograms in &stored.measured.histograms {
            if let Some(first) = histograms.states.first() {
                self.number(&format!("{}{BIN_WIDTH}", histograms.name), &histograms.unit, first.bin_width);
                self.count(&format!("{}{FIRST_BIN}", histograms.name), first.first_bin as f64);
                self.count(&format!("{}{BINS}", histograms.name), first.bins() as f64);
                self.word(&format!("{}{QUANTITY}", histograms.name), &histograms.quantity);
            }
        }
        self.word("case_digest", &record.case_digest);
        self.word("preparation_digest", &record.preparation_digest);
        self.word("digest", &stored.digest);
        self.word("granum_version", &record.granum_version);
        self.word("engine", &record.engine);
        self.word("engine_version", &record.engine_version);
        self.word(SETTINGS, &serde_json::to_string(&run.settings).unwrap_or_default());
    }

    /// What depends on the computer.
    pub fn seconds(&mut self, name: &str, stored: &StoredRun) {
        self.begin_row();
        self.word(RUN, name);
        let record = &stored.record;
        self.number("seconds", "s", record.wall_seconds.values().sum());
        for (phase, seconds) in &record.wall_seconds {
            self.number(&format!("seconds.{phase}"), "s", *seconds);
        }
        self.word("system", &record.machine.system);
        self.word("instruction_set", &record.machine.instruction_set);
        self.count("threads", record.machine.threads as f64);
    }

    /// The table: a number that a row does not have is NaN, a word empty. A column that has a word in some row holds words.
    pub fn finish(self) -> Result<Table> {
        let rows = self.rows;
        let column = |filling: Filling| {
            let Filling { name, unit, kind, cells } = filling;
            if cells.iter().any(|(_, cell)| matches!(cell, Cell::Word(_))) {
                let mut words = vec![String::new(); rows];
                for (row, cell) in cells {
                    words[row] = match cell {
                        Cell::Word(word) => word,
                        Cell::Number(number) => {
                            format!("{} {unit}", format_number(number)).trim_end().to_string()
                        }
                    };
                }
                return Column::of_words(name, words);
            }
            // Only real numbers can be missing.
            let kind = if cells.len() == rows { kind } else { ColumnKind::Real };
            let mut values = vec![f64::NAN; rows];
            for (row, cell) in cells {
                if let Cell::Number(number) = cell {
                    values[row] = number;
                }
            }
            Column::new(name, unit, values).of_kind(kind)
        };
        Ok(Table::new(self.columns.into_iter().map(column).collect())?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_may_have_different_columns() {
        let mut table = RowTable::default();
        table.begin_row();
        table.word("run", "a");
        table.number("x", "m", 1.0);
        table.count("n", 3.0);
        table.number("law", "Pa", 2.0);
        table.begin_row();
        table.word("run", "b");
        table.count("n", 4.0);
        table.word("law", "hertz");
        let table = table.finish().unwrap();
        assert_eq!(table.names().collect::<Vec<_>>(), ["run", "x", "n", "law"]);
        assert!(table.values("x").unwrap()[1].is_nan());
        assert_eq!(table.get("n").unwrap().kind, ColumnKind::Integer);
        assert_eq!(
            [table.get("law").unwrap().word(0), table.get("law").unwrap().word(1)],
            [Some("2 Pa"), Some("hertz")]
        );
    }
}
