//! Options of a trainer.

use granum_simd::Isa;

/// Options of a trainer. A field that is `None` has the value of the trainer.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Options {
    /// Largest number of epochs.
    pub epochs: Option<u64>,
    /// Training ends when the mean squared error (scaled units) is at or below this.
    pub goal: Option<f64>,
    /// Training ends when the Euclidean norm of the gradient of the trainer's objective is at or below this.
    pub minimum_gradient: Option<f64>,
    /// Training with validation rows ends when their error has not fallen for so many accepted steps in a row.
    pub maximum_failures: Option<u64>,
    /// Initial ratio of Bayesian regularisation, see [`super::LevenbergMarquardt::first_ratio`].
    pub first_ratio: Option<f64>,
    /// Seed of the random numbers of a trainer, such as those that choose mini-batches.
    pub seed: Option<u64>,
    /// The instruction set; by default the widest that the processor supports. Results do not depend on it.
    pub isa: Option<Isa>,
}
