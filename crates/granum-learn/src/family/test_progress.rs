//! How far a test with several stages is: the coordinate of tests whose stages end at other strains in each run.
//!
//! A stage of unloading ends at a stress, and the strain that it takes depends on the grains. The progress of a test counts its stages, and
//! within a stage it is the root of the share of the path of strain, since curves change most where a stage begins:
//!
//! ```text
//! progress = (stages before) + sqrt((s - s_begin) / (s_end - s_begin))
//! ```
//!
//! with the length `s` of the path of strain (`arc_length`). It is zero at the start and the number of stages at the end.

use crate::dataset::RunStates;
use crate::error::{LearnError, Result};

/// Its column.
pub(super) const TEST_PROGRESS: &str = "test_progress";

/// How far the first of two records of the state between two stages is before the second.
const TWICE: f64 = 1e-9;

/// The progress at each state of a run.
///
/// # Errors
/// If the run has no stages or no path of strain, or there is no strain in a stage.
pub(super) fn test_progress(run: &RunStates) -> Result<Vec<f64>> {
    let (stages, lengths) = (run.column("stage")?, run.column("arc_length")?);
    let mut progress = Vec::with_capacity(stages.len());
    let mut start = 0;
    let mut before = 0.0;
    while start < stages.len() {
        let end = (start..stages.len()).find(|row| stages[*row] != stages[start]).unwrap_or(stages.len());
        // A stage ends where the next one begins, and the last one with its last state.
        let last = lengths.get(end).copied().unwrap_or(lengths[end - 1]);
        let length = last - lengths[start];
        if !(length > 0.0 && length.is_finite()) {
            let reason = format!("nothing is strained in its stage {}", stages[start]);
            return Err(LearnError::Record { run: run.name().into(), reason });
        }
        // The state in which a stage ends can be recorded once more as the first of the next one.
        let most = if end < stages.len() { 1.0 - TWICE } else { 1.0 };
        let share = |s: &f64| ((s - lengths[start]) / length).sqrt().min(most);
        progress.extend(lengths[start..end].iter().map(|s| before + share(s)));
        before += 1.0;
        start = end;
    }
    Ok(progress)
}

#[cfg(test)]
mod tests {
    use granum_core::{Column, Table};

    use super::*;

    fn run(stages: Vec<f64>, lengths: Vec<f64>) -> RunStates {
        let columns = vec![Column::new("stage", "", stages), Column::new("arc_length", "", lengths)];
        RunStates::new("run", Table::new(columns).unwrap()).unwrap()
    }

    /// Golden: two stages by hand; a stage goes on until the next one begins.
    #[test]
    fn progress_counts_stages_and_shares_of_their_strain() {
        let run = run(vec![1.0, 1.0, 1.0, 2.0, 2.0], vec![0.0, 0.01, 0.03, 0.04, 0.05]);
        let found = test_progress(&run).unwrap();
        let expected = [0.0, 0.5, 0.75f64.sqrt(), 1.0, 2.0];
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
    }

    #[test]
    fn a_state_that_is_recorded_twice_is_no_turn() {
        let found = test_progress(&run(vec![1.0, 1.0, 2.0, 2.0], vec![0.0, 0.03, 0.03, 0.05])).unwrap();
        assert!(found.windows(2).all(|pair| pair[1] > pair[0]) && found[3] == 2.0, "{found:?}");
    }

    #[test]
    fn a_stage_without_strain_is_an_error() {
        let told = test_progress(&run(vec![1.0, 2.0], vec![0.1, 0.1])).unwrap_err().to_string();
        assert!(told.contains("`run`") && told.contains("stage 1"), "{told}");
    }
}
