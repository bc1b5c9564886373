//! Evaluation of a network: for batches and training in panels of lane blocks with rows across the lanes, and for a single
//! row with neurons across the lanes.

use granum_simd::{Isa, Kernel, LANES, Lanes, Real, Row8, dispatch, sigmoid, tanh};

use crate::feed_forward::activation::Activation;
use crate::feed_forward::network::{Network, NetworkError};
use crate::linear_algebra::kernels::{Scalars, blocks, odd, scalar_times_lanes};
use crate::table::scaler::Scaler;

/// Number of lane blocks in a chunk of a batch, such that its activations stay in the first-level cache.
const CHUNK: usize = 5;

/// The matrix of one layer (neurons x (inputs + 1), the bias last) as a part of the flat array of weights.
#[derive(Clone, Copy)]
pub(crate) struct Layer {
    pub inputs: usize,
    pub neurons: usize,
    pub activation: Activation,
    /// Index of the first element in the flat array of weights.
    pub at: usize,
}

impl Layer {
    pub(crate) fn all(network: &Network) -> Vec<Layer> {
        let mut at = 0;
        let shapes = network.layers().windows(2).zip(network.activations());
        shapes
            .map(|(shape, &activation)| {
                let layer = Layer { inputs: shape[0], neurons: shape[1], activation, at };
                at += layer.weights();
                layer
            })
            .collect()
    }

    pub(crate) fn weights(&self) -> usize {
        (self.inputs + 1) * self.neurons
    }

    pub(crate) fn matrix<'a>(&self, weights: &'a [f64]) -> &'a [f64] {
        &weights[self.at..self.at + self.weights()]
    }
}

/// Outputs of one layer for the lane blocks `first..first + width` (at most [`crate::linear_algebra::kernels::panel`]).
#[inline(always)]
pub(crate) fn layer_panel<L: Lanes>(
    layer: &Layer,
    weights: &[f64],
    inputs: &[Row8],
    outputs: &mut [Row8],
    stride: usize,
    first: usize,
    width: usize,
) {
    let matrix = layer.matrix(weights);
    let row = layer.inputs + 1;
    scalar_times_lanes::<L, 5, 5>(
        Scalars { values: matrix, by_k: 1, by_j: row },
        layer.neurons,
        layer.inputs,
        inputs,
        stride,
        first,
        width,
        #[inline(always)]
        |j, _| L::splat(matrix[j * row + layer.inputs]),
        #[inline(always)]
        |j, b, sum| sum.store(&mut outputs[j * stride + b].0),
    );
    match layer.activation {
        Activation::Tanh => activate::<L>(
            outputs,
            layer.neurons,
            stride,
            first,
            width,
            #[inline(always)]
            |x| tanh(x),
        ),
        Activation::Sigmoid => activate::<L>(
            outputs,
            layer.neurons,
            stride,
            first,
            width,
            #[inline(always)]
            |x| sigmoid(x),
        ),
        Activation::Linear => {}
    }
}

#[inline(always)]
fn activate<L: Lanes>(
    values: &mut [Row8],
    neurons: usize,
    stride: usize,
    first: usize,
    width: usize,
    f: impl Fn(L) -> L,
) {
    for j in 0..neurons {
        for value in &mut values[j * stride + first..j * stride + first + width] {
            f(L::load(&value.0)).store(&mut value.0);
        }
    }
}

/// Scalers of the inputs and outputs of a model.
#[derive(Clone, Copy)]
pub(crate) struct Scalers<'a> {
    pub inputs: &'a [Scaler],
    pub outputs: &'a [Scaler],
}

impl Network {
    /// The outputs, `rows x outputs`, for many rows of inputs, `rows x inputs`, both in row-major order.
    ///
    /// # Errors
    /// If `inputs` does not contain a whole number of rows.
    pub fn forward(&self, inputs: &[f64]) -> Result<Vec<f64>, NetworkError> {
        self.forward_on(Isa::detect(), inputs)
    }

    /// As [`Network::forward`] with a given instruction set; the result does not depend on it.
    ///
    /// # Errors
    /// As [`Network::forward`].
    pub fn forward_on(&self, isa: Isa, inputs: &[f64]) -> Result<Vec<f64>, NetworkError> {
        let columns = self.inputs();
        if !inputs.len().is_multiple_of(columns) {
            let text = format!("{} values are not a whole number of rows of {columns} inputs", inputs.len());
            return Err(NetworkError::Row(text));
        }
        let mut outputs = vec![0.0; inputs.len() / columns * self.outputs()];
        batch(isa, self, None, inputs, &mut outputs);
        Ok(outputs)
    }
}

/// Outputs for a flat table of rows; inputs and outputs are scaled if scalers are given.
pub(crate) fn batch(
    isa: Isa,
    network: &Network,
    scalers: Option<Scalers>,
    inputs: &[f64],
    outputs: &mut [f64],
) {
    dispatch(isa, Batch { network, scalers, inputs, outputs });
}

struct Batch<'a> {
    network: &'a Network,
    scalers: Option<Scalers<'a>>,
    inputs: &'a [f64],
    outputs: &'a mut [f64],
}

impl Kernel for Batch<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let layers = Layer::all(self.network);
        let (columns, results) = (self.network.inputs(), self.network.outputs());
        let rows = self.inputs.len() / columns;
        let widest = self.network.layers().iter().copied().max().unwrap_or(0);
        let stride = odd(CHUNK);
        let mut now = vec![Row8::default(); widest * stride];
        let mut next = now.clone();
        let mut row = 0;
        while row < rows {
            let count = (rows - row).min(CHUNK * LANES);
            let source = &self.inputs[row * columns..(row + count) * columns];
            load_columns::<L::Scalar>(
                source,
                columns,
                count,
                self.scalers.map(|s| s.inputs),
                &mut now,
                stride,
            );
            for layer in &layers {
                let width = crate::linear_algebra::kernels::panel::<L>();
                let mut first = 0;
                while first < blocks(count) {
                    let width = width.min(blocks(count) - first);
                    layer_panel::<L>(layer, self.network.weights(), &now, &mut next, stride, first, width);
                    first += width;
                }
                std::mem::swap(&mut now, &mut next);
            }
            let target = &mut self.outputs[row * results..(row + count) * results];
            store_columns::<L>(target, results, count, self.scalers.map(|s| s.outputs), &mut now, stride);
            row += count;
        }
    }
}

/// Transposes rows into lanes. Lanes beyond the last row remain unchanged.
#[inline(always)]
fn load_columns<R: Real>(
    source: &[f64],
    columns: usize,
    count: usize,
    scalers: Option<&[Scaler]>,
    lanes: &mut [Row8],
    stride: usize,
) {
    for c in 0..columns {
        let (minimum, factor, offset) = match scalers {
            Some(s) => (s[c].minimum, s[c].factor(), s[c].offset()),
            None => (0.0, 1.0, 0.0),
        };
        for r in 0..count {
            let value = source[r * columns + c];
            let scaled = if scalers.is_some() {
                R::splat(value - minimum).mul_add(R::splat(factor), R::splat(offset)).reduce_add()
            } else {
                value
            };
            lanes[c * stride + r / LANES].0[r % LANES] = scaled;
        }
    }
}

#[inline(always)]
fn store_columns<L: Lanes>(
    target: &mut [f64],
    columns: usize,
    count: usize,
    scalers: Option<&[Scaler]>,
    lanes: &mut [Row8],
    stride: usize,
) {
    for c in 0..columns {
        if let Some(s) = scalers {
            let (offset, factor, minimum) =
                (L::splat(s[c].offset()), L::splat(s[c].inverse_factor()), L::splat(s[c].minimum));
            for value in &mut lanes[c * stride..c * stride + blocks(count)] {
                (L::load(&value.0) - offset).mul_add(factor, minimum).store(&mut value.0);
            }
        }
        for r in 0..count {
            target[r * columns + c] = lanes[c * stride + r / LANES].0[r % LANES];
        }
    }
}

/// A network prepared for the evaluation of single rows, with neurons across the lanes and transposed, padded matrices.
#[derive(Clone, Debug)]
pub(crate) struct RowNetwork {
    layers: Vec<RowLayer>,
    widest: usize,
}

#[derive(Clone, Debug)]
struct RowLayer {
    activation: Activation,
    neurons: usize,
    inputs: usize,
    /// Rows of `blocks(neurons)` lane blocks: row `i` holds the weights of input `i`, and row `inputs` the biases.
    matrix: Vec<Row8>,
}

impl RowNetwork {
    pub(crate) fn new(network: &Network) -> RowNetwork {
        let layers = Layer::all(network)
            .iter()
            .map(|layer| {
                let width = blocks(layer.neurons);
                let mut matrix = vec![Row8::default(); width * (layer.inputs + 1)];
                for (index, &weight) in layer.matrix(network.weights()).iter().enumerate() {
                    let (j, i) = (index / (layer.inputs + 1), index % (layer.inputs + 1));
                    matrix[i * width + j / LANES].0[j % LANES] = weight;
                }
                RowLayer {
                    activation: layer.activation,
                    neurons: layer.neurons,
                    inputs: layer.inputs,
                    matrix,
                }
            })
            .collect();
        let widest = network.layers().iter().map(|&n| blocks(n)).max().unwrap_or(0);
        RowNetwork { layers, widest }
    }

    /// Outputs for one row of network inputs, given by `input(i)`.
    pub(crate) fn evaluate(&self, isa: Isa, input: impl Fn(usize) -> f64, outputs: &mut [f64]) {
        // Networks with up to 128 neurons per layer are evaluated without heap memory.
        const SMALL: usize = 16;
        if self.widest <= SMALL {
            let (mut now, mut next) = ([Row8::default(); SMALL], [Row8::default(); SMALL]);
            self.fill(&mut now, input);
            dispatch(isa, OneRow { network: self, now: &mut now, next: &mut next, outputs });
        } else {
            let (mut now, mut next) =
                (vec![Row8::default(); self.widest], vec![Row8::default(); self.widest]);
            self.fill(&mut now, input);
            dispatch(isa, OneRow { network: self, now: &mut now, next: &mut next, outputs });
        }
    }

    fn fill(&self, now: &mut [Row8], input: impl Fn(usize) -> f64) {
        for i in 0..self.layers[0].inputs {
            now[i / LANES].0[i % LANES] = input(i);
        }
    }
}

struct OneRow<'a> {
    network: &'a RowNetwork,
    now: &'a mut [Row8],
    next: &'a mut [Row8],
    outputs: &'a mut [f64],
}

impl Kernel for OneRow<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let (mut now, mut next) = (self.now, self.next);
        for layer in &self.network.layers {
            let width = blocks(layer.neurons);
            let mut b = 0;
            while b < width {
                // Eight independent chains of fused multiply-adds hide their latency if there are enough registers.
                let step = if L::REGISTERS >= 32 && width - b >= 8 {
                    row_tile::<L, 8>(layer, width, b, now, next)
                } else if width - b >= 4 {
                    row_tile::<L, 4>(layer, width, b, now, next)
                } else if width - b >= 2 {
                    row_tile::<L, 2>(layer, width, b, now, next)
                } else {
                    row_tile::<L, 1>(layer, width, b, now, next)
                };
                b += step;
            }
            std::mem::swap(&mut now, &mut next);
        }
        for (o, output) in self.outputs.iter_mut().enumerate() {
            *output = now[o / LANES].0[o % LANES];
        }
    }
}

#[inline(always)]
fn row_tile<L: Lanes, const B: usize>(
    layer: &RowLayer,
    width: usize,
    b: usize,
    now: &[Row8],
    next: &mut [Row8],
) -> usize {
    let mut sums = [L::zero(); B];
    let bias = &layer.matrix[layer.inputs * width + b..][..B];
    for l in 0..B {
        sums[l] = L::load(&bias[l].0);
    }
    for i in 0..layer.inputs {
        let value = L::splat(now[i / LANES].0[i % LANES]);
        let row = &layer.matrix[i * width + b..][..B];
        for l in 0..B {
            sums[l] = L::load(&row[l].0).mul_add(value, sums[l]);
        }
    }
    for l in 0..B {
        layer.activation.value(sums[l]).store(&mut next[b + l].0);
    }
    B
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn row_by_row(network: &Network, isa: Isa, inputs: &[f64]) -> Vec<f64> {
        let rows = RowNetwork::new(network);
        let mut outputs = Vec::new();
        for row in inputs.chunks(network.inputs()) {
            let mut output = vec![0.0; network.outputs()];
            rows.evaluate(isa, |i| row[i], &mut output);
            outputs.extend(output);
        }
        outputs
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]
        #[test]
        fn one_row_a_batch_and_every_instruction_set_give_the_same_bits(
            layers in proptest::collection::vec(1usize..23, 2..5),
            rows in 1usize..60,
            seed in any::<u64>(),
        ) {
            let network = Network::new(&layers, seed).unwrap();
            let inputs: Vec<f64> =
                (0..rows * layers[0]).map(|k| ((k as f64 + seed as f64 * 1e-19) * 0.7).sin()).collect();
            let reference = network.forward_on(Isa::Portable, &inputs).unwrap();
            for isa in Isa::ALL.into_iter().filter(|i| i.available()) {
                prop_assert_eq!(&network.forward_on(isa, &inputs).unwrap(), &reference);
                prop_assert_eq!(&row_by_row(&network, isa, &inputs), &reference);
            }
        }
    }
}
