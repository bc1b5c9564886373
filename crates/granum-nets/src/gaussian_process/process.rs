//! A Gaussian process with fitted parameters.

use std::sync::Arc;

use granum_simd::{Isa, Row8};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use super::covariance::{Covariance, parameter_count};
use super::error::GaussianProcessError;
use super::evidence::{Factorised, posterior};
use super::prior::Prior;
use super::rows::{RowLanes, Rows};
use crate::linear_algebra::minimise::minimise;
use crate::random::uniform;

/// Decrease of the logarithm of the posterior at which the search for its maximum ends.
const TOLERANCE: f64 = 1e-4;

/// How a process is fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct FitOptions {
    /// Number of searches for the most probable parameters: one from the mode of the prior, others from parameters drawn from it (2).
    pub starts: usize,
    /// Most steps of a search (60).
    pub iterations: usize,
    /// Most rows, evenly spread, by which parameters are judged (300); predictions use all rows.
    pub most_rows: usize,
    /// Seed of the drawn parameters (1).
    pub seed: u64,
    /// What is thought of the parameters before the rows are seen ([`Prior::Wide`]).
    pub prior: Prior,
}

impl Default for FitOptions {
    fn default() -> Self {
        FitOptions { starts: 2, iterations: 60, most_rows: 300, seed: 1, prior: Prior::Wide }
    }
}

/// The prediction of a process for a row.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ProcessPrediction {
    /// The mean.
    pub mean: f64,
    /// Variance of the mean: what more rows would reduce.
    pub variance: f64,
    /// Variance of the noise of a single observation: what they would not.
    pub noise: f64,
}

/// A row as predicted from all others.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct LeftOut {
    /// The mean.
    pub mean: f64,
    /// Variance of the observation about it, with its noise.
    pub variance: f64,
}

/// A row at which a further observation could be made, for [`GaussianProcess::reduction`].
#[derive(Clone, Debug, PartialEq)]
pub struct FurtherRow {
    row: Vec<f64>,
    /// `A^-1 k`, with the covariances k of the row with those that were observed.
    solved: Vec<f64>,
    /// Variance of the observation, with its noise, for targets with a standard deviation of one.
    variance: f64,
}

/// A Gaussian process: a distribution of functions, of which those near the observed targets remain.
#[derive(Clone, Debug)]
pub struct GaussianProcess {
    rows: Arc<Rows>,
    lanes: RowLanes,
    logarithms: Vec<f64>,
    covariance: Covariance,
    factorised: Factorised,
    /// `A^-1 y`.
    solved: Vec<f64>,
    /// Mean and standard deviation of the targets.
    scale: [f64; 2],
}

impl GaussianProcess {
    /// Fits a process: the parameters of its covariance are the most probable ones. The result depends on the arguments alone, to the
    /// bit.
    ///
    /// # Errors
    /// If the number of targets is not that of the rows, a target is not finite, or the covariance cannot be factorised.
    pub fn fit(
        rows: Arc<Rows>,
        targets: &[f64],
        options: &FitOptions,
    ) -> Result<GaussianProcess, GaussianProcessError> {
        let prior = options.prior.of_logarithms(rows.columns());
        let mut random = ChaCha8Rng::seed_from_u64(options.seed);
        let mut start = |k: usize| {
            let drawn = |[mean, deviation]: &[f64; 2]| match k {
                0 => *mean,
                _ => mean + 1.5 * deviation * uniform(&mut random),
            };
            prior.iter().map(drawn).collect()
        };
        let starts: Vec<Vec<f64>> = (0..options.starts.max(1)).map(&mut start).collect();
        GaussianProcess::best_of(rows, targets, &starts, options)
    }

    /// Fits a process by a single search from given parameters, such as those of nearly the same rows.
    ///
    /// # Errors
    /// As [`GaussianProcess::fit`] and [`GaussianProcess::with_parameters`].
    pub fn fit_from(
        rows: Arc<Rows>,
        targets: &[f64],
        parameters: &[f64],
        options: &FitOptions,
    ) -> Result<GaussianProcess, GaussianProcessError> {
        check_parameters(&rows, parameters)?;
        GaussianProcess::best_of(rows, targets, &[parameters.to_vec()], options)
    }

    fn best_of(
        rows: Arc<Rows>,
        targets: &[f64],
        starts: &[Vec<f64>],
        options: &FitOptions,
    ) -> Result<GaussianProcess, GaussianProcessError> {
        check_targets(&rows, targets)?;
        let used = rows.thinned(options.most_rows);
        let some = RowLanes::new(&rows.at(&used));
        let chosen: Vec<f64> = used.iter().map(|&k| targets[k]).collect();
        let [mean, deviation] = mean_and_deviation(&chosen);
        let chosen: Vec<f64> = chosen.iter().map(|y| (y - mean) / deviation).collect();
        let prior = options.prior.of_logarithms(rows.columns());
        let mut best: Option<(f64, Vec<f64>)> = None;
        for start in starts {
            let mut value = |logarithms: &[f64]| posterior(&some, &chosen, &prior, logarithms);
            let found = minimise(start, options.iterations, TOLERANCE, &mut value);
            if let Some(found) = found
                && best.as_ref().is_none_or(|(least, _)| found.value < *least)
            {
                best = Some((found.value, found.at));
            }
        }
        let (_, logarithms) = best.ok_or(GaussianProcessError::NotPositive)?;
        GaussianProcess::with_parameters(rows, targets, logarithms)
    }

    /// A process with given parameters, as [`GaussianProcess::parameters`] returns them: the same rows and targets give the same process.
    ///
    /// # Errors
    /// As [`GaussianProcess::fit`], and if the number of parameters is another or one is not finite.
    pub fn with_parameters(
        rows: Arc<Rows>,
        targets: &[f64],
        logarithms: Vec<f64>,
    ) -> Result<GaussianProcess, GaussianProcessError> {
        check_targets(&rows, targets)?;
        check_parameters(&rows, &logarithms)?;
        let scale = mean_and_deviation(targets);
        GaussianProcess::with_scale(rows, targets, logarithms, scale)
    }

    /// The same, with the mean and the standard deviation by which targets are scaled.
    pub(super) fn with_scale(
        rows: Arc<Rows>,
        targets: &[f64],
        logarithms: Vec<f64>,
        scale: [f64; 2],
    ) -> Result<GaussianProcess, GaussianProcessError> {
        let inputs = rows.columns();
        let covariance = Covariance::new(inputs, &logarithms);
        let lanes = RowLanes::new(&rows);
        let factorised = Factorised::new(&covariance, &lanes).ok_or(GaussianProcessError::NotPositive)?;
        let scaled: Vec<f64> = targets.iter().map(|y| (y - scale[0]) / scale[1]).collect();
        let solved = factorised.solve(&scaled);
        Ok(GaussianProcess { rows, lanes, logarithms, covariance, factorised, solved, scale })
    }

    /// The logarithms of the fitted parameters.
    pub fn parameters(&self) -> &[f64] {
        &self.logarithms
    }

    /// The prediction for a row.
    ///
    /// # Panics
    /// If the row has another number of inputs.
    pub fn predict(&self, row: &[f64]) -> ProcessPrediction {
        let (with, own) = self.with_observations(row);
        let square = self.scale[1] * self.scale[1];
        ProcessPrediction {
            mean: self.mean_of(&with),
            variance: square * (own - self.factorised.quadratic(with)).max(0.0),
            noise: self.noise(),
        }
    }

    /// The prediction for a row without its variance, in whose place zero stands: it takes a number of operations that grows with that of the
    /// observations, while the variance takes one that grows with its square. The mean has the same bits.
    ///
    /// # Panics
    /// If the row has another number of inputs.
    pub fn predict_mean(&self, row: &[f64]) -> ProcessPrediction {
        ProcessPrediction {
            mean: self.mean_of(&self.with_observations(row).0),
            variance: 0.0,
            noise: self.noise(),
        }
    }

    /// The covariances of a row with those that were observed, and its variance before anything was.
    fn with_observations(&self, row: &[f64]) -> (Vec<Row8>, f64) {
        assert_eq!(row.len(), self.rows.columns(), "inputs of a row");
        self.covariance.with(Isa::detect(), row, &self.lanes)
    }

    fn mean_of(&self, with: &[Row8]) -> f64 {
        let mean: f64 = Row8::numbers(with).iter().zip(&self.solved).map(|(k, a)| k * a).sum();
        let [centre, deviation] = self.scale;
        centre + deviation * mean
    }

    /// Prepares a further observation.
    ///
    /// # Panics
    /// If the row has another number of inputs.
    pub fn further(&self, row: &[f64]) -> FurtherRow {
        assert_eq!(row.len(), self.rows.columns(), "inputs of a row");
        let (with, own) = self.covariance.with(Isa::detect(), row, &self.lanes);
        let solved = self.factorised.solve(&Row8::numbers(&with)[..self.rows.count()]);
        let variance = (own - self.factorised.quadratic(with)).max(0.0) + self.covariance.noise();
        FurtherRow { row: row.to_vec(), solved, variance }
    }

    /// By how much a further observation would reduce the variance of the mean at a row, whatever its value turned out to be:
    /// `c^2 / (v + n)`, with the covariance c of the function at both rows, and the variance v and the noise n at the further one.
    ///
    /// # Panics
    /// If the row has another number of inputs.
    pub fn reduction(&self, row: &[f64], further: &FurtherRow) -> f64 {
        assert_eq!(row.len(), self.rows.columns(), "inputs of a row");
        let covariance = self.remaining_scaled(row, &self.covariances(row), further);
        let square = self.scale[1] * self.scale[1];
        if further.variance > 0.0 { square * covariance * covariance / further.variance } else { 0.0 }
    }

    /// The covariances of a row with those that were observed, before anything was.
    pub(super) fn covariances(&self, row: &[f64]) -> Vec<Row8> {
        self.covariance.with(Isa::detect(), row, &self.lanes).0
    }

    /// The covariance of the function at a row, given by its covariances with those that were observed, and at a further one.
    pub(super) fn remaining(&self, row: &[f64], with: &[Row8], further: &FurtherRow) -> f64 {
        self.scale[1] * self.scale[1] * self.remaining_scaled(row, with, further)
    }

    /// The same for targets with a standard deviation of one.
    fn remaining_scaled(&self, row: &[f64], with: &[Row8], further: &FurtherRow) -> f64 {
        let known: f64 = Row8::numbers(with).iter().zip(&further.solved).map(|(k, a)| k * a).sum();
        self.covariance.between(row, &further.row) - known
    }

    /// `A^-1`, row-major.
    pub(super) fn inverse(&self) -> Vec<f64> {
        self.factorised.clone().inverse()
    }

    /// `A^-1 y` with scaled targets, and the standard deviation by which they were scaled.
    pub(super) fn solved(&self) -> (&[f64], f64) {
        (&self.solved, self.scale[1])
    }

    /// The lower triangular matrix `F`, row-major, with which `|F b|^2 = b^T A^-1 b` for the covariance `A` of the targets, scaled to a standard deviation of one, with
    /// their noise. It takes as many operations as `A^-1` does.
    pub fn inverse_factor(&self) -> Vec<f64> {
        self.factorised.inverse_factor()
    }

    pub(super) fn covariance(&self) -> &Covariance {
        &self.covariance
    }

    pub(super) fn rows(&self) -> &Rows {
        &self.rows
    }

    /// Mean and standard deviation by which targets are scaled.
    pub(super) fn scale(&self) -> [f64; 2] {
        self.scale
    }

    /// Number of targets.
    pub(super) fn targets(&self) -> usize {
        self.rows.count()
    }

    /// Variance of the noise of a single observation.
    pub fn noise(&self) -> f64 {
        self.scale[1] * self.scale[1] * self.covariance.noise()
    }

    /// Each row as predicted from all others with the same parameters: `y_i - a_i / (A^-1)_ii` with the variance `1 / (A^-1)_ii`
    /// (Rasmussen and Williams 2006, equation 5.12).
    pub fn left_out(&self, targets: &[f64]) -> Vec<LeftOut> {
        let inverse = self.factorised.clone().diagonal_of_inverse();
        let square = self.scale[1] * self.scale[1];
        let of_row = |(k, target): (usize, &f64)| {
            let own = inverse[k];
            LeftOut { mean: target - self.scale[1] * self.solved[k] / own, variance: square / own }
        };
        targets.iter().enumerate().map(of_row).collect()
    }

    /// The same as predictions, with the noise apart from what further rows would reduce.
    pub fn predictions_left_out(&self, targets: &[f64]) -> Vec<ProcessPrediction> {
        let noise = self.noise();
        let without_noise = |left: LeftOut| {
            let variance = (left.variance - noise).max(0.0);
            ProcessPrediction { mean: left.mean, variance, noise }
        };
        self.left_out(targets).into_iter().map(without_noise).collect()
    }
}

fn check_parameters(rows: &Rows, logarithms: &[f64]) -> Result<(), GaussianProcessError> {
    let (inputs, needed) = (rows.columns(), parameter_count(rows.columns()));
    if logarithms.len() != needed || logarithms.iter().any(|l| !l.is_finite()) {
        return Err(GaussianProcessError::Parameters { found: logarithms.len(), inputs, needed });
    }
    Ok(())
}

fn check_targets(rows: &Rows, targets: &[f64]) -> Result<(), GaussianProcessError> {
    if targets.len() != rows.count() {
        let (found, needed) = (targets.len(), rows.count());
        return Err(GaussianProcessError::Rows(format!("there are {found} targets for {needed} rows")));
    }
    match targets.iter().position(|y| !y.is_finite()) {
        Some(k) => Err(GaussianProcessError::Rows(format!(
            "target {} is {}, not a finite number",
            k + 1,
            targets[k]
        ))),
        None => Ok(()),
    }
}

/// The standard deviation is 1 if all values are equal.
fn mean_and_deviation(values: &[f64]) -> [f64; 2] {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let deviation = (values.iter().map(|y| (y - mean) * (y - mean)).sum::<f64>() / count).sqrt();
    [mean, if deviation > 1e-300 { deviation } else { 1.0 }]
}
