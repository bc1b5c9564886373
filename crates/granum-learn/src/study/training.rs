//! The training of a study.

use granum_core::observer::{Flow, Progress};

use super::definition::{Planned, StudyDefinition, fit_name};
use super::member::{Member, Role, StudyFit};
use super::observer::StudyObserver;
use crate::dataset::{Dataset, SplitParts};
use crate::error::{LearnError, Result};
use crate::runs::StudyRun;
use crate::surrogate::{Surrogate, SurrogateMethods};

/// A trained study; the documentation of [this module](super) has an example.
pub struct Study {
    /// What it consists of.
    pub definition: StudyDefinition,
    /// SHA-256 of its data set.
    pub dataset_digest: String,
    /// The runs for training and evaluation, if they are run folders.
    pub runs: Vec<StudyRun>,
    /// The fits with their surrogates.
    pub fits: Vec<StudyFit>,
}

impl Study {
    /// Fits all surrogates to the training part of a data set. The result does not depend on the number of threads.
    ///
    /// # Errors
    /// As [`StudyDefinition::check`]; if a method that was asked for cannot be fitted; or [`LearnError::Stopped`] if the
    /// observer stops the training. A baseline that cannot be fitted is left out, with a remark.
    pub fn train(
        dataset: &Dataset,
        definition: &StudyDefinition,
        methods: &SurrogateMethods,
        observer: &dyn StudyObserver,
    ) -> Result<Study> {
        let parts = definition.check(dataset, methods)?;
        let total = definition.fits.iter().map(|fit| definition.members(fit).len()).sum();
        let mut done = 0;
        let mut fits = Vec::new();
        for spec in &definition.fits {
            let (mut members, mut remarks) = (Vec::new(), Vec::new());
            for planned in definition.members(spec) {
                if observer.stop() {
                    return Err(LearnError::Stopped { done, total });
                }
                observer.begins(&planned.name, done + 1, total);
                match fitted(&planned, &parts, methods, observer) {
                    Ok(surrogate) => members.push(planned.with(surrogate)),
                    Err(error @ LearnError::Surrogate { .. }) if planned.role != Role::Asked => {
                        remarks.push(format!("{} is missing: {error}", planned.name));
                    }
                    Err(LearnError::Stopped { .. }) => return Err(LearnError::Stopped { done, total }),
                    Err(error) => return Err(error),
                }
                done += 1;
            }
            fits.push(StudyFit { name: fit_name(spec), spec: spec.clone(), members, remarks });
        }
        Ok(Study { definition: definition.clone(), dataset_digest: dataset.digest(), runs: Vec::new(), fits })
    }

    /// Every surrogate of the study.
    pub fn members(&self) -> impl Iterator<Item = &Member> {
        self.fits.iter().flat_map(|fit| &fit.members)
    }

    /// The surrogate of the given name.
    ///
    /// # Errors
    /// [`LearnError::Unknown`] with the existing names.
    pub fn member(&self, name: &str) -> Result<&Member> {
        self.members().find(|member| member.name == name).ok_or_else(|| LearnError::Unknown {
            kind: "surrogate in the study",
            name: name.to_owned(),
            known: self.members().map(|member| member.name.as_str()).collect::<Vec<_>>().join(", "),
        })
    }
}

fn fitted(
    planned: &Planned,
    parts: &SplitParts,
    methods: &SurrogateMethods,
    observer: &dyn StudyObserver,
) -> Result<Box<dyn Surrogate>> {
    if let Some(surrogate) = observer.finished(&planned.name)? {
        return Ok(surrogate);
    }
    let method = methods.by_name(&planned.method)?;
    let training = if method.has_memory() { &parts.training_runs } else { &parts.training };
    let mut listen = |progress: &Progress| {
        observer.progress(&planned.name, progress);
        if observer.stop() { Flow::Stop } else { Flow::Continue }
    };
    let surrogate = method.fit(training, &planned.spec, &mut listen)?;
    observer.fitted(&planned.name, surrogate.as_ref())?;
    Ok(surrogate)
}
