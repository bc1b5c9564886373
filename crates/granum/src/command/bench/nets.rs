//! Speed of training and prediction, on synthetic rows of the size of Antony, Zhou and Wang (2006).
#![allow(clippy::disallowed_methods, reason = "numbers of which only the time that they take is shown")]

use std::hint::black_box;

use granum_core::parallel;
use granum_dem::Isa;
use granum_nets::trainer::{LevenbergMarquardt, NoObserver, Trainer, Traingdx};
use granum_nets::{Data, Model, ModelColumn, ModelDefinition, Network};
use serde::Serialize;

use super::learning;
use super::timing::best;
use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// Number of rows of one sub-model of the paper.
const ROWS: usize = 280;
/// Number of hidden neurons of the largest class of networks of the paper.
const HIDDEN: usize = 60;
/// Number of rows of a large table.
const TABLE: usize = 1_000_000;
/// Numbers of inputs and hidden neurons of the eighteen networks of Tables 1 to 6.
const PAPER: [(usize, [usize; 3]); 6] = [
    (3, [60, 55, 50]),
    (3, [25, 40, 65]),
    (4, [50, 50, 50]),
    (3, [25, 40, 55]),
    (4, [25, 40, 55]),
    (3, [50, 60, 65]),
];

/// The result of one measurement.
#[derive(Serialize)]
pub struct Figure {
    name: &'static str,
    value: f64,
    unit: &'static str,
    threads: usize,
    isa: &'static str,
}

/// Synthetic rows similar to (strain, f, P(f), ...) with a smooth target between 0.1 and 0.9.
fn rows(columns: usize) -> Result<Data, Failure> {
    let mut inputs = Vec::new();
    let mut targets = Vec::new();
    for r in 0..ROWS {
        let strain = (r / 7) as f64 / (ROWS / 7) as f64;
        let f = (r % 7) as f64 / 6.0;
        let all = [2.0 * strain - 1.0, 2.0 * f - 1.0, (1.0 - f) * (3.0 * strain).cos(), (5.0 * strain).sin()];
        inputs.extend_from_slice(&all[..columns]);
        targets.push(0.5 + 0.35 * (4.0 * strain).sin() * (1.0 - f) + 0.01 * (97.0 * r as f64).sin());
    }
    Ok(Data::new(inputs, columns, targets)?)
}

/// Measures all figures and prints each at once.
pub fn measure(
    context: &Context,
    isa: Option<Isa>,
    seconds: f64,
    threads: usize,
) -> Result<Vec<Figure>, Failure> {
    let isa = isa.unwrap_or_else(Isa::detect);
    let mut figures = Vec::new();
    let mut show = |name, value, unit, threads| {
        figures.push(Figure { name, value, unit, threads, isa: isa.name() });
        if context.json {
            return Ok(());
        }
        output::line(&format!("{name:<62} {threads} threads {:>9} {value:>12.3} {unit}", isa.name()))
    };
    if !context.json {
        output::line("")?;
    }
    show("traingdx, 280 rows, 3-60-60-1", descent(context, isa, seconds)?, "epochs/s", 1)?;
    show("Levenberg-Marquardt, 280 rows, 3-60-60-1", second_order(context, isa, seconds)?, "epochs/s", 1)?;
    show("the paper's eighteen networks, default trainer", eighteen(context, isa, threads)?, "s", threads)?;
    let model = model(isa)?;
    let value = best(context, 0.3 * seconds, || {
        for k in 0..1000 {
            black_box(model.value(black_box(&[1e-3 * k as f64, 0.3, 0.4]))?);
        }
        Ok(())
    })?;
    show("one prediction, 3-60-60-1", 1e3 * value, "microseconds", 1)?;
    let both = best(context, 0.3 * seconds, || {
        for k in 0..1000 {
            black_box(model.predict(black_box(&[1e-3 * k as f64, 0.3, 0.4]))?);
        }
        Ok(())
    })?;
    show("one prediction with its standard deviation, 3-60-60-1", 1e3 * both, "microseconds", 1)?;
    let table: Vec<f64> = (0..3 * TABLE).map(|k| (k as f64 * 0.37).sin()).collect();
    let batch = best(context, seconds, || {
        black_box(model.predict_batch(&table)?);
        Ok(())
    })?;
    show("a million rows in one call, 3-60-60-1", 1e-6 * TABLE as f64 / batch, "M rows/s", 1)?;
    learning::measure(context, isa, seconds, &mut |name, value, unit| show(name, value, unit, 1))?;
    Ok(figures)
}

fn descent(context: &Context, isa: Isa, seconds: f64) -> Result<f64, Failure> {
    let data = rows(3)?;
    let epochs = if isa == Isa::Portable { 10 } else { 500 };
    let rule = Traingdx { epochs, isa, minimum_gradient: 0.0, ..Default::default() };
    let each = best(context, seconds, || {
        let mut network = Network::new(&[3, HIDDEN, HIDDEN, 1], 1)?;
        black_box(rule.train(&mut network, &data, &mut NoObserver)?);
        Ok(())
    })?;
    Ok(epochs as f64 / each)
}

fn second_order(context: &Context, isa: Isa, seconds: f64) -> Result<f64, Failure> {
    let data = rows(3)?;
    let rule = LevenbergMarquardt { isa, epochs: 20, tolerance: 0.0, ..Default::default() };
    let mut epochs = 1;
    let each = best(context, seconds, || {
        let mut network = Network::new(&[3, HIDDEN, HIDDEN, 1], 1)?;
        epochs = rule.train(&mut network, &data, &mut NoObserver)?.epochs;
        Ok(())
    })?;
    Ok(epochs as f64 / each)
}

/// Time for training all eighteen networks, s, with one network per thread.
fn eighteen(context: &Context, isa: Isa, threads: usize) -> Result<f64, Failure> {
    let jobs: Vec<(usize, usize)> = PAPER.iter().flat_map(|(c, h)| h.map(|h| (*c, h))).collect();
    let data = [rows(3)?, rows(4)?];
    best(context, 0.0, || {
        parallel::map(jobs.len(), threads.max(1), |k| -> Result<(), Failure> {
            let (columns, hidden) = jobs[k];
            let mut network = Network::new(&[columns, hidden, hidden, 1], 1)?;
            let rule = LevenbergMarquardt { isa, ..Default::default() };
            rule.train(&mut network, &data[columns - 3], &mut NoObserver)?;
            Ok(())
        })
        .map(drop)
    })
}

fn model(isa: Isa) -> Result<Model, Failure> {
    let definition = ModelDefinition {
        inputs: ["strain", "f", "probability"].map(|n| ModelColumn::new(n, "1")).to_vec(),
        output: ModelColumn::new("stress_ratio", "1"),
        quantities: Vec::new(),
        shares: Vec::new(),
        hidden: vec![HIDDEN, HIDDEN],
        seed: 1,
    };
    let rule = LevenbergMarquardt { isa, epochs: 20, ..Default::default() };
    Ok(Model::fit(&definition, &rows(3)?, &rule, &mut NoObserver)?.0)
}
