//! What is asked.

use granum_io::case::SEED;
use serde::{Deserialize, Serialize};

use crate::dataset::{Dataset, RunStates};
use crate::error::{LearnError, Result};
use crate::family::FamilyDefinition;
use crate::surrogate::SurrogateMethods;

/// A strain that is an output of families whose tests end at a stress; on a bench it is measured as the coordinate is.
const STRAIN: &str = "axial_strain";

/// The measures of a sample that are known of a packing.
const PACKING: [&str; 2] = ["sample.void_ratio", "sample.mechanical_coordination_number"];

/// What is asked of runs: quantities of the laboratory, soft sensors, properties, and how surrogates are fitted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct WorthPlan {
    /// The column along which a test runs.
    pub coordinate: String,
    /// What a laboratory measures: `stress_ratio` and `volumetric_strain`.
    pub outputs: Vec<String>,
    /// The soft sensors, the most telling first.
    pub sensors: Vec<String>,
    /// The properties of the grains, the packing and the test, constant in each run.
    pub properties: Vec<String>,
    /// The methods among which one is chosen for each answer. Those that cannot be fitted to its inputs are left out.
    pub methods: Vec<String>,
    /// Numbers of training runs, of which the first so many are used.
    pub counts: Vec<usize>,
    /// Level of the intervals (0.9).
    pub level: f64,
    /// Most states from which a surrogate is fitted, and most on which it is scored (20000).
    pub most_states: usize,
    /// Seed of the methods.
    pub seed: u64,
    /// Number of threads; 0 for the number of processors. Answers do not depend on it.
    #[serde(skip)]
    pub threads: usize,
}

impl WorthPlan {
    /// The usual question to runs along a coordinate: `stress_ratio` and `volumetric_strain` from the deviator fabric, the second moment of the
    /// contact forces, their whole distribution, the coordination number and the sliding fraction, and from all properties in which the
    /// training runs differ; with all training runs.
    pub fn new(coordinate: &str, training: &Dataset) -> WorthPlan {
        let names = |names: &[&str]| names.iter().map(ToString::to_string).collect::<Vec<_>>();
        WorthPlan {
            coordinate: coordinate.to_owned(),
            outputs: names(&["stress_ratio", "volumetric_strain"]),
            sensors: names(&[
                "deviator_fabric",
                "mean_square_force",
                "probability_density",
                "mechanical_coordination_number",
                "sliding_fraction",
            ]),
            properties: properties(training),
            methods: names(&["ridge", "boosted-trees", "gaussian-process"]),
            counts: vec![training.runs().len()],
            level: 0.9,
            most_states: 20_000,
            seed: 1,
            threads: 0,
        }
    }

    /// The usual question to the runs of a family along its path, with the columns of the family ([`FamilyDefinition::with_its_columns`]): along its
    /// coordinate, from its inputs as properties, and about what it predicts beside strains and soft sensors: the stress ratio, and the volumetric strain or,
    /// where the volume is held or follows from the strain, the mean stress.
    pub fn of_family(family: &FamilyDefinition, training: &Dataset) -> WorthPlan {
        let usual = WorthPlan::new(family.coordinate, training);
        let is_output = |name: &&str| *name != STRAIN && !usual.sensors.iter().any(|sensor| sensor == name);
        let outputs = family.outputs.iter().map(|output| output.column).filter(is_output);
        WorthPlan {
            outputs: outputs.map(String::from).collect(),
            properties: family.inputs.iter().map(|input| input.name.to_owned()).collect(),
            ..usual
        }
    }

    /// Refuses a plan that runs cannot answer, before anything is fitted.
    ///
    /// # Errors
    /// If a column or method does not exist, a property is not constant in each run, or a number of runs is too small or too large.
    pub(super) fn check(
        &self,
        training: &Dataset,
        unseen: &Dataset,
        methods: &SurrogateMethods,
    ) -> Result<()> {
        let bad = |reason: String| Err(LearnError::Dataset(reason));
        if self.outputs.is_empty() || self.sensors.is_empty() || self.methods.is_empty() {
            return bad("at least one output, one sensor and one method must be named".into());
        }
        self.methods.iter().try_for_each(|name| methods.by_name(name).map(drop))?;
        let coordinate = std::slice::from_ref(&self.coordinate);
        for dataset in [training, unseen] {
            for name in coordinate.iter().chain(&self.outputs).chain(&self.sensors).chain(&self.properties) {
                dataset.expand(&[name])?;
            }
        }
        for run in training.runs().iter().chain(unseen.runs()) {
            for name in &self.properties {
                let values = run.values(name)?;
                if values.iter().any(|value| *value != values[0]) {
                    let run = run.name();
                    return bad(format!(
                        "{name} is not constant in {run}, so that it is no property; name it as a sensor"
                    ));
                }
            }
        }
        if let Some(twice) = self.outputs.iter().find(|output| self.sensors.contains(output)) {
            return bad(format!("{twice} is both an output and a sensor"));
        }
        let all = training.runs().len();
        match self.counts.iter().find(|count| !(FEWEST_RUNS..=all).contains(count)) {
            Some(count) => bad(format!(
                "{count} is no number of training runs; it must be from {FEWEST_RUNS} to {all}, which is how many there are"
            )),
            None => Ok(()),
        }
    }
}

/// Fewest training runs.
pub(super) const FEWEST_RUNS: usize = 5;

/// The properties in which runs differ: the keys of their cases that are numbers and not the same in all runs, without seeds and without those that
/// repeat another one, and the void ratio and the coordination number of their samples.
pub fn properties(dataset: &Dataset) -> Vec<String> {
    let values =
        |name: &str| -> Option<Vec<f64>> { dataset.runs().iter().map(|run| run.parameter(name)).collect() };
    let mut found: Vec<(String, Vec<f64>)> = Vec::new();
    let keys = dataset.runs().first().into_iter().flat_map(RunStates::parameters).map(|own| own.key.as_str());
    let of_case = keys.filter(|key| *key != SEED && !key.starts_with("sample."));
    for key in of_case.chain(PACKING) {
        let Some(values) = values(key) else { continue };
        let is_same = values.iter().all(|value| *value == values[0]);
        if !is_same && !found.iter().any(|(_, known)| *known == values) {
            found.push((key.to_owned(), values));
        }
    }
    found.into_iter().map(|(key, _)| key).collect()
}
