//! A state-space network: a small network gives the change of a state for an increment, and the state is what is predicted.

use granum_simd::{Lanes, tanh};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use crate::feed_forward::network::NetworkError;
use crate::linear_algebra::kernels::Scalars;
use crate::random::uniform;
use crate::recurrent::cell_batch::{CellKernel, Work, check_sizes, check_weights, ones};
use crate::recurrent::cell_network::CellNetwork;
use crate::sequence::sequence_group::{CellSizes, Group, add, below_tanh, product};

/// A network that advances a state `z` of measured quantities and further, internal ones. With the inputs `x_t` of a row, the first
/// of which is the length `l_t` of the increment, and the start vector `s` of the sequence, whose first values are the measured
/// quantities before the first row:
///
/// ```text
/// z_0 = (s_1 ... s_outputs, W_0 s + b_0)
/// a_t = tanh(W x_t + U z_(t-1) + b)
/// z_t = z_(t-1) + l_t (V a_t + d)
/// y_t = the first values of z_t
/// ```
///
/// Nothing changes in an increment of length zero, whatever the weights are, and the prediction starts from what was measured. All
/// measured quantities are predicted freely: from the predicted, not the measured state of the row before. Gradients are computed by
/// back-propagation through the whole sequence. Results have the same bits with every instruction set.
///
/// ```
/// use granum_nets::trainer::{Adam, NoObserver, Trainer};
/// use granum_nets::{Data, Sequences, StateSpace};
///
/// // A material that yields: dy = l (1 - y), from any y.
/// let starts: Vec<f64> = (0..16).map(|k| f64::from(k) / 16.0).collect();
/// let y = starts.iter().flat_map(|start| (1..=20).map(move |k| 1.0 - (1.0 - start) * 0.9f64.powi(k)));
/// let sequences = Sequences::new(vec![20; 16])?.with_starts(starts.clone(), 1)?;
/// let data = Data::new(vec![0.1; 320], 1, y.collect())?.with_sequences(sequences)?;
/// let mut network = StateSpace::new(1, 1, 4, 0, 1, 1)?;
/// let report = Adam { epochs: 200, learning_rate: 0.02, ..Adam::default() }.train(&mut network, &data, &mut NoObserver)?;
/// assert!(report.error.sqrt() < 0.02, "{}", report.error.sqrt());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct StateSpace {
    shape: Shape,
    weights: Vec<f64>,
}

/// The weights of a [`StateSpace`] by what they are for. All weights of a neuron stand together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateSpaceWeights<'a> {
    /// The hidden neurons: inputs, bias, state.
    pub hidden: &'a [f64],
    /// The changes of the state: bias, hidden neurons.
    pub changes: &'a [f64],
    /// The internal values before the first row: start values, bias.
    pub first_internal: &'a [f64],
}

const NAME: &str = "state-space network";

/// Numbers of inputs, start values, hidden neurons, internal values of the state, and outputs. The weights of a neuron are stored
/// together: inputs, bias, state for the hidden neurons, then bias, hidden neurons for the changes of the state, then start values,
/// bias for the internal values before the first row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shape {
    inputs: usize,
    starts: usize,
    hidden: usize,
    internal: usize,
    outputs: usize,
}

impl Shape {
    fn new(sizes: [usize; 5]) -> Result<Shape, NetworkError> {
        let [inputs, starts, hidden, internal, outputs] = sizes;
        let shape = Shape { inputs, starts, hidden, internal, outputs };
        check_sizes(&[inputs, hidden, outputs, shape.state()], starts, || shape.weights())?;
        if starts < outputs {
            let text = format!(
                "a {NAME} with {outputs} outputs needs their first values: {starts} start values are too few"
            );
            return Err(NetworkError::GivenWeights(text));
        }
        Ok(shape)
    }

    fn state(&self) -> usize {
        self.outputs + self.internal
    }

    fn hidden_row(&self) -> usize {
        self.inputs + 1 + self.state()
    }

    fn changes(&self) -> usize {
        self.hidden * self.hidden_row()
    }

    fn first_state(&self) -> usize {
        self.changes() + self.state() * (1 + self.hidden)
    }

    fn weights(&self) -> usize {
        self.first_state() + self.internal * (self.starts + 1)
    }
}

impl StateSpace {
    /// A network with the given numbers of inputs, start values, hidden neurons, internal values of the state, and outputs, with
    /// random weights from the seed: uniform with the magnitude `1 / sqrt(n)` for neurons with n weights.
    ///
    /// # Errors
    /// If there is no input, hidden neuron or output, there are too many, or fewer start values than outputs.
    pub fn new(
        inputs: usize,
        starts: usize,
        hidden: usize,
        internal: usize,
        outputs: usize,
        seed: u64,
    ) -> Result<StateSpace, NetworkError> {
        let shape = Shape::new([inputs, starts, hidden, internal, outputs])?;
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let magnitude = |place: usize| {
            let row = match place {
                place if place < shape.changes() => shape.hidden_row(),
                place if place < shape.first_state() => 1 + hidden,
                _ => starts + 1,
            };
            1.0 / (row as f64).sqrt()
        };
        let weights = (0..shape.weights()).map(|place| magnitude(place) * uniform(&mut random)).collect();
        Ok(StateSpace { shape, weights })
    }

    /// A network with given weights in the order of [`Differentiable::weights`](crate::Differentiable::weights); `sizes` are the numbers in the order of
    /// [`StateSpace::new`].
    ///
    /// # Errors
    /// As [`StateSpace::new`], and if the number of weights is wrong or a weight is not finite.
    pub fn from_weights(sizes: [usize; 5], weights: Vec<f64>) -> Result<StateSpace, NetworkError> {
        let shape = Shape::new(sizes)?;
        check_weights(NAME, shape.weights(), &weights)?;
        Ok(StateSpace { shape, weights })
    }

    /// Number of hidden neurons.
    pub fn hidden(&self) -> usize {
        self.shape.hidden
    }

    /// Number of internal values of the state.
    pub fn internal(&self) -> usize {
        self.shape.internal
    }

    /// Number of start values of a sequence.
    pub fn starts(&self) -> usize {
        self.shape.starts
    }

    /// The weights by what they are for, each a row for each neuron.
    pub fn parts(&self) -> StateSpaceWeights<'_> {
        let (neurons, first_internal) = self.weights.split_at(self.shape.first_state());
        let (hidden, changes) = neurons.split_at(self.shape.changes());
        StateSpaceWeights { hidden, changes, first_internal }
    }
}

impl CellNetwork for StateSpace {
    type Cell = Shape;
    const NAME: &'static str = NAME;

    fn cell(&self) -> Shape {
        self.shape
    }

    fn cell_weights(&self) -> &[f64] {
        &self.weights
    }

    fn cell_weights_mut(&mut self) -> &mut [f64] {
        &mut self.weights
    }
}

impl CellKernel for Shape {
    fn sizes(&self) -> CellSizes {
        let Shape { inputs, starts, outputs, .. } = *self;
        let (state, weights, rows) = (self.state(), self.weights(), self.rows(outputs));
        CellSizes { inputs, starts, state, outputs, weights, rows }
    }

    /// A row of ones with the hidden neurons.
    fn own(&self) -> Vec<usize> {
        vec![1 + self.hidden]
    }

    /// With respect to the states after each step, to the rates of change, and to the weighted sums of the hidden neurons.
    fn derivatives(&self) -> Vec<usize> {
        vec![self.state(), self.state(), self.hidden]
    }

    #[inline(always)]
    fn start<L: Lanes>(self, weights: &[f64], group: &mut Group, _: &mut Work) {
        let Shape { inputs, starts, internal, outputs, .. } = self;
        let Group { layout, below, starts: start_rows, .. } = group;
        let (stride, start_stride, (_, all)) = (layout.stride, layout.start_stride, layout.step(0));
        let place = inputs + 1;
        for j in 0..outputs {
            for b in 0..all {
                below[(place + j) * stride + b] = start_rows[j * start_stride + b];
            }
        }
        product::<L>(
            Scalars { values: &weights[self.first_state()..], by_k: 1, by_j: starts + 1 },
            internal,
            starts + 1,
            start_rows,
            start_stride,
            0,
            all,
            #[inline(always)]
            |j, b, sum| sum.store(&mut below[(place + outputs + j) * stride + b].0),
        );
    }

    #[inline(always)]
    fn forward<L: Lanes>(self, weights: &[f64], group: &mut Group, work: &mut Work) {
        let Shape { inputs, hidden, outputs, .. } = self;
        let Group { layout, below, .. } = group;
        let Work { outputs: results, own, .. } = work;
        let [neurons] = &mut own[..] else { return };
        let stride = layout.stride;
        let place = inputs + 1;
        ones(&mut neurons[..stride]);
        let row = self.hidden_row();
        for step in 0..layout.steps() {
            let (first, width) = layout.step(step);
            product::<L>(
                Scalars { values: weights, by_k: 1, by_j: row },
                hidden,
                row,
                below,
                stride,
                first,
                width,
                #[inline(always)]
                |j, b, sum| tanh(sum).store(&mut neurons[(1 + j) * stride + b].0),
            );
            let next = layout.next(step);
            product::<L>(
                Scalars { values: &weights[self.changes()..], by_k: 1, by_j: 1 + hidden },
                self.state(),
                1 + hidden,
                neurons,
                stride,
                first,
                width,
                #[inline(always)]
                |j, b, sum| {
                    let length = L::load(&below[b].0);
                    let after = length.mul_add(sum, L::load(&below[(place + j) * stride + b].0));
                    if j < outputs {
                        after.store(&mut results[j * stride + b].0);
                    }
                    if b - first < next.1 {
                        after.store(&mut below[(place + j) * stride + next.0 + b - first].0);
                    }
                },
            );
        }
    }

    #[inline(always)]
    fn backward<L: Lanes>(self, weights: &[f64], group: &Group, work: &mut Work, gradient: &mut [f64]) {
        let Shape { inputs, starts, hidden, internal, outputs } = self;
        let Group { layout, below, starts: start_rows, .. } = group;
        let Work { output_deltas, own, derivatives, carried, .. } = work;
        let ([neurons], [state_deltas, rate_deltas, deltas]) = (&own[..], &mut derivatives[..]) else {
            return;
        };
        let (stride, start_stride) = (layout.stride, layout.start_stride);
        state_deltas[outputs * stride..].fill(Default::default());
        state_deltas[..outputs * stride].copy_from_slice(&output_deltas[..outputs * stride]);
        let row = self.hidden_row();
        for step in (0..layout.steps()).rev() {
            let (first, width) = layout.step(step);
            for j in 0..self.state() {
                for b in first..first + width {
                    let delta = L::load(&state_deltas[j * stride + b].0) * L::load(&below[b].0);
                    delta.store(&mut rate_deltas[j * stride + b].0);
                }
            }
            let (changes, counts) = (&weights[self.changes()..], [hidden, self.state()]);
            below_tanh::<L>(changes, counts, rate_deltas, neurons, deltas, stride, (first, width));
            product::<L>(
                Scalars { values: &weights[inputs + 1..], by_k: row, by_j: 1 },
                self.state(),
                hidden,
                deltas,
                stride,
                first,
                width,
                #[inline(always)]
                |j, b, sum| {
                    let delta = sum + L::load(&state_deltas[j * stride + b].0);
                    if step == 0 {
                        delta.store(&mut carried[j * start_stride + b].0);
                    } else {
                        let entry = &mut state_deltas[j * stride + layout.offsets[step - 1] + b - first].0;
                        (L::load(entry) + delta).store(entry);
                    }
                },
            );
        }
        let total = layout.total();
        add::<L>(deltas, hidden, below, row, 0, stride, total, gradient);
        add::<L>(rate_deltas, self.state(), neurons, 1 + hidden, self.changes(), stride, total, gradient);
        let (width, at, all) = (starts + 1, self.first_state(), layout.step(0).1);
        let inner = &carried[outputs * start_stride..];
        add::<L>(inner, internal, start_rows, width, at, start_stride, all, gradient);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recurrent::cell_tests::{self, cases, data};
    use crate::{Data, Differentiable, Isa, Sequences};

    /// The equations of the documentation, row by row.
    fn by_hand(network: &StateSpace, data: &Data) -> Vec<f64> {
        let (shape, w) = (network.shape, &network.weights);
        let Shape { inputs, starts, hidden, internal, outputs } = shape;
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let sequences = data.sequences().unwrap();
        let mut predictions = Vec::new();
        for (k, rows) in sequences.ranges().into_iter().enumerate() {
            let start = &sequences.starts()[k * starts..(k + 1) * starts];
            let mut z = start[..outputs].to_vec();
            z.extend((0..internal).map(|j| {
                let row = &w[shape.first_state() + j * (starts + 1)..][..starts + 1];
                dot(&row[..starts], start) + row[starts]
            }));
            for r in rows {
                let x = &data.inputs()[r * inputs..(r + 1) * inputs];
                let neuron = |j: usize| {
                    let row = &w[j * shape.hidden_row()..][..shape.hidden_row()];
                    (dot(&row[..inputs], x) + row[inputs] + dot(&row[inputs + 1..], &z)).tanh()
                };
                let a: Vec<f64> = (0..hidden).map(neuron).collect();
                for (j, value) in z.iter_mut().enumerate() {
                    let row = &w[shape.changes() + j * (1 + hidden)..][..1 + hidden];
                    *value += x[0] * (row[0] + dot(&row[1..], &a));
                }
                predictions.extend_from_slice(&z[..outputs]);
            }
        }
        predictions
    }

    #[test]
    fn outputs_are_those_of_the_equations() {
        for (lengths, internal) in cases().into_iter().zip([3, 0, 2, 3]) {
            let data = data(&lengths, [3, 4, 2]);
            let network = StateSpace::new(3, 4, 7, internal, 2, 5).unwrap();
            let predictions = network.evaluate(Isa::detect(), data.inputs(), data.sequences()).unwrap();
            for (ours, expected) in predictions.iter().zip(by_hand(&network, &data)) {
                assert!((ours - expected).abs() < 1e-12, "{ours} {expected}");
            }
        }
    }

    #[test]
    fn gradients_and_bits() {
        for internal in [0, 2] {
            cell_tests::check(&StateSpace::new(2, 3, 3, internal, 2, 8).unwrap(), 3);
        }
    }

    #[test]
    fn nothing_changes_without_an_increment() {
        let network = StateSpace::new(2, 2, 5, 1, 2, 8).unwrap();
        let sequences = Sequences::new(vec![3]).unwrap().with_starts(vec![0.25, -0.5], 2).unwrap();
        let predictions =
            network.evaluate(Isa::detect(), &[0.0, 1.0, 0.0, 2.0, 0.0, -1.0], Some(&sequences)).unwrap();
        assert_eq!(predictions, [0.25, -0.5, 0.25, -0.5, 0.25, -0.5]);
        let error = StateSpace::new(2, 1, 5, 1, 2, 8).unwrap_err().to_string();
        assert!(error.contains("1 start values are too few"), "{error}");
    }
}
