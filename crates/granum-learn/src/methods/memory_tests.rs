//! Tests of methods with memory, on synthetic runs whose stress depends on the history of the strain.

use granum_core::observer::{Event, Flow, NoObserver, Observer, Progress};
use granum_core::{Column, Table};
use granum_nets::trainer::Adam;

use super::*;
use crate::dataset::{Dataset, RunStates, Split};
use crate::error::{LearnError, Result};
use crate::inference::predict_table;
use crate::surrogate::*;
use crate::{compare, score_surrogate};

/// Cyclic tests of a material that yields: `ds = k (de - |de| s / s_0)` (Duhem), from a stress that depends on the sample.
/// The strain turns at different places in every run, so that one strain has many stresses, and runs differ in length.
fn cyclic(count: usize) -> Dataset {
    let run = |k: usize| {
        let (phase, frequency) = (1.7 * k as f64, 0.25 + 0.05 * (k % 4) as f64);
        let sample = 0.3 * (2.3 * k as f64).sin();
        let strain_at = |state: usize| {
            let angle = frequency * state as f64;
            ((angle + phase).sin() - phase.sin())
                + 0.5 * ((2.3 * angle + 0.4 * phase).sin() - (0.4 * phase).sin())
        };
        let strain: Vec<f64> = (0..30 + k % 9).map(strain_at).collect();
        let mut stress = vec![sample];
        for pair in strain.windows(2) {
            let (step, last) = (pair[1] - pair[0], stress[stress.len() - 1]);
            stress.push(last + 1.5 * (step - step.abs() * last));
        }
        let columns = vec![Column::new("strain", "", strain), Column::new("stress", "", stress)];
        RunStates::new(&format!("run-{k}"), Table::new(columns)?)?.with_parameter("sample", "", sample)
    };
    Dataset::new((0..count).map(run).collect::<Result<_>>().unwrap()).unwrap()
}

fn spec() -> FitSpec {
    FitSpec::new(["strain", "sample"], ["stress"])
}

fn small() -> Recurrent {
    let trainer = Adam { epochs: 250, learning_rate: 0.01, maximum_failures: 250, ..Adam::default() };
    Recurrent { hidden: 10, networks: 2, trainer: trainer.into() }
}

/// The recurrent method must beat those without memory where the same inputs give different outputs, and its intervals must
/// hold on unseen runs.
#[test]
fn memory_is_worth_something_where_there_is_a_history() {
    let dataset = cyclic(30);
    let unseen: Vec<String> = (24..30).map(|k| format!("run-{k}")).collect();
    // Every second state is held out from methods without memory; the other sees whole runs.
    let parts = dataset.split(&Split::default().unseen(unseen)).unwrap();
    assert_eq!(parts.training_runs.rows(), parts.training.rows() + parts.held_out.rows());
    let network = FeedForward { hidden: vec![8], ..FeedForward::default() };
    let methods: [&dyn SurrogateMethod; 3] = [&RidgeRegression::default(), &network, &small()];
    let scores = compare(&parts, &spec(), &methods, 0.9, &mut NoObserver).unwrap();
    let [ridge, network, recurrent] = &scores[..] else { panic!() };
    for other in [ridge, network] {
        let (ours, theirs) = (recurrent.unseen.relative_rmse, other.unseen.relative_rmse);
        assert!(ours < 0.4 * theirs, "recurrent {ours}, {} {theirs}", other.method);
    }
    let coverage = recurrent.coverage.unwrap();
    assert!((0.75..=1.0).contains(&coverage), "{coverage}");
    assert_eq!((recurrent.held_out.states, recurrent.training.states), (0, parts.training_runs.rows()));

    // It is saved and read like all others, and a table with the column `run` is answered like the data set.
    let text = to_json(recurrent.surrogate.as_ref()).unwrap();
    let loaded = SurrogateMethods::standard().from_json(&text, "recurrent.json").unwrap();
    assert_eq!(score_surrogate(loaded.as_ref(), &parts.unseen).unwrap(), recurrent.unseen);
    let inputs = RunInputs::from_dataset(&parts.unseen, loaded.columns()).unwrap();
    let predictions = loaded.predict(&inputs, 0.9).unwrap();
    let table = predict_table(loaded.as_ref(), &parts.unseen.table().unwrap(), 0.9).unwrap();
    let means: Vec<f64> = predictions.iter().map(|predicted| predicted.values[0].mean).collect();
    assert_eq!(table.column("predicted_stress").unwrap(), means);
    crate::surrogate::stream_tests::answers_as_whole_runs(loaded.as_ref(), &inputs);
    // The boundaries of runs matter: as one run, the same rows give other predictions.
    let joined = RunInputs::new(inputs.values().to_vec(), 2, vec![inputs.len()]).unwrap();
    assert_ne!(loaded.predict(&joined, 0.9).unwrap(), predictions);
    // For a method without memory they do not.
    let ridge = ridge.surrogate.as_ref();
    crate::surrogate::stream_tests::answers_as_whole_runs(ridge, &inputs);
    crate::surrogate::stream_tests::answers_as_whole_runs(network.surrogate.as_ref(), &inputs);
    assert_eq!(ridge.predict(&joined, 0.9).unwrap(), ridge.predict(&inputs, 0.9).unwrap());
    assert!(loaded.predict(&RunInputs::separate(Vec::new(), 2).unwrap(), 0.9).unwrap().is_empty());

    let damaged = |from: &str, to: &str| {
        let text = super::tests::sealed(&text.replacen(from, to, 1));
        SurrogateMethods::standard().from_json(&text, "r.json").err().unwrap().to_string()
    };
    assert!(damaged("\"hidden\": 10", "\"hidden\": 11").contains("weights, not"));
    assert!(damaged("\"ranges\": [", "\"ranges\": [[0.0, 1.0], ").contains("not those of its columns"));
    assert!(damaged("\"degrees_of_freedom\": ", "\"degrees_of_freedom\": -").contains("not those of"));
}

#[test]
fn threads_change_no_bit_of_a_recurrent_fit() {
    let dataset = cyclic(5);
    let trainer = Adam { epochs: 6, ..Adam::default() }.into();
    let method = Recurrent { hidden: 5, networks: 3, trainer };
    let text = |threads: usize| {
        let fitted = method.fit(&dataset, &spec().with_threads(threads), &mut NoObserver).unwrap();
        to_json(fitted.as_ref()).unwrap()
    };
    assert_eq!(text(1), text(3));
    // A single run has no other by which its errors could be judged.
    let single = dataset.select(|run, _| run.name() == "run-2");
    let fitted = method.fit(&single, &spec(), &mut NoObserver).unwrap();
    assert!(fitted.predict_rows(&[0.1, 0.2], 0.9).unwrap()[0].values[0].interval.is_none());
    let none = Recurrent { networks: 0, ..method };
    let text = none.fit(&dataset, &spec(), &mut NoObserver).err().unwrap().to_string();
    assert_eq!(text, "recurrent: the number of networks must be 1 or more, not 0");
}

/// Every method hears its observer at least once, says nothing else when it is heard, and ends when the observer asks for it.
#[test]
fn every_method_can_be_followed_and_stopped() {
    let run = |k: usize| {
        let strain: Vec<f64> = (0..24).map(|state| 0.01 * state as f64).collect();
        let stress = strain.iter().map(|strain| (1.0 + 0.2 * k as f64) * strain / (0.05 + strain)).collect();
        // A soft sensor, which the cascade needs.
        let fabric = strain.iter().map(|strain| 0.1 * k as f64 * strain).collect();
        let fabric = Column::new("deviator_fabric", "", fabric);
        let columns = vec![Column::new("strain", "", strain), fabric, Column::new("stress", "", stress)];
        RunStates::new(&format!("run-{k}"), Table::new(columns)?)?.with_parameter("friction", "", k as f64)
    };
    let dataset = Dataset::new((0..6).map(run).collect::<Result<_>>().unwrap()).unwrap();
    let trainer = Adam { epochs: 3, ..Adam::default() }.into();
    let small = FeedForward { hidden: vec![2], ..FeedForward::default() };
    let methods = SurrogateMethods::standard().replaced_by(small);
    let methods = methods.replaced_by(Recurrent { hidden: 2, networks: 2, trainer });
    for method in methods.all() {
        let spec = FitSpec::new(["strain", "friction"], ["stress"]).with_coordinate("strain");
        let spec = spec.with_threads(1);
        let fit = |observer: &mut dyn Observer| method.fit(&dataset, &spec, observer);
        let mut listener = Stopper::default();
        let listened = match fit(&mut listener) {
            Ok(listened) => listened,
            Err(error) => panic!("{}: {error}", method.name()),
        };
        let silent = fit(&mut NoObserver).unwrap();
        assert_eq!(to_json(listened.as_ref()).unwrap(), to_json(silent.as_ref()).unwrap());
        assert!(!listener.reports.is_empty(), "{} says nothing", method.name());
        for after in [1, listener.reports.len()] {
            let mut stopper = Stopper { after, ..Stopper::default() };
            let stopped = fit(&mut stopper).err();
            assert!(matches!(stopped, Some(LearnError::Stopped { .. })), "{} after {after}", method.name());
            assert_eq!(stopper.reports.len(), after, "{} goes on after it was stopped", method.name());
        }
    }
}

/// Stops a fit after a number of reports.
#[derive(Default)]
struct Stopper {
    after: usize,
    reports: Vec<Progress>,
    completed: Vec<Event>,
}

impl Observer for Stopper {
    fn progress(&mut self, progress: &Progress) -> Flow {
        self.reports.push(progress.clone());
        if self.reports.len() == self.after { Flow::Stop } else { Flow::Continue }
    }
    fn event(&mut self, event: &Event) {
        self.completed.push(event.clone());
    }
}

#[test]
fn fits_are_followed_and_stopped() {
    let dataset = cyclic(4);
    let trainer = Adam { epochs: 5, ..Adam::default() }.into();
    let recurrent = Recurrent { hidden: 3, networks: 2, trainer };
    let network = FeedForward { hidden: vec![3], ..FeedForward::default() };
    for (method, part) in [(&recurrent as &dyn SurrogateMethod, "network 1"), (&network, "stress")] {
        let mut stopper = Stopper { after: 2, ..Stopper::default() };
        let error = method.fit(&dataset, &spec().with_threads(1), &mut stopper).err().unwrap();
        assert!(matches!(error, LearnError::Stopped { done: 0, .. }), "{error}");
        assert_eq!((stopper.reports.len(), stopper.completed.len()), (2, 0));
        assert_eq!((stopper.reports[0].part.as_deref(), stopper.reports[0].done), (Some(part), 1));
        let mut listener = Stopper::default();
        let listened = method.fit(&dataset, &spec(), &mut listener).unwrap();
        let silent = method.fit(&dataset, &spec(), &mut NoObserver).unwrap();
        assert_eq!(to_json(listened.as_ref()).unwrap(), to_json(silent.as_ref()).unwrap());
        assert!(listener.completed.contains(&Event::PartCompleted { part: part.into() }));
    }
}
