//! Feed-forward networks as graphs, with the uncertainty that their training rows leave.
//!
//! With the gradient `g` of the output of a network with respect to its weights, and the directions `v_d` that the training rows determine,
//!
//! ```text
//! variance = 1 / beta + (g . g - sum_d (v_d . g)^2 + sum_d open_d (v_d . g)^2) / alpha
//! ```
//!
//! as in [`granum_nets::Model::deviations_of`]. The gradient is a product of the outputs of a layer and of the derivatives with respect to the weighted sums of the next
//! one, so that the graph has the layers once forwards and once backwards.

use granum_nets::{Activation, Model, Network, Scaler, Uncertainty};

use super::graph::{OnnxGraph, Value};
use super::interpolated::interpolated;

/// What a network predicts for rows: its value in the unit of the output, and the standard deviation of observations.
pub struct OnnxNetwork {
    /// A column with the value of each row.
    pub values: Value,
    /// A column with the standard deviation of each observation; `None` if the network does not provide it.
    pub deviations: Option<Value>,
}

/// The network of a model for a table of its inputs, in their units; an observation is the mean of so many successive rows.
pub fn network(graph: &mut OnnxGraph, model: &Model, inputs: &Value, points: usize) -> OnnxNetwork {
    let scaled = scaled(graph, model.input_scalers(), inputs);
    let passed = layers(graph, model.network(), scaled);
    let output = std::slice::from_ref(model.output_scaler());
    let values = unscaled(graph, output, &passed[passed.len() - 1]);
    let deviations = model.uncertainty().map(|known| {
        let gradient = gradient(graph, model.network(), &passed);
        let variance = variance(graph, &known, &gradient, points);
        let deviation = graph.apply("Sqrt", &[&variance]);
        let unit = graph.number(model.output_scaler().inverse_factor());
        let deviation = graph.apply("Mul", &[&deviation, &unit]);
        match factor(graph, model, inputs, points) {
            Some(factor) => graph.apply("Mul", &[&deviation, &factor]),
            None => deviation,
        }
    });
    OnnxNetwork { values, deviations }
}

/// A table in the scaled units of a network.
pub fn scaled(graph: &mut OnnxGraph, scalers: &[Scaler], table: &Value) -> Value {
    let numbers = |number: fn(&Scaler) -> f64| scalers.iter().map(number).collect::<Vec<f64>>();
    graph.scaled(table, &numbers(|s| s.minimum), &numbers(Scaler::factor), &numbers(Scaler::offset))
}

/// A table of scaled outputs in their units.
pub fn unscaled(graph: &mut OnnxGraph, scalers: &[Scaler], table: &Value) -> Value {
    let numbers = |number: fn(&Scaler) -> f64| scalers.iter().map(number).collect::<Vec<f64>>();
    graph.scaled(table, &numbers(Scaler::offset), &numbers(Scaler::inverse_factor), &numbers(|s| s.minimum))
}

/// The inputs and the outputs of all layers.
fn layers(graph: &mut OnnxGraph, network: &Network, inputs: Value) -> Vec<Value> {
    let mut passed = vec![inputs];
    for layer in matrices(network) {
        let transposed: Vec<f64> =
            (0..layer.inputs).flat_map(|input| layer.rows().map(move |row| row[input])).collect();
        let bias: Vec<f64> = layer.rows().map(|row| row[layer.inputs]).collect();
        let sums = graph.linear(&passed[passed.len() - 1], layer.inputs, &transposed, Some(&bias));
        passed.push(match layer.activation {
            Activation::Tanh => graph.apply("Tanh", &[&sums]),
            Activation::Sigmoid => graph.apply("Sigmoid", &[&sums]),
            Activation::Linear => sums,
        });
    }
    passed
}

/// A layer with its weights: for each neuron those of its inputs, and its bias.
struct LayerMatrix<'a> {
    inputs: usize,
    neurons: usize,
    activation: Activation,
    weights: &'a [f64],
}

impl<'a> LayerMatrix<'a> {
    fn rows(&self) -> impl Iterator<Item = &'a [f64]> + use<'a> {
        self.weights.chunks_exact(self.inputs + 1)
    }
}

fn matrices(network: &Network) -> Vec<LayerMatrix<'_>> {
    let mut rest = network.weights();
    let shapes = network.layers().windows(2).zip(network.activations());
    let layer = |(shape, activation): (&[usize], &Activation)| {
        let (weights, others) = rest.split_at((shape[0] + 1) * shape[1]);
        rest = others;
        LayerMatrix { inputs: shape[0], neurons: shape[1], activation: *activation, weights }
    };
    shapes.map(layer).collect()
}

/// The derivatives of the output with respect to all weights, a row for each row of inputs, in the order of the weights.
fn gradient(graph: &mut OnnxGraph, network: &Network, passed: &[Value]) -> Value {
    let matrices = matrices(network);
    let mut parts = Vec::new();
    let mut above: Option<Value> = None;
    for (k, layer) in matrices.iter().enumerate().rev() {
        let slope = slope(graph, layer.activation, &passed[k + 1]);
        let deltas = match &above {
            Some(above) => graph.apply("Mul", &[above, &slope]),
            None => slope,
        };
        parts.push(products(graph, &deltas, &passed[k], layer));
        let plain: Vec<f64> = layer.rows().flat_map(|row| row[..layer.inputs].to_vec()).collect();
        above = Some(graph.linear(&deltas, layer.neurons, &plain, None));
    }
    parts.reverse();
    graph.beside(&parts.iter().collect::<Vec<_>>())
}

/// The derivatives with respect to the weights of a layer.
fn products(graph: &mut OnnxGraph, deltas: &Value, below: &Value, layer: &LayerMatrix) -> Value {
    let zero = graph.number(0.0);
    let one = graph.number(1.0);
    let first = graph.columns(below, &[0]);
    let zeros = graph.apply("Mul", &[&first, &zero]);
    let ones = graph.apply("Add", &[&zeros, &one]);
    let below = graph.beside(&[below, &ones]);
    let (last, middle) = (graph.integers(&[2]), graph.integers(&[1]));
    let (columns, rows) =
        (graph.apply("Unsqueeze", &[deltas, &last]), graph.apply("Unsqueeze", &[&below, &middle]));
    let products = graph.apply("Mul", &[&columns, &rows]);
    let shape = graph.integers(&[-1, ((layer.inputs + 1) * layer.neurons) as i64]);
    graph.apply("Reshape", &[&products, &shape])
}

/// The derivative of an activation from its value: `1 - y^2`, `y (1 - y)` or 1.
fn slope(graph: &mut OnnxGraph, activation: Activation, y: &Value) -> Value {
    let one = graph.number(1.0);
    match activation {
        Activation::Tanh => {
            let square = graph.apply("Mul", &[y, y]);
            graph.apply("Sub", &[&one, &square])
        }
        Activation::Sigmoid => {
            let rest = graph.apply("Sub", &[&one, y]);
            graph.apply("Mul", &[y, &rest])
        }
        Activation::Linear => {
            let zero = graph.number(0.0);
            let zeros = graph.apply("Mul", &[y, &zero]);
            graph.apply("Add", &[&zeros, &one])
        }
    }
}

fn variance(graph: &mut OnnxGraph, known: &Uncertainty, gradient: &Value, points: usize) -> Value {
    let gradient =
        if points == 1 { gradient.clone() } else { sum_of_points(graph, gradient, points, known.weights) };
    let squares = graph.apply("Mul", &[&gradient, &gradient]);
    let own = graph.sum_of_rows(&squares);
    let count = known.open.len();
    let along = graph.linear(&gradient, known.weights, &known.directions, None);
    let squares = graph.apply("Mul", &[&along, &along]);
    let determined = graph.sum_of_rows(&squares);
    let open = graph.linear(&squares, count, &known.open, None);
    let zero = graph.number(0.0);
    let rest = graph.apply("Sub", &[&own, &determined]);
    let rest = graph.apply("Max", &[&rest, &zero]);
    let sum = graph.apply("Add", &[&rest, &open]);
    let per_alpha = graph.number(1.0 / known.alpha);
    let of_weights = graph.apply("Mul", &[&sum, &per_alpha]);
    let noise = graph.number(1.0 / known.beta);
    graph.apply("Add", &[&of_weights, &noise])
}

/// The sum of the successive rows of an observation, over the square root of their number.
fn sum_of_points(graph: &mut OnnxGraph, table: &Value, points: usize, columns: usize) -> Value {
    let (shape, axis) = (graph.integers(&[-1, points as i64, columns as i64]), graph.integers(&[1]));
    let grouped = graph.apply("Reshape", &[table, &shape]);
    let sums = graph.apply_with("ReduceSum", &[&grouped, &axis], &[("keepdims", 0)]);
    let scale = graph.number(1.0 / (points as f64).sqrt());
    graph.apply("Mul", &[&sums, &scale])
}

/// The mean of the successive rows of an observation.
pub fn mean_of_points(graph: &mut OnnxGraph, column: &Value, points: usize) -> Value {
    if points == 1 {
        return column.clone();
    }
    let shape = graph.integers(&[-1, points as i64]);
    let grouped = graph.apply("Reshape", &[column, &shape]);
    let sums = graph.sum_of_rows(&grouped);
    let share = graph.number(1.0 / points as f64);
    graph.apply("Mul", &[&sums, &share])
}

/// The factor on standard deviations from left-out blocks: linear between its values, constant beyond them.
fn factor(graph: &mut OnnxGraph, model: &Model, inputs: &Value, points: usize) -> Option<Value> {
    let intervals = model.training_fit().intervals.as_ref()?;
    let column = model.inputs().iter().position(|input| Some(&input.name) == intervals.input.as_ref());
    if intervals.factors.len() == 1 {
        return Some(graph.number(intervals.factors[0]));
    }
    let Some(column) = column else { return Some(graph.number(intervals.factor(0.0))) };
    let mut place = graph.columns(inputs, &[column]);
    if points > 1 {
        // That of the first row of an observation.
        let shape = graph.integers(&[-1, points as i64]);
        let grouped = graph.apply("Reshape", &[&place, &shape]);
        place = graph.columns(&grouped, &[0]);
    }
    Some(interpolated(graph, &place, &intervals.at, &intervals.factors))
}
