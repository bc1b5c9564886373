//! Batches of recurrent cells: what all cells have in common around the equations of a step.

use granum_simd::{Isa, Kernel, LANES, Lanes, Row8, dispatch};

use crate::differentiable::Batch;
use crate::feed_forward::network::{LARGEST_LAYER, MOST_WEIGHTS, NetworkError};
use crate::sequence::sequence_group::{CellSizes, Group, SequenceRows, groups, squared_error};
use crate::sequence::stepper::{NextRows, put_outputs};
use crate::table::data::Data;
use crate::table::sequences::Sequences;
use crate::training_error::TrainingError;

/// The equations of a recurrent cell and their derivatives, over all steps of a group of sequences.
pub(crate) trait CellKernel: Copy + Send + Sync + 'static {
    fn sizes(&self) -> CellSizes;

    /// Numbers of rows of the matrices of intermediate results in [`Work::own`].
    fn own(&self) -> Vec<usize>;

    /// Numbers of rows of the matrices of derivatives in [`Work::derivatives`].
    fn derivatives(&self) -> Vec<usize>;

    /// Number of rows over all steps that the intermediate results need for a cell with these outputs.
    fn rows(&self, outputs: usize) -> usize {
        self.own().iter().chain(&self.derivatives()).sum::<usize>() + 2 * outputs
    }

    /// The matrices of [`Work::own`] that hold a part of the state beside the rows below a step.
    fn carried(&self) -> &'static [usize] {
        &[]
    }

    /// Computes the state before the first step.
    fn start<L: Lanes>(self, weights: &[f64], group: &mut Group, work: &mut Work);

    /// Computes the states after [`CellKernel::start`], which go to the rows `below` the next step of the group, and the outputs.
    fn forward<L: Lanes>(self, weights: &[f64], group: &mut Group, work: &mut Work);

    /// Adds the gradient, after [`CellKernel::forward`], for the derivatives `work.output_deltas` of the outputs.
    fn backward<L: Lanes>(self, weights: &[f64], group: &Group, work: &mut Work, gradient: &mut [f64]);
}

/// Intermediate results of a pass over a group. Matrices over all steps have the stride of the layout of the group.
#[derive(Default)]
pub(crate) struct Work {
    pub outputs: Vec<Row8>,
    pub output_deltas: Vec<Row8>,
    /// The matrices of the cell.
    pub own: Vec<Vec<Row8>>,
    /// The matrices of the cell that only [`CellKernel::backward`] needs: there is room for them, for `output_deltas` and for
    /// `carried` where rows have targets.
    pub derivatives: Vec<Vec<Row8>>,
    /// Derivatives with respect to the first states, and those that are carried from step to step: two rows for each value of the
    /// state, with the stride of the starts.
    pub carried: Vec<Row8>,
}

/// Sequences with memory for the passes of a cell over them.
pub(crate) struct CellBatch<C> {
    isa: Isa,
    cell: C,
    /// What the cell says of itself, which a step of one row would otherwise wait for.
    sizes: CellSizes,
    own: Vec<usize>,
    derivatives: Vec<usize>,
    groups: Vec<Group>,
    rows: usize,
    work: Work,
    /// The group for which there is room in `work`.
    fitted: Option<usize>,
}

impl<C: CellKernel> CellBatch<C> {
    pub(crate) fn new(isa: Isa, cell: C, rows: &SequenceRows) -> Result<CellBatch<C>, TrainingError> {
        let groups = groups(&cell.sizes(), rows)?;
        Ok(CellBatch::of_groups(isa, cell, groups, rows.sequences.rows()))
    }

    fn of_groups(isa: Isa, cell: C, groups: Vec<Group>, rows: usize) -> CellBatch<C> {
        let (sizes, own, derivatives) = (cell.sizes(), cell.own(), cell.derivatives());
        CellBatch { isa, cell, sizes, own, derivatives, groups, rows, work: Work::default(), fitted: None }
    }

    /// Sequences whose rows come one after the other.
    pub(crate) fn of_next_rows(
        isa: Isa,
        cell: C,
        count: usize,
        starts: &[f64],
    ) -> Result<CellBatch<C>, TrainingError> {
        let groups = vec![Group::of_next_rows(&cell.sizes(), count, starts)?];
        Ok(CellBatch::of_groups(isa, cell, groups, count))
    }

    /// The outputs for all rows, `rows x outputs`.
    pub(crate) fn evaluate(&mut self, weights: &[f64]) -> Vec<f64> {
        let outputs = self.sizes.outputs;
        let mut predictions = vec![0.0; self.rows * outputs];
        for number in 0..self.groups.len() {
            self.forward(number, weights);
            let layout = &self.groups[number].layout;
            layout.each_row(|row, block, lane| {
                for o in 0..outputs {
                    predictions[row * outputs + o] = self.work.outputs[o * layout.stride + block].0[lane];
                }
            });
        }
        predictions
    }

    fn forward(&mut self, number: usize, weights: &[f64]) {
        self.pass(number, weights, true);
    }

    /// Makes room for the intermediate results of a group; what is there stays.
    fn fit(&mut self, number: usize) {
        if self.fitted == Some(number) {
            return;
        }
        self.fitted = Some(number);
        let CellBatch { sizes, own, derivatives, groups, work, .. } = self;
        let group = &groups[number];
        let stride = group.layout.stride;
        work.outputs.resize(sizes.outputs * stride, Row8::default());
        fit_matrices(&mut work.own, own, stride);
        if !group.targets.is_empty() {
            work.output_deltas.resize(sizes.outputs * stride, Row8::default());
            work.carried.resize(2 * sizes.state * group.layout.start_stride, Row8::default());
            fit_matrices(&mut work.derivatives, derivatives, stride);
        }
    }

    /// A pass over a group, which begins with the first state or with the state that is there.
    fn pass(&mut self, number: usize, weights: &[f64], begins: bool) {
        self.fit(number);
        let CellBatch { isa, cell, groups, work, .. } = self;
        let group = &mut groups[number];
        let (isa, cell) = (*isa, *cell);
        if begins {
            dispatch(isa, Start { cell, weights, group, work });
        }
        dispatch(isa, Forward { cell, weights, group, work });
    }
}

impl<C: CellKernel> NextRows for CellBatch<C> {
    fn sizes(&self) -> CellSizes {
        self.sizes
    }

    fn advance(&mut self, weights: &[f64], begins: bool, inputs: &[f64], outputs: &mut [f64]) {
        let CellSizes { inputs: columns, outputs: width, .. } = self.sizes;
        self.groups[0].set_inputs(columns, inputs);
        self.pass(0, weights, begins);
        put_outputs(&self.groups[0].layout, &self.work.outputs, width, outputs);
    }

    fn carry(&mut self) {
        let CellBatch { cell, sizes, groups, work, .. } = self;
        let first = sizes.inputs + 1;
        let Group { layout, below, .. } = &mut groups[0];
        Group::carry(layout, below, first);
        for place in cell.carried() {
            Group::carry(layout, &mut work.own[*place], 0);
        }
    }

    fn state_values(&self) -> usize {
        self.sizes.state + self.cell.carried().iter().map(|place| self.own[*place]).sum::<usize>()
    }

    fn state(&self) -> Vec<f64> {
        let CellBatch { cell, sizes, groups, work, .. } = self;
        let Group { layout, below, .. } = &groups[0];
        let mut states = Group::values(layout, below, sizes.inputs + 1);
        for place in cell.carried() {
            let further = Group::values(layout, &work.own[*place], 0);
            states.iter_mut().zip(further).for_each(|(state, further)| state.extend(further));
        }
        states.concat()
    }

    fn set_state(&mut self, state: &[f64]) {
        self.fit(0);
        let width = self.state_values();
        let CellBatch { cell, sizes, own, groups, work, .. } = self;
        let Group { layout, below, .. } = &mut groups[0];
        for (lane, values) in state.chunks_exact(width).enumerate() {
            let (first, mut further) = values.split_at(sizes.state);
            Group::set_values(layout, below, sizes.inputs + 1, lane, first);
            for place in cell.carried() {
                let (part, rest) = further.split_at(own[*place]);
                Group::set_values(layout, &mut work.own[*place], 0, lane, part);
                further = rest;
            }
        }
    }
}

impl<C: CellKernel> Batch for CellBatch<C> {
    fn squared_error(&mut self, weights: &[f64]) -> f64 {
        let mut sum = 0.0;
        for number in 0..self.groups.len() {
            self.forward(number, weights);
            let (group, outputs) = (&self.groups[number], &self.work.outputs[..]);
            sum += dispatch(self.isa, SquaredError { group, outputs });
        }
        sum
    }

    fn gradient(&mut self, weights: &[f64], scale: f64, gradient: &mut [f64]) {
        gradient.fill(0.0);
        for number in 0..self.groups.len() {
            // With a single group, the results of the forward pass are still there.
            if self.groups.len() > 1 {
                self.forward(number, weights);
            }
            let CellBatch { isa, cell, groups, work, .. } = self;
            dispatch(*isa, Backward { cell: *cell, weights, group: &groups[number], work, scale, gradient });
        }
    }
}

struct Start<'a, C> {
    cell: C,
    weights: &'a [f64],
    group: &'a mut Group,
    work: &'a mut Work,
}

impl<C: CellKernel> Kernel for Start<'_, C> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        self.cell.start::<L>(self.weights, self.group, self.work);
    }
}

struct Forward<'a, C> {
    cell: C,
    weights: &'a [f64],
    group: &'a mut Group,
    work: &'a mut Work,
}

impl<C: CellKernel> Kernel for Forward<'_, C> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        self.cell.forward::<L>(self.weights, self.group, self.work);
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

struct Backward<'a, C> {
    cell: C,
    weights: &'a [f64],
    group: &'a Group,
    work: &'a mut Work,
    scale: f64,
    gradient: &'a mut [f64],
}

impl<C: CellKernel> Kernel for Backward<'_, C> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Group { layout, targets, weights, .. } = self.group;
        let Work { outputs, output_deltas, .. } = &mut *self.work;
        for o in 0..targets.len() / layout.stride {
            for at in o * layout.stride..o * layout.stride + layout.total() {
                let error = L::load(&outputs[at].0) - L::load(&targets[at].0);
                (L::load(&weights[at].0) * error * L::splat(self.scale)).store(&mut output_deltas[at].0);
            }
        }
        self.cell.backward::<L>(self.weights, self.group, self.work, self.gradient);
    }
}

fn fit_matrices(matrices: &mut Vec<Vec<Row8>>, rows: &[usize], stride: usize) {
    matrices.resize(rows.len(), Vec::new());
    for (matrix, rows) in matrices.iter_mut().zip(rows) {
        matrix.resize(*rows * stride, Row8::default());
    }
}

/// A row of ones.
pub(crate) fn ones(row: &mut [Row8]) {
    row.fill(Row8([1.0; LANES]));
}

/// The rows of a table in the form for a cell; `name` is used in messages.
pub(crate) fn rows_of<'a>(
    sizes: &CellSizes,
    name: &str,
    inputs: &'a [f64],
    sequences: Option<&'a Sequences>,
    data: Option<&'a Data>,
) -> Result<SequenceRows<'a>, TrainingError> {
    let refused = |text: String| Err(TrainingError::Rows(text));
    let Some(sequences) = sequences else {
        return refused(format!("a {name} needs rows that are divided into sequences"));
    };
    let (needed, found) = (sizes.starts, sequences.start_columns());
    if needed != found {
        return refused(format!("the {name} has {needed} start values, the sequences have {found}"));
    }
    if inputs.len() != sequences.rows() * sizes.inputs {
        let (rows, columns, found) = (sequences.rows(), sizes.inputs, inputs.len());
        return refused(format!("{rows} rows of {columns} inputs are needed, not {found} values"));
    }
    let (targets, weights) = (data.map(Data::targets), data.and_then(Data::weights));
    Ok(SequenceRows { inputs, sequences, targets, weights })
}

/// Refuses sizes that are zero or too large; `weights` are counted for possible layers alone, so that the count cannot overflow.
pub(crate) fn check_sizes(
    layers: &[usize],
    starts: usize,
    weights: impl FnOnce() -> usize,
) -> Result<(), NetworkError> {
    for (layer, &neurons) in layers.iter().enumerate() {
        if neurons == 0 || neurons > LARGEST_LAYER {
            return Err(NetworkError::Neurons { layer, neurons });
        }
    }
    let weights = weights();
    if starts > LARGEST_LAYER || weights > MOST_WEIGHTS {
        return Err(NetworkError::Weights(weights));
    }
    Ok(())
}

/// Refuses weights of the wrong number, or that are not finite.
pub(crate) fn check_weights(name: &str, needed: usize, weights: &[f64]) -> Result<(), NetworkError> {
    if weights.len() != needed {
        let text = format!("a {name} of this size needs {needed} weights, not {}", weights.len());
        return Err(NetworkError::GivenWeights(text));
    }
    if let Some(place) = weights.iter().position(|weight| !weight.is_finite()) {
        let text = format!("weight {place} is {}, which is not a finite number", weights[place]);
        return Err(NetworkError::GivenWeights(text));
    }
    Ok(())
}
