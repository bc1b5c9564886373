//! Surrogates: models of any kind that are fitted to a data set and predict with an uncertainty.
//!
//! A [`SurrogateMethod`] fits and loads surrogates, and a [`Surrogate`] is the fitted model. Both traits are open: a
//! user-defined method can be added to [`SurrogateMethods`], and is scored by [`crate::compare`] and saved by [`save`]
//! like those of this crate. The following is a complete example, which predicts the mean of the training rows:
//!
//! ```
//! use granum_learn::surrogate::{
//!     self, Cause, Columns, Content, Estimate, FitSpec, Prediction, Surrogate, SurrogateMethod, SurrogateMethods,
//! };
//! use granum_learn::{Dataset, Result};
//!
//! struct Mean;
//!
//! struct FittedMean {
//!     columns: Columns,
//!     /// Mean and standard deviation of each output.
//!     moments: Vec<[f64; 2]>,
//! }
//!
//! impl SurrogateMethod for Mean {
//!     fn name(&self) -> &str {
//!         "mean"
//!     }
//!     fn help(&self) -> &str {
//!         "the mean of the training rows"
//!     }
//!     fn fit(&self, dataset: &Dataset, spec: &FitSpec) -> Result<Box<dyn Surrogate>> {
//!         let columns = spec.columns(dataset)?;
//!         let moments = |name: &String| {
//!             let values = dataset.values(&[name])?;
//!             let n = values.len() as f64;
//!             let mean = values.iter().sum::<f64>() / n;
//!             Ok([mean, (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt()])
//!         };
//!         let moments = columns.output_names().iter().map(moments).collect::<Result<_>>()?;
//!         Ok(Box::new(FittedMean { columns, moments }))
//!     }
//!     fn load(&self, columns: Columns, content: &Content) -> Result<Box<dyn Surrogate>> {
//!         Ok(Box::new(FittedMean { moments: content.read()?, columns }))
//!     }
//! }
//!
//! impl Surrogate for FittedMean {
//!     fn method(&self) -> &str {
//!         "mean"
//!     }
//!     fn columns(&self) -> &Columns {
//!         &self.columns
//!     }
//!     fn answer(&self, rows: &[&[f64]], level: f64) -> Result<Vec<Prediction>> {
//!         let quantile = granum_nets::two_sided_quantile(level, f64::INFINITY);
//!         let estimates = self.moments.iter().map(|[mean, sd]| Estimate::new(*mean).by(vec![(Cause::Noise, *sd)], quantile));
//!         Ok(vec![Prediction::new(estimates.collect()); rows.len()])
//!     }
//!     fn content(&self) -> Result<Content> {
//!         Content::of(&self.moments)
//!     }
//! }
//!
//! # use granum_core::{Column, Table};
//! # use granum_learn::RunStates;
//! let columns = vec![Column::new("x", "", vec![0.0, 1.0, 2.0]), Column::new("y", "", vec![1.0, 2.0, 3.0])];
//! let dataset = Dataset::new(vec![RunStates::new("run", Table::new(columns)?)?])?;
//! let methods = SurrogateMethods::standard().with(Mean);
//! let fitted = methods.by_name("mean")?.fit(&dataset, &FitSpec::new(["x"], ["y"]))?;
//! assert_eq!(fitted.predict(&[5.0], 0.9)?[0].values[0].mean, 2.0);
//! // A saved surrogate is loaded by the name of its method.
//! let text = surrogate::to_json(fitted.as_ref())?;
//! assert_eq!(methods.from_json(&text, "mean.json")?.predict(&[5.0], 0.9)?, fitted.predict(&[5.0], 0.9)?);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod feed_forward;
mod file;
mod prediction;
mod registry;
mod ridge;
mod spec;
#[cfg(test)]
mod tests;

use crate::dataset::Dataset;
use crate::error::{LearnError, Result};

pub use feed_forward::FeedForward;
pub(crate) use feed_forward::causes;
pub use file::{Content, save, to_json};
pub use prediction::{Cause, Estimate, Interval, Outside, Prediction, outside_of};
pub use registry::SurrogateMethods;
pub use ridge::RidgeRegression;
pub use spec::{Columns, FitSpec};

/// A method of fitting surrogates; the documentation of [this module](self) contains a complete example.
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

/// A fitted model, which predicts outputs from inputs. The documentation of [this module](self) contains a complete example.
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
            return Err(problem(format!("an interval holds a share between 0 and 1, not {level}")));
        }
        if names.is_empty() || !rows.len().is_multiple_of(names.len()) {
            let (needed, list) = (names.len(), names.join(", "));
            return Err(problem(format!(
                "rows have {needed} values ({list}); {} values are no such rows",
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
            let reason = format!("it did not answer {} rows with {outputs} values each", rows.len());
            return Err(problem(reason));
        }
        Ok(predictions)
    }
}
