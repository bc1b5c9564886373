//! The memory of a surrogate in the graph of an ONNX file: an input with all that is kept of the state before, and an output with what is kept of this one.

use crate::onnx::{OnnxGraph, Value, part};

/// The parts of a memory, which are read and kept in the same order.
pub(super) struct OnnxMemory {
    /// The condition that a run begins, so that the memory has no meaning.
    pub begins: Value,
    all: Value,
    width: usize,
    /// The columns that have been read.
    read: usize,
    kept: Vec<Value>,
}

impl OnnxMemory {
    /// Adds the inputs `memory`, of so many columns, and `begins`.
    pub fn new(graph: &mut OnnxGraph, width: usize) -> OnnxMemory {
        let all =
            graph.input("memory", width, "next_memory of the state before; of no meaning where begins is 1");
        let begins = graph.input("begins", 1, "1 for the first state of a run, or else 0");
        let half = graph.number(0.5);
        let begins = graph.apply("Greater", &[&begins, &half]);
        OnnxMemory { begins, all, width, read: 0, kept: Vec::new() }
    }

    /// The next columns; without meaning where a run begins.
    pub fn next(&mut self, graph: &mut OnnxGraph, columns: usize) -> Value {
        let found = part(graph, &self.all, self.read, columns);
        self.read += columns;
        debug_assert!(self.read <= self.width);
        found.unwrap_or_else(|| self.all.clone())
    }

    /// The next columns; zero where a run begins.
    pub fn next_or_zero(&mut self, graph: &mut OnnxGraph, columns: usize) -> Value {
        let found = self.next(graph, columns);
        let zero = graph.number(0.0);
        graph.apply("Where", &[&self.begins, &zero, &found])
    }

    /// Keeps columns for the next state.
    pub fn keep(&mut self, columns: &Value) {
        self.kept.push(columns.clone());
    }

    /// Adds the output `next_memory`.
    pub fn write(&self, graph: &mut OnnxGraph) {
        debug_assert_eq!(self.read, self.width);
        let next = graph.beside(&self.kept.iter().collect::<Vec<_>>());
        graph.output("next_memory", self.width, "memory of the next state", &next);
    }
}
