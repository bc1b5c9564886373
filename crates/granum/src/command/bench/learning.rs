//! Speed of training by gradients, of networks and of models with memory, and of predictions with intervals: what
//! `benches/peers/networks_torch.py` compares with PyTorch, on the same data, which follow from formulas.
#![allow(clippy::disallowed_methods, reason = "numbers of which only the time that they take is shown")]

use std::hint::black_box;

use granum_core::{Column, Table};
use granum_dem::Isa;
use granum_learn::surrogate::{FitSpec, GaussianProcessOfCurves, RunInputs, SurrogateMethod};
use granum_learn::{Dataset, RunStates};
use granum_nets::trainer::{Adam, Lbfgs, LevenbergMarquardt, NoObserver, Trainer};
use granum_nets::{
    Batch, Data, Differentiable, Ensemble, Gru, Lstm, Model, ModelColumn, ModelDefinition, Network, Sequences,
};

use super::timing::best;
use crate::context::Context;
use crate::failure::Failure;

/// Rows, inputs, hidden neurons of both layers and rows of a mini-batch of a large table.
const TABLE: [usize; 4] = [12_000, 8, 32, 256];
/// Sequences, states of each, inputs, hidden neurons, outputs and sequences of a mini-batch.
const RUNS: [usize; 6] = [64, 100, 5, 32, 3, 16];
/// Numbers of epochs of a measurement.
const EPOCHS: u64 = 5;
/// Training runs of curves, states of a run, and states that are asked.
const CURVES: [usize; 3] = [48, 100, 20_000];
/// Rows of predictions with intervals in a call.
const ASKED: usize = 20_000;
/// Training rows of the network that is asked.
const LEARNED: usize = 240;

/// Waves over all numbers of a table.
fn waves(count: usize, step: f64) -> Vec<f64> {
    (0..count).map(|k| (step * k as f64).sin()).collect()
}

/// The large table: waves as inputs, and a target between 0.1 and 0.9.
fn table() -> Result<Data, Failure> {
    let [rows, inputs, ..] = TABLE;
    let values = waves(rows * inputs, 0.37);
    let targets =
        values.chunks(inputs).map(|row| 0.5 + 0.3 * (row[0] * row[1] + 0.5 * row[2]).sin()).collect();
    Ok(Data::new(values, inputs, targets)?)
}

/// Sequences whose targets are running means of their inputs.
fn runs() -> Result<Data, Failure> {
    let [count, states, inputs, _, outputs, _] = RUNS;
    let values = waves(count * states * inputs, 0.37);
    let mut targets = Vec::with_capacity(count * states * outputs);
    for run in values.chunks(states * inputs) {
        let mut means = vec![0.0; outputs];
        for row in run.chunks(inputs) {
            means.iter_mut().zip(row).for_each(|(mean, value)| *mean = 0.9 * *mean + 0.1 * value);
            targets.extend_from_slice(&means);
        }
    }
    let sequences = Sequences::new(vec![states; count])?;
    Ok(Data::with_target_columns(values, inputs, targets, outputs)?.with_sequences(sequences)?)
}

/// Epochs a second of mini-batch Adam.
fn adam<M: Differentiable>(
    context: &Context,
    isa: Isa,
    seconds: f64,
    data: &Data,
    model: impl Fn() -> Result<M, Failure>,
) -> Result<f64, Failure> {
    let rule =
        Adam { epochs: EPOCHS, batch_rows: TABLE[3], batch_sequences: RUNS[5], isa, ..Adam::default() };
    let each = best(context, seconds, || {
        black_box(rule.train(&mut model()?, data, &mut NoObserver)?);
        Ok(())
    })?;
    Ok(EPOCHS as f64 / each)
}

/// Errors with their gradients a second, over all rows.
fn gradients(
    context: &Context,
    isa: Isa,
    seconds: f64,
    data: &Data,
    model: &dyn Differentiable,
) -> Result<f64, Failure> {
    let mut batch: Box<dyn Batch> = model.batch(isa, data)?;
    let mut gradient = vec![0.0; model.weights().len()];
    let each = best(context, seconds, || {
        black_box(batch.squared_error(model.weights()));
        batch.gradient(model.weights(), 1.0, &mut gradient);
        black_box(&gradient);
        Ok(())
    })?;
    Ok(1.0 / each)
}

/// Predictions with intervals a second of a network that was trained with Bayesian regularisation, or of so many of them.
fn intervals(context: &Context, isa: Isa, seconds: f64, hidden: usize, members: u64) -> Result<f64, Failure> {
    let values = waves(3 * LEARNED, 0.37);
    let targets = values.chunks(3).enumerate();
    let targets =
        targets.map(|(k, row)| 0.5 + 0.3 * (2.0 * row[0]).sin() * row[1] + 0.01 * (97.0 * k as f64).sin());
    let data = Data::new(values.clone(), 3, targets.collect())?;
    let definition = ModelDefinition {
        inputs: ["strain", "fabric", "force"].map(|name| ModelColumn::new(name, "1")).to_vec(),
        output: ModelColumn::new("stress_ratio", "1"),
        quantities: Vec::new(),
        shares: Vec::new(),
        hidden: vec![hidden; 2],
        seed: 1,
    };
    let rule = LevenbergMarquardt { isa, epochs: 20, ..Default::default() };
    let asked = waves(3 * ASKED, 0.11);
    if members > 1 {
        let seeds: Vec<u64> = (1..=members).collect();
        let ensemble = Ensemble::fit(&definition, &data, &rule, &seeds, 1, &mut NoObserver)?.0;
        let each = best(context, seconds, || {
            black_box(ensemble.predict_batch_with_deviations(&asked)?);
            Ok(())
        })?;
        return Ok(ASKED as f64 / each);
    }
    let model = Model::fit(&definition, &data, &rule, &mut NoObserver)?.0;
    let each = best(context, seconds, || {
        black_box(model.predict_batch_with_deviations(&asked, 1)?);
        Ok(())
    })?;
    Ok(ASKED as f64 / each)
}

/// Predictions of two outputs with intervals a second, of states along runs, by Gaussian processes of curves.
fn curves(context: &Context, seconds: f64) -> Result<f64, Failure> {
    let [runs, states, asked] = CURVES;
    let run = |k: usize| -> granum_learn::Result<RunStates> {
        let place = (0.618_033_988_749_894_8 * k as f64).fract();
        let x: Vec<f64> = (0..states).map(|i| i as f64 / (states - 1) as f64).collect();
        let curve = |height: f64| x.iter().map(|x| height * x / (x + 0.1)).collect();
        let columns =
            [("y", curve(1.0 + place * place)), ("z", curve((3.0 * place).sin())), ("x", x.clone())];
        let columns = columns.into_iter().map(|(name, values)| Column::new(name, "", values));
        RunStates::new(&format!("run-{k}"), Table::new(columns.collect())?)?
            .with_parameter("place", "", place)
    };
    let dataset = Dataset::new((0..runs).map(run).collect::<granum_learn::Result<_>>()?)?;
    let spec = FitSpec::new(["x", "place"], ["y", "z"]).with_coordinate("x").with_threads(1);
    let fitted = GaussianProcessOfCurves::default().fit(&dataset, &spec, &mut NoObserver)?;
    let rows = (0..asked).flat_map(|k| {
        let (run, state) = (k / states, k % states);
        [state as f64 / states as f64, (0.414 * run as f64).fract()]
    });
    let inputs = RunInputs::new(rows.collect(), 2, vec![states; asked / states])?;
    let each = best(context, seconds, || {
        black_box(fitted.predict(&inputs, 0.9)?);
        Ok(())
    })?;
    Ok(asked as f64 / each)
}

/// Measures all figures; `show` receives the name, the value and the unit of each.
pub fn measure(
    context: &Context,
    isa: Isa,
    seconds: f64,
    show: &mut dyn FnMut(&'static str, f64, &'static str) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let [_, inputs, neurons, _] = TABLE;
    let data = table()?;
    let network = || Ok(Network::new(&[inputs, neurons, neurons, 1], 1)?);
    let value = adam(context, isa, seconds, &data, network)?;
    show("Adam, 12,000 rows in batches of 256, 8-32-32-1", value, "epochs/s")?;
    let value = gradients(context, isa, seconds, &data, &network()?)?;
    show("error and gradient, 12,000 rows, 8-32-32-1", value, "a second")?;
    let rule = Lbfgs { epochs: 20, isa, ..Lbfgs::default() };
    let each = best(context, seconds, || {
        black_box(rule.train(&mut network()?, &data, &mut NoObserver)?);
        Ok(())
    })?;
    show("L-BFGS, 12,000 rows, 8-32-32-1", rule.epochs as f64 / each, "steps/s")?;
    let data = runs()?;
    let [_, _, inputs, hidden, outputs, _] = RUNS;
    let gru = || Ok(Gru::new(inputs, 0, hidden, outputs, 1)?);
    let value = adam(context, isa, seconds, &data, gru)?;
    show("Adam, 64 runs of 100 states in batches of 16, GRU 5-32-3", value, "epochs/s")?;
    show(
        "error and gradient, 64 runs, GRU 5-32-3",
        gradients(context, isa, seconds, &data, &gru()?)?,
        "a second",
    )?;
    let lstm = || Ok(Lstm::new(inputs, 0, hidden, outputs, 1)?);
    let value = adam(context, isa, seconds, &data, lstm)?;
    show("Adam, 64 runs of 100 states in batches of 16, LSTM 5-32-3", value, "epochs/s")?;
    show(
        "error and gradient, 64 runs, LSTM 5-32-3",
        gradients(context, isa, seconds, &data, &lstm()?)?,
        "a second",
    )?;
    let value = 1e-6 * intervals(context, isa, seconds, 12, 1)?;
    show("predictions with intervals, 3-12-12-1, 240 training rows", value, "M rows/s")?;
    let value = 1e-6 * intervals(context, isa, seconds, 60, 1)?;
    show("predictions with intervals, 3-60-60-1, 240 training rows", value, "M rows/s")?;
    let value = 1e-6 * intervals(context, isa, seconds, 60, 5)?;
    show("predictions with intervals, five networks 3-60-60-1", value, "M rows/s")?;
    let value = 1e-6 * curves(context, seconds)?;
    show("states of two curves with intervals, Gaussian processes, 48 runs", value, "M states/s")
}
