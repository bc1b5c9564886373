//! `granum predict`: what the networks of a study answer.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use clap::Args;
use granum_core::names::nearest;
use granum_io::{Column, Table, check_output_file, read_columns, write_table};
use granum_learn::{RowAnswer, Surrogate, files::load_study};
use serde_json::json;

use super::trained_range::{inputs, short};
use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// Share of the states of unseen runs that intervals hold.
const LEVEL: f64 = 0.9;

/// Ask the networks of a study: one state by flags, or many from a table.
///
/// The inputs are those of a state of a test, whatever the form of the networks: deviator_strain, deviator_fabric, stress_ratio,
/// every bin of P(f) (probability_density_0.125, ...) where the mapping reads it, and force where P(f) is the answer. The
/// answer comes with the interval that holds 90 % of the states of unseen runs; of networks that were trained on a single
/// run it does not contain the scatter between samples. A row outside the range that a network was trained in is answered all the same, and said to be outside: do not trust
/// it. Without --set and --input the error lists the inputs with their ranges.
#[derive(Args)]
#[command(after_help = "Example:\n  granum predict study --mapping F4 --set deviator_strain=0.12 --set \
                  deviator_fabric=0.1 --set force=1.125\n  granum predict study --mapping F1 --input rows.csv -o answers.csv")]
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
        let answer = surrogate.predict(&row(surrogate, &self.values)?, LEVEL)?;
        let network = &surrogate.networks()[answer.sub_model];
        let output = surrogate.mapping().network_output();
        let range = surrogate.mapping().sub_models[answer.sub_model].strain_range;
        let outside =
            answer.outside.iter().map(|o| json!({ "input": o.name, "value": o.value, "range": o.range }));
        let result = json!({
            "mapping": self.mapping,
            "output": output,
            "value": answer.value,
            "standard_deviation": answer.standard_deviation,
            "level": LEVEL,
            "lower": answer.interval.map(|[lower, _]| lower),
            "upper": answer.interval.map(|[_, upper]| upper),
            "runs_of_interval": network.blocks(),
            "constant": network.is_constant(),
            "sub_model": answer.sub_model + 1,
            "strain_range": range,
            "outside": outside.collect::<Vec<_>>(),
        });
        output::say(context, &result, || {
            let interval = answer
                .interval
                .map_or(String::new(), |[lower, upper]| format!(", 90 % interval {lower:.6} to {upper:.6}"));
            let head = format!(
                "{output} = {:.6}{interval}  ({} sub-model {}, deviator strain {} to {})",
                answer.value,
                self.mapping,
                answer.sub_model + 1,
                range[0],
                range[1]
            );
            let mut lines = vec![head];
            lines.extend(remarks(surrogate, &[answer.sub_model]));
            lines.extend(outside_text(&answer));
            lines.join("\n")
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
        let (answers, outside, sub_models) = answer(surrogate, &table)?;
        let warning = format!(
            "{outside} of {} rows lie outside the trained range (column outside is 1): do not trust their answers",
            answers.rows()
        );
        if outside > 0 && !context.json {
            eprintln!("warning: {warning}");
        }
        if !context.json {
            remarks(surrogate, &sub_models).iter().for_each(|remark| eprintln!("note: {remark}"));
        }
        let Some(output) = &self.output else { return output::put_table(context, None, &answers) };
        write_table(output, &answers)?;
        let result = json!({
            "output": output,
            "rows": answers.rows(),
            "rows_outside": outside,
            "constant_sub_models": constants(surrogate, &sub_models),
        });
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

/// Numbers, from 1, of those of the sub-models whose networks learned a constant.
fn constants(surrogate: &Surrogate, sub_models: &[usize]) -> Vec<usize> {
    let networks = surrogate.networks();
    sub_models.iter().filter(|k| networks[**k].is_constant()).map(|k| k + 1).collect()
}

/// What there is to know about answers of these sub-models.
fn remarks(surrogate: &Surrogate, sub_models: &[usize]) -> Vec<String> {
    let name = &surrogate.mapping().name;
    let constant = constants(surrogate, sub_models).into_iter().map(|number| {
        format!("{name} sub-model {number}: this network learned a constant: it does not use its inputs.")
    });
    let mut remarks: Vec<String> = constant.collect();
    let asked = || sub_models.iter().map(|&k| &surrogate.networks()[k]);
    if asked().any(|network| network.training_fit().evidence.is_none()) {
        let trainer = &surrogate.networks()[0].provenance().trainer;
        remarks.push(format!(
            "There is no interval: networks trained by {trainer} do not know how sure they are."
        ));
    } else if let Some(runs) = asked().map(granum_nets::Model::blocks).min().flatten() {
        remarks.push(format!(
            "The interval contains the scatter between samples, judged by {runs} training runs."
        ));
    } else {
        remarks.push(
            "The interval does not contain the scatter between samples: the network was trained on one run, or cannot tell \
             runs apart."
                .into(),
        );
    }
    remarks
}

/// The inputs that lie outside, in words.
fn outside_text(answer: &RowAnswer) -> Option<String> {
    let each = answer.outside.iter().map(|outside| {
        let [low, high] = outside.range;
        format!("{} = {} (trained from {} to {})", outside.name, outside.value, short(low), short(high))
    });
    let all = each.collect::<Vec<_>>().join(", ");
    (!all.is_empty()).then(|| format!("OUTSIDE the trained range: {all}; do not trust this answer."))
}

/// The rows with their answers, how many of them lie outside, and the sub-models that answered.
fn answer(surrogate: &Surrogate, table: &Table) -> Result<(Table, usize, Vec<usize>), Failure> {
    let columns: Vec<&[f64]> = table.columns().iter().map(|column| column.values.as_slice()).collect();
    let rows: Vec<f64> =
        (0..table.rows()).flat_map(|row| columns.iter().map(move |column| column[row])).collect();
    let answers = surrogate.predict_rows(&rows, LEVEL)?;
    let beyond = answers.iter().filter(|answer| !answer.outside.is_empty()).count();
    let mut all = table.columns().to_vec();
    let mut add = |name: &str, value: &dyn Fn(&RowAnswer) -> f64| {
        all.push(Column::new(name, "", answers.iter().map(value).collect()));
    };
    add(&format!("predicted_{}", surrogate.mapping().network_output()), &|answer| answer.value);
    if answers.iter().any(|answer| answer.interval.is_some()) {
        add("standard_deviation", &|answer| answer.standard_deviation.unwrap_or(f64::NAN));
        add("lower", &|answer| answer.interval.map_or(f64::NAN, |[lower, _]| lower));
        add("upper", &|answer| answer.interval.map_or(f64::NAN, |[_, upper]| upper));
    }
    add("sub_model", &|answer| (answer.sub_model + 1) as f64);
    add("outside", &|answer| f64::from(u8::from(!answer.outside.is_empty())));
    let sub_models: BTreeSet<usize> = answers.iter().map(|answer| answer.sub_model).collect();
    Ok((Table::new(all)?, beyond, sub_models.into_iter().collect()))
}
