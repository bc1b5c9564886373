//! Families of tests with a surrogate that is ready to use: grains of one kind with stated ranges of their properties, along one path.
//!
//! A [`FamilyDefinition`] says which tests belong to a family, which dimensionless inputs they have and which curves are predicted.
//! [`FamilyModel::fit`] fits its surrogate, Gaussian processes of whole curves
//! ([`GaussianProcessOfCurves`](crate::surrogate::GaussianProcessOfCurves)), to runs; [`FamilyModel::predict`] answers with curves,
//! also where inputs are missing ([`TypicalValue`]); [`FamilyScores`] says how far the answers are from samples that it has not seen.
//! The families are listed in [`ALL`].

mod definition;
mod file;
mod model;
mod prediction;
mod replicates;
mod sand;
mod score_types;
mod scores;
#[cfg(test)]
mod tests;
mod typical;

pub use definition::{FamilyDefinition, FamilyInput, FamilyOutput};
pub use model::{FamilyFit, FamilyModel};
pub use prediction::{FamilyPrediction, InputSource, PredictedCurve, UsedInput};
pub use sand::SAND;
pub use score_types::{FamilyScores, OutputScore, QuarterCoverage, TrainingData};
pub use typical::TypicalValue;

/// All families.
pub const ALL: &[&FamilyDefinition] = &[&SAND];

/// The family of a name.
///
/// # Errors
/// [`LearnError::Unknown`](crate::LearnError::Unknown) with the existing names.
pub fn by_name(name: &str) -> crate::Result<&'static FamilyDefinition> {
    ALL.iter().copied().find(|family| family.name == name).ok_or_else(|| crate::LearnError::Unknown {
        kind: "family",
        name: name.to_owned(),
        known: ALL.iter().map(|family| family.name).collect::<Vec<_>>().join(", "),
    })
}
