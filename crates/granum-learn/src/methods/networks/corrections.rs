//! What the ridge regression beside networks adds to their predictions.
//!
//! Ridge regression predicts a histogram at the centres of its bins. Between them the difference that it makes is interpolated, so that
//! the prediction stays as smooth as that of the network; beyond the first and the last it is constant.

use super::fitted::SubModelNetworks;
use crate::curve::interpolated;
use crate::error::Result;

impl SubModelNetworks {
    /// Corrects the predictions of a network, given the state of each as a row of the columns of the mapping and, if the output is
    /// a histogram, the value `at` of the binned variable.
    pub(super) fn correct(
        &self,
        sub_model: usize,
        states: &[&[f64]],
        at: &[f64],
        values: &mut [f64],
    ) -> Result<()> {
        let Some(beside) = &self.beside else { return Ok(()) };
        // The predictions for the bins of a state follow each other.
        let mut distinct: Vec<&[f64]> = Vec::new();
        let mut number = Vec::with_capacity(states.len());
        for state in states {
            if distinct.last() != Some(state) {
                distinct.push(state);
            }
            number.push(distinct.len() - 1);
        }
        let ridge = beside.means(distinct.concat())?;
        if !self.mapping.predicts_histogram() {
            for (value, number) in values.iter_mut().zip(number) {
                *value = beside.mixed(0, *value, ridge[number][0]);
            }
            return Ok(());
        }
        let centres = self.mapping.output_centres();
        let bins: Vec<Option<usize>> =
            at.iter().map(|at| centres.iter().position(|centre| centre == at)).collect();
        let mut corrections = vec![Vec::new(); distinct.len()];
        for (number, _) in number.iter().zip(&bins).filter(|(_, bin)| bin.is_none()) {
            if corrections[*number].is_empty() {
                let network = self.at_centres(sub_model, distinct[*number])?;
                let each = network.iter().zip(&ridge[*number]).enumerate();
                corrections[*number] = each.map(|(bin, (a, b))| beside.correction(bin, *a, *b)).collect();
            }
        }
        for (k, value) in values.iter_mut().enumerate() {
            match bins[k] {
                Some(bin) => *value = beside.mixed(bin, *value, ridge[number[k]][bin]),
                None => *value += interpolated(at[k], centres, &corrections[number[k]]),
            }
        }
        Ok(())
    }

    /// What a network predicts for the bins of a state.
    fn at_centres(&self, sub_model: usize, state: &[f64]) -> Result<Vec<f64>> {
        let mut inputs = Vec::new();
        self.mapping.push_inputs(state, self.mapping.output_centres(), &mut inputs);
        let batch = self.networks[sub_model].predict_batch(&inputs);
        Ok(batch.map_err(|error| self.failed(sub_model, &error))?.values)
    }
}
