//! The numbers of values of a tensor state-space network, and where its weights are.

use crate::feed_forward::network::NetworkError;
use crate::recurrent::cell_batch::check_sizes;
use crate::recurrent::symmetric_tensor::COMPONENTS;

/// Least rate of decay.
const LEAST_DECAY: f64 = 0.05;

/// Numbers of values of a [`crate::TensorStateSpace`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TensorSizes {
    /// Further inputs of a row beside the length and the direction of the increment.
    pub further: usize,
    /// Scalars of the start vector, of which the first are the measured ones before the first row.
    pub start_scalars: usize,
    /// Hidden neurons.
    pub hidden: usize,
    /// Measured deviators.
    pub tensors: usize,
    /// Measured scalars.
    pub scalars: usize,
    /// Internal deviators.
    pub internal_tensors: usize,
    /// Internal scalars.
    pub internal_scalars: usize,
}

impl TensorSizes {
    pub(crate) fn all_tensors(&self) -> usize {
        self.tensors + self.internal_tensors
    }

    pub(crate) fn all_scalars(&self) -> usize {
        self.scalars + self.internal_scalars
    }

    pub(crate) fn state(&self) -> usize {
        COMPONENTS * self.all_tensors() + self.all_scalars()
    }

    pub(crate) fn inputs(&self) -> usize {
        1 + COMPONENTS + self.further
    }

    pub(crate) fn starts(&self) -> usize {
        COMPONENTS * self.tensors + self.start_scalars
    }

    pub(crate) fn outputs(&self) -> usize {
        COMPONENTS * self.tensors + self.scalars
    }

    /// Inputs of the hidden neurons, without the one.
    pub(crate) fn features(&self) -> usize {
        let m = self.all_tensors();
        self.further + self.all_scalars() + 3 * m + m * (m + 1) / 2 + 1
    }

    /// Tensors of which a change is a sum.
    pub(crate) fn basis(&self) -> usize {
        2 * self.all_tensors() + 2
    }

    pub(crate) fn coefficients(&self) -> usize {
        self.all_tensors() * self.basis() + self.all_scalars()
    }

    pub(crate) fn changes(&self) -> usize {
        self.hidden * (self.features() + 1)
    }

    pub(crate) fn first_tensors(&self) -> usize {
        self.changes() + self.coefficients() * (1 + self.hidden)
    }

    pub(crate) fn first_scalars(&self) -> usize {
        self.first_tensors() + self.internal_tensors * self.tensors
    }

    /// The square roots of what the rates of decay exceed [`LEAST_DECAY`] by: of tensors, then of scalars.
    pub(crate) fn decays(&self) -> usize {
        self.first_scalars() + self.internal_scalars * (self.start_scalars + 1)
    }

    pub(crate) fn weights(&self) -> usize {
        self.decays() + self.all_tensors() + self.all_scalars()
    }

    /// The rate of decay of tensor `k`, or of scalar `k` less the number of tensors.
    pub(crate) fn decay(&self, weights: &[f64], k: usize) -> f64 {
        let root = weights[self.decays() + k];
        LEAST_DECAY + root * root
    }

    pub(crate) fn check(&self) -> Result<(), NetworkError> {
        // Each number before sums and products of them, which could overflow.
        let TensorSizes {
            further, start_scalars, tensors, scalars, internal_tensors, internal_scalars, ..
        } = *self;
        let more = |count: usize| count.saturating_add(1);
        let counts = [
            self.hidden,
            more(further),
            more(start_scalars),
            more(tensors),
            more(scalars),
            more(internal_tensors),
            more(internal_scalars),
        ];
        check_sizes(&counts, 0, || 0)?;
        let layers = [self.hidden, self.outputs(), self.state(), self.features(), self.coefficients()];
        check_sizes(&layers, self.starts(), || self.weights())?;
        if self.start_scalars < self.scalars {
            let (scalars, found) = (self.scalars, self.start_scalars);
            return Err(NetworkError::GivenWeights(format!(
                "a tensor state-space network with {scalars} scalars needs their first values: {found} start scalars are too few"
            )));
        }
        Ok(())
    }
}
