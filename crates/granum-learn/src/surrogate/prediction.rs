//! The prediction of a surrogate for a row.

use granum_nets::Deviation;

use super::spec::Columns;

/// The prediction of a surrogate for one row.
///
/// ```
/// use granum_learn::surrogate::{Cause, Estimate, Prediction};
///
/// // A mean with standard deviations 3 and 4 from two causes, and an interval of two standard deviations.
/// let estimate = Estimate::new(100.0).by(vec![(Cause::Noise, 3.0), (Cause::Runs, 4.0)], 2.0);
/// let prediction = Prediction::new(vec![estimate]);
/// let interval = prediction.values[0].interval.as_ref().unwrap();
/// assert_eq!((interval.standard_deviation(), interval.lower, interval.upper), (5.0, 90.0, 110.0));
/// assert!(prediction.outside.is_empty());
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Prediction {
    /// One estimate for each output, in order.
    pub values: Vec<Estimate>,
    /// The inputs outside the trained range; the estimates should not be trusted if there are any.
    pub outside: Vec<Outside>,
    /// Two inputs, each within its trained range, that the training runs do not have together.
    pub combination: Option<UnseenCombination>,
}

/// Values of two inputs that the training runs do not have together.
#[derive(Clone, Debug, PartialEq)]
pub struct UnseenCombination {
    /// Their names and values.
    pub inputs: [(String, f64); 2],
}

impl Prediction {
    /// A prediction from the estimates of all outputs, with all inputs inside the trained range.
    pub fn new(values: Vec<Estimate>) -> Prediction {
        Prediction { values, outside: Vec::new(), combination: None }
    }

    /// Sets the inputs outside the trained range.
    pub fn with_outside(self, outside: Vec<Outside>) -> Prediction {
        Prediction { outside, ..self }
    }

    /// Sets the two inputs that the training runs do not have together.
    pub fn with_combination(self, combination: Option<UnseenCombination>) -> Prediction {
        Prediction { combination, ..self }
    }

    /// True if the training runs say little of these inputs: one is outside its trained range, or two do not occur together.
    pub fn is_extrapolated(&self) -> bool {
        !self.outside.is_empty() || self.combination.is_some()
    }
}

/// The estimate of one output.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Estimate {
    /// The mean.
    pub mean: f64,
    /// Interval for observations of new runs; `None` if the surrogate does not provide it.
    pub interval: Option<Interval>,
}

impl Estimate {
    /// A mean without an interval.
    pub fn new(mean: f64) -> Estimate {
        Estimate { mean, interval: None }
    }

    /// Sets an interval that extends by `quantile` standard deviations to either side; the standard deviation is given by
    /// cause.
    pub fn by(self, causes: Vec<(Cause, f64)>, quantile: f64) -> Estimate {
        let mut interval = Interval { lower: self.mean, upper: self.mean, causes };
        let half = quantile * interval.standard_deviation();
        (interval.lower, interval.upper) = (self.mean - half, self.mean + half);
        Estimate { interval: Some(interval), ..self }
    }

    /// Cuts the interval to the values that the quantity can have (see [`possible_values`](super::possible_values)). The mean stays within it.
    pub fn cut(mut self, [low, high]: [f64; 2]) -> Estimate {
        if let Some(interval) = &mut self.interval {
            interval.lower = interval.lower.max(low.min(self.mean));
            interval.upper = interval.upper.min(high.max(self.mean));
        }
        self
    }

    /// Sets an interval with the given ends.
    pub fn within(self, [lower, upper]: [f64; 2], causes: Vec<(Cause, f64)>) -> Estimate {
        Estimate { interval: Some(Interval { lower, upper, causes }), ..self }
    }
}

/// An interval that should contain the requested share of the observations.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Interval {
    /// Lower end.
    pub lower: f64,
    /// Upper end.
    pub upper: f64,
    /// The standard deviation of each known cause; their squares add up to the variance. Empty if the surrogate does not
    /// distinguish causes.
    pub causes: Vec<(Cause, f64)>,
}

impl Interval {
    /// The total standard deviation of all causes; 0 if none is known.
    pub fn standard_deviation(&self) -> f64 {
        self.causes.iter().map(|(_, deviation)| deviation * deviation).sum::<f64>().sqrt()
    }
}

/// The cause of a deviation between an observation and its prediction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Cause {
    /// The scatter of the observations about any smooth function.
    Noise,
    /// The uncertainty of the parameters, which the training rows do not determine exactly.
    Parameters,
    /// The difference of a new run as a whole from the training runs.
    Runs,
    /// The uncertainty of the soft sensors from which a cascade predicts.
    Sensors,
}

impl std::fmt::Display for Cause {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(match self {
            Cause::Noise => "noise",
            Cause::Parameters => "parameters",
            Cause::Runs => "runs",
            Cause::Sensors => "sensors",
        })
    }
}

/// An input that is outside the trained range of a surrogate.
#[derive(Clone, Debug, PartialEq)]
pub struct Outside {
    /// Its name.
    pub name: String,
    /// Value of the input.
    pub value: f64,
    /// Trained range.
    pub range: [f64; 2],
}

/// The inputs of a row that lie outside the given ranges, of which there is one for each input.
pub fn outside_of(columns: &Columns, ranges: &[[f64; 2]], row: &[f64]) -> Vec<Outside> {
    let each = columns.inputs.iter().zip(ranges).zip(row);
    let beyond = each.filter(|((_, [low, high]), value)| !(*value >= low && *value <= high));
    beyond
        .map(|((input, range), value)| Outside { name: input.name.clone(), value: *value, range: *range })
        .collect()
}

/// The standard deviation of a network, split by cause.
pub fn causes(deviation: &Deviation) -> Vec<(Cause, f64)> {
    let all = [
        (Cause::Noise, deviation.noise),
        (Cause::Parameters, deviation.weights),
        (Cause::Runs, deviation.blocks),
    ];
    all.into_iter().filter(|(_, deviation)| *deviation > 0.0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_is_cut_to_what_can_be_and_holds_its_mean() {
        let ends = |mean: f64| {
            let interval = Estimate::new(mean).by(vec![(Cause::Noise, 0.2)], 1.0).cut([0.0, 1.0]).interval;
            interval.map(|own| [own.lower, own.upper]).unwrap()
        };
        assert_eq!(ends(0.1), [0.0, 0.1 + 0.2]);
        assert_eq!(ends(0.95), [0.75, 1.0]);
        // A mean that cannot be is the end of its interval.
        assert_eq!(ends(-0.1), [-0.1, 0.1]);
        assert_eq!(ends(0.5), [0.3, 0.7]);
        assert!(Estimate::new(-1.0).cut([0.0, 1.0]).interval.is_none());
    }
}
