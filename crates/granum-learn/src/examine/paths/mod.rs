//! How well surrogates with a state follow any path: fitted to some runs and rolled out freely along whole unseen ones, from the state of the sample
//! to the end, beside baselines and the scatter between samples.

mod answers;
mod baselines;
mod columns;
mod held;
mod quantities;
mod question;
mod scatter;
#[cfg(test)]
mod tests;
mod work;

pub use answers::{Drift, PathAnswer, PathAnswers};
pub use held::HeldStates;
pub use question::AnyPath;
pub use work::WorkInCycles;
