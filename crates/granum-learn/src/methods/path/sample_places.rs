//! Where the samples of runs lie among those of the training runs.

use serde::{Deserialize, Serialize};

use crate::curve::{increases, interpolated};
use crate::onnx::{self, OnnxGraph, Value};

/// Number of equal shares of the training runs whose ends are kept.
const SHARES: usize = 10;

/// For each value that describes a sample the shares of the training runs that have less.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SamplePlaces(Vec<Shares>);

/// The ends of equal shares of the training runs, without those that are the same, and the share of runs below each.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Shares {
    ends: Vec<f64>,
    below: Vec<f64>,
}

impl Shares {
    fn new(mut values: Vec<f64>) -> Shares {
        values.sort_by(f64::total_cmp);
        let (mut ends, mut below) = (Vec::<f64>::new(), Vec::new());
        for k in 0..=SHARES {
            let end = values[(values.len() - 1) * k / SHARES];
            if ends.last().is_none_or(|last| end > *last) {
                ends.push(end);
                below.push(k as f64 / SHARES as f64);
            }
        }
        Shares { ends, below }
    }

    fn is_sound(&self) -> bool {
        let finite = self.ends.iter().all(|end| end.is_finite());
        let shares = self.below.iter().all(|share| (0.0..=1.0).contains(share));
        !self.ends.is_empty()
            && self.ends.len() == self.below.len()
            && increases(&self.ends)
            && finite
            && shares
    }
}

impl SamplePlaces {
    /// From the values that describe the sample of each training run, of which there is at least one.
    pub fn new(samples: &[Vec<f64>]) -> SamplePlaces {
        let values = samples.first().map_or(0, Vec::len);
        let column = |k: usize| samples.iter().map(|sample| sample[k]).collect();
        SamplePlaces((0..values).map(|k| Shares::new(column(k))).collect())
    }

    /// The place of a sample, from 0 to 1 in each value.
    pub fn place(&self, sample: &[f64]) -> Vec<f64> {
        let share = |(shares, value): (&Shares, &f64)| interpolated(*value, &shares.ends, &shares.below);
        self.0.iter().zip(sample).map(share).collect()
    }

    /// The places of samples, a row each, in a graph.
    pub fn onnx(&self, graph: &mut OnnxGraph, samples: &Value) -> Value {
        let mut places = Vec::with_capacity(self.0.len());
        for (k, shares) in self.0.iter().enumerate() {
            let values = graph.columns(samples, &[k]);
            places.push(onnx::interpolated(graph, &values, &shares.ends, &shares.below));
        }
        graph.beside(&places.iter().collect::<Vec<_>>())
    }

    /// Number of values that describe a sample.
    pub fn values(&self) -> usize {
        self.0.len()
    }

    /// True if it can be that of some runs.
    pub fn is_sound(&self) -> bool {
        self.0.iter().all(Shares::is_sound)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_shares_of_the_training_runs() {
        let samples: Vec<Vec<f64>> = (0..=100).map(|k| vec![f64::from(k * k), 3.0]).collect();
        let places = SamplePlaces::new(&samples);
        assert!(places.is_sound());
        let at = |value: f64| places.place(&[value, 3.0])[0];
        assert!((at(2500.0) - 0.5).abs() < 1e-12 && (at(8100.0) - 0.9).abs() < 1e-12);
        assert!((at(3050.0) - 0.55).abs() < 1e-12);
        // Beyond the ends there is nothing further, and what is the same in all runs has one place.
        assert_eq!((at(-5.0), at(1e9)), (0.0, 1.0));
        assert_eq!(places.place(&[0.0, 3.0])[1], places.place(&[0.0, 7.0])[1]);
    }
}
