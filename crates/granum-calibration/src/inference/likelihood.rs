//! The likelihood of laboratory curves, with three errors that are stated apart.
//!
//! The difference of a measured and a predicted curve is normal with the sum of three covariances: that of the measurement, that of the
//! prediction (a surrogate's interval with its correlation along the curve), and that of the inadequacy of the model, since spheres are no
//! grains of sand: a smooth function of strain, `(a s)^2 exp(-(difference of strains / l)^2 / 2)` with the root mean square s of the measured
//! curve. Its relative size a is free, one for each quantity, and has a half-normal prior.
//!
//! Source of the discrepancy: Kennedy, O'Hagan, Bayesian calibration of computer models, Journal of the Royal Statistical Society B 63
//! (2001), 425 to 464.

use granum_learn::regression::cholesky::Cholesky;
use serde::{Deserialize, Serialize};

use crate::compared::curve::{ForwardModel, MeasuredCurve, MeasurementError, PredictedCurve};
use crate::draws::chains::LogDensity;
use crate::error::{CalibrationError, Result};
use crate::inference::prior::Prior;

/// Sizes of a discrepancy over which its prior is averaged, where each quantity is averaged on its own.
const NODES: usize = 24;
/// Sets of sizes over which the priors of all quantities are averaged together.
const SETS: usize = 128;

/// A free parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FreeParameter {
    /// Its name.
    pub name: String,
    /// Its prior.
    pub prior: Prior,
}

/// Inadequacy of the model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Discrepancy {
    /// Scale of the half-normal prior of its relative size: with 0.1 the model may well be off by a tenth of a curve's root mean square.
    pub scale: f64,
    /// Difference of axial strains over which it is alike.
    pub correlation_strain: f64,
}

impl Default for Discrepancy {
    fn default() -> Self {
        Discrepancy { scale: 0.05, correlation_strain: 0.05 }
    }
}

/// The posterior of free parameters: their priors, the curves, and what predicts them.
pub struct Posterior<'a> {
    parameters: &'a [FreeParameter],
    curves: &'a [MeasuredCurve],
    model: &'a dyn ForwardModel,
    /// Names of all coordinates: the parameters, then one discrepancy for each quantity.
    names: Vec<String>,
    /// Priors of the relative sizes of the discrepancies.
    sizes: Option<Prior>,
    correlation_strain: f64,
    /// For each curve, the place of the discrepancy of its quantity.
    quantity: Vec<usize>,
    /// For each curve, the covariance of the measurement and the root mean square.
    measurement: Vec<(Vec<f64>, f64)>,
}

impl<'a> Posterior<'a> {
    /// The posterior; without a discrepancy the model is taken to be right.
    ///
    /// # Errors
    /// If a prior has no sense, a curve has no readings, its strains do not rise, or an error, weight or number is not finite, or an error is
    /// zero.
    pub fn new(
        parameters: &'a [FreeParameter],
        curves: &'a [MeasuredCurve],
        model: &'a dyn ForwardModel,
        discrepancy: Option<Discrepancy>,
    ) -> Result<Posterior<'a>> {
        parameters.iter().try_for_each(|free| free.prior.check(&free.name))?;
        curves.iter().try_for_each(check_curve)?;
        if parameters.is_empty() || curves.is_empty() {
            return Err(CalibrationError::Input(
                "a calibration needs a free parameter and a measured curve".into(),
            ));
        }
        let mut quantities: Vec<&str> = Vec::new();
        let quantity = curves.iter().map(|curve| {
            let known = quantities.iter().position(|name| *name == curve.quantity);
            known.unwrap_or_else(|| {
                quantities.push(&curve.quantity);
                quantities.len() - 1
            })
        });
        let quantity = quantity.collect();
        let mut names: Vec<String> = parameters.iter().map(|free| free.name.clone()).collect();
        let mut sizes = None;
        if let Some(Discrepancy { scale, correlation_strain }) = discrepancy {
            let prior = Prior::Normal { mean: 0.0, deviation: scale, from: 0.0, to: f64::INFINITY };
            prior.check("the discrepancy")?;
            if !(correlation_strain > 0.0 && correlation_strain.is_finite()) {
                let message =
                    format!("the discrepancy: correlation_strain = {correlation_strain} must be positive");
                return Err(CalibrationError::Input(message));
            }
            names.extend(quantities.iter().map(|name| format!("{name}_discrepancy")));
            sizes = Some(prior);
        }
        Ok(Posterior {
            parameters,
            curves,
            model,
            names,
            sizes,
            correlation_strain: discrepancy.map_or(1.0, |discrepancy| discrepancy.correlation_strain),
            quantity,
            measurement: curves
                .iter()
                .map(|curve| (measurement_covariance(curve), root_mean_square(&curve.measured)))
                .collect(),
        })
    }

    /// The values of the coordinates at shares of their priors: the parameters, then the relative sizes of discrepancies.
    pub fn values(&self, shares: &[f64]) -> Vec<f64> {
        let priors = self.parameters.iter().map(|free| Some(free.prior)).chain(std::iter::repeat(self.sizes));
        shares
            .iter()
            .zip(priors)
            .map(|(share, prior)| prior.map_or(*share, |prior| prior.value(*share)))
            .collect()
    }

    /// The priors of all coordinates: of the parameters, then of the relative sizes of discrepancies.
    pub fn priors(&self) -> Vec<Prior> {
        let sizes = self.names.len() - self.parameters.len();
        let parameters = self.parameters.iter().map(|free| free.prior);
        parameters.chain(self.sizes.into_iter().cycle().take(sizes)).collect()
    }

    /// The value of one coordinate at a share of its prior.
    pub fn value(&self, coordinate: usize, share: f64) -> f64 {
        let prior = self.parameters.get(coordinate).map(|free| free.prior).or(self.sizes);
        prior.map_or(share, |prior| prior.value(share))
    }

    /// The logarithm of the likelihood of predicted curves, up to a constant, with the mean over the priors of the relative sizes of
    /// discrepancies: for a model whose every evaluation costs a simulation.
    pub fn marginal_log_likelihood(&self, predicted: &[PredictedCurve]) -> f64 {
        let sizes: Vec<f64> = match self.sizes {
            Some(prior) => (0..NODES).map(|k| prior.value((k as f64 + 0.5) / NODES as f64)).collect(),
            None => vec![0.0],
        };
        let quantities = self.quantity.iter().max().map_or(0, |last| last + 1);
        // Curves of one quantity share a size, and sizes of different quantities are independent.
        let of_quantity = |quantity: usize| {
            let terms: Vec<f64> = sizes
                .iter()
                .map(|size| {
                    let own = self.quantity.iter().enumerate().filter(|(_, known)| **known == quantity);
                    let all = vec![*size; if self.sizes.is_some() { quantities } else { 0 }];
                    own.map(|(k, _)| self.log_density_of_curve(k, &predicted[k], &all)).sum()
                })
                .collect();
            log_mean(&terms)
        };
        if predicted.len() != self.curves.len() {
            return f64::NEG_INFINITY;
        }
        match self.sizes {
            Some(prior) if predicted.iter().any(|curve| !curve.across.is_empty()) => {
                self.averaged_together(predicted, prior, quantities)
            }
            _ if self.sizes.is_none() => self.log_likelihood_of(predicted, &[]),
            _ => (0..quantities).map(of_quantity).sum(),
        }
    }

    /// As [`Posterior::marginal_log_likelihood`] where the errors of different quantities go together: the mean over points that fill the priors
    /// of all sizes evenly.
    fn averaged_together(&self, predicted: &[PredictedCurve], prior: Prior, quantities: usize) -> f64 {
        let size = |set: usize, quantity: usize| {
            prior.value(f64::from(sobol_burley::sample(set as u32, quantity as u32, 0)))
        };
        let term = |set: usize| {
            let sizes: Vec<f64> = (0..quantities).map(|quantity| size(set, quantity)).collect();
            self.log_likelihood_of(predicted, &sizes)
        };
        log_mean(&(0..SETS).map(term).collect::<Vec<f64>>())
    }

    /// The logarithm of the likelihood of one curve, weighted.
    fn log_density_of_curve(&self, k: usize, predicted: &PredictedCurve, sizes: &[f64]) -> f64 {
        let curve = &self.curves[k];
        let apart: Vec<f64> = curve.measured.iter().zip(&predicted.mean).map(|(a, b)| a - b).collect();
        normal_log_density(&apart, &self.covariance(k, predicted, sizes))
            .map_or(f64::NEG_INFINITY, |density| curve.weight * density)
    }

    /// The covariance of the difference between a measured curve and its prediction, row-major, with the given relative sizes of
    /// discrepancies.
    pub fn covariance(&self, curve: usize, predicted: &PredictedCurve, sizes: &[f64]) -> Vec<f64> {
        let (measurement, scale) = &self.measurement[curve];
        let mut sum = measurement.clone();
        for (sum, part) in sum.iter_mut().zip(&predicted.covariance) {
            *sum += part;
        }
        if let Some(size) = sizes.get(self.quantity[curve]) {
            let variance = (size * scale).powi(2);
            let strain = &self.curves[curve].strain;
            for (i, a) in strain.iter().enumerate() {
                for (j, b) in strain[..=i].iter().enumerate() {
                    let apart = (a - b) / self.correlation_strain;
                    sum[i * strain.len() + j] += variance * libm::exp(-0.5 * apart * apart);
                }
            }
        }
        sum
    }

    /// The logarithm of the likelihood of values, up to a constant.
    fn log_likelihood(&self, values: &[f64]) -> f64 {
        let (parameters, sizes) = values.split_at(self.parameters.len());
        let Some(predicted) = self.model.predict(parameters) else { return f64::NEG_INFINITY };
        self.log_likelihood_of(&predicted, sizes)
    }

    /// The logarithm of the likelihood of predicted curves with the given relative sizes of discrepancies, up to a constant.
    fn log_likelihood_of(&self, predicted: &[PredictedCurve], sizes: &[f64]) -> f64 {
        let all: Vec<usize> = (0..predicted.len()).collect();
        groups(predicted, &all).iter().map(|group| self.log_density_of_group(group, predicted, sizes)).sum()
    }

    /// The logarithm of the likelihood of curves whose errors go together. Each has its weight as the exponent of its density given those
    /// before it.
    fn log_density_of_group(&self, group: &[usize], predicted: &[PredictedCurve], sizes: &[f64]) -> f64 {
        if let [one] = group {
            return self.log_density_of_curve(*one, &predicted[*one], sizes);
        }
        let apart = |curve: &usize| {
            let measured = self.curves[*curve].measured.iter();
            measured.zip(&predicted[*curve].mean).map(|(a, b)| a - b).collect::<Vec<f64>>()
        };
        let apart: Vec<f64> = group.iter().flat_map(apart).collect();
        let count = apart.len();
        let Some(factor) = Cholesky::new(count, &self.covariance_of_group(group, predicted, sizes)) else {
            return f64::NEG_INFINITY;
        };
        let weight = |curve: &usize| vec![self.curves[*curve].weight; self.curves[*curve].strain.len()];
        let weights = group.iter().flat_map(weight);
        let constant = libm::log(2.0 * std::f64::consts::PI);
        let density = |((k, y), weight): ((usize, f64), f64)| {
            -0.5 * weight * (y * y + 2.0 * libm::log(factor.lower()[k * count + k]) + constant)
        };
        factor.solve_lower(&apart).into_iter().enumerate().zip(weights).map(density).sum()
    }

    /// The covariance of the differences of several curves, one after another, of which the lower triangle is filled, row-major.
    pub fn covariance_of_group(
        &self,
        group: &[usize],
        predicted: &[PredictedCurve],
        sizes: &[f64],
    ) -> Vec<f64> {
        let lengths: Vec<usize> = group.iter().map(|curve| self.curves[*curve].strain.len()).collect();
        let count: usize = lengths.iter().sum();
        let mut all = vec![0.0; count * count];
        let mut put = |values: &[f64], (row, column): (usize, usize), width: usize| {
            for (k, value) in values.iter().enumerate() {
                all[(row + k / width) * count + column + k % width] = *value;
            }
        };
        let first = |place: usize| lengths[..place].iter().sum::<usize>();
        for (place, curve) in group.iter().enumerate() {
            let row = first(place);
            put(&self.covariance(*curve, &predicted[*curve], sizes), (row, row), lengths[place]);
            for (other, values) in &predicted[*curve].across {
                if let Some(known) = group[..place].iter().position(|curve| curve == other) {
                    put(values, (row, first(known)), lengths[known]);
                }
            }
        }
        all
    }
}

impl LogDensity for Posterior<'_> {
    fn names(&self) -> &[String] {
        &self.names
    }

    fn log_density(&self, shares: &[f64]) -> f64 {
        self.log_likelihood(&self.values(shares))
    }
}

/// The logarithm of the mean of exponentials.
fn log_mean(terms: &[f64]) -> f64 {
    let largest = terms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if largest == f64::NEG_INFINITY {
        return largest;
    }
    let mean = terms.iter().map(|term| libm::exp(term - largest)).sum::<f64>() / terms.len() as f64;
    largest + libm::log(mean)
}

/// The curves of `chosen` in groups whose errors go together.
pub(crate) fn groups(predicted: &[PredictedCurve], chosen: &[usize]) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for curve in chosen.iter().copied() {
        let known = predicted[curve].across.iter().map(|(other, _)| *other);
        let with = |group: &&mut Vec<usize>| known.clone().any(|other| group.contains(&other));
        match groups.iter_mut().find(with) {
            Some(group) => group.push(curve),
            None => groups.push(vec![curve]),
        }
    }
    groups
}

/// The logarithm of the density of a normal distribution with mean zero at a vector, of whose covariance the lower triangle is read;
/// `None` if that is not positive definite.
pub fn normal_log_density(vector: &[f64], covariance: &[f64]) -> Option<f64> {
    let factor = Cholesky::new(vector.len(), covariance)?;
    let square: f64 = factor.solve_lower(vector).iter().map(|y| y * y).sum();
    let constant = vector.len() as f64 * libm::log(2.0 * std::f64::consts::PI);
    Some(-0.5 * (square + factor.log_determinant() + constant))
}

/// The covariance of the error of measurement of a curve, of which the lower triangle is filled, row-major.
pub fn measurement_covariance(curve: &MeasuredCurve) -> Vec<f64> {
    let count = curve.strain.len();
    let mut covariance = vec![0.0; count * count];
    for i in 0..count {
        for j in 0..=i {
            let apart = (curve.strain[i] - curve.strain[j]).abs();
            let alike =
                if i == j { 1.0 } else { libm::exp(-apart / curve.error.correlation_strain.max(1e-300)) };
            covariance[i * count + j] =
                alike * curve.error.deviation(curve.measured[i]) * curve.error.deviation(curve.measured[j]);
        }
    }
    covariance
}

fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|x| x * x).sum::<f64>() / values.len() as f64).sqrt()
}

fn check_curve(curve: &MeasuredCurve) -> Result<()> {
    let refuse = |what: &str| {
        Err(CalibrationError::Input(format!("{} of the test {}: {what}", curve.quantity, curve.test)))
    };
    let MeasurementError { absolute, relative, correlation_strain } = curve.error;
    let rising = curve.strain.windows(2).all(|pair| pair[1] > pair[0]);
    if curve.measured.is_empty() || curve.measured.len() != curve.strain.len() {
        return refuse("it needs readings, each with its strain");
    }
    if !(rising && curve.strain.iter().chain(&curve.measured).all(|x| x.is_finite())) {
        return refuse("readings must be finite and their strains must rise");
    }
    if [absolute, relative, correlation_strain].iter().any(|x| !(*x >= 0.0 && x.is_finite())) {
        return refuse("errors and their correlation must be finite and not negative");
    }
    if curve.measured.iter().any(|reading| curve.error.deviation(*reading) == 0.0) {
        return refuse("a reading of zero has no error; give an absolute part of the error of measurement");
    }
    if !(curve.weight > 0.0 && curve.weight.is_finite()) {
        return refuse("the weight must be positive");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use granum_core::observer::NoObserver;

    use super::*;
    use crate::draws::chains::{ChainOptions, draw};

    fn line_test(error: MeasurementError) -> MeasuredCurve {
        let strain: Vec<f64> = (1..=10).map(|k| f64::from(k) / 100.0).collect();
        let measured = strain.iter().map(|s| 2.0 * s).collect();
        MeasuredCurve { test: "T".into(), quantity: "y".into(), strain, measured, error, weight: 1.0 }
    }

    fn slope(from: f64, to: f64) -> Vec<FreeParameter> {
        vec![FreeParameter { name: "slope".into(), prior: Prior::Uniform { from, to } }]
    }

    fn line(values: &[f64]) -> Option<Vec<PredictedCurve>> {
        let mean = (1..=10).map(|k| values[0] * f64::from(k) / 100.0).collect();
        Some(vec![PredictedCurve { mean, ..PredictedCurve::default() }])
    }

    #[test]
    fn a_density_by_hand() {
        // Two independent values with variances 4 and 9 at 2 and 3: both one deviation off.
        let density = normal_log_density(&[2.0, 3.0], &[4.0, 0.0, 0.0, 9.0]).unwrap();
        assert!((density - (-1.0 - (2.0 * std::f64::consts::PI * 6.0).ln())).abs() < 1e-12);
        assert!(normal_log_density(&[0.0, 0.0], &[1.0, 0.0, 2.0, 1.0]).is_none());
    }

    /// Golden: the slope of a line through the origin with independent errors s has the deviation s / sqrt(sum of x^2); without errors
    /// of their own, readings tell no more than the largest of them.
    #[test]
    fn the_posterior_of_a_slope_is_that_of_least_squares() {
        let free = slope(0.0, 4.0);
        let own = [line_test(MeasurementError { absolute: 0.01, relative: 0.0, correlation_strain: 0.0 })];
        let posterior = Posterior::new(&free, &own, &line, None).unwrap();
        let options = ChainOptions { least_effective: 1500.0, ..ChainOptions::default() };
        let draws = draw(&posterior, &options, &mut NoObserver).unwrap();
        let values: Vec<f64> = draws.points().iter().map(|shares| posterior.values(shares)[0]).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let deviation = root_mean_square(&values.iter().map(|x| x - mean).collect::<Vec<_>>());
        let expected = 0.01 / 0.0385f64.sqrt();
        assert!((mean - 2.0).abs() < 0.1 * expected, "{mean}");
        assert!((deviation / expected - 1.0).abs() < 0.08, "{deviation} {expected}");
    }

    /// A model that cannot follow the measured curve is sure of a wrong value without a discrepancy, and unsure with one.
    #[test]
    fn a_discrepancy_widens_the_posterior_of_a_wrong_model() {
        let free = slope(0.0, 4.0);
        let mut bent =
            line_test(MeasurementError { absolute: 0.001, relative: 0.0, correlation_strain: 0.0 });
        bent.measured = bent.strain.iter().map(|s| 2.0 * s - 12.0 * s * s).collect();
        let bent = [bent];
        let width = |discrepancy: Option<Discrepancy>| {
            let posterior = Posterior::new(&free, &bent, &line, discrepancy).unwrap();
            let draws = draw(&posterior, &ChainOptions::default(), &mut NoObserver).unwrap();
            let values: Vec<f64> = draws.points().iter().map(|shares| posterior.values(shares)[0]).collect();
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            (posterior.names.len(), root_mean_square(&values.iter().map(|x| x - mean).collect::<Vec<_>>()))
        };
        let (one, sure) = width(None);
        let (two, unsure) = width(Some(Discrepancy { scale: 0.5, correlation_strain: 0.05 }));
        assert_eq!((one, two), (1, 2));
        assert!(unsure > 5.0 * sure, "{sure} {unsure}");
    }

    /// Golden: averaged over the prior of its size, the likelihood is that of a fine sum over sizes.
    #[test]
    fn the_size_of_a_discrepancy_is_averaged() {
        let free = slope(0.0, 4.0);
        let curves = [line_test(MeasurementError { absolute: 0.01, relative: 0.0, correlation_strain: 0.0 })];
        let posterior =
            Posterior::new(&free, &curves, &line, Some(Discrepancy { scale: 0.1, correlation_strain: 0.05 }))
                .unwrap();
        let predicted = line(&[1.9]).unwrap();
        let found = posterior.marginal_log_likelihood(&predicted);
        let prior = Prior::Normal { mean: 0.0, deviation: 0.1, from: 0.0, to: f64::INFINITY };
        let terms = (0..2000).map(|k| prior.value((f64::from(k) + 0.5) / 2000.0));
        let mean: f64 = terms.map(|size| posterior.log_likelihood(&[1.9, size]).exp()).sum::<f64>() / 2000.0;
        assert!((found - mean.ln()).abs() < 0.02, "{found} {}", mean.ln());
        let right = Posterior::new(&free, &curves, &line, None).unwrap();
        assert_eq!(right.marginal_log_likelihood(&predicted), right.log_likelihood(&[1.9]));
    }

    /// Golden: two curves whose errors go together have the density of all of their readings, and the weight of the second one counts what it
    /// tells beside the first.
    #[test]
    fn curves_of_one_sample_are_judged_together() {
        let free = slope(0.0, 4.0);
        let error = MeasurementError { absolute: 0.01, relative: 0.0, correlation_strain: 0.0 };
        let one = MeasuredCurve { strain: vec![0.1], measured: vec![0.3], ..line_test(error) };
        let mut two =
            MeasuredCurve { quantity: "volumetric_strain".into(), measured: vec![0.5], ..one.clone() };
        let model = |values: &[f64]| {
            let curve =
                |mean: f64, across| PredictedCurve { mean: vec![mean], covariance: vec![0.04], across };
            Some(vec![curve(0.1 * values[0], Vec::new()), curve(0.2 * values[0], vec![(0, vec![0.03])])])
        };
        let variance = 0.04 + 1e-4;
        let joint = [variance, 0.03, 0.03, variance];
        let expected = normal_log_density(&[0.1, 0.1], &joint).unwrap();
        let alone = normal_log_density(&[0.1], &joint[..1]).unwrap();
        for weight in [1.0, 0.5] {
            two.weight = weight;
            let curves = [one.clone(), two.clone()];
            let posterior = Posterior::new(&free, &curves, &model, None).unwrap();
            let found = posterior.log_likelihood(&[2.0]);
            let expected = alone + weight * (expected - alone);
            assert!((found - expected).abs() < 1e-12, "{weight}: {found} {expected}");
        }
    }

    /// Golden: averaged over the sizes of two quantities whose errors go together, the likelihood is that of a fine grid of sizes; with a
    /// covariance of zero between them it is that of each quantity on its own.
    #[test]
    fn sizes_of_discrepancies_are_averaged_together() {
        let free = slope(0.0, 4.0);
        let error = MeasurementError { absolute: 0.01, relative: 0.0, correlation_strain: 0.0 };
        let one = MeasuredCurve { strain: vec![0.1], measured: vec![0.3], ..line_test(error) };
        let two = MeasuredCurve { quantity: "volumetric_strain".into(), measured: vec![0.5], ..one.clone() };
        let curves = [one, two];
        let discrepancy = Some(Discrepancy { scale: 0.3, correlation_strain: 0.05 });
        let posterior = Posterior::new(&free, &curves, &line, discrepancy).unwrap();
        let prior = Prior::Normal { mean: 0.0, deviation: 0.3, from: 0.0, to: f64::INFINITY };
        for across in [0.03, 0.0] {
            let curve =
                |mean: f64, across| PredictedCurve { mean: vec![mean], covariance: vec![0.04], across };
            let predicted = [curve(0.2, Vec::new()), curve(0.4, vec![(0, vec![across])])];
            let size = |k: u32| prior.value((f64::from(k) + 0.5) / 60.0);
            let sets = (0..3600).map(|k| [size(k / 60), size(k % 60)]);
            let terms: Vec<f64> = sets.map(|sizes| posterior.log_likelihood_of(&predicted, &sizes)).collect();
            let found = posterior.marginal_log_likelihood(&predicted);
            assert!((found - log_mean(&terms)).abs() < 0.01, "{found} {}", log_mean(&terms));
            let alone = predicted.clone().map(|curve| PredictedCurve { across: Vec::new(), ..curve });
            let alone = posterior.marginal_log_likelihood(&alone);
            assert_eq!((found - alone).abs() < 0.01, across == 0.0, "{across}: {found} {alone}");
        }
    }

    #[test]
    fn curves_without_sense_are_refused() {
        let error = MeasurementError { absolute: 0.0, relative: 0.02, correlation_strain: 0.0 };
        let refused = |change: fn(&mut MeasuredCurve)| {
            let mut curve = line_test(error);
            change(&mut curve);
            Posterior::new(&slope(0.0, 1.0), &[curve], &line, None).err().map(|error| error.to_string())
        };
        assert_eq!(refused(|_| ()), None);
        let zero = refused(|curve| curve.measured[0] = 0.0).unwrap();
        assert!(zero.contains("y of the test T") && zero.contains("absolute part"), "{zero}");
        assert!(refused(|curve| curve.strain[3] = 0.0).unwrap().contains("must rise"));
        assert!(refused(|curve| curve.measured.clear()).unwrap().contains("needs readings"));
        assert!(refused(|curve| curve.weight = 0.0).unwrap().contains("weight"));
        assert!(refused(|curve| curve.error.relative = -1.0).unwrap().contains("not negative"));
    }
}
