//! Why contact laws cannot be used together.

/// Laws that cannot be combined, or parameters that they do not have.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LawError {
    /// A law cannot be combined with the normal law.
    #[error("contact.{slot} = {law:?} {reason}; it can be combined with {normal_laws}")]
    Apart {
        /// Its slot: `tangential` or `adhesion`.
        slot: &'static str,
        /// Its name.
        law: &'static str,
        /// What is wrong.
        reason: &'static str,
        /// The normal laws with which it can be combined.
        normal_laws: String,
    },
    /// A parameter that none of the chosen laws has.
    #[error("contact.{key} has no effect with {laws}: leave it out, or choose a law that has it")]
    Unused {
        /// The key of the parameter.
        key: &'static str,
        /// The chosen laws.
        laws: String,
    },
    /// A parameter out of bounds.
    #[error("contact.{key} is {value}; it must be from {low} to {high}{}{unit}", if unit.is_empty() { "" } else { " " })]
    OutOfBounds {
        /// The key of the parameter.
        key: &'static str,
        /// The given value, in SI units.
        value: f64,
        /// Smallest value.
        low: f64,
        /// Largest value.
        high: f64,
        /// SI unit.
        unit: &'static str,
    },
}
