//! A small study that is trained on synthetic records with the complete procedure: data set, networks, scores, curves,
//! report.

use std::sync::OnceLock;

use granum_antony2006::StudyReport;
use granum_antony2006::interpretation;
use granum_antony2006::learning_curve::PaperLearningCurve;
use granum_antony2006::size_study::SizeStudyOptions;
use granum_antony2006::summary::{DemSummary, MappingSummary, PaperSummary, RunSummary, SpeedSummary};
use granum_antony2006::{
    Evaluation, Mapping, PaperData, PaperDataOptions, PaperOptions, SizeStudy, paper_mappings,
};
use granum_learn::NamedRecord;
use granum_learn::study::NoStudyObserver;
use granum_report::{RoleInStudy, RunReport};

use crate::synthetic;

/// The mappings of the paper with small networks, whose training takes little time.
fn small_mappings() -> Vec<Mapping> {
    paper_mappings().into_iter().map(|mapping| mapping.with_neurons(4)).collect()
}

fn train() -> StudyReport {
    let mut runs: Vec<RunReport> =
        [(RoleInStudy::Training, 1), (RoleInStudy::Unseen, 2), (RoleInStudy::Unseen, 3)]
            .map(|(role, seed)| synthetic::run(role, seed))
            .to_vec();
    runs[0].start = Some(synthetic::assembly(0.0));
    runs[0].end = Some(synthetic::assembly(0.35));
    let named = |run: &'static str, k: usize, runs: &'static [RunReport]| NamedRecord {
        name: run,
        seed: k as u64 + 1,
        record: &runs[k].record,
    };
    // The records are leaked, since they must live as long as the test program.
    let kept: &'static [RunReport] = Box::leak(runs.clone().into_boxed_slice());
    let training = [named("training-1", 0, kept)];
    let unseen = [named("unseen-2", 1, kept), named("unseen-3", 2, kept)];
    let data = PaperData::from_records(&training, &unseen, &PaperDataOptions::default())
        .expect("the records are whole");
    let options = PaperOptions { mappings: small_mappings(), threads: 2, ..Default::default() };
    let study = options.train(&data, &NoStudyObserver).expect("small networks train");
    let evaluations = Evaluation::of_study(&study, &data).expect("states are finite");
    let curve =
        PaperLearningCurve::measure(&data, 2000, &options, &NoStudyObserver).expect("small networks train");
    let size_options =
        SizeStudyOptions { neurons: vec![1, 2, 4], seeds: 2, study: options, ..Default::default() };
    let size_study = SizeStudy::run(&data, &size_options, &NoStudyObserver).expect("small networks train");
    let measured = granum_antony2006::speed::measure(&study, &data.parts.unseen.runs()[0], 180.0, 1)
        .expect("states are finite");
    // Measured times vary between tests, but the page must not.
    let speed = SpeedSummary { network_seconds: 0.02, factor: 9000.0, training_seconds: 4.0, ..measured };
    let summary = PaperSummary {
        dem: DemSummary {
            grains: 5000,
            solid_fraction: 0.61,
            coordination_number: 4.77,
            mechanical_coordination_number: 5.01,
            runs: runs.iter().map(summary_of).collect(),
        },
        mappings: evaluations.iter().map(|e| (e.mapping.name.clone(), MappingSummary::new(e))).collect(),
        reading: interpretation::read(&evaluations, Some(&size_study)),
        size_study: Some(size_study),
        learning_curve: Some(curve),
        speed,
    };
    StudyReport {
        figures: granum_antony2006::figures::figures(&study, &data).expect("states are finite"),
        summary,
        runs,
        command: "granum reproduce".into(),
        dataset_hash: data.hash().expect("states are finite"),
        network_seed: 1,
    }
}

fn summary_of(run: &RunReport) -> RunSummary {
    RunSummary {
        role: run.role.word().into(),
        seed: run.case.preparation.seed,
        wall_seconds: run.wall_seconds(),
        grain_steps: run.run.grain_steps() as f64,
    }
}

/// The study, trained once for all tests.
pub fn study() -> &'static StudyReport {
    static STUDY: OnceLock<StudyReport> = OnceLock::new();
    STUDY.get_or_init(train)
}
