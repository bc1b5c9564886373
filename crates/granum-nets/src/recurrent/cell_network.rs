//! What every network that is one cell over sequences has in common: its passes over rows, whatever the cell is.

use granum_simd::Isa;

use crate::differentiable::{Batch, Differentiable, check_columns};
use crate::recurrent::cell_batch::{CellBatch, CellKernel, rows_of};
use crate::sequence::stepper::{Stepper, Steps};
use crate::table::data::Data;
use crate::table::sequences::Sequences;
use crate::training_error::TrainingError;

/// A network that is one cell and its weights. A new cell is one file that implements [`CellKernel`] and this.
pub(crate) trait CellNetwork {
    type Cell: CellKernel;
    /// What the network is called in messages.
    const NAME: &'static str;

    fn cell(&self) -> Self::Cell;
    fn cell_weights(&self) -> &[f64];
    fn cell_weights_mut(&mut self) -> &mut [f64];
}

impl<N: CellNetwork + Send + Sync> Differentiable for N {
    fn name(&self) -> &str {
        N::NAME
    }

    fn inputs(&self) -> usize {
        self.cell().sizes().inputs
    }

    fn outputs(&self) -> usize {
        self.cell().sizes().outputs
    }

    fn weights(&self) -> &[f64] {
        self.cell_weights()
    }

    fn weights_mut(&mut self) -> &mut [f64] {
        self.cell_weights_mut()
    }

    fn evaluate(
        &self,
        isa: Isa,
        inputs: &[f64],
        sequences: Option<&Sequences>,
    ) -> Result<Vec<f64>, TrainingError> {
        let cell = self.cell();
        let rows = rows_of(&cell.sizes(), N::NAME, inputs, sequences, None)?;
        CellBatch::new(isa, cell, &rows).map(|mut batch| batch.evaluate(self.cell_weights()))
    }

    fn stepper(&self, isa: Isa, sequences: usize, starts: &[f64]) -> Result<Box<dyn Stepper>, TrainingError> {
        let rows = CellBatch::of_next_rows(isa, self.cell(), sequences, starts)?;
        Ok(Box::new(Steps::new(rows, sequences, self.cell_weights())))
    }

    fn batch(&self, isa: Isa, data: &Data) -> Result<Box<dyn Batch>, TrainingError> {
        check_columns(self, data)?;
        let cell = self.cell();
        let rows = rows_of(&cell.sizes(), N::NAME, data.inputs(), data.sequences(), Some(data))?;
        Ok(Box::new(CellBatch::new(isa, cell, &rows)?))
    }
}
