//! The traits of surrogates and of the methods that fit them.

use super::content::Content;
use super::prediction::Prediction;
use super::spec::{Columns, FitSpec};
use crate::dataset::Dataset;
use crate::error::{LearnError, Result};

/// A method of fitting surrogates; the documentation of [this module](super) contains a complete example.
pub trait SurrogateMethod: Send + Sync {
    /// Name of the method in files and messages.
    fn name(&self) -> &str;

    /// A short description.
    fn help(&self) -> &str;

    /// Fits a surrogate to all rows of a data set. The result depends only on the data set and the spec, and is
    /// bit-identical for any number of threads.
    ///
    /// # Errors
    /// If columns are missing, values are not finite, or there are too few rows.
    fn fit(&self, dataset: &Dataset, spec: &FitSpec) -> Result<Box<dyn Surrogate>>;

    /// Recreates a surrogate from the result of [`Surrogate::content`].
    ///
    /// # Errors
    /// If the content is not that of such a surrogate with these columns; the message gives the reason.
    fn load(&self, columns: Columns, content: &Content) -> Result<Box<dyn Surrogate>>;
}

/// A fitted model, which predicts outputs from inputs. The documentation of [this module](super) contains a complete example.
pub trait Surrogate: Send + Sync {
    /// Name of the method with which it was fitted and by which it is loaded.
    fn method(&self) -> &str;

    /// The inputs and outputs.
    fn columns(&self) -> &Columns;

    /// Predicts rows, each with a finite value for every input in order, which [`Surrogate::predict`] ensures. The
    /// intervals should contain the given share (0 to 1) of the observations of new runs.
    ///
    /// # Errors
    /// If a row cannot be predicted.
    fn answer(&self, rows: &[&[f64]], level: f64) -> Result<Vec<Prediction>>;

    /// Everything that is needed for bit-identical predictions after loading.
    ///
    /// # Errors
    /// If the content cannot be represented in JSON.
    fn content(&self) -> Result<Content>;

    /// Predicts rows, given in row-major order with a value for every input in order.
    ///
    /// # Errors
    /// If `rows` does not contain a whole number of rows, a value is not finite, or the level is not between 0 and 1.
    fn predict(&self, rows: &[f64], level: f64) -> Result<Vec<Prediction>> {
        let names = self.columns().input_names();
        let problem = |reason: String| LearnError::Surrogate { method: self.method().into(), reason };
        if !(level > 0.0 && level < 1.0) {
            return Err(problem(format!("the level of an interval must be between 0 and 1, not {level}")));
        }
        if names.is_empty() || !rows.len().is_multiple_of(names.len()) {
            let (needed, list) = (names.len(), names.join(", "));
            return Err(problem(format!(
                "a row has {needed} values ({list}); {} values are not a whole number of rows",
                rows.len()
            )));
        }
        if let Some(k) = rows.iter().position(|value| !value.is_finite()) {
            let (row, name) = (k / names.len() + 1, &names[k % names.len()]);
            return Err(problem(format!("row {row}: {name} is {}, not a finite number", rows[k])));
        }
        let rows: Vec<&[f64]> = rows.chunks_exact(names.len()).collect();
        let predictions = self.answer(&rows, level)?;
        let outputs = self.columns().outputs.len();
        if predictions.len() != rows.len() || predictions.iter().any(|p| p.values.len() != outputs) {
            let reason = format!("it did not return {} rows with {outputs} values each", rows.len());
            return Err(problem(reason));
        }
        Ok(predictions)
    }
}
