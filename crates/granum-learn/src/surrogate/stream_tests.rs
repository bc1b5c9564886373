//! What holds of every stream of predictions.

use super::prediction::Prediction;
use super::run_inputs::RunInputs;
use super::run_memory::RunMemory;
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
    memories_are_values(surrogate, inputs, &whole);
    assert!(PredictionStream::new(surrogate, 1.0).is_err());
}

/// Memories of a run that another stream goes on from, in any order and with other trials in between, have the bits of the run as a whole; and what is no
/// memory is refused.
fn memories_are_values(surrogate: &dyn Surrogate, inputs: &RunInputs, whole: &[Prediction]) {
    let mut stream = PredictionStream::new(surrogate, 0.8).unwrap();
    let mut memories = Vec::new();
    for run in inputs.runs() {
        stream.restart();
        for row in run.chunks_exact(inputs.columns()) {
            memories.push((stream.memory(), row));
            stream.next_state(row).unwrap();
        }
    }
    assert!(memories[0].0.is_start());
    let mut other = PredictionStream::new(surrogate, 0.8).unwrap();
    for ((memory, row), expected) in memories.iter().zip(whole).rev() {
        // As from a file.
        let read: RunMemory = serde_json::from_str(&serde_json::to_string(memory).unwrap()).unwrap();
        other.resume(&read).unwrap();
        let trial: Vec<f64> = row.iter().map(|value| 1.1 * value + 0.01).collect();
        // A trial leaves no trace, whether it has an answer or not.
        let of_trial = other.next_state(&trial);
        other.resume(&read).unwrap();
        // Several next states at once have the bits of each of them.
        let means = |own: &Prediction| own.values.iter().map(|estimate| estimate.mean).collect::<Vec<f64>>();
        let at_once = other.means_of(&[row.to_vec(), row.to_vec()]).unwrap();
        assert_eq!(at_once, vec![means(expected); 2], "{}", surrogate.method());
        assert_eq!(&other.memory(), memory);
        if let Ok(of_trial) = of_trial {
            let at_once = other.means_of(&[trial.clone(), row.to_vec(), trial]).unwrap();
            assert_eq!(at_once, [means(&of_trial), means(expected), means(&of_trial)]);
        }
        other.resume(&read).unwrap();
        assert_eq!(&other.memory(), memory);
        assert_eq!(&other.next_state(row).unwrap(), expected, "{}", surrogate.method());
    }
    let parts = memories[1].0.parts();
    if parts.is_empty() {
        // A surrogate without memory goes on from nothing, and refuses the memory of another one.
        assert!(!surrogate.has_memory());
        assert!(other.resume(&RunMemory::new(vec![vec![0.0]])).is_err());
        return;
    }
    for at in 0..parts.len() {
        let mut damaged = parts.to_vec();
        damaged[at].push(0.0);
        assert!(other.resume(&RunMemory::new(damaged)).is_err(), "{} {at}", surrogate.method());
        if let Some(value) = parts[at].first() {
            let mut damaged = parts.to_vec();
            damaged[at][0] = f64::NAN * value;
            assert!(other.resume(&RunMemory::new(damaged)).is_err(), "{} {at}", surrogate.method());
        }
    }
    assert!(other.resume(&RunMemory::new(parts[1..].to_vec())).is_err() || parts.len() == 1);
    // After a refusal the next state is the first of a run.
    assert_eq!(&other.next_state(memories[0].1).unwrap(), &whole[0]);
}
