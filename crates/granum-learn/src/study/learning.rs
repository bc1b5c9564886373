//! The measurement of a learning curve: a study is trained again on fewer of its runs.

use granum_core::observer::Progress;

use super::definition::{RIDGE, StudyDefinition};
use super::member::{Member, MemberRole, StudyFit};
use super::observer::StudyObserver;
use super::scores::use_of;
use super::training::Study;
use crate::dataset::{Dataset, RunStates};
use crate::error::{LearnError, Result};
use crate::input_use::InputUse;
use crate::learning_curve::{LearningCurve, LearningPoint, MeanError};
use crate::methods::networks::NetworkCheckpoints;
use crate::student_t::PairedTest;
use crate::surrogate::SurrogateMethods;

impl LearningCurve {
    /// Trains the fits of a study on the given numbers of its training runs and scores them on its unseen runs. For each number
    /// at most `most_sets` different sets of runs are used. The surrogates are not kept.
    ///
    /// # Errors
    /// As [`Study::train`].
    pub fn measure(
        dataset: &Dataset,
        definition: &StudyDefinition,
        methods: &SurrogateMethods,
        (numbers, most_sets): (&[usize], usize),
        observer: &dyn StudyObserver,
    ) -> Result<LearningCurve> {
        let is_unseen = |run: &&RunStates| definition.split.unseen.iter().any(|name| name == run.name());
        let (unseen, training): (Vec<&RunStates>, Vec<&RunStates>) =
            dataset.runs().iter().partition(is_unseen);
        if unseen.is_empty() {
            return Err(LearnError::Dataset("a learning curve needs unseen runs".into()));
        }
        let mut curve = LearningCurve { unseen_runs: unseen.len(), points: Vec::new() };
        for &count in numbers {
            let sets: Vec<&[&RunStates]> = training.chunks_exact(count.max(1)).take(most_sets).collect();
            let mut found: Vec<Sums> = Vec::new();
            for set in &sets {
                let runs = set.iter().chain(&unseen).map(|run| (*run).clone()).collect();
                let part = Dataset::new(runs)?;
                let study = Study::train(&part, definition, methods, &Unkept { observer, runs: count })?;
                let unseen = part.split(&definition.split)?.unseen;
                let asked = study.fits.iter().flat_map(|fit| {
                    let members = fit.members.iter().filter(|member| member.role == MemberRole::Asked);
                    members.map(move |member| (fit, member))
                });
                for (k, (fit, member)) in asked.enumerate() {
                    if found.len() == k {
                        found.push(Sums::new(fit, member));
                    }
                    found[k].add(&study, fit, member, &unseen)?;
                }
            }
            curve.points.extend(found.into_iter().map(|sums| sums.point(count, sets.len())));
        }
        // The order of the first points is that of the fits and methods.
        let order: Vec<(String, String)> =
            curve.points.iter().map(|point| (point.fit.clone(), point.method.clone())).collect();
        let place = |point: &LearningPoint| {
            order.iter().position(|(fit, method)| *fit == point.fit && *method == point.method)
        };
        curve.points.sort_by_key(|point| (place(point), point.training_runs));
        Ok(curve)
    }
}

/// Follows a study of the curve, whose surrogates are not kept.
struct Unkept<'a> {
    observer: &'a dyn StudyObserver,
    runs: usize,
}

impl StudyObserver for Unkept<'_> {
    fn begins(&self, name: &str, number: usize, all: usize) {
        let runs = self.runs;
        self.observer.begins(&format!("{name} from {runs} runs"), number, all);
    }
    fn progress(&self, name: &str, progress: &Progress) {
        self.observer.progress(name, progress);
    }
    fn networks(&self) -> &dyn NetworkCheckpoints {
        &crate::methods::networks::NoCheckpoints
    }
    fn stop(&self) -> bool {
        self.observer.stop()
    }
}

/// The errors of a surrogate on each unseen run, summed over sets.
#[derive(Clone, Copy, Debug, Default)]
struct Errors {
    own: f64,
    coordinate_only: f64,
    with_other: Option<f64>,
    ridge: Option<f64>,
    ridge_coordinate_only: Option<f64>,
}

struct Sums {
    fit: String,
    method: String,
    by_run: Vec<Errors>,
}

impl Sums {
    fn new(fit: &StudyFit, member: &Member) -> Sums {
        Sums { fit: fit.name.clone(), method: member.method.clone(), by_run: Vec::new() }
    }

    fn add(&mut self, study: &Study, fit: &StudyFit, member: &Member, unseen: &Dataset) -> Result<()> {
        let used = use_of(fit, member, unseen)?;
        let mut found = match used {
            Some(used) => errors_of_use(&used),
            None => self.errors_alone(study, member, unseen)?,
        };
        let ridge = |role: MemberRole| {
            let own = fit.members.iter().find(|other| {
                other.method == RIDGE
                    && (other.role == MemberRole::CoordinateOnly) == (role == MemberRole::CoordinateOnly)
            });
            own.map(|ridge| errors_by_run(study, ridge, unseen)).transpose()
        };
        let (with_inputs, alone) = (ridge(MemberRole::Baseline)?, ridge(MemberRole::CoordinateOnly)?);
        for (k, errors) in found.iter_mut().enumerate() {
            errors.ridge = with_inputs.as_ref().and_then(|errors| errors.get(k).copied());
            errors.ridge_coordinate_only = alone.as_ref().and_then(|errors| errors.get(k).copied());
        }
        if self.by_run.is_empty() {
            self.by_run = found;
            return Ok(());
        }
        for (sum, found) in self.by_run.iter_mut().zip(found) {
            let both = |a: Option<f64>, b: Option<f64>| a.zip(b).map(|(a, b)| a + b);
            sum.own += found.own;
            sum.coordinate_only += found.coordinate_only;
            sum.with_other = both(sum.with_other, found.with_other);
            sum.ridge = both(sum.ridge, found.ridge);
            sum.ridge_coordinate_only = both(sum.ridge_coordinate_only, found.ridge_coordinate_only);
        }
        Ok(())
    }

    /// The errors of a surrogate without inputs besides the coordinate.
    fn errors_alone(&self, study: &Study, member: &Member, unseen: &Dataset) -> Result<Vec<Errors>> {
        let errors = errors_by_run(study, member, unseen)?;
        Ok(errors.into_iter().map(|own| Errors { own, coordinate_only: own, ..Errors::default() }).collect())
    }

    fn point(self, training_runs: usize, sets: usize) -> LearningPoint {
        let count = sets as f64;
        let mean = |value: &dyn Fn(&Errors) -> f64| -> MeanError {
            MeanError::new(&self.by_run.iter().map(|errors| value(errors) / count).collect::<Vec<_>>())
        };
        let some = |value: &dyn Fn(&Errors) -> Option<f64>| -> Option<MeanError> {
            let values: Option<Vec<f64>> =
                self.by_run.iter().map(|errors| Some(value(errors)? / count)).collect();
            values.filter(|values| !values.is_empty()).map(|values| MeanError::new(&values))
        };
        let difference = |value: &dyn Fn(&Errors) -> Option<f64>| -> Option<PairedTest> {
            let values: Option<Vec<f64>> =
                self.by_run.iter().map(|errors| Some(value(errors)? / count)).collect();
            PairedTest::new(&values?)
        };
        LearningPoint {
            training_runs,
            sets,
            error: mean(&|errors| errors.own),
            coordinate_only: mean(&|errors| errors.coordinate_only),
            ridge: some(&|errors| errors.ridge),
            ridge_coordinate_only: some(&|errors| errors.ridge_coordinate_only),
            with_other: some(&|errors| errors.with_other),
            help: difference(&|errors| Some(errors.coordinate_only - errors.own)).unwrap_or_default(),
            lost_with_other: difference(&|errors| Some(errors.with_other? - errors.own)),
            fit: self.fit,
            method: self.method,
        }
    }
}

fn errors_of_use(used: &InputUse) -> Vec<Errors> {
    let errors = used.runs.iter().map(|run| Errors {
        own: run.own,
        coordinate_only: run.coordinate_only,
        with_other: run.with_other,
        ..Errors::default()
    });
    errors.collect()
}

/// The relative RMSE of a surrogate on every unseen run with a scored state.
fn errors_by_run(study: &Study, member: &Member, unseen: &Dataset) -> Result<Vec<f64>> {
    let mut errors = Vec::new();
    for run in unseen.runs() {
        let score = study.score_part(member, &Dataset::new(vec![run.clone()])?)?.score;
        if score.states > 0 {
            errors.push(score.relative_rmse);
        }
    }
    Ok(errors)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::Split;
    use crate::study::NoStudyObserver;
    use crate::surrogate::FitSpec;
    use crate::synthetic::{Law, dataset_of, records};

    #[test]
    fn an_input_that_shows_a_hidden_variable_helps_and_one_that_does_not_does_not() {
        let curve = |law| {
            let dataset = dataset_of(&records(law, 6));
            let fit = FitSpec::new(["deviator_strain", "deviator_fabric"], ["stress_ratio"]);
            let fit = fit.with_coordinate("deviator_strain");
            let split = Split::default().unseen(["run-3", "run-4", "run-5", "run-6"]);
            let definition = StudyDefinition::new([fit], ["ridge"], split);
            let methods = SurrogateMethods::standard();
            LearningCurve::measure(&dataset, &definition, &methods, (&[1, 2], 2), &NoStudyObserver).unwrap()
        };
        let hidden = curve(Law::Hidden);
        let numbers: Vec<_> = hidden.points.iter().map(|point| (point.training_runs, point.sets)).collect();
        assert_eq!(numbers, [(1, 2), (2, 1)]);
        let last = &hidden.points[1];
        assert!(last.helps() && last.error.mean < 0.7 * last.coordinate_only.mean, "{last:?}");
        assert!(last.with_other.unwrap().mean > 1.5 * last.error.mean);
        // The surrogate is the ridge regression itself.
        assert_eq!(last.ridge.unwrap().mean, last.error.mean);
        assert!(!curve(Law::Blind).points.iter().any(LearningPoint::helps));
    }
}
