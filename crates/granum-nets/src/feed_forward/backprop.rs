//! Errors, gradients and sensitivities of a network over all rows of a table.
//!
//! Each lane of a vector holds one row. All memory that an epoch needs is allocated once.

use granum_simd::{Isa, Kernel, LANES, Lanes, Row8, dispatch, mul_add};

use crate::feed_forward::activation::Activation;
use crate::feed_forward::forward::{Layer, layer_panel};
use crate::feed_forward::network::Network;
use crate::linear_algebra::kernels::{Scalars, blocks, lane_dots, odd, panel, panels, scalar_times_lanes};
use crate::table::data::Data;

/// A table in the layout for training, with memory for the results of a pass over it.
#[derive(Clone)]
pub(crate) struct Workspace {
    pub isa: Isa,
    pub layers: Vec<Layer>,
    /// Number of rows of the table.
    pub rows: usize,
    /// Number of rows of each observation.
    pub points: usize,
    /// Number of lane blocks that hold the rows.
    pub blocks: usize,
    /// Distance between the rows of every lane matrix, in blocks.
    pub stride: usize,
    /// The inputs, followed by the outputs of each layer; each matrix has a last row of ones, which the bias multiplies.
    pub outputs: Vec<Vec<Row8>>,
    /// For each layer except the inputs, the derivatives with respect to the weighted sums from the last backward pass.
    pub deltas: Vec<Vec<Row8>>,
    /// Targets and weights of the squared errors, one row for each output neuron; the weight is zero in unused lanes.
    pub targets: Vec<Row8>,
    pub weights: Vec<Row8>,
    /// If an observation has several points: for every row the residual of its observation, after
    /// [`Workspace::squared_error`].
    shared: Vec<Row8>,
}

/// The values at the output neurons with which the backward pass starts.
#[derive(Clone, Copy)]
enum Seed {
    /// `scale * weight * (output - target)`: the gradient of `scale / 2` times the weighted sum of squares.
    Error(f64),
    /// The square root of the weight: the sensitivity of the weighted residuals.
    Residual,
}

impl Workspace {
    /// A workspace with `data` for a network of this shape.
    pub(crate) fn new(isa: Isa, network: &Network, data: &Data) -> Workspace {
        let layers = Layer::all(network);
        let (count, stride) = (blocks(data.rows), odd(blocks(data.rows)));
        let mut outputs: Vec<Vec<Row8>> =
            network.layers().iter().map(|n| vec![Row8::default(); (n + 1) * stride]).collect();
        let deltas = network.layers()[1..].iter().map(|n| vec![Row8::default(); n * stride]).collect();
        for (layer, neurons) in outputs.iter_mut().zip(network.layers()) {
            layer[neurons * stride..].fill(Row8([1.0; 8]));
        }
        let mut targets = vec![Row8::default(); data.target_columns * stride];
        let mut weights = targets.clone();
        across_lanes(&data.inputs, data.input_columns, &mut outputs[0], stride);
        for r in 0..data.rows {
            let (block, lane) = (r / LANES, r % LANES);
            for c in 0..data.target_columns {
                targets[c * stride + block].0[lane] = data.targets[r * data.target_columns + c];
                // The residual of an observation is the sum over its points of sqrt(weight / points) times their errors.
                let weight = data.weights.as_ref().map_or(1.0, |w| w[r]);
                weights[c * stride + block].0[lane] = weight / data.points as f64;
            }
        }
        let (rows, points) = (data.rows, data.points);
        let shared = if points > 1 { vec![Row8::default(); count] } else { Vec::new() };
        Workspace {
            isa,
            layers,
            rows,
            points,
            blocks: count,
            stride,
            outputs,
            deltas,
            targets,
            weights,
            shared,
        }
    }

    /// Replaces the inputs by those of as many other rows, in row-major order.
    pub(crate) fn set_inputs(&mut self, inputs: &[f64]) {
        across_lanes(inputs, inputs.len() / self.rows, &mut self.outputs[0], self.stride);
    }

    /// The first output of the network for each row, from the last forward pass.
    pub(crate) fn first_outputs(&self) -> impl Iterator<Item = f64> {
        let last = &self.outputs[self.layers.len()];
        (0..self.rows).map(|row| last[row / LANES].0[row % LANES])
    }

    /// Number of observations.
    pub(crate) fn observations(&self) -> usize {
        self.rows / self.points
    }

    /// A workspace with some of the rows of this one and the results of the last passes over them; each row is treated as a
    /// separate observation.
    pub(crate) fn some_rows(&self, chosen: &[usize]) -> Workspace {
        let (count, stride) = (blocks(chosen.len()), odd(blocks(chosen.len())));
        let gather = |matrix: &Vec<Row8>| {
            let height = matrix.len() / self.stride;
            let mut some = vec![Row8::default(); height * stride];
            for k in 0..height {
                for (r, &row) in chosen.iter().enumerate() {
                    some[k * stride + r / LANES].0[r % LANES] =
                        matrix[k * self.stride + row / LANES].0[row % LANES];
                }
            }
            some
        };
        Workspace {
            isa: self.isa,
            layers: self.layers.clone(),
            rows: chosen.len(),
            points: 1,
            blocks: count,
            stride,
            outputs: self.outputs.iter().map(gather).collect(),
            deltas: self.deltas.iter().map(gather).collect(),
            targets: gather(&self.targets),
            weights: gather(&self.weights),
            shared: Vec::new(),
        }
    }

    /// Sums over the points of each observation, from one lane per row to one lane per observation.
    pub(crate) fn sum_points(&self, rows: &[Row8], observations: &mut [Row8]) {
        if self.points == 1 {
            observations[..self.blocks].copy_from_slice(&rows[..self.blocks]);
            return;
        }
        let numbers = &Row8::numbers(rows)[..self.rows];
        for (k, points) in numbers.chunks_exact(self.points).enumerate() {
            observations[k / LANES].0[k % LANES] = points.iter().fold(0.0, |sum, v| sum + v);
        }
    }

    /// Copies the value of each observation to all of its rows.
    fn share(&self, observations: &[Row8], rows: &mut [Row8]) {
        let numbers = Row8::numbers(observations);
        for r in 0..self.rows {
            rows[r / LANES].0[r % LANES] = numbers[r / self.points];
        }
    }

    /// A workspace with one row for every residual: with several targets, each row is repeated for each target.
    pub(crate) fn for_residuals(isa: Isa, network: &Network, data: &Data) -> Workspace {
        if data.target_columns == 1 {
            return Workspace::new(isa, network, data);
        }
        let (m, rows) = (data.target_columns, data.rows);
        let repeated = Data {
            rows: rows * m,
            inputs: data.inputs.repeat(m),
            targets: data.targets.repeat(m),
            weights: data.weights.as_ref().map(|w| w.repeat(m)),
            blocks: Vec::new(),
            sequences: None,
            validation: None,
            ..*data
        };
        let mut workspace = Workspace::new(isa, network, &repeated);
        for r in 0..rows * m {
            for c in (0..m).filter(|&c| c != r / rows) {
                workspace.weights[c * workspace.stride + r / LANES].0[r % LANES] = 0.0;
            }
        }
        workspace
    }

    /// Size of a workspace for so many rows, bytes.
    pub(crate) fn bytes(network: &Network, rows: usize) -> usize {
        let neurons: usize = network.layers().iter().map(|n| 2 * n + 1).sum();
        neurons * odd(blocks(rows)) * size_of::<Row8>()
    }

    /// Evaluates the network for all rows and returns the weighted sum of squared errors over the observations.
    pub(crate) fn squared_error(&mut self, weights: &[f64]) -> f64 {
        let sum = dispatch(self.isa, SquaredError { workspace: self, weights });
        if self.points == 1 {
            return sum;
        }
        let mut residuals = vec![Row8::default(); blocks(self.observations())];
        self.residuals(&mut residuals);
        let mut shared = std::mem::take(&mut self.shared);
        self.share(&residuals, &mut shared);
        self.shared = shared;
        Row8::numbers(&residuals).iter().fold(0.0, |sum, e| mul_add(*e, *e, sum))
    }

    /// Gradient of `scale / 2` times the weighted sum of squared errors, after [`Workspace::squared_error`] with the
    /// same weights.
    pub(crate) fn gradient(&mut self, weights: &[f64], scale: f64, gradient: &mut [f64]) {
        dispatch(self.isa, Back { workspace: self, weights, seed: Seed::Error(scale) });
        dispatch(self.isa, Gradient { workspace: self, factors: None, gradient });
    }

    /// Stores in `deltas` the derivatives of the weighted output of each row with respect to the weighted sums of all
    /// neurons.
    pub(crate) fn sensitivities(&mut self, weights: &[f64]) {
        dispatch(self.isa, Back { workspace: self, weights, seed: Seed::Residual });
    }

    /// Weighted residuals `sqrt(weight) (output - target)`, one lane per observation, after [`Workspace::squared_error`].
    pub(crate) fn residuals(&self, residuals: &mut [Row8]) {
        if self.points == 1 {
            return dispatch(self.isa, Residuals { workspace: self, residuals });
        }
        let mut rows = vec![Row8::default(); self.blocks];
        dispatch(self.isa, Residuals { workspace: self, residuals: &mut rows });
        self.sum_points(&rows, residuals);
    }

    /// `J v`, one lane per observation, with the Jacobian `J` of the weighted residuals, after [`Workspace::sensitivities`].
    pub(crate) fn jacobian_times(&self, vector: &[f64], product: &mut [Row8]) {
        if self.points == 1 {
            return dispatch(self.isa, JacobianTimes { workspace: self, vector, product });
        }
        let mut rows = vec![Row8::default(); self.blocks];
        dispatch(self.isa, JacobianTimes { workspace: self, vector, product: &mut rows });
        self.sum_points(&rows, product);
    }

    /// `J^T s` with one number `s` per observation, after [`Workspace::sensitivities`].
    pub(crate) fn transposed_jacobian_times(&mut self, factors: &[Row8], product: &mut [f64]) {
        if self.points == 1 {
            return dispatch(
                self.isa,
                Gradient { workspace: self, factors: Some(factors), gradient: product },
            );
        }
        let mut rows = vec![Row8::default(); self.blocks];
        self.share(factors, &mut rows);
        dispatch(self.isa, Gradient { workspace: self, factors: Some(&rows), gradient: product });
    }
}

/// Puts rows of so many columns into a lane matrix.
fn across_lanes(rows: &[f64], columns: usize, lanes: &mut [Row8], stride: usize) {
    for (r, row) in rows.chunks_exact(columns).enumerate() {
        for (c, value) in row.iter().enumerate() {
            lanes[c * stride + r / LANES].0[r % LANES] = *value;
        }
    }
}

struct SquaredError<'a> {
    workspace: &'a mut Workspace,
    weights: &'a [f64],
}

impl Kernel for SquaredError<'_> {
    type Output = f64;
    #[inline(always)]
    fn run<L: Lanes>(self) -> f64 {
        let w = self.workspace;
        panels(
            0,
            w.blocks,
            panel::<L>(),
            #[inline(always)]
            |first, width| {
                for (l, layer) in w.layers.iter().enumerate() {
                    let (before, after) = w.outputs.split_at_mut(l + 1);
                    layer_panel::<L>(layer, self.weights, &before[l], &mut after[0], w.stride, first, width);
                }
            },
        );
        let last = &w.outputs[w.layers.len()];
        let mut sum = L::zero();
        for c in 0..w.targets.len() / w.stride {
            for at in c * w.stride..c * w.stride + w.blocks {
                let error = L::load(&last[at].0) - L::load(&w.targets[at].0);
                sum = (L::load(&w.weights[at].0) * error).mul_add(error, sum);
            }
        }
        sum.reduce_add()
    }
}

struct Back<'a> {
    workspace: &'a mut Workspace,
    weights: &'a [f64],
    seed: Seed,
}

impl Kernel for Back<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let w = self.workspace;
        let depth = w.layers.len();
        let last = &mut w.deltas[depth - 1];
        for c in 0..w.layers[depth - 1].neurons {
            for at in c * w.stride..c * w.stride + w.blocks {
                let y = L::load(&w.outputs[depth][at].0);
                let weight = L::load(&w.weights[at].0);
                let start = match self.seed {
                    Seed::Error(scale) if w.points > 1 => {
                        weight.sqrt() * L::load(&w.shared[at].0) * L::splat(scale)
                    }
                    Seed::Error(scale) => weight * (y - L::load(&w.targets[at].0)) * L::splat(scale),
                    Seed::Residual => weight.sqrt(),
                };
                (start * w.layers[depth - 1].activation.slope(y)).store(&mut last[at].0);
            }
        }
        // Panels are one block narrower than in the forward pass, so that the compiler keeps all sums in registers.
        panels(
            0,
            w.blocks,
            if const { L::REGISTERS >= 32 } { 4 } else { 1 },
            #[inline(always)]
            |first, width| {
                for l in (1..depth).rev() {
                    let layer = &w.layers[l];
                    let (before, after) = w.deltas.split_at_mut(l);
                    let (target, stride) = (&mut before[l - 1], w.stride);
                    scalar_times_lanes::<L, 5, 4>(
                        Scalars { values: layer.matrix(self.weights), by_k: layer.inputs + 1, by_j: 1 },
                        layer.inputs,
                        layer.neurons,
                        &after[0],
                        stride,
                        first,
                        width,
                        #[inline(always)]
                        |_, _| L::zero(),
                        #[inline(always)]
                        |i, b, sum| sum.store(&mut target[i * stride + b].0),
                    );
                    let outputs = &w.outputs[l];
                    match w.layers[l - 1].activation {
                        Activation::Tanh => times_slope::<L>(
                            target,
                            outputs,
                            layer.inputs,
                            stride,
                            first,
                            width,
                            #[inline(always)]
                            |y| Activation::Tanh.slope(y),
                        ),
                        Activation::Sigmoid => times_slope::<L>(
                            target,
                            outputs,
                            layer.inputs,
                            stride,
                            first,
                            width,
                            #[inline(always)]
                            |y| Activation::Sigmoid.slope(y),
                        ),
                        Activation::Linear => {}
                    }
                }
            },
        );
    }
}

/// Multiplies the derivatives with respect to the outputs of neurons by the slope of their activation.
#[inline(always)]
fn times_slope<L: Lanes>(
    deltas: &mut [Row8],
    outputs: &[Row8],
    neurons: usize,
    stride: usize,
    first: usize,
    width: usize,
    slope: impl Fn(L) -> L,
) {
    for j in 0..neurons {
        let at = j * stride + first;
        for (delta, y) in deltas[at..at + width].iter_mut().zip(&outputs[at..at + width]) {
            (L::load(&delta.0) * slope(L::load(&y.0))).store(&mut delta.0);
        }
    }
}

struct Gradient<'a> {
    workspace: &'a mut Workspace,
    /// Factors of the contributions of the rows.
    factors: Option<&'a [Row8]>,
    gradient: &'a mut [f64],
}

impl Kernel for Gradient<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let w = self.workspace;
        let mut scaled = Vec::new();
        for (l, layer) in w.layers.iter().enumerate() {
            let row = layer.inputs + 1;
            let target = &mut self.gradient[layer.at..layer.at + layer.weights()];
            let deltas = match self.factors {
                None => &w.deltas[l],
                Some(factors) => {
                    scaled.clone_from(&w.deltas[l]);
                    for j in 0..layer.neurons {
                        for b in 0..w.blocks {
                            let delta = &mut scaled[j * w.stride + b].0;
                            (L::load(delta) * L::load(&factors[b].0)).store(delta);
                        }
                    }
                    &scaled
                }
            };
            lane_dots::<L>(
                deltas,
                layer.neurons,
                &w.outputs[l],
                row,
                w.stride,
                w.blocks,
                #[inline(always)]
                |j, i, sum| {
                    target[j * row + i] = sum;
                },
            );
        }
    }
}

struct Residuals<'a> {
    workspace: &'a Workspace,
    residuals: &'a mut [Row8],
}

impl Kernel for Residuals<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let w = self.workspace;
        let last = &w.outputs[w.layers.len()];
        for b in 0..w.blocks {
            // At most one of several outputs has a non-zero weight.
            let mut sum = L::zero();
            for c in 0..w.targets.len() / w.stride {
                let at = c * w.stride + b;
                let error = L::load(&last[at].0) - L::load(&w.targets[at].0);
                sum = L::load(&w.weights[at].0).sqrt().mul_add(error, sum);
            }
            sum.store(&mut self.residuals[b].0);
        }
    }
}

struct JacobianTimes<'a> {
    workspace: &'a Workspace,
    vector: &'a [f64],
    product: &'a mut [Row8],
}

impl Kernel for JacobianTimes<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let w = self.workspace;
        self.product[..w.blocks].fill(Row8::default());
        for (l, layer) in w.layers.iter().enumerate() {
            let row = layer.inputs + 1;
            let (deltas, stride) = (&w.deltas[l], w.stride);
            let product = &mut *self.product;
            panels(
                0,
                w.blocks,
                panel::<L>(),
                #[inline(always)]
                |first, width| {
                    scalar_times_lanes::<L, 5, 5>(
                        Scalars { values: layer.matrix(self.vector), by_k: 1, by_j: row },
                        layer.neurons,
                        row,
                        &w.outputs[l],
                        stride,
                        first,
                        width,
                        #[inline(always)]
                        |_, _| L::zero(),
                        #[inline(always)]
                        |j, b, sum| {
                            let delta = L::load(&deltas[j * stride + b].0);
                            delta.mul_add(sum, L::load(&product[b].0)).store(&mut product[b].0);
                        },
                    );
                },
            );
        }
    }
}
