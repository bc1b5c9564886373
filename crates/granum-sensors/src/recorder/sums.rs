//! What the looks at one state add up to.

use serde::{Deserialize, Serialize};

use crate::{Averaging, Histogram, SensorColumn};

/// Sums over the looks at one state, a number for each column, and the counts of each histogram.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct StateSums {
    pub(crate) state: usize,
    pub(crate) looks: u64,
    pub(crate) sums: Vec<f64>,
    pub(crate) histograms: Vec<Histogram>,
}

impl StateSums {
    pub(super) fn new(state: usize, columns: usize, histograms: Vec<Histogram>) -> StateSums {
        StateSums { state, looks: 0, sums: vec![0.0; columns], histograms }
    }

    /// Adds the values of a look; its counts were added before.
    pub(super) fn add<'a>(&mut self, row: &[f64], columns: impl Iterator<Item = &'a SensorColumn>) {
        for ((sum, value), column) in self.sums.iter_mut().zip(row).zip(columns) {
            match column.averaging {
                Averaging::Mean => *sum += value,
                Averaging::RootMeanSquare => *sum += value * value,
                Averaging::Largest => *sum = sum.max(*value),
            }
        }
        self.looks += 1;
    }

    /// The averages over the looks.
    pub(crate) fn averages<'a>(&self, columns: impl Iterator<Item = &'a SensorColumn>) -> Vec<f64> {
        let looks = self.looks as f64;
        (self.sums.iter().zip(columns))
            .map(|(sum, column)| match column.averaging {
                Averaging::Mean => sum / looks,
                Averaging::RootMeanSquare => (sum / looks).sqrt(),
                Averaging::Largest => *sum,
            })
            .collect()
    }

    /// True if it has the width and bins of another one, and not more looks than a state takes.
    pub(super) fn is_like(&self, fresh: &StateSums, looks: usize) -> bool {
        self.sums.len() == fresh.sums.len()
            && self.histograms.len() == fresh.histograms.len()
            && self.histograms.iter().zip(&fresh.histograms).all(|(own, other)| own.has_bins_of(other))
            && (1..=looks as u64).contains(&self.looks)
    }
}
