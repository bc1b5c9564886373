//! Judges surrogates of whole tests on unseen parameter points with replicates: errors in units of the scatter of single runs, and how many
//! states and curves intervals hold.
//!
//! ```sh
//! cargo run --release -p granum --example judge_curves -- TRAINING UNSEEN 24 48 96 all
//! ```
//!
//! `TRAINING` and `UNSEEN` are folders of campaigns or of data sets, several of them separated by commas. For each number of runs the first so many are fitted;
//! `24x20` fits twenty sets of 24 runs, one after another in the training runs, and prints the root of the mean of their squared errors (`mean`) with its standard error
//! over the sets, and the error of each; then the same for the error on the single runs of all the other materials of `TRAINING` (`others`), of which there are more,
//! and the share of their states that intervals of 90 % hold (`held`), on average over the sets with its standard error.
//! `run` is the root mean square error over single unseen runs, each predicted for its own sample; `mean` that of the prediction for the
//! mean sample of a point against the mean of its replicates, less what that mean scatters itself, with its standard error over the points.
//! Both are divided by the standard deviation between replicates, pooled over points and states. `noise` is what the surrogate says
//! of this standard deviation. A histogram is judged over all of its bins.

use std::any::Any;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use granum_campaign::data_set::DataSet;
use granum_core::observer::NoObserver;
use granum_learn::curve::interpolated;
use granum_learn::surrogate::{Cause, FittedCurves, RunInputs, Surrogate};
use granum_learn::{Dataset, FitSpec, Prediction, RunStates, SurrogateMethods};

const COORDINATE: &str = "axial_strain";
const OUTPUTS: [&str; 6] = [
    "stress_ratio",
    "volumetric_strain",
    "deviator_fabric",
    "mechanical_coordination_number",
    "sliding_fraction",
    "probability_density",
];
const INPUTS: [&str; 8] = [
    "axial_strain",
    "grains.material.friction",
    "contact.rolling_friction",
    "preparation.mean_stress",
    "grains.spread",
    "preparation.friction",
    "sample.void_ratio",
    "sample.mechanical_coordination_number",
];
const STATES: usize = 126;
const END: f64 = 0.249;

type Failure = Box<dyn std::error::Error>;

/// A run of the unseen campaign: its inputs in the order of the surrogate, and the curves of each output column on equal strains, one
/// after another.
struct Unseen {
    point: Vec<u64>,
    inputs: Vec<f64>,
    curves: Vec<f64>,
}

/// What a surrogate says of a value.
#[derive(Clone, Copy)]
struct Said {
    mean: f64,
    lower: f64,
    upper: f64,
    noise: f64,
}

impl Said {
    fn holds(&self, value: f64) -> bool {
        self.lower - 1e-9 <= value && value <= self.upper + 1e-9
    }
}

fn read(folders: &str) -> Result<Vec<RunStates>, Failure> {
    let mut runs = Vec::new();
    for folder in folders.split(',').map(Path::new) {
        runs.extend(match DataSet::meant_by(folder) {
            Ok(Some(inside)) => of_data_set(&inside)?,
            // A campaign under way: the runs that are finished.
            _ => of_campaign(folder)?,
        });
    }
    runs.retain(|run| run.column(COORDINATE).is_ok_and(|xs| xs.iter().any(|strain| *strain > END)));
    Ok(runs)
}

fn of_data_set(folder: &Path) -> Result<Vec<RunStates>, Failure> {
    let data_set = DataSet::read(folder, granum::Registry::standard().reading())?;
    let mut runs = Vec::new();
    for run in data_set.each_run()? {
        runs.push(RunStates::of_case(&run.name, &run.case, run.measured)?);
    }
    Ok(runs)
}

fn of_campaign(folder: &Path) -> Result<Vec<RunStates>, Failure> {
    let text = std::fs::read_to_string(folder.join("campaign.json"))?;
    let plan: serde_json::Value = serde_json::from_str(&text)?;
    let names = plan["runs"].as_array().ok_or("no runs")?.iter().filter_map(|run| run["name"].as_str());
    let mut runs = Vec::new();
    for name in names {
        let folder = folder.join("tests").join(name);
        if folder.join("run.json").exists() {
            runs.push(RunStates::read(name, &granum_io::Run::at(&folder)?)?);
        }
    }
    Ok(runs)
}

/// The run without the states before its test, so that every method sees the same curves.
fn curve(run: &RunStates, output: &str) -> Result<Vec<f64>, Failure> {
    let (xs, ys) = (run.column(COORDINATE)?, run.column(output)?);
    let from = (1..xs.len()).rev().find(|&k| xs[k] <= xs[k - 1]).unwrap_or(0);
    Ok(strains().map(|x| interpolated(x, &xs[from..], &ys[from..])).collect())
}

fn strains() -> impl Iterator<Item = f64> {
    (0..STATES).map(|k| END * k as f64 / (STATES - 1) as f64)
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}

fn mean_square(values: impl Iterator<Item = f64>) -> f64 {
    mean(values.map(|value| value * value))
}

/// For each run what is said of each value, in the order of [`Unseen::curves`].
fn predict(surrogate: &dyn Surrogate, runs: &[Vec<f64>], band: bool) -> Result<Vec<Vec<Said>>, Failure> {
    let names = surrogate.columns().input_names();
    let place = names.iter().position(|name| name == COORDINATE).ok_or("no coordinate")?;
    let mut values = Vec::new();
    for run in runs {
        for x in strains() {
            let mut row = run.clone();
            row[place] = x;
            values.extend(row);
        }
    }
    let inputs = RunInputs::new(values, runs[0].len(), vec![STATES; runs.len()])?;
    let any: &dyn Any = surrogate;
    let all = match any.downcast_ref::<FittedCurves>() {
        Some(curves) if band => curves.bands(&inputs, 0.9)?,
        _ => surrogate.predict(&inputs, 0.9)?,
    };
    let outputs = surrogate.columns().outputs.len();
    let of_run = |states: &[Prediction]| {
        (0..outputs).flat_map(|output| states.iter().map(move |state| said(state, output))).collect()
    };
    Ok(all.chunks(STATES).map(of_run).collect())
}

fn said(state: &Prediction, output: usize) -> Said {
    let estimate = &state.values[output];
    let interval = estimate.interval.clone().unwrap_or_default();
    let noise = interval.causes.iter().find(|(cause, _)| *cause == Cause::Noise).map_or(0.0, |(_, s)| *s);
    Said { mean: estimate.mean, lower: interval.lower, upper: interval.upper, noise }
}

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [training, unseen, counts @ ..] = &arguments[..] else {
        return Err("TRAINING UNSEEN NUMBER...".into());
    };
    let (training, unseen) = (read(training)?, read(unseen)?);
    println!("{} training runs, {} unseen ones", training.len(), unseen.len());
    let methods = SurrogateMethods::standard();
    for count in counts {
        if let Some((count, sets)) = count.split_once('x') {
            judge_sets(&methods, &training, &unseen, (count.parse()?, sets.parse()?))?;
            continue;
        }
        let count = if count == "all" { training.len() } else { count.parse()? };
        let dataset = Dataset::new(training[..count.min(training.len())].to_vec())?;
        println!(
            "{count} runs: output, run, mean, noise, states within 90 %, curves within 90 %, by quarters of inputs"
        );
        for output in OUTPUTS {
            let spec = spec(output);
            let fitted = methods.by_name("gaussian-process")?.fit(&dataset, &spec, &mut NoObserver)?;
            judge(fitted.as_ref(), &spec, output, &unseen)?;
        }
    }
    Ok(())
}

/// Errors over sets of training runs, one after another.
fn judge_sets(
    methods: &SurrogateMethods,
    training: &[RunStates],
    unseen: &[RunStates],
    (count, sets): (usize, usize),
) -> Result<(), Failure> {
    println!("{sets} sets of {count} runs: output, error, and of each set");
    for output in OUTPUTS {
        let spec = spec(output);
        let (mut squares, mut others, mut shares) = (Vec::new(), Vec::new(), Vec::new());
        for set in training.chunks_exact(count).take(sets) {
            let dataset = Dataset::new(set.to_vec())?;
            let fitted = methods.by_name("gaussian-process")?.fit(&dataset, &spec, &mut NoObserver)?;
            let (scatter, net) = against_means(fitted.as_ref(), &of_runs(fitted.as_ref(), &spec, unseen)?)?;
            squares.push(mean(net.into_iter()) / (scatter * scatter));
            let own: BTreeSet<&str> = set.iter().map(|run| run.name()).collect();
            let other = training.iter().filter(|run| !own.contains(run.name())).cloned().collect::<Vec<_>>();
            let (error, held) = on_runs(fitted.as_ref(), &of_runs(fitted.as_ref(), &spec, &other)?)?;
            others.push(error / (scatter * scatter));
            shares.push(100.0 * held);
        }
        println!("  {output:32} mean   {}", of_sets(&squares));
        println!("  {output:32} others {}", of_sets(&others));
        let share = mean(shares.iter().copied());
        let variance = mean_square(shares.iter().map(|own| own - share)) / (shares.len() as f64 - 1.0);
        println!("  {output:32} held   {share:.1} +- {:.1} %", variance.sqrt());
    }
    Ok(())
}

/// The root of the mean of squares with its standard error, and the root of each.
fn of_sets(squares: &[f64]) -> String {
    let square = mean(squares.iter().copied());
    let variance = mean_square(squares.iter().map(|own| own - square)) / (squares.len() as f64 - 1.0);
    let root = |square: f64| square.signum() * square.abs().sqrt();
    let each: Vec<String> = squares.iter().map(|own| format!("{:.2}", root(*own))).collect();
    let uncertainty = 0.5 * variance.sqrt() / square.abs().sqrt();
    format!("{:.3} +- {uncertainty:.3}  {}", root(square), each.join(" "))
}

/// The mean square error over single runs, and the share of their states that intervals hold.
fn on_runs(fitted: &dyn Surrogate, runs: &[Unseen]) -> Result<(f64, f64), Failure> {
    let inputs: Vec<Vec<f64>> = runs.iter().map(|run| run.inputs.clone()).collect();
    let states = predict(fitted, &inputs, false)?;
    let error = |(run, predicted): (&Unseen, &Vec<Said>)| {
        mean_square(run.curves.iter().zip(predicted).map(|(y, said)| said.mean - y))
    };
    let each = runs.iter().zip(&states).flat_map(|(run, said)| run.curves.iter().zip(said));
    let held = mean(each.map(|(value, said)| f64::from(u8::from(said.holds(*value)))));
    Ok((mean(runs.iter().zip(&states).map(error)), held))
}

fn spec(output: &str) -> FitSpec {
    let mut inputs = INPUTS.map(String::from).to_vec();
    if output == "deviator_fabric" {
        inputs.push(format!("sample.{output}"));
    }
    FitSpec::new(inputs, [output]).with_coordinate(COORDINATE)
}

fn of_runs(fitted: &dyn Surrogate, spec: &FitSpec, unseen: &[RunStates]) -> Result<Vec<Unseen>, Failure> {
    let columns = fitted.columns().output_names();
    let of_run = |run: &RunStates| -> Result<Unseen, Failure> {
        let first = |name: &String| run.column(name).map(|values| values[0]);
        let inputs = spec.inputs.iter().map(first).collect::<Result<Vec<f64>, _>>()?;
        let point = inputs[1..6].iter().map(|value| value.to_bits()).collect();
        let curves: Vec<Vec<f64>> =
            columns.iter().map(|name| curve(run, name)).collect::<Result<_, Failure>>()?;
        Ok(Unseen { point, inputs, curves: curves.concat() })
    };
    unseen.iter().map(of_run).collect()
}

fn judge(fitted: &dyn Surrogate, spec: &FitSpec, output: &str, unseen: &[RunStates]) -> Result<(), Failure> {
    let columns = fitted.columns().output_names();
    let runs = of_runs(fitted, spec, unseen)?;
    let (scatter, net) = against_means(fitted, &runs)?;
    let count = net.len() as f64;
    let square = mean(net.iter().copied());
    let error_of_square = (mean_square(net.iter().map(|n| n - square)) / (count - 1.0)).sqrt();
    let material = square.signum() * square.abs().sqrt() / scatter;
    let uncertainty = 0.5 * error_of_square / square.abs().sqrt() / scatter;

    let inputs: Vec<Vec<f64>> = runs.iter().map(|run| run.inputs.clone()).collect();
    let (states, bands) = (predict(fitted, &inputs, false)?, predict(fitted, &inputs, true)?);
    let error = |(run, predicted): (&Unseen, &Vec<Said>)| {
        mean_square(run.curves.iter().zip(predicted).map(|(y, said)| said.mean - y))
    };
    let run = mean(runs.iter().zip(&states).map(error)).sqrt() / scatter;
    let noise = mean_square(states.iter().flatten().map(|said| said.noise)).sqrt() / scatter;
    // Bins that are empty in all runs are held by any interval.
    let is_empty = |column: &usize| {
        let own = column * STATES..(column + 1) * STATES;
        runs.iter().all(|run| run.curves[own.clone()].iter().all(|value| *value == 0.0))
    };
    let counted: Vec<usize> = (0..columns.len()).filter(|column| !is_empty(column)).collect();
    let held = |k: usize, said: &[Said], column: usize| {
        let own = column * STATES..(column + 1) * STATES;
        mean(own.map(|i| f64::from(u8::from(said[i].holds(runs[k].curves[i])))))
    };
    let share = |k: usize| mean(counted.iter().map(|column| held(k, &states[k], *column)));
    let shares: Vec<f64> = (0..runs.len()).map(share).collect();
    let whole =
        |k: usize| mean(counted.iter().map(|column| f64::from(u8::from(held(k, &bands[k], *column) == 1.0))));
    let curves = 100.0 * mean((0..runs.len()).map(whole));
    let mut quarters = String::new();
    for input in 1..INPUTS.len() {
        let mut order: Vec<usize> = (0..runs.len()).collect();
        order.sort_by(|a, b| runs[*a].inputs[input].total_cmp(&runs[*b].inputs[input]));
        for part in order.chunks(runs.len().div_ceil(4)) {
            quarters += &format!(" {:.0}", 100.0 * mean(part.iter().map(|&k| shares[k])));
        }
        quarters += ",";
    }
    let held = 100.0 * mean(shares.iter().copied());
    println!(
        "  {output:32} {run:.2} {material:.2} +- {uncertainty:.2} {noise:.2} {held:.1} % {curves:.1} %  {quarters}"
    );
    Ok(())
}

/// The scatter of single runs, and for each point the mean square error against the mean of its replicates, less what that mean
/// scatters itself.
fn against_means(fitted: &dyn Surrogate, runs: &[Unseen]) -> Result<(f64, Vec<f64>), Failure> {
    let mut points: BTreeMap<&[u64], Vec<&Unseen>> = BTreeMap::new();
    runs.iter().for_each(|run| points.entry(&run.point).or_default().push(run));
    let (mut within, mut net) = (Vec::new(), Vec::new());
    for replicates in points.values().filter(|replicates| replicates.len() > 2) {
        let count = replicates.len() as f64;
        let values = replicates[0].curves.len();
        let centre: Vec<f64> =
            (0..values).map(|k| mean(replicates.iter().map(|run| run.curves[k]))).collect();
        let square = |run: &&Unseen| mean_square(run.curves.iter().zip(&centre).map(|(y, m)| y - m));
        let variance = replicates.iter().map(square).sum::<f64>() / (count - 1.0);
        within.push(variance);
        let inputs = replicates[0].inputs.len();
        let sample: Vec<f64> =
            (0..inputs).map(|k| mean(replicates.iter().map(|run| run.inputs[k]))).collect();
        let predicted = &predict(fitted, &[sample], false)?[0];
        let miss = mean_square(predicted.iter().zip(&centre).map(|(said, m)| said.mean - m));
        net.push(miss - variance / count);
    }
    Ok((mean(within.into_iter()).sqrt(), net))
}
