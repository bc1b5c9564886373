//! Forward pass and back-propagation through time of a gated recurrent unit, for many sequences at once.

use granum_simd::{Isa, Kernel, LANES, Lanes, Row8, dispatch, sigmoid, tanh};

use crate::differentiable::Batch;
use crate::linear_algebra::kernels::Scalars;
use crate::recurrent::gru_shape::GruShape;
use crate::sequence::sequence_group::{
    CellSizes, Group, Layout, SequenceRows, add, groups, product, squared_error,
};
use crate::sequence::stepper::{NextRows, put_outputs};
use crate::training_error::TrainingError;

/// Intermediate results of a pass over a group.
#[derive(Default)]
struct Scratch {
    /// Reset gates, update gates, candidates, and the part of the candidates that the reset gates multiply.
    gates: Vec<Row8>,
    /// A row of ones, and the rows of the state after each step.
    after: Vec<Row8>,
    outputs: Vec<Row8>,
    /// Derivatives with respect to the outputs, the states, the weighted sums of `gates`, the state before a step, and the
    /// weighted sums of the first state.
    output_deltas: Vec<Row8>,
    state_deltas: Vec<Row8>,
    deltas: Vec<Row8>,
    carried: Vec<Row8>,
    start_deltas: Vec<Row8>,
}

impl Scratch {
    /// Number of lane matrices' rows over all steps.
    fn rows(shape: &GruShape) -> usize {
        8 * shape.hidden + shape.state_row() + shape.hidden + 2 * shape.outputs
    }

    fn fit(&mut self, shape: &GruShape, layout: &Layout, trains: bool) {
        let GruShape { hidden, outputs, .. } = *shape;
        let stride = layout.stride;
        self.gates.resize(4 * hidden * stride, Row8::default());
        self.after.resize(shape.state_row() * stride, Row8::default());
        self.after[..stride].fill(Row8([1.0; LANES]));
        self.outputs.resize(outputs * stride, Row8::default());
        if trains {
            self.output_deltas.resize(outputs * stride, Row8::default());
            self.state_deltas.resize(hidden * stride, Row8::default());
            self.deltas.resize(4 * hidden * stride, Row8::default());
            self.carried.resize(hidden * layout.start_stride, Row8::default());
            self.start_deltas.resize(hidden * layout.start_stride, Row8::default());
        }
    }
}

/// Sequences with memory for the passes over them.
pub(crate) struct GruBatch {
    isa: Isa,
    shape: GruShape,
    groups: Vec<Group>,
    rows: usize,
    scratch: Scratch,
}

impl GruBatch {
    pub(crate) fn new(isa: Isa, shape: GruShape, rows: &SequenceRows) -> Result<GruBatch, TrainingError> {
        let groups = groups(&cell_sizes(&shape), rows)?;
        Ok(GruBatch { isa, shape, groups, rows: rows.sequences.rows(), scratch: Scratch::default() })
    }

    /// The outputs for all rows, `rows x outputs`.
    pub(crate) fn evaluate(&mut self, weights: &[f64]) -> Vec<f64> {
        let mut predictions = vec![0.0; self.rows * self.shape.outputs];
        for number in 0..self.groups.len() {
            self.forward(number, weights, false);
            let layout = &self.groups[number].layout;
            layout.each_row(|row, block, lane| {
                for o in 0..self.shape.outputs {
                    predictions[row * self.shape.outputs + o] =
                        self.scratch.outputs[o * layout.stride + block].0[lane];
                }
            });
        }
        predictions
    }

    fn forward(&mut self, number: usize, weights: &[f64], trains: bool) {
        let GruBatch { isa, shape, groups, scratch, .. } = self;
        let group = &mut groups[number];
        scratch.fit(shape, &group.layout, trains);
        dispatch(*isa, Start { shape, weights, group });
        dispatch(*isa, Forward { shape, weights, group, scratch });
    }

    /// Sequences whose rows come one after the other.
    pub(crate) fn of_next_rows(
        isa: Isa,
        shape: GruShape,
        count: usize,
        starts: &[f64],
    ) -> Result<GruBatch, TrainingError> {
        let groups = vec![Group::of_next_rows(&cell_sizes(&shape), count, starts)?];
        Ok(GruBatch { isa, shape, groups, rows: count, scratch: Scratch::default() })
    }
}

impl NextRows for GruBatch {
    fn sizes(&self) -> CellSizes {
        cell_sizes(&self.shape)
    }

    fn advance(&mut self, weights: &[f64], begins: bool, inputs: &[f64], outputs: &mut [f64]) {
        let GruBatch { isa, shape, groups, scratch, .. } = self;
        let (isa, group) = (*isa, &mut groups[0]);
        group.set_inputs(shape.inputs, inputs);
        scratch.fit(shape, &group.layout, false);
        if begins {
            dispatch(isa, Start { shape, weights, group });
        }
        dispatch(isa, Forward { shape, weights, group, scratch });
        put_outputs(&groups[0].layout, &scratch.outputs, shape.outputs, outputs);
    }

    fn carry(&mut self) {
        let Group { layout, below, .. } = &mut self.groups[0];
        Group::carry(layout, below, self.shape.inputs + 1);
    }

    fn state_values(&self) -> usize {
        self.shape.hidden
    }

    fn state(&self) -> Vec<f64> {
        let Group { layout, below, .. } = &self.groups[0];
        Group::values(layout, below, self.shape.inputs + 1).concat()
    }

    fn set_state(&mut self, state: &[f64]) {
        let Group { layout, below, .. } = &mut self.groups[0];
        for (lane, values) in state.chunks_exact(self.shape.hidden).enumerate() {
            Group::set_values(layout, below, self.shape.inputs + 1, lane, values);
        }
    }
}

fn cell_sizes(shape: &GruShape) -> CellSizes {
    let GruShape { inputs, starts, hidden: state, outputs } = *shape;
    CellSizes { inputs, starts, state, outputs, weights: shape.weights(), rows: Scratch::rows(shape) }
}

impl Batch for GruBatch {
    fn squared_error(&mut self, weights: &[f64]) -> f64 {
        let mut sum = 0.0;
        for number in 0..self.groups.len() {
            self.forward(number, weights, true);
            let (group, outputs) = (&self.groups[number], &self.scratch.outputs[..]);
            sum += dispatch(self.isa, SquaredError { group, outputs });
        }
        sum
    }

    fn gradient(&mut self, weights: &[f64], scale: f64, gradient: &mut [f64]) {
        gradient.fill(0.0);
        for number in 0..self.groups.len() {
            // With a single group, the results of the forward pass are still there.
            if self.groups.len() > 1 {
                self.forward(number, weights, true);
            }
            let GruBatch { isa, shape, groups, scratch, .. } = self;
            let group = &groups[number];
            dispatch(*isa, Backward { shape, weights, group, scratch, scale });
            dispatch(*isa, Gradient { shape, group, scratch, gradient });
        }
    }
}

/// The state before the first step.
struct Start<'a> {
    shape: &'a GruShape,
    weights: &'a [f64],
    group: &'a mut Group,
}

impl Kernel for Start<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let GruShape { inputs, starts, hidden, .. } = *self.shape;
        let (shape, weights) = (self.shape, self.weights);
        let Group { layout, below, starts: start_rows, .. } = self.group;
        let (stride, (_, all)) = (layout.stride, layout.step(0));
        let state = (inputs + 1) * stride;
        let first_state = Scalars { values: &weights[shape.first_state()..], by_k: 1, by_j: starts + 1 };
        product::<L>(
            first_state,
            hidden,
            starts + 1,
            start_rows,
            layout.start_stride,
            0,
            all,
            #[inline(always)]
            |j, b, sum| {
                tanh(sum).store(&mut below[state + j * stride + b].0);
            },
        );
    }
}

struct Forward<'a> {
    shape: &'a GruShape,
    weights: &'a [f64],
    group: &'a mut Group,
    scratch: &'a mut Scratch,
}

impl Kernel for Forward<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let GruShape { inputs, hidden, outputs, .. } = *self.shape;
        let (shape, weights, scratch) = (self.shape, self.weights, self.scratch);
        let Group { layout, below, .. } = self.group;
        let stride = layout.stride;
        let state = (inputs + 1) * stride;
        for step in 0..layout.steps() {
            let (first, width) = layout.step(step);
            let gates = &mut scratch.gates;
            let row = shape.gate_row();
            let both = Scalars { values: weights, by_k: 1, by_j: row };
            product::<L>(
                both,
                2 * hidden,
                row,
                below,
                stride,
                first,
                width,
                #[inline(always)]
                |j, b, sum| {
                    sum.store(&mut gates[j * stride + b].0);
                },
            );
            let from_inputs =
                Scalars { values: &weights[shape.candidate_inputs()..], by_k: 1, by_j: inputs + 1 };
            product::<L>(
                from_inputs,
                hidden,
                inputs + 1,
                below,
                stride,
                first,
                width,
                #[inline(always)]
                |j, b, sum| {
                    sum.store(&mut gates[(2 * hidden + j) * stride + b].0);
                },
            );
            let row = shape.state_row();
            let from_state = Scalars { values: &weights[shape.candidate_state()..], by_k: 1, by_j: row };
            let lanes = &below[inputs * stride..];
            product::<L>(
                from_state,
                hidden,
                row,
                lanes,
                stride,
                first,
                width,
                #[inline(always)]
                |j, b, sum| {
                    sum.store(&mut gates[(3 * hidden + j) * stride + b].0);
                },
            );
            let next = layout.next(step);
            for j in 0..hidden {
                for b in 0..width {
                    let at = |part: usize| (part * hidden + j) * stride + first + b;
                    let reset = sigmoid(L::load(&gates[at(0)].0));
                    let update = sigmoid(L::load(&gates[at(1)].0));
                    let held = L::load(&gates[at(3)].0);
                    let candidate = tanh(reset.mul_add(held, L::load(&gates[at(2)].0)));
                    let before = L::load(&below[state + j * stride + first + b].0);
                    let after = update.mul_add(before - candidate, candidate);
                    reset.store(&mut gates[at(0)].0);
                    update.store(&mut gates[at(1)].0);
                    candidate.store(&mut gates[at(2)].0);
                    after.store(&mut scratch.after[(1 + j) * stride + first + b].0);
                    if b < next.1 {
                        after.store(&mut below[state + j * stride + next.0 + b].0);
                    }
                }
            }
        }
        let row = shape.state_row();
        let read_out = Scalars { values: &weights[shape.read_out()..], by_k: 1, by_j: row };
        let (after, results) = (&scratch.after, &mut scratch.outputs);
        product::<L>(
            read_out,
            outputs,
            row,
            after,
            stride,
            0,
            layout.total(),
            #[inline(always)]
            |o, b, sum| {
                sum.store(&mut results[o * stride + b].0);
            },
        );
    }
}

struct SquaredError<'a> {
    group: &'a Group,
    outputs: &'a [Row8],
}

impl Kernel for SquaredError<'_> {
    type Output = f64;
    #[inline(always)]
    fn run<L: Lanes>(self) -> f64 {
        squared_error::<L>(self.group, self.outputs)
    }
}

struct Backward<'a> {
    shape: &'a GruShape,
    weights: &'a [f64],
    group: &'a Group,
    scratch: &'a mut Scratch,
    scale: f64,
}

impl Kernel for Backward<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let GruShape { inputs, hidden, outputs, .. } = *self.shape;
        let (shape, weights) = (self.shape, self.weights);
        let Group { layout, below, targets, weights: factors, .. } = self.group;
        let Scratch {
            gates,
            outputs: results,
            output_deltas,
            state_deltas,
            deltas,
            carried,
            start_deltas,
            ..
        } = self.scratch;
        let (stride, start_stride, one) = (layout.stride, layout.start_stride, L::splat(1.0));
        let state = (inputs + 1) * stride;
        for o in 0..outputs {
            for at in o * stride..o * stride + layout.total() {
                let error = L::load(&results[at].0) - L::load(&targets[at].0);
                (L::load(&factors[at].0) * error * L::splat(self.scale)).store(&mut output_deltas[at].0);
            }
        }
        let (gate_row, state_row) = (shape.gate_row(), shape.state_row());
        let read_out = Scalars { values: &weights[shape.read_out() + 1..], by_k: state_row, by_j: 1 };
        product::<L>(
            read_out,
            hidden,
            outputs,
            output_deltas,
            stride,
            0,
            layout.total(),
            #[inline(always)]
            |j, b, sum| {
                sum.store(&mut state_deltas[j * stride + b].0);
            },
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
                    let before = L::load(&below[state + j * stride + first + b].0);
                    let new = delta * (one - update) * (-candidate).mul_add(candidate, one);
                    let kept = delta * (before - candidate) * (-update).mul_add(update, update);
                    let opened = new * held * (-reset).mul_add(reset, reset);
                    opened.store(&mut deltas[at(0)].0);
                    kept.store(&mut deltas[at(1)].0);
                    new.store(&mut deltas[at(2)].0);
                    (new * reset).store(&mut deltas[at(3)].0);
                    (delta * update).store(&mut carried[j * start_stride + b].0);
                }
            }
            let both = Scalars { values: &weights[inputs + 1..], by_k: gate_row, by_j: 1 };
            let from_state =
                Scalars { values: &weights[shape.candidate_state() + 1..], by_k: state_row, by_j: 1 };
            for (scalars, depth, part) in [(both, 2 * hidden, 0), (from_state, hidden, 3 * hidden)] {
                let lanes = &deltas[part * stride..];
                product::<L>(
                    scalars,
                    hidden,
                    depth,
                    lanes,
                    stride,
                    first,
                    width,
                    #[inline(always)]
                    |j, b, sum| {
                        let entry = &mut carried[j * start_stride + b - first].0;
                        (L::load(entry) + sum).store(entry);
                    },
                );
            }
            for j in 0..hidden {
                for b in 0..width {
                    let delta = L::load(&carried[j * start_stride + b].0);
                    if step == 0 {
                        let before = L::load(&below[state + j * stride + b].0);
                        let delta = delta * (-before).mul_add(before, one);
                        delta.store(&mut start_deltas[j * start_stride + b].0);
                    } else {
                        let entry = &mut state_deltas[j * stride + layout.offsets[step - 1] + b].0;
                        (L::load(entry) + delta).store(entry);
                    }
                }
            }
        }
    }
}

struct Gradient<'a> {
    shape: &'a GruShape,
    group: &'a Group,
    scratch: &'a Scratch,
    gradient: &'a mut [f64],
}

impl Kernel for Gradient<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let GruShape { inputs, starts, hidden, outputs } = *self.shape;
        let (shape, scratch, gradient) = (self.shape, self.scratch, self.gradient);
        let Group { layout, below, starts: start_rows, .. } = self.group;
        let (stride, total) = (layout.stride, layout.total());
        let part = |k: usize| &scratch.deltas[k * hidden * stride..];
        let state = &below[inputs * stride..];
        add::<L>(&scratch.deltas, 2 * hidden, below, shape.gate_row(), 0, stride, total, gradient);
        add::<L>(part(2), hidden, below, inputs + 1, shape.candidate_inputs(), stride, total, gradient);
        add::<L>(part(3), hidden, state, shape.state_row(), shape.candidate_state(), stride, total, gradient);
        add::<L>(
            &scratch.output_deltas,
            outputs,
            &scratch.after,
            shape.state_row(),
            shape.read_out(),
            stride,
            total,
            gradient,
        );
        let (width, at) = (starts + 1, shape.first_state());
        let (stride, all) = (layout.start_stride, layout.step(0).1);
        add::<L>(&scratch.start_deltas, hidden, start_rows, width, at, stride, all, gradient);
    }
}
