//! The runs of a campaign with what its report draws of them.

use std::collections::BTreeMap;

use granum_run::strength::Curves;

use crate::data::RunReport;
use crate::path;

/// Number of points of all curves of a panel together.
pub(super) const MOST_POINTS: usize = 40_000;
/// Fewest and most points of one curve.
pub(super) const POINTS_OF_CURVE: [usize; 2] = [12, 80];

/// The value of a variable in a run.
#[derive(Clone, Debug, PartialEq)]
pub enum VariableValue {
    /// A number in SI units.
    Number(f64),
    /// A word.
    Word(String),
}

/// A variable of a campaign.
#[derive(Clone, Debug, PartialEq)]
pub struct ReportVariable {
    /// Its name.
    pub name: String,
    /// SI unit; empty for pure numbers and words.
    pub unit: String,
    /// True if it is spread on a logarithmic scale.
    pub logarithmic: bool,
    /// True if it is the seed of a sample.
    pub is_seed: bool,
}

/// A finished run of a campaign, with what the report draws of it.
#[derive(Clone, Debug, PartialEq)]
pub struct CampaignEntry {
    /// Its name.
    pub name: String,
    /// Its values of the variables, in their order.
    pub values: Vec<VariableValue>,
    /// Stress ratio against strain, void ratio against strain, void ratio against mean stress.
    pub(super) curves: [Vec<[f64; 2]>; 3],
    /// The label of the strain.
    pub(super) strain: &'static str,
    pub(super) measures: BTreeMap<String, f64>,
    /// The checks that it did not pass, with their values.
    pub flags: Vec<(String, f64)>,
    /// True if it is part of the data set.
    pub accepted: bool,
    pub(super) seconds: f64,
}

impl CampaignEntry {
    /// The entry of a run among so many.
    pub fn new(run: &RunReport, values: Vec<VariableValue>, accepted: bool, runs: usize) -> CampaignEntry {
        let most = (MOST_POINTS / runs.max(1)).clamp(POINTS_OF_CURVE[0], POINTS_OF_CURVE[1]);
        let stages = run.case.test_stages();
        let curves = Curves::new(&run.record, &stages);
        let (strain, label) = run.strain_and_label();
        let ratio = path::where_stress(&curves, curves.stress_ratio().iter().copied());
        let void = curves.void_ratio();
        let against_stress = curves.mean_stress().iter().zip(&void).map(|(p, e)| [*p, *e]).collect();
        CampaignEntry {
            name: run.name.clone(),
            values,
            curves: [
                thinned(path::lines(run, &strain, &ratio), most),
                thinned(path::lines(run, &strain, &void), most),
                thinned(against_stress, most),
            ],
            strain: label,
            measures: run.run.measures.clone(),
            flags: run
                .run
                .quality
                .iter()
                .filter(|flag| !flag.passed)
                .map(|flag| (flag.name.clone(), flag.value))
                .collect(),
            accepted,
            seconds: run.wall_seconds(),
        }
    }

    pub(super) fn measure(&self, name: &str) -> Option<f64> {
        self.measures.get(name).copied().filter(|value| value.is_finite())
    }
}

/// At most so many points of a curve, the first and the last among them.
pub(super) fn thinned(points: Vec<[f64; 2]>, most: usize) -> Vec<[f64; 2]> {
    let last = points.len().saturating_sub(1);
    if points.len() <= most || most < 2 {
        return points;
    }
    (0..most).map(|k| points[k * last / (most - 1)]).collect()
}

/// A campaign with what its report tells.
#[derive(Clone, Debug, PartialEq)]
pub struct CampaignRuns {
    /// Its name.
    pub name: String,
    /// The variables.
    pub variables: Vec<ReportVariable>,
    /// The finished runs.
    pub runs: Vec<CampaignEntry>,
    /// The runs that failed: names, values in words and reasons.
    pub failed: Vec<[String; 3]>,
    /// Number of runs that are not finished.
    pub unfinished: usize,
    /// The number of the variable by which curves are coloured.
    pub coloured_by: usize,
}
