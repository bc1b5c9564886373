//! A long short-term memory with a linear read-out: a model with memory.

use granum_simd::{Lanes, Row8, sigmoid, tanh};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use crate::feed_forward::network::NetworkError;
use crate::linear_algebra::kernels::Scalars;
use crate::random::uniform;
use crate::recurrent::cell_batch::{CellKernel, Work, check_sizes, check_weights, ones};
use crate::recurrent::cell_network::CellNetwork;
use crate::sequence::sequence_group::{CellSizes, Group, add, product};

/// Initial bias of the forget gates, with which a new cell remembers (Gers, Schmidhuber and Cummins 2000).
const REMEMBER: f64 = 1.0;

/// A long short-term memory (Hochreiter and Schmidhuber 1997, with the forget gate of Gers, Schmidhuber and Cummins 2000) with a
/// linear read-out. With the inputs `x_t` of a row, the state `h_t`, the cell `c_t`, and the start vector `s` of the sequence:
///
/// ```text
/// h_0 = tanh(W_h s + b_h)          c_0 = W_c s + b_c
/// i_t, f_t, o_t = sigmoid(W x_t + U h_(t-1) + b)                      input, forget and output gate
/// g_t = tanh(W_g x_t + U_g h_(t-1) + b_g)                             candidate
/// c_t = f_t * c_(t-1) + i_t * g_t
/// h_t = o_t * tanh(c_t)
/// y_t = V h_t + d
/// ```
///
/// The first row of a sequence is predicted like all others, and sequences may have any lengths. Gradients are computed by
/// back-propagation through the whole sequence. Results have the same bits with every instruction set.
///
/// ```
/// use granum_nets::trainer::{Adam, NoObserver, Trainer};
/// use granum_nets::{Data, Lstm, Sequences};
///
/// // The target is the input of three rows before.
/// let x: Vec<f64> = (0..240).map(|k| (0.9 * f64::from(k * k)).sin()).collect();
/// let y = (0..240).map(|k| if k % 12 < 3 { 0.0 } else { x[k - 3] }).collect();
/// let data = Data::new(x, 1, y)?.with_sequences(Sequences::new(vec![12; 20])?)?;
/// let mut lstm = Lstm::new(1, 0, 8, 1, 1)?;
/// let report = Adam { epochs: 300, learning_rate: 0.02, ..Adam::default() }.train(&mut lstm, &data, &mut NoObserver)?;
/// assert!(report.error.sqrt() < 0.2, "{}", report.error.sqrt());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Lstm {
    shape: LstmShape,
    weights: Vec<f64>,
}

/// The weights of an [`Lstm`] by what they are for. All weights of a neuron stand together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LstmWeights<'a> {
    /// Input gates, forget gates, candidates, then output gates: inputs, bias, state.
    pub gates: &'a [f64],
    /// The outputs: bias, state.
    pub read_out: &'a [f64],
    /// The first state, then the first cell: start values, bias.
    pub first_state: &'a [f64],
}

const NAME: &str = "long short-term memory";

/// Numbers of inputs, start values, hidden neurons and outputs. The weights of a neuron are stored together: inputs, bias, state.
/// The neurons of the input gates, forget gates, candidates and output gates come first, then the read-out, then those of the first
/// state and of the first cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct LstmShape {
    inputs: usize,
    starts: usize,
    hidden: usize,
    outputs: usize,
}

impl LstmShape {
    fn gate_row(&self) -> usize {
        self.inputs + 1 + self.hidden
    }

    fn read_out(&self) -> usize {
        4 * self.hidden * self.gate_row()
    }

    fn first_state(&self) -> usize {
        self.read_out() + self.outputs * (1 + self.hidden)
    }

    fn weights(&self) -> usize {
        self.first_state() + 2 * self.hidden * (self.starts + 1)
    }
}

impl Lstm {
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
    ) -> Result<Lstm, NetworkError> {
        let shape = LstmShape { inputs, starts, hidden, outputs };
        check_sizes(&[inputs, hidden, outputs], starts, || shape.weights())?;
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let (state, start) = (1.0 / (hidden as f64).sqrt(), 1.0 / ((starts + 1) as f64).sqrt());
        let magnitude = |place: usize| if place < shape.first_state() { state } else { start };
        let mut weights: Vec<f64> =
            (0..shape.weights()).map(|place| magnitude(place) * uniform(&mut random)).collect();
        for neuron in hidden..2 * hidden {
            weights[neuron * shape.gate_row() + inputs] += REMEMBER;
        }
        Ok(Lstm { shape, weights })
    }

    /// A cell with given weights in the order of [`Differentiable::weights`](crate::Differentiable::weights).
    ///
    /// # Errors
    /// As [`Lstm::new`], and if the number of weights is wrong or a weight is not finite.
    pub fn from_weights(
        inputs: usize,
        starts: usize,
        hidden: usize,
        outputs: usize,
        weights: Vec<f64>,
    ) -> Result<Lstm, NetworkError> {
        let shape = LstmShape { inputs, starts, hidden, outputs };
        check_sizes(&[inputs, hidden, outputs], starts, || shape.weights())?;
        check_weights(NAME, shape.weights(), &weights)?;
        Ok(Lstm { shape, weights })
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
    pub fn parts(&self) -> LstmWeights<'_> {
        let (gates, rest) = self.weights.split_at(self.shape.read_out());
        let (read_out, first_state) = rest.split_at(self.shape.outputs * (1 + self.shape.hidden));
        LstmWeights { gates, read_out, first_state }
    }
}

impl CellNetwork for Lstm {
    type Cell = LstmShape;
    const NAME: &'static str = NAME;

    fn cell(&self) -> LstmShape {
        self.shape
    }

    fn cell_weights(&self) -> &[f64] {
        &self.weights
    }

    fn cell_weights_mut(&mut self) -> &mut [f64] {
        &mut self.weights
    }
}

impl CellKernel for LstmShape {
    fn sizes(&self) -> CellSizes {
        let LstmShape { inputs, starts, hidden, outputs } = *self;
        let (weights, rows) = (self.weights(), self.rows(outputs));
        CellSizes { inputs, starts, state: hidden, outputs, weights, rows }
    }

    /// Gates (input, forget, candidate, output); cells before each step; `tanh` of the cells after it; a row of ones with the
    /// states after each step.
    fn own(&self) -> Vec<usize> {
        let hidden = self.hidden;
        vec![4 * hidden, hidden, hidden, 1 + hidden]
    }

    /// With respect to the states, and to the weighted sums of the gates.
    fn derivatives(&self) -> Vec<usize> {
        vec![self.hidden, 4 * self.hidden]
    }

    /// The cells.
    fn carried(&self) -> &'static [usize] {
        &[1]
    }

    #[inline(always)]
    fn start<L: Lanes>(self, weights: &[f64], group: &mut Group, work: &mut Work) {
        let LstmShape { inputs, starts, hidden, .. } = self;
        let Group { layout, below, starts: start_rows, .. } = group;
        let [_, before, ..] = &mut work.own[..] else { return };
        let (stride, (_, all)) = (layout.stride, layout.step(0));
        let state = (inputs + 1) * stride;
        let first = Scalars { values: &weights[self.first_state()..], by_k: 1, by_j: starts + 1 };
        product::<L>(
            first,
            2 * hidden,
            starts + 1,
            start_rows,
            layout.start_stride,
            0,
            all,
            #[inline(always)]
            |j, b, sum| match j < hidden {
                true => tanh(sum).store(&mut below[state + j * stride + b].0),
                false => sum.store(&mut before[(j - hidden) * stride + b].0),
            },
        );
    }

    #[inline(always)]
    fn forward<L: Lanes>(self, weights: &[f64], group: &mut Group, work: &mut Work) {
        let LstmShape { inputs, hidden, outputs, .. } = self;
        let Group { layout, below, .. } = group;
        let Work { outputs: results, own, .. } = work;
        let [gates, before, bounded, after] = &mut own[..] else { return };
        let stride = layout.stride;
        let state = (inputs + 1) * stride;
        ones(&mut after[..stride]);
        let row = self.gate_row();
        for step in 0..layout.steps() {
            let (first, width) = layout.step(step);
            product::<L>(
                Scalars { values: weights, by_k: 1, by_j: row },
                4 * hidden,
                row,
                below,
                stride,
                first,
                width,
                #[inline(always)]
                |j, b, sum| sum.store(&mut gates[j * stride + b].0),
            );
            let next = layout.next(step);
            for j in 0..hidden {
                for b in 0..width {
                    let at = |part: usize| (part * hidden + j) * stride + first + b;
                    let open = sigmoid(L::load(&gates[at(0)].0));
                    let kept = sigmoid(L::load(&gates[at(1)].0));
                    let candidate = tanh(L::load(&gates[at(2)].0));
                    let shown = sigmoid(L::load(&gates[at(3)].0));
                    let cell = kept.mul_add(L::load(&before[at(0)].0), open * candidate);
                    let limited = tanh(cell);
                    let value = shown * limited;
                    open.store(&mut gates[at(0)].0);
                    kept.store(&mut gates[at(1)].0);
                    candidate.store(&mut gates[at(2)].0);
                    shown.store(&mut gates[at(3)].0);
                    limited.store(&mut bounded[at(0)].0);
                    value.store(&mut after[(1 + j) * stride + first + b].0);
                    if b < next.1 {
                        value.store(&mut below[state + j * stride + next.0 + b].0);
                        cell.store(&mut before[j * stride + next.0 + b].0);
                    }
                }
            }
        }
        let read_out = Scalars { values: &weights[self.read_out()..], by_k: 1, by_j: 1 + hidden };
        product::<L>(
            read_out,
            outputs,
            1 + hidden,
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
        let LstmShape { inputs, starts, hidden, outputs } = self;
        let Group { layout, below, starts: start_rows, .. } = group;
        let Work { output_deltas, own, derivatives, carried, .. } = work;
        let ([gates, before, bounded, after], [state_deltas, deltas]) = (&own[..], &mut derivatives[..])
        else {
            return;
        };
        let (stride, start_stride, one) = (layout.stride, layout.start_stride, L::splat(1.0));
        let state = (inputs + 1) * stride;
        // The derivatives with respect to the first states, and those with respect to the cells, which are carried on.
        let (start_deltas, cell_deltas) = carried.split_at_mut(hidden * start_stride);
        cell_deltas.fill(Row8::default());
        let read_out = Scalars { values: &weights[self.read_out() + 1..], by_k: 1 + hidden, by_j: 1 };
        product::<L>(
            read_out,
            hidden,
            outputs,
            output_deltas,
            stride,
            0,
            layout.total(),
            #[inline(always)]
            |j, b, sum| sum.store(&mut state_deltas[j * stride + b].0),
        );
        let row = self.gate_row();
        for step in (0..layout.steps()).rev() {
            let (first, width) = layout.step(step);
            for j in 0..hidden {
                for b in 0..width {
                    let at = |part: usize| (part * hidden + j) * stride + first + b;
                    let delta = L::load(&state_deltas[at(0)].0);
                    let open = L::load(&gates[at(0)].0);
                    let kept = L::load(&gates[at(1)].0);
                    let candidate = L::load(&gates[at(2)].0);
                    let shown = L::load(&gates[at(3)].0);
                    let limited = L::load(&bounded[at(0)].0);
                    let old = L::load(&before[at(0)].0);
                    let carried = &mut cell_deltas[j * start_stride + b].0;
                    let slope = (-limited).mul_add(limited, one);
                    let cell = (delta * shown).mul_add(slope, L::load(carried));
                    (cell * candidate * (-open).mul_add(open, open)).store(&mut deltas[at(0)].0);
                    (cell * old * (-kept).mul_add(kept, kept)).store(&mut deltas[at(1)].0);
                    (cell * open * (-candidate).mul_add(candidate, one)).store(&mut deltas[at(2)].0);
                    (delta * limited * (-shown).mul_add(shown, shown)).store(&mut deltas[at(3)].0);
                    (cell * kept).store(carried);
                }
            }
            product::<L>(
                Scalars { values: &weights[inputs + 1..], by_k: row, by_j: 1 },
                hidden,
                4 * hidden,
                deltas,
                stride,
                first,
                width,
                #[inline(always)]
                |j, b, sum| {
                    if step == 0 {
                        let value = L::load(&below[state + j * stride + b].0);
                        (sum * (-value).mul_add(value, one)).store(&mut start_deltas[j * start_stride + b].0);
                    } else {
                        let place = layout.offsets[step - 1] + b - first;
                        let entry = &mut state_deltas[j * stride + place].0;
                        (L::load(entry) + sum).store(entry);
                    }
                },
            );
        }
        let total = layout.total();
        add::<L>(deltas, 4 * hidden, below, row, 0, stride, total, gradient);
        add::<L>(output_deltas, outputs, after, 1 + hidden, self.read_out(), stride, total, gradient);
        let (width, at, all) = (starts + 1, self.first_state(), layout.step(0).1);
        add::<L>(carried, 2 * hidden, start_rows, width, at, start_stride, all, gradient);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recurrent::cell_tests::{self, cases, data};
    use crate::{Data, Differentiable, Isa};

    /// The equations of the documentation, row by row.
    fn by_hand(lstm: &Lstm, data: &Data) -> Vec<f64> {
        let LstmShape { inputs, starts, hidden, outputs } = lstm.shape;
        let (shape, w) = (lstm.shape, &lstm.weights);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let sigmoid = |x: f64| 1.0 / (1.0 + (-x).exp());
        let sequences = data.sequences().unwrap();
        let mut predictions = Vec::new();
        for (k, rows) in sequences.ranges().into_iter().enumerate() {
            let start = &sequences.starts()[k * starts..(k + 1) * starts];
            let first = |j: usize| {
                let row = &w[shape.first_state() + j * (starts + 1)..][..starts + 1];
                dot(&row[..starts], start) + row[starts]
            };
            let mut h: Vec<f64> = (0..hidden).map(|j| first(j).tanh()).collect();
            let mut c: Vec<f64> = (hidden..2 * hidden).map(first).collect();
            for r in rows {
                let x = &data.inputs()[r * inputs..(r + 1) * inputs];
                let sum = |part: usize, j: usize| {
                    let row = &w[(part * hidden + j) * shape.gate_row()..][..shape.gate_row()];
                    dot(&row[..inputs], x) + row[inputs] + dot(&row[inputs + 1..], &h)
                };
                let all: Vec<[f64; 4]> = (0..hidden).map(|j| [0, 1, 2, 3].map(|part| sum(part, j))).collect();
                for (j, [i, f, g, o]) in all.into_iter().enumerate() {
                    c[j] = sigmoid(f) * c[j] + sigmoid(i) * g.tanh();
                    h[j] = sigmoid(o) * c[j].tanh();
                }
                predictions.extend((0..outputs).map(|o| {
                    let row = &w[shape.read_out() + o * (1 + hidden)..][..1 + hidden];
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
            let lstm = Lstm::new(3, 2, 7, 2, 5).unwrap();
            let predictions = lstm.evaluate(Isa::detect(), data.inputs(), data.sequences()).unwrap();
            for (ours, expected) in predictions.iter().zip(by_hand(&lstm, &data)) {
                assert!((ours - expected).abs() < 1e-13, "{ours} {expected}");
            }
        }
    }

    #[test]
    fn gradients_and_bits() {
        for starts in [0, 2] {
            cell_tests::check(&Lstm::new(2, starts, 3, 2, 8).unwrap(), starts);
        }
        let error = Lstm::from_weights(1, 0, 2, 1, vec![0.0; 3]).unwrap_err().to_string();
        assert!(error.contains("needs 39 weights, not 3"), "{error}");
        assert!(Lstm::new(1, 0, 0, 1, 1).is_err());
    }
}
