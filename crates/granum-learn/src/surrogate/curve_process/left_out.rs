//! Runs as predicted from others: the runs are divided into parts, and for each part components and processes are fitted again to the
//! other runs, so that nothing that is fitted has seen the runs that it predicts.

use std::sync::Arc;

use granum_nets::gaussian_process::{FitOptions, GaussianProcess, Rows};

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
    pub rows: Option<&'a Rows>,
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
        let processes = self.processes(&others, &components)?;
        let predicted = |run: usize| {
            let each = components.components.iter().zip(&processes);
            let weights: Vec<_> = match self.rows {
                Some(rows) => each.map(|(c, process)| (c, process.predict(rows.row(run)))).collect(),
                None => Vec::new(),
            };
            (run, Curve::new(components.mean.clone(), components.rest.clone(), &weights))
        };
        Ok(own.into_iter().map(predicted).collect())
    }

    fn processes(&self, others: &[usize], components: &Components) -> Result<Vec<GaussianProcess>> {
        let Some(rows) = self.rows.filter(|_| !components.weights.is_empty()) else { return Ok(Vec::new()) };
        let values = others.iter().flat_map(|&run| rows.row(run).iter().copied()).collect();
        let rows = Arc::new(Rows::new(values, rows.columns()).map_err(failed)?);
        let mut options = self.options;
        options.iterations = ITERATIONS;
        let fit = |(targets, parameters): (&Vec<f64>, &Vec<f64>)| {
            GaussianProcess::fit_from(rows.clone(), targets, parameters, &options).map_err(failed)
        };
        components.weights.iter().zip(self.parameters).map(fit).collect()
    }
}
