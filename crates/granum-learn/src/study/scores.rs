//! The scores of a study.

use std::collections::BTreeMap;

use granum_core::parallel;
use serde::{Deserialize, Serialize};

use super::input_test::MemberTest;
use super::member::{Member, MemberRole, StudyFit};
use super::training::Study;
use crate::comparison::{Judged, judged};
use crate::dataset::{Dataset, SplitParts};
use crate::error::{LearnError, Result};
use crate::input_use::InputUse;
use crate::methods::networks::{NetworkScores, networks_of};
use crate::pooled_error::PooledError;
use crate::scatter::{self, SeedScatter};
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
    pub role: MemberRole,
    /// On the training states.
    pub training: PartScore,
    /// On the held-out states of the training runs.
    pub held_out: PartScore,
    /// On the unseen runs.
    pub unseen: PartScore,
    /// The error on the unseen runs with its standard error over them; null if it was not measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unseen_error: Option<PooledError>,
    /// The error of each output on the unseen runs.
    pub outputs: Vec<OutputScore>,
    /// The networks of its sub-models; empty for other surrogates.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub networks: Vec<NetworkScores>,
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
    /// The scatter of the outputs between runs that differ only in their seed; null if there are no such runs.
    #[serde(default)]
    pub seed_scatter: Option<SeedScatter>,
}

/// The scores of a study.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StudyScores {
    /// The scores of each fit.
    pub fits: Vec<FitScores>,
}

impl FitScores {
    /// The surrogates that were scored on unseen runs, that with the least error first.
    pub fn ranked(&self) -> Vec<(&MemberScores, PooledError)> {
        let members = self.members.iter();
        let mut ranked: Vec<(&MemberScores, PooledError)> =
            members.filter_map(|member| Some((member, member.unseen_error?))).collect();
        ranked.sort_by(|a, b| a.1.relative.total_cmp(&b.1.relative));
        ranked
    }
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
        let training = self.definition.training_states(&parts);
        let parts = SplitParts { training, ..parts };
        let members: Vec<(&StudyFit, &Member)> =
            self.fits.iter().flat_map(|fit| fit.members.iter().map(move |member| (fit, member))).collect();
        let scored = parallel::map(members.len(), self.definition.threads, |k| {
            let (fit, member) = members[k];
            Ok::<_, LearnError>((
                self.score_member(fit, member, &parts)?,
                use_of(fit, member, &parts.unseen)?,
            ))
        })?;
        let mut scored = members.iter().zip(scored);
        let mut fits = Vec::new();
        for fit in &self.fits {
            let (mut members, mut uses) = (Vec::new(), BTreeMap::new());
            for ((_, member), (scores, used)) in scored.by_ref().take(fit.members.len()) {
                members.push(scores);
                uses.extend(used.map(|used| (member.name.clone(), used)));
            }
            let seed_scatter = scatter::seed_scatter(&parts, &fit.spec)?;
            fits.push(FitScores { name: fit.name.clone(), members, uses, seed_scatter });
        }
        Ok(StudyScores { fits })
    }

    fn score_member(&self, fit: &StudyFit, member: &Member, parts: &SplitParts) -> Result<MemberScores> {
        let judge = |part: &Dataset| {
            let scored = fit.spec.scored_states(part)?;
            judged(member.surrogate.as_ref(), part, self.definition.level, &scored)
        };
        // A surrogate with memory was fitted to all states of the training runs.
        let (training, held_out) = match member.surrogate.has_memory() {
            true => (&parts.training_runs, &parts.held_out.select(|_, _| false)),
            false => (&parts.training, &parts.held_out),
        };
        let unseen = judge(&parts.unseen)?;
        let outputs = member.surrogate.columns().outputs.iter().zip(&unseen.outputs);
        let output = |(output, unseen): (&crate::Variable, &Score)| OutputScore {
            name: output.name.clone(),
            unit: output.unit.clone(),
            unseen: *unseen,
        };
        let networks = match networks_of(member.surrogate.as_ref()) {
            Some(networks) => networks.scores(parts)?,
            None => Vec::new(),
        };
        Ok(MemberScores {
            name: member.name.clone(),
            method: member.method.clone(),
            role: member.role,
            training: judge(training)?.into(),
            held_out: judge(held_out)?.into(),
            unseen_error: Some(unseen.pooled).filter(|_| unseen.score.states > 0),
            outputs: outputs.map(output).collect(),
            unseen: unseen.into(),
            networks,
        })
    }

    /// Scores one surrogate on any runs.
    ///
    /// # Errors
    /// As [`Study::evaluate`].
    pub fn score_part(&self, member: &Member, part: &Dataset) -> Result<PartScore> {
        let fit = self.fits.iter().find(|fit| fit.members.iter().any(|own| own.name == member.name));
        let scored = match fit {
            Some(fit) => fit.spec.scored_states(part)?,
            None => vec![true; part.rows()],
        };
        Ok(judged(member.surrogate.as_ref(), part, self.definition.level, &scored)?.into())
    }

    /// The use that a surrogate of a fit makes of its inputs on unseen runs; `None` if it has none besides the coordinate.
    ///
    /// # Errors
    /// As [`Study::evaluate`].
    pub fn member_use(&self, fit: &StudyFit, member: &Member, unseen: &Dataset) -> Result<Option<InputUse>> {
        use_of(fit, member, unseen)
    }

    /// The use that the surrogates of a fit make of their inputs on unseen runs, by their names; of those with inputs besides
    /// the coordinate.
    ///
    /// # Errors
    /// As [`Study::evaluate`].
    pub fn uses(&self, fit: &StudyFit, unseen: &Dataset) -> Result<BTreeMap<String, InputUse>> {
        let mut uses = BTreeMap::new();
        for member in &fit.members {
            uses.extend(use_of(fit, member, unseen)?.map(|used| (member.name.clone(), used)));
        }
        Ok(uses)
    }
}

impl From<Judged> for PartScore {
    fn from(judged: Judged) -> PartScore {
        PartScore { score: judged.score, coverage: judged.coverage, outside: judged.outside }
    }
}

/// The use that a surrogate makes of its inputs; `None` if it has none besides the coordinate, or without unseen states.
pub(crate) fn use_of(fit: &StudyFit, member: &Member, unseen: &Dataset) -> Result<Option<InputUse>> {
    let surrogate = member.surrogate.as_ref();
    let coordinate = fit.spec.place_of_coordinate(surrogate.columns());
    let others = surrogate.columns().inputs.len() > usize::from(coordinate.is_some());
    let baseline =
        member.role == MemberRole::CoordinateOnly || member.method == crate::methods::mean_curve::NAME;
    let Some(alone) = fit.coordinate_only(member).filter(|_| others && !baseline && unseen.rows() > 0) else {
        return Ok(None);
    };
    InputUse::measure(&MemberTest::new(surrogate, alone, &fit.spec, unseen)?).map(Some)
}
