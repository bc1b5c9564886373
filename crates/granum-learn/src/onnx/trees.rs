//! Sums of regression trees as graphs. All trees are descended together, a level at a time: the number of the node of each tree is a table of integers, and what the node asks
//! for is looked up by it. A leaf leads to itself.

use super::graph::{OnnxGraph, Value};
use crate::regression::boosting::Tree;

/// The sum of the values of trees for each row of their inputs: a column.
pub fn sum_of_trees(graph: &mut OnnxGraph, inputs: &Value, trees: &[Tree]) -> Value {
    let (mut input, mut limit, mut value, mut next, mut roots) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new(), Vec::with_capacity(trees.len()));
    for tree in trees {
        let first = input.len();
        roots.push(first as i64);
        for node in 0..tree.nodes() {
            match tree.question(node) {
                Some(question) => {
                    input.push(question.input as i64);
                    limit.push(question.limit);
                    value.push(0.0);
                    next.push((first + question.next) as i64);
                }
                // Nothing is larger than infinity.
                None => {
                    input.push(0);
                    limit.push(f64::INFINITY);
                    value.push(tree.value(node));
                    next.push((first + node) as i64);
                }
            }
        }
    }
    let (input, next) = (graph.integers(&input), graph.integers(&next));
    let (limit, value) = (graph.constant(&[limit.len()], &limit), graph.constant(&[value.len()], &value));
    let mut node = graph.integers(&roots);
    let levels = trees.iter().map(Tree::depth).max().unwrap_or(0);
    for level in 0..levels.max(1) {
        let asked = graph.apply("Gather", &[&input, &node]);
        let own = match level {
            // The roots are the same for all rows.
            0 => graph.apply_with("Gather", &[inputs, &asked], &[("axis", 1)]),
            _ => graph.apply_with("GatherElements", &[inputs, &asked], &[("axis", 1)]),
        };
        let limit = graph.apply("Gather", &[&limit, &node]);
        let is_larger = graph.apply("Greater", &[&own, &limit]);
        let further = graph.cast(&is_larger, true);
        let next = graph.apply("Gather", &[&next, &node]);
        node = graph.apply("Add", &[&next, &further]);
    }
    let values = graph.apply("Gather", &[&value, &node]);
    graph.sum_of_rows(&values)
}
