//! Families of tests with surrogates that are ready to use: grains of one kind with stated ranges of their properties, along one or more
//! paths, each with a surrogate of its own.
//!
//! A [`FamilyDefinition`] says which tests belong to a family, which dimensionless inputs they have and which curves are predicted.
//! [`FamilyModel::fit`] fits its surrogate, Gaussian processes of whole curves
//! ([`GaussianProcessOfCurves`](crate::surrogate::GaussianProcessOfCurves)), to runs; [`FamilyModel::predict`] answers with curves,
//! also where inputs are missing ([`TypicalValue`]); [`FamilyScores`] says how far the answers are from samples that it has not seen.
//! The families are listed in [`ALL`], each path by itself.

mod common_inputs;
mod common_outputs;
mod definition;
mod file;
mod integrated;
mod model;
mod onnx_form;
mod powder;
mod prediction;
mod replicates;
mod sand;
mod score_types;
mod scores;
mod shaped_sand;
mod states;
mod test_progress;
#[cfg(test)]
mod tests;
mod typical;

pub use definition::{FamilyDefinition, FamilyInput, FamilyOutput};
pub use model::{FamilyFit, FamilyModel};
pub use powder::{POWDER_CONSTANT_P, POWDER_OEDOMETER};
pub use prediction::{FamilyCurve, FamilyPrediction, InputSource, UsedInput};
pub use sand::{SAND, SAND_CONSTANT_P, SAND_UNDRAINED, SAND_UNLOAD_RELOAD};
pub use score_types::{FamilyOutputScore, FamilyScores, QuarterCoverage, TrainingData};
pub use shaped_sand::SHAPED_SAND;
pub use states::FamilyStates;
pub use typical::TypicalValue;

/// All families, path by path. The first path of a family is the one that is meant where none is named.
pub const ALL: &[&FamilyDefinition] = &[
    &SAND,
    &SAND_CONSTANT_P,
    &SAND_UNDRAINED,
    &SAND_UNLOAD_RELOAD,
    &POWDER_CONSTANT_P,
    &POWDER_OEDOMETER,
    &SHAPED_SAND,
];

/// The family of a name, along a path; without one, along its first path.
///
/// # Errors
/// [`LearnError::Unknown`](crate::LearnError::Unknown) with the existing names.
pub fn by_name(name: &str, path: Option<&str>) -> crate::Result<&'static FamilyDefinition> {
    let unknown = |kind, name: &str, known: Vec<&str>| crate::LearnError::Unknown {
        kind,
        name: name.to_owned(),
        known: known.join(", "),
    };
    let own: Vec<&'static FamilyDefinition> =
        ALL.iter().copied().filter(|family| family.name == name).collect();
    let Some(first) = own.first().copied() else {
        let mut known: Vec<&str> = ALL.iter().map(|family| family.name).collect();
        known.dedup();
        return Err(unknown("family", name, known));
    };
    let Some(path) = path else { return Ok(first) };
    let found = own.iter().copied().find(|family| family.path == path);
    found.ok_or_else(|| unknown("path", path, own.iter().map(|family| family.path).collect()))
}
