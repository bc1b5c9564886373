//! Networks by sub-model in the graph of an ONNX file: every network answers every state, and the coordinate chooses among the answers.

use super::fitted::SubModelNetworks;
use super::mapping::NetworkMapping;
use crate::onnx::{self, OnnxEstimate, OnnxGraph, Value};

/// A distance that is less than any other.
const NEAREST: f64 = -1e300;

impl SubModelNetworks {
    /// Adds all that the networks predict, with intervals of a level.
    pub(super) fn onnx_form(&self, graph: &mut OnnxGraph, level: f64) {
        let mapping = self.mapping();
        let columns = mapping.columns();
        let inputs = onnx::inputs(graph, &columns);
        let rows = network_rows(graph, mapping, &inputs);
        let ridge = self.beside.as_ref().map(|beside| beside.onnx(graph, &inputs));
        let choice = Choice::new(graph, mapping, &inputs);
        let (points, outputs) = (mapping.points_of_value(), columns.outputs.len());
        let (mut means, mut deviations, mut quantiles, mut outside) = (vec![], vec![], vec![], vec![]);
        for (sub_model, network) in self.networks().iter().enumerate() {
            let answer = onnx::network(graph, network, &rows, points);
            let mean = onnx::mean_of_points(graph, &answer.values, points);
            means.push(by_output(graph, &mean, outputs));
            deviations.push(answer.deviations.map(|own| by_output(graph, &own, outputs)));
            quantiles.push(network.quantile(level));
            let ranges = self.trained_ranges(sub_model);
            outside.push(onnx::outside(graph, &inputs, &ranges[..columns.inputs.len()]));
            for (input, [low, high]) in columns.inputs.iter().zip(&ranges) {
                graph.state(
                    &format!("trained_range.sub_model_{}.{}", sub_model + 1, input.name),
                    format!("[{low:?}, {high:?}]"),
                );
            }
        }
        let mean = choice.chosen(graph, &means);
        // A deviation is there if it is of all networks; granum trains all of a mapping in one way.
        let all: Option<Vec<Value>> = deviations.into_iter().collect();
        let spread = all.map(|all| {
            let quantiles: Vec<Value> = quantiles.iter().map(|quantile| graph.number(*quantile)).collect();
            let halves: Vec<Value> = (all.iter().zip(&quantiles))
                .map(|(deviation, quantile)| graph.apply("Mul", &[deviation, quantile]))
                .collect();
            [choice.chosen(graph, &all), choice.chosen(graph, &halves)]
        });
        let mut estimates = Vec::with_capacity(outputs);
        for output in 0..outputs {
            let own = graph.columns(&mean, &[output]);
            let mean = match (&self.beside, &ridge) {
                (Some(beside), Some(ridge)) => beside.onnx_mixed(graph, output, &own, ridge),
                _ => own,
            };
            let spread = spread.as_ref().map(|both| both.each_ref().map(|own| graph.columns(own, &[output])));
            estimates.push(OnnxEstimate { mean, spread });
        }
        let outside = choice.chosen(graph, &outside);
        let outside = graph.apply("Max", &[&outside, &choice.uncovered]);
        onnx::outputs(graph, &columns, &estimates, &outside);
    }
}

/// The rows of the networks: for each state one, or one for each bin.
fn network_rows(graph: &mut OnnxGraph, mapping: &NetworkMapping, inputs: &Value) -> Value {
    let points = mapping.rows_of_state();
    if points == 1 && !mapping.predicts_histogram() && !mapping.inputs.iter().any(|own| mapping.is_point(own))
    {
        return inputs.clone();
    }
    // Each input of the networks as a table with a column for each bin.
    let one = graph.row(&vec![1.0; points]);
    let zero = graph.row(&vec![0.0; points]);
    let (mut tables, mut first) = (Vec::new(), 0);
    let bins = |graph: &mut OnnxGraph, centres: &[f64]| {
        let column = graph.columns(inputs, &[0]);
        let nothing = graph.apply("Mul", &[&column, &zero]);
        let centres = graph.row(centres);
        graph.apply("Add", &[&nothing, &centres])
    };
    for input in &mapping.inputs {
        let own: Vec<usize> = (first..first + input.len()).collect();
        first += input.len();
        match &input.bins {
            Some(known) if mapping.is_point(input) => {
                tables.push(bins(graph, &known.centres));
                tables.push(graph.columns(inputs, &own));
            }
            _ => {
                for column in own {
                    let column = graph.columns(inputs, &[column]);
                    tables.push(graph.apply("Mul", &[&column, &one]));
                }
            }
        }
    }
    if mapping.predicts_histogram() {
        tables.push(bins(graph, mapping.output_centres()));
    }
    let last = graph.integers(&[2]);
    let tables: Vec<Value> = tables.iter().map(|table| graph.apply("Unsqueeze", &[table, &last])).collect();
    let all = graph.apply_with("Concat", &tables.iter().collect::<Vec<_>>(), &[("axis", 2)]);
    let shape = graph.integers(&[-1, tables.len() as i64]);
    graph.apply("Reshape", &[&all, &shape])
}

/// A column with so many values of each state one after the other, as a table.
fn by_output(graph: &mut OnnxGraph, column: &Value, outputs: usize) -> Value {
    let shape = graph.integers(&[-1, outputs as i64]);
    graph.apply("Reshape", &[column, &shape])
}

/// Which sub-model answers a state, see [`sub_model_at`](crate::surrogate::sub_model::sub_model_at).
struct Choice {
    /// For each sub-model but the first the condition that it is nearer than all before.
    nearer: Vec<Value>,
    /// A column that is 1 where no sub-model covers the coordinate.
    uncovered: Value,
}

impl Choice {
    fn new(graph: &mut OnnxGraph, mapping: &NetworkMapping, inputs: &Value) -> Choice {
        let x = graph.columns(inputs, &[mapping.place_of_coordinate()]);
        let nearest = graph.number(NEAREST);
        let (mut nearer, mut covered) = (Vec::new(), Vec::new());
        let mut least: Option<Value> = None;
        for (k, sub_model) in mapping.sub_models.iter().enumerate() {
            let [low, high] = sub_model.range.map(|end| graph.number(end));
            let below = graph.apply("Less", &[&x, &low]);
            // The last range has its end.
            let beyond = match k + 1 == mapping.sub_models.len() {
                true => graph.apply("Greater", &[&x, &high]),
                false => {
                    let within = graph.apply("Less", &[&x, &high]);
                    graph.apply("Not", &[&within])
                }
            };
            let away = graph.apply("Or", &[&below, &beyond]);
            let holds = graph.apply("Not", &[&away]);
            let (under, over) = (graph.apply("Sub", &[&low, &x]), graph.apply("Sub", &[&x, &high]));
            let distance = graph.apply("Max", &[&under, &over]);
            let distance = graph.apply("Where", &[&holds, &nearest, &distance]);
            covered.push(holds);
            least = Some(match least {
                None => distance,
                Some(least) => {
                    let is_nearer = graph.apply("Less", &[&distance, &least]);
                    let least = graph.apply("Where", &[&is_nearer, &distance, &least]);
                    nearer.push(is_nearer);
                    least
                }
            });
        }
        let away: Vec<Value> = covered.iter().map(|holds| graph.apply("Not", &[holds])).collect();
        let away = away.into_iter().reduce(|all, own| graph.apply("And", &[&all, &own]));
        let uncovered = match away {
            Some(away) => onnx::any(graph, &away),
            None => graph.number(0.0),
        };
        Choice { nearer, uncovered }
    }

    /// The table of the sub-model that answers, of the tables of all.
    fn chosen(&self, graph: &mut OnnxGraph, tables: &[Value]) -> Value {
        let mut chosen = tables[0].clone();
        for (nearer, table) in self.nearer.iter().zip(&tables[1..]) {
            chosen = graph.apply("Where", &[nearer, table, &chosen]);
        }
        chosen
    }
}
