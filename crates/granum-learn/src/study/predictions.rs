//! The predictions of a study for its unseen runs, as one table.

use granum_core::{Column, Table};

use super::training::Study;
use crate::dataset::Dataset;
use crate::error::Result;
use crate::surrogate::{Estimate, Interval, RunInputs};

/// The predictions of all surrogates for the unseen runs of a data set: the number of the run (from 1), `stage`, `state`, the
/// inputs and outputs of all fits, and for each output and surrogate `predicted_OUTPUT_by_NAME`, with `lower_` and `upper_` if
/// there is an interval (NaN where there is none).
///
/// # Errors
/// If a column is missing or a state cannot be predicted.
pub fn predictions(study: &Study, unseen: &Dataset) -> Result<Table> {
    let numbers = unseen.run_of_rows().iter().map(|run| (run + 1) as f64).collect();
    let mut columns = vec![Column::new("run", "", numbers)];
    let mut measured: Vec<String> = vec!["stage".into(), "state".into()];
    for fit in &study.fits {
        let own = fit.spec.columns(unseen)?;
        measured.extend(own.input_names().into_iter().chain(own.output_names()));
    }
    for (k, name) in measured.iter().enumerate() {
        if !measured[..k].contains(name) {
            columns.push(Column::new(name, &unseen.variable(name)?.unit, unseen.column(name)?));
        }
    }
    for member in study.members() {
        let surrogate = member.surrogate.as_ref();
        let inputs = RunInputs::from_dataset(unseen, surrogate.columns())?;
        let predictions = surrogate.predict(&inputs, study.definition.level)?;
        for (k, output) in surrogate.columns().outputs.iter().enumerate() {
            let mut add = |word: &str, value: &dyn Fn(&Estimate) -> f64| {
                let name = format!("{word}_{}_by_{}", output.name, member.name);
                let values = predictions.iter().map(|prediction| value(&prediction.values[k])).collect();
                columns.push(Column::new(name, &output.unit, values));
            };
            add("predicted", &|estimate| estimate.mean);
            if predictions.iter().any(|prediction| prediction.values[k].interval.is_some()) {
                let end = |estimate: &Estimate, end: fn(&Interval) -> f64| {
                    estimate.interval.as_ref().map_or(f64::NAN, end)
                };
                add("lower", &|estimate| end(estimate, |interval| interval.lower));
                add("upper", &|estimate| end(estimate, |interval| interval.upper));
            }
        }
    }
    Ok(Table::new(columns)?)
}
