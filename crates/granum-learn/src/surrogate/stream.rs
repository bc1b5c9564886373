//! Predictions of a surrogate for states that come one after the other, as from the sensors of a test that is running.

use std::sync::Arc;

use super::possible_values::cut_to_possible;
use super::prediction::Prediction;
use super::run_inputs::RunInputs;
use super::run_memory::RunMemory;
use super::run_steps::RunSteps;
use super::surrogate_trait::{Surrogate, check_finite, check_inputs, check_level};
use crate::error::{LearnError, Result};

/// Predictions for states that come one after the other. They have the bits of [`Surrogate::predict`] for the whole run; the time for a state does not
/// depend on how many there were before it, and nothing is kept of them but the memory of the surrogate.
///
/// ```
/// use granum_core::observer::NoObserver;
/// use granum_core::{Column, Table};
/// use granum_learn::surrogate::{FitSpec, PredictionStream, Recurrent, RunInputs, SurrogateMethod};
/// use granum_learn::{Dataset, RunStates};
///
/// let run = |k: u32| {
///     let x: Vec<f64> = (0..12).map(|i| (f64::from(i * (1 + k % 4)) + f64::from(k)).sin()).collect();
///     let table = Table::new(vec![Column::new("x", "", x.clone()), Column::new("y", "", x)])?;
///     RunStates::new(&format!("run-{k}"), table)
/// };
/// let dataset = Dataset::new((0..4).map(run).collect::<granum_learn::Result<_>>()?)?;
/// let mut method = Recurrent::default();
/// (method.hidden, method.networks) = (4, 2);
/// let fitted = method.fit(&dataset, &FitSpec::new(["x"], ["y"]), &mut NoObserver)?;
///
/// let whole = fitted.predict(&RunInputs::new(vec![-0.5, 0.9], 1, vec![2])?, 0.9)?;
/// let mut stream = PredictionStream::new(fitted.as_ref(), 0.9)?;
/// assert_eq!(stream.next_state(&[-0.5])?, whole[0]);
/// assert_eq!(stream.next_state(&[0.9])?, whole[1]);
/// stream.restart();
/// assert_eq!(stream.next_state(&[-0.5])?, whole[0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct PredictionStream<'a> {
    surrogate: Whose<'a>,
    level: f64,
    /// `None` for a surrogate without memory.
    steps: Option<Box<dyn RunSteps>>,
    /// The values that each output can have.
    possible: Vec<[f64; 2]>,
}

/// A surrogate of the caller, or one that is shared.
enum Whose<'a> {
    Borrowed(&'a dyn Surrogate),
    Shared(Arc<dyn Surrogate>),
}

impl Whose<'_> {
    fn surrogate(&self) -> &dyn Surrogate {
        match self {
            Whose::Borrowed(surrogate) => *surrogate,
            Whose::Shared(surrogate) => surrogate.as_ref(),
        }
    }
}

impl PredictionStream<'static> {
    /// As [`PredictionStream::new`], for a surrogate that is shared: the stream can be kept with it.
    ///
    /// # Errors
    /// As [`PredictionStream::new`].
    pub fn of_shared(surrogate: Arc<dyn Surrogate>, level: f64) -> Result<PredictionStream<'static>> {
        let steps = steps_of(surrogate.as_ref(), level)?;
        let possible = possible_of(surrogate.as_ref());
        Ok(PredictionStream { surrogate: Whose::Shared(surrogate), level, steps, possible })
    }
}

impl<'a> PredictionStream<'a> {
    /// A stream whose intervals should contain the given share (0 to 1) of the observations of new runs.
    ///
    /// # Errors
    /// If the level is not between 0 and 1, or the surrogate has a memory and does not say what it keeps of a run.
    pub fn new(surrogate: &'a dyn Surrogate, level: f64) -> Result<PredictionStream<'a>> {
        let (steps, possible) = (steps_of(surrogate, level)?, possible_of(surrogate));
        Ok(PredictionStream { surrogate: Whose::Borrowed(surrogate), level, steps, possible })
    }

    /// The prediction for the next state of the run, with a value for every input in order.
    ///
    /// # Errors
    /// If the state does not have a finite value for every input, or its prediction is not finite. The memory is then what it was before the state.
    pub fn next_state(&mut self, row: &[f64]) -> Result<Prediction> {
        let surrogate = self.surrogate.surrogate();
        let columns = surrogate.columns();
        let inputs = RunInputs::new(row.to_vec(), columns.inputs.len(), vec![1])?;
        check_inputs(surrogate.method(), columns, &inputs)?;
        let predictions = match &mut self.steps {
            Some(steps) => cut_to_possible(vec![steps.predict(row)?], |output| self.possible[output]),
            None => surrogate.predict(&inputs, self.level)?,
        };
        check_finite(surrogate.method(), columns, &inputs, &predictions)?;
        if let Some(steps) = &mut self.steps {
            steps.accept();
        }
        Ok(predictions.into_iter().next().unwrap_or_default())
    }

    /// The means of the outputs for each of several possible next states, to the bits of [`PredictionStream::next_state`] for each of them: what a difference needs, at less
    /// cost. The memory stays what it was.
    ///
    /// # Errors
    /// As [`PredictionStream::next_state`].
    pub fn means_of(&mut self, rows: &[Vec<f64>]) -> Result<Vec<Vec<f64>>> {
        let surrogate = self.surrogate.surrogate();
        let (method, columns) = (surrogate.method(), surrogate.columns());
        let inputs = RunInputs::new(rows.concat(), columns.inputs.len(), vec![1; rows.len()])?;
        check_inputs(method, columns, &inputs)?;
        let means = match &mut self.steps {
            Some(steps) => steps.means_of(rows)?,
            None => surrogate.means(&inputs)?,
        };
        if !means.iter().flatten().all(|mean| mean.is_finite()) {
            let reason = "what it predicts for one of several next states is no finite number".into();
            return Err(LearnError::Surrogate { method: method.into(), reason });
        }
        Ok(means)
    }

    /// The next state is the first of a new run.
    pub fn restart(&mut self) {
        if let Some(steps) = &mut self.steps {
            steps.restart();
        }
    }

    /// The memory before the next state, as a value; that of a surrogate without memory is always that before a first state.
    pub fn memory(&self) -> RunMemory {
        self.steps.as_ref().map_or_else(RunMemory::default, |steps| steps.memory())
    }

    /// Goes on from a memory of any stream of the same surrogate, with the same bits as that stream.
    ///
    /// ```
    /// # use granum_core::observer::NoObserver;
    /// # use granum_core::{Column, Table};
    /// # use granum_learn::surrogate::{FitSpec, PredictionStream, Recurrent, RunInputs, SurrogateMethod};
    /// # use granum_learn::{Dataset, RunStates};
    /// # let run = |k: u32| {
    /// #     let x: Vec<f64> = (0..12).map(|i| (f64::from(i * (1 + k % 4)) + f64::from(k)).sin()).collect();
    /// #     let table = Table::new(vec![Column::new("x", "", x.clone()), Column::new("y", "", x)])?;
    /// #     RunStates::new(&format!("run-{k}"), table)
    /// # };
    /// # let dataset = Dataset::new((0..4).map(run).collect::<granum_learn::Result<_>>()?)?;
    /// # let mut method = Recurrent::default();
    /// # (method.hidden, method.networks) = (4, 2);
    /// # let fitted = method.fit(&dataset, &FitSpec::new(["x"], ["y"]), &mut NoObserver)?;
    /// let mut stream = PredictionStream::new(fitted.as_ref(), 0.9)?;
    /// stream.next_state(&[-0.5])?;
    /// // A trial from here, and what the other choice would have been.
    /// let here = stream.memory();
    /// let there = stream.next_state(&[0.9])?;
    /// stream.resume(&here)?;
    /// assert_ne!(stream.next_state(&[0.1])?, there);
    /// stream.resume(&here)?;
    /// assert_eq!(stream.next_state(&[0.9])?, there);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If it is not a memory of this surrogate; the next state is then the first of a new run.
    pub fn resume(&mut self, memory: &RunMemory) -> Result<()> {
        match &mut self.steps {
            Some(steps) => steps.resume(memory),
            None if memory.is_start() => Ok(()),
            None => {
                let method = self.surrogate.surrogate().method().into();
                let reason = "it has no memory, and a memory of a run is that of another one".into();
                Err(LearnError::Surrogate { method, reason })
            }
        }
    }
}

/// The values that each output of a surrogate can have.
fn possible_of(surrogate: &dyn Surrogate) -> Vec<[f64; 2]> {
    (0..surrogate.columns().outputs.len()).map(|output| surrogate.possible_values(output)).collect()
}

/// The steps of a surrogate with memory.
fn steps_of(surrogate: &dyn Surrogate, level: f64) -> Result<Option<Box<dyn RunSteps>>> {
    check_level(surrogate.method(), level)?;
    let steps = surrogate.steps(level)?;
    if steps.is_none() && surrogate.has_memory() {
        let reason = "it has a memory, but not one that can be carried from state to state (Surrogate::steps): predict whole runs";
        return Err(LearnError::Surrogate { method: surrogate.method().into(), reason: reason.into() });
    }
    if steps.is_none() {
        // What a surrogate computes once, such as the curvature of a network, is there before the first state comes; this answer is not used.
        let columns = surrogate.columns().inputs.len();
        let _ = surrogate.evaluate(&RunInputs::separate(vec![0.0; columns], columns)?, level);
    }
    Ok(steps)
}
