//! Why an engine cannot be used.

/// The reason why an engine cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum EngineError {
    /// There is none of that name.
    #[error("there is no engine {name:?}; {suggestion}")]
    Unknown {
        /// The name.
        name: String,
        /// The nearest name, or all existing names.
        suggestion: String,
    },
    /// There is already an engine of the same name.
    #[error("there is already an engine {name:?}: give the new one another name")]
    NameTaken {
        /// The name.
        name: &'static str,
    },
    /// The engine cannot resume runs.
    #[error("the engine {engine} cannot resume an interrupted run: run it again in another folder")]
    CannotResume {
        /// Its name.
        engine: &'static str,
    },
    /// The engine failed.
    #[error("the engine {engine}: {what}")]
    Failed {
        /// Its name.
        engine: &'static str,
        /// What is wrong, and what would be right.
        what: String,
    },
}
