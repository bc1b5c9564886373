//! The measurement of all answers.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use granum_core::observer::{Flow, NoObserver, Observer, Progress};
use granum_core::parallel;

use super::answers::{Answer, Worth};
use super::knowledge::{Knowledge, Source};
use super::plan::{FEWEST_RUNS, WorthPlan};
use crate::curve::{interpolated, never_falls};
use crate::dataset::{Dataset, RunStates};
use crate::error::{LearnError, Result};
use crate::input_use::permutation;
use crate::pooled_error::PooledError;
use crate::study::thinned;
use crate::surrogate::{FitSpec, RunInputs, Surrogate, SurrogateMethod, SurrogateMethods};

/// Name of the method that predicts sensors first.
const CASCADE: &str = "cascade";
/// Every run with this remainder is left out when methods are compared.
const LEFT_OUT: [usize; 2] = [2, 5];
/// Most other runs whose sensors a run is given.
const MOST_OTHERS: usize = 4;

/// Fits a surrogate for every knowledge and scores it on unseen runs, path by path. The answers do not depend on the number of threads.
///
/// # Errors
/// If the plan does not fit the runs (as named there), if a surrogate cannot be fitted with any of the methods, and
/// [`LearnError::Stopped`] if the observer stops the measurement.
pub fn measure(
    training: &Dataset,
    unseen: &Dataset,
    plan: &WorthPlan,
    methods: &SurrogateMethods,
    observer: &mut dyn Observer,
) -> Result<Worth> {
    plan.check(training, unseen, methods)?;
    let names_of_unseen = unseen.runs().iter().map(|run| run.name().to_owned()).collect();
    let (training, unseen) = (by_path(training), by_path(unseen));
    let (mut tasks, mut remarks) = (Vec::new(), Vec::new());
    for (path, unseen) in &unseen {
        let Some(training) = training.get(path) else {
            remarks.push(format!("there is no training run of the path {path}"));
            continue;
        };
        if training.runs().len() < FEWEST_RUNS {
            remarks.push(format!("the path {path} has fewer than {FEWEST_RUNS} training runs"));
            continue;
        }
        let unseen = thinned(unseen, plan.most_states);
        let all = training.runs().len();
        let mut counts: Vec<usize> = plan.counts.iter().map(|count| *count.min(&all)).collect();
        counts.dedup();
        let questions =
            [(&plan.outputs, Knowledge::of_sensors(plan)), (&plan.sensors, Knowledge::of_outputs(plan))];
        for (outputs, knowledge) in questions {
            for count in &counts {
                let task = |outputs: &[String], knowledge: Vec<Knowledge>| Task {
                    path: path.clone(),
                    outputs: outputs.to_vec(),
                    count: *count,
                    knowledge,
                    training: training.clone(),
                    unseen: unseen.clone(),
                };
                for fit in fits(&knowledge) {
                    // The first stage of a cascade, which costs most, is the same for all outputs.
                    match fit[0].source {
                        Source::Predicted => tasks.push(task(outputs, fit)),
                        _ => tasks.extend(outputs.chunks(1).map(|output| task(output, fit.clone()))),
                    }
                }
            }
        }
    }
    // Those that take longest first.
    tasks.sort_by_key(|task| (task.knowledge[0].source != Source::Predicted, std::cmp::Reverse(task.count)));
    let total = tasks.len();
    let (done, observer) = (AtomicUsize::new(0), Mutex::new((observer, false)));
    let found = parallel::map(total, plan.threads, |k| {
        let task = &tasks[k];
        let before = done.load(Ordering::Relaxed);
        let progress = Progress::new("comparison", "surrogates", before as u64).out_of(total as u64);
        let progress = progress.part(format!("{}, {} runs", task.outputs.join(" and "), task.count));
        let mut locked = observer.lock().unwrap_or_else(PoisonError::into_inner);
        locked.1 |= locked.0.progress(&progress) == Flow::Stop;
        let stopped = locked.1;
        drop(locked);
        if stopped {
            return Err(LearnError::Stopped { done: before, total });
        }
        let answers = task.answers(plan, methods)?;
        done.fetch_add(1, Ordering::Relaxed);
        Ok(answers)
    })?;
    let mut answers: Vec<Answer> = found.into_iter().flatten().collect();
    // In the order in which paths, outputs, numbers of runs and knowledge are listed.
    let outputs: Vec<&String> = plan.outputs.iter().chain(&plan.sensors).collect();
    let questions = [Knowledge::of_sensors(plan), Knowledge::of_outputs(plan)];
    let place = |answer: &Answer| {
        let output = outputs.iter().position(|output| **output == answer.output);
        let question = &questions[usize::from(!plan.outputs.contains(&answer.output))];
        let knowledge = question.iter().position(|own| own.name == answer.knowledge.name);
        (answer.path.clone(), output, answer.training_runs, knowledge)
    };
    answers.sort_by_cached_key(place);
    Ok(Worth { plan: plan.clone(), unseen: names_of_unseen, answers, remarks })
}

/// Knowledge that is answered by the same surrogate, put together: sensors of another origin are given to the surrogate of the measured ones.
fn fits(knowledge: &[Knowledge]) -> Vec<Vec<Knowledge>> {
    let mut fits: Vec<Vec<Knowledge>> = Vec::new();
    for own in knowledge {
        match fits.iter_mut().find(|fit| fit[0].is_same_surrogate(own)) {
            Some(fit) => fit.push(own.clone()),
            None => fits.push(vec![own.clone()]),
        }
    }
    fits
}

/// The runs of each path.
fn by_path(dataset: &Dataset) -> BTreeMap<String, Dataset> {
    let mut found = BTreeMap::new();
    for run in dataset.runs() {
        let path = path_of(run);
        if !found.contains_key(&path) {
            found.insert(path.clone(), dataset.select(|other, _| path_of(other) == path));
        }
    }
    found
}

/// The paths of the stages of a run, one after another; empty if they are not known.
fn path_of(run: &RunStates) -> String {
    let is_path = |key: &str| {
        key.strip_prefix("stage.").and_then(|rest| rest.split_once('.')).is_some_and(|(_, key)| key == "path")
    };
    let mut stages: Vec<String> = run
        .parameters()
        .iter()
        .filter(|own| is_path(&own.key))
        .filter_map(|own| run.word(&own.key))
        .collect();
    stages.dedup();
    stages.join(", ")
}

/// A surrogate that is to be fitted, with all that it is asked.
struct Task {
    path: String,
    outputs: Vec<String>,
    count: usize,
    knowledge: Vec<Knowledge>,
    training: Dataset,
    unseen: Dataset,
}

impl Task {
    fn answers(&self, plan: &WorthPlan, methods: &SurrogateMethods) -> Result<Vec<Answer>> {
        let first: Vec<&str> = self.training.runs().iter().take(self.count).map(RunStates::name).collect();
        let training = self.training.select(|run, _| first.contains(&run.name()));
        let inputs = varying(&training, &self.knowledge[0].inputs(plan), &plan.coordinate)?;
        let spec = FitSpec::new(inputs, self.outputs.clone()).with_coordinate(&plan.coordinate);
        let spec = spec.with_seed(plan.seed).with_threads(1);
        let (method, surrogate) = if self.knowledge[0].source == Source::Predicted {
            let method = methods.by_name(CASCADE)?;
            (CASCADE.to_owned(), method.fit(&training, &spec, &mut NoObserver)?)
        } else {
            fitted(&training, &spec, plan, methods)?
        };
        let mut answers = Vec::new();
        for (knowledge, output) in
            self.knowledge.iter().flat_map(|own| self.outputs.iter().map(move |o| (own, o)))
        {
            let scored = scored(surrogate.as_ref(), &self.unseen, plan, knowledge, Some(output))?;
            answers.extend(scored.map(|(error, coverage)| Answer {
                path: self.path.clone(),
                output: output.clone(),
                knowledge: knowledge.clone(),
                training_runs: self.count,
                method: method.clone(),
                error,
                coverage,
            }));
        }
        Ok(answers)
    }
}

/// The inputs that are not the same in all states: from others nothing can be learned. A histogram is an input as a whole.
fn varying(training: &Dataset, inputs: &[String], coordinate: &str) -> Result<Vec<String>> {
    let mut found = Vec::new();
    for name in inputs {
        let is_group = training.runs().first().is_some_and(|run| run.group(name).is_some());
        let varies = name == coordinate || is_group || {
            let values = training.column(name)?;
            values.iter().any(|value| *value != values[0])
        };
        if varies {
            found.push(name.clone());
        }
    }
    Ok(found)
}

/// A surrogate by the method with the least error on left-out training runs.
fn fitted(
    training: &Dataset,
    spec: &FitSpec,
    plan: &WorthPlan,
    methods: &SurrogateMethods,
) -> Result<(String, Box<dyn Surrogate>)> {
    let mut refusal = None;
    let mut possible: Vec<&dyn SurrogateMethod> = Vec::new();
    for name in &plan.methods {
        let method = methods.by_name(name)?;
        match method.check(training, spec) {
            Ok(()) => possible.push(method),
            Err(error) => refusal = Some(error),
        }
    }
    let data = |dataset: &Dataset, method: &dyn SurrogateMethod| match method.has_memory() {
        true => dataset.clone(),
        false => thinned(dataset, plan.most_states),
    };
    let mut best: Option<(f64, &dyn SurrogateMethod)> = None;
    if possible.len() > 1 {
        let [rest, step] = LEFT_OUT;
        let number =
            |run: &RunStates| training.runs().iter().position(|own| own.name() == run.name()).unwrap_or(0);
        let others = training.select(|run, _| number(run) % step != rest);
        let left_out = thinned(&training.select(|run, _| number(run) % step == rest), plan.most_states);
        for method in &possible {
            let Ok(surrogate) = method.fit(&data(&others, *method), spec, &mut NoObserver) else { continue };
            let own = Knowledge {
                name: String::new(),
                measured: Vec::new(),
                properties: false,
                source: Source::Measured,
            };
            let Some((error, _)) = scored(surrogate.as_ref(), &left_out, plan, &own, None)? else { continue };
            if best.is_none_or(|(least, _)| error.relative < least) {
                best = Some((error.relative, *method));
            }
        }
    }
    match (best.map(|(_, method)| method).or(possible.first().copied()), refusal) {
        (Some(method), _) => {
            let surrogate = method.fit(&data(training, method), spec, &mut NoObserver)?;
            Ok((method.name().to_owned(), surrogate))
        }
        (None, Some(error)) => Err(error),
        (None, None) => Err(LearnError::Dataset("no method is named".into())),
    }
}

/// The error on runs of one output or of all, and the share of their values within the intervals; `None` if sensors of another run are asked for
/// and there is none, or the coordinate turns.
fn scored(
    surrogate: &dyn Surrogate,
    runs: &Dataset,
    plan: &WorthPlan,
    knowledge: &Knowledge,
    output: Option<&str>,
) -> Result<Option<(PooledError, Option<f64>)>> {
    let columns = surrogate.columns();
    let names = columns.input_names();
    surrogate.check(runs)?;
    let sensors = runs.expand(&knowledge.measured)?;
    let is_sensor: Vec<bool> = names.iter().map(|name| sensors.contains(name)).collect();
    let count = runs.runs().len();
    let variants: Vec<usize> = match knowledge.source {
        Source::Measured | Source::Predicted => vec![0],
        Source::Permuted => vec![1],
        Source::OtherRun => (1..count.min(MOST_OTHERS + 1)).collect(),
    };
    let read =
        |run: &RunStates| -> Result<Vec<Vec<f64>>> { names.iter().map(|name| run.column(name)).collect() };
    let inputs: Vec<Vec<Vec<f64>>> = runs.runs().iter().map(read).collect::<Result<_>>()?;
    let place = names.iter().position(|name| *name == plan.coordinate).unwrap_or(0);
    let turns = inputs.iter().any(|run| !never_falls(&run[place]));
    if variants.is_empty() || (knowledge.source == Source::OtherRun && turns) {
        return Ok(None);
    }
    let outputs = columns.outputs.len();
    let asked = output.map(|output| runs.expand(&[output])).transpose()?;
    let is_asked = |name: &String| asked.as_ref().is_none_or(|asked| asked.contains(name));
    let is_asked: Vec<bool> = columns.output_names().iter().map(is_asked).collect();
    let exact = runs.values(&columns.output_names())?;
    let lengths: Vec<usize> = runs.runs().iter().map(RunStates::rows).collect();
    let mut squares = vec![[0.0; 2]; count];
    let (mut held, mut intervals) = (0usize, 0usize);
    for variant in &variants {
        let mut rows = Vec::new();
        for (k, own) in inputs.iter().enumerate() {
            let other = &inputs[(k + variant) % count];
            let order = match knowledge.source {
                Source::Permuted => permutation(&vec![0; lengths[k]], plan.seed.wrapping_add(k as u64)),
                _ => (0..lengths[k]).collect(),
            };
            for row in 0..lengths[k] {
                for (input, column) in own.iter().enumerate() {
                    rows.push(match (is_sensor[input], knowledge.source) {
                        (true, Source::OtherRun) => {
                            interpolated(own[place][row], &other[place], &other[input])
                        }
                        (true, Source::Permuted) => column[order[row]],
                        _ => column[row],
                    });
                }
            }
        }
        let predictions =
            surrogate.predict(&RunInputs::new(rows, names.len(), lengths.clone())?, plan.level)?;
        let mut states = predictions.iter().zip(exact.chunks_exact(outputs));
        for (sums, length) in squares.iter_mut().zip(&lengths) {
            for (prediction, exact) in states.by_ref().take(*length) {
                let asked = prediction.values.iter().zip(exact).zip(&is_asked).filter(|(_, asked)| **asked);
                for ((estimate, exact), _) in asked {
                    sums[0] += (estimate.mean - exact) * (estimate.mean - exact);
                    sums[1] += exact * exact;
                    if let Some(interval) = &estimate.interval {
                        intervals += 1;
                        held += usize::from(interval.lower <= *exact && *exact <= interval.upper);
                    }
                }
            }
        }
    }
    let coverage = (intervals > 0).then(|| held as f64 / intervals as f64);
    Ok(Some((PooledError::new(&squares), coverage)))
}
