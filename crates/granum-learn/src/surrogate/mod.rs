//! Surrogates: models of any kind that are fitted to a data set and predict with an uncertainty.
//!
//! A [`SurrogateMethod`] fits and loads surrogates, and a [`Surrogate`] is the fitted model. Both traits are open: a
//! user-defined method can be added to [`SurrogateMethods`], and is scored by [`crate::compare`] and saved by [`save`]
//! like those of this crate. The following is a complete example, which predicts the mean of the training rows:
//!
//! ```
//! use granum_core::observer::{NoObserver, Observer};
//! use granum_learn::surrogate::{
//!     self, Cause, Columns, Content, Estimate, FitSpec, Prediction, RunInputs, Surrogate, SurrogateMethod,
//!     SurrogateMethods,
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
//!     fn fit(
//!         &self,
//!         dataset: &Dataset,
//!         spec: &FitSpec,
//!         _: &mut dyn Observer,
//!     ) -> Result<Box<dyn Surrogate>> {
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
//!     fn evaluate(&self, inputs: &RunInputs, level: f64) -> Result<Vec<Prediction>> {
//!         let quantile = granum_nets::two_sided_quantile(level, f64::INFINITY);
//!         let estimates = self.moments.iter().map(|[mean, sd]| Estimate::new(*mean).by(vec![(Cause::Noise, *sd)], quantile));
//!         Ok(vec![Prediction::new(estimates.collect()); inputs.len()])
//!     }
//!     fn content(&self) -> Result<Content> {
//!         Content::new(&self.moments)
//!     }
//! }
//!
//! # use granum_core::{Column, Table};
//! # use granum_learn::RunStates;
//! let columns = vec![Column::new("x", "", vec![0.0, 1.0, 2.0]), Column::new("y", "", vec![1.0, 2.0, 3.0])];
//! let dataset = Dataset::new(vec![RunStates::new("run", Table::new(columns)?)?])?;
//! let methods = SurrogateMethods::standard().with(Mean)?;
//! let fitted = methods.by_name("mean")?.fit(&dataset, &FitSpec::new(["x"], ["y"]), &mut NoObserver)?;
//! assert_eq!(fitted.predict_rows(&[5.0], 0.9)?[0].values[0].mean, 2.0);
//! // A saved surrogate is loaded by the name of its method.
//! let text = surrogate::to_json(fitted.as_ref())?;
//! assert_eq!(methods.from_json(&text, "mean.json")?.predict_rows(&[5.0], 0.9)?, fitted.predict_rows(&[5.0], 0.9)?);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub(crate) mod checkpoints;
pub(crate) mod content;
pub(crate) mod file;
pub(crate) mod onnx_estimates;
pub(crate) mod possible_values;
pub(crate) mod prediction;
pub(crate) mod run_inputs;
pub(crate) mod run_memory;
pub(crate) mod run_steps;
pub(crate) mod settings;
pub(crate) mod spec;
pub(crate) mod stream;
#[cfg(test)]
pub(crate) mod stream_tests;
pub(crate) mod sub_model;
pub(crate) mod surrogate_trait;

pub use crate::methods::{
    BoostedTrees, Cascade, CorrelatedCurve, EndedEarly, ErrorCorrelation, FeedForward, FittedCascade,
    FittedCurves, FurtherRun, GaussianProcessOfCurves, LeftOutCurves, MeanCurve, NearestRun, NextRuns,
    PathCell, PathNetworks, Recurrent, RidgeRegression, SurrogateMethods, method_of_words,
};
pub use content::Content;
pub use file::{save, to_json};
pub use possible_values::possible_values;
pub use prediction::{Cause, Estimate, Interval, Outside, Prediction, UnseenCombination, causes, outside_of};
pub use run_inputs::RunInputs;
pub use run_memory::RunMemory;
pub use run_steps::RunSteps;
pub use spec::{Columns, FitSpec};
pub use stream::PredictionStream;
pub use surrogate_trait::{Surrogate, SurrogateMethod};
pub(crate) use surrogate_trait::{check_finite, check_level};
