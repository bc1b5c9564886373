//! Error on unseen runs as a function of the number of training runs, for networks and baselines.
//!
//! ```text
//! cargo run --release -p granum-antony2006 --example judge -- --runs run-1 run-2 ... [--training 1 2 4 8 16] [--sets 4]
//!     [--form point histogram] [--mappings F1 F3]
//! ```
//!
//! From the given runs, `sets` different groups of each size are used for training, and each is evaluated on all runs
//! outside the group, with all baselines of `granum evaluate`. For each form and number of training runs a table is
//! printed, in per cent: the relative RMSE, averaged over groups and evaluation runs, of the networks, of strain-only
//! networks, of ridge regression on the same sensors, of ridge regression on strain alone and of the mean curve; then the
//! differences between the networks and the strain-only networks, and between the networks and ridge regression, with
//! their standard errors (negative if the networks are better). The standard error combines, as a root of the sum of
//! squares, the scatter of the mean over groups and that over evaluation runs.

use std::error::Error;

use granum_antony2006::evaluation::score_run;
use granum_antony2006::{Mapping, PaperData, PaperDataOptions, PaperOptions, paper_mappings};
use granum_learn::NamedRecord;
use granum_learn::networks::Form;
use granum_learn::study::NoStudyObserver;
use granum_sensors::Record;

/// Number of predictors that are compared, in the order of the table.
const KINDS: usize = 5;
type Errors = [f64; KINDS];
type Failure = Box<dyn Error>;

struct Wishes {
    runs: Vec<String>,
    training: Vec<usize>,
    sets: usize,
    forms: Vec<Form>,
    mappings: Vec<Mapping>,
}

fn main() -> Result<(), Failure> {
    let wishes = wishes()?;
    let open = |folder: &String| {
        Ok((folder.clone(), granum_run::record::read_record(&granum_io::Run::at(folder)?)?))
    };
    let runs: Vec<(String, Record)> = wishes.runs.iter().map(open).collect::<Result<_, Failure>>()?;
    for &form in &wishes.forms {
        for &count in &wishes.training {
            judge(&runs, &wishes, form, count)?;
        }
    }
    Ok(())
}

/// Trains on groups of so many runs and prints the table of results.
fn judge(runs: &[(String, Record)], wishes: &Wishes, form: Form, count: usize) -> Result<(), Failure> {
    let mappings = &wishes.mappings;
    // errors[mapping][group][run]
    let mut errors = vec![vec![vec![None; runs.len()]; wishes.sets]; mappings.len()];
    for group in 0..wishes.sets {
        let first = group * runs.len() / wishes.sets;
        let trains = |k: usize| (k + runs.len() - first) % runs.len() < count;
        let chosen = |wanted: bool| -> Vec<NamedRecord> {
            let some = (0..runs.len()).filter(|&k| trains(k) == wanted);
            some.map(|k| NamedRecord { name: &runs[k].0, seed: 0, record: &runs[k].1 }).collect()
        };
        let data = PaperData::from_records(&chosen(true), &chosen(false), &PaperDataOptions::default())?;
        let options = PaperOptions { form, mappings: mappings.clone(), ..PaperOptions::default() };
        let study = options.train(&data, &NoStudyObserver)?;
        let judging = (0..runs.len()).filter(|&k| !trains(k));
        for (k, run) in judging.zip(data.parts.unseen.runs()) {
            for (m, score) in score_run(&study, run)?.into_iter().enumerate() {
                let baselines = [score.ridge, score.ridge_strain_only, score.mean_curve];
                let [a, b, c] = baselines.map(|score| score.map_or(f64::NAN, |s| s.relative_rmse));
                errors[m][group][k] =
                    Some([score.network.relative_rmse, score.strain_only.relative_rmse, a, b, c]);
            }
        }
    }
    println!("{form:?} form, {count} training runs, {} groups", wishes.sets);
    println!("    network  strain only  ridge  ridge on strain  mean curve | minus strain only  minus ridge");
    for (mapping, errors) in mappings.iter().zip(&errors) {
        let of = |kind: usize| 100.0 * estimate(errors, &|e| e[kind]).0;
        let values: Vec<String> = (0..KINDS).map(|kind| format!("{:5.2}", of(kind))).collect();
        let difference = |kind: usize| {
            let (mean, error) = estimate(errors, &|e| e[0] - e[kind]);
            format!("{:+5.2} ± {:.2}", 100.0 * mean, 100.0 * error)
        };
        println!("{}  {} | {}  {}", mapping.name, values.join("  "), difference(1), difference(2));
    }
    Ok(())
}

/// Mean over groups and runs, with its standard error.
fn estimate(errors: &[Vec<Option<Errors>>], value: &dyn Fn(&Errors) -> f64) -> (f64, f64) {
    let runs = errors.first().map_or(0, Vec::len);
    let average = |some: Vec<&Errors>| -> Option<f64> {
        let count = some.len() as f64;
        (!some.is_empty()).then(|| some.into_iter().map(value).sum::<f64>() / count)
    };
    let by_group: Vec<f64> =
        errors.iter().filter_map(|group| average(group.iter().flatten().collect())).collect();
    let by_run: Vec<f64> = (0..runs)
        .filter_map(|run| average(errors.iter().filter_map(|group| group[run].as_ref()).collect()))
        .collect();
    let (mean, over_groups) = mean_and_error(&by_group);
    let (_, over_runs) = mean_and_error(&by_run);
    (mean, over_groups.hypot(over_runs))
}

/// Mean with its standard error, which is zero for a single value.
fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
    (mean, if values.len() > 1 { (squares / (n - 1.0) / n).sqrt() } else { 0.0 })
}

fn wishes() -> Result<Wishes, Failure> {
    let usage = "write --runs A B C ... [--training 1 2 4 ...] [--sets N] [--form point histogram] [--mappings F1 ...]";
    let mut wishes = Wishes { runs: vec![], training: vec![], sets: 4, forms: vec![], mappings: vec![] };
    let mut key = String::new();
    for word in std::env::args().skip(1) {
        match (key.as_str(), word.as_str()) {
            (_, "--runs" | "--training" | "--sets" | "--form" | "--mappings") => key = word,
            ("--runs", _) => wishes.runs.push(word),
            ("--training", _) => wishes.training.push(word.parse()?),
            ("--sets", _) => wishes.sets = word.parse()?,
            ("--form", "point") => wishes.forms.push(Form::Point),
            ("--form", "histogram") => wishes.forms.push(Form::Histogram),
            ("--mappings", _) => wishes.mappings.push(granum_antony2006::mapping::paper_mapping(&word)?),
            _ => return Err(format!("{word}: {usage}").into()),
        }
    }
    if wishes.mappings.is_empty() {
        wishes.mappings = paper_mappings();
    }
    if wishes.forms.is_empty() {
        wishes.forms = vec![Form::Point, Form::Histogram];
    }
    if wishes.training.is_empty() {
        wishes.training = [1, 2, 4, 8, 16].into_iter().filter(|&n| n + 2 <= wishes.runs.len()).collect();
    }
    let most = wishes.training.iter().max().copied().unwrap_or(0);
    if wishes.training.contains(&0) || most + 2 > wishes.runs.len() || wishes.sets == 0 {
        let found = wishes.runs.len();
        return Err(format!("{found} runs: {usage}, with two runs or more left to judge by").into());
    }
    Ok(wishes)
}
