//! The name of the difference between runs: it is the scatter between samples only if the runs differ in nothing but the
//! seed.

use granum_io::case::{Difference, SEED};
use serde_json::Value;

/// Key of the spread in the scores of a mapping if the runs differ only in their seed.
const SEED_SCATTER: &str = "seed_scatter";
/// Key of the spread if they differ in more than the seed.
const RUN_DIFFERENCE: &str = "run_difference";

/// The differences between the runs of a training.
pub struct Spread {
    differences: Vec<String>,
}

impl Spread {
    /// `differences` are those other than the seed.
    pub fn new(differences: &[Difference]) -> Spread {
        Spread { differences: differences.iter().map(|found| found.key.clone()).collect() }
    }

    /// Every key in which the runs may differ.
    pub fn keys(&self) -> Vec<&str> {
        std::iter::once(SEED).chain(self.differences.iter().map(String::as_str)).collect()
    }

    /// The name of the spread as the heading of a column, at most 12 characters.
    pub fn name(&self) -> &'static str {
        if self.differences.is_empty() { "seed scatter" } else { "difference" }
    }

    /// An explanation of the column, if its name is not sufficient.
    pub fn explanation(&self) -> Option<String> {
        let (last, others) = self.differences.split_last()?;
        let mut keys = String::from("seed");
        others.iter().for_each(|key| keys += &format!(", {key}"));
        Some(format!("difference: difference between runs ({keys} and {last})"))
    }

    /// The scores of mappings, with the spread under its proper name.
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
