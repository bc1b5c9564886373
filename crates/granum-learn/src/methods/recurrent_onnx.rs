//! A step of several recurrent networks in the graph of an ONNX file.

use granum_nets::SequenceModel;

use super::onnx_memory::OnnxMemory;
use super::scatter_of_networks::RunVariances;
use crate::onnx::{self, OnnxEstimate, OnnxGraph, Value};

/// The estimates of all outputs for the next state, in the order of the outputs. The input `memory` has the memories of all networks one after the other, the output
/// `next_memory` those after the state; where the input `begins` is 1 a run begins.
pub(super) fn onnx_steps(
    graph: &mut OnnxGraph,
    networks: &[SequenceModel],
    inputs: &Value,
    known: Option<(&RunVariances, f64)>,
    outputs: usize,
) -> Vec<OnnxEstimate> {
    let width: usize = networks.iter().map(|network| network.gru().hidden()).sum();
    let mut memory = OnnxMemory::new(graph, width);
    let mut answers = Vec::with_capacity(networks.len());
    for network in networks {
        let own = memory.next(graph, network.gru().hidden());
        let step = onnx::step(graph, network, inputs, &own, &memory.begins);
        memory.keep(&step.state);
        answers.push(step.outputs);
    }
    memory.write(graph);
    (0..outputs).map(|output| estimate(graph, &answers, known, output)).collect()
}

/// The mean of the networks for an output, and their variance with that of runs.
fn estimate(
    graph: &mut OnnxGraph,
    answers: &[Value],
    known: Option<(&RunVariances, f64)>,
    output: usize,
) -> OnnxEstimate {
    let [mean, between] = onnx::mean_and_variance(graph, answers, output);
    let Some((known, level)) = known else { return OnnxEstimate { mean, spread: None } };
    let of_runs = graph.number(known.variances()[output]);
    let variance = graph.apply("Add", &[&between, &of_runs]);
    let deviation = graph.apply("Sqrt", &[&variance]);
    let spread = onnx::spread(graph, Some(deviation), known.quantile(level));
    OnnxEstimate { mean, spread }
}
