//! Reads a data set back, with the case and the record of each of its runs.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use granum_dem::config::RecordedColumns;
use granum_io::formats::parquet::{ListColumn, TableWithLists, read_with_lists};
use granum_io::run::file_digest;
use granum_io::shell::ShowPath;
use granum_io::{
    Case, Column, ColumnKind, Error, QualityFlag, Reading, Result, RunKind, RunRecord, RunStatus, Table,
};
use granum_io::{formats, run};
use granum_run::derived_columns::density_name;
use granum_sensors::{Histogram, Histograms, Record};

use super::layout::{
    BIN_WIDTH, CASE_FILE, CHECK, COUNTED, DATA_SET, FIRST_BIN, LIMIT, MEASURE, QUANTITY, RUN, RUNS_FILE,
    SETTINGS, STATES_FILE, SUMS,
};
use crate::plan::apply_settings;

/// A data set, read from its folder.
#[derive(Clone, Debug)]
pub struct DataSet {
    folder: PathBuf,
    base: Case,
    /// A row for each run.
    pub runs: Table,
    /// A row for each state.
    pub states: TableWithLists,
}

/// A run of a data set.
#[derive(Clone, Debug, PartialEq)]
pub struct DataSetRun {
    /// Its name.
    pub name: String,
    /// Its case.
    pub case: Case,
    /// Its record, as far as the data set has it: identity, measures, checks.
    pub record: RunRecord,
    /// Digest of its results.
    pub digest: String,
    /// Its measurements.
    pub measured: Record,
}

impl DataSet {
    /// True if a folder holds a data set.
    pub fn is_in(folder: &Path) -> bool {
        folder.join(RUNS_FILE).is_file()
            && folder.join(STATES_FILE).is_file()
            && folder.join(CASE_FILE).is_file()
    }

    /// The folder of the data set that is meant by the folder of a campaign or a data set; `None` for any other folder.
    ///
    /// # Errors
    /// If it is a campaign without a data set.
    pub fn meant_by(folder: &Path) -> Result<Option<PathBuf>> {
        if DataSet::is_in(folder) {
            return Ok(Some(folder.to_path_buf()));
        }
        if !folder.join(crate::campaign::CAMPAIGN_FILE).is_file() {
            return Ok(None);
        }
        let inside = folder.join(DATA_SET);
        if DataSet::is_in(&inside) {
            return Ok(Some(inside));
        }
        let message = "the campaign has no data set yet; it is written when all runs are finished, and of those that are finished by \
                       `granum campaign PLAN --collect`. A run that did not pass its checks is part of it only if `accept` of the \
                       plan says so (`granum campaign status` lists these)";
        Err(Error::content(folder, message))
    }

    /// Reads a data set, whose files are compared with its sums.
    ///
    /// # Errors
    /// If a file is missing, changed or damaged, or the data set was not written to its end.
    pub fn read(folder: &Path, reading: Reading) -> Result<DataSet> {
        check_sums(folder)?;
        let path = folder.join(CASE_FILE);
        let base = Case::read_as(&path, reading)?;
        let runs = formats::parquet::read_with_words(&folder.join(RUNS_FILE), None)?;
        let states = read_with_lists(&folder.join(STATES_FILE))?;
        Ok(DataSet { folder: folder.to_path_buf(), base, runs, states })
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The runs with their cases and records, as they were in their folders.
    ///
    /// # Errors
    /// If the files do not fit together.
    pub fn each_run(&self) -> Result<Vec<DataSetRun>> {
        let wrong = |name: &str, why: &str| Error::content(&self.folder.join(name), why.to_string());
        let names = self.runs.get(RUN).filter(|column| column.has_words());
        let names = names.ok_or_else(|| wrong(RUNS_FILE, "has no column run of words"))?;
        let states = self.states.table.get(RUN).filter(|column| column.has_words());
        let states = states.ok_or_else(|| wrong(STATES_FILE, "has no column run of words"))?;
        let mut rows: BTreeMap<&str, (usize, usize)> = BTreeMap::new();
        for row in 0..self.states.table.rows() {
            let name = states.word(row).unwrap_or_default();
            let range = rows.entry(name).or_insert((row, row));
            if range.1 != row {
                return Err(wrong(STATES_FILE, "does not have the states of a run below each other"));
            }
            range.1 = row + 1;
        }
        let starts = ListStarts::new(&self.states.lists);
        let run = |row: usize| {
            let name = names.word(row).unwrap_or_default();
            let (start, end) = rows.get(name).copied().unwrap_or_default();
            self.run(row, name, start..end, &starts)
        };
        (0..self.runs.rows()).map(run).collect()
    }

    fn run(
        &self,
        row: usize,
        name: &str,
        rows: std::ops::Range<usize>,
        starts: &ListStarts,
    ) -> Result<DataSetRun> {
        let path = self.folder.join(RUNS_FILE);
        let wrong = |why: String| Error::content(&path, format!("run {name}: {why}"));
        let word =
            |column: &str| self.runs.get(column).and_then(|column| column.word(row)).unwrap_or_default();
        let number = |column: &str| {
            self.runs.values(column).map(|values| values[row]).filter(|value| value.is_finite())
        };
        let settings: Vec<(String, String)> = serde_json::from_str(word(SETTINGS))
            .map_err(|error| wrong(format!("its settings cannot be read: {error}")))?;
        let case = apply_settings(&self.base, &settings)?;
        if case.digest() != word("case_digest") {
            return Err(wrong("its case is not that of case.toml with its settings".into()));
        }
        let count = number("states").unwrap_or_default();
        if rows.len() as f64 != count {
            return Err(wrong(format!("it has {count} states, and {} are in {STATES_FILE}", rows.len())));
        }
        let measured = self.measured(&case, row, rows, starts)?;
        let mut record = RunRecord {
            format: run::RUN_FORMAT,
            granum_version: word("granum_version").into(),
            kind: RunKind::Test,
            status: RunStatus::Finished,
            engine: word("engine").into(),
            engine_version: word("engine_version").into(),
            // All of its digits are in the case; samples from a packing have none.
            seed: number("seed").map(|_| case.preparation.seed),
            case_digest: word("case_digest").into(),
            preparation_digest: word("preparation_digest").into(),
            grains: number("grains").unwrap_or_default() as usize,
            ..RunRecord::default()
        };
        for column in self.runs.columns().iter().filter(|column| !column.has_words()) {
            let value = column.values[row];
            if let Some(check) = column.name.strip_prefix(CHECK).filter(|check| !check.ends_with(LIMIT)) {
                if let Some(limit) = number(&format!("{CHECK}{check}{LIMIT}")) {
                    record.quality.push(QualityFlag::at_most(check, value, limit, ""));
                }
            } else if let Some(measure) = column.name.strip_prefix(MEASURE).filter(|_| value.is_finite()) {
                record.measures.insert(measure.to_string(), value);
            }
        }
        Ok(DataSetRun { name: name.to_string(), case, record, digest: word("digest").into(), measured })
    }

    /// The record of a run.
    fn measured(
        &self,
        case: &Case,
        row: usize,
        rows: std::ops::Range<usize>,
        starts: &ListStarts,
    ) -> Result<Record> {
        let numbers_stages = case.test_definition().columns == RecordedColumns::All;
        let is_counted = |name: &str| name.ends_with(COUNTED);
        let mut columns = Vec::new();
        for column in self.states.table.columns().iter().filter(|column| !column.has_words()) {
            let values = &column.values[rows.clone()];
            let is_absent = values.iter().all(|value| value.is_nan());
            if is_absent || is_counted(&column.name) || (column.name == "stage" && !numbers_stages) {
                continue;
            }
            columns.push(Column::new(&column.name, &column.unit, values.to_vec()).of_kind(ColumnKind::Real));
        }
        let mut histograms = Vec::new();
        for name in self.states.table.names().filter_map(|name| name.strip_suffix(COUNTED)) {
            histograms.extend(self.histograms(name, row, rows.clone(), starts));
        }
        Ok(Record { series: Table::new(columns)?, histograms })
    }

    /// The histograms of a name; `None` if the run has none. Counts follow from the densities, whose bits they give again.
    fn histograms(
        &self,
        name: &str,
        row: usize,
        rows: std::ops::Range<usize>,
        starts: &ListStarts,
    ) -> Option<Histograms> {
        let of_run = |end: &str| self.runs.values(&format!("{name}{end}")).map(|values| values[row]);
        let (bin_width, first_bin) = (of_run(BIN_WIDTH)?, of_run(FIRST_BIN)?);
        if !bin_width.is_finite() {
            return None;
        }
        let of_state = |end: &str| self.states.table.values(&format!("{name}{end}"));
        let (totals, below, above) = (of_state(COUNTED)?, of_state("_below")?, of_state("_above")?);
        let quantity = self.runs.get(&format!("{name}{QUANTITY}"))?.word(row)?.to_string();
        let unit = self.runs.get(&format!("{name}{BIN_WIDTH}"))?.unit.clone();
        let list = self.states.lists.iter().position(|list| list.name == density_name(name))?;
        let states = rows.map(|state| {
            let counts = starts.list(&self.states.lists, list, state).iter();
            let counts =
                counts.map(|density| libm::round(density * bin_width * totals[state]) as u64).collect();
            let (below, above) = (below[state] as u64, above[state] as u64);
            Histogram { bin_width, first_bin: first_bin as i64, counts, below, above }
        });
        Some(Histograms { name: name.to_string(), quantity, unit, states: states.collect() })
    }
}

/// Where the list of each row begins.
struct ListStarts(Vec<Vec<usize>>);

impl ListStarts {
    fn new(lists: &[ListColumn]) -> ListStarts {
        let starts = |list: &ListColumn| {
            let mut at = 0;
            let mut all = Vec::with_capacity(list.lengths.len());
            for length in &list.lengths {
                all.push(at);
                at += length;
            }
            all
        };
        ListStarts(lists.iter().map(starts).collect())
    }

    fn list<'a>(&self, lists: &'a [ListColumn], list: usize, row: usize) -> &'a [f64] {
        let start = self.0[list][row];
        &lists[list].values[start..start + lists[list].lengths[row]]
    }
}

/// Compares the files of a data set with its sums.
fn check_sums(folder: &Path) -> Result<()> {
    let path = folder.join(SUMS);
    if !path.is_file() {
        let message = format!(
            "the data set was not written to its end: it has no {SUMS}; give the command of its campaign again, or `granum campaign PLAN \
             --collect`"
        );
        return Err(Error::content(folder, message));
    }
    let text = granum_core::input::read_text(&path, 1 << 20).map_err(Error::file("read", &path))?;
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let Some((sum, name)) = line.split_once("  ") else {
            return Err(Error::content(&path, format!("{line:?} is not a sum with the name of a file")));
        };
        if name.contains(['/', '\\']) {
            return Err(Error::content(&path, format!("{name:?} is no file of a data set")));
        }
        let file = folder.join(name);
        if !file.is_file() {
            return Err(Error::content(
                &file,
                format!("is missing, and {SUMS} names it; copy data sets with all of their files"),
            ));
        }
        if file_digest(&file)? != sum {
            let message = format!("was changed or damaged: its SHA-256 is not that of {}", path.shown());
            return Err(Error::content(&file, message));
        }
    }
    Ok(())
}
