//! A trained mapping: its networks and their predictions.

use granum_nets::{Deviation, Model};

use crate::mapping::{Form, Mapping, Quantity};
use crate::study_data::{Rows, State};
use granum_learn::dataset::Variable;
use granum_learn::score::{Score, Scorer};
use granum_learn::surrogate::Columns;
use granum_learn::surrogate::Outside;
use granum_learn::{LearnError, Result};

/// A mapping with one trained network for each sub-model.
///
/// [`MappingNetworks::answer`] predicts states, and [`MappingNetworks::predict_row`] rows of the inputs of the mapping,
/// which include the force if `P(f)` is the output. As a [`granum_learn::Surrogate`] it predicts columns of a data set.
#[derive(Clone, Debug)]
pub struct MappingNetworks {
    mapping: Mapping,
    form: Form,
    forces: Vec<f64>,
    networks: Vec<Model>,
    /// Inputs and outputs of the mapping as a surrogate.
    columns: Columns,
}

/// The prediction of a surrogate for a state.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// The output: one value, or for a distribution one value for each bin of f.
    pub values: Vec<f64>,
    /// Number of the sub-model that was used, from 0.
    pub sub_model: usize,
    /// True if the strain is outside the ranges of all sub-models, or an input is outside the trained range of the network.
    pub outside: bool,
}

/// The prediction for one row, see [`MappingNetworks::input_names`].
#[derive(Clone, Debug, PartialEq)]
pub struct RowAnswer {
    /// The output.
    pub value: f64,
    /// Standard deviation of an observation around the output, if the network provides it.
    pub standard_deviation: Option<f64>,
    /// The standard deviation, split by cause.
    pub deviation: Option<Deviation>,
    /// Lower and upper end of the requested interval, if the network provides it.
    pub interval: Option<[f64; 2]>,
    /// Number of the sub-model that was used, from 0.
    pub sub_model: usize,
    /// The inputs outside the trained range of the network, including the strain if no sub-model covers it.
    pub outside: Vec<Outside>,
}

impl MappingNetworks {
    /// A surrogate from a mapping and its networks; `forces` are the centres of the bins of f.
    ///
    /// # Errors
    /// If there is not one network for each sub-model, or the columns of a network are not those of the mapping.
    pub fn new(mapping: Mapping, form: Form, forces: Vec<f64>, networks: Vec<Model>) -> Result<Self> {
        let problem = |reason: String| LearnError::Network { network: mapping.name.clone(), reason };
        if mapping.sub_models.is_empty() || networks.len() != mapping.sub_models.len() {
            let (found, wanted) = (networks.len(), mapping.sub_models.len());
            return Err(problem(format!("{found} networks for {wanted} sub-models")));
        }
        let inputs = mapping.network_inputs(form, &forces);
        for (k, network) in networks.iter().enumerate() {
            let found: Vec<&str> = network.inputs().iter().map(|column| column.name.as_str()).collect();
            if found != inputs || network.output().name != mapping.network_output() {
                let (found, wanted) = (found.join(", "), inputs.join(", "));
                let output = &network.output().name;
                return Err(problem(format!(
                    "network {} maps ({found}) to {output}, but should map ({wanted}) to {}",
                    k + 1,
                    mapping.network_output()
                )));
            }
        }
        let columns = columns_of(&mapping, &forces);
        Ok(MappingNetworks { mapping, form, forces, networks, columns })
    }

    pub(super) fn data_columns(&self) -> &Columns {
        &self.columns
    }

    /// The mapping.
    pub fn mapping(&self) -> &Mapping {
        &self.mapping
    }

    /// Form in which the force distribution enters the networks.
    pub fn form(&self) -> Form {
        self.form
    }

    /// Centres of the bins of f.
    pub fn forces(&self) -> &[f64] {
        &self.forces
    }

    /// The networks, one for each sub-model.
    pub fn networks(&self) -> &[Model] {
        &self.networks
    }

    /// Names of the values of a row for [`MappingNetworks::predict_row`]. In both forms they are the quantities of a
    /// state: strain, fabric, stress ratio, the densities of all bins if the distribution is an input, and the force if
    /// the distribution is the output.
    pub fn input_names(&self) -> Vec<String> {
        self.mapping.network_inputs(Form::Histogram, &self.forces)
    }

    /// The trained range of a sub-model for each of [`MappingNetworks::input_names`]; for the strain only the part that
    /// the mapping covers. In point form all bins share the range of the densities.
    pub fn trained_ranges(&self, sub_model: usize) -> Vec<[f64; 2]> {
        let network = &self.networks[sub_model];
        let covered = self.mapping.sub_models.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], s| {
            [a.min(s.strain_range[0]), b.max(s.strain_range[1])]
        });
        let range = |name: &String| {
            let stands_for = |input: &str| {
                input == name || (input == "probability_density" && name.starts_with("probability_density_"))
            };
            let place = network.inputs().iter().position(|column| stands_for(&column.name));
            let scaler = &network.input_scalers()[place.unwrap_or(0)];
            match name.as_str() {
                "deviator_strain" => [scaler.minimum.max(covered[0]), scaler.maximum.min(covered[1])],
                _ => [scaler.minimum, scaler.maximum],
            }
        };
        self.input_names().iter().map(range).collect()
    }

    /// The prediction for one row. Its first value, the deviator strain, selects the sub-model. The interval should
    /// contain the share `level` of the states of unseen runs.
    ///
    /// # Errors
    /// If the row has the wrong length or a value is not finite.
    pub fn predict_row(&self, row: &[f64], level: f64) -> Result<RowAnswer> {
        let one = self.predict_rows(row, level)?.pop();
        one.ok_or_else(|| LearnError::Network {
            network: self.mapping.name.clone(),
            reason: "there is no row to predict".into(),
        })
    }

    /// As [`MappingNetworks::predict_row`], for many rows in row-major order.
    ///
    /// # Errors
    /// As [`MappingNetworks::predict_row`].
    pub fn predict_rows(&self, rows: &[f64], level: f64) -> Result<Vec<RowAnswer>> {
        let names = self.input_names();
        let problem = |reason: String| LearnError::Network { network: self.mapping.name.clone(), reason };
        if !rows.len().is_multiple_of(names.len()) {
            let (found, list) = (rows.len() % names.len(), names.join(", "));
            return Err(problem(format!("a row has {} values ({list}), not {found}", names.len())));
        }
        if let Some(k) = rows.iter().position(|value| !value.is_finite()) {
            let (row, name) = (k / names.len() + 1, &names[k % names.len()]);
            return Err(problem(format!("row {row}: {name} is {}, not a finite number", rows[k])));
        }
        let rows: Vec<&[f64]> = rows.chunks_exact(names.len()).collect();
        let mut answers = vec![None; rows.len()];
        for sub_model in 0..self.networks.len() {
            let own: Vec<usize> =
                (0..rows.len()).filter(|&k| self.mapping.sub_model_at(rows[k][0]).0 == sub_model).collect();
            if own.is_empty() {
                continue;
            }
            let inputs: Vec<f64> = own.iter().flat_map(|&k| self.network_rows(rows[k])).collect();
            let spread = self.spread(sub_model, &inputs, self.row_points(), level)?;
            let ranges = self.trained_ranges(sub_model);
            for (place, &k) in own.iter().enumerate() {
                answers[k] = Some(RowAnswer {
                    value: spread.values[place],
                    standard_deviation: spread.deviations.as_ref().map(|deviations| deviations[place].total),
                    deviation: spread.deviations.as_ref().map(|deviations| deviations[place]),
                    interval: spread.interval(place),
                    sub_model,
                    outside: self.outside(rows[k], &names, &ranges),
                });
            }
        }
        Ok(answers.into_iter().flatten().collect())
    }

    fn outside(&self, row: &[f64], names: &[String], ranges: &[[f64; 2]]) -> Vec<Outside> {
        let uncovered = !self.mapping.sub_model_at(row[0]).1;
        let beyond = |k: &usize| {
            let [low, high] = ranges[*k];
            !(row[*k] >= low && row[*k] <= high) || (*k == 0 && uncovered)
        };
        let found = (0..row.len()).filter(beyond);
        found.map(|k| Outside { name: names[k].clone(), value: row[k], range: ranges[k] }).collect()
    }

    /// Number of rows of network inputs whose outputs are averaged for one row.
    fn row_points(&self) -> usize {
        let number = self.mapping.output != Quantity::ForceDistribution;
        if number && self.mapping.has_point_rows(self.form) { self.forces.len() } else { 1 }
    }

    /// The network inputs for one row of [`MappingNetworks::input_names`]: the row itself, or one row for each bin of f.
    fn network_rows(&self, row: &[f64]) -> Vec<f64> {
        if self.form == Form::Histogram || !self.mapping.inputs.contains(&Quantity::ForceDistribution) {
            return row.to_vec();
        }
        let mut rows = Vec::new();
        for (bin, &force) in self.forces.iter().enumerate() {
            let mut at = 0;
            for &input in &self.mapping.inputs {
                if input == Quantity::ForceDistribution {
                    rows.extend([force, row[at + bin]]);
                    at += self.forces.len();
                } else {
                    rows.push(row[at]);
                    at += 1;
                }
            }
        }
        rows
    }

    /// Intervals that should contain the given share of the states of unseen runs: for each state `[lower, upper]` of the
    /// output, or of each bin of f. `None` for a state whose network provides no standard deviation.
    ///
    /// # Errors
    /// As [`MappingNetworks::answer`].
    pub fn intervals<'a>(
        &self,
        states: impl IntoIterator<Item = &'a State>,
        level: f64,
    ) -> Result<Vec<Option<Vec<[f64; 2]>>>> {
        let states: Vec<&State> = states.into_iter().collect();
        let mut intervals = vec![None; states.len()];
        for sub_model in 0..self.networks.len() {
            let own: Vec<usize> = (0..states.len())
                .filter(|&k| self.mapping.sub_model_at(states[k].strain).0 == sub_model)
                .collect();
            if own.is_empty() {
                continue;
            }
            let group: Vec<&State> = own.iter().map(|&k| states[k]).collect();
            let inputs = self.inputs(&group, &self.forces);
            let spread = self.spread(sub_model, &inputs, self.row_points(), level)?;
            let each = spread.values.len() / own.len();
            for (place, &k) in own.iter().enumerate() {
                intervals[k] = (place * each..(place + 1) * each).map(|i| spread.interval(i)).collect();
            }
        }
        Ok(intervals)
    }

    /// Predictions of a network for observations of the given number of points, with their standard deviations.
    fn spread(&self, sub_model: usize, inputs: &[f64], points: usize, level: f64) -> Result<Spread> {
        let network = &self.networks[sub_model];
        let failed = |error: granum_nets::ModelError| self.failed(sub_model, &error);
        let batch = network.predict_batch(inputs).map_err(failed)?.values;
        let deviations = network.deviations_of(inputs, points).map_err(failed)?;
        let mean = |values: &[f64]| values.iter().sum::<f64>() / points as f64;
        Ok(Spread {
            values: batch.chunks(points).map(mean).collect(),
            deviations,
            quantile: network.quantile(level),
        })
    }

    /// The predictions for states. In point form a scalar is the mean of the outputs over the bins of f.
    ///
    /// # Errors
    /// If a state contains a value that is not finite.
    pub fn answer<'a>(&self, states: impl IntoIterator<Item = &'a State>) -> Result<Vec<Answer>> {
        self.answer_at(states, &self.forces)
    }

    /// As [`MappingNetworks::answer`], but a distribution is predicted at arbitrary values of f. Distributions that are
    /// inputs are still given at the bins of f.
    ///
    /// # Errors
    /// As [`MappingNetworks::answer`].
    pub fn answer_at<'a>(
        &self,
        states: impl IntoIterator<Item = &'a State>,
        forces: &[f64],
    ) -> Result<Vec<Answer>> {
        let states: Vec<&State> = states.into_iter().collect();
        let at: Vec<(usize, bool)> =
            states.iter().map(|state| self.mapping.sub_model_at(state.strain)).collect();
        let mut answers = Vec::with_capacity(states.len());
        // Consecutive states of one sub-model are evaluated together.
        let mut start = 0;
        while start < states.len() {
            let sub_model = at[start].0;
            let length = at[start..].iter().take_while(|(k, _)| *k == sub_model).count();
            let group = start..start + length;
            self.answer_group(&states[group.clone()], &at[group], forces, &mut answers)?;
            start += length;
        }
        Ok(answers)
    }

    fn answer_group(
        &self,
        states: &[&State],
        at: &[(usize, bool)],
        forces: &[f64],
        answers: &mut Vec<Answer>,
    ) -> Result<()> {
        let sub_model = at[0].0;
        let inputs = self.inputs(states, forces);
        let batch = self.networks[sub_model]
            .predict_batch(&inputs)
            .map_err(|error| self.failed(sub_model, &error))?;
        let rows = batch.values.len() / states.len();
        for (k, &(_, inside)) in at.iter().enumerate() {
            let values = &batch.values[k * rows..(k + 1) * rows];
            answers.push(Answer {
                values: if self.mapping.output == Quantity::ForceDistribution {
                    values.to_vec()
                } else {
                    vec![values.iter().sum::<f64>() / rows as f64]
                },
                sub_model,
                outside: !inside || batch.outside[k * rows..(k + 1) * rows].contains(&true),
            });
        }
        Ok(())
    }

    /// The rows of network inputs for states, at arbitrary values of f if the output is a distribution.
    fn inputs(&self, states: &[&State], forces: &[f64]) -> Vec<f64> {
        if self.mapping.output != Quantity::ForceDistribution || forces == self.forces {
            return Rows::new(&self.mapping, self.form, &self.forces, states.iter().copied()).inputs;
        }
        let mut inputs = Vec::new();
        for state in states {
            let one = Rows::new(&self.mapping, self.form, &self.forces, [*state]);
            // If the output is a distribution, f is the last input.
            let others = &one.inputs[..one.input_columns - 1];
            for &force in forces {
                inputs.extend_from_slice(others);
                inputs.push(force);
            }
        }
        inputs
    }

    /// The score of the predictions for states within the ranges of the sub-models, or only within that of `sub_model`.
    ///
    /// # Errors
    /// As [`MappingNetworks::answer`].
    pub fn evaluate<'a>(
        &self,
        states: impl IntoIterator<Item = &'a State>,
        sub_model: Option<usize>,
    ) -> Result<Score> {
        let states = states_of(&self.mapping, states, sub_model);
        let mut scorer = Scorer::default();
        for (answer, state) in self.answer(states.iter().copied())?.iter().zip(&states) {
            scorer.add(state.values(self.mapping.output), &answer.values);
        }
        Ok(scorer.score())
    }

    fn failed(&self, sub_model: usize, error: &granum_nets::ModelError) -> LearnError {
        let network = format!("{} sub-model {}", self.mapping.name, sub_model + 1);
        LearnError::Network { network, reason: error.to_string() }
    }
}

/// Predictions with their standard deviations, and the half width of an interval in standard deviations.
struct Spread {
    values: Vec<f64>,
    deviations: Option<Vec<Deviation>>,
    quantile: f64,
}

impl Spread {
    fn interval(&self, k: usize) -> Option<[f64; 2]> {
        let half = self.quantile * self.deviations.as_ref()?[k].total;
        Some([self.values[k] - half, self.values[k] + half])
    }
}

/// The inputs and outputs of a mapping, all of which are dimensionless.
pub(super) fn columns_of(mapping: &Mapping, forces: &[f64]) -> Columns {
    let variable = |name: String| Variable { name, unit: String::new() };
    let of = |quantity: &Quantity| -> Vec<Variable> {
        let column = quantity.column();
        match quantity {
            Quantity::ForceDistribution => {
                forces.iter().map(|force| variable(format!("{column}_{force}"))).collect()
            }
            _ => vec![variable(column.to_owned())],
        }
    };
    Columns { inputs: mapping.inputs.iter().flat_map(of).collect(), outputs: of(&mapping.output) }
}

/// The states within the range of a sub-model, or within that of any sub-model.
pub(crate) fn states_of<'a>(
    mapping: &Mapping,
    states: impl IntoIterator<Item = &'a State>,
    sub_model: Option<usize>,
) -> Vec<&'a State> {
    states
        .into_iter()
        .filter(|state| {
            let (found, inside) = mapping.sub_model_at(state.strain);
            inside && sub_model.is_none_or(|wanted| wanted == found)
        })
        .collect()
}
