//! Whole studies on synthetic records.

use granum_io::RunKind;

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use granum_nets::trainer::{
    Flow, LevenbergMarquardt, Observer, Options, Progress, Trainer, TrainerState, TrainingError,
    TrainingReport, by_name,
};
use granum_nets::{Column, Data, Differentiable, Model, ModelDefinition};
use granum_sensors::Record;

use crate::figures::figures;
use crate::files;
use crate::interpretation;
use crate::mapping::{Form, Mapping, paper_mapping};
use crate::mapping_networks::MappingNetworks;
use crate::sensor_use::{Verdict, is_constant};
use crate::size_study::{SizeStudy, SizeStudyOptions};
use crate::study::{Evaluation, Silent, Study, StudyObserver, StudyOptions, StudyProgress};
use crate::study_data::{Rows, State, StudyData, StudyDataOptions};
use crate::summary::MappingSummary;
use crate::synthetic::{Law, record};
use granum_learn::LearnError;
use granum_learn::dataset::NamedRecord;

fn dataset(law: Law, training: u64, unseen: u64, intervals: usize) -> StudyData {
    let records: Vec<Record> = (1..=training + unseen).map(|seed| record(law, seed, intervals)).collect();
    let named: Vec<NamedRecord> = records
        .iter()
        .enumerate()
        .map(|(k, record)| NamedRecord { name: "run", seed: k as u64 + 1, record })
        .collect();
    let (seen, rest) = named.split_at(training as usize);
    StudyData::new(seen, rest, &StudyDataOptions::default()).unwrap()
}

/// Small networks, so that the tests are quick.
fn small(names: &[&str], neurons: usize, trainer: &str, epoch_factor: f64) -> StudyOptions {
    let mappings: Vec<Mapping> =
        names.iter().map(|name| paper_mapping(name).unwrap().with_neurons(neurons)).collect();
    StudyOptions {
        mappings,
        trainer: by_name(trainer, &Options::default()).unwrap(),
        epoch_factor,
        ..Default::default()
    }
}

fn evaluate(dataset: &StudyData, options: &StudyOptions) -> Vec<Evaluation> {
    Study::train(dataset, options, &Silent).unwrap().evaluate(dataset).unwrap()
}

const DEFAULT: &str = "levenberg-marquardt";

#[test]
fn smooth_curves_are_learned_down_to_their_noise() {
    // Here the noise is independent between states, whereas in real runs it is correlated over several states. Since a state
    // counts as a fraction of an observation, the curves are slightly smoother than these records would permit.
    let dataset = dataset(Law::Plain, 1, 2, 120);
    for evaluation in evaluate(&dataset, &small(&["F1", "F2", "F3", "F4", "F5", "F6"], 6, DEFAULT, 1.0)) {
        let name = &evaluation.mapping.name;
        let scatter = evaluation.seed_scatter.unwrap();
        assert!(evaluation.network.held_out.relative_rmse < 4.0 * scatter, "{name}: {evaluation:?}");
        assert!(evaluation.network.unseen.relative_rmse < 4.0 * scatter, "{name}: {evaluation:?}");
        assert!(evaluation.network.unseen.r2 > 0.9, "{name}: {evaluation:?}");
        assert_eq!(evaluation.sub_models.len(), 3);
    }
}

/// If the soft sensors contain no information, no mapping may appear to be better than strain only, or appear to use them.
#[test]
fn inputs_without_information_do_not_help() {
    for law in [Law::Blind, Law::Plain] {
        let dataset = dataset(law, 1, 5, 120);
        for evaluation in evaluate(&dataset, &small(&["F1", "F3"], 4, DEFAULT, 1.0)) {
            let name = &evaluation.mapping.name;
            let (own, alone) =
                (evaluation.network.unseen.relative_rmse, evaluation.strain_only.unseen.relative_rmse);
            // If all quantities are functions of strain, the fabric may only help a small network with its shape.
            assert!(law == Law::Plain || own > 0.97 * alone, "{law:?} {name}: {own} {alone}");
            let verdict = evaluation.sensor_use.verdict();
            assert_eq!(verdict, Verdict::DoesNotUse, "{law:?} {name}: {:?}", evaluation.sensor_use);
            let text = interpretation::read_mapping(&evaluation);
            assert!(text.contains("they do not use their sensors"), "{text}");
        }
    }
}

/// If the sensors contain the information, the mapping must find it, which strain-only networks cannot.
#[test]
fn inputs_with_information_help() {
    let dataset = dataset(Law::Hidden, 1, 4, 120);
    let mut options = small(&["F1", "F3", "F5"], 4, DEFAULT, 1.0);
    options.form = Form::Histogram;
    for evaluation in evaluate(&dataset, &options) {
        let name = &evaluation.mapping.name;
        let (own, alone) =
            (evaluation.network.unseen.relative_rmse, evaluation.strain_only.unseen.relative_rmse);
        assert!(own < 0.6 * alone, "{name}: {own} {alone}");
        assert!(own < 0.6 * evaluation.best_without_sensors().unwrap(), "{name}");
        let sensors = &evaluation.sensor_use;
        assert_eq!(sensors.verdict(), Verdict::Gains, "{name}: {sensors:?}");
        assert!(sensors.with_other.unwrap().relative_rmse > 1.5 * own, "{name}: {sensors:?}");
        assert!(sensors.permuted.unwrap().relative_rmse > 1.5 * own, "{name}: {sensors:?}");
        assert!(evaluation.sub_models.iter().all(|sub_model| !sub_model.constant));
        // Ridge regression finds the linear dependence on the sensors, which strain alone does not contain.
        let (ridge, alone) =
            (evaluation.ridge.unseen.relative_rmse, evaluation.ridge_strain_only.unseen.relative_rmse);
        assert!(ridge < 0.7 * alone, "{name}: {ridge} {alone}");
        let text = interpretation::read_mapping(&evaluation);
        assert!(text.contains("they use their sensors, and are "), "{text}");
    }
}

#[test]
fn one_or_two_unseen_runs_are_too_few_to_test() {
    for (unseen, said) in [
        (0, "cannot be judged from no unseen run"),
        (1, "cannot be judged from one unseen run"),
        (2, "2 unseen runs are too few to test"),
    ] {
        let dataset = dataset(Law::Hidden, 1, unseen, 40);
        for evaluation in evaluate(&dataset, &small(&["F3"], 3, "traingdx", 1e-3)) {
            assert_eq!(evaluation.sensor_use.verdict(), Verdict::TooFewRuns);
            assert_eq!(evaluation.sensor_use.with_other.is_some(), unseen > 1);
            let text = interpretation::read_mapping(&evaluation);
            assert!(text.contains(said), "{text}");
        }
    }
}

/// A network with the same inputs that was trained on nearly constant targets.
fn silenced(surrogate: &MappingNetworks, states: &[&State]) -> Model {
    let (mapping, form, forces) = (surrogate.mapping(), surrogate.form(), surrogate.forces());
    let rows = Rows::new(mapping, form, forces, states.iter().copied());
    let targets = (0..rows.count()).map(|k| 0.7 + 1e-9 * (k % 3) as f64).collect();
    let data = Data::new(rows.inputs, rows.input_columns, targets).unwrap();
    let definition = ModelDefinition {
        inputs: mapping.network_inputs(form, forces).iter().map(|name| Column::new(name, "1")).collect(),
        output: Column::new(mapping.network_output(), "1"),
        quantities: Vec::new(),
        shares: Vec::new(),
        hidden: vec![3, 3],
        seed: 1,
    };
    let options = Options { epochs: Some(5), ..Options::default() };
    let trainer = by_name("traingdx", &options).unwrap();
    Model::fit(&definition, &data, trainer.as_ref(), &mut |_: &Progress| Flow::Continue).unwrap().0
}

/// A network with nearly constant predictions is reported as constant.
#[test]
fn a_forged_constant_is_called_one() {
    let dataset = dataset(Law::Plain, 1, 3, 40);
    let mut study = Study::train(&dataset, &small(&["F3"], 3, "traingdx", 1e-3), &Silent).unwrap();
    let surrogate = &study.mappings[0].surrogate;
    let training = dataset.training();
    assert!((0..3).all(|k| !is_constant(surrogate, &training, k).unwrap()));
    let forged = silenced(surrogate, &training);
    let networks = vec![surrogate.networks()[0].clone(), forged, surrogate.networks()[2].clone()];
    let forces = dataset.forces.clone();
    study.mappings[0].surrogate =
        MappingNetworks::new(surrogate.mapping().clone(), surrogate.form(), forces, networks).unwrap();
    let evaluation = &study.evaluate(&dataset).unwrap()[0];
    let found: Vec<bool> = evaluation.sub_models.iter().map(|sub_model| sub_model.constant).collect();
    assert_eq!(found, [false, true, false]);
    let text = interpretation::read_mapping(evaluation);
    assert!(
        text.ends_with("The network of sub-model 2 predicts a constant: it has learned nothing."),
        "{text}"
    );
}

#[test]
fn the_point_form_finds_the_information_too() {
    let dataset = dataset(Law::Hidden, 1, 1, 120);
    for evaluation in evaluate(&dataset, &small(&["F3"], 4, DEFAULT, 1.0)) {
        let (own, alone) =
            (evaluation.network.unseen.relative_rmse, evaluation.strain_only.unseen.relative_rmse);
        assert!(own < 0.6 * alone, "{own} {alone}");
    }
}

/// A user-defined trainer: Levenberg-Marquardt under another name, which does not accept the options of a study.
struct Own;

impl Trainer for Own {
    fn name(&self) -> &str {
        "own"
    }
    fn resume(
        &self,
        model: &mut dyn Differentiable,
        data: &Data,
        state: Option<TrainerState>,
        observer: &mut dyn Observer,
    ) -> Result<TrainingReport, TrainingError> {
        let mut report = LevenbergMarquardt::default().resume(model, data, state, observer)?;
        report.trainer = "own".into();
        Ok(report)
    }
}

#[test]
fn a_study_trains_with_any_trainer() {
    let dataset = dataset(Law::Plain, 1, 0, 40);
    let options = small(&["F1"], 3, DEFAULT, 1.0);
    let usual = Study::train(&dataset, &options, &Silent).unwrap();
    let own = Study::train(&dataset, &StudyOptions { trainer: Own.into(), ..options }, &Silent).unwrap();
    assert_eq!(own.trainer, "own");
    for (a, b) in own.mappings[0].surrogate.networks().iter().zip(usual.mappings[0].surrogate.networks()) {
        assert_eq!((a.provenance().trainer.as_str(), b.provenance().trainer.as_str()), ("own", DEFAULT));
        // The output of F1 is a scalar, so that no options are passed to the trainer.
        assert_eq!(a.network().weights(), b.network().weights());
    }
}

/// The weights of a network depend neither on the number of threads nor on the other networks of the study.
#[test]
fn networks_do_not_depend_on_threads_or_company() {
    let dataset = dataset(Law::Plain, 1, 0, 40);
    let text = |options: &StudyOptions| {
        let study = Study::train(&dataset, options, &Silent).unwrap();
        study.mapping("F4").unwrap().surrogate.networks().iter().map(Model::to_json).collect::<Vec<_>>()
    };
    let mut options = small(&["F1", "F4"], 3, "traingdx", 1e-3);
    options.threads = 1;
    let one = text(&options);
    options.threads = 3;
    assert_eq!(one, text(&options));
    options.mappings.remove(0);
    assert_eq!(one, text(&options));
    options.seed = 2;
    assert_ne!(one, text(&options));
}

#[derive(Default)]
struct TrainingCheckpoints {
    models: Mutex<Vec<(String, Model)>>,
    heard: AtomicUsize,
    found: AtomicUsize,
    stop_after: Option<usize>,
}

impl StudyObserver for TrainingCheckpoints {
    fn progress(&self, progress: &StudyProgress) {
        assert!(progress.epoch <= progress.epochs && progress.error.is_finite());
        self.heard.fetch_add(1, Ordering::Relaxed);
    }
    fn trained(&self, network: &str, model: &Model, _: f64) {
        self.models.lock().unwrap().push((network.to_owned(), model.clone()));
    }
    fn finished(&self, network: &str) -> Option<Model> {
        let models = self.models.lock().unwrap();
        let found = models.iter().find(|(name, _)| name == network)?.1.clone();
        self.found.fetch_add(1, Ordering::Relaxed);
        Some(found)
    }
    fn stop(&self) -> bool {
        self.stop_after.is_some_and(|limit| self.models.lock().unwrap().len() >= limit)
    }
}

/// A study that was stopped is resumed with its existing networks and ends with the results of an uninterrupted study.
#[test]
fn a_stopped_study_goes_on_where_it_was() {
    let dataset = dataset(Law::Plain, 1, 0, 40);
    let options = small(&["F1"], 3, "traingdx", 1e-3);
    let mut checkpoints = TrainingCheckpoints { stop_after: Some(2), ..Default::default() };
    let error = Study::train(&dataset, &options, &checkpoints).unwrap_err();
    assert!(matches!(error, LearnError::Stopped { total: 6, .. }), "{error}");
    checkpoints.stop_after = None;
    let resumed = Study::train(&dataset, &options, &checkpoints).unwrap();
    assert!(checkpoints.found.load(Ordering::Relaxed) >= 2 && checkpoints.heard.load(Ordering::Relaxed) > 0);
    let whole = Study::train(&dataset, &options, &Silent).unwrap();
    for (a, b) in resumed.mappings.iter().zip(&whole.mappings) {
        for (x, y) in a.surrogate.networks().iter().zip(b.surrogate.networks()) {
            assert_eq!(x.to_json(), y.to_json());
        }
    }
    // With another number of epochs the stored networks are not used.
    let longer = StudyOptions { epoch_factor: 2e-3, ..options };
    let fresh = Study::train(&dataset, &longer, &checkpoints).unwrap();
    assert_ne!(
        fresh.mappings[0].surrogate.networks()[0].to_json(),
        whole.mappings[0].surrogate.networks()[0].to_json()
    );
}

#[test]
fn too_few_states_are_refused() {
    let coarse = dataset(Law::Plain, 1, 0, 12);
    let message =
        Study::train(&coarse, &small(&["F2"], 3, "traingdx", 1e-3), &Silent).unwrap_err().to_string();
    assert_eq!(
        message,
        "F2 sub-model 1 (deviator strain 0 to 0.05) has 1 training states, needs 3; record more states or widen its range"
    );
}

#[test]
fn a_study_survives_its_files_and_answers_rows() {
    let dataset = dataset(Law::Plain, 1, 1, 40);
    let study = Study::train(&dataset, &small(&["F1", "F2"], 3, "traingdx", 1e-3), &Silent).unwrap();
    let folder = tempfile::tempdir().unwrap();
    files::save_study(folder.path(), &study, &[]).unwrap();
    assert_eq!(files::load_runs(folder.path()).unwrap(), Some(vec![]));
    let loaded = files::load_study(folder.path()).unwrap();
    assert_eq!(loaded.dataset_hash, study.dataset_hash);
    assert_eq!(loaded.baselines, study.baselines);
    assert_eq!(loaded.evaluate(&dataset).unwrap(), study.evaluate(&dataset).unwrap());

    let f2 = &loaded.mapping("F2").unwrap().surrogate;
    assert_eq!(f2.input_names(), ["deviator_strain", "stress_ratio", "force"]);
    let state = dataset.unseen_runs[0].at(0.1).unwrap();
    let answer = f2.predict_row(&[0.1, state.stress_ratio, dataset.forces[2]], 0.9).unwrap();
    assert_eq!(answer.sub_model, 1);
    assert_eq!(answer.value, f2.answer([&state]).unwrap()[0].values[2]);
    let ratio = dataset.training_runs[0].at(0.28).unwrap().stress_ratio;
    let far = f2.predict_row(&[0.5, ratio, 9.0], 0.9).unwrap();
    let names: Vec<&str> = far.outside.iter().map(|outside| outside.name.as_str()).collect();
    assert_eq!((far.sub_model, names), (2, vec!["deviator_strain", "force"]));
    assert_eq!(far.outside[1].range, [dataset.forces[0], dataset.forces[13]]);
    assert!(f2.predict_row(&[], 0.9).is_err() && f2.predict_row(&[f64::NAN, 0.5, 1.0], 0.9).is_err());
    // A row of F1 is a state, and its prediction equals that for the state, the mean over the points.
    let f1 = &loaded.mapping("F1").unwrap().surrogate;
    assert_eq!(f1.input_names().len(), 15);
    let row: Vec<f64> = [0.1].iter().chain(&state.densities).copied().collect();
    let [one, two] = &f1.predict_rows(&[row.clone(), row.clone()].concat(), 0.9).unwrap()[..] else {
        panic!()
    };
    assert_eq!((one.value, one), (f1.answer([&state]).unwrap()[0].values[0], two));
    let message = f1.predict_row(&row[..3], 0.9).unwrap_err().to_string();
    assert!(message.contains("a row has 15 values (deviator_strain, probability_density_0.125"), "{message}");
    let message = loaded.mapping("F3").unwrap_err().to_string();
    assert_eq!(message, "there is no mapping `F3`; there are: F1, F2");

    refuses_every_changed_bit(folder.path());
    // Studies of version 2 had no SHA-256 of their files.
    let manifest = folder.path().join(crate::layout::STUDY_FILE);
    let mut old: serde_json::Value = serde_json::from_slice(&std::fs::read(&manifest).unwrap()).unwrap();
    old["version"] = 2.into();
    for key in ["content", "sha256"] {
        assert!(old.as_object_mut().unwrap().remove(key).is_some(), "{key}");
    }
    std::fs::write(&manifest, serde_json::to_vec(&old).unwrap()).unwrap();
    assert!(!files::can_be_checked(folder.path()).unwrap());
    let kept = folder.path().join(crate::layout::BASELINES_FILE);
    let sealed = std::fs::read_to_string(&kept).unwrap();
    let text = sealed.split(",\n  \"sha256\"").next().unwrap().to_string() + "\n}";
    std::fs::write(&kept, text.replace("\"F2\"", "\"F9\"")).unwrap();
    let message = files::load_study(folder.path()).unwrap_err().to_string();
    assert!(
        message.contains("baselines.json") && message.contains("not the baselines of the mappings"),
        "{message}"
    );
    std::fs::write(&kept, &text[..100]).unwrap();
    assert!(files::load_study(folder.path()).unwrap_err().to_string().contains("these are not baselines"));
    std::fs::remove_file(&kept).unwrap();
    // For a study that was saved without baselines, the baselines are fitted to the data set of the evaluation.
    let older = files::load_study(folder.path()).unwrap();
    assert!(
        older.baselines.is_none() && older.score_run(&dataset.unseen_runs[0]).unwrap()[0].ridge.is_none()
    );
    assert_eq!(older.evaluate(&dataset).unwrap(), study.evaluate(&dataset).unwrap());

    std::fs::write(folder.path().join("F1-2.json"), "{}").unwrap();
    assert!(files::load_study(folder.path()).unwrap_err().to_string().contains("F1-2.json"));
    let text = std::fs::read_to_string(&manifest).unwrap().replace("\"F1\"", "\"../F1\"");
    std::fs::write(&manifest, text).unwrap();
    assert!(files::load_study(folder.path()).unwrap_err().to_string().contains("letters, digits"));
}

/// Flips random bits in each file of a study, and exchanges two of its networks: it is refused, and the file is named.
fn refuses_every_changed_bit(folder: &std::path::Path) {
    assert!(files::faults(folder).unwrap().is_empty() && files::can_be_checked(folder).unwrap());
    let mut noise = 20_061_121_u64;
    let names = ["study.json", "baselines.json", "F1-1.json", "F2-3.json", "F1-strain-only-2.json"];
    for (round, name) in names.iter().cycle().take(200).enumerate() {
        let path = folder.join(name);
        let good = std::fs::read(&path).unwrap();
        let mut bytes = good.clone();
        noise = noise * 48271 % 2_147_483_647;
        let at = noise as usize % bytes.len();
        bytes[at] ^= 1 << (round % 8);
        std::fs::write(&path, bytes).unwrap();
        let message = files::load_study(folder).unwrap_err().to_string();
        assert!(message.contains(name), "byte {at} of {name}: {message}");
        let told =
            files::faults(folder).map(|faults| faults.iter().map(ToString::to_string).collect::<String>());
        assert!(told.unwrap_or_else(|error| error.to_string()).contains(name));
        std::fs::write(&path, good).unwrap();
    }
    let (one, two) = (folder.join("F1-1.json"), folder.join("F1-2.json"));
    let good = std::fs::read(&one).unwrap();
    std::fs::copy(&two, &one).unwrap();
    let message = files::load_study(folder).unwrap_err().to_string();
    assert!(message.contains("F1-1.json: was changed or replaced since the study was saved"), "{message}");
    std::fs::remove_file(&one).unwrap();
    assert!(files::load_study(folder).unwrap_err().to_string().contains("F1-1.json"));
    std::fs::write(&one, good).unwrap();
    files::load_study(folder).unwrap();
}

#[test]
fn any_record_can_be_scored() {
    let dataset = dataset(Law::Plain, 1, 1, 40);
    let study = Study::train(&dataset, &small(&["F1", "F2"], 3, "traingdx", 1e-3), &Silent).unwrap();
    let other = record(Law::Plain, 2, 40);
    let run = study.read(&NamedRecord { name: "other", seed: 2, record: &other }).unwrap();
    assert_eq!(run.states, dataset.unseen_runs[0].states);
    let scores = study.score_run(&run).unwrap();
    let evaluations = study.evaluate(&dataset).unwrap();
    for (score, evaluation) in scores.iter().zip(&evaluations) {
        assert_eq!(score.mapping, evaluation.mapping.name);
        assert_eq!(score.network, evaluation.network.unseen);
        assert_eq!(score.strain_only, evaluation.strain_only.unseen);
        assert_eq!(score.ridge, Some(evaluation.ridge.unseen));
        assert_eq!(score.ridge_strain_only, Some(evaluation.ridge_strain_only.unseen));
        assert_eq!(score.mean_curve, Some(evaluation.mean_curve.unseen));
        assert!(score.states_outside < run.states.len());
    }
    let mut finer = other;
    for histogram in &mut finer.histograms[0].states {
        histogram.bin_width = 0.25 / 3.0;
        histogram.counts =
            [histogram.counts.clone(), histogram.counts.clone(), histogram.counts.clone()].concat();
    }
    let error = study.read(&NamedRecord { name: "finer", seed: 2, record: &finer }).unwrap_err().to_string();
    assert!(error.contains("record with bins of width 0.25"), "{error}");
}

#[test]
fn a_record_survives_its_files() {
    let record = record(Law::Plain, 1, 10);
    let mut record = record;
    for name in ["forces_below", "forces_above"] {
        let values = vec![0.0; record.forces().len()];
        record.series.set(granum_core::Column::new(name, "", values)).unwrap();
    }
    let parent = tempfile::tempdir().unwrap();
    let folder = granum_io::RunFolder::create(parent.path().join("run"), false).unwrap();
    let case = granum_io::Case::default();
    let machine = granum_io::Machine::here("avx2", 1);
    folder.write_case(&case, None).unwrap();
    folder.write_record(&granum_io::RunRecord::new(RunKind::Test, "0.1.0", &case, machine)).unwrap();
    granum_run::record::write_record(&folder, &record).unwrap();
    assert_eq!(granum_run::record::read_record(&folder.run()).unwrap(), record);
    let mut broken = record.clone();
    broken.histograms[0].states.pop();
    granum_run::record::write_record(&folder, &broken).unwrap();
    let error = granum_run::record::read_record(&folder.run()).unwrap_err().to_string();
    assert!(error.contains("run: its series.parquet and histograms are not those of a test"), "{error}");
}

#[test]
fn figures_have_lines_points_and_bands() {
    let dataset = dataset(Law::Plain, 1, 2, 60);
    let study = Study::train(&dataset, &small(&["F1", "F2"], 3, "traingdx", 1e-3), &Silent).unwrap();
    let figures = figures(&study, &dataset).unwrap();
    let panel = &figures[0].panels[0];
    assert_eq!(
        (figures[0].panels.len(), panel.lines.len(), panel.points.len(), panel.bands.len()),
        (1, 6, 2, 1)
    );
    for line in &panel.lines {
        assert_eq!((line.x.len(), line.y.len()), (line.outside.len(), line.x.len()));
        let [low, high] = study.mappings[0].surrogate.mapping().sub_models[line.sub_model - 1].strain_range;
        assert!(line.x.len() > 150 && line.x.iter().all(|x| (low..=high).contains(x)));
    }
    assert_eq!(figures[1].panels.len(), 3);
    let panel = &figures[1].panels[2];
    assert_eq!((panel.lines.len(), panel.points.len(), panel.bands.len()), (6, 6, 3));
    assert!(panel.against_force && panel.points[0].x == dataset.forces);
    // At the centres of the bins, the line passes through the predictions of the network.
    let run = &dataset.unseen_runs[0];
    let strain = panel.lines[0].strain.unwrap();
    let state = run.states.iter().find(|state| state.strain == strain).unwrap();
    let answer = &study.mappings[1].surrogate.answer([state]).unwrap()[0];
    assert!((panel.lines[0].y[0] - answer.values[0]).abs() < 1e-12);
    assert!((panel.lines[0].y[200] - answer.values[13]).abs() < 1e-12);
    let band = &panel.bands[0];
    assert!(band.low.iter().zip(&band.high).all(|(low, high)| low <= high));
}

/// Notes the names of the networks.
#[derive(Default)]
struct Names(std::sync::Mutex<Vec<String>>);

impl StudyObserver for Names {
    fn trained(&self, network: &str, _: &Model, _: f64) {
        self.0.lock().unwrap().push(network.to_string());
    }
}

#[test]
fn the_size_study_sees_that_one_neuron_is_too_few() {
    let dataset = dataset(Law::Plain, 1, 1, 120);
    let options = SizeStudyOptions {
        neurons: vec![1, 5],
        seeds: 2,
        study: StudyOptions::default(),
        ..Default::default()
    };
    let names = Names::default();
    let study = SizeStudy::run(&dataset, &options, &names).unwrap();
    let (mut trained, mut told) = (names.0.into_inner().unwrap(), options.networks());
    trained.sort();
    told.sort();
    assert!(told.contains(&"F3-5-neurons-seed-2-2".to_string()) && trained == told, "{trained:?} {told:?}");
    assert_eq!(study.curves.len(), 2);
    let f1 = &study.curves[0];
    assert_eq!(f1.mapping, "F1");
    assert_eq!(f1.points.iter().map(|p| (p.neurons, p.weights)).collect::<Vec<_>>(), [(1, 8), (5, 56)]);
    assert!(f1.points[1].median_held_out < f1.points[0].median_held_out, "{f1:?}");
    assert_eq!(f1.neurons_for_held_out, Some(5));
    assert_eq!((f1.points[0].held_out.len(), f1.points[0].unseen.len()), (2, 2));
    let sentences = interpretation::read_size_study(&study);
    assert!(sentences.len() == 1 && sentences[0].contains("F1 needs 5 neurons"), "{sentences:?}");
}

#[test]
fn summary_and_speed_come_from_the_evaluation() {
    let dataset = dataset(Law::Plain, 1, 2, 40);
    let study = Study::train(&dataset, &small(&["F1"], 3, "traingdx", 1e-3), &Silent).unwrap();
    let evaluation = &study.evaluate(&dataset).unwrap()[0];
    let summary = MappingSummary::new(evaluation);
    assert_eq!(summary.relative_rmse.unseen, Some(evaluation.network.unseen.relative_rmse));
    assert_eq!(summary.relative_rmse.strain_only, evaluation.strain_only.unseen.relative_rmse);
    assert_eq!(summary.sub_models[1].strain_range, [0.1, 0.2]);
    assert_eq!((summary.sub_models[1].hidden.as_slice(), summary.sub_models[1].epochs), (&[3, 3][..], 150));
    let (scatter, best) = (summary.seed_scatter.unwrap(), summary.best_without_sensors.unwrap());
    assert!((best / scatter - 2f64.sqrt()).abs() < 1e-12);
    let speed = crate::speed::measure(&study, &dataset.unseen_runs[0], 60.0, 5).unwrap();
    assert!(speed.network_seconds > 0.0 && speed.states == 40 && speed.training_seconds > 0.0);
    assert!((speed.factor * speed.network_seconds / 60.0 - 1.0).abs() < 1e-12);
    assert!(interpretation::read(&study.evaluate(&dataset).unwrap(), None).len() == 1);
    assert!(interpretation::read_speed(&speed).contains("times faster"));
}
