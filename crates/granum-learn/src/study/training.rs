//! The training of a study.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};

use granum_core::observer::{Flow, Progress};
use granum_core::parallel;

use super::definition::{Planned, StudyDefinition};
use super::member::{Member, MemberRole, StudyFit};
use super::names::member_file;
use super::observer::StudyObserver;
use super::timed::Timed;
use crate::dataset::Dataset;
use crate::error::{LearnError, Result};
use crate::learning_curve::LearningCurve;
use crate::methods::mean_curve;
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
    /// Training time of each network by the name under which it is kept, s.
    pub seconds: BTreeMap<String, f64>,
    /// The errors as a function of the number of training runs, if they were measured.
    pub learning_curve: Option<LearningCurve>,
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
        let training = definition.training_states(&parts);
        let planned: Vec<(usize, Planned)> = (definition.fits.iter().enumerate())
            .flat_map(|(fit, spec)| definition.members(spec).into_iter().map(move |planned| (fit, planned)))
            .collect();
        let (done, total) = (AtomicUsize::new(0), planned.len());
        let stopped = || LearnError::Stopped { done: done.load(Ordering::Relaxed), total };
        let threads = match definition.threads {
            0 => parallel::available_threads(),
            threads => threads,
        };
        let timed = Timed::new(observer.networks());
        let fitted = parallel::map(total, threads, |k| {
            if observer.stop() {
                return Err(stopped());
            }
            let planned = &planned[k].1;
            observer.begins(&planned.name, k + 1, total);
            let threads = threads.div_ceil(total);
            let data = match methods.by_name(&planned.method)?.has_memory() {
                true => &parts.training_runs,
                false => &training,
            };
            let result = match fitted(planned, data, methods, threads, observer, &timed) {
                Ok(surrogate) => Ok(surrogate),
                Err(error @ LearnError::Surrogate { .. }) if planned.role != MemberRole::Asked => {
                    Err(format!("{} is missing: {error}", planned.name))
                }
                Err(LearnError::Stopped { .. }) => return Err(stopped()),
                Err(error) => return Err(error),
            };
            done.fetch_add(1, Ordering::Relaxed);
            Ok(result)
        })?;
        let fit = |spec: &crate::FitSpec| StudyFit {
            name: spec.fit_name(),
            spec: spec.clone(),
            members: Vec::new(),
            remarks: Vec::new(),
        };
        let mut fits: Vec<StudyFit> = definition.fits.iter().map(fit).collect();
        for ((fit, planned), result) in planned.into_iter().zip(fitted) {
            match result {
                Ok(surrogate) => fits[fit].members.push(planned.with(surrogate)),
                Err(remark) => fits[fit].remarks.push(remark),
            }
        }
        Ok(Study {
            definition: definition.clone(),
            dataset_digest: dataset.digest(),
            runs: Vec::new(),
            fits,
            seconds: timed.into_seconds(),
            learning_curve: None,
        })
    }

    /// The time of the training of the networks of a surrogate, s; 0 if it has none or it is unknown.
    pub fn seconds_of(&self, member: &Member) -> f64 {
        let own = |name: &str| {
            let number = name.strip_prefix(&member.name).and_then(|rest| rest.strip_prefix('-'));
            number.is_some_and(|number| number.parse::<usize>().is_ok())
        };
        self.seconds.iter().filter(|(name, _)| own(name)).map(|(_, seconds)| seconds).sum()
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

/// Refuses a finished surrogate whose method, inputs or outputs are not those of the fit: its file was put in the place of another one.
fn check_fit(planned: &Planned, surrogate: &dyn Surrogate) -> Result<()> {
    let (columns, spec) = (surrogate.columns(), &planned.spec);
    let (inputs, outputs) = (
        columns.input_names(),
        columns.outputs.iter().map(|output| output.name.as_str()).collect::<Vec<_>>(),
    );
    // A mean curve, and a method of another program, may use fewer inputs than it is given.
    let uses_all =
        planned.method != mean_curve::NAME && SurrogateMethods::standard().by_name(&planned.method).is_ok();
    let same_inputs =
        if uses_all { inputs == spec.inputs } else { inputs.iter().all(|input| spec.inputs.contains(input)) };
    if surrogate.method() == planned.method && same_inputs && outputs == spec.outputs {
        return Ok(());
    }
    let reason = format!(
        "it is not the surrogate of this fit, which is {} from {} to {}, but {} from {} to {}; remove the file, and it is fitted again",
        planned.method,
        spec.inputs.join(", "),
        spec.outputs.join(", "),
        surrogate.method(),
        inputs.join(", "),
        outputs.join(", ")
    );
    Err(LearnError::SurrogateFile { file: member_file(&planned.name), reason })
}

fn fitted(
    planned: &Planned,
    training: &Dataset,
    methods: &SurrogateMethods,
    threads: usize,
    observer: &dyn StudyObserver,
    checkpoints: &Timed,
) -> Result<Box<dyn Surrogate>> {
    if let Some(surrogate) = observer.finished(&planned.name)? {
        check_fit(planned, surrogate.as_ref())?;
        checkpoints.found(&planned.name, surrogate.as_ref());
        return Ok(surrogate);
    }
    let mut listen = |progress: &Progress| {
        observer.progress(&planned.name, progress);
        if observer.stop() { Flow::Stop } else { Flow::Continue }
    };
    let spec = planned.spec.clone().with_threads(threads);
    let method = methods.by_name(&planned.method)?;
    let surrogate = method.fit_resumable(training, &spec, &mut listen, checkpoints)?;
    observer.fitted(&planned.name, surrogate.as_ref())?;
    Ok(surrogate)
}
