//! The scores of a study.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::input_test::MemberTest;
use super::member::{Member, Role, StudyFit};
use super::training::Study;
use crate::comparison::judged;
use crate::dataset::Dataset;
use crate::error::Result;
use crate::input_use::InputUse;
use crate::score::Score;

/// The score of a surrogate on a part of a data set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PartScore {
    /// The score of all outputs together.
    pub score: Score,
    /// The share of the values that lie within their intervals; null without intervals or states.
    pub coverage: Option<f64>,
    /// Number of states with an input outside the trained range.
    pub outside: usize,
}

/// The score of one output on the unseen runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OutputScore {
    /// Name of the column.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// The score.
    pub unseen: Score,
}

/// The scores of a surrogate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MemberScores {
    /// Name of the surrogate.
    pub name: String,
    /// Name of its method.
    pub method: String,
    /// Its role.
    pub role: Role,
    /// On the training states.
    pub training: PartScore,
    /// On the held-out states of the training runs.
    pub held_out: PartScore,
    /// On the unseen runs.
    pub unseen: PartScore,
    /// The error of each output on the unseen runs.
    pub outputs: Vec<OutputScore>,
}

/// The scores of a fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FitScores {
    /// Name of the fit.
    pub name: String,
    /// The scores of its surrogates.
    pub members: Vec<MemberScores>,
    /// For each surrogate with inputs besides the coordinate, by its name: the use of these inputs on the unseen runs.
    pub uses: BTreeMap<String, InputUse>,
}

/// The scores of a study.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StudyScores {
    /// The scores of each fit.
    pub fits: Vec<FitScores>,
}

impl StudyScores {
    /// The scores of the surrogate of the given name.
    pub fn member(&self, name: &str) -> Option<&MemberScores> {
        self.fits.iter().flat_map(|fit| &fit.members).find(|member| member.name == name)
    }
}

impl Study {
    /// Scores all surrogates on the parts of the data set with which they were trained.
    ///
    /// # Errors
    /// If a column is missing or a state cannot be predicted.
    pub fn evaluate(&self, dataset: &Dataset) -> Result<StudyScores> {
        let parts = dataset.split(&self.definition.split)?;
        let fits = self.fits.iter().map(|fit| {
            let score = |member: &Member| {
                let on = |part: &Dataset| self.score_part(member, part);
                // A surrogate with memory was fitted to all states of the training runs.
                let (training, held_out) = match member.surrogate.has_memory() {
                    true => (&parts.training_runs, &parts.held_out.select(|_, _| false)),
                    false => (&parts.training, &parts.held_out),
                };
                Ok(MemberScores {
                    name: member.name.clone(),
                    method: member.method.clone(),
                    role: member.role,
                    training: on(training)?,
                    held_out: on(held_out)?,
                    unseen: on(&parts.unseen)?,
                    outputs: self.score_outputs(member, &parts.unseen)?,
                })
            };
            let members = fit.members.iter().map(score).collect::<Result<_>>()?;
            Ok(FitScores { name: fit.name.clone(), members, uses: self.uses(fit, &parts.unseen)? })
        });
        Ok(StudyScores { fits: fits.collect::<Result<_>>()? })
    }

    /// Scores one surrogate on any runs.
    ///
    /// # Errors
    /// As [`Study::evaluate`].
    pub fn score_part(&self, member: &Member, part: &Dataset) -> Result<PartScore> {
        let judged = judged(member.surrogate.as_ref(), part, self.definition.level)?;
        Ok(PartScore { score: judged.score, coverage: judged.coverage, outside: judged.outside })
    }

    fn score_outputs(&self, member: &Member, part: &Dataset) -> Result<Vec<OutputScore>> {
        let scores = judged(member.surrogate.as_ref(), part, self.definition.level)?.outputs;
        let outputs = member.surrogate.columns().outputs.iter().zip(scores);
        let score = |(output, unseen): (&crate::Variable, Score)| OutputScore {
            name: output.name.clone(),
            unit: output.unit.clone(),
            unseen,
        };
        Ok(outputs.map(score).collect())
    }

    /// The use that the surrogates of a fit make of their inputs on unseen runs, by their names; of those with inputs besides
    /// the coordinate.
    ///
    /// # Errors
    /// As [`Study::evaluate`].
    pub fn uses(&self, fit: &StudyFit, unseen: &Dataset) -> Result<BTreeMap<String, InputUse>> {
        let mut uses = BTreeMap::new();
        if unseen.rows() == 0 {
            return Ok(uses);
        }
        for member in fit.members.iter().filter(|member| member.role != Role::CoordinateOnly) {
            let Some(alone) = fit.coordinate_only(member) else { continue };
            let coordinate = fit.spec.place_of_coordinate(member.surrogate.columns());
            if member.surrogate.columns().inputs.len() <= usize::from(coordinate.is_some()) {
                continue;
            }
            if member.method == crate::surrogate::mean_curve::NAME {
                continue;
            }
            let test = MemberTest::new(member.surrogate.as_ref(), alone, coordinate, unseen)?;
            uses.insert(member.name.clone(), InputUse::measure(&test)?);
        }
        Ok(uses)
    }
}
