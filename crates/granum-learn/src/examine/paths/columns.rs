//! The columns of a path, of what is learned along it, and of its kind.

use crate::dataset::{Dataset, RunStates};
use crate::methods::{STRAINS, SUFFIXES};
use crate::surrogate::FitSpec;

pub(super) const TENSORS: [&str; 2] = ["stress", "fabric"];
pub(super) const SCALARS: [&str; 2] = ["volumetric_strain", "mechanical_coordination_number"];
/// The words of a case that say what a random path consists of, and what its mean stress and its volume do.
const KINDS: [&str; 2] = ["stage.1.kind", "stage.1.drainage"];
/// The name for runs of all kinds.
pub(super) const ALL: &str = "all";

/// What is learned along a path.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Learned {
    /// True if the volume is an input, as all other strains are, and the mean stress is learned in its place.
    pub volume_is_input: bool,
    /// Further inputs, which describe the material.
    pub properties: Vec<String>,
}

impl Learned {
    /// The scalars that are learned.
    pub fn scalars(&self) -> &'static [&'static str] {
        if self.volume_is_input { &SCALARS[1..] } else { &SCALARS }
    }

    /// What is learned: stress, fabric, volumetric strain unless it is an input, and mechanical coordination number, from the strains and the state of the sample.
    pub fn spec(&self) -> FitSpec {
        let tensors = TENSORS.iter().flat_map(|name| SUFFIXES.map(|suffix| format!("{name}_{suffix}")));
        let outputs: Vec<String> =
            tensors.chain(self.scalars().iter().map(|name| (*name).to_string())).collect();
        let samples = outputs.iter().filter(|name| *name != SCALARS[0]).map(|name| format!("sample.{name}"));
        let strains = STRAINS.map(String::from).into_iter();
        let further = ["sample.void_ratio".to_string()].into_iter().chain(self.properties.iter().cloned());
        let inputs: Vec<String> = strains.chain(samples).chain(further).collect();
        FitSpec::new(inputs, outputs)
    }
}

/// True if a run is one of a kind, or all kinds are asked for.
pub(super) fn is_of(run: &RunStates, kind: &str) -> bool {
    kind == ALL || KINDS.iter().any(|key| run.word(key).is_some_and(|word| word == kind))
}

/// The kinds that occur, after all of them together. Drainage tells kinds apart where runs differ in it.
pub(super) fn kinds(runs: &Dataset) -> Vec<String> {
    let words = |key: &str| {
        let mut found: Vec<String> = Vec::new();
        for word in runs.runs().iter().filter_map(|run| run.word(key)) {
            if !found.contains(&word) {
                found.push(word);
            }
        }
        found
    };
    let [paths, drainage] = KINDS.map(words);
    let differing = if drainage.len() > 1 { drainage } else { Vec::new() };
    [ALL.to_string()].into_iter().chain(paths).chain(differing).collect()
}
