//! What a surrogate says of a row.

use super::Columns;

/// What a surrogate says of one row.
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
    /// One estimate for each output, in their order.
    pub values: Vec<Estimate>,
    /// The inputs that lie outside what it was fitted to; do not trust the estimates if there is one.
    pub outside: Vec<Outside>,
}

impl Prediction {
    /// From the estimates of all outputs, with every input inside.
    pub fn new(values: Vec<Estimate>) -> Prediction {
        Prediction { values, outside: Vec::new() }
    }

    /// The same with these inputs outside.
    pub fn with_outside(self, outside: Vec<Outside>) -> Prediction {
        Prediction { outside, ..self }
    }
}

/// What a surrogate says of one output.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Estimate {
    /// Its mean.
    pub mean: f64,
    /// Where observations of new runs lie; `None` where the surrogate does not know.
    pub interval: Option<Interval>,
}

impl Estimate {
    /// A mean of which no more is known.
    pub fn new(mean: f64) -> Estimate {
        Estimate { mean, interval: None }
    }

    /// The same with an interval that reaches `quantile` standard deviations to either side, which is told by what it comes
    /// from.
    pub fn by(self, causes: Vec<(Cause, f64)>, quantile: f64) -> Estimate {
        let mut interval = Interval { lower: self.mean, upper: self.mean, causes };
        let half = quantile * interval.standard_deviation();
        (interval.lower, interval.upper) = (self.mean - half, self.mean + half);
        Estimate { interval: Some(interval), ..self }
    }

    /// The same with an interval of these ends.
    pub fn within(self, [lower, upper]: [f64; 2], causes: Vec<(Cause, f64)>) -> Estimate {
        Estimate { interval: Some(Interval { lower, upper, causes }), ..self }
    }
}

/// An interval that holds the share of observations that was asked for.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Interval {
    /// Its lower end.
    pub lower: f64,
    /// Its upper end.
    pub upper: f64,
    /// The standard deviation by each cause that is known; their squares add up. Empty where the surrogate cannot tell them
    /// apart.
    pub causes: Vec<(Cause, f64)>,
}

impl Interval {
    /// The standard deviation by all causes together; 0 where none is known.
    pub fn standard_deviation(&self) -> f64 {
        self.causes.iter().map(|(_, deviation)| deviation * deviation).sum::<f64>().sqrt()
    }
}

/// Why an observation may lie off its prediction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Cause {
    /// The observations scatter about any smooth answer.
    Noise,
    /// The parameters of the surrogate are not determined by the rows that it was fitted to.
    Parameters,
    /// A new run differs as a whole from those that it was fitted to.
    Runs,
}

impl std::fmt::Display for Cause {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(match self {
            Cause::Noise => "noise",
            Cause::Parameters => "parameters",
            Cause::Runs => "runs",
        })
    }
}

/// An input that lies outside what a surrogate was fitted to.
#[derive(Clone, Debug, PartialEq)]
pub struct Outside {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// What it was fitted to.
    pub range: [f64; 2],
}

/// The inputs of a row that lie outside ranges, one for each input.
pub fn outside_of(columns: &Columns, ranges: &[[f64; 2]], row: &[f64]) -> Vec<Outside> {
    let each = columns.inputs.iter().zip(ranges).zip(row);
    let beyond = each.filter(|((_, [low, high]), value)| !(*value >= low && *value <= high));
    beyond
        .map(|((input, range), value)| Outside { name: input.name.clone(), value: *value, range: *range })
        .collect()
}
