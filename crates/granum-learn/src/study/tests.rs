//! Tests of studies on columns with known laws.

use std::sync::Mutex;

use granum_core::{Column, Table};

use super::*;
use crate::dataset::{Dataset, RunStates, Split};
use crate::error::{LearnError, Result};
use crate::input_use::Verdict;
use crate::methods::networks::{NetworkCheckpoints, SubModel, networks_of};
use crate::surrogate::{FitSpec, Surrogate, SurrogateMethods};

/// A run in which `y` follows `x` and, with the given slope, a sensor that differs from run to run.
fn run(k: u32, slope: f64) -> RunStates {
    let x: Vec<f64> = (0..30).map(|i| f64::from(i) / 29.0).collect();
    let s: Vec<f64> = x.iter().map(|x| ((7.0 + f64::from(k)) * x + 2.0 * f64::from(k)).sin()).collect();
    let noise = |i: usize| 0.01 * ((i * 7919 + k as usize * 104_729) % 101) as f64 / 101.0;
    let y = x.iter().zip(&s).enumerate().map(|(i, (x, s))| 1.0 + x * x + slope * s + noise(i)).collect();
    let columns = vec![Column::new("x", "", x), Column::new("s", "m", s), Column::new("y", "Pa", y)];
    let run = RunStates::new(&format!("run-{k}"), Table::new(columns).unwrap()).unwrap();
    run.with_parameter("friction", "", 0.3).unwrap()
}

fn dataset(slope: f64) -> Dataset {
    Dataset::new((1..=6).map(|k| run(k, slope)).collect()).unwrap()
}

fn definition(inputs: &[&str]) -> StudyDefinition {
    let fit = FitSpec::new(inputs.iter().copied(), ["y"]).with_coordinate("x");
    StudyDefinition::new([fit], ["ridge"], Split::default().unseen(["run-4", "run-5", "run-6"]))
}

fn train(dataset: &Dataset, definition: &StudyDefinition) -> Result<Study> {
    Study::train(dataset, definition, &SurrogateMethods::standard(), &NoStudyObserver)
}

#[test]
fn a_sensor_that_matters_is_used_and_one_that_does_not_is_not() {
    for (slope, wanted) in [(0.3, Verdict::Gains), (0.0, Verdict::DoesNotUse)] {
        let dataset = dataset(slope);
        let study = train(&dataset, &definition(&["x", "s"])).unwrap();
        let names: Vec<&str> = study.members().map(|member| member.name.as_str()).collect();
        assert_eq!(names, ["y-ridge", "y-ridge-coordinate-only", "y-mean-curve"]);
        let scores = study.evaluate(&dataset).unwrap();
        let error = |name: &str| scores.member(name).unwrap().unseen.score.relative_rmse;
        let used = &scores.fits[0].uses["y-ridge"];
        assert_eq!(used.verdict(), wanted, "{used:?}");
        assert_eq!((used.runs.len(), scores.fits[0].uses.len()), (3, 1));
        if slope > 0.0 {
            assert!(error("y-ridge") < 0.2 * error("y-ridge-coordinate-only"), "{scores:?}");
            assert!(used.with_other.unwrap().relative_rmse > 2.0 * error("y-ridge"));
        }
        let ridge = scores.member("y-ridge").unwrap();
        assert_eq!((ridge.outputs.len(), ridge.outputs[0].unit.as_str()), (1, "Pa"));
        assert_eq!(ridge.outputs[0].unseen, ridge.unseen.score);
        assert_eq!((ridge.training.score.states, ridge.held_out.score.states), (45, 45));
    }
}

#[test]
fn a_study_comes_back_from_its_folder_and_altered_files_are_refused() {
    let dataset = dataset(0.3);
    let study = train(&dataset, &definition(&["x", "s"])).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let scores = save(folder.path(), &study, &dataset).unwrap();
    assert!(is_study(folder.path()));
    let methods = SurrogateMethods::standard();
    let stored = load(folder.path(), &methods).unwrap();
    assert_eq!(stored.scores, scores);
    assert_eq!(stored.study.evaluate(&dataset).unwrap(), scores);
    assert_eq!((&stored.study.definition, stored.unseen.len()), (&study.definition, 3));
    let table = stored.predictions.unwrap();
    assert_eq!(table.rows(), 90);
    // The score follows from the stored predictions.
    let (exact, given) = (table.column("y").unwrap(), table.column("predicted_y_by_y-ridge").unwrap());
    let squares = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>();
    let errors = squares(&mut exact.iter().zip(given).map(|(a, b)| a - b));
    let relative = (errors / squares(&mut exact.iter().copied())).sqrt();
    assert!((relative - scores.member("y-ridge").unwrap().unseen.score.relative_rmse).abs() < 1e-12);
    assert!(table.has("lower_y_by_y-ridge") && table.has("predicted_y_by_y-mean-curve"));
    // The same study has the same bytes.
    let again = tempfile::tempdir().unwrap();
    save(again.path(), &study, &dataset).unwrap();
    for entry in std::fs::read_dir(folder.path()).unwrap() {
        let name = entry.unwrap().file_name();
        let bytes = |folder: &tempfile::TempDir| std::fs::read(folder.path().join(&name)).unwrap();
        assert_eq!(bytes(&folder), bytes(&again), "{name:?}");
    }
    let refused = |file: &str, from: &str, to: &str| {
        let path = folder.path().join(file);
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains(from), "{file}");
        std::fs::write(&path, text.replacen(from, to, 1)).unwrap();
        let message = load(folder.path(), &methods).err().unwrap().to_string();
        std::fs::write(&path, text).unwrap();
        message
    };
    assert!(refused("y-ridge.json", "ridge", "rigde").contains("y-ridge.json: its SHA-256 is not the one"));
    assert!(refused("predictions.csv", "1", "2").contains("predictions.csv: its SHA-256"));
    assert!(refused("study.json", "0.9", "0.8").contains("study.json: the SHA-256 does not match"));
    assert!(refused("study.json", "\"version\": 2", "\"version\": 3").contains("it has version 3"));
}

#[test]
fn what_cannot_be_studied_is_refused_before_anything_is_fitted() {
    let dataset = dataset(0.3);
    let message = |definition: &StudyDefinition| train(&dataset, definition).err().unwrap().to_string();
    assert!(message(&definition(&["x", "t"])).contains("there is no column t"));
    assert!(message(&definition(&["x", "y"])).contains("y is both an input and an output"));
    assert!(message(&definition(&["s"])).contains("the coordinate x must be one of the inputs"));
    let text = message(&definition(&["x", "friction"]));
    assert!(
        text.contains("friction is 0.3 in all training states") && text.contains("leave it out"),
        "{text}"
    );
    let unknown = StudyDefinition { methods: vec!["rigde".into()], ..definition(&["x"]) };
    assert!(message(&unknown).contains("there is no surrogate method `rigde`"));
    let twice = StudyDefinition { methods: vec!["ridge".into(), "ridge".into()], ..definition(&["x"]) };
    assert!(message(&twice).contains("named twice"));
}

/// Without an unseen run the held-out states of the training run are scored.
#[test]
fn a_single_run_is_scored_on_its_held_out_states() {
    let one = Dataset::new(vec![run(1, 0.3)]).unwrap();
    let definition = StudyDefinition { split: Split::default(), ..definition(&["x", "s"]) };
    let scores = train(&one, &definition).unwrap().evaluate(&one).unwrap();
    let ridge = scores.member("y-ridge").unwrap();
    assert_eq!((ridge.held_out.score.states, ridge.unseen.score.states), (15, 0));
    assert!(ridge.held_out.score.relative_rmse < 0.05 && scores.fits[0].uses.is_empty(), "{scores:?}");
}

/// Networks by sub-model, with fewer training states than there are, and the files from which such a fit goes on.
#[test]
fn networks_by_sub_model_are_scored_in_their_ranges_and_kept_while_they_are_trained() {
    let dataset = dataset(0.3);
    let sub_models = SubModel::divided([0.0, 0.9], &[0.4], &[3]);
    let fit = FitSpec::new(["x", "s"], ["y"]).with_coordinate("x").with_sub_models(sub_models);
    let split = Split::default().unseen(["run-4", "run-5", "run-6"]);
    let mut definition = StudyDefinition::new([fit], ["sub-models"], split);
    definition.most_states = Some(30);
    let methods = SurrogateMethods::standard();
    let folder = tempfile::tempdir().unwrap();
    let plan = StudyPlan::new(&[], &[], dataset.digest(), definition.clone()).unwrap();
    let kept = |plan: &StudyPlan| {
        KeptStudy::begin(folder.path(), plan, &methods, std::time::Duration::ZERO).unwrap()
    };
    // Stopped within the first network, whose state is kept.
    let stopped = AtNetwork { kept: kept(&plan), epochs: Mutex::new(0), most: 3 };
    assert!(Study::train(&dataset, &definition, &methods, &stopped).is_err());
    let files = |ending: &str| {
        let names = std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name());
        names.filter(|name| name.to_string_lossy().ends_with(ending)).count()
    };
    assert!(files(".unfinished") > 0);
    let going_on = AtNetwork { kept: kept(&plan), epochs: Mutex::new(0), most: u64::MAX };
    let resumed = Study::train(&dataset, &definition, &methods, &going_on).unwrap();
    assert_eq!((files(".unfinished"), files("-1.json")), (0, 0));
    // A process may be killed between the storing of a surrogate and the removal of its networks.
    std::fs::write(folder.path().join("y-sub-models-2.json"), "left").unwrap();
    assert!(kept(&plan).finished("y-sub-models").unwrap().is_some());
    assert_eq!(files("-2.json"), 0);
    let whole = Study::train(&dataset, &definition, &methods, &NoStudyObserver).unwrap();
    let networks = |study: &Study| -> Vec<String> {
        let member = study.member("y-sub-models").unwrap();
        networks_of(member.surrogate.as_ref())
            .unwrap()
            .networks()
            .iter()
            .map(|model| model.to_json())
            .collect()
    };
    assert_eq!(networks(&resumed), networks(&whole));
    assert!(resumed.seconds_of(resumed.member("y-sub-models").unwrap()) > 0.0);
    let scores = whole.evaluate(&dataset).unwrap();
    let member = scores.member("y-sub-models").unwrap();
    // States beyond 0.9 are not scored, for any method, but count as outside.
    assert_eq!(member.unseen.score.states, 3 * 27);
    assert_eq!(scores.member("y-ridge").unwrap().unseen.score.states, 3 * 27);
    assert!(member.unseen.outside >= 3 * 3);
    let each: Vec<usize> = member.networks.iter().map(|network| network.unseen.states).collect();
    assert_eq!(each, [3 * 12, 3 * 15]);
    assert_eq!((member.networks[0].rows, member.networks[1].range), (23, [0.4, 0.9]));
    assert!(member.unseen.score.relative_rmse < 0.1, "{member:?}");
    // Another plan begins from nothing.
    definition.most_states = None;
    let other = StudyPlan::new(&[], &[], dataset.digest(), definition).unwrap();
    assert_eq!(plan.differences(&other), ["the number of training states"]);
    assert!(kept(&plan).finished("y-ridge").unwrap().is_some());
    assert!(kept(&other).finished("y-ridge").unwrap().is_none());
}

/// A process may be killed while it removes the study of another plan: the next one still knows the names of its files.
#[test]
fn what_is_left_of_a_study_that_was_being_removed_is_removed_the_next_time() {
    let folder = tempfile::tempdir().unwrap();
    let plan = |output: &str| {
        let fit = FitSpec::new(["x"], [output]);
        StudyPlan::new(&[], &[], "digest".into(), StudyDefinition::new([fit], ["ridge"], Split::default()))
            .unwrap()
    };
    let begin = |plan: &StudyPlan| {
        KeptStudy::begin(folder.path(), plan, &SurrogateMethods::standard(), std::time::Duration::ZERO)
    };
    let (old, new) = (plan("y"), plan("s"));
    begin(&old).unwrap();
    let [scored, surrogate] = [SCORED_FILE, "y-ridge.json"].map(|name| folder.path().join(name));
    std::fs::write(&surrogate, "{}").unwrap();
    // Its removal is cut short by something that cannot be removed as a file.
    std::fs::create_dir(&scored).unwrap();
    assert!(begin(&new).is_err());
    assert!(surrogate.exists());
    std::fs::remove_dir(&scored).unwrap();
    begin(&new).unwrap();
    assert!(!surrogate.exists());
    assert_eq!(StudyPlan::read(folder.path()).unwrap(), new);
}

/// Keeps a study in its folder and stops after some epochs.
struct AtNetwork {
    kept: KeptStudy,
    epochs: Mutex<u64>,
    most: u64,
}

impl StudyObserver for AtNetwork {
    fn progress(&self, _: &str, _: &granum_core::observer::Progress) {
        *self.epochs.lock().unwrap() += 1;
    }
    fn finished(&self, name: &str) -> Result<Option<Box<dyn Surrogate>>> {
        self.kept.finished(name)
    }
    fn fitted(&self, name: &str, surrogate: &dyn Surrogate) -> Result<()> {
        self.kept.fitted(name, surrogate)
    }
    fn networks(&self) -> &dyn NetworkCheckpoints {
        &self.kept.networks
    }
    fn stop(&self) -> bool {
        *self.epochs.lock().unwrap() >= self.most
    }
}

/// A path that turns has no mean curve along it, and inputs cannot be exchanged between runs at the same coordinate.
#[test]
fn along_a_path_that_turns_the_mean_curve_is_missing_with_its_reason() {
    let turn = |k: u32| {
        let x: Vec<f64> = (0..40).map(|i| (f64::from(i) / 6.0).sin()).collect();
        let s: Vec<f64> = (0..40).map(|i| (f64::from(i * k) / 5.0).cos()).collect();
        let y = x.iter().zip(&s).map(|(x, s)| 2.0 + x + 0.5 * s).collect();
        let columns = vec![Column::new("x", "", x), Column::new("s", "", s), Column::new("y", "", y)];
        RunStates::new(&format!("run-{k}"), Table::new(columns).unwrap()).unwrap()
    };
    let dataset = Dataset::new((1..=6).map(turn).collect()).unwrap();
    let study = train(&dataset, &definition(&["x", "s"])).unwrap();
    let remark = &study.fits[0].remarks[0];
    assert!(remark.contains("y-mean-curve is missing") && remark.contains("falls from a state"), "{remark}");
    let used = &study.evaluate(&dataset).unwrap().fits[0].uses["y-ridge"];
    assert!(used.with_other.is_none() && used.permuted.is_some());
    assert_eq!(used.verdict(), Verdict::Gains);
}

/// Stops after the first surrogate and keeps it.
#[derive(Default)]
struct UnfinishedFits(Mutex<Vec<(String, String)>>);

impl StudyObserver for UnfinishedFits {
    fn finished(&self, name: &str) -> Result<Option<Box<dyn Surrogate>>> {
        let kept = self.0.lock().unwrap();
        let found = kept.iter().find(|(known, _)| known == name);
        found.map(|(_, text)| SurrogateMethods::standard().from_json(text, name)).transpose()
    }
    fn fitted(&self, name: &str, surrogate: &dyn Surrogate) -> Result<()> {
        self.0.lock().unwrap().push((name.into(), crate::surrogate::to_json(surrogate)?));
        Ok(())
    }
    fn stop(&self) -> bool {
        self.0.lock().unwrap().len() == 1
    }
}

#[test]
fn a_stopped_training_goes_on_to_the_same_surrogates() {
    let dataset = dataset(0.3);
    // With one thread, so that no other fit ends while the first one is kept.
    let definition = StudyDefinition { threads: 1, ..definition(&["x", "s"]) };
    let unfinished = UnfinishedFits::default();
    let stopped = Study::train(&dataset, &definition, &SurrogateMethods::standard(), &unfinished);
    assert!(matches!(stopped.err().unwrap(), LearnError::Stopped { done: 1, total: 3 }));
    unfinished.0.lock().unwrap().push(("none".into(), String::new()));
    let resumed = Study::train(&dataset, &definition, &SurrogateMethods::standard(), &unfinished).unwrap();
    let whole = train(&dataset, &definition).unwrap();
    assert_eq!(resumed.evaluate(&dataset).unwrap(), whole.evaluate(&dataset).unwrap());
}

/// The file of one surrogate may have been put in the place of another one.
#[test]
fn a_finished_surrogate_of_another_fit_is_refused() {
    let dataset = dataset(0.3);
    let definition = StudyDefinition { threads: 1, ..definition(&["x", "s"]) };
    let methods = SurrogateMethods::standard();
    let unfinished = UnfinishedFits::default();
    assert!(Study::train(&dataset, &definition, &methods, &unfinished).is_err());
    let first = unfinished.0.lock().unwrap()[0].clone();
    assert_eq!(first.0, "y-ridge");
    unfinished.0.lock().unwrap().push(("y-ridge-coordinate-only".into(), first.1));
    let refused = Study::train(&dataset, &definition, &methods, &unfinished).err().unwrap().to_string();
    assert!(
        refused.starts_with("y-ridge-coordinate-only.json: it is not the surrogate of this fit"),
        "{refused}"
    );
}

/// A law that is a word: the stress follows the strain with another factor for each law.
fn with_law(k: u32, law: &str, factor: f64) -> RunStates {
    let x: Vec<f64> = (0..30).map(|i| f64::from(i) / 29.0).collect();
    let y = x.iter().map(|x| factor * x + 0.002 * (17.0 * x + f64::from(k)).sin()).collect();
    let table = Table::new(vec![Column::new("x", "", x), Column::new("y", "", y)]).unwrap();
    RunStates::new(&format!("run-{k}"), table).unwrap().with_word("contact.normal", law).unwrap()
}

#[test]
fn a_word_is_an_input_that_is_learned_from() {
    let laws = ["hertz", "jkr", "hertz", "jkr", "hertz", "jkr"];
    let run = |k: usize| with_law(k as u32 + 1, laws[k], if laws[k] == "hertz" { 1.0 } else { 2.0 });
    let dataset = Dataset::new((0..6).map(run).collect()).unwrap();
    let fit = FitSpec::new(["x", "contact.normal"], ["y"]).with_coordinate("x");
    let split = Split::default().unseen(["run-5", "run-6"]);
    let definition = StudyDefinition::new([fit.clone()], ["ridge"], split.clone());
    let methods = SurrogateMethods::standard();
    let study = Study::train(&dataset, &definition, &methods, &NoStudyObserver).unwrap();
    let scores = study.evaluate(&dataset).unwrap();
    let [with, without] =
        ["y-ridge", "y-ridge-coordinate-only"].map(|name| scores.member(name).unwrap().unseen.score);
    assert!(with.relative_rmse < 0.7 * without.relative_rmse, "{with:?} {without:?}");
    let base = tempfile::tempdir().unwrap();
    save(base.path(), &study, &dataset).unwrap();
    let loaded = load(base.path(), &methods).unwrap().study;
    let surrogate = loaded.member("y-ridge").unwrap().surrogate.as_ref();
    let categories = surrogate.columns().categories();
    assert_eq!(categories, [crate::dataset::Category::new("contact.normal", ["hertz", "jkr"])]);

    // A table has the law as a word.
    let asked = |laws: [&str; 2]| {
        Table::new(vec![Column::new("x", "", vec![0.9; 2]), Column::of_words("contact.normal", laws)])
            .unwrap()
    };
    let predictions = crate::inference::predict_table(surrogate, &asked(["hertz", "jkr"]), 0.9).unwrap();
    let y = predictions.column("predicted_y").unwrap();
    assert!(y[1] > y[0] + 0.3, "{y:?}");
    assert_eq!(predictions.names().take(2).collect::<Vec<_>>(), ["contact.normal", "x"]);
    let error =
        crate::inference::predict_table(surrogate, &asked(["hertz", "hooke"]), 0.9).unwrap_err().to_string();
    assert!(
        error.contains("row 2: contact.normal is \"hooke\"; the surrogate was fitted to hertz, jkr"),
        "{error}"
    );

    // A law that the training runs do not have, and one that all of them have, are refused before anything is fitted.
    let refused = |laws: [&str; 6]| {
        let run = |k: usize| with_law(k as u32 + 1, laws[k], 1.0);
        let dataset = Dataset::new((0..6).map(run).collect()).unwrap();
        let definition = StudyDefinition::new([fit.clone()], ["ridge"], split.clone());
        Study::train(&dataset, &definition, &methods, &NoStudyObserver).err().unwrap().to_string()
    };
    let text = refused(["hertz", "jkr", "hertz", "jkr", "hertz", "hooke"]);
    assert_eq!(
        text,
        "record `run-6`: contact.normal is hooke, of which nothing can be known from runs with hertz, jkr"
    );
    let text = refused(["jkr", "jkr", "jkr", "jkr", "jkr", "jkr"]);
    assert!(text.contains("the input contact.normal is jkr in all training runs"), "{text}");
}
