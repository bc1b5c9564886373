//! Settings of methods with networks.

use granum_nets::trainer::{self, SharedTrainer};
use serde::{Deserialize, Serialize};

use crate::error::{LearnError, Result};

/// The form in which a histogram enters a network.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Form {
    /// As single points: the binned variable and the value of the bin are one input each, and a state gives one row for each
    /// bin.
    #[default]
    Point,
    /// As a whole: every bin is an input.
    Histogram,
}

/// Settings of methods with networks, which a study records.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NetworkSettings {
    /// Name of the trainer.
    pub trainer: String,
    /// Form in which histograms enter networks by sub-model.
    pub form: Form,
    /// Factor on the numbers of epochs of sub-models, for a method whose sub-models have some.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub epoch_factor: Option<f64>,
    /// Numbers of neurons of the hidden layers, for the methods of any columns (10 and 10).
    #[serde(default = "usual_layers")]
    pub hidden: Vec<usize>,
}

fn usual_layers() -> Vec<usize> {
    vec![10, 10]
}

impl Default for NetworkSettings {
    fn default() -> Self {
        NetworkSettings {
            trainer: trainer::NAMES[0].into(),
            form: Form::Point,
            epoch_factor: None,
            hidden: usual_layers(),
        }
    }
}

impl NetworkSettings {
    /// The trainer.
    ///
    /// # Errors
    /// If there is none of this name; the message gives the names.
    pub fn trainer(&self) -> Result<SharedTrainer> {
        trainer::by_name(&self.trainer, &trainer::Options::default())
            .map_err(|error| LearnError::Network { network: "trainer".into(), reason: error.to_string() })
    }
}
