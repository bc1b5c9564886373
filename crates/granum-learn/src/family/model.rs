//! A family with its fitted surrogate.

use std::any::Any;

use granum_core::observer::Observer;

use super::definition::FamilyDefinition;
use super::score_types::{FamilyScores, TrainingData};
use crate::curve::range;
use crate::dataset::{Dataset, RunStates};
use crate::error::{LearnError, Result};
use crate::surrogate::{
    EndedEarly, FitSpec, FittedCurves, GaussianProcessOfCurves, Surrogate, SurrogateMethod,
};

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
        let mut model = FamilyModel { definition, surrogate, rows: Vec::new(), data, scores: Vec::new() };
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

    /// The range of each input over the runs.
    pub fn ranges(&self) -> Vec<[f64; 2]> {
        let inputs = self.definition.inputs.len();
        (0..inputs).map(|input| range(self.rows.iter().map(|row| row[input]))).collect()
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
