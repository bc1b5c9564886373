//! What a study consists of.

use serde::{Deserialize, Serialize};

use super::member::{Member, MemberRole};
use super::thinning::thinned;
use crate::comparison::check_units;
use crate::dataset::{Dataset, Split, SplitParts};
use crate::error::{LearnError, Result};
use crate::methods::networks::NetworkSettings;
use crate::surrogate::{FitSpec, SurrogateMethods};

/// Name of the method that is the baseline with all inputs.
pub(crate) const RIDGE: &str = "ridge";

/// What a study consists of: fits, methods, and the split of its data set.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct StudyDefinition {
    /// What is fitted: inputs, outputs and coordinate. Each output should be in one fit only.
    pub fits: Vec<FitSpec>,
    /// Names of the methods.
    pub methods: Vec<String>,
    /// The split into training, held-out and unseen states.
    pub split: Split,
    /// Level of the intervals (0.9).
    pub level: f64,
    /// Settings of the methods with networks.
    #[serde(default)]
    pub networks: NetworkSettings,
    /// Largest number of training states: if there are more, every n-th of each run is used, see
    /// [`super::thinned`]. Methods with memory always learn from all states.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub most_states: Option<usize>,
    /// True if the error is also measured as a function of the number of training runs, see
    /// [`crate::learning_curve::LearningCurve`].
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub learning_curve: bool,
    /// Number of threads; 0 for the number of processors. Results do not depend on it.
    #[serde(skip)]
    pub threads: usize,
}

impl StudyDefinition {
    /// A definition with intervals of 90 %.
    pub fn new<M: Into<String>>(
        fits: impl IntoIterator<Item = FitSpec>,
        methods: impl IntoIterator<Item = M>,
        split: Split,
    ) -> StudyDefinition {
        StudyDefinition {
            fits: fits.into_iter().collect(),
            methods: methods.into_iter().map(Into::into).collect(),
            split,
            level: 0.9,
            networks: NetworkSettings::default(),
            most_states: None,
            learning_curve: false,
            threads: 0,
        }
    }

    /// Checks the definition against a data set before anything is fitted, and splits the data set.
    ///
    /// # Errors
    /// If a method or a column does not exist, a value is not finite, outputs of a fit have different
    /// units, or an input has the same value in all training states.
    pub fn check(&self, dataset: &Dataset, methods: &SurrogateMethods) -> Result<SplitParts> {
        let bad = |reason: String| Err(LearnError::Dataset(reason));
        if self.fits.is_empty() || self.methods.is_empty() {
            return bad("a study needs at least one fit and one method".into());
        }
        for (k, name) in self.methods.iter().enumerate() {
            methods.by_name(name)?;
            if self.methods[..k].contains(name) {
                return bad(format!("the method {name} is named twice"));
            }
        }
        let parts = dataset.split(&self.split)?;
        let training = self.training_states(&parts);
        for (k, fit) in self.fits.iter().enumerate() {
            let name = fit.fit_name();
            if self.fits[..k].iter().any(|other| other.fit_name() == name) {
                return bad(format!("the output {name} is named twice"));
            }
            let columns = fit.columns(dataset)?;
            check_units(&columns)?;
            dataset.values(&columns.output_names())?;
            dataset.values(&columns.input_names())?;
            for input in &fit.inputs {
                check_words(input, dataset, &parts.training)?;
            }
            for (input, variable) in fit.inputs.iter().map(|input| (input, dataset.variable(input))) {
                // A category holds words. A histogram has no column of its own name, and some of its bins may be empty in all states.
                if variable.is_err() || is_bin(dataset, input) {
                    continue;
                }
                let values = training.column(input)?;
                if let Some(same) = values.first().filter(|first| values.iter().all(|value| value == *first))
                {
                    return bad(format!(
                        "the input {input} is {same} in all training states, so that nothing can be learned from it; \
                         leave it out, or train on runs that differ in it"
                    ));
                }
            }
            for member in self.members(fit) {
                granum_io::check_name("name of an output", &member.name)?;
                let method = methods.by_name(&member.method)?;
                if member.role == MemberRole::Asked && !method.has_memory() {
                    method.check(&training, &member.spec)?;
                }
            }
        }
        Ok(parts)
    }

    /// The states from which methods without memory learn.
    pub fn training_states(&self, parts: &SplitParts) -> Dataset {
        match self.most_states {
            Some(most) => thinned(&parts.training, most),
            None => parts.training.clone(),
        }
    }

    /// The members that a fit has, without their surrogates: what is asked for, and the baselines.
    pub(super) fn members(&self, fit: &FitSpec) -> Vec<Planned> {
        let name = fit.fit_name();
        let has_others = fit.coordinate.is_some() && fit.inputs.len() > 1;
        let mut members: Vec<Planned> = Vec::new();
        let mut add = |method: &str, role: MemberRole| {
            let alone = role == MemberRole::CoordinateOnly;
            let mark = if alone { "-coordinate-only" } else { "" };
            let spec = match (&fit.coordinate, alone) {
                (Some(coordinate), true) => FitSpec { inputs: vec![coordinate.clone()], ..fit.clone() },
                _ => fit.clone(),
            };
            let name = format!("{name}-{method}{mark}");
            let spec = FitSpec { kept_as: Some(name.clone()), ..spec };
            if !members.iter().any(|member| member.name == name) {
                members.push(Planned { name, method: method.to_owned(), role, spec });
            }
        };
        for method in &self.methods {
            add(method, MemberRole::Asked);
        }
        add(RIDGE, MemberRole::Baseline);
        if has_others {
            for method in self.methods.iter().filter(|method| *method != MEAN_CURVE) {
                add(method, MemberRole::CoordinateOnly);
            }
            add(RIDGE, MemberRole::CoordinateOnly);
        }
        add(MEAN_CURVE, MemberRole::Baseline);
        members
    }
}

const MEAN_CURVE: &str = crate::methods::mean_curve::NAME;

/// Checks an input that holds words: the training runs must have several of them, and all that the other runs have.
fn check_words(input: &str, dataset: &Dataset, training: &Dataset) -> Result<()> {
    let Some(all) = dataset.category(input) else { return Ok(()) };
    let bad = |reason: String| Err(LearnError::Dataset(reason));
    let Some(known) = training.category(input) else {
        let words = all.list();
        return bad(format!(
            "the input {input} is a number in the training runs and a word in others ({words})"
        ));
    };
    if let [same] = known.words.as_slice() {
        return bad(format!(
            "the input {input} is {same} in all training runs, so that nothing can be learned from it; leave it out, or train on \
             runs that differ in it"
        ));
    }
    dataset.check_words(known.columns())
}

/// A member that is to be fitted.
pub(super) struct Planned {
    pub name: String,
    pub method: String,
    pub role: MemberRole,
    pub spec: FitSpec,
}

impl Planned {
    pub fn with(self, surrogate: Box<dyn crate::Surrogate>) -> Member {
        Member { name: self.name, method: self.method, role: self.role, surrogate }
    }
}

/// True if a column is a bin of a histogram.
fn is_bin(dataset: &Dataset, column: &str) -> bool {
    let groups = dataset.runs().iter().flat_map(|run| run.groups());
    groups.into_iter().any(|group| group.columns().any(|name| name == column))
}
