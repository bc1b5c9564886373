//! Predictions for whole tables.

use granum_core::{Column, Table};

use crate::dataset::Category;
use crate::error::{LearnError, Result};
use crate::surrogate::{Estimate, Prediction, RunInputs, Surrogate, check_finite};

/// The column of a table with the number of the run of each row.
pub const RUN: &str = "run";

/// Predicts every row of a table. A category among the inputs (`contact.normal`) is a column of words. The rows are the states of one run; if there is a column `run`, a run starts wherever its
/// value changes. The result has the inputs of the surrogate, then for each output `predicted_NAME`,
/// followed by `standard_deviation_NAME`, `lower_NAME` and `upper_NAME` if the surrogate provides them (NaN for rows
/// without them), and last `outside`, which is 1 if an input is outside the trained range.
///
/// ```
/// use granum_core::observer::NoObserver;
/// use granum_core::{Column, Table};
/// use granum_learn::{Dataset, FitSpec, RunStates, SurrogateMethods, inference};
///
/// let x: Vec<f64> = (0..20).map(f64::from).collect();
/// let y = x.iter().map(|x| 3.0 * x).collect();
/// let table = Table::new(vec![Column::new("x", "", x), Column::new("y", "", y)])?;
/// let dataset = Dataset::new(vec![RunStates::new("run", table)?])?;
/// let methods = SurrogateMethods::standard();
/// let spec = FitSpec::new(["x"], ["y"]).with_coordinate("x");
/// let ridge = methods.by_name("ridge")?.fit(&dataset, &spec, &mut NoObserver)?;
///
/// let asked = Table::new(vec![Column::new("x", "", vec![4.5, 40.0])])?;
/// let predictions = inference::predict_table(ridge.as_ref(), &asked, 0.9)?;
/// assert!((predictions.column("predicted_y")?[0] - 13.5).abs() < 0.1);
/// assert_eq!(predictions.column("outside")?, [0.0, 1.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If a column is missing, an answer is not a finite number, and as [`Surrogate::predict`].
pub fn predict_table(surrogate: &dyn Surrogate, table: &Table, level: f64) -> Result<Table> {
    let columns = surrogate.columns();
    let categories = columns.categories();
    let table = &with_columns_of_words(table, &categories)?;
    let inputs = chosen(table, &columns.input_names())?;
    let rows = run_inputs(table, &inputs)?;
    let predictions = surrogate.predict(&rows, level)?;
    check_finite(surrogate.method(), columns, &rows, &predictions)?;
    // What was given as words is shown as words.
    let words = categories.iter().filter_map(|category| table.get(&category.name));
    let mut all: Vec<Column> = words.cloned().collect();
    let is_shown = |column: &&Column| !all.iter().any(|words| is_word_of(&column.name, &words.name));
    let others: Vec<Column> = inputs.columns().iter().filter(is_shown).cloned().collect();
    all.extend(others);
    for (k, output) in columns.outputs.iter().enumerate() {
        let mut add = |prefix: &str, value: &dyn Fn(&Estimate) -> f64| {
            let values = predictions.iter().map(|prediction| value(&prediction.values[k])).collect();
            all.push(Column::new(format!("{prefix}_{}", output.name), &output.unit, values));
        };
        add("predicted", &|estimate| estimate.mean);
        if predictions.iter().any(|prediction| prediction.values[k].interval.is_some()) {
            let of = |estimate: &Estimate, value: &dyn Fn(&crate::surrogate::Interval) -> f64| {
                estimate.interval.as_ref().map_or(f64::NAN, value)
            };
            add("standard_deviation", &|estimate| of(estimate, &|interval| interval.standard_deviation()));
            add("lower", &|estimate| of(estimate, &|interval| interval.lower));
            add("upper", &|estimate| of(estimate, &|interval| interval.upper));
        }
    }
    let outside = |prediction: &Prediction| f64::from(u8::from(prediction.is_extrapolated()));
    all.push(Column::new("outside", "", predictions.iter().map(outside).collect()));
    Ok(Table::new(all)?)
}

/// True for the column of a word of a category.
fn is_word_of(column: &str, category: &str) -> bool {
    Category::parts(column).is_some_and(|(name, _)| name == category)
}

/// The table with a column of zeros and ones for each word of the categories that it has as columns of words.
fn with_columns_of_words(table: &Table, categories: &[Category]) -> Result<Table> {
    let mut table = table.clone();
    for category in categories {
        let Some(given) = table.get(&category.name).filter(|column| column.has_words()).cloned() else {
            continue;
        };
        for row in 0..table.rows() {
            let word = given.word(row).unwrap_or_default();
            if !category.words.iter().any(|known| known == word) {
                let (name, known) = (&category.name, category.list());
                return Err(LearnError::Rows(format!(
                    "row {}: {name} is {word:?}; the surrogate was fitted to {known}",
                    row + 1
                )));
            }
        }
        for (word, name) in category.words.iter().zip(category.columns()) {
            let is_it = |row: usize| f64::from(u8::from(given.word(row) == Some(word)));
            table.set(Column::new(name, "", (0..table.rows()).map(is_it).collect()))?;
        }
    }
    Ok(table)
}

/// The rows of the inputs, divided into runs by the column `run` of the table.
fn run_inputs(table: &Table, inputs: &Table) -> Result<RunInputs> {
    let lengths = match table.values(RUN) {
        _ if inputs.rows() == 0 => Vec::new(),
        Some(runs) => runs.chunk_by(|a, b| a.to_bits() == b.to_bits()).map(<[f64]>::len).collect(),
        None => vec![inputs.rows()],
    };
    RunInputs::new(rows_of(inputs), inputs.columns().len(), lengths)
}

/// The columns with the given names, in this order.
///
/// # Errors
/// If a column is missing.
pub fn chosen(table: &Table, names: &[String]) -> Result<Table> {
    let mut columns = Vec::with_capacity(names.len());
    for name in names {
        table.column(name)?;
        columns.extend(table.columns().iter().filter(|column| column.name == *name).cloned());
    }
    Ok(Table::new(columns)?)
}

/// The values of a table in row-major order.
pub fn rows_of(table: &Table) -> Vec<f64> {
    let columns: Vec<&[f64]> = table.columns().iter().map(|column| column.values.as_slice()).collect();
    (0..table.rows()).flat_map(|row| columns.iter().map(move |column| column[row])).collect()
}
