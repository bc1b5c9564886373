//! Tests whether networks use their sensors: the general test of [`granum_learn::input_use`], with the strain as the
//! coordinate. Sensors are permuted within the range of each sub-model.

use granum_learn::Result;
use granum_learn::input_use::{Given, InputTest, InputUse, permutation};
use granum_learn::score::Scorer;

use crate::mapping::Mapping;
use crate::mapping_networks::{MappingNetworks, states_of};
use crate::study::trained::TrainedMapping;
use crate::study_data::{Run, State};

pub use granum_learn::input_use::{InputUse as SensorUse, RunErrors, Verdict};

/// A network is considered constant if the standard deviation of its predictions is below this fraction of that of the
/// targets.
const CONSTANT: f64 = 1e-3;

/// The use that a mapping makes of the sensors of unseen runs; runs without a state in its range are omitted.
///
/// # Errors
/// If a state contains a value that is not finite.
pub fn sensor_use(trained: &TrainedMapping, runs: &[&Run]) -> Result<SensorUse> {
    let mapping = trained.surrogate.mapping();
    let judged = runs.iter().map(|run| (*run, states_of(mapping, &run.states, None)));
    let judged = judged.filter(|(_, states)| !states.is_empty()).collect();
    InputUse::measure(&SensorTest { trained, judged })
}

struct SensorTest<'a> {
    trained: &'a TrainedMapping,
    judged: Vec<(&'a Run, Vec<&'a State>)>,
}

impl InputTest for SensorTest<'_> {
    fn runs(&self) -> Vec<String> {
        self.judged.iter().map(|(run, _)| run.name.clone()).collect()
    }

    fn error(&self, run: usize, given: Given, all: &mut Scorer) -> Result<f64> {
        let (_, states) = &self.judged[run];
        let surrogate = &self.trained.surrogate;
        let given: Vec<State> = match given {
            Given::Own => states.iter().map(|state| (*state).clone()).collect(),
            Given::OfRun(other) => sensors_of(self.judged[other].0, states),
            Given::Permuted(seed) => permuted_sensors(surrogate.mapping(), states, seed),
        };
        error(surrogate, &given, states, all)
    }

    fn coordinate_only_error(&self, run: usize) -> Result<f64> {
        let states = self.judged[run].1.iter().copied();
        Ok(self.trained.strain_only.evaluate(states, None)?.relative_rmse)
    }
}

/// Relative RMSE of the predictions for the states `given` in comparison with the states `exact`; the errors are also
/// added to `all`.
fn error(surrogate: &MappingNetworks, given: &[State], exact: &[&State], all: &mut Scorer) -> Result<f64> {
    let mut own = Scorer::default();
    for (answer, state) in surrogate.answer(given)?.iter().zip(exact) {
        let dem = state.values(surrogate.mapping().output);
        own.add(dem, &answer.values);
        all.add(dem, &answer.values);
    }
    Ok(own.score().relative_rmse)
}

/// States with the same strains and with the sensors of another run at these strains.
fn sensors_of(other: &Run, states: &[&State]) -> Vec<State> {
    let at = |state: &&State| Some(State { strain: state.strain, ..other.at(state.strain)? });
    states.iter().filter_map(at).collect()
}

/// States with the same strains and with sensors that are permuted within the range of each sub-model.
fn permuted_sensors(mapping: &Mapping, states: &[&State], seed: u64) -> Vec<State> {
    let groups: Vec<usize> = states.iter().map(|state| mapping.sub_model_at(state.strain).0).collect();
    let order = permutation(&groups, seed);
    order.iter().zip(states).map(|(&from, to)| State { strain: to.strain, ..states[from].clone() }).collect()
}

/// True if the predictions of a sub-model for the training states in its range are nearly constant: their standard
/// deviation is below 1e-3 of that of the targets.
///
/// # Errors
/// If a state contains a value that is not finite.
pub fn is_constant(surrogate: &MappingNetworks, training: &[&State], sub_model: usize) -> Result<bool> {
    let states = states_of(surrogate.mapping(), training.iter().copied(), Some(sub_model));
    let answers = surrogate.answer(states.iter().copied())?;
    let given: Vec<f64> = answers.iter().flat_map(|answer| answer.values.iter().copied()).collect();
    let targets: Vec<f64> =
        states.iter().flat_map(|state| state.values(surrogate.mapping().output).iter().copied()).collect();
    Ok(spread(&given) < CONSTANT * spread(&targets))
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn spread(values: &[f64]) -> f64 {
    let mean = mean(values);
    (values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / values.len() as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mapping::paper_mapping;

    #[test]
    fn sensors_are_exchanged_within_sub_models() {
        let mapping = paper_mapping("F3").unwrap();
        let states: Vec<State> = (0..60)
            .map(|k| State {
                strain: 0.005 * f64::from(k),
                stress_ratio: 0.5,
                deviator_fabric: f64::from(k),
                densities: vec![f64::from(k)],
            })
            .collect();
        let all: Vec<&State> = states.iter().collect();
        let permuted = permuted_sensors(&mapping, &all, 1);
        assert_eq!(permuted, permuted_sensors(&mapping, &all, 1));
        assert_ne!(permuted, permuted_sensors(&mapping, &all, 2));
        let moved = permuted.iter().zip(&states).filter(|(a, b)| a.deviator_fabric != b.deviator_fabric);
        assert!(moved.count() > 40);
        for (state, own) in permuted.iter().zip(&states) {
            assert_eq!((state.strain, state.densities[0]), (own.strain, state.deviator_fabric));
            let home = mapping.sub_model_at(0.005 * state.deviator_fabric).0;
            assert_eq!(home, mapping.sub_model_at(state.strain).0);
        }
        let mut numbers: Vec<f64> = permuted.iter().map(|state| state.deviator_fabric).collect();
        numbers.sort_by(f64::total_cmp);
        assert!(numbers.iter().enumerate().all(|(k, &number)| number == k as f64));
    }
}
