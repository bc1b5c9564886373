//! Baselines: predictors without networks, with which the networks are compared.
//!
//! - The **mean curve** of the training runs, which is a function of strain only.
//! - **Ridge regression** with splines of strain, both with the sensors of the networks and without them. It is linear
//!   in the sensors and has the same settings for all mappings; a network that performs worse is not worthwhile.
//!
//! They are fitted to the training states of all training runs and stored with the study, so that it can be evaluated
//! without its training runs.

mod mean_curve;
mod ridge;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

pub use mean_curve::MeanCurve;
pub use ridge::Ridge;

use crate::mapping::Mapping;
use crate::study_data::StudyData;
use granum_learn::Result;

/// The baselines of a study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Baselines {
    /// The mean curve of the training runs.
    pub mean_curve: MeanCurve,
    /// Ridge regression for each mapping, by name.
    pub mappings: BTreeMap<String, MappingBaselines>,
}

/// Ridge regression for a mapping.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MappingBaselines {
    /// Regression on strain and the sensors of the mapping.
    pub ridge: Ridge,
    /// Regression on strain alone.
    pub strain_only: Ridge,
}

impl MappingBaselines {
    /// Fits both to the training states of a data set.
    ///
    /// # Errors
    /// [`granum_learn::LearnError::Dataset`] if there is no training state or the fit cannot be solved.
    pub fn fit(mapping: &Mapping, dataset: &StudyData) -> Result<MappingBaselines> {
        let states = dataset.training();
        Ok(MappingBaselines {
            ridge: Ridge::fit(mapping, &states)?,
            strain_only: Ridge::fit(&mapping.strain_only(), &states)?,
        })
    }
}

impl Baselines {
    /// Fits all baselines to the training states of a data set.
    ///
    /// # Errors
    /// As [`MappingBaselines::fit`].
    pub fn fit<'a>(
        mappings: impl IntoIterator<Item = &'a Mapping>,
        dataset: &StudyData,
    ) -> Result<Baselines> {
        let fit = |mapping: &Mapping| Ok((mapping.name.clone(), MappingBaselines::fit(mapping, dataset)?));
        Ok(Baselines {
            mean_curve: MeanCurve::new(dataset),
            mappings: mappings.into_iter().map(fit).collect::<Result<_>>()?,
        })
    }

    /// True if these are the baselines of the given mappings with the given number of bins of f.
    pub fn are_of<'a>(&self, mappings: impl IntoIterator<Item = &'a Mapping>, bins: usize) -> bool {
        let fits = |mapping: &Mapping| {
            self.mappings.get(&mapping.name).is_some_and(|both| {
                both.ridge.is_of(mapping, bins) && both.strain_only.is_of(&mapping.strain_only(), bins)
            })
        };
        self.mean_curve.is_sound(bins) && mappings.into_iter().all(fits)
    }
}
