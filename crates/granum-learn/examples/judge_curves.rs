//! Judges surrogates of whole tests on unseen parameter points with replicates: errors in units of the scatter of single runs, and how many
//! states and curves intervals hold.
//!
//! ```sh
//! cargo run --release -p granum-learn --example judge_curves -- CAMPAIGN UNSEEN_CAMPAIGN 24 48 96
//! ```
//!
//! For each number of runs the first so many of the campaign are fitted. `run` is the root mean square error over single unseen runs,
//! each predicted for its own sample; `mean` that of the prediction for the mean sample of a point against the mean of its replicates, less
//! what that mean scatters itself. Both are divided by the standard deviation between replicates, pooled over points and states.

use std::any::Any;
use std::collections::BTreeMap;
use std::path::Path;

use granum_core::observer::NoObserver;
use granum_learn::curve::interpolated;
use granum_learn::surrogate::{Cause, FittedCurves, RunInputs, Surrogate};
use granum_learn::{Dataset, FitSpec, Prediction, RunStates, SurrogateMethods};

const COORDINATE: &str = "axial_strain";
const OUTPUTS: [&str; 5] = [
    "stress_ratio",
    "volumetric_strain",
    "deviator_fabric",
    "mechanical_coordination_number",
    "sliding_fraction",
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

/// A run of the unseen campaign: its inputs in the order of the surrogate, and its curves on equal strains.
struct Unseen {
    point: Vec<u64>,
    inputs: Vec<f64>,
    curve: Vec<f64>,
}

fn read(campaign: &Path) -> Result<Vec<RunStates>, Failure> {
    let text = std::fs::read_to_string(campaign.join("campaign.json"))?;
    let plan: serde_json::Value = serde_json::from_str(&text)?;
    let names = plan["runs"].as_array().ok_or("no runs")?.iter().filter_map(|run| run["name"].as_str());
    let mut runs = Vec::new();
    for name in names {
        let folder = campaign.join("tests").join(name);
        if !folder.join("run.json").exists() {
            continue;
        }
        let run = granum_io::Run::at(&folder)?;
        let states = RunStates::read(name, &run)?;
        if states.column(COORDINATE)?.iter().any(|strain| *strain > END) {
            runs.push(states);
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

fn mean_square(values: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for value in values {
        sum += value * value;
        count += 1.0;
    }
    sum / count
}

fn predict(
    surrogate: &dyn Surrogate,
    runs: &[Vec<f64>],
    band: bool,
) -> Result<Vec<Vec<Prediction>>, Failure> {
    let place = surrogate
        .columns()
        .input_names()
        .iter()
        .position(|name| name == COORDINATE)
        .ok_or("no coordinate")?;
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
    Ok(all.chunks(STATES).map(<[Prediction]>::to_vec).collect())
}

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [training, unseen, counts @ ..] = &arguments[..] else {
        return Err("CAMPAIGN UNSEEN_CAMPAIGN NUMBER...".into());
    };
    let (training, unseen) = (read(Path::new(training))?, read(Path::new(unseen))?);
    println!("{} training runs, {} unseen ones", training.len(), unseen.len());
    let methods = SurrogateMethods::standard();
    for count in counts {
        let count = count.parse::<usize>()?.min(training.len());
        let dataset = Dataset::new(training[..count].to_vec())?;
        for name in ["ridge", "gaussian-process"] {
            println!(
                "{count} runs, {name}: output, run, mean, noise, states within 90 %, curves within 90 %, by quarters of inputs"
            );
            for output in OUTPUTS {
                let spec = spec(output);
                let fitted = methods.by_name(name)?.fit(&dataset, &spec, &mut NoObserver)?;
                judge(fitted.as_ref(), &spec, output, &unseen)?;
            }
        }
    }
    Ok(())
}

fn spec(output: &str) -> FitSpec {
    let mut inputs = INPUTS.map(String::from).to_vec();
    let start = format!("sample.{output}");
    if output == "deviator_fabric" && !inputs.contains(&start) {
        inputs.push(start);
    }
    FitSpec::new(inputs, [output]).with_coordinate(COORDINATE)
}

fn judge(fitted: &dyn Surrogate, spec: &FitSpec, output: &str, unseen: &[RunStates]) -> Result<(), Failure> {
    let of_run = |run: &RunStates| -> Result<Unseen, Failure> {
        let first = |name: &String| run.column(name).map(|values| values[0]);
        let inputs = spec.inputs.iter().map(first).collect::<Result<Vec<f64>, _>>()?;
        let point = inputs[1..6].iter().map(|value| value.to_bits()).collect();
        Ok(Unseen { point, inputs, curve: curve(run, output)? })
    };
    let runs: Vec<Unseen> = unseen.iter().map(of_run).collect::<Result<_, _>>()?;
    let mut points: BTreeMap<&[u64], Vec<&Unseen>> = BTreeMap::new();
    runs.iter().for_each(|run| points.entry(&run.point).or_default().push(run));
    let average = |of: &[&Unseen], value: &dyn Fn(&Unseen) -> f64| {
        of.iter().map(|run| value(run)).sum::<f64>() / of.len() as f64
    };
    let (mut within, mut net) = (Vec::new(), Vec::new());
    for replicates in points.values().filter(|replicates| replicates.len() > 2) {
        let count = replicates.len() as f64;
        let mean: Vec<f64> = (0..STATES).map(|k| average(replicates, &|run| run.curve[k])).collect();
        let square = |run: &&Unseen| run.curve.iter().zip(&mean).map(|(y, m)| (y - m) * (y - m)).sum::<f64>();
        let variance = replicates.iter().map(square).sum::<f64>() / (STATES as f64 * (count - 1.0));
        within.push(variance);
        let inputs: Vec<f64> =
            (0..replicates[0].inputs.len()).map(|k| average(replicates, &|run| run.inputs[k])).collect();
        let predicted = &predict(fitted, &[inputs], false)?[0];
        let miss = mean_square(predicted.iter().zip(&mean).map(|(p, m)| p.values[0].mean - m));
        net.push(miss - variance / count);
    }
    let scatter = (within.iter().sum::<f64>() / within.len() as f64).sqrt();
    let inputs: Vec<Vec<f64>> = runs.iter().map(|run| run.inputs.clone()).collect();
    let (states, bands) = (predict(fitted, &inputs, false)?, predict(fitted, &inputs, true)?);
    let error = |(run, predicted): (&Unseen, &Vec<Prediction>)| {
        mean_square(run.curve.iter().zip(predicted).map(|(y, p)| p.values[0].mean - y))
    };
    let errors: Vec<f64> = runs.iter().zip(&states).map(error).collect();
    let run = (errors.iter().sum::<f64>() / errors.len() as f64).sqrt() / scatter;
    let net = net.iter().sum::<f64>() / net.len() as f64;
    let mean = net.signum() * net.abs().sqrt() / scatter;
    let noise = |p: &Prediction| {
        let causes =
            p.values[0].interval.as_ref().map(|interval| interval.causes.clone()).unwrap_or_default();
        causes.iter().find(|(cause, _)| *cause == Cause::Noise).map_or(0.0, |(_, s)| *s)
    };
    let noise = mean_square(states.iter().flatten().map(noise)).sqrt() / scatter;
    let holds = |y: f64, p: &Prediction| {
        p.values[0].interval.as_ref().is_some_and(|i| i.lower - 1e-9 <= y && y <= i.upper + 1e-9)
    };
    let share = |k: usize| {
        let held = runs[k].curve.iter().zip(&states[k]).filter(|(y, p)| holds(**y, p)).count();
        held as f64 / STATES as f64
    };
    let shares: Vec<f64> = (0..runs.len()).map(share).collect();
    let whole =
        (0..runs.len()).filter(|&k| runs[k].curve.iter().zip(&bands[k]).all(|(y, p)| holds(*y, p))).count();
    let mut quarters = String::new();
    for input in 1..INPUTS.len() {
        let mut order: Vec<usize> = (0..runs.len()).collect();
        order.sort_by(|a, b| runs[*a].inputs[input].total_cmp(&runs[*b].inputs[input]));
        for part in order.chunks(runs.len().div_ceil(4)) {
            quarters +=
                &format!(" {:.0}", 100.0 * part.iter().map(|&k| shares[k]).sum::<f64>() / part.len() as f64);
        }
        quarters += ",";
    }
    let held = 100.0 * shares.iter().sum::<f64>() / shares.len() as f64;
    let curves = 100.0 * whole as f64 / runs.len() as f64;
    println!("  {output:32} {run:.2} {mean:.2} {noise:.2} {held:.1} % {curves:.1} %  {quarters}");
    Ok(())
}
