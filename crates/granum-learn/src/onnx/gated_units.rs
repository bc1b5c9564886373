//! Gated recurrent units and long short-term memories as graphs.

use granum_nets::{Differentiable, Gru, GruWeights, Lstm, LstmWeights, SequenceModel};

use super::graph::{OnnxGraph, Value};
use super::network::{scaled, unscaled};
use super::unit::{OnnxStep, OnnxUnit, affine, parts};

/// A step of a recurrent network for a table of its inputs in their units, with its outputs in theirs. Where the condition `begins` holds, a sequence begins, and
/// its memory comes from the inputs.
pub fn step(
    graph: &mut OnnxGraph,
    model: &SequenceModel,
    inputs: &Value,
    memory: &Value,
    begins: &Value,
) -> OnnxStep {
    let x = scaled(graph, model.input_scalers(), inputs);
    let first = model.gru().first_state(graph, &x);
    let before = graph.apply("Where", &[begins, &first, memory]);
    let step = model.gru().advance(graph, &x, &before);
    OnnxStep { outputs: unscaled(graph, model.output_scalers(), &step.outputs), ..step }
}

impl OnnxUnit for Gru {
    fn state_values(&self) -> usize {
        self.hidden()
    }

    fn first_state(&self, graph: &mut OnnxGraph, starts: &Value) -> Value {
        let sums = affine(graph, starts, self.parts().first_state, self.starts(), self.starts());
        graph.apply("Tanh", &[&sums])
    }

    fn advance(&self, graph: &mut OnnxGraph, inputs: &Value, state: &Value) -> OnnxStep {
        let (columns, hidden) = (self.inputs(), self.hidden());
        let GruWeights { gates, candidate_inputs, candidate_state, read_out, .. } = self.parts();
        let both = graph.beside(&[inputs, state]);
        let gates = affine(graph, &both, gates, columns + hidden, columns);
        let gates = graph.apply("Sigmoid", &[&gates]);
        let [reset, update] = parts(graph, &gates, [hidden; 2]);
        let from_inputs = affine(graph, inputs, candidate_inputs, columns, columns);
        let held = affine(graph, state, candidate_state, hidden, 0);
        let held = graph.apply("Mul", &[&reset, &held]);
        let candidate = graph.apply("Add", &[&held, &from_inputs]);
        let candidate = graph.apply("Tanh", &[&candidate]);
        let difference = graph.apply("Sub", &[state, &candidate]);
        let kept = graph.apply("Mul", &[&update, &difference]);
        let state = graph.apply("Add", &[&kept, &candidate]);
        OnnxStep { outputs: affine(graph, &state, read_out, hidden, 0), state }
    }
}

/// The state is followed by the cell.
impl OnnxUnit for Lstm {
    fn state_values(&self) -> usize {
        2 * self.hidden()
    }

    fn first_state(&self, graph: &mut OnnxGraph, starts: &Value) -> Value {
        let both = affine(graph, starts, self.parts().first_state, self.starts(), self.starts());
        let [state, cell] = parts(graph, &both, [self.hidden(); 2]);
        let state = graph.apply("Tanh", &[&state]);
        graph.beside(&[&state, &cell])
    }

    fn advance(&self, graph: &mut OnnxGraph, inputs: &Value, state: &Value) -> OnnxStep {
        let (columns, hidden) = (self.inputs(), self.hidden());
        let LstmWeights { gates, read_out, .. } = self.parts();
        let [before, cell] = parts(graph, state, [hidden; 2]);
        let both = graph.beside(&[inputs, &before]);
        let gates = affine(graph, &both, gates, columns + hidden, columns);
        let [open, kept, candidate, shown] = parts(graph, &gates, [hidden; 4]);
        let [open, kept, shown] = [open, kept, shown].map(|gate| graph.apply("Sigmoid", &[&gate]));
        let candidate = graph.apply("Tanh", &[&candidate]);
        let old = graph.apply("Mul", &[&kept, &cell]);
        let new = graph.apply("Mul", &[&open, &candidate]);
        let cell = graph.apply("Add", &[&old, &new]);
        let bounded = graph.apply("Tanh", &[&cell]);
        let after = graph.apply("Mul", &[&shown, &bounded]);
        let outputs = affine(graph, &after, read_out, hidden, 0);
        OnnxStep { outputs, state: graph.beside(&[&after, &cell]) }
    }
}
