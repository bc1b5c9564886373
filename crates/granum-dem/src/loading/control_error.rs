//! Reasons why a control is not possible.

/// Reasons why a control is not possible.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ControlError {
    /// Too few or too many equations.
    #[error(
        "the stage gives {found} equations for the six strain rates of the cell ({what}); give each component a rate \
         or a stress, fix it, or leave it free and add one constraint"
    )]
    Count {
        /// Number of equations.
        found: usize,
        /// Where they come from.
        what: String,
    },
    /// Equations that contradict or repeat one another.
    #[error(
        "the equations of the stage do not determine the strain rates: {0} repeats or contradicts others"
    )]
    Singular(String),
    /// The speed is not positive.
    #[error(
        "the strain rate of the stage is {0} /s; it must be positive: a sample that carries no stress has no speed for an inertial \
         number, unless the stage brings it to a stress, so that such a stage needs strain_rate"
    )]
    Speed(f64),
}
