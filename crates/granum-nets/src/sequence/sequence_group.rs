//! Sequences in the lanes of vectors, and the products over them of which recurrent cells consist.
//!
//! Each lane of a vector holds one sequence. Sequences are sorted by their length, so that the lane blocks of a step are the
//! first ones, and the lane blocks of all steps are stored one after the other: block `b` of step `t` is at `offsets[t] + b`
//! of every row of a lane matrix. A product over all steps, which the gradient consists of, is thus one product of matrices.
//! In lanes whose sequence has ended, the weights of the errors are zero, so that they contribute nothing.

use granum_simd::{LANES, Lanes, Row8};

use crate::linear_algebra::kernels::{Scalars, blocks, lane_dots, odd, panel, panels, scalar_times_lanes};
use crate::table::sequences::Sequences;
use crate::training_error::TrainingError;

/// Number of sequences that are computed together; with more, the memory for intermediate results is used again.
pub(crate) const GROUP: usize = 8 * LANES;
/// Limit on the memory of a batch, bytes.
const MEMORY: usize = 2 << 30;

/// Numbers of rows of the matrices of a recurrent cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct CellSizes {
    pub inputs: usize,
    pub starts: usize,
    /// Number of values of the state that are known before a step.
    pub state: usize,
    pub outputs: usize,
    /// Number of weights.
    pub weights: usize,
    /// Number of rows over all steps that the intermediate results need.
    pub rows: usize,
}

impl CellSizes {
    /// Number of rows below a step: inputs, a one, state.
    pub fn below(&self) -> usize {
        self.inputs + 1 + self.state
    }
}

/// The rows of a batch; without targets and weights for predictions.
pub(crate) struct SequenceRows<'a> {
    pub inputs: &'a [f64],
    pub sequences: &'a Sequences,
    pub targets: Option<&'a [f64]>,
    pub weights: Option<&'a [f64]>,
}

/// The place of the sequences of a group in the lanes.
pub(crate) struct Layout {
    /// For each lane the number of its sequence and its first row, in the order of decreasing length.
    lanes: Vec<(usize, usize)>,
    lengths: Vec<usize>,
    /// For each step the first lane block, and last the number of all lane blocks.
    pub offsets: Vec<usize>,
    /// Distance between the rows of lane matrices over all steps, and of those with one lane block for each sequence.
    pub stride: usize,
    pub start_stride: usize,
    /// Number of steps behind the last one for whose state there is room: 1 where rows follow that are not known yet.
    ahead: usize,
}

impl Layout {
    fn new(members: &[(usize, usize, usize)], ahead: usize) -> Layout {
        let lengths: Vec<usize> = members.iter().map(|(_, _, length)| *length).collect();
        let mut offsets = vec![0];
        for step in 0..lengths.first().copied().unwrap_or(0) {
            let active = lengths.partition_point(|length| *length > step);
            offsets.push(offsets[step] + blocks(active));
        }
        for _ in 0..ahead {
            offsets.push(offsets[offsets.len() - 1] + blocks(members.len()));
        }
        let total = offsets[offsets.len() - 1];
        Layout {
            lanes: members.iter().map(|(number, first, _)| (*number, *first)).collect(),
            lengths,
            offsets,
            stride: odd(total),
            start_stride: odd(blocks(members.len())),
            ahead,
        }
    }

    pub fn steps(&self) -> usize {
        self.offsets.len() - 1 - self.ahead
    }

    /// First lane block and number of lane blocks of the step after one, to which its state goes: none behind the last, unless rows follow.
    pub fn next(&self, step: usize) -> (usize, usize) {
        if step + 2 < self.offsets.len() { self.step(step + 1) } else { (0, 0) }
    }

    pub fn total(&self) -> usize {
        self.offsets[self.steps()]
    }

    /// First lane block and number of lane blocks of a step.
    pub fn step(&self, step: usize) -> (usize, usize) {
        (self.offsets[step], self.offsets[step + 1] - self.offsets[step])
    }

    /// Calls `visit(row, lane block, lane)` for every row of the table.
    pub fn each_row(&self, mut visit: impl FnMut(usize, usize, usize)) {
        for (lane, ((_, first), length)) in self.lanes.iter().zip(&self.lengths).enumerate() {
            for step in 0..*length {
                visit(first + step, self.offsets[step] + lane / LANES, lane % LANES);
            }
        }
    }
}

/// The sequences of a group in the layout for training.
pub(crate) struct Group {
    pub layout: Layout,
    /// Rows of the inputs, a row of ones, and the rows of the state before each step.
    pub below: Vec<Row8>,
    /// Rows of the start values and a row of ones.
    pub starts: Vec<Row8>,
    /// Targets and weights of the squared errors, one row for each output; the weight is zero in unused lanes.
    pub targets: Vec<Row8>,
    pub weights: Vec<Row8>,
}

impl Group {
    /// As many sequences of one row each as there are start vectors, with room for the state after it. The inputs are not known yet.
    ///
    /// # Errors
    /// If the start vectors are those of another cell, or of too many sequences.
    pub fn of_next_rows(sizes: &CellSizes, count: usize, starts: &[f64]) -> Result<Group, TrainingError> {
        if count == 0 || count > GROUP || starts.len() != count * sizes.starts {
            let (needed, found) = (sizes.starts, starts.len());
            return Err(TrainingError::Rows(format!(
                "between 1 and {GROUP} sequences of {needed} start values each can be advanced together, not {count} with {found} values"
            )));
        }
        let sequences =
            Sequences::new(vec![1; count]).and_then(|own| own.with_starts(starts.to_vec(), sizes.starts));
        let sequences = sequences.map_err(|error| TrainingError::Rows(error.to_string()))?;
        let inputs = vec![0.0; count * sizes.inputs];
        let rows = SequenceRows { inputs: &inputs, sequences: &sequences, targets: None, weights: None };
        let members: Vec<_> = (0..count).map(|number| (number, number, 1)).collect();
        Ok(Group::new(sizes, &rows, &members, 1))
    }

    /// Sets the inputs of the one row of each sequence.
    pub fn set_inputs(&mut self, columns: usize, inputs: &[f64]) {
        for (lane, row) in inputs.chunks_exact(columns).enumerate() {
            for (column, value) in row.iter().enumerate() {
                self.below[column * self.layout.stride + lane / LANES].0[lane % LANES] = *value;
            }
        }
    }

    /// The state after the one row becomes that before it, in the rows from `first` on of a matrix over all steps.
    pub fn carry(layout: &Layout, matrix: &mut [Row8], first: usize) {
        let (after, width) = layout.step(1);
        for row in matrix[first * layout.stride..].chunks_exact_mut(layout.stride) {
            row.copy_within(after..after + width, 0);
        }
    }

    /// The values before the first step, sequence by sequence, in the rows from `first` on of a matrix over all steps.
    pub fn values(layout: &Layout, matrix: &[Row8], first: usize) -> Vec<Vec<f64>> {
        let value = |lane: usize, row: &[Row8]| row[lane / LANES].0[lane % LANES];
        let rows = || matrix[first * layout.stride..].chunks_exact(layout.stride);
        (0..layout.lanes.len()).map(|lane| rows().map(|row| value(lane, row)).collect()).collect()
    }

    /// Sets the values before the first step of a sequence, as [`Group::values`] gave them.
    pub fn set_values(layout: &Layout, matrix: &mut [Row8], first: usize, lane: usize, values: &[f64]) {
        let rows = matrix[first * layout.stride..].chunks_exact_mut(layout.stride);
        for (row, value) in rows.zip(values) {
            row[lane / LANES].0[lane % LANES] = *value;
        }
    }

    fn new(sizes: &CellSizes, rows: &SequenceRows, members: &[(usize, usize, usize)], ahead: usize) -> Group {
        let layout = Layout::new(members, ahead);
        let CellSizes { inputs, starts, outputs, .. } = *sizes;
        let (stride, start_stride) = (layout.stride, layout.start_stride);
        let mut below = vec![Row8::default(); sizes.below() * stride];
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

/// The rows in groups of sequences, the longest first.
///
/// # Errors
/// If the memory does not suffice.
pub(crate) fn groups(sizes: &CellSizes, rows: &SequenceRows) -> Result<Vec<Group>, TrainingError> {
    let ranges = rows.sequences.ranges();
    let mut members: Vec<(usize, usize, usize)> =
        ranges.iter().enumerate().map(|(number, rows)| (number, rows.start, rows.len())).collect();
    members.sort_by_key(|(number, _, length)| (std::cmp::Reverse(*length), *number));
    let longest = members.first().map_or(0, |(_, _, length)| *length);
    let lanes = blocks(members.len().min(GROUP)) * longest;
    let all = blocks(rows.sequences.rows()).saturating_add(members.len() * longest / LANES);
    let blocks = lanes.saturating_mul(sizes.rows).saturating_add(all.saturating_mul(sizes.below()));
    let (bytes, limit) = (blocks.saturating_mul(size_of::<Row8>()), MEMORY);
    if bytes > limit {
        let (rows, weights) = (rows.sequences.rows(), sizes.weights);
        return Err(TrainingError::Memory { rows, weights, bytes, limit });
    }
    Ok(members.chunks(GROUP).map(|members| Group::new(sizes, rows, members, 0)).collect())
}

/// The weighted sum of squared errors of the outputs of a group.
#[inline(always)]
pub(crate) fn squared_error<L: Lanes>(group: &Group, outputs: &[Row8]) -> f64 {
    let Group { layout, targets, weights, .. } = group;
    let mut sum = L::zero();
    for o in 0..targets.len() / layout.stride {
        for at in o * layout.stride..o * layout.stride + layout.total() {
            let error = L::load(&outputs[at].0) - L::load(&targets[at].0);
            sum = (L::load(&weights[at].0) * error).mul_add(error, sum);
        }
    }
    sum.reduce_add()
}

/// The derivatives with respect to the weighted sums of hidden neurons `tanh` in the lane blocks `first..first + width`, from those `above` with
/// respect to linear functions of the neurons. The `weights` of each function are a bias and one for each neuron; the rows `neurons` are ones, then
/// the neurons.
#[inline(always)]
pub(crate) fn below_tanh<L: Lanes>(
    weights: &[f64],
    [hidden, functions]: [usize; 2],
    above: &[Row8],
    neurons: &[Row8],
    deltas: &mut [Row8],
    stride: usize,
    (first, width): (usize, usize),
) {
    let one = L::splat(1.0);
    product::<L>(
        Scalars { values: &weights[1..], by_k: 1 + hidden, by_j: 1 },
        hidden,
        functions,
        above,
        stride,
        first,
        width,
        #[inline(always)]
        |j, b, sum| {
            let value = L::load(&neurons[(1 + j) * stride + b].0);
            (sum * (-value).mul_add(value, one)).store(&mut deltas[j * stride + b].0);
        },
    );
}

/// Products of scalars with lane blocks `first..first + width`, summed from zero.
#[expect(clippy::redundant_closure, reason = "a closure that is passed by reference is not inlined")]
#[inline(always)]
pub(crate) fn product<L: Lanes>(
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
                |_, _| L::zero(),
                // Not by reference: the function that calls a closure behind a reference is not inlined, and has no vector instructions.
                #[inline(always)]
                |j, b, sum| finish(j, b, sum),
            );
        },
    );
}

/// Adds the products of the rows of two lane matrices over `count` lane blocks to the gradient from `at` on.
#[inline(always)]
pub(crate) fn add<L: Lanes>(
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
