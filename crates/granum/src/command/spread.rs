//! What the difference between runs is called: the scatter between samples only where the runs differ in their seed alone.

use granum_io::case::{Difference, SEED};
use serde_json::Value;

/// Key of the spread in the scores of a mapping, where runs differ in their seed alone.
const SEED_SCATTER: &str = "seed_scatter";
/// Its key where they differ in more.
const RUN_DIFFERENCE: &str = "run_difference";

/// In what the runs of a training differ.
pub struct Spread {
    differences: Vec<String>,
}

impl Spread {
    /// `differences` are those besides the seed.
    pub fn of(differences: &[Difference]) -> Spread {
        Spread { differences: differences.iter().map(|found| found.key.clone()).collect() }
    }

    /// Every key in which the runs may differ.
    pub fn keys(&self) -> Vec<&str> {
        std::iter::once(SEED).chain(self.differences.iter().map(String::as_str)).collect()
    }

    /// Its name as the heading of a column, of at most 12 letters.
    pub fn name(&self) -> &'static str {
        if self.differences.is_empty() { "seed scatter" } else { "difference" }
    }

    /// What the column is, where its name does not say so.
    pub fn explanation(&self) -> Option<String> {
        let (last, others) = self.differences.split_last()?;
        let mut keys = String::from("seed");
        others.iter().for_each(|key| keys += &format!(", {key}"));
        Some(format!("difference: difference between runs ({keys} and {last})"))
    }

    /// The scores of mappings with the spread under its own name.
    pub fn renamed(&self, mut mappings: Value) -> Value {
        if !self.differences.is_empty() {
            for mapping in mappings.as_object_mut().into_iter().flat_map(|all| all.values_mut()) {
                let Some(scores) = mapping.as_object_mut() else { continue };
                if let Some(value) = scores.remove(SEED_SCATTER) {
                    scores.insert(RUN_DIFFERENCE.to_string(), value);
                }
            }
        }
        mappings
    }
}
