//! Which runs to make next: those that would reduce most what more runs would reduce of the variance of the predicted curves.

use granum_nets::gaussian_process::{Observations, Rows};

use super::failure::failed;
use super::fitted::FittedCurves;
use super::kept_curve::KeptCurve;
use crate::error::Result;

/// Runs in the order in which they are worth being made.
#[derive(Clone, Debug, PartialEq)]
pub struct NextRuns {
    /// Places among the candidates, the run that tells most first.
    pub chosen: Vec<usize>,
    /// The variance of the mean curves, averaged over candidates and coordinate, over the variance of the curves of the training runs, summed
    /// over outputs: before any of the runs, and after each.
    pub variance: Vec<f64>,
}

impl FittedCurves {
    /// Chooses at most `count` of the candidates for which `is_free` is true. Each candidate is given by its inputs beside the coordinate in their
    /// order, and the variance is averaged over all candidates, free or not, which should therefore fill the ranges that matter evenly.
    ///
    /// Each run is chosen with what the runs before it will tell, so that a batch does not cluster ([`Observations`]). Every output counts
    /// alike: its variance is that over its training curves.
    ///
    /// # Errors
    /// If a candidate has other inputs, or the surrogate has no input beside the coordinate.
    pub fn next_runs(&self, candidates: &[Vec<f64>], is_free: &[bool], count: usize) -> Result<NextRuns> {
        if candidates.len() != is_free.len() {
            return Err(failed("every candidate needs a flag whether it is free"));
        }
        if self.kept.groups.is_empty() || candidates.len() < 2 {
            return Err(failed("a choice of runs needs two candidates and an input beside the coordinate"));
        }
        let mut values = Vec::with_capacity(candidates.len() * self.kept.groups.len());
        for candidate in candidates {
            values.extend(self.row(candidate)?);
        }
        let rows = Rows::new(values, self.kept.groups.len()).map_err(failed)?;
        let shares = self.shares();
        // What a variance of one of the weight of a component is on average over the coordinate.
        let square = |component: &Vec<f64>| -> f64 {
            component.iter().zip(&shares).map(|(value, share)| share * value * value).sum()
        };
        let mut processes = Vec::new();
        for curves in self.curves_of_each_output() {
            let of_curve = |kept: &KeptCurve| -> f64 {
                let each = kept.components.iter().zip(&kept.weights);
                each.map(|(component, weights)| square(component) * variance(weights)).sum()
            };
            let total: f64 = self.kept.curves[curves.clone()].iter().map(of_curve).sum();
            // Curves that are all alike have nothing to learn.
            if total <= 0.0 {
                continue;
            }
            for curve in curves {
                for (component, process) in
                    self.kept.curves[curve].components.iter().zip(&self.processes[curve])
                {
                    processes.push((square(component) / total, process.posterior_covariance(&rows)));
                }
            }
        }
        let Observations { rows: chosen, variance } = Observations::choose(processes, is_free, count);
        Ok(NextRuns { chosen, variance })
    }

    /// The curves that make up each output: one, or those of the coefficients of a histogram.
    fn curves_of_each_output(&self) -> Vec<std::ops::Range<usize>> {
        let (mut found, mut output, mut curve) = (Vec::new(), 0, 0);
        while curve < self.kept.curves.len() {
            let histogram = self.kept.histograms.iter().find(|densities| densities.first == output);
            let (curves, outputs) = histogram.map_or((1, 1), |own| (own.directions.len(), own.bins()));
            found.push(curve..curve + curves);
            curve += curves;
            output += outputs.max(1);
        }
        found
    }
}

fn variance(values: &[f64]) -> f64 {
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / count
}

#[cfg(test)]
mod tests {
    use granum_core::observer::NoObserver;
    use granum_core::{Column, Table};

    use crate::surrogate::{FitSpec, GaussianProcessOfCurves};
    use crate::{Dataset, RunStates};

    /// Curves whose height is a wave of one parameter, known for small values of it only: the next runs are spread over the rest, are the same
    /// again, and leave out what is not free.
    #[test]
    fn the_next_runs_are_spread_over_what_is_not_known() {
        let run = |k: u32| {
            let place = 0.02 * f64::from(k);
            let x: Vec<f64> = (0..20).map(|i| f64::from(i) / 19.0).collect();
            let y = x.iter().map(|x| (1.2 + (5.0 * place).sin()) * (1.0 - (-4.0 * x).exp())).collect();
            let table = Table::new(vec![Column::new("x", "", x), Column::new("y", "", y)])?;
            RunStates::new(&format!("run-{k}"), table)?.with_parameter("place", "", place)
        };
        let dataset = Dataset::new((0..12).map(run).collect::<crate::Result<_>>().unwrap()).unwrap();
        let spec = FitSpec::new(["x", "place"], ["y"]).with_coordinate("x").with_threads(1);
        let method = GaussianProcessOfCurves::default();
        let (fitted, _) = method.fit_with_left_out(&dataset, &spec, &mut NoObserver).unwrap();
        let candidates: Vec<Vec<f64>> = (0..40).map(|k| vec![0.025 * f64::from(k)]).collect();
        let is_free: Vec<bool> = (0..40).map(|k| k != 39).collect();
        let next = fitted.next_runs(&candidates, &is_free, 3).unwrap();
        let mut places: Vec<f64> = next.chosen.iter().map(|k| candidates[*k][0]).collect();
        assert!(places[0] > 0.4, "{places:?}");
        assert!(next.variance.windows(2).all(|pair| pair[1] < pair[0]), "{:?}", next.variance);
        assert_eq!(fitted.next_runs(&candidates, &is_free, 3).unwrap(), next);
        assert!(!next.chosen.contains(&39));
        places.sort_by(f64::total_cmp);
        assert!(places[0] > 0.24 && places[2] - places[0] > 0.09, "{places:?}");
        let error = fitted.next_runs(&candidates, &[true], 3).unwrap_err().to_string();
        assert!(error.contains("flag"), "{error}");
    }
}
