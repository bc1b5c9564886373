//! Feed-forward multilayer perceptron.

use crate::feed_forward::activation::Activation;
use crate::feed_forward::initialisation::nguyen_widrow;

/// Largest number of neurons in a layer, and of inputs.
pub const LARGEST_LAYER: usize = 4096;
/// Largest number of layers, including the inputs.
pub const MOST_LAYERS: usize = 16;
/// Largest number of weights of a network.
pub const MOST_WEIGHTS: usize = 1 << 22;

/// An error in the shape of a network.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NetworkError {
    /// There are too few or too many layers.
    #[error("a network has between 2 and {MOST_LAYERS} layers (inputs and outputs counted), not {0}")]
    Layers(usize),
    /// A layer is empty or too large.
    #[error("layer {layer} has {neurons} neurons; between 1 and {LARGEST_LAYER} are possible")]
    Neurons {
        /// Layer, 0 being the inputs.
        layer: usize,
        /// Number of neurons of the layer.
        neurons: usize,
    },
    /// There are too many weights in total.
    #[error("the network would have {0} weights; at most {MOST_WEIGHTS} are possible")]
    Weights(usize),
    /// The number of activations does not match the number of layers.
    #[error("{layers} layers need {needed} activations (one for each but the inputs), not {activations}", needed = layers - 1)]
    Activations {
        /// Number of layers.
        layers: usize,
        /// Number of activations.
        activations: usize,
    },
    /// The number of given weights does not match the layers, or a weight is not finite.
    #[error("{0}")]
    GivenWeights(String),
    /// A row, or a table of rows, has the wrong length.
    #[error("{0}")]
    Row(String),
}

/// A fully connected feed-forward network with a bias at each neuron.
///
/// With `a_0` the inputs, layer `l` computes `a_l = f_l(W_l [a_(l-1); 1])`. Every evaluation of a network starts the sums
/// with the bias and adds the inputs in order with fused multiply-adds. A single row, a batch and the training therefore
/// give identical bits, with every instruction set.
///
/// ```
/// let network = granum_nets::Network::new(&[3, 60, 60, 1], 7)?;
/// assert_eq!(network.weights().len(), 4 * 60 + 61 * 60 + 61);
/// assert_eq!(network.forward(&[0.1, 0.2, 0.3])?.len(), 1);
/// # Ok::<(), granum_nets::NetworkError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Network {
    layers: Vec<usize>,
    activations: Vec<Activation>,
    weights: Vec<f64>,
}

impl Network {
    /// A network with the given numbers of neurons, `layers[0]` being the inputs: tanh in the hidden layers and a
    /// sigmoid at the output, as in Antony, Zhou and Wang (2006); `&[3, 60, 60, 1]` is their four-layer network with 60
    /// neurons in each hidden layer. Initial weights after Nguyen and Widrow (1990) from the seed.
    ///
    /// # Errors
    /// If there are fewer than two layers, or a layer is empty or too large.
    pub fn new(layers: &[usize], seed: u64) -> Result<Network, NetworkError> {
        let mut activations = vec![Activation::Tanh; layers.len().saturating_sub(1)];
        if let Some(last) = activations.last_mut() {
            *last = Activation::Sigmoid;
        }
        Network::with_activations(layers, &activations, seed)
    }

    /// As [`Network::new`], with one activation for each layer except the inputs.
    ///
    /// # Errors
    /// As [`Network::new`], and if the number of activations does not match the number of layers.
    pub fn with_activations(
        layers: &[usize],
        activations: &[Activation],
        seed: u64,
    ) -> Result<Network, NetworkError> {
        check_shape(layers, activations)?;
        let weights = nguyen_widrow(layers, activations, seed);
        Ok(Network { layers: layers.to_vec(), activations: activations.to_vec(), weights })
    }

    /// A network with given weights in the order of [`Network::weights`].
    ///
    /// # Errors
    /// As [`Network::with_activations`], and if the number of weights is wrong or a weight is not finite.
    pub fn from_weights(
        layers: &[usize],
        activations: &[Activation],
        weights: Vec<f64>,
    ) -> Result<Network, NetworkError> {
        let count = check_shape(layers, activations)?;
        if weights.len() != count {
            let text = format!("layers {layers:?} need {count} weights, not {}", weights.len());
            return Err(NetworkError::GivenWeights(text));
        }
        if let Some(i) = weights.iter().position(|w| !w.is_finite()) {
            let text = format!("weight {i} is {}, which is not a finite number", weights[i]);
            return Err(NetworkError::GivenWeights(text));
        }
        Ok(Network { layers: layers.to_vec(), activations: activations.to_vec(), weights })
    }

    /// Numbers of neurons of all layers, starting with the inputs.
    pub fn layers(&self) -> &[usize] {
        &self.layers
    }

    /// Activations of all layers except the inputs.
    pub fn activations(&self) -> &[Activation] {
        &self.activations
    }

    /// Number of inputs.
    pub fn inputs(&self) -> usize {
        self.layers[0]
    }

    /// Number of outputs.
    pub fn outputs(&self) -> usize {
        self.layers[self.layers.len() - 1]
    }

    /// All weights, ordered by layer and then by neuron; for each neuron the weights of its inputs are followed by its bias.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// The weights, which can be changed in place.
    pub fn weights_mut(&mut self) -> &mut [f64] {
        &mut self.weights
    }
}

/// Checks the shape of a network and returns its number of weights.
fn check_shape(layers: &[usize], activations: &[Activation]) -> Result<usize, NetworkError> {
    if layers.len() < 2 || layers.len() > MOST_LAYERS {
        return Err(NetworkError::Layers(layers.len()));
    }
    if let Some(layer) = layers.iter().position(|&n| n == 0 || n > LARGEST_LAYER) {
        return Err(NetworkError::Neurons { layer, neurons: layers[layer] });
    }
    if activations.len() != layers.len() - 1 {
        return Err(NetworkError::Activations { layers: layers.len(), activations: activations.len() });
    }
    let count = layers.windows(2).map(|shape| (shape[0] + 1) * shape[1]).sum();
    if count > MOST_WEIGHTS {
        return Err(NetworkError::Weights(count));
    }
    Ok(count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_are_checked() {
        assert!(Network::new(&[3], 0).is_err());
        assert!(Network::new(&[3, 0, 1], 0).is_err());
        assert!(Network::new(&[3, 5000, 1], 0).is_err());
        assert!(Network::new(&[4096; 16], 0).is_err());
        assert!(Network::with_activations(&[3, 1], &[], 0).is_err());
        assert!(Network::from_weights(&[1, 1], &[Activation::Linear], vec![1.0, f64::NAN]).is_err());
        assert!(Network::from_weights(&[1, 1], &[Activation::Linear], vec![1.0]).is_err());
        let network = Network::new(&[3, 60, 60, 1], 1).unwrap();
        assert_eq!(network.weights().len(), 4 * 60 + 61 * 60 + 61);
        assert!(network.forward(&[0.0; 4]).is_err());
    }

    #[test]
    fn seeds_differ_and_repeat() {
        let weights = |seed| Network::new(&[2, 5, 1], seed).unwrap().weights().to_vec();
        assert_eq!(weights(3), weights(3));
        assert_ne!(weights(3), weights(4));
    }

    #[test]
    fn a_network_by_hand() {
        let tanh_tanh = [Activation::Tanh, Activation::Sigmoid];
        let network = Network::from_weights(
            &[2, 2, 1],
            &tanh_tanh,
            vec![0.5, -0.25, 0.1, 1.0, 2.0, -0.3, 0.7, -1.1, 0.2],
        )
        .unwrap();
        let (x, y) = (0.3f64, -0.8f64);
        let (a, b) = ((0.5 * x - 0.25 * y + 0.1).tanh(), (x + 2.0 * y - 0.3).tanh());
        let expected = 1.0 / (1.0 + (-(0.7 * a - 1.1 * b + 0.2)).exp());
        assert!((network.forward(&[x, y]).unwrap()[0] - expected).abs() < 1e-15);
    }
}
