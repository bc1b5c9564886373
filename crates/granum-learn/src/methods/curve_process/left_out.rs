//! Runs as predicted from others: the runs are divided into parts, and for each part components and the parameters of processes are fitted again to
//! the other runs, so that nothing that is fitted has seen the runs that it predicts. A run is then predicted from all runs but itself, in closed
//! form (Rasmussen and Williams 2006, section 5.4.2): from seven eighths of the runs errors would be larger than those of all, and intervals too wide.

use std::sync::Arc;

use granum_nets::gaussian_process::{FitOptions, GaussianProcess, ProcessPrediction, Rows};

use super::components::Components;
use super::failure::failed;
use super::predicted_curve::Curve;
use crate::error::Result;

/// Number of parts.
pub(super) const PARTS: usize = 8;
/// Most steps of a search for parameters, which begins at those of all runs.
const ITERATIONS: usize = 20;

/// The curves of an output with what the processes see of the inputs.
pub(super) struct Curves<'a> {
    pub curves: &'a [Vec<f64>],
    pub shares: &'a [f64],
    /// The values of the groups of each run; `None` where there are no inputs.
    pub rows: Option<&'a Arc<Rows>>,
    /// Parameters of the process of each component, fitted to all runs.
    pub parameters: &'a [Vec<f64>],
    pub independent: bool,
    pub options: FitOptions,
}

impl Curves<'_> {
    /// The curves of the runs of a part, as predicted from the others, each with the number of the run.
    pub fn predicted(&self, part: usize) -> Result<Vec<(usize, Curve)>> {
        let (own, others): (Vec<usize>, Vec<usize>) =
            (0..self.curves.len()).partition(|run| run % PARTS == part);
        if own.is_empty() || others.is_empty() {
            return Ok(Vec::new());
        }
        let known: Vec<Vec<f64>> = others.iter().map(|&run| self.curves[run].clone()).collect();
        let most = if others.len() > 2 { self.parameters.len() } else { 0 };
        let components = Components::new(&known, self.shares, most);
        let components = if self.independent { components.independent() } else { components };
        let weights = self.weights_left_out(&others, &components)?;
        let predicted = |run: usize| {
            let of_run: Vec<_> =
                components.components.iter().zip(&weights).map(|(c, own)| (c, own[run])).collect();
            (run, Curve::new(components.mean.clone(), components.rest.clone(), &of_run))
        };
        Ok(own.into_iter().map(predicted).collect())
    }

    /// For each component the weight of each run as predicted from all other runs, with parameters that are fitted to `others`.
    fn weights_left_out(
        &self,
        others: &[usize],
        components: &Components,
    ) -> Result<Vec<Vec<ProcessPrediction>>> {
        let Some(rows) = self.rows.filter(|_| !components.weights.is_empty()) else { return Ok(Vec::new()) };
        let values = others.iter().flat_map(|&run| rows.row(run).iter().copied()).collect();
        let known = Arc::new(Rows::new(values, rows.columns()).map_err(failed)?);
        let mut options = self.options;
        options.iterations = ITERATIONS;
        let all = components.weights_of(self.curves, self.shares);
        let all = all.ok_or_else(|| failed("components of curves depend on each other"))?;
        let fit = |((targets, all), parameters): ((&Vec<f64>, &Vec<f64>), &Vec<f64>)| {
            let fitted = GaussianProcess::fit_from(known.clone(), targets, parameters, &options);
            let fitted = fitted.map_err(failed)?;
            let process = GaussianProcess::with_parameters(rows.clone(), all, fitted.parameters().to_vec());
            // Where the others have no noise and a run has the inputs of another one, the matrix of all cannot be inverted.
            Ok(process.map_or_else(
                |_| (0..rows.count()).map(|run| fitted.predict(rows.row(run))).collect(),
                |process| process.predictions_left_out(all),
            ))
        };
        components.weights.iter().zip(&all).zip(self.parameters).map(fit).collect()
    }
}
