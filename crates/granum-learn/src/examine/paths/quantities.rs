//! What is judged of a state on a path.

use super::columns::{Learned, SCALARS, TENSORS};
use crate::dataset::Dataset;
use crate::error::Result;
use crate::methods::{COMPONENTS, STRAINS, SUFFIXES, deviator};

/// A state: deviators of stress over mean stress and of fabric, volumetric strain or logarithm of the mean stress, coordination number.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Row {
    pub stress: [f64; COMPONENTS],
    pub fabric: [f64; COMPONENTS],
    pub volume: f64,
    pub pressure: f64,
    pub coordination: f64,
}

/// The least mean stress whose logarithm is judged, Pa: a sample of grains that flows with its water carries less by chance.
const LEAST_PRESSURE: f64 = 1e3;

/// The norm of the deviator of stress over mean stress where two of the principal stresses are zero, the square root of 6: grains that do not stick to
/// each other bear no larger one.
const LARGEST_RATIO: f64 = 2.449_489_742_783_178;

/// The deviator of stress over mean stress. Where a predicted mean stress is so small, or negative, that the norm would be larger than grains without
/// adhesion can bear, it is that norm.
fn stress_over_pressure(stress: [f64; COMPONENTS], pressure: f64) -> [f64; COMPONENTS] {
    let norm = stress.iter().map(|c| c * c).sum::<f64>().sqrt();
    if norm == 0.0 {
        return [0.0; COMPONENTS];
    }
    let is_larger = norm > LARGEST_RATIO * pressure;
    stress.map(|c| if is_larger { LARGEST_RATIO * (c / norm) } else { c / pressure })
}

impl Row {
    /// From the outputs of what is learned, in their order.
    pub fn of_outputs(learned: &Learned, row: &[f64]) -> Row {
        let six = |first: usize| std::array::from_fn(|k| row[first + k]);
        let (stress, pressure) = deviator(six(0));
        let known = Row { fabric: deviator(six(6)).0, ..Row::default() };
        match learned.volume_is_input {
            false => Row {
                stress: stress_over_pressure(stress, pressure),
                volume: row[12],
                coordination: row[13],
                ..known
            },
            true => {
                let pressure = pressure.max(LEAST_PRESSURE);
                Row {
                    stress: stress_over_pressure(stress, pressure),
                    pressure: libm::log(pressure),
                    coordination: row[12],
                    ..known
                }
            }
        }
    }
}

/// One of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Quantity {
    Stress,
    Volume,
    Pressure,
    Fabric,
    Coordination,
}

impl Quantity {
    /// What is judged of what is learned.
    pub fn judged(learned: &Learned) -> [Quantity; 4] {
        let second = if learned.volume_is_input { Quantity::Pressure } else { Quantity::Volume };
        [Quantity::Stress, second, Quantity::Fabric, Quantity::Coordination]
    }

    pub fn name(self) -> &'static str {
        match self {
            Quantity::Stress => "stress deviator",
            Quantity::Volume => "volumetric strain",
            Quantity::Pressure => "logarithm of mean stress",
            Quantity::Fabric => "fabric deviator",
            Quantity::Coordination => "coordination number",
        }
    }

    /// The difference of two states, squared.
    pub fn square(self, a: &Row, b: &Row) -> f64 {
        let tensors = |a: &[f64; COMPONENTS], b: &[f64; COMPONENTS]| -> f64 {
            a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
        };
        match self {
            Quantity::Stress => tensors(&a.stress, &b.stress),
            Quantity::Fabric => tensors(&a.fabric, &b.fabric),
            Quantity::Volume => (a.volume - b.volume) * (a.volume - b.volume),
            Quantity::Pressure => (a.pressure - b.pressure) * (a.pressure - b.pressure),
            Quantity::Coordination => (a.coordination - b.coordination) * (a.coordination - b.coordination),
        }
    }

    /// The reference of its errors: zero for tensors, the mean of the training states for scalars.
    fn reference(self, means: &Row) -> Row {
        Row { stress: [0.0; COMPONENTS], fabric: [0.0; COMPONENTS], ..*means }
    }

    /// Sums over states: of the squared error, and of the squared difference from the reference.
    pub fn squares(self, exact: &[Row], rows: &[Row], means: &Row) -> [f64; 2] {
        let reference = self.reference(means);
        let errors = exact.iter().zip(rows).map(|(exact, row)| self.square(exact, row)).sum();
        [errors, exact.iter().map(|exact| self.square(exact, &reference)).sum()]
    }
}

/// The states of all runs.
pub(super) fn rows_of(learned: &Learned, runs: &Dataset) -> Result<Vec<Row>> {
    let outputs = learned.spec().outputs;
    let rows = runs.values(&outputs)?;
    Ok(rows.chunks_exact(outputs.len()).map(|row| Row::of_outputs(learned, row)).collect())
}

/// The states of the samples, for each run.
pub(super) fn samples(learned: &Learned, runs: &Dataset) -> Result<Vec<Row>> {
    let tensors = TENSORS.iter().flat_map(|name| SUFFIXES.map(|suffix| format!("sample.{name}_{suffix}")));
    let names: Vec<String> = tensors.chain([format!("sample.{}", SCALARS[1])]).collect();
    let of_run = |run: &crate::dataset::RunStates| -> Result<Row> {
        let mut row = Vec::new();
        for name in &names {
            row.push(run.values(name)?.first().copied().unwrap_or_default());
        }
        if !learned.volume_is_input {
            row.insert(12, 0.0);
        }
        Ok(Row::of_outputs(learned, &row))
    };
    runs.runs().iter().map(of_run).collect()
}

/// The deviators of strain of all runs.
pub(super) fn strains(runs: &Dataset) -> Result<Vec<[f64; COMPONENTS]>> {
    let values = runs.values(&STRAINS)?;
    let of_row = |row: &[f64]| deviator([row[0], row[1], row[2], 0.5 * row[3], 0.5 * row[4], 0.5 * row[5]]).0;
    Ok(values.chunks_exact(6).map(of_row).collect())
}

/// The mean of all states.
pub(super) fn means(learned: &Learned, runs: &Dataset) -> Result<Row> {
    let rows = rows_of(learned, runs)?;
    let count = rows.len().max(1) as f64;
    let mut mean = Row::default();
    for row in &rows {
        (0..COMPONENTS).for_each(|c| {
            mean.stress[c] += row.stress[c] / count;
            mean.fabric[c] += row.fabric[c] / count;
        });
        mean.volume += row.volume / count;
        mean.pressure += row.pressure / count;
        mean.coordination += row.coordination / count;
    }
    Ok(mean)
}
