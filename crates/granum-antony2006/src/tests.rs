//! Whole studies on synthetic records.

use std::sync::atomic::{AtomicUsize, Ordering};

use granum_core::observer::Progress as Step;
use granum_learn::curve::RunCurves;
use granum_learn::input_use::Verdict;
use granum_learn::networks::{Form, NetworkCheckpoints, SubModelNetworks, networks_of};
use granum_learn::study::{KeptStudy, NoStudyObserver, Study, StudyObserver, StudyPlan};
use granum_learn::{LearnError, NamedRecord, RunStates, Surrogate};
use granum_nets::trainer::{
    Flow, LevenbergMarquardt, Observer, Options, Progress, Trainer, TrainerState, TrainingError,
    TrainingReport, by_name,
};
use granum_nets::{Data, Differentiable, Model, ModelDefinition};
use granum_sensors::Record;

use crate::Evaluation;
use crate::data::{PaperData, PaperDataOptions};
use crate::evaluation::{networks, strain_only, training_seconds};
use crate::interpretation;
use crate::mapping::{Mapping, paper_mapping};
use crate::options::{PaperOptions, is_of_paper};
use crate::synthetic::{Law, record};

pub(crate) fn data(law: Law, training: u64, unseen: u64, intervals: usize) -> PaperData {
    let records: Vec<Record> = (1..=training + unseen).map(|seed| record(law, seed, intervals)).collect();
    let names: Vec<String> = (1..=records.len()).map(|k| format!("run-{k}")).collect();
    let named: Vec<NamedRecord> = records
        .iter()
        .zip(&names)
        .enumerate()
        .map(|(k, (record, name))| NamedRecord { name, seed: k as u64 + 1, record })
        .collect();
    let (seen, rest) = named.split_at(training as usize);
    PaperData::from_records(seen, rest, &PaperDataOptions::default()).unwrap()
}

/// Small networks, so that the tests are quick.
pub(crate) fn small(names: &[&str], neurons: usize, trainer: &str, epoch_factor: f64) -> PaperOptions {
    let mappings: Vec<Mapping> =
        names.iter().map(|name| paper_mapping(name).unwrap().with_neurons(neurons)).collect();
    PaperOptions {
        mappings,
        trainer: by_name(trainer, &Options::default()).unwrap(),
        epoch_factor,
        ..Default::default()
    }
}

pub(crate) fn evaluate(data: &PaperData, options: &PaperOptions) -> Vec<Evaluation> {
    Evaluation::of_study(&options.train(data, &NoStudyObserver).unwrap(), data).unwrap()
}

pub(crate) const DEFAULT: &str = "levenberg-marquardt";

#[test]
fn smooth_curves_are_learned_down_to_their_noise() {
    // Here the noise is independent between states, whereas in real runs it is correlated over several states. Since a state
    // counts as a fraction of an observation, the curves are slightly smoother than these records would permit.
    let data = data(Law::Plain, 1, 2, 120);
    for evaluation in evaluate(&data, &small(&["F1", "F2", "F3", "F4", "F5", "F6"], 6, DEFAULT, 1.0)) {
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
        let data = data(law, 1, 5, 120);
        for evaluation in evaluate(&data, &small(&["F1", "F3"], 4, DEFAULT, 1.0)) {
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
    let data = data(Law::Hidden, 1, 4, 120);
    let mut options = small(&["F1", "F3", "F5"], 4, DEFAULT, 1.0);
    options.form = Form::Histogram;
    for evaluation in evaluate(&data, &options) {
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
        let data = data(Law::Hidden, 1, unseen, 40);
        for evaluation in evaluate(&data, &small(&["F3"], 3, "traingdx", 1e-3)) {
            assert_eq!(evaluation.sensor_use.verdict(), Verdict::TooFewRuns);
            assert_eq!(evaluation.sensor_use.with_other.is_some(), unseen > 1);
            let text = interpretation::read_mapping(&evaluation);
            assert!(text.contains(said), "{text}");
        }
    }
}

/// A network with the same inputs that was trained on nearly constant targets.
fn silenced(networks: &SubModelNetworks) -> Model {
    let columns = networks.mapping().network_inputs();
    let rows = 60;
    let value = |k: usize| ((k * 7919) % 101) as f64 / 101.0;
    let inputs = (0..rows * columns.len()).map(value).collect();
    let targets = (0..rows).map(|k| 0.7 + 1e-9 * (k % 3) as f64).collect();
    let data = Data::new(inputs, columns.len(), targets).unwrap();
    let definition = ModelDefinition::new(columns, networks.mapping().network_output(), vec![3, 3]);
    let options = Options { epochs: Some(5), ..Options::default() };
    let trainer = by_name("traingdx", &options).unwrap();
    Model::fit(&definition, &data, trainer.as_ref(), &mut |_: &Progress| Flow::Continue).unwrap().0
}

/// A network with nearly constant predictions is reported as constant.
#[test]
fn a_forged_constant_is_called_one() {
    let data = data(Law::Plain, 1, 3, 40);
    let mut study = small(&["F3"], 3, "traingdx", 1e-3).train(&data, &NoStudyObserver).unwrap();
    let own = networks(&study, "F3").unwrap();
    assert!((0..3).all(|k| !own.is_constant(&data.parts.training, k).unwrap()));
    let models = vec![own.networks()[0].clone(), silenced(own), own.networks()[2].clone()];
    let forged = SubModelNetworks::new(own.method(), own.mapping().clone(), models).unwrap();
    study.fits[0].members[0].surrogate = Box::new(forged);
    let evaluation = &Evaluation::of_study(&study, &data).unwrap()[0];
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
    let data = data(Law::Hidden, 1, 1, 120);
    for evaluation in evaluate(&data, &small(&["F3"], 4, DEFAULT, 1.0)) {
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
    let data = data(Law::Plain, 1, 0, 40);
    let options = small(&["F1"], 3, DEFAULT, 1.0);
    let usual = options.train(&data, &NoStudyObserver).unwrap();
    let own = PaperOptions { trainer: Own.into(), ..options }.train(&data, &NoStudyObserver).unwrap();
    assert_eq!(own.definition.networks.trainer, "own");
    let [own, usual] = [&own, &usual].map(|study| networks(study, "F1").unwrap().networks());
    for (a, b) in own.iter().zip(usual) {
        assert_eq!((a.provenance().trainer.as_str(), b.provenance().trainer.as_str()), ("own", DEFAULT));
        // The output of F1 is a scalar, so that no options are passed to the trainer.
        assert_eq!(a.network().weights(), b.network().weights());
    }
}

/// The weights of a network depend neither on the number of threads nor on the other networks of the study.
#[test]
fn networks_do_not_depend_on_threads_or_company() {
    let data = data(Law::Plain, 1, 0, 40);
    let text = |options: &PaperOptions| {
        let study = options.train(&data, &NoStudyObserver).unwrap();
        let own = networks(&study, "F4").unwrap().networks().iter();
        own.map(Model::to_json).collect::<Vec<_>>()
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

/// Keeps a study in a folder and stops it after some epochs.
struct Stops {
    kept: KeptStudy,
    epochs: AtomicUsize,
    most: usize,
}

impl StudyObserver for Stops {
    fn progress(&self, _: &str, progress: &Step) {
        // Ridge regressions count their outputs and have no error on the way.
        let Some(error) = progress.value("error") else { return };
        assert!(progress.of.is_some_and(|most| progress.done <= most) && error.is_finite());
        self.epochs.fetch_add(1, Ordering::Relaxed);
    }
    fn finished(&self, name: &str) -> granum_learn::Result<Option<Box<dyn Surrogate>>> {
        self.kept.finished(name)
    }
    fn fitted(&self, name: &str, surrogate: &dyn Surrogate) -> granum_learn::Result<()> {
        self.kept.fitted(name, surrogate)
    }
    fn networks(&self) -> &dyn NetworkCheckpoints {
        &self.kept.networks
    }
    fn stop(&self) -> bool {
        self.epochs.load(Ordering::Relaxed) >= self.most
    }
}

/// A study that was stopped is resumed with its existing networks and ends with the results of an uninterrupted study.
#[test]
fn a_stopped_study_goes_on_where_it_was() {
    let data = data(Law::Plain, 1, 0, 40);
    let options = small(&["F1"], 3, "traingdx", 1e-3);
    let folder = tempfile::tempdir().unwrap();
    let observer = |options: &PaperOptions, most: usize| {
        let plan = StudyPlan::new(&[], &[], data.dataset.digest(), options.definition(&data)).unwrap();
        let every = std::time::Duration::ZERO;
        let kept = KeptStudy::begin(folder.path(), &plan, &options.methods(), every).unwrap();
        Stops { kept, epochs: AtomicUsize::new(0), most }
    };
    let error = options.train(&data, &observer(&options, 300)).err().unwrap();
    assert!(matches!(error, LearnError::Stopped { total: 5, .. }), "{error}");
    let going_on = observer(&options, usize::MAX);
    let resumed = options.train(&data, &going_on).unwrap();
    let whole = options.train(&data, &NoStudyObserver).unwrap();
    // Of the 810 epochs of all networks, those before the stop are not repeated.
    let epochs = |study: &Study| -> u64 {
        let all = study.members().filter_map(|member| networks_of(member.surrogate.as_ref()));
        all.flat_map(SubModelNetworks::networks).map(|model| model.provenance().epochs).sum()
    };
    let (repeated, all) = (going_on.epochs.load(Ordering::Relaxed) as u64, epochs(&whole));
    assert!(repeated + 290 < all, "{repeated} {all}");
    for name in [networks, strain_only] {
        let [a, b] = [&resumed, &whole].map(|study| name(study, "F1").unwrap().networks());
        assert!(a.iter().zip(b).all(|(x, y)| x.to_json() == y.to_json()));
    }
    // With another number of epochs nothing that is kept is used.
    let longer = PaperOptions { epoch_factor: 2e-3, ..options };
    let fresh = longer.train(&data, &observer(&longer, usize::MAX)).unwrap();
    let [a, b] = [&fresh, &whole].map(|study| networks(study, "F1").unwrap().networks()[0].to_json());
    assert_ne!(a, b);
}

#[test]
fn too_few_states_are_refused_before_anything_is_trained() {
    let coarse = data(Law::Plain, 1, 0, 12);
    let options = small(&["F2"], 3, "traingdx", 1e-3);
    let message =
        options.definition(&coarse).check(&coarse.dataset, &options.methods()).unwrap_err().to_string();
    assert_eq!(
        message,
        "F2 sub-model 1 (deviator strain 0 to 0.05) has 1 training states, needs 3; record more states or widen its range"
    );
}

#[test]
fn a_study_survives_its_files_and_answers_rows() {
    let data = data(Law::Plain, 1, 1, 40);
    let options = small(&["F1", "F2"], 3, "traingdx", 1e-3);
    let study = options.train(&data, &NoStudyObserver).unwrap();
    let folder = tempfile::tempdir().unwrap();
    granum_learn::study::save(folder.path(), &study, &data.dataset).unwrap();
    let loaded = granum_learn::study::load(folder.path(), &options.methods()).unwrap().study;
    assert!(is_of_paper(&loaded.definition));
    let read = PaperOptions::from_definition(&loaded.definition).unwrap();
    assert_eq!((read.mappings, read.epoch_factor), (options.mappings.clone(), 1e-3));
    let evaluated = |study: &Study| Evaluation::of_study(study, &data).unwrap();
    assert_eq!(evaluated(&loaded), evaluated(&study));
    assert_eq!(training_seconds(&loaded), training_seconds(&study));

    let f2 = networks(&loaded, "F2").unwrap();
    assert_eq!(f2.input_names(), ["deviator_strain", "stress_ratio", "force"]);
    let run = &data.parts.unseen.runs()[0];
    let at = |run: &RunStates, networks: &SubModelNetworks, strain: f64| {
        RunCurves::new(run, "deviator_strain", &Surrogate::columns(networks).input_names())
            .unwrap()
            .at(strain)
    };
    let state = at(run, f2, 0.1);
    let force = data.bins.centres[2];
    let predicted = f2.predict_row(&[state[0], state[1], force], 0.9).unwrap();
    assert_eq!(predicted.sub_model, 1);
    assert_eq!(predicted.value, f2.predict_states(&state).unwrap()[0].values[2]);
    let ratio = at(&data.parts.training_runs.runs()[0], f2, 0.28)[1];
    let far = f2.predict_row(&[0.5, ratio, 9.0], 0.9).unwrap();
    let names: Vec<&str> = far.outside.iter().map(|outside| outside.name.as_str()).collect();
    assert_eq!((far.sub_model, names), (2, vec!["deviator_strain", "force"]));
    assert_eq!(far.outside[1].range, [data.bins.centres[0], data.bins.centres[13]]);
    assert!(f2.predict_row(&[], 0.9).is_err() && f2.predict_row(&[f64::NAN, 0.5, 1.0], 0.9).is_err());
    // A row of F1 is a state, and its prediction equals that for the state, the mean over the points.
    let f1 = networks(&loaded, "F1").unwrap();
    assert_eq!(f1.input_names().len(), 15);
    let row = at(run, f1, 0.1);
    let [one, two] = &f1.predict_single_values(&[row.clone(), row.clone()].concat(), 0.9).unwrap()[..] else {
        panic!()
    };
    assert_eq!((one.value, one), (f1.predict_states(&row).unwrap()[0].values[0], two));
    let message = f1.predict_row(&row[..3], 0.9).unwrap_err().to_string();
    assert!(message.contains("a row has 15 values (deviator_strain, probability_density_0.125"), "{message}");
    let message = networks(&loaded, "F3").unwrap_err().to_string();
    assert_eq!(message, "there is no mapping `F3`; there are: F1, F2");
    refuses_every_changed_bit(folder.path(), &options);
    // The format of earlier versions is refused with its version.
    let manifest = folder.path().join(granum_learn::study::STUDY_FILE);
    std::fs::write(&manifest, r#"{"format": "granum study", "version": 3, "form": "point"}"#).unwrap();
    let message = granum_learn::study::load(folder.path(), &options.methods()).err().unwrap().to_string();
    assert!(
        message.contains("version 3 of an earlier format") && message.contains("train again"),
        "{message}"
    );
}

/// Flips random bits in each file of a study, and exchanges two of its surrogates: it is refused, and the file is named.
fn refuses_every_changed_bit(folder: &std::path::Path, options: &PaperOptions) {
    use granum_learn::study::{faults, load};
    let methods = options.methods();
    assert!(faults(folder).unwrap().is_empty());
    let mut noise = 20_061_121_u64;
    let names = ["study.json", "F1-antony2006.json", "F2-ridge.json", "F1-antony2006-coordinate-only.json"];
    for (round, name) in names.iter().cycle().take(120).enumerate() {
        let path = folder.join(name);
        let good = std::fs::read(&path).unwrap();
        let mut bytes = good.clone();
        noise = noise * 48271 % 2_147_483_647;
        let at = noise as usize % bytes.len();
        bytes[at] ^= 1 << (round % 8);
        std::fs::write(&path, bytes).unwrap();
        let message = load(folder, &methods).err().unwrap().to_string();
        assert!(message.contains(name), "byte {at} of {name}: {message}");
        let told = faults(folder).map(|faults| faults.iter().map(ToString::to_string).collect::<String>());
        assert!(told.unwrap_or_else(|error| error.to_string()).contains(name));
        std::fs::write(&path, good).unwrap();
    }
    let (one, two) = (folder.join("F1-antony2006.json"), folder.join("F2-antony2006.json"));
    let good = std::fs::read(&one).unwrap();
    std::fs::copy(&two, &one).unwrap();
    let message = load(folder, &methods).err().unwrap().to_string();
    assert!(
        message.contains("F1-antony2006.json: its SHA-256") && message.contains("changed or replaced"),
        "{message}"
    );
    std::fs::remove_file(&one).unwrap();
    assert!(load(folder, &methods).err().unwrap().to_string().contains("F1-antony2006.json"));
    std::fs::write(&one, good).unwrap();
    load(folder, &methods).unwrap();
}
