//! The trivial answer: the curve of the training runs against strain, with no network at all.

use crate::dataset::{Dataset, Run, State};
use crate::mapping::Quantity;

/// The mean over the training runs of their training states, linear in strain between them. It knows strain only.
pub struct MeanCurve {
    runs: Vec<Run>,
}

impl MeanCurve {
    /// The mean curve of a data set.
    pub fn new(dataset: &Dataset) -> Self {
        let runs = dataset.training_runs.iter().map(|run| {
            let chosen = run.numbers.iter().zip(&run.states).filter(|(number, _)| dataset.trains(**number));
            let (numbers, states): (Vec<u64>, Vec<State>) =
                chosen.map(|(&number, s)| (number, s.clone())).unzip();
            Run { states, numbers, ..run.clone() }
        });
        MeanCurve { runs: runs.collect() }
    }

    /// Its answer at a strain; empty if no run has a training state.
    pub fn answer(&self, quantity: Quantity, strain: f64) -> Vec<f64> {
        let at: Vec<State> = self.runs.iter().filter_map(|run| run.at(strain)).collect();
        let Some(first) = at.first() else { return Vec::new() };
        let n = at.len() as f64;
        (0..first.values(quantity).len())
            .map(|c| at.iter().map(|state| state.values(quantity)[c]).sum::<f64>() / n)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::{DatasetOptions, NamedRecord};
    use crate::synthetic::{Law, record};

    #[test]
    fn it_is_the_mean_of_the_training_states() {
        let (a, b) = (record(Law::Plain, 1, 40), record(Law::Plain, 2, 40));
        let named = |record| NamedRecord { name: "run", seed: 0, record };
        let dataset = Dataset::new(&[named(&a), named(&b)], &[], &DatasetOptions::default()).unwrap();
        let curve = MeanCurve::new(&dataset);
        let (x, y) = (&dataset.training_runs[0].states[8], &dataset.training_runs[1].states[8]);
        let answer = curve.answer(Quantity::StressRatio, x.strain);
        assert!((answer[0] - 0.5 * (x.stress_ratio + y.stress_ratio)).abs() < 1e-12);
        assert_eq!(curve.answer(Quantity::ForceDistribution, 0.1).len(), 14);
        // A held-out state is answered from its neighbours, not from itself.
        let run = &dataset.training_runs[0].states;
        let alone = Dataset::new(&[named(&a)], &[], &DatasetOptions::default()).unwrap();
        let answer = MeanCurve::new(&alone).answer(Quantity::StressRatio, run[9].strain);
        assert!((answer[0] - 0.5 * (run[8].stress_ratio + run[10].stress_ratio)).abs() < 1e-12);
    }
}
