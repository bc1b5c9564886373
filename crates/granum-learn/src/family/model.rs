//! A family with its fitted surrogate.

use std::any::Any;

use granum_core::observer::Observer;

use super::definition::FamilyDefinition;
use super::score_types::{FamilyScores, TrainingData};
use super::typical::TypicalValues;
use crate::curve::range;
use crate::dataset::{Dataset, RunStates};
use crate::error::{LearnError, Result};
use crate::surrogate::{
    EndedEarly, FitSpec, FittedCurves, GaussianProcessOfCurves, Surrogate, SurrogateMethod,
};

/// Part of the range between two limits up to which runs are close to one of them.
const CLOSE: f64 = 0.05;
/// Ratio of two limits beyond which the logarithm counts.
const WIDE: f64 = 10.0;

/// How the surrogate of a family is fitted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FamilyFit {
    /// The method, by default with its default settings.
    pub method: GaussianProcessOfCurves,
    /// Number of threads; 0 for the number of processors. Results do not depend on it.
    pub threads: usize,
}

/// A family with its fitted surrogate.
pub struct FamilyModel {
    pub(super) definition: &'static FamilyDefinition,
    pub(super) surrogate: Box<dyn Surrogate>,
    /// The inputs of each run to which it was fitted.
    pub(super) rows: Vec<Vec<f64>>,
    pub(super) data: Vec<TrainingData>,
    pub(super) scores: Vec<FamilyScores>,
    pub(super) typical: TypicalValues,
}

impl FamilyModel {
    /// Fits the surrogate of a family to runs; `data` says whose they are. Runs whose curves end early are left out, and the observer is
    /// told so.
    ///
    /// # Errors
    /// If a run is not of the family or lacks an input or output, and as [`SurrogateMethod::fit`].
    pub fn fit(
        definition: &'static FamilyDefinition,
        dataset: &Dataset,
        data: Vec<TrainingData>,
        fit: &FamilyFit,
        observer: &mut dyn Observer,
    ) -> Result<FamilyModel> {
        let dataset = with_columns(definition, dataset)?;
        let names = definition.inputs.iter().map(|input| input.name);
        let inputs = [definition.coordinate].into_iter().chain(names);
        let spec = FitSpec::new(inputs, definition.outputs.iter().map(|output| output.column))
            .with_coordinate(definition.coordinate)
            .with_threads(fit.threads);
        let surrogate = fit.method.fit(&dataset, &spec, observer)?;
        let mut model = FamilyModel {
            definition,
            surrogate,
            rows: Vec::new(),
            data,
            scores: Vec::new(),
            typical: TypicalValues::default(),
        };
        let left_out: Vec<String> = model.left_out().iter().map(|early| early.run.clone()).collect();
        let kept = dataset.runs().iter().filter(|run| !left_out.iter().any(|name| name == run.name()));
        model.rows = kept.map(|run| inputs_of(definition, run)).collect::<Result<_>>()?;
        Ok(model)
    }

    /// The family.
    pub fn definition(&self) -> &'static FamilyDefinition {
        self.definition
    }

    /// The surrogate.
    pub fn surrogate(&self) -> &dyn Surrogate {
        self.surrogate.as_ref()
    }

    /// The data to which it was fitted.
    pub fn data(&self) -> &[TrainingData] {
        &self.data
    }

    /// The number of runs to which it was fitted.
    pub fn runs(&self) -> usize {
        self.rows.len()
    }

    /// The runs that were left out because their curves end early.
    pub fn left_out(&self) -> &[EndedEarly] {
        self.curves().map_or(&[], FittedCurves::left_out)
    }

    /// The range of each input in which a prediction is no extrapolation: that of the runs, up to the limits that the plan of the family states
    /// where runs come as close to them as their number allows.
    pub fn ranges(&self) -> Vec<[f64; 2]> {
        let inputs = self.definition.inputs.iter().zip(self.run_ranges());
        inputs.map(|(input, runs)| input.limits.map_or(runs, |limits| up_to_limits(runs, limits))).collect()
    }

    /// The range of each input over the runs.
    pub(super) fn run_ranges(&self) -> Vec<[f64; 2]> {
        (0..self.definition.inputs.len()).map(|input| range(self.values_of(input))).collect()
    }

    /// The values of an input in all runs.
    pub(super) fn values_of(&self, input: usize) -> Vec<f64> {
        self.rows.iter().map(|row| row[input]).collect()
    }

    /// The scores on runs that it has not seen.
    pub fn scores(&self) -> &[FamilyScores] {
        &self.scores
    }

    /// Adds scores, which replace those on data of the same name.
    pub fn add_scores(&mut self, scores: FamilyScores) {
        self.scores.retain(|known| known.data != scores.data);
        self.scores.push(scores);
    }

    /// The curves of a run at the points of the coordinate, one for each column of the surrogate; `None` if the run ends before the last
    /// point.
    ///
    /// # Errors
    /// If the run is not of the family or lacks a column, or the coordinate turns in it.
    pub fn measured(&self, run: &RunStates) -> Result<Option<Vec<Vec<f64>>>> {
        let run = self.definition.with_columns(run)?;
        self.curves().map_or(Ok(None), |curves| curves.measured(&run))
    }

    /// The part of the coordinate that each of its points stands for; the sum is 1.
    pub fn shares(&self) -> Vec<f64> {
        self.curves().map_or_else(Vec::new, FittedCurves::shares)
    }

    pub(super) fn curves(&self) -> Option<&FittedCurves> {
        let any: &dyn Any = self.surrogate.as_ref();
        any.downcast_ref()
    }
}

/// A range of runs with those of its limits to which it comes close, over its width or over that of its logarithm.
fn up_to_limits(runs: [f64; 2], limits: [f64; 2]) -> [f64; 2] {
    let [low, high] = limits;
    let is_logarithmic = low > 0.0 && high > WIDE * low;
    let place = |value: f64| match is_logarithmic {
        true => libm::log(value.max(f64::MIN_POSITIVE) / low) / libm::log(high / low),
        false => (value - low) / (high - low),
    };
    [
        if place(runs[0]) <= CLOSE { runs[0].min(low) } else { runs[0] },
        if place(runs[1]) >= 1.0 - CLOSE { runs[1].max(high) } else { runs[1] },
    ]
}

/// The runs with the inputs and outputs of the family.
pub(super) fn with_columns(definition: &FamilyDefinition, dataset: &Dataset) -> Result<Dataset> {
    Dataset::new(dataset.runs().iter().map(|run| definition.with_columns(run)).collect::<Result<_>>()?)
}

/// The inputs of a run in order.
pub(super) fn inputs_of(definition: &FamilyDefinition, run: &RunStates) -> Result<Vec<f64>> {
    definition.inputs.iter().map(|input| input.of_run(run)).collect()
}

/// The error of content that does not fit together.
pub(super) fn unfit(reason: &str) -> LearnError {
    LearnError::Content(format!("family: {reason}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_within_where_runs_come_close_to_them() {
        assert_eq!(up_to_limits([0.101, 0.799], [0.1, 0.8]), [0.1, 0.8]);
        // Runs of another plan stay what they are.
        assert_eq!(up_to_limits([0.3, 0.5], [0.1, 0.8]), [0.3, 0.5]);
        assert_eq!(up_to_limits([0.05, 0.9], [0.1, 0.8]), [0.05, 0.9]);
        assert_eq!(up_to_limits([1.1e-5, 3.9e-4], [1e-5, 4e-4]), [1e-5, 4e-4]);
        assert_eq!(up_to_limits([2e-5, 1e-4], [1e-5, 4e-4]), [2e-5, 1e-4]);
    }
}
