//! How far the answers of a family are from runs that it has not seen.

use super::definition::{FamilyDefinition, FamilyOutput};
use super::model::{FamilyModel, inputs_of, unfit, with_columns};
use super::replicates::{PointSums, net_error, replicates, standard_error};
use super::score_types::{FamilyOutputScore, FamilyScores, QuarterCoverage, TrainingData};
use crate::curve::is_logarithmic;
use crate::dataset::{Dataset, RunStates};
use crate::error::{LearnError, Result};
use crate::surrogate::{Prediction, RunInputs};

/// Level of the intervals.
const LEVEL: f64 = 0.9;
/// Rounding error of a state that is known exactly, such as the first.
const SLIGHT: f64 = 1e-9;

/// A run with what is predicted for it: values by output and point.
struct ScoredRun {
    inputs: Vec<f64>,
    measured: Vec<Vec<f64>>,
    predicted: Vec<Prediction>,
    bands: Vec<Prediction>,
}

impl ScoredRun {
    /// True if the runs of the fit say little of its inputs.
    fn is_flagged(&self) -> bool {
        self.predicted.iter().any(Prediction::is_extrapolated)
    }
}

fn too_short(name: &str, definition: &FamilyDefinition, points: &[f64]) -> LearnError {
    let (coordinate, end) = (definition.coordinate, points.last().copied().unwrap_or_default());
    LearnError::Dataset(format!(
        "no run of `{name}` goes as far as the curves of the family {}, which end at {coordinate} {end:.4}; record the tests to there",
        definition.name
    ))
}

impl FamilyModel {
    /// Scores it on runs that it has not seen.
    ///
    /// # Errors
    /// If a run is not of the family or lacks a column, or no run goes as far as the curves do.
    pub fn score(&self, dataset: &Dataset, data: TrainingData) -> Result<FamilyScores> {
        let curves = self.curves().ok_or_else(|| unfit("its surrogate has no curves"))?;
        let definition = self.definition;
        let with = with_columns(definition, dataset)?;
        let (points, shares) = (curves.points(), curves.shares());
        let (mut scored, mut of_runs, mut left_out) = (Vec::new(), Vec::new(), Vec::new());
        for (run, original) in with.runs().iter().zip(dataset.runs()) {
            let Some(measured) = curves.measured(run)? else {
                left_out.push(run.name().to_string());
                continue;
            };
            let inputs = inputs_of(definition, run)?;
            let rows =
                points.iter().flat_map(|x| std::iter::once(*x).chain(inputs.iter().copied())).collect();
            let rows = RunInputs::new(rows, inputs.len() + 1, vec![points.len()])?;
            let predicted = self.surrogate.predict(&rows, LEVEL)?;
            let bands = curves.bands(&rows, LEVEL)?;
            scored.push(ScoredRun { inputs, measured, predicted, bands });
            of_runs.push(original);
        }
        if scored.is_empty() {
            return Err(too_short(&data.name, definition, points));
        }
        let groups = replicates(&of_runs.iter().map(|run| &**run).collect::<Vec<&RunStates>>());
        let outputs = definition.outputs.iter().map(|output| {
            let columns = self.columns_of(output);
            self.output_score(output, &columns, &shares, (&scored, &groups))
        });
        Ok(FamilyScores {
            data: TrainingData { runs: dataset.runs().len(), ..data },
            points: groups.iter().filter(|group| group.len() > 1).count(),
            outside: scored.iter().filter(|run| run.is_flagged()).count(),
            left_out,
            level: LEVEL,
            outputs: outputs.collect(),
        })
    }

    /// The numbers of the columns of an output: one, or those of all bins.
    pub fn columns_of(&self, output: &FamilyOutput) -> Vec<usize> {
        let columns = self.surrogate.columns().outputs.iter().enumerate();
        let is_own = |name: &str| {
            let bin = name.strip_prefix(output.column).and_then(|rest| rest.strip_prefix('_'));
            name == output.column || bin.is_some_and(|bin| bin.parse::<f64>().is_ok())
        };
        columns.filter(|(_, column)| is_own(&column.name)).map(|(number, _)| number).collect()
    }

    fn output_score(
        &self,
        output: &FamilyOutput,
        columns: &[usize],
        shares: &[f64],
        (runs, groups): (&[ScoredRun], &[Vec<usize>]),
    ) -> FamilyOutputScore {
        let (mut errors, mut squares) = (0.0, 0.0);
        let mut of_runs = Vec::with_capacity(runs.len());
        let mut whole = 0;
        for run in runs {
            let mut held = 0.0;
            for &column in columns {
                let mut is_whole = true;
                for (k, share) in shares.iter().enumerate() {
                    let exact = run.measured[column][k];
                    let estimate = &run.predicted[k].values[column];
                    errors += share * (estimate.mean - exact).powi(2);
                    squares += share * exact * exact;
                    held += share * f64::from(u8::from(holds(&run.predicted[k], column, exact)));
                    is_whole &= holds(&run.bands[k], column, exact);
                }
                whole += usize::from(is_whole);
            }
            of_runs.push(held / columns.len() as f64);
        }
        let mut sums = Vec::new();
        for group in groups.iter().filter(|group| group.len() > 1) {
            let mut point = PointSums::default();
            for &column in columns {
                for (k, share) in shares.iter().enumerate() {
                    let measured: Vec<f64> = group.iter().map(|run| runs[*run].measured[column][k]).collect();
                    let predicted: Vec<f64> =
                        group.iter().map(|run| runs[*run].predicted[k].values[column].mean).collect();
                    point.add(&measured, &predicted, *share);
                }
            }
            sums.push(point);
        }
        let total = |part: fn(&PointSums) -> f64| sums.iter().map(part).sum::<f64>();
        let within = runs.iter().zip(&of_runs).filter(|(run, _)| !run.is_flagged()).map(|(_, held)| *held);
        let within: Vec<f64> = within.collect();
        let is_part = !within.is_empty() && within.len() < runs.len();
        let or_nan = |value: f64| if sums.is_empty() { f64::NAN } else { value };
        FamilyOutputScore {
            output: output.column.into(),
            relative_error: (errors / squares).sqrt(),
            relative_scatter: or_nan((total(|point| point.variance) / total(|point| point.square)).sqrt()),
            net_error: or_nan(net_error(&sums)),
            standard_error: or_nan(standard_error(&sums)),
            held: of_runs.iter().sum::<f64>() / runs.len() as f64,
            held_within: is_part.then(|| within.iter().sum::<f64>() / within.len() as f64),
            whole_curves: whole as f64 / (runs.len() * columns.len()) as f64,
            quarters: self.quarters(runs, groups, &of_runs),
        }
    }

    fn quarters(&self, runs: &[ScoredRun], groups: &[Vec<usize>], held: &[f64]) -> Vec<QuarterCoverage> {
        let of_input = |(number, [low, high]): (usize, [f64; 2])| {
            let values: Vec<f64> = runs.iter().map(|run| run.inputs[number]).collect();
            let logarithmic = low > 0.0 && is_logarithmic(&values);
            let scaled = |value: f64| {
                let part = match logarithmic {
                    true => libm::log(value.max(low) / low) / libm::log(high / low),
                    false => (value - low) / (high - low),
                };
                ((4.0 * part) as usize).min(3)
            };
            // The shares of the runs of each material in a quarter.
            let of_materials = |quarter: usize| -> Vec<Vec<f64>> {
                let is_in = |run: &&usize| scaled(runs[**run].inputs[number]) == quarter;
                let of_material =
                    |group: &Vec<usize>| group.iter().filter(is_in).map(|run| held[*run]).collect();
                groups.iter().map(of_material).filter(|own: &Vec<f64>| !own.is_empty()).collect()
            };
            let quarters = [0, 1, 2, 3].map(of_materials);
            QuarterCoverage {
                input: self.definition.inputs[number].name.into(),
                held: quarters.each_ref().map(|own| share_and_error(own).map(|(share, _)| share)),
                standard_errors: quarters
                    .each_ref()
                    .map(|own| share_and_error(own).and_then(|(_, error)| error)),
                runs: quarters.each_ref().map(|own| own.iter().map(Vec::len).sum()),
            }
        };
        self.run_ranges()
            .into_iter()
            .enumerate()
            .filter(|(_, [low, high])| high > low)
            .map(of_input)
            .collect()
    }
}

/// The mean over all runs, and its standard error over the materials, whose runs are not independent of each other.
fn share_and_error(materials: &[Vec<f64>]) -> Option<(f64, Option<f64>)> {
    let runs = materials.iter().map(Vec::len).sum::<usize>() as f64;
    if runs == 0.0 {
        return None;
    }
    let share = materials.iter().flatten().sum::<f64>() / runs;
    let count = materials.len() as f64;
    let squares: f64 =
        materials.iter().map(|own| own.iter().map(|held| held - share).sum::<f64>().powi(2)).sum();
    let error = (materials.len() > 1).then(|| (count / (count - 1.0) * squares).sqrt() / runs);
    Some((share, error))
}

fn holds(prediction: &Prediction, column: usize, exact: f64) -> bool {
    let slight = SLIGHT * (1.0 + exact.abs());
    let within = |lower: f64, upper: f64| lower - slight <= exact && exact <= upper + slight;
    prediction.values[column].interval.as_ref().is_some_and(|interval| within(interval.lower, interval.upper))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: three materials, of which the first has two runs that are held or not together.
    #[test]
    fn runs_of_a_material_are_not_independent() {
        let (share, error) = share_and_error(&[vec![1.0, 1.0], vec![0.4], vec![0.6]]).unwrap();
        assert!((share - 0.75).abs() < 1e-15);
        let squares = 0.5f64.powi(2) + 0.35f64.powi(2) + 0.15f64.powi(2);
        assert!((error.unwrap() - (1.5 * squares).sqrt() / 4.0).abs() < 1e-15);
        assert_eq!(share_and_error(&[vec![0.5, 0.7]]).unwrap().1, None);
        assert!(share_and_error(&[]).is_none());
    }
}
