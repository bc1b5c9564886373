//! What to fit: which columns from which, along which of them, from which seed.

use serde::{Deserialize, Serialize};

use crate::dataset::{Dataset, Variable};
use crate::error::{LearnError, Result};

/// What to fit, for any method.
///
/// ```
/// use granum_learn::FitSpec;
///
/// let spec = FitSpec::new(["arc_length", "grains.material.friction"], ["stress_ratio"]);
/// let spec = spec.with_coordinate("arc_length").with_seed(3);
/// assert_eq!((spec.inputs.len(), spec.seed), (2, 3));
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct FitSpec {
    /// Columns to predict from; the name of a histogram (`probability_density`) stands for all of its bins.
    pub inputs: Vec<String>,
    /// Columns to predict, likewise.
    pub outputs: Vec<String>,
    /// The input that runs along the path of a test, where there is one: what the others mean depends on it, and intervals
    /// may change along it.
    pub coordinate: Option<String>,
    /// Seed of what is random in a method.
    pub seed: u64,
    /// Threads; 0 for as many as the machine has. Results do not depend on it.
    pub threads: usize,
}

impl FitSpec {
    /// Predicts these outputs from these inputs, without a coordinate, from seed 1, on all threads of the machine.
    pub fn new<I: Into<String>, O: Into<String>>(
        inputs: impl IntoIterator<Item = I>,
        outputs: impl IntoIterator<Item = O>,
    ) -> FitSpec {
        FitSpec {
            inputs: inputs.into_iter().map(Into::into).collect(),
            outputs: outputs.into_iter().map(Into::into).collect(),
            coordinate: None,
            seed: 1,
            threads: 0,
        }
    }

    /// The same along a coordinate.
    pub fn with_coordinate(self, name: &str) -> FitSpec {
        FitSpec { coordinate: Some(name.into()), ..self }
    }

    /// The same from another seed.
    pub fn with_seed(self, seed: u64) -> FitSpec {
        FitSpec { seed, ..self }
    }

    /// The same on so many threads.
    pub fn with_threads(self, threads: usize) -> FitSpec {
        FitSpec { threads, ..self }
    }

    /// The columns that it means in a data set, with their units and with every bin of a histogram.
    ///
    /// # Errors
    /// If a column is not there, named twice, or both input and output, there is no input or no output, or the coordinate is no
    /// input.
    pub fn columns(&self, dataset: &Dataset) -> Result<Columns> {
        let bad = |reason: String| Err(LearnError::Dataset(reason));
        let (inputs, outputs) = (dataset.expand(&self.inputs)?, dataset.expand(&self.outputs)?);
        for (names, what) in [(&inputs, "input"), (&outputs, "output")] {
            if names.is_empty() {
                return bad(format!("there is no {what} column to fit"));
            }
            if let Some(k) = (0..names.len()).find(|&k| names[..k].contains(&names[k])) {
                return bad(format!("{} is named twice among the {what}s", names[k]));
            }
        }
        if let Some(both) = inputs.iter().find(|name| outputs.contains(name)) {
            return bad(format!("{both} is both an input and an output"));
        }
        if let Some(coordinate) = &self.coordinate
            && !inputs.contains(coordinate)
        {
            return bad(format!(
                "the coordinate {coordinate} must be one of the inputs: {}",
                inputs.join(", ")
            ));
        }
        let variables =
            |names: &[String]| names.iter().map(|name| dataset.variable(name)).collect::<Result<Vec<_>>>();
        Ok(Columns { inputs: variables(&inputs)?, outputs: variables(&outputs)? })
    }

    /// The place of the coordinate among the inputs.
    pub(crate) fn place_of_coordinate(&self, columns: &Columns) -> Option<usize> {
        let name = self.coordinate.as_ref()?;
        columns.inputs.iter().position(|input| input.name == *name)
    }
}

/// Inputs and outputs of a surrogate.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Columns {
    /// What it predicts from, in the order of a row.
    pub inputs: Vec<Variable>,
    /// What it predicts.
    pub outputs: Vec<Variable>,
}

impl Columns {
    /// Names of the inputs.
    pub fn input_names(&self) -> Vec<String> {
        self.inputs.iter().map(|variable| variable.name.clone()).collect()
    }

    /// Names of the outputs.
    pub fn output_names(&self) -> Vec<String> {
        self.outputs.iter().map(|variable| variable.name.clone()).collect()
    }
}
