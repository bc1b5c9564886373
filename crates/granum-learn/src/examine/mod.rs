//! Questions to a data set that teach how to learn from it: which runs to make, what noise in the inputs costs, how few numbers hold a curve or
//! a distribution, what kinds of states there are, and how well surrogates with a state follow any path. Each question is a file, and all errors are those on unseen runs.

mod components;
mod designs;
mod errors;
mod map;
mod noise;
mod noise_numbers;
mod order;
mod paths;
mod turn;

pub use components::{ComponentsAnswer, ComponentsOfCurves, ComponentsOfInputs};
pub use designs::{DesignAnswer, compare_designs};
pub use errors::errors_on;
pub use map::{MapOptions, StateMap};
pub use noise::{NoiseAnswer, NoiseInInputs, Noisy};
pub use order::{Order, OrderAnswer, OrderOfRuns};
pub use paths::{AnyPath, Drift, HeldStates, PathAnswer, PathAnswers, WorkInCycles};
