//! Networks with a state whose rows come one after the other, as those of a test that is running.

use granum_simd::{LANES, Row8};

use crate::sequence::sequence_group::{CellSizes, GROUP, Layout};
use crate::training_error::TrainingError;

/// Most sequences that a [`Stepper`] advances together.
pub const MOST_SEQUENCES: usize = GROUP;

/// Sequences whose rows come one after the other, each with the state of a network.
///
/// ```
/// use granum_nets::{Differentiable, Gru, Isa, Sequences};
///
/// let gru = Gru::new(1, 1, 4, 1, 1)?;
/// let rows = [0.3, -0.2, 0.7];
/// let sequences = Sequences::new(vec![3])?.with_starts(vec![0.5], 1)?;
/// let together = gru.evaluate(Isa::detect(), &rows, Some(&sequences))?;
/// let mut stepper = gru.stepper(Isa::detect(), 1, &[0.5])?;
/// for (row, expected) in rows.iter().zip(together) {
///     let mut output = [0.0];
///     stepper.predict(&[*row], &mut output)?;
///     assert_eq!(output[0], expected);
///     stepper.accept();
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Stepper: Send + Sync {
    /// The outputs, `sequences x outputs`, for the next row of each sequence, `sequences x inputs`. The state stays what it was before these rows.
    ///
    /// # Errors
    /// If there are not so many values.
    fn predict(&mut self, inputs: &[f64], outputs: &mut [f64]) -> Result<(), TrainingError>;

    /// The state after the rows that were predicted last becomes that before the next ones.
    fn accept(&mut self);

    /// The state before the next rows as a value, sequence by sequence; empty before the first rows were accepted.
    fn state(&self) -> Vec<f64>;

    /// Goes on from a state that [`Stepper::state`] gave, of this stepper or of another one of the same network with as many sequences. The rows
    /// after it have the same bits as those after it in its own sequence. An empty state is that before the first rows, with the start values of
    /// this stepper.
    ///
    /// # Errors
    /// If there are not so many values as this network's state has, or one is not finite.
    fn set_state(&mut self, state: &[f64]) -> Result<(), TrainingError>;
}

/// The batches of a kind of network, for sequences of one row after which others follow.
pub(crate) trait NextRows: Send + Sync {
    fn sizes(&self) -> CellSizes;

    /// The outputs for rows of inputs; at the beginning of the sequences the first state is computed from their start values.
    fn advance(&mut self, weights: &[f64], begins: bool, inputs: &[f64], outputs: &mut [f64]);

    /// The state after these rows becomes that before the next ones.
    fn carry(&mut self);

    /// Number of values of the state of a sequence.
    fn state_values(&self) -> usize;

    /// The state before the next rows, sequence by sequence.
    fn state(&self) -> Vec<f64>;

    /// Sets the state before the next rows.
    fn set_state(&mut self, state: &[f64]);
}

/// A network with the states of sequences.
pub(crate) struct Steps<B> {
    rows: B,
    sequences: usize,
    weights: Vec<f64>,
    begins: bool,
    /// True if rows were predicted that have not been accepted.
    predicted: bool,
}

impl<B: NextRows> Steps<B> {
    pub(crate) fn new(rows: B, sequences: usize, weights: &[f64]) -> Steps<B> {
        Steps { rows, sequences, weights: weights.to_vec(), begins: true, predicted: false }
    }
}

impl<B: NextRows> Stepper for Steps<B> {
    fn predict(&mut self, inputs: &[f64], outputs: &mut [f64]) -> Result<(), TrainingError> {
        let CellSizes { inputs: columns, outputs: width, .. } = self.rows.sizes();
        let (needed, room) = (self.sequences * columns, self.sequences * width);
        if (inputs.len(), outputs.len()) != (needed, room) {
            let (found, given) = (inputs.len(), outputs.len());
            return Err(TrainingError::Rows(format!(
                "a step needs {needed} inputs and room for {room} outputs, not {found} and {given}"
            )));
        }
        self.rows.advance(&self.weights, self.begins, inputs, outputs);
        self.predicted = true;
        Ok(())
    }

    fn accept(&mut self) {
        if std::mem::take(&mut self.predicted) {
            self.rows.carry();
            self.begins = false;
        }
    }

    fn state(&self) -> Vec<f64> {
        if self.begins { Vec::new() } else { self.rows.state() }
    }

    fn set_state(&mut self, state: &[f64]) -> Result<(), TrainingError> {
        let needed = self.sequences * self.rows.state_values();
        if !state.is_empty() && state.len() != needed {
            let found = state.len();
            return Err(TrainingError::Rows(format!("the state has {needed} values, not {found}")));
        }
        if let Some(value) = state.iter().find(|value| !value.is_finite()) {
            return Err(TrainingError::Rows(format!("a value of the state is {value}, not a finite number")));
        }
        (self.begins, self.predicted) = (state.is_empty(), false);
        if !self.begins {
            self.rows.set_state(state);
        }
        Ok(())
    }
}

/// Puts the outputs of rows in the order of their sequences.
pub(crate) fn put_outputs(layout: &Layout, results: &[Row8], width: usize, outputs: &mut [f64]) {
    for (lane, row) in outputs.chunks_exact_mut(width).enumerate() {
        for (column, output) in row.iter_mut().enumerate() {
            *output = results[column * layout.stride + lane / LANES].0[lane % LANES];
        }
    }
}

#[cfg(test)]
mod tests {
    use granum_simd::Isa;

    use crate::{Differentiable, Gru, Lstm, Network, Sequences, StateSpace, TensorSizes, TensorStateSpace};

    /// Rows one after the other have the bits of rows together, for any number of sequences, and a row that was not accepted leaves no trace.
    fn check(network: &dyn Differentiable, starts: usize) {
        let (columns, width, steps) = (network.inputs(), network.outputs(), 7);
        for count in [1, 3, 24] {
            let wave = |k: usize, phase: f64| 0.4 * (1.3 * k as f64 + phase).sin();
            let inputs: Vec<f64> = (0..count * steps * columns).map(|k| wave(k, 0.2)).collect();
            let first: Vec<f64> = (0..count * starts).map(|k| wave(k, 0.9)).collect();
            let sequences = Sequences::new(vec![steps; count]).unwrap();
            let sequences = sequences.with_starts(first.clone(), starts).unwrap();
            for isa in Isa::ALL.into_iter().filter(|isa| isa.available()) {
                let together = network.evaluate(isa, &inputs, Some(&sequences)).unwrap();
                let mut stepper = network.stepper(isa, count, &first).unwrap();
                // Another one, which has advanced in its own way, goes on from the states of the first.
                let mut other = network.stepper(isa, count, &vec![0.3; first.len()]).unwrap();
                let mut states: Vec<(Vec<f64>, Vec<f64>, Vec<f64>)> = Vec::new();
                for step in 0..steps {
                    let of_step = |values: &[f64], width: usize| -> Vec<f64> {
                        let rows = values.chunks_exact(width).skip(step).step_by(steps);
                        rows.flatten().copied().collect()
                    };
                    let mut outputs = vec![0.0; count * width];
                    stepper.predict(&vec![0.7; count * columns], &mut outputs).unwrap();
                    stepper.predict(&of_step(&inputs, columns), &mut outputs).unwrap();
                    let before = stepper.state();
                    stepper.accept();
                    stepper.accept();
                    states.push((before, of_step(&inputs, columns), outputs.clone()));
                    let expected = of_step(&together, width);
                    let same = outputs.iter().zip(&expected).all(|(a, b)| a.to_bits() == b.to_bits());
                    assert!(same, "{} {count} {step} {isa:?}: {outputs:?} {expected:?}", network.name());
                }
                assert!(states[0].0.is_empty(), "before the first rows there is no state");
                for (state, rows, expected) in states.iter().skip(1).rev() {
                    other.set_state(state).unwrap();
                    let mut outputs = vec![0.0; count * width];
                    other.predict(rows, &mut outputs).unwrap();
                    let same = outputs.iter().zip(expected).all(|(a, b)| a.to_bits() == b.to_bits());
                    assert!(same, "{} {count} {isa:?}: {outputs:?} {expected:?}", network.name());
                    assert_eq!(&other.state(), state, "a prediction that was not accepted leaves no trace");
                    other.accept();
                }
                stepper.set_state(&[]).unwrap();
                let mut outputs = vec![0.0; count * width];
                stepper.predict(&states[0].1, &mut outputs).unwrap();
                assert_eq!(outputs, states[0].2, "an empty state is the beginning");
            }
        }
    }

    #[test]
    fn rows_one_after_the_other_have_the_bits_of_rows_together() {
        check(&Gru::new(3, 2, 9, 2, 1).unwrap(), 2);
        check(&Lstm::new(3, 2, 9, 2, 1).unwrap(), 2);
        check(&StateSpace::new(3, 4, 9, 2, 3, 1).unwrap(), 4);
        let sizes = TensorSizes {
            further: 1,
            start_scalars: 2,
            hidden: 5,
            tensors: 2,
            scalars: 1,
            internal_tensors: 1,
            internal_scalars: 1,
        };
        check(&TensorStateSpace::new(sizes, 1).unwrap(), 12);
    }

    #[test]
    fn what_cannot_be_advanced_is_refused() {
        let gru = Gru::new(3, 2, 9, 2, 1).unwrap();
        let error = |count: usize, starts: &[f64]| {
            gru.stepper(Isa::detect(), count, starts).err().map(|error| error.to_string()).unwrap_or_default()
        };
        assert!(error(1, &[0.0]).contains("2 start values"), "{}", error(1, &[0.0]));
        assert!(error(1000, &[0.0; 2000]).contains("between 1 and 64"));
        let mut stepper = gru.stepper(Isa::detect(), 1, &[0.0; 2]).unwrap();
        assert!(
            stepper.predict(&[0.0; 2], &mut [0.0; 2]).unwrap_err().to_string().contains("needs 3 inputs")
        );
        let error = |state: &[f64]| {
            let mut stepper = gru.stepper(Isa::detect(), 1, &[0.0; 2]).unwrap();
            stepper.set_state(state).err().map(|error| error.to_string()).unwrap_or_default()
        };
        assert!(error(&[0.0; 8]).contains("has 9 values, not 8"), "{}", error(&[0.0; 8]));
        assert!(error(&[f64::NAN; 9]).contains("not a finite number"), "{}", error(&[f64::NAN; 9]));
        let network = Network::new(&[3, 4, 1], 1).unwrap();
        let error = network.stepper(Isa::detect(), 1, &[]).err().unwrap().to_string();
        assert!(error.contains("no state"), "{error}");
    }
}
