//! `granum predict`: what the networks of a study answer.

use std::path::{Path, PathBuf};

use clap::Args;
use granum_hybrid::{HybridError, Surrogate, files::load_study};
use granum_io::{Column, Table, check_output_file, nearest, read_columns, write_table};
use serde_json::json;

use super::trained_range::inputs;
use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// Ask the networks of a study: one row of inputs by flags, or many from a table.
///
/// A row outside the range that a network was trained in is answered all the same, and said to be outside: do not trust
/// it. Without --set and --input the error lists the inputs with their ranges.
#[derive(Args)]
#[command(
    after_help = "Example:\n  granum predict study --mapping F1 --set deviator_strain=0.12 --set force=1.125 --set \
                  probability_density=0.3\n  granum predict study --mapping F2 --input rows.csv -o answers.csv"
)]
pub struct Predict {
    /// Folder of the study that `granum train` left (or `models` of a reproduction).
    study: PathBuf,
    /// Mapping to ask, F1 to F6.
    #[arg(short, long, value_name = "NAME")]
    mapping: String,
    /// One input of the row; give every input once.
    #[arg(short = 's', long = "set", value_name = "INPUT=VALUE", conflicts_with = "input")]
    values: Vec<String>,
    /// Table of rows (CSV or Parquet) with a column for every input; other columns are passed over.
    #[arg(short, long, value_name = "FILE")]
    input: Option<PathBuf>,
    /// Where to write the answers (CSV or Parquet by extension); the standard output by default.
    #[arg(short, long, value_name = "FILE", requires = "input")]
    output: Option<PathBuf>,
}

impl Predict {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        let study = load_study(&self.study)?;
        let surrogate = &study.mapping(&self.mapping)?.surrogate;
        match &self.input {
            Some(path) => self.many(context, surrogate, path),
            None => self.one(context, surrogate),
        }
    }

    fn one(&self, context: &Context, surrogate: &Surrogate) -> Result<(), Failure> {
        let answer = surrogate.predict(&row(surrogate, &self.values)?)?;
        let output = surrogate.mapping().network_output();
        let range = surrogate.mapping().sub_models[answer.sub_model].strain_range;
        let result = json!({
            "mapping": self.mapping,
            "output": output,
            "value": answer.value,
            "standard_deviation": answer.standard_deviation,
            "sub_model": answer.sub_model + 1,
            "strain_range": range,
            "outside": answer.outside,
        });
        output::say(context, &result, || {
            let deviation = answer.standard_deviation.map_or(String::new(), |d| format!(" +- {d:.2e}"));
            let mut text = format!(
                "{output} = {:.6}{deviation}  ({} sub-model {}, deviator strain {} to {})",
                answer.value,
                self.mapping,
                answer.sub_model + 1,
                range[0],
                range[1]
            );
            if !answer.outside.is_empty() {
                text += &format!(
                    "\nOUTSIDE the trained range: {}; do not trust this answer. {} was trained on:\n{}",
                    answer.outside.join(", "),
                    self.mapping,
                    inputs(surrogate, Some(answer.sub_model))
                );
            }
            text
        })
    }

    fn many(&self, context: &Context, surrogate: &Surrogate, path: &Path) -> Result<(), Failure> {
        if let Some(output) = &self.output {
            check_output_file(output, context.force)?;
        }
        let names = surrogate.input_names();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let table = read_columns(path, &names)?;
        check_finite(path, &table)?;
        let (answers, outside) = answer(surrogate, &table)?;
        let warning = format!(
            "{outside} of {} rows lie outside the trained range (column outside is 1): do not trust their answers",
            answers.rows()
        );
        if outside > 0 && !context.json {
            eprintln!("warning: {warning}");
        }
        let Some(output) = &self.output else { return output::put_table(context, None, &answers) };
        write_table(output, &answers)?;
        let result = json!({ "output": output, "rows": answers.rows(), "rows_outside": outside });
        output::say(context, &result, || format!("wrote {} rows to {}", answers.rows(), output.display()))
    }
}

/// The row that `--set` flags give, in the order of the network's inputs.
fn row(surrogate: &Surrogate, flags: &[String]) -> Result<Vec<f64>, Failure> {
    let names = surrogate.input_names();
    let needs = || format!("{} needs:\n{}", surrogate.mapping().formula(), inputs(surrogate, None));
    let mut row = vec![None; names.len()];
    for flag in flags {
        let (name, text) = flag
            .split_once('=')
            .ok_or_else(|| Failure::new(format!("--set {flag}: write it as INPUT=VALUE\n{}", needs())))?;
        let k = names.iter().position(|known| known == name.trim()).ok_or_else(|| {
            let near = nearest(name.trim(), names.iter().map(String::as_str));
            let hint = near.map_or(String::new(), |near| format!("; did you mean {near}?"));
            Failure::new(format!("--set {flag}: there is no such input{hint}\n{}", needs()))
        })?;
        let value =
            text.trim().parse::<f64>().ok().filter(|value| value.is_finite()).ok_or_else(|| {
                Failure::new(format!("--set {flag}: {:?} is not a finite number", text.trim()))
            })?;
        if row[k].replace(value).is_some() {
            return Err(Failure::new(format!("--set {flag}: {} is given twice", names[k])));
        }
    }
    let missing: Vec<&str> =
        names.iter().zip(&row).filter(|(_, v)| v.is_none()).map(|(name, _)| name.as_str()).collect();
    if !missing.is_empty() {
        let example = missing.first().map_or(String::new(), |name| format!(" (as --set {name}=VALUE)"));
        return Err(Failure::new(format!("missing: {}{example}\n{}", missing.join(", "), needs())));
    }
    Ok(row.into_iter().flatten().collect())
}

fn check_finite(path: &Path, table: &Table) -> Result<(), Failure> {
    for column in table.columns() {
        if let Some(k) = column.values.iter().position(|value| !value.is_finite()) {
            let (name, value) = (&column.name, column.values[k]);
            return Err(Failure::new(format!(
                "{}: data row {}: {name} is {value}, not a finite number",
                path.display(),
                k + 1
            )));
        }
    }
    Ok(())
}

/// The rows with their answers, and how many of them lie outside.
fn answer(surrogate: &Surrogate, table: &Table) -> Result<(Table, usize), Failure> {
    let mapping = surrogate.mapping();
    let columns: Vec<&[f64]> = table.columns().iter().map(|column| column.values.as_slice()).collect();
    let count = table.rows();
    let at: Vec<(usize, bool)> = (0..count).map(|row| mapping.sub_model_at(columns[0][row])).collect();
    let mut values = vec![0.0; count];
    let mut deviations = vec![f64::NAN; count];
    let mut outside = vec![0.0; count];
    for (k, network) in surrogate.networks().iter().enumerate() {
        let own: Vec<usize> = (0..count).filter(|&row| at[row].0 == k).collect();
        if own.is_empty() {
            continue;
        }
        let rows: Vec<f64> =
            own.iter().flat_map(|&row| columns.iter().map(move |column| column[row])).collect();
        let failed = |error: granum_nets::ModelError| HybridError::Network {
            network: format!("{} sub-model {}", mapping.name, k + 1),
            reason: error.to_string(),
        };
        let batch = network.predict_batch(&rows).map_err(failed)?;
        let spread = network.standard_deviations(&rows).map_err(failed)?;
        for (place, &row) in own.iter().enumerate() {
            values[row] = batch.values[place];
            outside[row] = f64::from(u8::from(batch.outside[place] || !at[row].1));
            if let Some(spread) = &spread {
                deviations[row] = spread[place];
            }
        }
    }
    let beyond = outside.iter().filter(|&&flag| flag > 0.0).count();
    let mut all = table.columns().to_vec();
    all.push(Column::new(format!("predicted_{}", mapping.network_output()), "", values));
    if deviations.iter().any(|deviation| !deviation.is_nan()) {
        all.push(Column::new("standard_deviation", "", deviations));
    }
    all.push(Column::new("sub_model", "", at.iter().map(|(k, _)| (k + 1) as f64).collect()));
    all.push(Column::new("outside", "", outside));
    Ok((Table::new(all)?, beyond))
}
