//! The networks that advance along a path.

use granum_nets::{Differentiable, Gru, Lstm, NetworkError, StateSpace, TensorSizes, TensorStateSpace};
use serde::{Deserialize, Serialize};

use super::channels::Widths;
use super::rotation::COMPONENTS;
use crate::onnx::OnnxUnit;

/// A kind of network with a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PathCell {
    /// A gated recurrent unit, whose first memory comes from the sample.
    Gru,
    /// A long short-term memory, whose first memory comes from the sample.
    Lstm,
    /// A state-space network, whose state is what is measured and internal variables.
    StateSpace,
    /// A feed-forward network over the last increments and the predicted state.
    Window,
    /// A state-space network of tensors and scalars, which is objective by construction.
    TensorStateSpace,
}

impl PathCell {
    pub(crate) const ALL: [PathCell; 5] =
        [PathCell::Gru, PathCell::Lstm, PathCell::StateSpace, PathCell::Window, PathCell::TensorStateSpace];

    /// The name of the method.
    pub(crate) fn name(self) -> &'static str {
        match self {
            PathCell::Gru => "path-gru",
            PathCell::Lstm => "path-lstm",
            PathCell::StateSpace => "path-state-space",
            PathCell::Window => "path-window",
            PathCell::TensorStateSpace => "path-tensor",
        }
    }

    pub(super) fn help(self) -> &'static str {
        match self {
            PathCell::Gru => {
                "any path of strain: gated recurrent units over increments, from the state of the sample"
            }
            PathCell::Lstm => {
                "any path of strain: long short-term memories over increments, from the state of the sample"
            }
            PathCell::StateSpace => {
                "any path of strain: networks that advance a state of soft sensors and internal variables"
            }
            PathCell::Window => {
                "any path of strain: feed-forward networks over the last increments and the predicted state"
            }
            PathCell::TensorStateSpace => {
                "any path of strain: as path-state-space, with tensors and invariants, in every frame the same"
            }
        }
    }
}

/// A network with a state, which is trained and written as a graph.
pub(super) trait PathNetwork: Differentiable + OnnxUnit {}

impl<N: Differentiable + OnnxUnit> PathNetwork for N {}

/// The sizes of a network.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CellSizes {
    pub cell: PathCell,
    pub hidden: usize,
    /// Internal variables of a state-space network: of each kind, where there are tensors and scalars.
    pub internal: usize,
    /// Number of increments that a feed-forward network sees.
    pub window: usize,
}

impl CellSizes {
    /// True if the answer turns with the axes whatever the weights are.
    pub fn is_objective(&self, widths: &Widths) -> bool {
        widths.direction == 0 || self.cell == PathCell::TensorStateSpace
    }

    /// Number of increments that a network sees, with that to the row.
    pub fn increments_seen(&self) -> usize {
        if self.cell == PathCell::Window { self.window.max(1) } else { 1 }
    }

    /// The inputs of the network from the increments of all rows.
    pub fn inputs(&self, widths: &Widths, increments: &[f64], lengths: &[usize]) -> Vec<f64> {
        let width = widths.increment();
        // Ten times a mean increment has the magnitude one.
        let vector = |row: &[f64]| row[1..].iter().map(|c| 10.0 * row[0] * c).collect::<Vec<f64>>();
        match self.cell {
            PathCell::Gru | PathCell::Lstm => increments.chunks_exact(width).flat_map(vector).collect(),
            PathCell::StateSpace | PathCell::TensorStateSpace => increments.to_vec(),
            PathCell::Window => {
                let mut values = Vec::new();
                let mut first = 0;
                for length in lengths {
                    let row = |k: usize| &increments[(first + k) * width..(first + k + 1) * width];
                    for k in 0..*length {
                        values.extend(row(k));
                        for back in 1..self.window {
                            match k.checked_sub(back) {
                                Some(earlier) => values.extend(vector(row(earlier))),
                                None => values.extend(vec![0.0; width - 1]),
                            }
                        }
                    }
                    first += length;
                }
                values
            }
        }
    }

    /// A network with random weights from a seed, or with given weights.
    pub fn network(
        &self,
        widths: &Widths,
        seed: u64,
        weights: Option<Vec<f64>>,
    ) -> Result<Box<dyn PathNetwork>, NetworkError> {
        let (hidden, outputs, starts) = (self.hidden, widths.outputs(), widths.starts());
        let increment = widths.increment();
        let state_space = |inputs: usize, internal: usize, weights: Option<Vec<f64>>| {
            let network = match weights {
                None => StateSpace::new(inputs, starts, hidden, internal, outputs, seed)?,
                Some(weights) => {
                    StateSpace::from_weights([inputs, starts, hidden, internal, outputs], weights)?
                }
            };
            Ok::<Box<dyn PathNetwork>, NetworkError>(Box::new(network))
        };
        Ok(match self.cell {
            PathCell::Gru => Box::new(match weights {
                None => Gru::new(increment - 1, starts, hidden, outputs, seed)?,
                Some(weights) => Gru::from_weights(increment - 1, starts, hidden, outputs, weights)?,
            }),
            PathCell::Lstm => Box::new(match weights {
                None => Lstm::new(increment - 1, starts, hidden, outputs, seed)?,
                Some(weights) => Lstm::from_weights(increment - 1, starts, hidden, outputs, weights)?,
            }),
            PathCell::StateSpace => state_space(increment, self.internal, weights)?,
            PathCell::Window => {
                let inputs =
                    self.window.saturating_sub(1).saturating_mul(increment - 1).saturating_add(increment);
                state_space(inputs, 0, weights)?
            }
            // Without tensors there is nothing that turns.
            PathCell::TensorStateSpace if widths.direction != COMPONENTS => {
                state_space(increment, self.internal, weights)?
            }
            PathCell::TensorStateSpace => {
                let sizes = TensorSizes {
                    further: widths.further,
                    start_scalars: widths.start_scalars,
                    hidden,
                    tensors: widths.tensors,
                    scalars: widths.scalars,
                    internal_tensors: self.internal,
                    internal_scalars: self.internal,
                };
                Box::new(match weights {
                    None => TensorStateSpace::new(sizes, seed)?,
                    Some(weights) => TensorStateSpace::from_weights(sizes, weights)?,
                })
            }
        })
    }
}
