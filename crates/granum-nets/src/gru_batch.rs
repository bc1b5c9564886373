//! Forward pass and back-propagation through time of a gated recurrent unit, for many sequences at once.
//!
//! Each lane of a vector holds one sequence. Sequences are sorted by their length, so that the lane blocks of a step are the
//! first ones, and the lane blocks of all steps are stored one after the other: block `b` of step `t` is at `offsets[t] + b`
//! of every row of a lane matrix. A product over all steps, which the gradient consists of, is thus one product of matrices.
//! In lanes whose sequence has ended, the weights of the errors are zero, so that they contribute nothing.

use granum_simd::{Isa, Kernel, LANES, Lanes, Row8, dispatch, sigmoid, tanh};

use crate::differentiable::Batch;
use crate::gru_shape::GruShape;
use crate::kernels::{Scalars, blocks, lane_dots, odd, panel, panels, scalar_times_lanes};
use crate::sequences::Sequences;
use crate::trainer::error::TrainingError;

/// Number of sequences that are computed together; with more, the memory for intermediate results is used again.
const GROUP: usize = 8 * LANES;
/// Limit on the memory of a batch, bytes.
const MEMORY: usize = 2 << 30;

/// The rows of a batch; without targets and weights for predictions.
pub(crate) struct GruRows<'a> {
    pub inputs: &'a [f64],
    pub sequences: &'a Sequences,
    pub targets: Option<&'a [f64]>,
    pub weights: Option<&'a [f64]>,
}

/// The place of the sequences of a group in the lanes.
struct Layout {
    /// For each lane the number of its sequence and its first row, in the order of decreasing length.
    lanes: Vec<(usize, usize)>,
    lengths: Vec<usize>,
    /// For each step the first lane block, and last the number of all lane blocks.
    offsets: Vec<usize>,
    /// Distance between the rows of lane matrices over all steps, and of those with one lane block for each sequence.
    stride: usize,
    start_stride: usize,
}

impl Layout {
    fn new(members: &[(usize, usize, usize)]) -> Layout {
        let lengths: Vec<usize> = members.iter().map(|(_, _, length)| *length).collect();
        let mut offsets = vec![0];
        for step in 0..lengths.first().copied().unwrap_or(0) {
            let active = lengths.partition_point(|length| *length > step);
            offsets.push(offsets[step] + blocks(active));
        }
        let total = offsets[offsets.len() - 1];
        Layout {
            lanes: members.iter().map(|(number, first, _)| (*number, *first)).collect(),
            lengths,
            offsets,
            stride: odd(total),
            start_stride: odd(blocks(members.len())),
        }
    }

    fn steps(&self) -> usize {
        self.offsets.len() - 1
    }

    fn total(&self) -> usize {
        self.offsets[self.steps()]
    }

    /// First lane block and number of lane blocks of a step.
    fn step(&self, step: usize) -> (usize, usize) {
        (self.offsets[step], self.offsets[step + 1] - self.offsets[step])
    }

    /// Calls `visit(row, lane block, lane)` for every row of the table.
    fn each_row(&self, mut visit: impl FnMut(usize, usize, usize)) {
        for (lane, ((_, first), length)) in self.lanes.iter().zip(&self.lengths).enumerate() {
            for step in 0..*length {
                visit(first + step, self.offsets[step] + lane / LANES, lane % LANES);
            }
        }
    }
}

/// The sequences of a group in the layout for training.
struct Group {
    layout: Layout,
    /// Rows of the inputs, a row of ones, and the rows of the state before each step.
    below: Vec<Row8>,
    /// Rows of the start values and a row of ones.
    starts: Vec<Row8>,
    /// Targets and weights of the squared errors, one row for each output; the weight is zero in unused lanes.
    targets: Vec<Row8>,
    weights: Vec<Row8>,
}

impl Group {
    fn new(shape: &GruShape, rows: &GruRows, members: &[(usize, usize, usize)]) -> Group {
        let layout = Layout::new(members);
        let GruShape { inputs, starts, outputs, .. } = *shape;
        let (stride, start_stride) = (layout.stride, layout.start_stride);
        let mut below = vec![Row8::default(); shape.gate_row() * stride];
        below[inputs * stride..(inputs + 1) * stride].fill(Row8([1.0; LANES]));
        let mut start_rows = vec![Row8::default(); (starts + 1) * start_stride];
        start_rows[starts * start_stride..].fill(Row8([1.0; LANES]));
        for (lane, (number, _)) in layout.lanes.iter().enumerate() {
            for c in 0..starts {
                let value = rows.sequences.starts()[number * starts + c];
                start_rows[c * start_stride + lane / LANES].0[lane % LANES] = value;
            }
        }
        let trained = if rows.targets.is_some() { outputs * stride } else { 0 };
        let mut targets = vec![Row8::default(); trained];
        let mut weights = targets.clone();
        layout.each_row(|row, block, lane| {
            for c in 0..inputs {
                below[c * stride + block].0[lane] = rows.inputs[row * inputs + c];
            }
            if let Some(values) = rows.targets {
                for c in 0..outputs {
                    targets[c * stride + block].0[lane] = values[row * outputs + c];
                    weights[c * stride + block].0[lane] = rows.weights.map_or(1.0, |weights| weights[row]);
                }
            }
        });
        Group { layout, below, starts: start_rows, targets, weights }
    }
}

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
    pub(crate) fn new(isa: Isa, shape: GruShape, rows: &GruRows) -> Result<GruBatch, TrainingError> {
        let ranges = rows.sequences.ranges();
        let mut members: Vec<(usize, usize, usize)> =
            ranges.iter().enumerate().map(|(number, rows)| (number, rows.start, rows.len())).collect();
        members.sort_by_key(|(number, _, length)| (std::cmp::Reverse(*length), *number));
        let longest = members.first().map_or(0, |(_, _, length)| *length);
        let lanes = blocks(members.len().min(GROUP)) * longest;
        let all = blocks(rows.sequences.rows()).saturating_add(members.len() * longest / LANES);
        let blocks = lanes.saturating_mul(Scratch::rows(&shape)) + all.saturating_mul(shape.gate_row());
        let (bytes, limit) = (blocks.saturating_mul(size_of::<Row8>()), MEMORY);
        if bytes > limit {
            let (rows, weights) = (rows.sequences.rows(), shape.weights());
            return Err(TrainingError::Memory { rows, weights, bytes, limit });
        }
        let groups = members.chunks(GROUP).map(|members| Group::new(&shape, rows, members)).collect();
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
        dispatch(*isa, Forward { shape, weights, group, scratch });
    }
}

impl Batch for GruBatch {
    fn squared_error(&mut self, weights: &[f64]) -> f64 {
        let mut sum = 0.0;
        for number in 0..self.groups.len() {
            self.forward(number, weights, true);
            sum += dispatch(self.isa, SquaredError { group: &self.groups[number], scratch: &self.scratch });
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
        let GruShape { inputs, starts, hidden, outputs } = *self.shape;
        let (shape, weights, scratch) = (self.shape, self.weights, self.scratch);
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
            let next = if step + 1 < layout.steps() { layout.step(step + 1) } else { (0, 0) };
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

/// Products of scalars with lane blocks `first..first + width`, summed from zero.
#[inline(always)]
fn product<L: Lanes>(
    scalars: Scalars,
    results: usize,
    depth: usize,
    lanes: &[Row8],
    stride: usize,
    first: usize,
    width: usize,
    mut finish: impl FnMut(usize, usize, L),
) {
    panels(
        first,
        first + width,
        panel::<L>(),
        #[inline(always)]
        |from, width| {
            scalar_times_lanes::<L, 5, 5>(
                scalars,
                results,
                depth,
                lanes,
                stride,
                from,
                width,
                #[inline(always)]
                |_| L::zero(),
                &mut finish,
            );
        },
    );
}

struct SquaredError<'a> {
    group: &'a Group,
    scratch: &'a Scratch,
}

impl Kernel for SquaredError<'_> {
    type Output = f64;
    #[inline(always)]
    fn run<L: Lanes>(self) -> f64 {
        let Group { layout, targets, weights, .. } = self.group;
        let mut sum = L::zero();
        for o in 0..targets.len() / layout.stride {
            for at in o * layout.stride..o * layout.stride + layout.total() {
                let error = L::load(&self.scratch.outputs[at].0) - L::load(&targets[at].0);
                sum = (L::load(&weights[at].0) * error).mul_add(error, sum);
            }
        }
        sum.reduce_add()
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

/// Adds the products of the rows of two lane matrices over `count` lane blocks to the gradient from `at` on.
#[inline(always)]
fn add<L: Lanes>(
    a: &[Row8],
    rows_a: usize,
    b: &[Row8],
    rows_b: usize,
    at: usize,
    stride: usize,
    count: usize,
    gradient: &mut [f64],
) {
    lane_dots::<L>(
        a,
        rows_a,
        b,
        rows_b,
        stride,
        count,
        #[inline(always)]
        |j, i, sum| gradient[at + j * rows_b + i] += sum,
    );
}
