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
    /// The engine cannot execute this case, or does not find what it needs; nothing has been written.
    #[error("the engine {engine}: {what}")]
    Refused {
        /// Its name.
        engine: String,
        /// What is wrong, and what would be right.
        what: String,
    },
    /// The engine cannot resume runs.
    #[error("the engine {engine} cannot resume an interrupted run: run it again in another folder")]
    CannotResume {
        /// Its name.
        engine: String,
    },
    /// The engine has no simulation in this process.
    #[error("the engine {engine} leaves no simulation in memory; read the snapshots in the folder of a run")]
    NoSimulation {
        /// Its name.
        engine: String,
    },
    /// The engine failed during a run.
    #[error("the engine {engine} failed: {what}")]
    Failed {
        /// Its name.
        engine: String,
        /// What is wrong, and what would be right.
        what: String,
    },
}
