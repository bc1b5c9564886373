//! The name of the method, and its errors.

use crate::error::LearnError;

pub(super) const NAME: &str = "gaussian-process";

pub(super) fn failed(reason: impl std::fmt::Display) -> LearnError {
    LearnError::Surrogate { method: NAME.into(), reason: reason.to_string() }
}
