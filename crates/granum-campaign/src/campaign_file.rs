//! The content of the file of a campaign: its variables and runs, with all that determines them.

use granum_run::engine::LammpsStart;
use serde::{Deserialize, Serialize};

use crate::plan::{Keep, RunValue};

/// Layout of the file.
pub(crate) const FORMAT: u32 = 1;

/// The content of the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct CampaignFile {
    pub(crate) format: u32,
    /// Version of granum that planned the runs.
    pub(crate) granum_version: String,
    /// The text of the plan.
    pub(crate) plan: String,
    /// The resolved base case.
    pub(crate) case: String,
    pub(crate) variables: Vec<VariableRecord>,
    /// Limits up to which a run that did not pass a check is taken all the same.
    pub(crate) accept: Vec<String>,
    /// What stays of finished runs.
    #[serde(default, skip_serializing_if = "Keep::is_usual")]
    pub(crate) keep: Keep,
    /// The engine that carries out the tests; empty for granum's own.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(crate) engine: String,
    /// How LAMMPS is started, if it is the engine.
    #[serde(default, skip_serializing_if = "LammpsStart::is_usual")]
    pub(crate) lammps: LammpsStart,
    pub(crate) runs: Vec<CampaignRun>,
    /// Names of the runs of earlier plans whose folders are still there.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) no_longer_planned: Vec<String>,
}

/// A variable of a campaign.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VariableRecord {
    /// Its name.
    pub name: String,
    /// SI unit of its numbers; empty for pure numbers and words.
    pub unit: String,
    /// The keys that take its value.
    pub keys: Vec<String>,
    /// True if it is spread on a logarithmic scale.
    #[serde(default)]
    pub logarithmic: bool,
}

/// A run of a campaign.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CampaignRun {
    /// Its name, which is that of its folder.
    pub name: String,
    /// The values of the variables, in the order of [`Campaign::variables`](crate::Campaign::variables).
    pub values: Vec<RunValue>,
    /// The keys that it sets over the base case, with their values as text.
    pub settings: Vec<(String, String)>,
    /// Digest of its case.
    pub case_digest: String,
    /// True if other runs have the same sample, which is then a run of its own.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub shares_sample: bool,
    /// The name of the folder of a sample that it shares; empty in files of earlier versions.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub sample: String,
}
