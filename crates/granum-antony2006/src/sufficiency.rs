//! Checks that a data set is sufficient for the training of mappings, before anything is written.

use crate::mapping::Mapping;
use crate::mapping_networks::states_of;
use crate::study::options::FEWEST_STATES;
use crate::study_data::StudyData;
use granum_learn::{LearnError, Result};

/// Refuses mappings with a sub-model that would have too few training states.
///
/// # Errors
/// [`LearnError::TooFewStates`] for the first such sub-model.
pub fn check_states(dataset: &StudyData, mappings: &[Mapping]) -> Result<()> {
    let states = dataset.training();
    for mapping in mappings {
        for (k, sub_model) in mapping.sub_models.iter().enumerate() {
            let found = states_of(mapping, states.iter().copied(), Some(k)).len();
            if found < FEWEST_STATES {
                return Err(LearnError::TooFewStates {
                    mapping: mapping.name.clone(),
                    sub_model: k + 1,
                    low: sub_model.strain_range[0],
                    high: sub_model.strain_range[1],
                    found,
                    needed: FEWEST_STATES,
                });
            }
        }
    }
    Ok(())
}
