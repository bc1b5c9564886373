//! A study of columns, methods and a split of one's own: the stress ratio from the strain and from the speed that the sensor of this
//! program measures.

use granum::learn::Result;
use granum::learn::study::StudyScores;
use granum::prelude::*;

/// Trains it on all runs but the last, which scores it, and returns the scores with the study.
pub fn hardening_study(records: &[Record], methods: &SurrogateMethods) -> Result<(Study, StudyScores)> {
    let name = |k: usize| format!("run {k}");
    let run = |(k, record): (usize, &Record)| {
        RunStates::from_record(&NamedRecord { name: &name(k), seed: k as u64, record })
    };
    let dataset = Dataset::new(records.iter().enumerate().map(run).collect::<Result<_>>()?)?;
    let spec = FitSpec::new(["axial_strain", "fluctuating_speed"], ["von_mises_ratio"]);
    let definition = StudyDefinition::new(
        [spec.with_coordinate("axial_strain")],
        ["fading-memory"],
        Split::default().first_state(1).unseen([name(records.len() - 1)]),
    );
    let study = Study::train(&dataset, &definition, methods, &NoStudyObserver)?;
    let scores = study.evaluate(&dataset)?;
    Ok((study, scores))
}
