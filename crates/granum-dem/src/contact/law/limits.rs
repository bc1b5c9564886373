//! Limits on the history and the prepared constants of contact laws.

/// Largest number of history columns of a tangential law.
pub const MAX_HISTORY: usize = 10;
/// Largest number of history columns of a moment law.
pub const MAX_MOMENT_HISTORY: usize = 6;
/// Largest number of history columns of an adhesion law.
pub const MAX_ADHESION_HISTORY: usize = 4;
/// Largest number of history columns of a normal law.
pub const MAX_NORMAL_HISTORY: usize = 4;
/// Number of constants that a law may prepare for a pair.
pub const LAW_CONSTANTS: usize = 6;
/// Largest number of energy channels of a law.
pub const LAW_CHANNELS: usize = 2;
/// Largest number of parameters of a set of laws that may have given values; more are an error.
pub const MOST_PARAMETERS: usize = 32;
