//! Fits processes to curves, and predicts each run from what is fitted to others.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use granum_core::observer::{Flow, Observer, Progress, SharedObserver};
use granum_core::parallel;
use granum_nets::gaussian_process::{FitOptions, GaussianProcess, Prior, Rows};

use super::components::Components;
use super::densities::Densities;
use super::failure::failed;
use super::kept_curve::KeptCurve;
use super::left_out::{Curves, PARTS};
use super::predicted_curve::Curve;
use super::prepared::{Prepared, Shared};
use crate::error::{LearnError, Result};
use crate::surrogate::spec::FitSpec;

/// Below so many runs the prior of the processes is narrow, and a short memory of the start is tried.
const FEW_RUNS: usize = 64;

/// Left-out runs are few as well: the start is taken to be forgotten unless the mean square of their errors is then larger by this factor or more.
const DOUBT: f64 = 2.0;

/// By so much the surprise must be less, on average over points and runs: a root that is hardly more probable misses the largest values by more.
const DECISIVE: f64 = 1.0;

/// Variances are taken to be at least this share of the mean square of an output, since at a common start there are neither errors nor variances.
const SLIGHT: f64 = 1e-6;

/// What is fitted, and how.
pub(super) struct Fitting<'a> {
    /// Searches for the parameters of each process, and the most runs by which they are judged.
    pub starts: usize,
    pub most_runs: usize,
    pub spec: &'a FitSpec,
    pub shared: &'a Shared,
}

/// A fitted curve.
struct Fit {
    prepared: Prepared,
    /// Logarithms of the parameters of the process of each component.
    parameters: Vec<Vec<f64>>,
    /// The curves of the runs, each as predicted from other runs, without starts as in `prepared`.
    predicted: Vec<Curve>,
}

impl Fitting<'_> {
    /// All curves, each with those of the runs as predicted from others, less the starts of the runs.
    pub fn fitted(
        &self,
        starts: &[Option<usize>],
        histograms: &[Densities],
        observer: &mut dyn Observer,
    ) -> Result<Vec<(KeptCurve, Vec<Curve>)>> {
        let mut fits = self.fits(self.shared.prepared(starts, histograms), observer)?;
        // From many runs the processes learn themselves how a curve depends on its start; few are predicted better if it is taken to be
        // forgotten, unless it is not.
        if self.are_few() {
            let is_better = |other: &Fit, own: &Fit| self.error(other) < DOUBT * self.error(own);
            self.try_instead(&mut fits, |own| self.shared.forgetting(own), is_better, observer)?;
        }
        let is_better = |other: &Fit, own: &Fit| self.surprise(other) < self.surprise(own) - DECISIVE;
        self.try_instead(&mut fits, |own| self.shared.rooted(own), is_better, observer)?;
        let kept = |Fit { prepared, parameters, predicted }: Fit| {
            let predicted = self.shared.outputs(&prepared, predicted);
            let Prepared { start, memory, root, components, .. } = prepared;
            let Components { mean, components, weights, rest } = components;
            (KeptCurve { start, memory, root, mean, components, rest, parameters, weights }, predicted)
        };
        Ok(fits.into_iter().map(kept).collect())
    }

    fn are_few(&self) -> bool {
        self.shared.runs.len() < FEW_RUNS
    }

    /// Fits some curves in another way as well, and takes it where that is better.
    fn try_instead(
        &self,
        fits: &mut [Fit],
        another: impl Fn(&Prepared) -> Option<Prepared>,
        is_better: impl Fn(&Fit, &Fit) -> bool,
        observer: &mut dyn Observer,
    ) -> Result<()> {
        let others: Vec<Option<Prepared>> = fits.iter().map(|fit| another(&fit.prepared)).collect();
        let tried = fits.iter_mut().zip(&others).filter(|(_, other)| other.is_some()).map(|(fit, _)| fit);
        let tried: Vec<&mut Fit> = tried.collect();
        let found = self.fits(others.into_iter().flatten().collect(), observer)?;
        for (fit, other) in tried.into_iter().zip(found) {
            if is_better(&other, fit) {
                *fit = other;
            }
        }
        Ok(())
    }

    /// The mean square error of the runs as predicted from others.
    fn error(&self, fit: &Fit) -> f64 {
        self.mean_over_runs(fit, |apart, _| apart * apart)
    }

    /// How little the runs were expected by what was fitted to others: minus twice the logarithm of their normal density, but for a constant.
    fn surprise(&self, fit: &Fit) -> f64 {
        let measured = self.shared.measured_of(&fit.prepared);
        let count = (measured.len() * self.shared.points.len()) as f64;
        let square = measured.iter().flatten().map(|y| y * y).sum::<f64>() / count;
        self.mean_over_runs(fit, |apart, variance| {
            let variance = variance.max(SLIGHT * square).max(f64::MIN_POSITIVE);
            apart * apart / variance + libm::log(variance)
        })
    }

    /// The mean over points and runs of what is made of the difference of a measured output from the predicted one, and the variance of the prediction.
    fn mean_over_runs(&self, fit: &Fit, of: impl Fn(f64, f64) -> f64) -> f64 {
        let predicted = self.shared.outputs(&fit.prepared, fit.predicted.clone());
        let measured = self.shared.measured_of(&fit.prepared);
        let of_run = |(measured, predicted): (&Vec<f64>, &Curve)| -> f64 {
            let each = self.shared.shares.iter().enumerate();
            let value = |(k, share): (usize, &f64)| {
                share * of(measured[k] - predicted.mean[k], predicted.parameters[k] + predicted.noise[k])
            };
            each.map(value).sum()
        };
        measured.iter().zip(&predicted).map(of_run).sum::<f64>() / measured.len() as f64
    }

    fn fits(&self, prepared: Vec<Prepared>, observer: &mut dyn Observer) -> Result<Vec<Fit>> {
        let components = |prepared: &Prepared| prepared.components.components.len();
        let each = prepared.iter().enumerate();
        let places: Vec<(usize, usize)> =
            each.flat_map(|(output, own)| (0..components(own)).map(move |j| (output, j))).collect();
        let processes = match &self.shared.rows {
            Some(rows) => self.processes(rows, &prepared, &places, observer)?,
            None => Vec::new(),
        };
        let mut rest = processes.iter().map(|process| process.parameters().to_vec());
        let parameters: Vec<Vec<Vec<f64>>> =
            prepared.iter().map(|own| rest.by_ref().take(components(own)).collect()).collect();
        let predicted = self.left_out(&prepared, &parameters, observer)?;
        let fits = prepared.into_iter().zip(parameters).zip(predicted);
        Ok(fits.map(|((prepared, parameters), predicted)| Fit { prepared, parameters, predicted }).collect())
    }

    fn options(&self) -> FitOptions {
        let mut options = FitOptions::default();
        options.most_rows = self.most_runs;
        options.prior = if self.are_few() { Prior::Narrow } else { Prior::Wide };
        options
    }

    /// The processes of all components of all outputs.
    fn processes(
        &self,
        rows: &Arc<Rows>,
        prepared: &[Prepared],
        fits: &[(usize, usize)],
        observer: &mut dyn Observer,
    ) -> Result<Vec<GaussianProcess>> {
        let follower = SharedObserver::new(observer);
        let done = AtomicUsize::new(0);
        parallel::map(fits.len(), self.spec.threads, |k| {
            let mut part = follower.part(format!("process {}", k + 1));
            let (complete, total) = (done.load(Ordering::Relaxed), fits.len());
            let progress = Progress::new("training", "processes", complete as u64).out_of(total as u64);
            if part.progress(&progress) == Flow::Stop {
                return Err(LearnError::Stopped { done: complete, total });
            }
            let (output, component) = fits[k];
            let mut options = self.options();
            options.starts = self.starts;
            options.seed = self.spec.seed.wrapping_add(k as u64);
            let targets = &prepared[output].components.weights[component];
            let process = GaussianProcess::fit(rows.clone(), targets, &options).map_err(failed)?;
            done.fetch_add(1, Ordering::Relaxed);
            part.completed();
            Ok(process)
        })
    }

    /// For each curve that is fitted those of the runs, in order, each as predicted from other runs.
    fn left_out(
        &self,
        prepared: &[Prepared],
        parameters: &[Vec<Vec<f64>>],
        observer: &mut dyn Observer,
    ) -> Result<Vec<Vec<Curve>>> {
        let (follower, shared) = (SharedObserver::new(observer), self.shared);
        let (done, total) = (AtomicUsize::new(0), prepared.len() * PARTS);
        let found = parallel::map(total, self.spec.threads, |k| {
            let (curve, part) = (k / PARTS, k % PARTS);
            let complete = done.load(Ordering::Relaxed);
            let progress = Progress::new("calibration", "parts", complete as u64).out_of(total as u64);
            if follower.part(format!("curve {}", curve + 1)).progress(&progress) == Flow::Stop {
                return Err(LearnError::Stopped { done: complete, total });
            }
            let curves = Curves {
                curves: &prepared[curve].curves,
                shares: &shared.shares,
                rows: shared.rows.as_ref(),
                parameters: &parameters[curve],
                independent: shared.independent,
                options: self.options(),
            };
            let predicted = curves.predicted(part)?;
            done.fetch_add(1, Ordering::Relaxed);
            Ok(predicted)
        })?;
        let mut found = found.into_iter();
        let mut of_curve = || {
            let mut runs: Vec<(usize, Curve)> = found.by_ref().take(PARTS).flatten().collect();
            runs.sort_by_key(|(run, _)| *run);
            runs.into_iter().map(|(_, curve)| curve).collect()
        };
        Ok(prepared.iter().map(|_| of_curve()).collect())
    }
}

#[cfg(test)]
mod tests {
    use granum_core::observer::NoObserver;
    use granum_core::{Column, Table};

    use super::super::local_calibration::LocalFactor;
    use super::super::{FittedCurves, GaussianProcessOfCurves};
    use super::*;
    use crate::dataset::{Dataset, RunStates};
    use crate::surrogate::{RunInputs, Surrogate, SurrogateMethods, to_json};

    /// Runs of which one output soon forgets its start and the other does not.
    fn fitted(count: usize) -> FittedCurves {
        let run = |k: usize| {
            let (strength, start) = ((k * 7 % count) as f64 / count as f64, (k * 3 % 8) as f64 / 8.0);
            let xs: Vec<f64> = (0..41).map(|i| f64::from(i) / 40.0).collect();
            let of = |f: &dyn Fn(f64) -> f64| xs.iter().map(|x| f(*x)).collect();
            let columns = vec![
                Column::new("forgets", "", of(&|x| start * (-10.0 * x).exp() + strength * x)),
                Column::new("remembers", "", of(&|x| start + strength * x)),
                Column::new("x", "", xs.clone()),
            ];
            let run = RunStates::new(&format!("run-{k}"), Table::new(columns)?)?
                .with_parameter("strength", "", strength)?;
            run.with_parameter("sample.forgets", "", start)?.with_parameter("sample.remembers", "", start)
        };
        let dataset = Dataset::new((0..count).map(run).collect::<Result<_>>().unwrap()).unwrap();
        let inputs = ["x", "strength", "sample.forgets", "sample.remembers"];
        let spec = FitSpec::new(inputs, ["forgets", "remembers"]).with_coordinate("x");
        let method = GaussianProcessOfCurves { components: 3, starts: 1, ..Default::default() };
        method.fit_with_left_out(&dataset, &spec, &mut NoObserver).unwrap().0
    }

    #[test]
    fn few_runs_forget_a_start_that_is_forgotten() {
        let few = fitted(20);
        let memories = |curves: &FittedCurves| -> Vec<bool> {
            curves.kept.curves.iter().map(|curve| curve.memory.is_some()).collect()
        };
        assert_eq!(memories(&few), [true, false]);
        assert_eq!(memories(&fitted(FEW_RUNS)), [false, false]);
        for (x, tolerance) in [(0.0, 1e-15), (0.1, 0.01), (1.0, 0.01)] {
            let predicted = few.predict_rows(&[x, 0.4, 0.3, 0.3], 0.9).unwrap().remove(0);
            let expected = [0.3 * (-10.0 * x).exp() + 0.4 * x, 0.3 + 0.4 * x];
            for (value, expected) in predicted.values.iter().zip(expected) {
                assert!((value.mean - expected).abs() <= tolerance, "{x}: {} {expected}", value.mean);
            }
            // The same with its covariance, and from a file.
            let correlated = few.correlated_curve(&[0.4, 0.3, 0.3], 0, &[x]).unwrap();
            assert!((correlated.mean[0] - predicted.values[0].mean).abs() < 1e-14);
            let read = SurrogateMethods::standard().from_json(&to_json(&few).unwrap(), "file").unwrap();
            assert_eq!(read.predict_rows(&[x, 0.4, 0.3, 0.3], 0.9).unwrap()[0], predicted);
        }
    }

    /// What is not remembered of a start is no error of runs that were left out in corners.
    #[test]
    fn intervals_outside_of_the_runs_do_not_know_a_start_that_is_forgotten() {
        let curves = fitted(48);
        assert!(curves.kept.curves[0].memory.is_some());
        let growth: Vec<f64> = curves.kept.local.iter().map(LocalFactor::growth).collect();
        assert!(growth.iter().all(|growth| *growth < 100.0), "{growth:?}");
    }

    /// Heights from 0.01 to 100 that scatter by a tenth of themselves: intervals hold, are not negative, and are the same with a covariance.
    #[test]
    fn a_heavy_tail_is_learned_by_its_root() {
        let height = |strength: f64| (4.0 * strength - 2.0) * std::f64::consts::LN_10;
        let dataset = |count: usize, seed: usize| {
            let run = |k: usize| {
                let place = (0.618_033_988_749_894_8 * (k + seed) as f64).fract();
                let xs: Vec<f64> = (0..41).map(|i| f64::from(i) / 40.0).collect();
                let own =
                    1.0 + 0.2 * ((43_758.545_3 * (12.989_8 * (k + seed) as f64).sin()).rem_euclid(1.0) - 0.5);
                let y = xs.iter().map(|x| own * (x * height(place)).exp()).collect();
                let table = Table::new(vec![Column::new("x", "", xs), Column::new("y", "", y)])?;
                RunStates::new(&format!("run-{k}"), table)?.with_parameter("strength", "", place)
            };
            Dataset::new((0..count).map(run).collect::<Result<_>>().unwrap()).unwrap()
        };
        let spec = FitSpec::new(["x", "strength"], ["y"]).with_coordinate("x");
        let method = GaussianProcessOfCurves { components: 4, starts: 1, ..Default::default() };
        let fitted = method.fit_with_left_out(&dataset(70, 0), &spec, &mut NoObserver).unwrap().0;
        assert!(fitted.kept.curves[0].root);
        let new = dataset(60, 1000);
        let inputs = RunInputs::from_dataset(&new, fitted.columns()).unwrap();
        let predicted = fitted.predict(&inputs, 0.9).unwrap();
        let held = predicted.iter().zip(new.column("y").unwrap()).filter(|(prediction, y)| {
            let interval = prediction.values[0].interval.as_ref().unwrap();
            (interval.lower..=interval.upper).contains(y)
        });
        let lower = |prediction: &crate::Prediction| prediction.values[0].interval.as_ref().unwrap().lower;
        assert!(predicted.iter().all(|prediction| lower(prediction) >= 0.0));
        let share = held.count() as f64 / predicted.len() as f64;
        assert!((0.85..=0.98).contains(&share), "{share}");
        for strength in [0.1, 0.5, 0.9] {
            let at = [0.0, 0.4, 1.0];
            let alone = |x: f64| fitted.predict_rows(&[x, strength], 0.9).unwrap()[0].values[0].mean;
            let correlated = fitted.correlated_curve(&[strength], 0, &at).unwrap();
            for (k, x) in at.iter().enumerate() {
                let mean = alone(*x);
                assert!(
                    mean > 0.0 && (correlated.mean[k] / mean - 1.0).abs() < 0.02,
                    "{x} {mean} {correlated:?}"
                );
            }
            let reducible = fitted.reducible_variance(&[strength], 0, &at).unwrap();
            assert!((0..3).all(|k| (0.0..=correlated.covariance[4 * k]).contains(&reducible[k])));
        }
    }
}
