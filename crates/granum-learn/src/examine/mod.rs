//! Questions to a data set that teach how to learn from it: which runs to make, what noise in the inputs costs, how few numbers hold a curve or
//! a distribution, and what kinds of states there are. Each question is a file, and all errors are those on unseen runs.

mod components;
mod designs;
mod errors;
mod map;
mod noise;
mod noise_numbers;
mod order;
mod turn;

pub use components::{ComponentsAnswer, ComponentsOfCurves, ComponentsOfInputs};
pub use designs::{DesignAnswer, compare_designs};
pub use errors::errors_on;
pub use map::{MapOptions, StateMap};
pub use noise::{NoiseAnswer, NoiseInInputs, Noisy};
pub use order::{Order, OrderAnswer, OrderOfRuns};
