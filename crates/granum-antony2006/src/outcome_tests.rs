//! What comes of studies: scores of single records, figures, the study of sizes, summaries.

use granum_io::RunKind;

use std::sync::Mutex;

use granum_learn::networks::NetworkCheckpoints;
use granum_learn::study::{NoStudyObserver, StudyObserver};
use granum_learn::surrogate::RunInputs;
use granum_learn::{NamedRecord, RunStates, Surrogate};
use granum_nets::Model;
use granum_sensors::Record;

use crate::Evaluation;
use crate::evaluation::{networks, score_run, scored_run};
use crate::figures::figures;
use crate::interpretation;
use crate::options::PaperOptions;
use crate::size_study::{SizeStudy, SizeStudyOptions};
use crate::summary::MappingSummary;
use crate::synthetic::{Law, record};
use crate::tests::{data, small};

#[test]
fn any_record_can_be_scored() {
    let data = data(Law::Plain, 1, 1, 40);
    let study = small(&["F1", "F2"], 3, "traingdx", 1e-3).train(&data, &NoStudyObserver).unwrap();
    let other = record(Law::Plain, 2, 40);
    let read =
        |name: &str, record: &Record| RunStates::from_record(&NamedRecord { name, seed: 2, record }).unwrap();
    let run = scored_run(&study, &read("other", &other)).unwrap();
    assert_eq!(run.table(), data.parts.unseen.runs()[0].table());
    let scores = score_run(&study, &run).unwrap();
    for (score, evaluation) in scores.iter().zip(&Evaluation::of_study(&study, &data).unwrap()) {
        assert_eq!(score.mapping, evaluation.mapping.name);
        assert_eq!(score.network, evaluation.network.unseen);
        assert_eq!(score.strain_only, evaluation.strain_only.unseen);
        assert_eq!(score.ridge, Some(evaluation.ridge.unseen));
        assert_eq!(score.ridge_strain_only, Some(evaluation.ridge_strain_only.unseen));
        assert_eq!(score.mean_curve, Some(evaluation.mean_curve.unseen));
        assert!(score.states_outside < run.rows());
    }
    let mut finer = other;
    for histogram in &mut finer.histograms[0].states {
        histogram.bin_width = 0.25 / 3.0;
        histogram.counts =
            [histogram.counts.clone(), histogram.counts.clone(), histogram.counts.clone()].concat();
    }
    let error = scored_run(&study, &read("finer", &finer)).unwrap_err().to_string();
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
    let data = data(Law::Plain, 1, 2, 60);
    let study = small(&["F1", "F2"], 3, "traingdx", 1e-3).train(&data, &NoStudyObserver).unwrap();
    let figures = figures(&study, &data).unwrap();
    let panel = &figures[0].panels[0];
    assert_eq!(
        (figures[0].panels.len(), panel.lines.len(), panel.points.len(), panel.bands.len()),
        (1, 6, 2, 1)
    );
    for line in &panel.lines {
        assert_eq!((line.x.len(), line.y.len()), (line.outside.len(), line.x.len()));
        let [low, high] = networks(&study, "F1").unwrap().mapping().sub_models[line.sub_model - 1].range;
        assert!(line.x.len() > 150 && line.x.iter().all(|x| (low..=high).contains(x)));
    }
    assert_eq!(figures[1].panels.len(), 3);
    let panel = &figures[1].panels[2];
    assert_eq!((panel.lines.len(), panel.points.len(), panel.bands.len()), (6, 6, 3));
    assert!(panel.against_force && panel.points[0].x == data.bins.centres);
    // At the centres of the bins, the line passes through the predictions of the network.
    let run = &data.parts.unseen.runs()[0];
    let strain = panel.lines[0].strain.unwrap();
    let f2 = networks(&study, "F2").unwrap();
    let part = granum_learn::Dataset::new(vec![run.clone()]).unwrap();
    let part = part.select(|run, row| run.table().column("deviator_strain").unwrap()[row] == strain);
    let inputs = RunInputs::from_dataset(&part, Surrogate::columns(f2)).unwrap();
    let predicted = &f2.predict_states(inputs.values()).unwrap()[0];
    assert!((panel.lines[0].y[0] - predicted.values[0]).abs() < 1e-12);
    assert!((panel.lines[0].y[200] - predicted.values[13]).abs() < 1e-12);
    let band = &panel.bands[0];
    assert!(band.low.iter().zip(&band.high).all(|(low, high)| low <= high));
}

/// Notes the names of the networks.
#[derive(Default)]
struct Names(Mutex<Vec<String>>);

impl NetworkCheckpoints for Names {
    fn trained(&self, network: &str, _: &Model, _: f64) {
        self.0.lock().unwrap().push(network.to_string());
    }
}

impl StudyObserver for Names {
    fn networks(&self) -> &dyn NetworkCheckpoints {
        self
    }
}

#[test]
fn the_size_study_sees_that_one_neuron_is_too_few() {
    let data = data(Law::Plain, 1, 1, 120);
    let options = SizeStudyOptions {
        neurons: vec![1, 5],
        seeds: 2,
        study: PaperOptions::default(),
        ..Default::default()
    };
    let names = Names::default();
    let study = SizeStudy::run(&data, &options, &names).unwrap();
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
    let data = data(Law::Plain, 1, 2, 40);
    let study = small(&["F1"], 3, "traingdx", 1e-3).train(&data, &NoStudyObserver).unwrap();
    let evaluation = &Evaluation::of_study(&study, &data).unwrap()[0];
    let summary = MappingSummary::new(evaluation);
    assert_eq!(summary.relative_rmse.unseen, Some(evaluation.network.unseen.relative_rmse));
    assert_eq!(summary.relative_rmse.strain_only, evaluation.strain_only.unseen.relative_rmse);
    assert_eq!(summary.sub_models[1].strain_range, [0.1, 0.2]);
    assert_eq!((summary.sub_models[1].hidden.as_slice(), summary.sub_models[1].epochs), (&[3, 3][..], 150));
    let (scatter, best) = (summary.seed_scatter.unwrap(), summary.best_without_sensors.unwrap());
    assert!((best / scatter - 2f64.sqrt()).abs() < 1e-12);
    let speed = crate::speed::measure(&study, &data.parts.unseen.runs()[0], 60.0, 5).unwrap();
    assert!(speed.network_seconds > 0.0 && speed.states == 40 && speed.training_seconds > 0.0);
    assert!((speed.factor * speed.network_seconds / 60.0 - 1.0).abs() < 1e-12);
    assert!(interpretation::read(&Evaluation::of_study(&study, &data).unwrap(), None).len() == 1);
    assert!(interpretation::read_speed(&speed).contains("times faster"));
}
