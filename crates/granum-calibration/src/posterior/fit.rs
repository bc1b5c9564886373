//! Whether a posterior explains the tests, which is said before anyone reads its numbers.
//!
//! A posterior is a comparison of values of the parameters with each other, and says nothing of whether the best of them fits. Three signs do:
//!
//! - A posterior predictive check of each curve. With the residual r of a draw and its covariance C, the sum of the measurement, of the surrogate
//!   and of an inadequacy whose size is drawn from its *prior*, new readings would have a `r^T C^-1 r` of a chi-square distribution with as many
//!   degrees of freedom as readings. The mean over draws of its share above that of the measured curve is the probability of a curve that lies at
//!   least so far off (a mixed replication of Gelman, Meng and Stern, Statistica Sinica 6 (1996), 733 to 807). With the posterior's sizes of the
//!   inadequacy anything would be probable, since that is what they are free for.
//! - A parameter whose draws crowd at an end of its prior: what would fit may lie beyond.
//! - An inadequacy that is larger than its prior has room for.

use granum_core::words;
use granum_learn::regression::cholesky::Cholesky;
use serde::{Deserialize, Serialize};

use crate::compared::curve::{ForwardModel, MeasuredCurve, PredictedCurve};
use crate::draws::chi_square::share_above;
use crate::error::{CalibrationError, Result};
use crate::inference::likelihood::{Discrepancy, FreeParameter, Posterior};
use crate::inference::prior::Prior;
use crate::inference::reach::digits;
use crate::posterior::confirmation::Confirmed;
use crate::posterior::outcome::Outcome;

/// Draws of the check.
const DRAWS: usize = 100;
/// Probability of a curve below which the posterior does not explain it.
const LEAST_PROBABILITY: f64 = 0.01;
/// Root mean square difference over the largest reading beyond which a prediction is poor, whatever errors and inadequacy the file allows.
const LARGEST_MISFIT: f64 = 0.2;
/// The same over the deviation of the surrogate, up to which a difference may be that of a surrogate of few or small samples.
const OF_SURROGATE: f64 = 2.0;
/// Share of a prior that is called its end.
const END: f64 = 0.05;
/// Share of the draws at an end of the prior beyond which they crowd there; the prior has a twentieth of them there.
const CROWD: f64 = 0.25;
/// Share of the prior of an inadequacy above its median beyond which it is larger than the prior has room for.
const NO_ROOM: f64 = 0.01;

/// How well the posterior explains the tests.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Fit {
    /// Each compared curve.
    pub curves: Vec<CurveFit>,
    /// Parameters at an end of their priors.
    pub at_ends: Vec<AtEnd>,
    /// Inadequacies that are larger than their priors have room for.
    pub large_inadequacies: Vec<LargeInadequacy>,
}

/// How well the posterior explains a curve.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CurveFit {
    /// The test.
    pub test: String,
    /// The quantity.
    pub quantity: String,
    /// Root mean square difference between the mean prediction and the readings, over the largest of these.
    pub misfit: Option<f64>,
    /// The same of simulations at draws from the posterior, their mean.
    pub misfit_of_simulations: Option<f64>,
    /// Probability of readings that lie at least as far from the predictions; `None` without a surrogate.
    pub probability: Option<f64>,
    /// True if the posterior explains the curve.
    pub is_explained: bool,
}

/// A parameter whose draws crowd at an end of its prior.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AtEnd {
    /// The parameter.
    pub parameter: String,
    /// True for the upper end.
    pub is_upper: bool,
    /// Share of the draws in the twentieth of the prior at this end.
    pub share: f64,
    /// The value at which this twentieth begins.
    pub from: f64,
    /// The bound, in SI units; `None` if the prior has none there.
    pub bound: Option<f64>,
}

/// An inadequacy that is larger than its prior has room for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LargeInadequacy {
    /// The quantity.
    pub quantity: String,
    /// The median of its relative size.
    pub median: f64,
    /// The scale of its prior.
    pub scale: f64,
    /// Share of the prior above the median.
    pub prior_above: f64,
}

impl Fit {
    /// Judges a posterior of these parameters and curves. The model is that of the posterior; without one only simulations at draws, and the
    /// priors, say something.
    ///
    /// # Errors
    /// As [`Posterior::new`], and if the model predicts no draw.
    pub fn new(
        parameters: &[FreeParameter],
        curves: &[MeasuredCurve],
        model: Option<&dyn ForwardModel>,
        inadequacy: Option<Discrepancy>,
        outcome: &Outcome,
        confirmed: &[Confirmed],
    ) -> Result<Fit> {
        let checked = match model {
            Some(model) => Some(Checked::new(parameters, curves, model, inadequacy, outcome)?),
            None => None,
        };
        let curve = |(k, curve): (usize, &MeasuredCurve)| {
            let of_curve =
                confirmed.iter().filter(|one| one.test == curve.test && one.quantity == curve.quantity);
            let simulated: Vec<f64> = of_curve.map(|one| one.misfit).collect();
            let mean = simulated.iter().sum::<f64>() / simulated.len() as f64;
            let misfit = checked.as_ref().map(|checked| checked.misfits[k]);
            let probability = checked.as_ref().map(|checked| checked.probabilities[k]);
            let misfit_of_simulations = (!simulated.is_empty()).then_some(mean);
            let deviation = checked.as_ref().map_or(0.0, |checked| checked.deviations[k]);
            let most = LARGEST_MISFIT.max(OF_SURROGATE * deviation);
            // What is not a number explains nothing.
            let is_near = |misfit: Option<f64>| misfit.is_none_or(|misfit| misfit <= most);
            let is_probable = probability.is_none_or(|probability| probability >= LEAST_PROBABILITY);
            CurveFit {
                test: curve.test.clone(),
                quantity: curve.quantity.clone(),
                is_explained: is_probable && is_near(misfit) && is_near(misfit_of_simulations),
                misfit,
                misfit_of_simulations,
                probability,
            }
        };
        let at_ends = parameters.iter().enumerate().filter_map(|(k, free)| at_end(free, &outcome.sorted(k)));
        let inadequacies = outcome.names.iter().enumerate().skip(parameters.len());
        let large = inadequacies.filter_map(|(k, name)| {
            large_inadequacy(name.strip_suffix("_discrepancy")?, inadequacy?, &outcome.sorted(k))
        });
        Ok(Fit {
            curves: curves.iter().enumerate().map(curve).collect(),
            at_ends: at_ends.collect(),
            large_inadequacies: large.collect(),
        })
    }

    /// True if nothing speaks against the posterior.
    pub fn is_good(&self) -> bool {
        self.lines().is_empty()
    }

    /// True if the posterior explains all curves; its parameters may be at the ends of their priors.
    pub fn explains(&self) -> bool {
        self.large_inadequacies.is_empty() && self.curves.iter().all(|curve| curve.is_explained)
    }

    /// What speaks against the posterior, a sentence for each sign.
    pub fn lines(&self) -> Vec<String> {
        let curves = self.curves.iter().filter(|curve| !curve.is_explained).map(CurveFit::line);
        let inadequacies = self.large_inadequacies.iter().map(LargeInadequacy::line);
        curves.chain(inadequacies).chain(self.at_ends.iter().map(AtEnd::line)).collect()
    }
}

impl CurveFit {
    fn line(&self) -> String {
        let percent = |misfit: f64| words::percent(misfit, 0);
        let mut parts = Vec::new();
        match (self.misfit, self.misfit_of_simulations) {
            (Some(misfit), Some(simulated)) => parts.push(format!(
                "predictions miss the readings by {} of the largest (simulations by {})",
                percent(misfit),
                percent(simulated)
            )),
            (Some(misfit), None) => {
                parts.push(format!("predictions miss the readings by {} of the largest", percent(misfit)));
            }
            (None, Some(simulated)) => {
                parts.push(format!("simulations miss the readings by {} of the largest", percent(simulated)));
            }
            (None, None) => {}
        }
        if let Some(probability) = self.probability.filter(|probability| *probability < LEAST_PROBABILITY) {
            let probability = match probability < 1e-6 {
                true => "less than 1e-6".into(),
                false => digits(probability),
            };
            parts.push(format!(
                "with the errors and the inadequacy that the file states, readings that lie so far off have a probability of {probability}"
            ));
        }
        format!(
            "the posterior does not explain the {} of {}: {}",
            self.quantity.replace('_', " "),
            self.test,
            parts.join("; ")
        )
    }
}

impl AtEnd {
    fn line(&self) -> String {
        let name = self.parameter.replace('_', " ");
        let share = words::percent(self.share, 0);
        let [end, other] = if self.is_upper { ["upper", "above"] } else { ["lower", "below"] };
        match self.bound {
            Some(bound) => format!(
                "{name} is at the {end} bound of its prior: {share} of its draws lie between {} and the bound {}; its interval says where the prior \
                 ends, and what fits better may lie beyond",
                digits(self.from),
                digits(bound)
            ),
            None => format!(
                "{name} lies at the {end} end of its prior: {share} of its draws lie {other} {}, where a twentieth of the prior is",
                digits(self.from)
            ),
        }
    }
}

impl LargeInadequacy {
    fn line(&self) -> String {
        let LargeInadequacy { quantity, median, scale, prior_above } = self;
        let probability = match *prior_above < 1e-6 {
            true => "less than 1e-6".into(),
            false => digits(*prior_above),
        };
        format!(
            "the inadequacy of the model in the {} is {:.0} % of the curve, and its prior has a scale of {:.0} %, so that a larger one had a probability of \
             {probability}: no value of the parameters explains the curves",
            quantity.replace('_', " "),
            100.0 * median,
            100.0 * scale
        )
    }
}

/// What the draws say of the curves.
struct Checked {
    misfits: Vec<f64>,
    /// Root mean square deviation of the surrogate over the largest reading.
    deviations: Vec<f64>,
    probabilities: Vec<f64>,
}

impl Checked {
    fn new(
        parameters: &[FreeParameter],
        curves: &[MeasuredCurve],
        model: &dyn ForwardModel,
        inadequacy: Option<Discrepancy>,
        outcome: &Outcome,
    ) -> Result<Checked> {
        let posterior = Posterior::new(parameters, curves, model, inadequacy)?;
        let sizes = posterior.priors().split_off(parameters.len());
        let draws = outcome.spread(DRAWS);
        let predicted: Vec<Vec<PredictedCurve>> =
            draws.iter().filter_map(|draw| model.predict(draw.get(..parameters.len())?)).collect();
        if predicted.is_empty() {
            let message =
                "the model predicts no draw from the posterior, so that nothing says whether it fits";
            return Err(CalibrationError::Input(message.into()));
        }
        let count = predicted.len() as f64;
        let misfit = |(k, curve): (usize, &MeasuredCurve)| {
            let mean = |i: usize| predicted.iter().map(|one| one[k].mean[i]).sum::<f64>() / count;
            let square: f64 = curve.measured.iter().enumerate().map(|(i, y)| (y - mean(i)).powi(2)).sum();
            let largest = curve.measured.iter().fold(1e-300, |most: f64, y| most.max(y.abs()));
            (square / curve.measured.len() as f64).sqrt() / largest
        };
        let deviation = |(k, curve): (usize, &MeasuredCurve)| {
            let width = curve.strain.len();
            let variance = |one: &Vec<PredictedCurve>| -> f64 {
                (0..width).map(|i| one[k].covariance.get(i * width + i).copied().unwrap_or(0.0)).sum()
            };
            let mean = predicted.iter().map(variance).sum::<f64>() / (count * width as f64);
            mean.max(0.0).sqrt() / curve.measured.iter().fold(1e-300, |most: f64, y| most.max(y.abs()))
        };
        let probability = |(k, curve): (usize, &MeasuredCurve)| {
            let of_draw = |(number, one): (usize, &Vec<PredictedCurve>)| {
                // Each draw has a size of its own, so that all together have those of the prior.
                let share = (number as f64 + 0.5) / count;
                let sizes: Vec<f64> = sizes.iter().map(|prior| prior.value(share)).collect();
                let apart: Vec<f64> = curve.measured.iter().zip(&one[k].mean).map(|(y, m)| y - m).collect();
                let Some(factor) = Cholesky::new(apart.len(), &posterior.covariance(k, &one[k], &sizes))
                else {
                    return 0.0;
                };
                let square: f64 = factor.solve_lower(&apart).iter().map(|y| y * y).sum();
                share_above(square, apart.len())
            };
            predicted.iter().enumerate().map(of_draw).sum::<f64>() / count
        };
        Ok(Checked {
            misfits: curves.iter().enumerate().map(misfit).collect(),
            deviations: curves.iter().enumerate().map(deviation).collect(),
            probabilities: curves.iter().enumerate().map(probability).collect(),
        })
    }
}

fn at_end(free: &FreeParameter, sorted: &[f64]) -> Option<AtEnd> {
    let share_where = |is_there: &dyn Fn(f64) -> bool| {
        let there = sorted.iter().filter(|value| is_there(free.prior.share(**value))).count();
        there as f64 / sorted.len() as f64
    };
    let lower = share_where(&|share| share < END);
    let upper = share_where(&|share| share > 1.0 - END);
    let is_upper = upper > lower;
    let share = upper.max(lower);
    let [from, to] = free.prior.bounds();
    (share >= CROWD).then(|| AtEnd {
        parameter: free.name.clone(),
        is_upper,
        share,
        from: free.prior.value(if is_upper { 1.0 - END } else { END }),
        bound: if is_upper { to } else { from },
    })
}

fn large_inadequacy(quantity: &str, inadequacy: Discrepancy, sorted: &[f64]) -> Option<LargeInadequacy> {
    let prior = Prior::Normal { mean: 0.0, deviation: inadequacy.scale, from: 0.0, to: f64::INFINITY };
    let median = crate::draws::diagnostics::quantile_of_sorted(sorted, 0.5);
    // The share above, not one less that below it, which has no digits far out.
    let prior_above = 2.0 * granum_nets::normal::share_below(-median / inadequacy.scale);
    (prior_above < NO_ROOM && prior.check(quantity).is_ok()).then(|| LargeInadequacy {
        quantity: quantity.into(),
        median,
        scale: inadequacy.scale,
        prior_above,
    })
}

#[cfg(test)]
mod tests {
    use granum_core::observer::NoObserver;

    use super::*;
    use crate::compared::curve::MeasurementError;
    use crate::draws::chains::{ChainOptions, draw};

    /// A line through the origin whose slope is free between 1 and 3, and readings that are a factor times one with the slope 2.
    fn judged(factor: f64, inadequacy: Option<Discrepancy>) -> Fit {
        let strain: Vec<f64> = (1..=10).map(|k| f64::from(k) / 100.0).collect();
        let curve = MeasuredCurve {
            test: "T1".into(),
            quantity: "deviator_stress".into(),
            measured: strain.iter().map(|s| factor * 2.0 * s).collect(),
            strain,
            error: MeasurementError { absolute: 0.002, relative: 0.02, correlation_strain: 0.02 },
            weight: 1.0,
        };
        let model = |values: &[f64]| {
            let mean = (1..=10).map(|k| values[0] * f64::from(k) / 100.0).collect();
            Some(vec![PredictedCurve { mean, ..PredictedCurve::default() }])
        };
        let free = [FreeParameter { name: "slope".into(), prior: Prior::Uniform { from: 1.0, to: 3.0 } }];
        let curves = [curve];
        let posterior = Posterior::new(&free, &curves, &model, inadequacy).unwrap();
        let draws = draw(&posterior, &ChainOptions::default(), &mut NoObserver).unwrap();
        let outcome = Outcome::from_draws(&posterior, &draws);
        Fit::new(&free, &curves, Some(&model), inadequacy, &outcome, &[]).unwrap()
    }

    #[test]
    fn nothing_is_said_of_a_posterior_that_fits() {
        for inadequacy in [None, Some(Discrepancy::default())] {
            let fit = judged(1.0, inadequacy);
            assert!(fit.is_good() && fit.explains(), "{fit:?}");
            // The readings are exactly those of the model.
            assert!(fit.curves[0].probability.unwrap() > 0.9, "{fit:?}");
        }
    }

    #[test]
    fn readings_that_nothing_explains_are_told_with_what_gives_way() {
        let right = judged(3.0, None);
        let sentences = right.lines().join("\n");
        assert!(sentences.contains("does not explain the deviator stress of T1"), "{sentences}");
        assert!(sentences.contains("less than 1e-6") && sentences.contains("by 31 %"), "{sentences}");
        assert!(
            sentences.contains("slope is at the upper bound of its prior") && sentences.contains("bound 3"),
            "{sentences}"
        );
        // The inadequacy takes it all, and the parameter is free.
        let wide = judged(3.0, Some(Discrepancy::default()));
        let sentences = wide.lines().join("\n");
        assert!(sentences.contains("the inadequacy of the model in the deviator stress is"), "{sentences}");
        assert!(!wide.explains() && wide.curves[0].probability.unwrap() < 0.01, "{wide:?}");
    }

    #[test]
    fn a_parameter_at_a_bound_is_told_even_if_the_curve_fits() {
        let fit = judged(1.5, None);
        assert!(fit.explains() && !fit.is_good(), "{fit:?}");
        assert_eq!((fit.at_ends.len(), fit.at_ends[0].bound), (1, Some(3.0)));
        let lower = judged(0.5, None);
        assert!(lower.lines()[0].contains("lower bound of its prior"), "{:?}", lower.lines());
    }

    #[test]
    fn a_poor_prediction_is_told_whatever_the_errors_allow() {
        let fit = judged(3.0, Some(Discrepancy { scale: 5.0, correlation_strain: 0.05 }));
        assert!(fit.curves[0].probability.unwrap() > 0.05, "{fit:?}");
        assert!(fit.lines()[0].contains("predictions miss the readings by"), "{:?}", fit.lines());
    }

    #[test]
    fn simulations_speak_where_there_is_no_surrogate() {
        let outcome = Outcome::from_weighted(
            vec!["slope".into()],
            &[Prior::Uniform { from: 1.0, to: 3.0 }],
            &[vec![0.5], vec![0.6]],
            &[0.5, 0.5],
            1,
        );
        let curve = MeasuredCurve {
            test: "T1".into(),
            quantity: "deviator_stress".into(),
            strain: vec![0.01],
            measured: vec![1.0],
            error: MeasurementError { absolute: 0.1, relative: 0.0, correlation_strain: 0.0 },
            weight: 1.0,
        };
        let confirmed = |misfit: f64| Confirmed {
            test: "T1".into(),
            quantity: "deviator_stress".into(),
            run: "a".into(),
            misfit,
            misfit_of_surrogate: None,
            deviations: None,
        };
        let free = [FreeParameter { name: "slope".into(), prior: Prior::Uniform { from: 1.0, to: 3.0 } }];
        let of = |misfit: f64| {
            Fit::new(&free, std::slice::from_ref(&curve), None, None, &outcome, &[confirmed(misfit)]).unwrap()
        };
        assert!(of(0.1).is_good());
        assert!(of(0.3).lines()[0].contains("simulations miss the readings by 30 %"));
    }
}
