//! Trains every sub-model of every mapping, and for each a strain-only network of the same size, and scores them.

pub(crate) mod evaluation;
pub(crate) mod observer;
pub(crate) mod options;
pub(crate) mod sub_model_summary;
pub(crate) mod trained;
pub(crate) mod training;

pub use evaluation::{Evaluation, Parts, RunScore};
pub use observer::{Silent, StudyObserver, StudyProgress};
pub use options::{FEWEST_STATES, StudyOptions};
pub use trained::{Study, TrainedMapping};
pub use training::network_name;
