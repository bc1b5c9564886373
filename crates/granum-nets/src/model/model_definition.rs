//! The definition of a model: columns, size of the network, seed.

use serde::{Deserialize, Serialize};

use crate::feed_forward::network::{Network, NetworkError};

/// Name and unit of a column.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelColumn {
    /// Name, e.g. `deviator_strain`.
    pub name: String,
    /// Unit, e.g. `Pa`; `1` for a pure number.
    pub unit: String,
}

impl ModelColumn {
    /// A column with its unit.
    pub fn new(name: &str, unit: &str) -> ModelColumn {
        ModelColumn { name: name.into(), unit: unit.into() }
    }
}

/// The definition of a model: its columns, the size of the network and the seed of its weights.
///
/// ```
/// use granum_nets::{ModelColumn, ModelDefinition};
///
/// let inputs = vec![ModelColumn::new("deviator_strain", "1"), ModelColumn::new("mean_stress", "Pa")];
/// let definition = ModelDefinition::new(inputs, ModelColumn::new("stress_ratio", "1"), vec![10, 10]).with_seed(3);
/// assert_eq!(definition.layers(), [2, 10, 10, 1]);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ModelDefinition {
    /// Input columns, in the order of the rows.
    pub inputs: Vec<ModelColumn>,
    /// Output column.
    pub output: ModelColumn,
    /// For each column the number of the quantity to which it belongs. Columns of one quantity, such as the bins of a
    /// distribution, are scaled together, so that they keep their proportions and together have the weight of one input.
    /// If empty, each column is a separate quantity.
    pub quantities: Vec<usize>,
    /// For each column the share of the range of an input to which it is scaled: 1 for [-1, 1], 0.3 for [-0.3, 0.3]. Since
    /// all weights are regularised equally, an input with a small share has less influence unless the data support it. If
    /// empty, all shares are 1.
    pub shares: Vec<f64>,
    /// Numbers of neurons of the hidden layers; the networks of the paper have two.
    pub hidden: Vec<usize>,
    /// Seed of the initial weights.
    pub seed: u64,
}

impl ModelDefinition {
    /// A definition with the given inputs, output and hidden layers, in which every column is a separate quantity with a share
    /// of 1, and the seed is 0.
    pub fn new(inputs: Vec<ModelColumn>, output: ModelColumn, hidden: Vec<usize>) -> ModelDefinition {
        ModelDefinition { inputs, output, quantities: Vec::new(), shares: Vec::new(), hidden, seed: 0 }
    }

    /// Sets the seed.
    pub fn with_seed(self, seed: u64) -> ModelDefinition {
        ModelDefinition { seed, ..self }
    }

    /// Numbers of neurons of all layers, including inputs and output.
    pub fn layers(&self) -> Vec<usize> {
        let mut layers = vec![self.inputs.len()];
        layers.extend(&self.hidden);
        layers.push(1);
        layers
    }

    /// The network before training.
    ///
    /// # Errors
    /// If a layer is empty or too large.
    pub fn network(&self) -> Result<Network, NetworkError> {
        Network::new(&self.layers(), self.seed)
    }
}
