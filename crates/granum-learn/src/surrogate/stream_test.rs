//! What holds of every stream of predictions.

use super::prediction::Prediction;
use super::run_inputs::RunInputs;
use super::stream::PredictionStream;
use super::surrogate_trait::Surrogate;

/// States one after the other have the bits of whole runs, and states that are refused leave no trace.
pub(crate) fn answers_as_whole_runs(surrogate: &dyn Surrogate, inputs: &RunInputs) {
    let whole = surrogate.predict(inputs, 0.8).unwrap();
    let mut stream = PredictionStream::new(surrogate, 0.8).unwrap();
    let mut answers: Vec<Prediction> = Vec::new();
    for run in inputs.runs() {
        stream.restart();
        for row in run.chunks_exact(inputs.columns()) {
            let mut damaged = row.to_vec();
            damaged[0] = f64::NAN;
            let error = stream.next_state(&damaged).unwrap_err().to_string();
            assert!(error.contains("is NaN, not a finite number"), "{error}");
            assert!(stream.next_state(&row[1..]).is_err());
            answers.push(stream.next_state(row).unwrap());
        }
    }
    assert_eq!(answers, whole, "{}", surrogate.method());
    assert!(PredictionStream::new(surrogate, 1.0).is_err());
}
