//! Ridge regression on splines: the regression of [`granum_learn::regression::deviations`] with the cubic B-splines of strain
//! of [`granum_learn::regression::spline`] as functions. The penalty on the squared coefficients of the sensors is 0.05 n for
//! `n` states. If a sensor is a distribution, each of its bins is an input; if the output is a distribution, each bin has
//! separate coefficients.

use serde::{Deserialize, Serialize};

use crate::mapping::{Mapping, Quantity};
use crate::study_data::State;
use granum_learn::regression::deviations::{Deviation, Regression, dot, row};
use granum_learn::regression::spline::{FUNCTIONS, basis};
use granum_learn::{LearnError, Result};

/// Penalty on the squared coefficients of the sensors, times the number of states.
const SENSOR_PENALTY: f64 = 0.05;

/// A fitted ridge regression.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ridge {
    /// Largest strain of the training states.
    end: f64,
    sensors: Vec<Quantity>,
    output: Quantity,
    /// One deviation for each value of the sensors.
    deviations: Vec<Deviation>,
    /// For each value of the output the coefficients of the splines, followed by those of the deviations.
    coefficients: Vec<Vec<f64>>,
}

impl Ridge {
    /// Fits the inputs and output of a mapping to states.
    ///
    /// # Errors
    /// [`LearnError::Dataset`] if there is no state or the equations cannot be solved.
    pub fn fit(mapping: &Mapping, states: &[&State]) -> Result<Ridge> {
        Ridge::fit_with(mapping, states, &|_, _| SENSOR_PENALTY * states.len() as f64)
    }

    /// As [`Ridge::fit`], with given penalties on the coefficients of the sensors. The penalty is a function of the
    /// quantity and of the standard deviation of the value from its mean as a function of strain.
    pub(crate) fn fit_with(
        mapping: &Mapping,
        states: &[&State],
        penalty: &dyn Fn(Quantity, f64) -> f64,
    ) -> Result<Ridge> {
        if states.is_empty() {
            return Err(LearnError::Dataset("ridge regression has no training state".to_owned()));
        }
        let unsolved =
            || LearnError::Dataset(format!("{}: the ridge regression has no solution", mapping.name));
        let end = states.iter().fold(0.0f64, |end, state| end.max(state.strain));
        let splines: Vec<Vec<f64>> = states.iter().map(|state| basis(state.strain, end).to_vec()).collect();
        let sensors = sensors_of(mapping);
        let quantities: Vec<Quantity> = (sensors.iter())
            .flat_map(|&sensor| std::iter::repeat_n(sensor, states[0].values(sensor).len()))
            .collect();
        let penalty = |input: usize, deviation: f64| penalty(quantities[input], deviation);
        let regression =
            Regression::new(&splines, &columns(states, &sensors), &penalty).ok_or_else(unsolved)?;
        let targets = columns(states, &[mapping.output]);
        let coefficients = targets.iter().map(|targets| regression.coefficients(targets)).collect();
        let deviations = regression.into_deviations();
        Ok(Ridge { end, sensors, output: mapping.output, deviations, coefficients })
    }

    /// The prediction for a state: one value, or one value for each bin of f.
    pub fn answer(&self, state: &State) -> Vec<f64> {
        let row = self.row(state);
        self.coefficients.iter().map(|coefficients| dot(coefficients, &row)).collect()
    }

    fn row(&self, state: &State) -> Vec<f64> {
        let values = self.sensors.iter().flat_map(|&sensor| state.values(sensor).iter().copied());
        row(&self.deviations, &basis(state.strain, self.end), values)
    }

    /// True if it was fitted to the inputs and the output of the given mapping, with the given number of bins of f.
    pub(super) fn is_of(&self, mapping: &Mapping, bins: usize) -> bool {
        let values = |quantity: &Quantity| if *quantity == Quantity::ForceDistribution { bins } else { 1 };
        let sensors = sensors_of(mapping);
        let columns: usize = sensors.iter().map(values).sum();
        self.sensors == sensors
            && self.output == mapping.output
            && self.deviations.len() == columns
            && self.deviations.iter().all(|deviation| deviation.mean.len() == FUNCTIONS)
            && self.coefficients.len() == values(&mapping.output)
            && self.coefficients.iter().all(|row| row.len() == FUNCTIONS + columns)
    }
}

/// The inputs of a mapping except the strain.
fn sensors_of(mapping: &Mapping) -> Vec<Quantity> {
    mapping.inputs.iter().copied().filter(|&input| input != Quantity::DeviatorStrain).collect()
}

/// The values of quantities at states, one column for each value.
fn columns(states: &[&State], quantities: &[Quantity]) -> Vec<Vec<f64>> {
    let mut columns = Vec::new();
    for &quantity in quantities {
        let count = states.first().map_or(0, |state| state.values(quantity).len());
        columns.extend((0..count).map(|k| states.iter().map(|state| state.values(quantity)[k]).collect()));
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mapping::paper_mapping;

    /// States with sensors that are far from any function of strain: they alternate by +1 and -1 about a curve.
    fn states(slope: f64) -> Vec<State> {
        (1..=240)
            .map(|k| {
                let strain = 0.3 * f64::from(k) / 240.0;
                let shown = if (k / 2) % 2 == 0 { 0.01 } else { -0.01 };
                State {
                    strain,
                    stress_ratio: 0.5 + 2.0 * strain + slope * shown,
                    deviator_fabric: 0.1 + strain + shown,
                    densities: vec![0.3 - strain, 0.2 + 2.0 * slope * shown],
                }
            })
            .collect()
    }

    /// The target is the sum of a spline and a multiple of a deviation that no spline can represent. The squares of the
    /// inputs of this coefficient sum to n, so that the penalty of 0.05 n reduces it by the factor 1 / 1.05.
    #[test]
    fn coefficients_as_solved_by_hand() {
        let mut mapping = paper_mapping("F4").unwrap();
        mapping.output = Quantity::StressRatio;
        let states = states(3.0);
        let all: Vec<&State> = states.iter().collect();
        let ridge = Ridge::fit(&mapping, &all).unwrap();
        let sensed = ridge.coefficients[0][FUNCTIONS];
        assert!((ridge.deviations[0].standard_deviation - 0.01).abs() < 2e-4, "{ridge:?}");
        let by_hand = 3.0 * ridge.deviations[0].standard_deviation / 1.05;
        assert!((sensed / by_hand - 1.0).abs() < 1e-6, "{sensed} {by_hand}");
        let mut state = states[100].clone();
        let before = ridge.answer(&state)[0];
        state.deviator_fabric += 0.005;
        assert!((ridge.answer(&state)[0] - before - 0.005 * 3.0 / 1.05).abs() < 1e-7);
        // The regression on strain alone predicts the curve.
        let alone = Ridge::fit(&mapping.strain_only(), &all).unwrap();
        assert!((alone.answer(&state)[0] - (0.5 + 2.0 * state.strain)).abs() < 2e-3);
        assert_eq!(alone.deviations.len(), 0);
        assert!(ridge.is_of(&mapping, 2) && !ridge.is_of(&mapping.strain_only(), 2));
        assert!(Ridge::fit(&mapping, &[]).is_err());
    }

    #[test]
    fn distributions_are_inputs_and_answers_bin_by_bin() {
        let states = states(1.0);
        let all: Vec<&State> = states.iter().collect();
        let read = Ridge::fit(&paper_mapping("F1").unwrap(), &all).unwrap();
        assert_eq!((read.deviations.len(), read.coefficients.len()), (2, 1));
        // The first bin is a function of strain: its deviation from the mean is rounding and contains no information.
        assert!(read.deviations[0].standard_deviation < 1e-3);
        let given = Ridge::fit(&paper_mapping("F5").unwrap(), &all).unwrap();
        assert_eq!((given.deviations.len(), given.coefficients.len()), (2, 2));
        let answer = given.answer(&states[50]);
        assert!((answer[1] - states[50].densities[1]).abs() < 1e-3, "{answer:?}");
        let text = serde_json::to_string(&given).unwrap();
        assert_eq!(serde_json::from_str::<Ridge>(&text).unwrap(), given);
    }
}
