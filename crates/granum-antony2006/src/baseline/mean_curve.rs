//! The trivial predictor: the mean curve of the training runs as a function of strain, without any network.

use serde::{Deserialize, Serialize};

use crate::mapping::Quantity;
use crate::study_data::{Run, State, StudyData, state_at};

/// The mean over the training runs at the strains of the training states of the first run, with linear interpolation. It
/// is a function of strain only.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeanCurve {
    states: Vec<State>,
}

impl MeanCurve {
    /// The mean curve of a data set.
    pub fn new(dataset: &StudyData) -> Self {
        let runs: Vec<Run> = (dataset.training_runs.iter())
            .map(|run| {
                let chosen =
                    run.numbers.iter().zip(&run.states).filter(|(number, _)| dataset.trains(**number));
                let (numbers, states): (Vec<u64>, Vec<State>) =
                    chosen.map(|(&number, s)| (number, s.clone())).unzip();
                Run { states, numbers, ..run.clone() }
            })
            .collect();
        let strains = runs.first().into_iter().flat_map(|run| &run.states).map(|state| state.strain);
        MeanCurve { states: strains.filter_map(|strain| mean_at(&runs, strain)).collect() }
    }

    /// The prediction at a strain. Outside the range of its states it is that of the first or last state; it is empty if
    /// no run has a training state.
    pub fn answer(&self, quantity: Quantity, strain: f64) -> Vec<f64> {
        state_at(&self.states, strain).map_or(Vec::new(), |state| state.values(quantity).to_vec())
    }

    /// True if every state has the given number of bins of f, all values are finite, and the strains increase.
    pub(super) fn is_sound(&self, bins: usize) -> bool {
        let finite = |state: &State| {
            let numbers = [state.strain, state.stress_ratio, state.deviator_fabric];
            state.densities.len() == bins && numbers.iter().chain(&state.densities).all(|x| x.is_finite())
        };
        self.states.iter().all(finite) && self.states.windows(2).all(|pair| pair[0].strain < pair[1].strain)
    }
}

/// The mean state of all runs at a strain.
fn mean_at(runs: &[Run], strain: f64) -> Option<State> {
    let at: Vec<State> = runs.iter().filter_map(|run| run.at(strain)).collect();
    let first = at.first()?;
    let mean = |value: &dyn Fn(&State) -> f64| at.iter().map(value).sum::<f64>() / at.len() as f64;
    Some(State {
        strain,
        stress_ratio: mean(&|state| state.stress_ratio),
        deviator_fabric: mean(&|state| state.deviator_fabric),
        densities: (0..first.densities.len()).map(|bin| mean(&|state| state.densities[bin])).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study_data::StudyDataOptions;
    use crate::synthetic::{Law, record};
    use granum_learn::dataset::NamedRecord;

    #[test]
    fn it_is_the_mean_of_the_training_states() {
        let (a, b) = (record(Law::Plain, 1, 40), record(Law::Plain, 2, 40));
        let named = |record| NamedRecord { name: "run", seed: 0, record };
        let dataset = StudyData::new(&[named(&a), named(&b)], &[], &StudyDataOptions::default()).unwrap();
        let curve = MeanCurve::new(&dataset);
        let (x, y) = (&dataset.training_runs[0].states[8], &dataset.training_runs[1].states[8]);
        let answer = curve.answer(Quantity::StressRatio, x.strain);
        assert!((answer[0] - 0.5 * (x.stress_ratio + y.stress_ratio)).abs() < 1e-12);
        assert_eq!(curve.answer(Quantity::ForceDistribution, 0.1).len(), 14);
        // The prediction for a held-out state follows from its neighbours and not from the state itself.
        let run = &dataset.training_runs[0].states;
        let alone = StudyData::new(&[named(&a)], &[], &StudyDataOptions::default()).unwrap();
        let answer = MeanCurve::new(&alone).answer(Quantity::StressRatio, run[9].strain);
        assert!((answer[0] - 0.5 * (run[8].stress_ratio + run[10].stress_ratio)).abs() < 1e-12);
    }
}
