//! The columns of a path, of what is learned along it, and of its kind.

use crate::dataset::{Dataset, RunStates};
use crate::methods::{STRAINS, SUFFIXES};
use crate::surrogate::FitSpec;

pub(super) const TENSORS: [&str; 2] = ["stress", "fabric"];
pub(super) const SCALARS: [&str; 2] = ["volumetric_strain", "mechanical_coordination_number"];
/// The word of a case that says what a random path consists of.
pub(super) const KIND: &str = "stage.1.kind";
/// The name for runs of all kinds.
pub(super) const ALL: &str = "all";

/// What is learned: stress, fabric, volumetric strain and mechanical coordination number, from the strains and the state of the sample.
pub(super) fn spec() -> FitSpec {
    let tensors = TENSORS.iter().flat_map(|name| SUFFIXES.map(|suffix| format!("{name}_{suffix}")));
    let outputs: Vec<String> = tensors.chain(SCALARS.map(String::from)).collect();
    let samples = outputs.iter().filter(|name| *name != SCALARS[0]).map(|name| format!("sample.{name}"));
    let strains = STRAINS.map(String::from).into_iter();
    let inputs: Vec<String> = strains.chain(samples).chain(["sample.void_ratio".into()]).collect();
    FitSpec::new(inputs, outputs)
}

/// The kind of the path of a run.
pub(super) fn kind(run: &RunStates) -> String {
    run.word(KIND).unwrap_or_else(|| ALL.into())
}

/// The kinds that occur, after all of them together.
pub(super) fn kinds(runs: &Dataset) -> Vec<String> {
    let mut found = vec![ALL.to_string()];
    for run in runs.runs() {
        if !found.contains(&kind(run)) {
            found.push(kind(run));
        }
    }
    found
}
