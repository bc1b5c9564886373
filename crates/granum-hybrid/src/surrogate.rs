//! A trained mapping: its networks, and their answers.

use granum_nets::Model;

use crate::dataset::{Rows, State};
use crate::error::{HybridError, Result};
use crate::mapping::{Form, Mapping, Quantity};
use crate::score::{Score, Scorer};

/// A mapping with one trained network a sub-model.
#[derive(Clone, Debug)]
pub struct Surrogate {
    mapping: Mapping,
    form: Form,
    forces: Vec<f64>,
    networks: Vec<Model>,
}

/// What a surrogate says of a state.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// The output: one value, or one a bin of f for a distribution.
    pub values: Vec<f64>,
    /// Number of the sub-model that answered, from 0.
    pub sub_model: usize,
    /// True if the strain lies in no sub-model's range, or an input outside what its network was trained on.
    pub outside: bool,
}

/// What a surrogate says of one row of network inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct RowAnswer {
    /// The output.
    pub value: f64,
    /// Standard deviation of an observation around it, where the network knows it.
    pub standard_deviation: Option<f64>,
    /// Number of the sub-model that answered, from 0.
    pub sub_model: usize,
    /// Names of the inputs that lie outside the range the network was trained in; the strain is among them where no
    /// sub-model covers it.
    pub outside: Vec<String>,
}

impl Surrogate {
    /// Puts a mapping and its networks together; `forces` are the centres of the bins of f.
    ///
    /// # Errors
    /// If there is not one network for each sub-model, or a network has other columns than the mapping.
    pub fn new(mapping: Mapping, form: Form, forces: Vec<f64>, networks: Vec<Model>) -> Result<Self> {
        let problem = |reason: String| HybridError::Network { network: mapping.name.clone(), reason };
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
        Ok(Surrogate { mapping, form, forces, networks })
    }

    /// What it maps.
    pub fn mapping(&self) -> &Mapping {
        &self.mapping
    }

    /// How the force distribution enters.
    pub fn form(&self) -> Form {
        self.form
    }

    /// Centres of the bins of f.
    pub fn forces(&self) -> &[f64] {
        &self.forces
    }

    /// Its networks, one a sub-model.
    pub fn networks(&self) -> &[Model] {
        &self.networks
    }

    /// Names of the values of a row that [`Surrogate::predict`] takes.
    pub fn input_names(&self) -> Vec<String> {
        self.mapping.network_inputs(self.form, &self.forces)
    }

    /// Answers one row of network inputs, the deviator strain first: the sub-model is chosen by it.
    ///
    /// # Errors
    /// If the row has the wrong length or a value is not finite.
    pub fn predict(&self, row: &[f64]) -> Result<RowAnswer> {
        let strain = row.first().copied().unwrap_or(f64::NAN);
        let (sub_model, inside) = self.mapping.sub_model_at(strain);
        let prediction =
            self.networks[sub_model].predict(row).map_err(|error| self.failed(sub_model, &error))?;
        let mut outside = prediction.outside;
        if !inside && !outside.iter().any(|name| name == "deviator_strain") {
            outside.insert(0, "deviator_strain".to_owned());
        }
        Ok(RowAnswer {
            value: prediction.value,
            standard_deviation: prediction.standard_deviation,
            sub_model,
            outside,
        })
    }

    /// Answers states. A number that is asked of every bin of f (point form) is the mean over the bins.
    ///
    /// # Errors
    /// If a state holds a value that is not finite.
    pub fn answer<'a>(&self, states: impl IntoIterator<Item = &'a State>) -> Result<Vec<Answer>> {
        self.answer_at(states, &self.forces)
    }

    /// As [`Surrogate::answer`], with a distribution given at any values of f. Inputs that are distributions stand at
    /// the bins of f all the same.
    ///
    /// # Errors
    /// As [`Surrogate::answer`].
    pub fn answer_at<'a>(
        &self,
        states: impl IntoIterator<Item = &'a State>,
        forces: &[f64],
    ) -> Result<Vec<Answer>> {
        let states: Vec<&State> = states.into_iter().collect();
        let at: Vec<(usize, bool)> =
            states.iter().map(|state| self.mapping.sub_model_at(state.strain)).collect();
        let mut answers = Vec::with_capacity(states.len());
        // States that follow each other in one sub-model go through its network together.
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

    /// The rows of network inputs for states, at any values of f where the output is a distribution.
    fn inputs(&self, states: &[&State], forces: &[f64]) -> Vec<f64> {
        if self.mapping.output != Quantity::ForceDistribution || forces == self.forces {
            return Rows::new(&self.mapping, self.form, &self.forces, states.iter().copied()).inputs;
        }
        let mut inputs = Vec::new();
        for state in states {
            let one = Rows::new(&self.mapping, self.form, &self.forces, [*state]);
            // f is the last input where the output is a distribution.
            let others = &one.inputs[..one.input_columns - 1];
            for &force in forces {
                inputs.extend_from_slice(others);
                inputs.push(force);
            }
        }
        inputs
    }

    /// Scores the answers to states within the ranges of the sub-models; with `sub_model`, to its states alone.
    ///
    /// # Errors
    /// As [`Surrogate::answer`].
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

    fn failed(&self, sub_model: usize, error: &granum_nets::ModelError) -> HybridError {
        let network = format!("{} sub-model {}", self.mapping.name, sub_model + 1);
        HybridError::Network { network, reason: error.to_string() }
    }
}

/// The states within the range of a sub-model, or of any.
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
