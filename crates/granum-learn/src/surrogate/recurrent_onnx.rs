//! A step of several recurrent networks in the graph of an ONNX file.

use granum_nets::SequenceModel;

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
    let memory =
        graph.input("memory", width, "next_memory of the state before; of no meaning where begins is 1");
    let begins = graph.input("begins", 1, "1 for the first state of a run, or else 0");
    let half = graph.number(0.5);
    let begins = graph.apply("Greater", &[&begins, &half]);
    let (mut first, mut answers, mut memories) = (0, Vec::new(), Vec::new());
    for network in networks {
        let hidden = network.gru().hidden();
        let own = graph.columns(&memory, &(first..first + hidden).collect::<Vec<_>>());
        let step = onnx::step(graph, network, inputs, &own, &begins);
        first += hidden;
        answers.push(step.outputs);
        memories.push(step.memory);
    }
    let next = graph.beside(&memories.iter().collect::<Vec<_>>());
    graph.output("next_memory", width, "memory of the next state", &next);
    (0..outputs).map(|output| estimate(graph, &answers, known, output)).collect()
}

/// The mean of the networks for an output, and their variance with that of runs.
fn estimate(
    graph: &mut OnnxGraph,
    answers: &[Value],
    known: Option<(&RunVariances, f64)>,
    output: usize,
) -> OnnxEstimate {
    let each: Vec<Value> = answers.iter().map(|answer| graph.columns(answer, &[output])).collect();
    let table = graph.beside(&each.iter().collect::<Vec<_>>());
    let share = graph.number(1.0 / answers.len() as f64);
    let sum = graph.sum_of_rows(&table);
    let mean = graph.apply("Mul", &[&sum, &share]);
    let Some((known, level)) = known else { return OnnxEstimate { mean, spread: None } };
    let apart = graph.apply("Sub", &[&table, &mean]);
    let squares = graph.apply("Mul", &[&apart, &apart]);
    let squares = graph.sum_of_rows(&squares);
    let per_network = graph.number(1.0 / (answers.len() as f64 - 1.0).max(1.0));
    let between = graph.apply("Mul", &[&squares, &per_network]);
    let of_runs = graph.number(known.variances()[output]);
    let variance = graph.apply("Add", &[&between, &of_runs]);
    let deviation = graph.apply("Sqrt", &[&variance]);
    let spread = onnx::spread(graph, Some(deviation), known.quantile(level));
    OnnxEstimate { mean, spread }
}
