//! What to fit: columns, size of the network, seed.

use serde::{Deserialize, Serialize};

use crate::network::{Network, NetworkError};

/// Name and unit of a column.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Column {
    /// Name, e.g. `deviator_strain`.
    pub name: String,
    /// Unit, e.g. `Pa`; `1` for a pure number.
    pub unit: String,
}

impl Column {
    /// A column with its unit.
    pub fn new(name: &str, unit: &str) -> Column {
        Column { name: name.into(), unit: unit.into() }
    }
}

/// What to fit: the columns, the size of the network and the seed of its weights.
///
/// ```
/// use granum_nets::{Column, Recipe};
///
/// let inputs = vec![Column::new("deviator_strain", "1"), Column::new("mean_stress", "Pa")];
/// let recipe = Recipe::new(inputs, Column::new("stress_ratio", "1"), vec![10, 10]).with_seed(3);
/// assert_eq!(recipe.layers(), [2, 10, 10, 1]);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Recipe {
    /// Input columns, in the order of the rows.
    pub inputs: Vec<Column>,
    /// Output column.
    pub output: Column,
    /// Which columns are parts of one quantity, such as the bins of a distribution: columns with the same number are scaled
    /// together, so that they keep their proportions and all of them weigh as much as one input. Empty: each column is a
    /// quantity of its own.
    pub quantities: Vec<usize>,
    /// How much of the range of an input each column is given: 1 for [-1, 1], 0.3 for [-0.3, 0.3]. All weights are held back
    /// alike, so an input that is given less is believed less until the rows speak for it. Empty: all of it.
    pub shares: Vec<f64>,
    /// Neurons of each hidden layer; the paper's networks have two.
    pub hidden: Vec<usize>,
    /// Seed of the initial weights.
    pub seed: u64,
}

impl Recipe {
    /// A network from these inputs to this output with these hidden layers: every column a quantity of its own with the
    /// whole range of an input, and seed 0.
    pub fn new(inputs: Vec<Column>, output: Column, hidden: Vec<usize>) -> Recipe {
        Recipe { inputs, output, quantities: Vec::new(), shares: Vec::new(), hidden, seed: 0 }
    }

    /// The same with another seed.
    pub fn with_seed(self, seed: u64) -> Recipe {
        Recipe { seed, ..self }
    }

    /// Neurons of all layers, inputs and output included.
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
