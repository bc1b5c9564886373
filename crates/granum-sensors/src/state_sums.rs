//! Sums over the observations of one state.

use serde::{Deserialize, Serialize};

use crate::{Averaging, Histogram, SensorColumn};

/// Sums over the observations at one state, a number for each column, and the counts of each histogram.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct StateSums {
    pub(crate) state: usize,
    pub(crate) observations: u64,
    pub(crate) sums: Vec<f64>,
    pub(crate) histograms: Vec<Histogram>,
}

impl StateSums {
    pub(super) fn new(state: usize, columns: usize, histograms: Vec<Histogram>) -> StateSums {
        StateSums { state, observations: 0, sums: vec![0.0; columns], histograms }
    }

    /// Adds the values of an observation; its counts have already been added to the histograms.
    pub(super) fn add<'a>(&mut self, row: &[f64], columns: impl Iterator<Item = &'a SensorColumn>) {
        for ((sum, value), column) in self.sums.iter_mut().zip(row).zip(columns) {
            match column.averaging {
                Averaging::Mean => *sum += value,
                Averaging::RootMeanSquare => *sum += value * value,
                Averaging::Largest => *sum = sum.max(*value),
            }
        }
        self.observations += 1;
    }

    /// The averages over the observations.
    pub(crate) fn averages<'a>(&self, columns: impl Iterator<Item = &'a SensorColumn>) -> Vec<f64> {
        let observations = self.observations as f64;
        (self.sums.iter().zip(columns))
            .map(|(sum, column)| match column.averaging {
                Averaging::Mean => sum / observations,
                Averaging::RootMeanSquare => (sum / observations).sqrt(),
                Averaging::Largest => *sum,
            })
            .collect()
    }

    /// True if it has the number of columns and the bins of another one, and at most the number of observations of a state.
    pub(super) fn is_like(&self, fresh: &StateSums, observations: usize) -> bool {
        self.sums.len() == fresh.sums.len()
            && self.histograms.len() == fresh.histograms.len()
            && self.histograms.iter().zip(&fresh.histograms).all(|(own, other)| own.has_bins_of(other))
            && (1..=observations as u64).contains(&self.observations)
    }
}
