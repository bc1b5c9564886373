//! The specification of a fit: inputs, outputs, coordinate and seed.

use serde::{Deserialize, Serialize};

use crate::dataset::{Category, Dataset, Variable};
use crate::error::{LearnError, Result};
use crate::methods::networks::{SubModel, is_within};

/// The specification of a fit, which is the same for all methods.
///
/// ```
/// use granum_learn::FitSpec;
///
/// let spec = FitSpec::new(["arc_length", "grains.material.friction"], ["stress_ratio"]);
/// let spec = spec.with_coordinate("arc_length").with_seed(3);
/// assert_eq!((spec.inputs.len(), spec.seed), (2, 3));
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct FitSpec {
    /// Names of the input columns; the name of a histogram (`probability_density`) represents all of its bins, and that of a category
    /// (`contact.normal`) is one column of zeros and ones for each of its words in the data set of the fit.
    pub inputs: Vec<String>,
    /// Names of the output columns, with the same rule for histograms; they cannot be categories.
    pub outputs: Vec<String>,
    /// The input that parametrises the path of a test, if there is one: the meaning of the other inputs depends on it, and
    /// intervals may vary along it.
    pub coordinate: Option<String>,
    /// Seed of the random numbers of a method.
    pub seed: u64,
    /// Its name; by default that of the outputs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Ranges of the coordinate with networks of their own, for the method that has such networks. States outside all ranges are
    /// not scored, for any method, and inputs are permuted within the ranges.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sub_models: Vec<SubModel>,
    /// The name under which networks are kept while the fit is unfinished; by default that of the fit.
    #[serde(skip)]
    pub kept_as: Option<String>,
    /// Number of threads; 0 for the number of processors. Results do not depend on it.
    #[serde(skip)]
    pub threads: usize,
}

impl FitSpec {
    /// A specification with the given inputs and outputs, without a coordinate, with seed 1 and one thread per processor.
    pub fn new<I: Into<String>, O: Into<String>>(
        inputs: impl IntoIterator<Item = I>,
        outputs: impl IntoIterator<Item = O>,
    ) -> FitSpec {
        FitSpec {
            inputs: inputs.into_iter().map(Into::into).collect(),
            outputs: outputs.into_iter().map(Into::into).collect(),
            coordinate: None,
            seed: 1,
            name: None,
            sub_models: Vec::new(),
            kept_as: None,
            threads: 0,
        }
    }

    /// Sets the coordinate.
    pub fn with_coordinate(self, name: &str) -> FitSpec {
        FitSpec { coordinate: Some(name.into()), ..self }
    }

    /// Sets the name.
    pub fn with_name(self, name: &str) -> FitSpec {
        FitSpec { name: Some(name.into()), ..self }
    }

    /// Sets the sub-models.
    pub fn with_sub_models(self, sub_models: Vec<SubModel>) -> FitSpec {
        FitSpec { sub_models, ..self }
    }

    /// Sets the seed.
    pub fn with_seed(self, seed: u64) -> FitSpec {
        FitSpec { seed, ..self }
    }

    /// Sets the number of threads.
    pub fn with_threads(self, threads: usize) -> FitSpec {
        FitSpec { threads, ..self }
    }

    /// Its name, by default that of the outputs. It is a part of file names, so that other signs than letters, digits, `-` and
    /// `_` are replaced.
    pub fn fit_name(&self) -> String {
        let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' };
        self.name.clone().unwrap_or_else(|| self.outputs.join("_")).chars().map(plain).collect()
    }

    /// The name under which a network of the fit is kept.
    pub(crate) fn network_kept_as(&self, network: &str) -> String {
        format!("{}-{network}", self.kept_as.clone().unwrap_or_else(|| self.fit_name()))
    }

    /// For each state of a data set whether it is scored: all states without sub-models.
    ///
    /// # Errors
    /// If the coordinate is missing.
    pub fn scored_states(&self, dataset: &Dataset) -> Result<Vec<bool>> {
        match &self.coordinate {
            Some(coordinate) if !self.sub_models.is_empty() && dataset.rows() > 0 => {
                let xs = dataset.column(coordinate)?;
                Ok(xs.iter().map(|x| is_within(&self.sub_models, *x, None)).collect())
            }
            _ => Ok(vec![true; dataset.rows()]),
        }
    }

    /// The corresponding columns of a data set, with their units and with all bins of histograms.
    ///
    /// # Errors
    /// If a column does not exist, is named twice, or is both input and output; if there is no input or no output; or if the
    /// coordinate is not an input.
    pub fn columns(&self, dataset: &Dataset) -> Result<Columns> {
        let bad = |reason: String| Err(LearnError::Dataset(reason));
        let no_number = self.outputs.iter().map(|name| (name, "an output"));
        for (name, what) in no_number.chain(self.coordinate.iter().map(|name| (name, "the coordinate"))) {
            if let Some(category) = dataset.category(name) {
                let words = category.list();
                return bad(format!("{name} holds words ({words}); {what} must be a number"));
            }
        }
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

    /// Index of the coordinate among the inputs.
    pub(crate) fn place_of_coordinate(&self, columns: &Columns) -> Option<usize> {
        let name = self.coordinate.as_ref()?;
        columns.inputs.iter().position(|input| input.name == *name)
    }
}

/// Inputs and outputs of a surrogate.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Columns {
    /// The inputs in the order of a row.
    pub inputs: Vec<Variable>,
    /// The outputs.
    pub outputs: Vec<Variable>,
}

impl Columns {
    /// Names of the inputs.
    pub fn input_names(&self) -> Vec<String> {
        self.inputs.iter().map(|variable| variable.name.clone()).collect()
    }

    /// The categories among the inputs, each with the words to which a surrogate is fitted.
    pub fn categories(&self) -> Vec<Category> {
        Category::among(self.inputs.iter().map(|variable| variable.name.as_str()))
    }

    /// Names of the outputs.
    pub fn output_names(&self) -> Vec<String> {
        self.outputs.iter().map(|variable| variable.name.clone()).collect()
    }
}
