//! What a fitted family answers.

use granum_core::quantity::format_number;

use super::model::{FamilyModel, unfit};
use super::typical::TypicalValue;
use crate::error::{LearnError, Result};
use crate::surrogate::{Outside, RunInputs, UnseenCombination};

/// Where the value of an input comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum InputSource {
    /// It was given.
    Given,
    /// It is the typical value of the runs of the family with the given inputs; its deviation has the part of other typical values as well.
    Typical(TypicalValue),
    /// It is a property of the grains that is not known: the answer is the mean over its range, from the first to the second value.
    Integrated([f64; 2]),
}

/// An input with its value.
#[derive(Clone, Debug, PartialEq)]
pub struct UsedInput {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Where the value comes from.
    pub source: InputSource,
}

/// The curve of an output.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FamilyCurve {
    /// The column.
    pub column: String,
    /// The mean at each point.
    pub mean: Vec<f64>,
    /// Lower end of the interval at each point.
    pub lower: Vec<f64>,
    /// Upper end of the interval at each point.
    pub upper: Vec<f64>,
    /// The part of the variance that comes from inputs that were not given, at each point.
    pub from_inputs: Vec<f64>,
}

/// The answer of a fitted family.
#[derive(Clone, Debug, PartialEq)]
pub struct FamilyPrediction {
    /// The inputs.
    pub inputs: Vec<UsedInput>,
    /// Inputs outside the range of the runs, where the answer is an extrapolation.
    pub outside: Vec<Outside>,
    /// Two inputs, each within its range, that the runs do not have together, so that the answer is an extrapolation too.
    pub combination: Option<UnseenCombination>,
    /// The points of the coordinate.
    pub points: Vec<f64>,
    /// The share of new samples of which a state should be within its interval.
    pub level: f64,
    /// One for each column of the surrogate: the bins of a histogram have one each.
    pub curves: Vec<FamilyCurve>,
}

/// Relative difference of a value from the end of a range that is rounding, as 50 kPa over 5 GPa has.
pub(super) const ROUNDING: f64 = 1e-12;

impl FamilyPrediction {
    /// The inputs that are outside of their ranges, or all of them if none is.
    fn far(&self) -> Vec<String> {
        if self.outside.is_empty() {
            let one = |input: &UsedInput| format!("{} = {}", input.name, format_number(input.value));
            return self.inputs.iter().map(one).collect();
        }
        let far = |outside: &Outside| {
            let [value, low, high] = [outside.value, outside.range[0], outside.range[1]].map(format_number);
            format!("{} = {value} (the runs have {low} to {high})", outside.name)
        };
        self.outside.iter().map(far).collect()
    }

    /// True if the runs say little of these inputs: one is outside its range, or two do not occur together.
    pub fn is_extrapolated(&self) -> bool {
        !self.outside.is_empty() || self.combination.is_some()
    }
}

/// Mean, lower and upper end of each output at each point.
pub(super) struct Plain {
    pub(super) curves: Vec<[Vec<f64>; 3]>,
    pub(super) combination: Option<UnseenCombination>,
}

impl FamilyModel {
    /// Predicts the curves of a test. `given` has a value for each input of the family, or `None` where it is not known. For a property of the
    /// grains the answer is then the mean over its range; for anything else a typical value stands, and what such a value does not say widens the
    /// intervals.
    ///
    /// # Errors
    /// If nothing is given, a value or an answer is not finite, or the level is not between 0 and 1.
    pub fn predict(&self, given: &[Option<f64>], level: f64) -> Result<FamilyPrediction> {
        let definition = self.definition;
        let failed =
            |reason: String| LearnError::Surrogate { method: format!("family {}", definition.name), reason };
        if given.len() != definition.inputs.len() {
            return Err(failed(format!("it has {} inputs, not {}", definition.inputs.len(), given.len())));
        }
        for (input, value) in definition.inputs.iter().zip(given) {
            if let Some(value) = value.filter(|value| !value.is_finite()) {
                return Err(failed(format!("{} is {value}, not a finite number", input.name)));
            }
        }
        if given.iter().all(Option::is_none) {
            let needed = definition.inputs.iter().filter(|input| input.is_required);
            let needed: Vec<String> =
                needed.map(|input| format!("{} ({})", input.name, input.meaning)).collect();
            return Err(failed(format!("nothing is given; it needs {}", needed.join(", "))));
        }
        let is_open =
            definition.inputs.iter().zip(given).any(|(input, value)| input.is_required && value.is_none());
        let answer =
            if is_open { self.integrated(given, level)? } else { self.of_given_grains(given, level)? };
        let is_finite = |curve: &FamilyCurve| {
            [&curve.mean, &curve.lower, &curve.upper].iter().all(|ends| ends.iter().all(|x| x.is_finite()))
        };
        match answer.curves.iter().find(|curve| !is_finite(curve)) {
            None => Ok(answer),
            Some(curve) => Err(failed(format!(
                "it has no finite value of {} at {}: that is too far from its runs",
                curve.column,
                answer.far().join(", ")
            ))),
        }
    }

    /// The answer where all properties of the grains are given.
    fn of_given_grains(&self, given: &[Option<f64>], level: f64) -> Result<FamilyPrediction> {
        let definition = self.definition;
        let (values, typical) = self.completed(given, None);
        let plain = self.plain(&values, level)?;
        // What each missing input could change, with those after it following as they usually do.
        let mut variances: Vec<Vec<f64>> =
            plain.curves.iter().map(|[mean, ..]| vec![0.0; mean.len()]).collect();
        let mut spreads: Vec<f64> =
            typical.iter().map(|value| value.map_or(0.0, |typical| typical.deviation.powi(2))).collect();
        for (input, value) in typical.iter().enumerate() {
            let Some(typical) = value.filter(|typical| typical.deviation > 0.0) else { continue };
            let shifted = |sign: f64| {
                let shifted = typical.mean + sign * typical.deviation;
                self.completed(given, Some((input, shifted))).0
            };
            let (least, most) = (shifted(-1.0), shifted(1.0));
            for (other, spread) in spreads.iter_mut().enumerate().filter(|(other, _)| *other != input) {
                *spread += (0.5 * (most[other] - least[other])).powi(2);
            }
            let (low, high) = (self.means(&least)?, self.means(&most)?);
            for ((variance, low), high) in variances.iter_mut().zip(&low).zip(&high) {
                for ((variance, low), high) in variance.iter_mut().zip(low).zip(high) {
                    *variance += (0.5 * (high - low)).powi(2);
                }
            }
        }
        let points = self.points()?.to_vec();
        let columns = &self.surrogate.columns().outputs;
        let curves = columns.iter().enumerate().zip(plain.curves).zip(variances);
        let curves = curves.map(|(((output, column), plain), variance)| {
            let [mean, lower, upper] = plain;
            let quantile = granum_nets::two_sided_quantile(level, f64::INFINITY);
            let [lowest, highest] = self.surrogate.possible_values(output);
            let wider = |k: usize, end: f64, sign: f64| {
                let half = end - mean[k];
                let end = mean[k] + sign * (half * half + quantile * quantile * variance[k]).sqrt();
                end.max(lowest.min(mean[k])).min(highest.max(mean[k]))
            };
            FamilyCurve {
                column: column.name.clone(),
                lower: lower.iter().enumerate().map(|(k, end)| wider(k, *end, -1.0)).collect(),
                upper: upper.iter().enumerate().map(|(k, end)| wider(k, *end, 1.0)).collect(),
                from_inputs: variance,
                mean,
            }
        });
        let named = definition.inputs.iter().zip(&values);
        let inputs = named.zip(typical.iter().zip(&spreads)).map(|((input, value), (typical, spread))| {
            let source = typical.map_or(InputSource::Given, |typical| {
                InputSource::Typical(TypicalValue { deviation: spread.sqrt(), ..typical })
            });
            UsedInput { name: input.name.into(), value: *value, source }
        });
        Ok(FamilyPrediction {
            outside: self.outside(&values),
            combination: plain.combination,
            inputs: inputs.collect(),
            points,
            level,
            curves: curves.collect(),
        })
    }

    /// The inputs that lie outside of their ranges, by more than rounding.
    pub(super) fn outside(&self, values: &[f64]) -> Vec<Outside> {
        let named = self.definition.inputs.iter().zip(values).zip(self.ranges());
        let is_outside = |((_, value), [low, high]): &((_, &f64), [f64; 2])| {
            let slight = ROUNDING * low.abs().max(high.abs());
            !(**value >= low - slight && **value <= high + slight)
        };
        named
            .filter(is_outside)
            .map(|((input, value), range)| Outside { name: input.name.into(), value: *value, range })
            .collect()
    }

    /// The values of all inputs, those that are missing in order from those that are given or estimated before; `fixed` sets a missing one.
    fn completed(
        &self,
        given: &[Option<f64>],
        fixed: Option<(usize, f64)>,
    ) -> (Vec<f64>, Vec<Option<TypicalValue>>) {
        let mut known: Vec<(usize, f64)> =
            given.iter().enumerate().filter_map(|(k, value)| value.map(|value| (k, value))).collect();
        let mut typical = vec![None; given.len()];
        let mut values: Vec<f64> = given.iter().map(|value| value.unwrap_or(f64::NAN)).collect();
        let ranges = self.ranges();
        for input in (0..given.len()).filter(|k| given[*k].is_none()) {
            let [low, high] = ranges[input];
            let mut found = self.typical.value(&self.rows, input, &known);
            // Typical is what occurs.
            found.mean = found.mean.clamp(low, high);
            let value = match fixed {
                Some((other, value)) if other == input => value.clamp(low, high),
                _ => found.mean,
            };
            (typical[input], values[input]) = (Some(found), value);
            known.push((input, value));
        }
        (values, typical)
    }

    pub(super) fn points(&self) -> Result<&[f64]> {
        self.curves().map(|curves| curves.points()).ok_or_else(|| unfit("its surrogate has no curves"))
    }

    /// The states at all points of the coordinate for values of all inputs.
    fn states(&self, values: &[f64]) -> Result<RunInputs> {
        let points = self.points()?;
        let rows = points.iter().flat_map(|x| std::iter::once(*x).chain(values.iter().copied())).collect();
        RunInputs::new(rows, values.len() + 1, vec![points.len()])
    }

    /// The mean of each output at each point for values of all inputs.
    fn means(&self, values: &[f64]) -> Result<Vec<Vec<f64>>> {
        let states = self.surrogate.means(&self.states(values)?)?;
        let outputs = self.surrogate.columns().outputs.len();
        Ok((0..outputs).map(|output| states.iter().map(|state| state[output]).collect()).collect())
    }

    /// The curves for values of all inputs.
    pub(super) fn plain(&self, values: &[f64], level: f64) -> Result<Plain> {
        let predicted = self.surrogate.predict(&self.states(values)?, level)?;
        let outputs = self.surrogate.columns().outputs.len();
        let curve = |output: usize| {
            let mut curve = [const { Vec::new() }; 3];
            for prediction in &predicted {
                let estimate = &prediction.values[output];
                let ends = estimate
                    .interval
                    .as_ref()
                    .map_or([estimate.mean; 2], |interval| [interval.lower, interval.upper]);
                curve[0].push(estimate.mean);
                curve[1].push(ends[0]);
                curve[2].push(ends[1]);
            }
            curve
        };
        let curves = (0..outputs).map(curve).collect();
        Ok(Plain { curves, combination: predicted.into_iter().find_map(|prediction| prediction.combination) })
    }
}
