//! A gated recurrent unit with a linear read-out: a model with memory.

use granum_simd::{Lanes, sigmoid, tanh};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use crate::feed_forward::network::NetworkError;
use crate::linear_algebra::kernels::Scalars;
use crate::random::uniform;
use crate::recurrent::cell_batch::{CellKernel, Work, check_sizes, check_weights, ones};
use crate::recurrent::cell_network::CellNetwork;
use crate::sequence::sequence_group::{CellSizes, Group, add, product};

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

const NAME: &str = "gated recurrent unit";

/// Numbers of inputs, start values, hidden neurons and outputs. The weights of a neuron are stored together, with its bias between
/// those of the inputs and those of the state. The neurons of the reset gates and update gates come first, then the parts of the
/// candidates from the inputs and from the state, then the read-out, then those of the first state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct GruShape {
    inputs: usize,
    starts: usize,
    hidden: usize,
    outputs: usize,
}

impl GruShape {
    fn new(inputs: usize, starts: usize, hidden: usize, outputs: usize) -> Result<GruShape, NetworkError> {
        let shape = GruShape { inputs, starts, hidden, outputs };
        check_sizes(&[inputs, hidden, outputs], starts, || shape.weights())?;
        Ok(shape)
    }

    fn gate_row(&self) -> usize {
        self.inputs + 1 + self.hidden
    }

    /// Number of weights of a neuron that receives the state: bias, state.
    fn state_row(&self) -> usize {
        1 + self.hidden
    }

    fn candidate_inputs(&self) -> usize {
        2 * self.hidden * self.gate_row()
    }

    fn candidate_state(&self) -> usize {
        self.candidate_inputs() + self.hidden * (self.inputs + 1)
    }

    fn read_out(&self) -> usize {
        self.candidate_state() + self.hidden * self.state_row()
    }

    fn first_state(&self) -> usize {
        self.read_out() + self.outputs * self.state_row()
    }

    fn weights(&self) -> usize {
        self.first_state() + self.hidden * (self.starts + 1)
    }
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
        let shape = GruShape::new(inputs, starts, hidden, outputs)?;
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

    /// A cell with given weights in the order of [`Differentiable::weights`](crate::Differentiable::weights).
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
        let shape = GruShape::new(inputs, starts, hidden, outputs)?;
        check_weights(NAME, shape.weights(), &weights)?;
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
        let shape = &self.shape;
        let (gates, rest) = self.weights.split_at(shape.candidate_inputs());
        let (candidate_inputs, rest) = rest.split_at(shape.hidden * (shape.inputs + 1));
        let (candidate_state, rest) = rest.split_at(shape.hidden * shape.state_row());
        let (read_out, first_state) = rest.split_at(shape.outputs * shape.state_row());
        GruWeights { gates, candidate_inputs, candidate_state, read_out, first_state }
    }
}

impl CellNetwork for Gru {
    type Cell = GruShape;
    const NAME: &'static str = NAME;

    fn cell(&self) -> GruShape {
        self.shape
    }

    fn cell_weights(&self) -> &[f64] {
        &self.weights
    }

    fn cell_weights_mut(&mut self) -> &mut [f64] {
        &mut self.weights
    }
}

impl CellKernel for GruShape {
    fn sizes(&self) -> CellSizes {
        let GruShape { inputs, starts, hidden, outputs } = *self;
        let (weights, rows) = (self.weights(), self.rows(outputs));
        CellSizes { inputs, starts, state: hidden, outputs, weights, rows }
    }

    /// Reset gates, update gates, candidates, and the part of the candidates that the reset gates multiply; a row of ones with the
    /// states after each step.
    fn own(&self) -> Vec<usize> {
        vec![4 * self.hidden, 1 + self.hidden]
    }

    /// With respect to the states, and to the weighted sums of the first matrix.
    fn derivatives(&self) -> Vec<usize> {
        vec![self.hidden, 4 * self.hidden]
    }

    #[inline(always)]
    fn start<L: Lanes>(self, weights: &[f64], group: &mut Group, _: &mut Work) {
        let GruShape { inputs, starts, hidden, .. } = self;
        let Group { layout, below, starts: start_rows, .. } = group;
        let (stride, (_, all)) = (layout.stride, layout.step(0));
        let state = (inputs + 1) * stride;
        product::<L>(
            Scalars { values: &weights[self.first_state()..], by_k: 1, by_j: starts + 1 },
            hidden,
            starts + 1,
            start_rows,
            layout.start_stride,
            0,
            all,
            #[inline(always)]
            |j, b, sum| tanh(sum).store(&mut below[state + j * stride + b].0),
        );
    }

    #[inline(always)]
    fn forward<L: Lanes>(self, weights: &[f64], group: &mut Group, work: &mut Work) {
        let GruShape { inputs, hidden, outputs, .. } = self;
        let Group { layout, below, .. } = group;
        let Work { outputs: results, own, .. } = work;
        let [gates, after] = &mut own[..] else { return };
        let stride = layout.stride;
        let state = (inputs + 1) * stride;
        let (gate_row, state_row) = (self.gate_row(), self.state_row());
        ones(&mut after[..stride]);
        for step in 0..layout.steps() {
            let (first, width) = layout.step(step);
            product::<L>(
                Scalars { values: weights, by_k: 1, by_j: gate_row },
                2 * hidden,
                gate_row,
                below,
                stride,
                first,
                width,
                #[inline(always)]
                |j, b, sum| sum.store(&mut gates[j * stride + b].0),
            );
            product::<L>(
                Scalars { values: &weights[self.candidate_inputs()..], by_k: 1, by_j: inputs + 1 },
                hidden,
                inputs + 1,
                below,
                stride,
                first,
                width,
                #[inline(always)]
                |j, b, sum| sum.store(&mut gates[(2 * hidden + j) * stride + b].0),
            );
            product::<L>(
                Scalars { values: &weights[self.candidate_state()..], by_k: 1, by_j: state_row },
                hidden,
                state_row,
                &below[inputs * stride..],
                stride,
                first,
                width,
                #[inline(always)]
                |j, b, sum| sum.store(&mut gates[(3 * hidden + j) * stride + b].0),
            );
            let next = layout.next(step);
            for j in 0..hidden {
                for b in 0..width {
                    let at = |part: usize| (part * hidden + j) * stride + first + b;
                    let reset = sigmoid(L::load(&gates[at(0)].0));
                    let update = sigmoid(L::load(&gates[at(1)].0));
                    let held = L::load(&gates[at(3)].0);
                    let candidate = tanh(reset.mul_add(held, L::load(&gates[at(2)].0)));
                    let before = L::load(&below[state + at(0)].0);
                    let value = update.mul_add(before - candidate, candidate);
                    reset.store(&mut gates[at(0)].0);
                    update.store(&mut gates[at(1)].0);
                    candidate.store(&mut gates[at(2)].0);
                    value.store(&mut after[(1 + j) * stride + first + b].0);
                    if b < next.1 {
                        value.store(&mut below[state + j * stride + next.0 + b].0);
                    }
                }
            }
        }
        product::<L>(
            Scalars { values: &weights[self.read_out()..], by_k: 1, by_j: state_row },
            outputs,
            state_row,
            after,
            stride,
            0,
            layout.total(),
            #[inline(always)]
            |o, b, sum| sum.store(&mut results[o * stride + b].0),
        );
    }

    #[inline(always)]
    fn backward<L: Lanes>(self, weights: &[f64], group: &Group, work: &mut Work, gradient: &mut [f64]) {
        let GruShape { inputs, starts, hidden, outputs } = self;
        let Group { layout, below, starts: start_rows, .. } = group;
        let Work { output_deltas, own, derivatives, carried, .. } = work;
        let ([gates, after], [state_deltas, deltas]) = (&own[..], &mut derivatives[..]) else { return };
        let (stride, start_stride, one) = (layout.stride, layout.start_stride, L::splat(1.0));
        let state = (inputs + 1) * stride;
        let (gate_row, state_row) = (self.gate_row(), self.state_row());
        // The derivatives with respect to the first states, and those with respect to the states before a step.
        let (start_deltas, before_deltas) = carried.split_at_mut(hidden * start_stride);
        product::<L>(
            Scalars { values: &weights[self.read_out() + 1..], by_k: state_row, by_j: 1 },
            hidden,
            outputs,
            output_deltas,
            stride,
            0,
            layout.total(),
            #[inline(always)]
            |j, b, sum| sum.store(&mut state_deltas[j * stride + b].0),
        );
        for step in (0..layout.steps()).rev() {
            let (first, width) = layout.step(step);
            for j in 0..hidden {
                for b in 0..width {
                    let at = |part: usize| (part * hidden + j) * stride + first + b;
                    let delta = L::load(&state_deltas[at(0)].0);
                    let reset = L::load(&gates[at(0)].0);
                    let update = L::load(&gates[at(1)].0);
                    let candidate = L::load(&gates[at(2)].0);
                    let held = L::load(&gates[at(3)].0);
                    let before = L::load(&below[state + at(0)].0);
                    let new = delta * (one - update) * (-candidate).mul_add(candidate, one);
                    let kept = delta * (before - candidate) * (-update).mul_add(update, update);
                    let opened = new * held * (-reset).mul_add(reset, reset);
                    opened.store(&mut deltas[at(0)].0);
                    kept.store(&mut deltas[at(1)].0);
                    new.store(&mut deltas[at(2)].0);
                    (new * reset).store(&mut deltas[at(3)].0);
                    (delta * update).store(&mut before_deltas[j * start_stride + b].0);
                }
            }
            let below_gates = Scalars { values: &weights[inputs + 1..], by_k: gate_row, by_j: 1 };
            let held_at = self.candidate_state() + 1;
            let below_held = Scalars { values: &weights[held_at..], by_k: state_row, by_j: 1 };
            // One call of the product for both, which is compiled once.
            for (scalars, depth, part) in [(below_gates, 2 * hidden, 0), (below_held, hidden, 3 * hidden)] {
                product::<L>(
                    scalars,
                    hidden,
                    depth,
                    &deltas[part * stride..],
                    stride,
                    first,
                    width,
                    #[inline(always)]
                    |j, b, sum| {
                        let entry = &mut before_deltas[j * start_stride + b - first].0;
                        (L::load(entry) + sum).store(entry);
                    },
                );
            }
            for j in 0..hidden {
                for b in 0..width {
                    let delta = L::load(&before_deltas[j * start_stride + b].0);
                    if step == 0 {
                        let value = L::load(&below[state + j * stride + b].0);
                        (delta * (-value).mul_add(value, one))
                            .store(&mut start_deltas[j * start_stride + b].0);
                    } else {
                        let entry = &mut state_deltas[j * stride + layout.offsets[step - 1] + b].0;
                        (L::load(entry) + delta).store(entry);
                    }
                }
            }
        }
        let total = layout.total();
        let [new, held] = [2, 3].map(|part| &deltas[part * hidden * stride..]);
        let (lanes, inputs_at, state_at) =
            (&below[inputs * stride..], self.candidate_inputs(), self.candidate_state());
        add::<L>(deltas, 2 * hidden, below, gate_row, 0, stride, total, gradient);
        add::<L>(new, hidden, below, inputs + 1, inputs_at, stride, total, gradient);
        add::<L>(held, hidden, lanes, state_row, state_at, stride, total, gradient);
        add::<L>(output_deltas, outputs, after, state_row, self.read_out(), stride, total, gradient);
        let (width, at, all) = (starts + 1, self.first_state(), layout.step(0).1);
        add::<L>(start_deltas, hidden, start_rows, width, at, start_stride, all, gradient);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recurrent::cell_tests::{self, cases, data};
    use crate::training_error::TrainingError;
    use crate::{Data, Differentiable, Isa, Sequences};

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
    fn gradients_and_bits() {
        // The last one has more neurons than a tile of a product is high.
        for (starts, hidden) in [(0, 3), (2, 3), (1, 9)] {
            cell_tests::check(&Gru::new(2, starts, hidden, 2, 8).unwrap(), starts);
        }
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        assert!(Gru::new(0, 1, 3, 1, 1).is_err() && Gru::new(1, 1, 0, 1, 1).is_err());
        assert!(Gru::new(1, 1, 4000, 1, 1).is_err());
        let error = Gru::from_weights(1, 1, 3, 1, vec![0.0; 3]).unwrap_err().to_string();
        assert!(error.contains("a gated recurrent unit of this size needs 58 weights, not 3"), "{error}");
        let gru = Gru::new(2, 1, 3, 1, 1).unwrap();
        let count = gru.weights().len();
        assert_eq!(Gru::from_weights(2, 1, 3, 1, gru.weights().to_vec()).unwrap(), gru);
        assert!(Gru::from_weights(2, 1, 3, 1, vec![f64::NAN; count]).is_err());
        let data = data(&[3, 2], [2, 1, 1]);
        let message = |result: Result<Vec<f64>, TrainingError>| result.unwrap_err().to_string();
        assert!(message(gru.evaluate(Isa::detect(), data.inputs(), None)).contains("divided into sequences"));
        let bare = Sequences::new(vec![3, 2]).unwrap();
        let text = message(gru.evaluate(Isa::detect(), data.inputs(), Some(&bare)));
        assert_eq!(text, "the gated recurrent unit has 1 start values, the sequences have 0");
        assert!(
            message(gru.evaluate(Isa::detect(), &[0.0; 9], data.sequences())).contains("5 rows of 2 inputs")
        );
    }
}
