//! A gated recurrent unit with a linear read-out: a model with memory.

use granum_simd::Isa;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use crate::differentiable::check_columns;
use crate::differentiable::{Batch, Differentiable};
use crate::feed_forward::network::{LARGEST_LAYER, MOST_WEIGHTS, NetworkError};
use crate::random::uniform;
use crate::recurrent::gru_batch::GruBatch;
use crate::recurrent::gru_shape::GruShape;
use crate::sequence::sequence_group::SequenceRows;
use crate::sequence::stepper::{Stepper, Steps};
use crate::table::data::Data;
use crate::table::sequences::Sequences;
use crate::training_error::TrainingError;

/// Initial bias of the update gates, with which a new cell remembers (Jozefowicz, Zaremba and Sutskever 2015).
const REMEMBER: f64 = 1.0;

/// A gated recurrent unit (Cho et al. 2014, with the reset gate behind the product as in common libraries) with a linear
/// read-out. With the inputs `x_t` of a row, the state `h_t`, and the start vector `s` of the sequence:
///
/// ```text
/// h_0 = tanh(W_0 s + b_0)
/// r_t = sigmoid(W_r x_t + U_r h_(t-1) + b_r)                          reset gate
/// z_t = sigmoid(W_z x_t + U_z h_(t-1) + b_z)                          update gate
/// n_t = tanh(W_n x_t + b_n + r_t * (U_n h_(t-1) + c_n))               candidate
/// h_t = (1 - z_t) * n_t + z_t * h_(t-1)
/// y_t = V h_t + d
/// ```
///
/// The first row of a sequence is predicted like all others, and sequences may have any lengths. Gradients are computed by
/// back-propagation through the whole sequence. Results have the same bits with every instruction set.
///
/// ```
/// use granum_nets::trainer::{Adam, NoObserver, Trainer};
/// use granum_nets::{Data, Gru, Sequences};
///
/// // The target is the sum of all inputs so far, which no function of the present input gives.
/// let inputs: Vec<f64> = (0..200).map(|k| (0.7 * f64::from(k)).sin()).collect();
/// let sums = inputs.chunks(10).flat_map(|run| {
///     run.iter().scan(0.0, |sum, x| {
///         *sum += 0.3 * x;
///         Some(*sum)
///     })
/// });
/// let data = Data::new(inputs.clone(), 1, sums.collect())?.with_sequences(Sequences::new(vec![10; 20])?)?;
/// let mut gru = Gru::new(1, 0, 8, 1, 1)?;
/// let trainer = Adam { epochs: 200, learning_rate: 0.02, ..Adam::default() };
/// let report = trainer.train(&mut gru, &data, &mut NoObserver)?;
/// assert!(report.error.sqrt() < 0.05, "{}", report.error.sqrt());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Gru {
    shape: GruShape,
    weights: Vec<f64>,
}

/// The weights of a [`Gru`] by what they are for. All weights of a neuron stand together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GruWeights<'a> {
    /// Reset gates, then update gates: inputs, bias, state.
    pub gates: &'a [f64],
    /// The part of the candidates from the inputs: inputs, bias.
    pub candidate_inputs: &'a [f64],
    /// The part of the candidates from the state: bias, state.
    pub candidate_state: &'a [f64],
    /// The outputs: bias, state.
    pub read_out: &'a [f64],
    /// The first state: start values, bias.
    pub first_state: &'a [f64],
}

impl Gru {
    /// A cell with the given numbers of inputs, start values, hidden neurons and outputs, with random weights from the seed:
    /// uniform with the magnitude `1 / sqrt(hidden)`, those of the first state with `1 / sqrt(starts + 1)`.
    ///
    /// # Errors
    /// If there is no input, hidden neuron or output, or there are too many.
    pub fn new(
        inputs: usize,
        starts: usize,
        hidden: usize,
        outputs: usize,
        seed: u64,
    ) -> Result<Gru, NetworkError> {
        let shape = checked(inputs, starts, hidden, outputs)?;
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let (state, start) = (1.0 / (hidden as f64).sqrt(), 1.0 / ((starts + 1) as f64).sqrt());
        let magnitude = |place: usize| if place < shape.first_state() { state } else { start };
        let mut weights: Vec<f64> =
            (0..shape.weights()).map(|place| magnitude(place) * uniform(&mut random)).collect();
        for neuron in hidden..2 * hidden {
            weights[neuron * shape.gate_row() + inputs] += REMEMBER;
        }
        Ok(Gru { shape, weights })
    }

    /// A cell with given weights in the order of [`Differentiable::weights`].
    ///
    /// # Errors
    /// As [`Gru::new`], and if the number of weights is wrong or a weight is not finite.
    pub fn from_weights(
        inputs: usize,
        starts: usize,
        hidden: usize,
        outputs: usize,
        weights: Vec<f64>,
    ) -> Result<Gru, NetworkError> {
        let shape = checked(inputs, starts, hidden, outputs)?;
        if weights.len() != shape.weights() {
            let (needed, found) = (shape.weights(), weights.len());
            let text = format!(
                "a recurrent unit with {inputs} inputs, {starts} start values, {hidden} hidden neurons and {outputs} outputs \
                 needs {needed} weights, not {found}"
            );
            return Err(NetworkError::GivenWeights(text));
        }
        if let Some(place) = weights.iter().position(|weight| !weight.is_finite()) {
            let text = format!("weight {place} is {}, which is not a finite number", weights[place]);
            return Err(NetworkError::GivenWeights(text));
        }
        Ok(Gru { shape, weights })
    }

    /// Number of hidden neurons.
    pub fn hidden(&self) -> usize {
        self.shape.hidden
    }

    /// Number of start values of a sequence.
    pub fn starts(&self) -> usize {
        self.shape.starts
    }

    /// The weights by what they are for, each a row for each neuron.
    pub fn parts(&self) -> GruWeights<'_> {
        let GruShape { inputs, hidden, .. } = self.shape;
        let (gates, rest) = self.weights.split_at(2 * hidden * self.shape.gate_row());
        let (candidate_inputs, rest) = rest.split_at(hidden * (inputs + 1));
        let (candidate_state, rest) = rest.split_at(hidden * self.shape.state_row());
        let (read_out, first_state) = rest.split_at(self.shape.outputs * self.shape.state_row());
        GruWeights { gates, candidate_inputs, candidate_state, read_out, first_state }
    }

    fn check_sequences<'a>(&self, sequences: Option<&'a Sequences>) -> Result<&'a Sequences, TrainingError> {
        let refused = |text: String| Err(TrainingError::Rows(text));
        let Some(sequences) = sequences else {
            return refused("a recurrent unit needs rows that are divided into sequences".into());
        };
        if sequences.start_columns() != self.shape.starts {
            return refused(format!(
                "the recurrent unit has {} start values, the sequences have {}",
                self.shape.starts,
                sequences.start_columns()
            ));
        }
        Ok(sequences)
    }
}

fn checked(inputs: usize, starts: usize, hidden: usize, outputs: usize) -> Result<GruShape, NetworkError> {
    for (layer, neurons) in [inputs, hidden, outputs].into_iter().enumerate() {
        if neurons == 0 || neurons > LARGEST_LAYER {
            return Err(NetworkError::Neurons { layer, neurons });
        }
    }
    let shape = GruShape { inputs, starts, hidden, outputs };
    if starts > LARGEST_LAYER || shape.weights() > MOST_WEIGHTS {
        return Err(NetworkError::Weights(shape.weights()));
    }
    Ok(shape)
}

impl Differentiable for Gru {
    fn name(&self) -> &str {
        "gated recurrent unit"
    }

    fn inputs(&self) -> usize {
        self.shape.inputs
    }

    fn outputs(&self) -> usize {
        self.shape.outputs
    }

    fn weights(&self) -> &[f64] {
        &self.weights
    }

    fn weights_mut(&mut self) -> &mut [f64] {
        &mut self.weights
    }

    fn evaluate(
        &self,
        isa: Isa,
        inputs: &[f64],
        sequences: Option<&Sequences>,
    ) -> Result<Vec<f64>, TrainingError> {
        let sequences = self.check_sequences(sequences)?;
        if inputs.len() != sequences.rows() * self.shape.inputs {
            return Err(TrainingError::Rows(format!(
                "{} rows of {} inputs are needed, not {} values",
                sequences.rows(),
                self.shape.inputs,
                inputs.len()
            )));
        }
        let rows = SequenceRows { inputs, sequences, targets: None, weights: None };
        GruBatch::new(isa, self.shape, &rows).map(|mut batch| batch.evaluate(&self.weights))
    }

    fn stepper(&self, isa: Isa, sequences: usize, starts: &[f64]) -> Result<Box<dyn Stepper>, TrainingError> {
        let rows = GruBatch::of_next_rows(isa, self.shape, sequences, starts)?;
        Ok(Box::new(Steps::new(rows, sequences, &self.weights)))
    }

    fn batch(&self, isa: Isa, data: &Data) -> Result<Box<dyn Batch>, TrainingError> {
        check_columns(self, data)?;
        let sequences = self.check_sequences(data.sequences())?;
        let (targets, weights) = (Some(data.targets()), data.weights());
        let rows = SequenceRows { inputs: data.inputs(), sequences, targets, weights };
        Ok(Box::new(GruBatch::new(isa, self.shape, &rows)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sequences of different lengths, with start vectors and targets.
    fn data(lengths: &[usize], shape: [usize; 3]) -> Data {
        let [inputs, starts, outputs] = shape;
        let rows: usize = lengths.iter().sum();
        let wave = |k: usize, phase: f64| (1.7 * k as f64 + phase).sin();
        let starts_of = (0..lengths.len() * starts).map(|k| wave(k, 0.9)).collect();
        let sequences = Sequences::new(lengths.to_vec()).unwrap().with_starts(starts_of, starts).unwrap();
        let targets = (0..rows * outputs).map(|k| 0.5 * wave(k, 0.4)).collect();
        let weights = (0..rows).map(|k| 1.0 + (k % 3) as f64).collect();
        Data::with_target_columns(
            (0..rows * inputs).map(|k| wave(k, 0.0)).collect(),
            inputs,
            targets,
            outputs,
        )
        .and_then(|data| data.with_weights(weights))
        .and_then(|data| data.with_sequences(sequences))
        .unwrap()
    }

    /// The equations of the documentation, row by row.
    fn by_hand(gru: &Gru, data: &Data) -> Vec<f64> {
        let GruShape { inputs, starts, hidden, outputs } = gru.shape;
        let (shape, w) = (gru.shape, &gru.weights);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let sigmoid = |x: f64| 1.0 / (1.0 + (-x).exp());
        let sequences = data.sequences().unwrap();
        let mut predictions = Vec::new();
        for (k, rows) in sequences.ranges().into_iter().enumerate() {
            let start = &sequences.starts()[k * starts..(k + 1) * starts];
            let first = |j: usize| {
                let row = &w[shape.first_state() + j * (starts + 1)..][..starts + 1];
                (dot(&row[..starts], start) + row[starts]).tanh()
            };
            let mut h: Vec<f64> = (0..hidden).map(first).collect();
            for r in rows {
                let x = &data.inputs()[r * inputs..(r + 1) * inputs];
                let gate = |j: usize| {
                    let row = &w[j * shape.gate_row()..][..shape.gate_row()];
                    sigmoid(dot(&row[..inputs], x) + row[inputs] + dot(&row[inputs + 1..], &h))
                };
                let next = |j: usize| {
                    let (reset, update) = (gate(j), gate(hidden + j));
                    let row = &w[shape.candidate_inputs() + j * (inputs + 1)..][..inputs + 1];
                    let own = &w[shape.candidate_state() + j * shape.state_row()..][..shape.state_row()];
                    let n =
                        (dot(&row[..inputs], x) + row[inputs] + reset * (own[0] + dot(&own[1..], &h))).tanh();
                    (1.0 - update) * n + update * h[j]
                };
                h = (0..hidden).map(next).collect();
                predictions.extend((0..outputs).map(|o| {
                    let row = &w[shape.read_out() + o * shape.state_row()..][..shape.state_row()];
                    row[0] + dot(&row[1..], &h)
                }));
            }
        }
        predictions
    }

    /// Lengths that fill less than one lane, several lane blocks, and more than one group.
    fn cases() -> Vec<Vec<usize>> {
        vec![vec![4], vec![1, 5, 3], (0..19).map(|k| 1 + (7 * k) % 6).collect(), vec![2; 70]]
    }

    #[test]
    fn outputs_are_those_of_the_equations() {
        for lengths in cases() {
            let data = data(&lengths, [3, 2, 2]);
            let gru = Gru::new(3, 2, 7, 2, 5).unwrap();
            let predictions = gru.evaluate(Isa::detect(), data.inputs(), data.sequences()).unwrap();
            for (ours, expected) in predictions.iter().zip(by_hand(&gru, &data)) {
                assert!((ours - expected).abs() < 1e-13, "{ours} {expected}");
            }
            let error: f64 = predictions
                .iter()
                .zip(data.targets())
                .enumerate()
                .map(|(k, (y, t))| data.weights().unwrap()[k / 2] * (y - t) * (y - t))
                .sum();
            let ours = gru.batch(Isa::detect(), &data).unwrap().squared_error(gru.weights());
            assert!((ours / error - 1.0).abs() < 1e-12, "{ours} {error}");
        }
    }

    #[test]
    fn gradients_agree_with_finite_differences() {
        for lengths in cases() {
            for starts in [0, 2] {
                let data = data(&lengths, [2, starts, 2]);
                let gru = Gru::new(2, starts, 3, 2, 8).unwrap();
                let mut batch = gru.batch(Isa::detect(), &data).unwrap();
                let mut weights = gru.weights().to_vec();
                let mut gradient = vec![f64::NAN; weights.len()];
                batch.squared_error(&weights);
                batch.gradient(&weights, 2.0, &mut gradient);
                let scale = gradient.iter().fold(1.0, |most: f64, g| most.max(g.abs()));
                for k in 0..weights.len() {
                    let (h, before) = (1e-5, weights[k]);
                    let mut at = |value: f64| {
                        weights[k] = value;
                        batch.squared_error(&weights)
                    };
                    let difference = (at(before + h) - at(before - h)) / (2.0 * h);
                    weights[k] = before;
                    let error = (gradient[k] - difference).abs();
                    assert!(error < 1e-7 * scale, "{lengths:?} {k}: {} {difference}", gradient[k]);
                }
            }
        }
    }

    #[test]
    fn every_instruction_set_gives_the_same_bits() {
        for lengths in cases() {
            let data = data(&lengths, [3, 1, 2]);
            let gru = Gru::new(3, 1, 9, 2, 3).unwrap();
            let all = |isa: Isa| {
                let mut batch = gru.batch(isa, &data).unwrap();
                let mut gradient = vec![0.0; gru.weights().len()];
                let error = batch.squared_error(gru.weights());
                batch.gradient(gru.weights(), 0.3, &mut gradient);
                (error, gradient, gru.evaluate(isa, data.inputs(), data.sequences()).unwrap())
            };
            let reference = all(Isa::Portable);
            for isa in Isa::ALL.into_iter().filter(|isa| isa.available()) {
                assert_eq!(all(isa), reference, "{}", isa.name());
            }
        }
    }

    /// The prediction for a sequence depends on nothing but the sequence: neither on its neighbours nor on their lengths.
    #[test]
    fn sequences_do_not_disturb_each_other() {
        let data = data(&[5, 2, 9, 1, 3, 8, 4, 4, 7, 6], [2, 1, 1]);
        let gru = Gru::new(2, 1, 5, 1, 3).unwrap();
        let together = gru.evaluate(Isa::detect(), data.inputs(), data.sequences()).unwrap();
        for (member, rows) in data.sequences().unwrap().ranges().into_iter().enumerate() {
            let own = data.only_members(&[member]).unwrap();
            let alone = gru.evaluate(Isa::detect(), own.inputs(), own.sequences()).unwrap();
            assert_eq!(alone, together[rows]);
        }
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        assert!(Gru::new(0, 1, 3, 1, 1).is_err() && Gru::new(1, 1, 0, 1, 1).is_err());
        assert!(Gru::new(1, 1, 4000, 1, 1).is_err());
        assert!(Gru::from_weights(1, 1, 3, 1, vec![0.0; 3]).is_err());
        let gru = Gru::new(2, 1, 3, 1, 1).unwrap();
        let count = gru.weights().len();
        assert_eq!(Gru::from_weights(2, 1, 3, 1, gru.weights().to_vec()).unwrap(), gru);
        assert!(Gru::from_weights(2, 1, 3, 1, vec![f64::NAN; count]).is_err());
        let data = data(&[3, 2], [2, 1, 1]);
        let message = |result: Result<Vec<f64>, TrainingError>| result.unwrap_err().to_string();
        assert!(message(gru.evaluate(Isa::detect(), data.inputs(), None)).contains("divided into sequences"));
        let bare = Sequences::new(vec![3, 2]).unwrap();
        let text = message(gru.evaluate(Isa::detect(), data.inputs(), Some(&bare)));
        assert_eq!(text, "the recurrent unit has 1 start values, the sequences have 0");
        assert!(
            message(gru.evaluate(Isa::detect(), &[0.0; 9], data.sequences())).contains("5 rows of 2 inputs")
        );
    }
}
