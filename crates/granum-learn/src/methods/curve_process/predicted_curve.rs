//! Predicted curves, as sums of components and put together to distributions.

use granum_nets::gaussian_process::ProcessPrediction;

use super::densities::{Coefficient, Densities};

/// A predicted curve: values at each point.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Curve {
    pub mean: Vec<f64>,
    /// Variance of the mean, which more runs would reduce.
    pub parameters: Vec<f64>,
    /// Variance of a single run about it.
    pub noise: Vec<f64>,
}

impl Curve {
    /// A mean curve, about which runs have the variance `rest` at each point, and components with their weights.
    pub fn new(mean: Vec<f64>, rest: Vec<f64>, weights: &[(&Vec<f64>, ProcessPrediction)]) -> Curve {
        let mut curve = Curve { parameters: vec![0.0; mean.len()], mean, noise: rest };
        for (component, weight) in weights {
            for (k, value) in component.iter().enumerate() {
                curve.mean[k] += weight.mean * value;
                curve.parameters[k] += weight.variance * value * value;
                curve.noise[k] += weight.noise * value * value;
            }
        }
        curve
    }

    /// The error at a point over its standard deviation.
    pub fn error(&self, point: usize, measured: f64) -> f64 {
        let error = measured - self.mean[point];
        let variance = self.parameters[point] + self.noise[point];
        // A point at which all curves are equal has no error and no variance.
        if error == 0.0 { 0.0 } else { error / variance.sqrt().max(1e-300) }
    }
}

/// The curves of all outputs: each is one of the given curves, or, if it is a bin, is put together from those of the coefficients of its
/// histogram, which stand in the place of its bins.
pub(super) fn curves_of_outputs(
    curves: impl IntoIterator<Item = Curve>,
    histograms: &[Densities],
    outputs: usize,
) -> Vec<Curve> {
    let mut curves = curves.into_iter();
    let mut found = Vec::with_capacity(outputs);
    while found.len() < outputs {
        match histograms.iter().find(|densities| densities.first == found.len()) {
            Some(densities) => {
                let own: Vec<Curve> = curves.by_ref().take(densities.directions.len()).collect();
                found.extend(curves_of_bins(densities, &own));
            }
            None => found.extend(curves.next()),
        }
    }
    found
}

/// Number of curves from which those of so many outputs are made.
pub(super) fn curves_needed(histograms: &[Densities], outputs: usize) -> usize {
    let bins: usize = histograms.iter().map(Densities::bins).sum();
    outputs - bins + histograms.iter().map(|densities| densities.directions.len()).sum::<usize>()
}

fn curves_of_bins(densities: &Densities, coefficients: &[Curve]) -> Vec<Curve> {
    let mut curves = vec![Curve::default(); densities.bins()];
    for point in 0..coefficients.first().map_or(0, |curve| curve.mean.len()) {
        let at = |curve: &Curve| Coefficient {
            mean: curve.mean[point],
            parameters: curve.parameters[point],
            noise: curve.noise[point],
        };
        let own: Vec<Coefficient> = coefficients.iter().map(at).collect();
        for (curve, density) in curves.iter_mut().zip(densities.densities(&own)) {
            curve.mean.push(density.mean);
            curve.parameters.push(density.parameters);
            curve.noise.push(density.noise);
        }
    }
    curves
}
