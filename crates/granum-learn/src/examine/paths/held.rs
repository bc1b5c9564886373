//! Whether the intervals of surrogates hold on unseen paths.

use serde::{Deserialize, Serialize};

use super::columns::{SCALARS, TENSORS, is_of, kinds};
use super::quantities::{Quantity, strains};
use crate::dataset::{Dataset, RunStates};
use crate::error::Result;
use crate::surrogate::{Columns, Prediction};

/// The level of the intervals that are judged.
pub(super) const LEVEL: f64 = 0.9;
/// The input by whose quarters intervals are judged, beside the length of the path.
const VOID_RATIO: &str = "sample.void_ratio";
/// Rounding error of a state that is known exactly.
const SLIGHT: f64 = 1e-9;

/// The share of the states of unseen runs that lie within their intervals.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeldStates {
    /// The method.
    pub method: String,
    /// The states of which runs: `all`, or those of a kind of path.
    pub kind: String,
    /// What is judged; of a tensor each component.
    pub quantity: String,
    /// The level of the intervals.
    pub level: f64,
    /// The share of the states within their intervals, averaged over runs.
    pub held: f64,
    /// Its standard error over runs; 0 for a single run.
    pub standard_error: f64,
    /// The share in each quarter of the longest path of strain, from the beginning; `None` where no run has states.
    pub along_path: [Option<f64>; 4],
    /// The share in each quarter of the range of the void ratio of the samples; `None` where there is no run.
    pub by_void_ratio: [Option<f64>; 4],
}

/// What all judgements of unseen runs share: where their states are.
pub(super) struct Places {
    /// For each state the quarter of the longest path.
    quarter_of_path: Vec<usize>,
    /// For each run the quarter of the range of the void ratio.
    quarter_of_void_ratio: Vec<Option<usize>>,
}

fn quarter(value: f64, [low, high]: [f64; 2]) -> usize {
    ((4.0 * (value - low) / (high - low)).max(0.0) as usize).min(3)
}

impl Places {
    /// # Errors
    /// If there are no strains.
    pub fn new(runs: &Dataset) -> Result<Places> {
        let strains = strains(runs)?;
        let mut lengths = Vec::with_capacity(strains.len());
        for run in runs.runs() {
            let mut length = 0.0;
            for row in 0..run.rows() {
                if row > 0 {
                    let (now, last) = (strains[lengths.len()], strains[lengths.len() - 1]);
                    length += now.iter().zip(last).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
                }
                lengths.push(length);
            }
        }
        let longest = lengths.iter().copied().fold(0.0, f64::max);
        let ratios: Vec<Option<f64>> = runs.runs().iter().map(|run| run.parameter(VOID_RATIO)).collect();
        let range = crate::curve::range(ratios.iter().flatten().copied());
        Ok(Places {
            quarter_of_path: lengths.iter().map(|length| quarter(*length, [0.0, longest])).collect(),
            quarter_of_void_ratio: ratios.iter().map(|own| own.map(|own| quarter(own, range))).collect(),
        })
    }
}

/// The places of the columns of a quantity among the outputs.
fn columns_of(quantity: Quantity, columns: &Columns) -> Vec<usize> {
    let is_own = |name: &str| match quantity {
        Quantity::Stress => name.starts_with(TENSORS[0]),
        // It is no output of its own.
        Quantity::Pressure => false,
        Quantity::Fabric => name.starts_with(TENSORS[1]),
        Quantity::Volume => name == SCALARS[0],
        Quantity::Coordination => name == SCALARS[1],
    };
    (0..columns.outputs.len()).filter(|k| is_own(&columns.outputs[*k].name)).collect()
}

/// Sums of held and of all states.
#[derive(Clone, Copy, Default)]
struct Share {
    held: f64,
    all: f64,
}

impl Share {
    fn add(&mut self, held: f64) {
        self.held += held;
        self.all += 1.0;
    }

    fn value(self) -> Option<f64> {
        (self.all > 0.0).then(|| self.held / self.all)
    }
}

/// The shares of states within their intervals, by kind of path and quantity; none without intervals.
///
/// # Errors
/// If a column is missing.
pub(super) fn held(
    method: &str,
    runs: &Dataset,
    places: &Places,
    (columns, quantities): (&Columns, &[Quantity]),
    predictions: &[Prediction],
) -> Result<Vec<HeldStates>> {
    let is_known = |prediction: &Prediction| prediction.values.iter().all(|own| own.interval.is_some());
    if !predictions.iter().all(is_known) {
        return Ok(Vec::new());
    }
    let names = columns.output_names();
    let exact = runs.values(&names)?;
    let mut found = Vec::new();
    for quantity in quantities {
        let own = columns_of(*quantity, columns);
        if own.is_empty() {
            continue;
        }
        // The share of the components of each state.
        let of_state = |(row, prediction): (usize, &Prediction)| {
            let is_held = |place: &&usize| {
                let exact = exact[row * names.len() + **place];
                let slight = SLIGHT * (1.0 + exact.abs());
                let interval = prediction.values[**place].interval.as_ref();
                interval.is_some_and(|own| own.lower - slight <= exact && exact <= own.upper + slight)
            };
            own.iter().filter(is_held).count() as f64 / own.len().max(1) as f64
        };
        let states: Vec<f64> = predictions.iter().enumerate().map(of_state).collect();
        for of_kind in kinds(runs) {
            let is_chosen = |run: &RunStates| is_of(run, &of_kind);
            found.push(of_runs(&states, runs, places, is_chosen).named(method, &of_kind, *quantity));
        }
    }
    Ok(found)
}

impl HeldStates {
    fn named(self, method: &str, kind: &str, quantity: Quantity) -> HeldStates {
        HeldStates { method: method.into(), kind: kind.into(), quantity: quantity.name().into(), ..self }
    }
}

/// The shares of some runs from those of all states.
fn of_runs(
    states: &[f64],
    runs: &Dataset,
    places: &Places,
    is_chosen: impl Fn(&RunStates) -> bool,
) -> HeldStates {
    let (mut along_path, mut by_void_ratio) = ([Share::default(); 4], [Share::default(); 4]);
    let mut each = Vec::new();
    let mut first = 0;
    for (number, run) in runs.runs().iter().enumerate() {
        let rows = first..first + run.rows();
        first = rows.end;
        if !is_chosen(run) || rows.is_empty() {
            continue;
        }
        let held = states[rows.clone()].iter().sum::<f64>() / rows.len() as f64;
        each.push(held);
        rows.for_each(|row| along_path[places.quarter_of_path[row]].add(states[row]));
        if let Some(quarter) = places.quarter_of_void_ratio[number] {
            by_void_ratio[quarter].add(held);
        }
    }
    let count = each.len() as f64;
    let mean = each.iter().sum::<f64>() / count.max(1.0);
    let spread = each.iter().map(|held| (held - mean) * (held - mean)).sum::<f64>();
    HeldStates {
        method: String::new(),
        kind: String::new(),
        quantity: String::new(),
        level: LEVEL,
        held: mean,
        standard_error: if count > 1.0 { (spread / (count - 1.0) / count).sqrt() } else { 0.0 },
        along_path: along_path.map(Share::value),
        by_void_ratio: by_void_ratio.map(Share::value),
    }
}
