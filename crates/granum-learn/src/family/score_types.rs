//! The scores of a family, and the data that they and its fit are of.

use serde::{Deserialize, Serialize};

/// The data to which a family was fitted.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainingData {
    /// Their name, such as that of their folder.
    pub name: String,
    /// SHA-256 over their content.
    pub digest: String,
    /// Number of runs.
    pub runs: usize,
}

/// The scores on some runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FamilyScores {
    /// The runs on which it was scored.
    pub data: TrainingData,
    /// Number of points with two or more runs that are alike but for their seeds.
    pub points: usize,
    /// Number of runs with an input outside the range of the training runs, or with two inputs that these do not have together.
    pub outside: usize,
    /// Names of the runs that were not scored since their curves end early.
    pub left_out: Vec<String>,
    /// Share of new samples of which a state should be within its interval.
    pub level: f64,
    /// The scores of each output.
    pub outputs: Vec<FamilyOutputScore>,
}

/// The scores of an output; a distribution is scored with all of its bins.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FamilyOutputScore {
    /// The output.
    pub output: String,
    /// Root mean square of the error for a single run over that of its values.
    pub relative_error: f64,
    /// Root mean square of the scatter of runs that are alike over that of their mean; NaN (null) without such runs.
    #[serde(deserialize_with = "null_is_nan")]
    pub relative_scatter: f64,
    /// Mean error over runs that are alike, net of what chance leaves of it, over the scatter of a single run; NaN (null) without such runs.
    #[serde(deserialize_with = "null_is_nan")]
    pub net_error: f64,
    /// Its standard error over the points, by the jackknife.
    #[serde(deserialize_with = "null_is_nan")]
    pub standard_error: f64,
    /// Share of the states within their intervals.
    pub held: f64,
    /// The same of the runs that are not flagged: with all inputs within the ranges of the fit, and no two that its runs do not have together. `None` if
    /// none is flagged or all are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub held_within: Option<f64>,
    /// Share of the curves that are within their bands as a whole; for a distribution the mean over its bins.
    pub whole_curves: f64,
    /// Share of the states within their intervals in each quarter of the range of each input.
    pub quarters: Vec<QuarterCoverage>,
}

/// The share of states within their intervals, by quarters of the range of an input.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct QuarterCoverage {
    /// The input.
    pub input: String,
    /// The share in each quarter, from the lowest; `None` where there is no run.
    pub held: [Option<f64>; 4],
    /// The standard error of each share over the materials: runs that are alike but for their seeds are one. `None` with fewer than two materials, and in
    /// files of earlier versions.
    #[serde(default, skip_serializing_if = "is_unknown")]
    pub standard_errors: [Option<f64>; 4],
    /// Number of runs in each quarter.
    pub runs: [usize; 4],
}

fn is_unknown(errors: &[Option<f64>; 4]) -> bool {
    errors.iter().all(Option::is_none)
}

fn null_is_nan<'d, D: serde::Deserializer<'d>>(from: D) -> std::result::Result<f64, D::Error> {
    Ok(Option::<f64>::deserialize(from)?.unwrap_or(f64::NAN))
}
