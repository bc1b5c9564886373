//! Recurrent networks along a run whose states come one after the other.

use std::sync::Arc;

use granum_nets::{ModelError, SequenceModel, SequenceSteps};

use crate::error::{LearnError, Result};
use crate::surrogate::prediction::Prediction;
use crate::surrogate::run_memory::RunMemory;
use crate::surrogate::run_steps::RunSteps;

/// The prediction for a row of inputs from the outputs of each network.
type Predict = Box<dyn Fn(&[Vec<f64>], &[f64]) -> Result<Prediction> + Send>;

/// The networks with their memories.
pub(super) struct RecurrentSteps {
    networks: Arc<[SequenceModel]>,
    outputs: usize,
    predict: Predict,
    failed: fn(ModelError) -> LearnError,
    steps: Vec<SequenceSteps>,
    /// False before the first state was accepted: it gives the first memory.
    begun: bool,
}

impl RecurrentSteps {
    /// Before a run; `failed` tells which surrogate an error of a network is of.
    pub fn new(
        networks: Arc<[SequenceModel]>,
        outputs: usize,
        predict: Predict,
        failed: fn(ModelError) -> LearnError,
    ) -> RecurrentSteps {
        RecurrentSteps { networks, outputs, predict, failed, steps: Vec::new(), begun: false }
    }

    /// The networks before a first row.
    fn begin(&mut self, row: &[f64]) -> Result<()> {
        let steps = self.networks.iter().map(|network| network.steps(row).map_err(self.failed));
        self.steps = steps.collect::<Result<_>>()?;
        Ok(())
    }
}

impl RunSteps for RecurrentSteps {
    fn predict(&mut self, row: &[f64]) -> Result<Prediction> {
        if !self.begun {
            self.begin(row)?;
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

    fn memory(&self) -> RunMemory {
        match self.begun {
            true => RunMemory::new(self.steps.iter().map(SequenceSteps::state).collect()),
            false => RunMemory::default(),
        }
    }

    fn resume(&mut self, memory: &RunMemory) -> Result<()> {
        self.restart();
        if memory.is_start() {
            return Ok(());
        }
        let (found, count) = (memory.parts().len(), self.networks.len());
        if found != count {
            let text = format!("a memory has the states of {count} networks, not {found}");
            return Err((self.failed)(ModelError::Columns(text)));
        }
        if self.steps.is_empty() {
            // The first row counts for the state before it alone, which is replaced.
            let columns = self.networks.first().map_or(0, |network| network.inputs().len());
            self.begin(&vec![0.0; columns])?;
        }
        for (steps, state) in self.steps.iter_mut().zip(memory.parts()) {
            if state.is_empty() {
                return Err((self.failed)(ModelError::Columns("a state of a memory has no values".into())));
            }
            steps.set_state(state).map_err(self.failed)?;
        }
        self.begun = true;
        Ok(())
    }
}
