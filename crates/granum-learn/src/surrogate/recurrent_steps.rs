//! Recurrent networks along a run whose states come one after the other.

use granum_nets::{ModelError, SequenceModel, SequenceSteps};

use super::prediction::Prediction;
use super::run_steps::RunSteps;
use crate::error::{LearnError, Result};

/// The prediction for a row of inputs from the outputs of each network.
type Predict<'a> = Box<dyn Fn(&[Vec<f64>], &[f64]) -> Result<Prediction> + Send + 'a>;

/// The networks with their memories.
pub(super) struct RecurrentSteps<'a> {
    networks: &'a [SequenceModel],
    outputs: usize,
    predict: Predict<'a>,
    failed: fn(ModelError) -> LearnError,
    steps: Vec<SequenceSteps>,
    /// False before the first state was accepted: it gives the first memory.
    begun: bool,
}

impl<'a> RecurrentSteps<'a> {
    /// Before a run; `failed` tells which surrogate an error of a network is of.
    pub fn new(
        networks: &'a [SequenceModel],
        outputs: usize,
        predict: Predict<'a>,
        failed: fn(ModelError) -> LearnError,
    ) -> RecurrentSteps<'a> {
        RecurrentSteps { networks, outputs, predict, failed, steps: Vec::new(), begun: false }
    }
}

impl RunSteps for RecurrentSteps<'_> {
    fn predict(&mut self, row: &[f64]) -> Result<Prediction> {
        if !self.begun {
            let steps = self.networks.iter().map(|network| network.steps(row).map_err(self.failed));
            self.steps = steps.collect::<Result<_>>()?;
        }
        let mut means = vec![vec![0.0; self.outputs]; self.steps.len()];
        for (steps, means) in self.steps.iter_mut().zip(&mut means) {
            steps.predict(row, means).map_err(self.failed)?;
        }
        (self.predict)(&means, row)
    }

    fn accept(&mut self) {
        self.steps.iter_mut().for_each(SequenceSteps::accept);
        self.begun = true;
    }

    fn restart(&mut self) {
        self.begun = false;
    }
}
