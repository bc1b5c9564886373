//! One table `[[stage]]` of a case, and the stages that it expands to.

use granum_dem::loading::preset::{self, Given, Preset};
use granum_dem::loading::{Stage, Until};
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Place in a case of the stages of its test, and of those of its preparation.
pub(super) const STAGE: &str = "stage";
pub(super) const PREPARATION_STAGE: &str = "preparation.stage";

/// Most stages that a test or a preparation may come to, with its repetitions.
pub(super) const MOST_STAGES: u64 = 10_000;

/// Most repetitions that may lie within one another. TOML is read to a depth of 80 tables, and a case with all its repetitions is
/// to be read back from the file that is written of it.
pub(super) const MOST_NESTED: usize = 32;

/// One table `[[stage]]` or `[[preparation.stage]]`.
///
/// ```
/// let text = "[[stage]]\npath = 'isotropic'\n[[stage]]\nrepeat = 3\n[[stage.stage]]\npath = 'drained-triaxial'\n";
/// let case = granum_io::Case::parse(text, "case.toml")?;
/// assert_eq!(case.test_stages().len(), 1 + 3);
/// # Ok::<(), granum_io::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CaseStage {
    /// A named path.
    Path {
        /// The path; in files its name. What is read by `serde` is one of granum's own.
        #[serde(rename = "name", serialize_with = "its_name", deserialize_with = "own_path")]
        path: &'static Preset,
        /// Its parameters in SI units; the others have their defaults.
        parameters: Given,
        /// False if strain, time and energy continue to count from an earlier stage.
        #[serde(default = "yes")]
        resets: bool,
        /// End conditions in addition to those of the path, of its stage that is driven.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        until: Vec<Until>,
    },
    /// A stage with an explicit control.
    Control(Box<Stage>),
    /// Stages that are repeated, one after another.
    Repeat {
        /// How often.
        times: u64,
        /// What.
        stages: Vec<CaseStage>,
    },
}

/// The stage of a path to which further end conditions belong: the only one beside those in which the sample comes to rest and those
/// that are only marks; `None` where there are several.
pub(super) fn driven(stages: &[Stage]) -> Option<usize> {
    let mut driven = stages.iter().enumerate().filter(|(_, stage)| !stage.settling && !stage.is_mark());
    match (driven.next(), driven.next()) {
        (Some((place, _)), None) => Some(place),
        _ => None,
    }
}

fn yes() -> bool {
    true
}

fn its_name<S: Serializer>(path: &Preset, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(path.name)
}

fn own_path<'d, D: Deserializer<'d>>(from: D) -> Result<&'static Preset, D::Error> {
    let name = String::deserialize(from)?;
    preset::named(&name).ok_or_else(|| D::Error::custom(format!("there is no path {name:?}")))
}

impl CaseStage {
    /// The stages that it expands to.
    pub fn stages(&self) -> Vec<Stage> {
        match self {
            CaseStage::Path { path, parameters, resets, until } => {
                let mut stages = path.expand(parameters);
                for stage in &mut stages {
                    stage.resets &= resets;
                }
                if let (false, Some(driven)) = (until.is_empty(), driven(&stages)) {
                    // An end that the path has by itself gives way to one of the same kind.
                    stages[driven].until.retain(|usual| until.iter().all(|end| !usual.is_of_kind(end)));
                    stages[driven].until.extend(until);
                }
                stages
            }
            CaseStage::Control(stage) => vec![(**stage).clone()],
            CaseStage::Repeat { times, stages } => {
                let once: Vec<Stage> = stages.iter().flat_map(CaseStage::stages).collect();
                let most = usize::try_from(MOST_STAGES).unwrap_or(usize::MAX);
                let times = usize::try_from(*times).unwrap_or(usize::MAX);
                once.iter().cycle().take(once.len().saturating_mul(times).min(most)).cloned().collect()
            }
        }
    }

    /// How many repetitions lie within one another.
    pub(super) fn nested(&self) -> usize {
        match self {
            CaseStage::Path { .. } | CaseStage::Control(_) => 0,
            CaseStage::Repeat { stages, .. } => 1 + stages.iter().map(CaseStage::nested).max().unwrap_or(0),
        }
    }

    /// How many stages it comes to.
    pub(super) fn count(&self) -> u64 {
        match self {
            CaseStage::Path { .. } | CaseStage::Control(_) => self.stages().len() as u64,
            CaseStage::Repeat { times, stages } => {
                let once = stages.iter().fold(0u64, |sum, stage| sum.saturating_add(stage.count()));
                once.saturating_mul(*times)
            }
        }
    }
}
