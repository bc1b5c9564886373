//! Runs as predicted from others: the runs are divided into parts, and for each part components and processes are fitted again to the
//! other runs, so that nothing that is fitted has seen the runs that it predicts.

use std::sync::Arc;

use granum_nets::gaussian_process::{FitOptions, GaussianProcess, Rows};

use super::components::Components;
use super::failure::failed;
use crate::error::Result;

/// Number of parts.
pub(super) const PARTS: usize = 8;
/// Most steps of a search for parameters, which begins at those of all runs.
const ITERATIONS: usize = 20;

/// The number of a run with its errors over their standard deviations, at each point.
pub(super) type RunErrors = (usize, Vec<f64>);

/// The curves of an output with what the processes see of the inputs.
pub(super) struct Curves<'a> {
    pub curves: &'a [Vec<f64>],
    pub shares: &'a [f64],
    /// The values of the groups of each run; `None` where there are no inputs.
    pub rows: Option<&'a Rows>,
    /// Parameters of the process of each component, fitted to all runs.
    pub parameters: &'a [Vec<f64>],
    pub options: FitOptions,
}

impl Curves<'_> {
    /// The errors of the runs of a part.
    pub fn errors(&self, part: usize) -> Result<Vec<RunErrors>> {
        let (own, others): (Vec<usize>, Vec<usize>) =
            (0..self.curves.len()).partition(|run| run % PARTS == part);
        if own.is_empty() || others.is_empty() {
            return Ok(Vec::new());
        }
        let known: Vec<Vec<f64>> = others.iter().map(|&run| self.curves[run].clone()).collect();
        let most = if others.len() > 2 { self.parameters.len() } else { 0 };
        let components = Components::new(&known, self.shares, most);
        let processes = self.processes(&others, &components)?;
        let errors = |&run: &usize| {
            let weights: Vec<_> = match self.rows {
                Some(rows) => processes.iter().map(|process| process.predict(rows.row(run))).collect(),
                None => Vec::new(),
            };
            let at = |point: usize| {
                let (mut value, mut variance) = (components.mean[point], components.rest[point]);
                for (component, weight) in components.components.iter().zip(&weights) {
                    let value_at = component[point];
                    value += weight.mean * value_at;
                    variance += value_at * value_at * (weight.variance + weight.noise);
                }
                // A point at which all curves are equal has no error and no variance.
                let error = self.curves[run][point] - value;
                if error == 0.0 { 0.0 } else { error / variance.sqrt().max(1e-300) }
            };
            (run, (0..self.shares.len()).map(at).collect())
        };
        Ok(own.iter().map(errors).collect())
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
