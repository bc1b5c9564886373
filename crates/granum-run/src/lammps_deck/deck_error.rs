//! Why a case cannot be written as an input deck for LAMMPS.

use granum_dem::loading::ControlError;
use thiserror::Error;

use crate::laboratory::LaboratoryError;

/// Why a case cannot be written as an input deck for LAMMPS.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum DeckError {
    /// A setting of the case that LAMMPS does not have.
    #[error("{key} = {value} cannot be written for LAMMPS: {why}")]
    Setting {
        /// The key of the case.
        key: &'static str,
        /// Its value.
        value: String,
        /// Why not, and what would be possible.
        why: String,
    },
    /// A stage that LAMMPS cannot follow.
    #[error("the stage {stage} cannot be written for LAMMPS: {why}")]
    Stage {
        /// Its name.
        stage: String,
        /// Why not.
        why: String,
    },
    /// A sample that a deck cannot begin with.
    #[error("the sample cannot be written for LAMMPS: {0}")]
    Sample(String),
    /// The control of a stage is not possible.
    #[error(transparent)]
    Control(#[from] ControlError),
    /// The sample cannot be simulated.
    #[error(transparent)]
    Laboratory(#[from] LaboratoryError),
    /// A file cannot be written.
    #[error(transparent)]
    File(#[from] granum_io::Error),
}
