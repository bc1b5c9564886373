//! The networks of a mapping as a general surrogate.
//!
//! As a surrogate, a mapping has columns of a data set as inputs and outputs; if `P(f)` is the output, it predicts all
//! bins at once.

use granum_core::observer::{Observer, SharedObserver};
use granum_nets::Model;
use granum_nets::trainer::{SharedTrainer, training_progress};
use serde::{Deserialize, Serialize};

use crate::mapping::{Form, Mapping, Quantity, paper_mappings};
use crate::mapping_networks::{MappingNetworks, RowAnswer, columns_of};
use crate::study::observer::{StudyObserver, StudyProgress};
use crate::study::options::StudyOptions;
use crate::study::training::{Job, network_name, network_seed, train_all};
use crate::study_data::StudyData;
use granum_learn::dataset::{Dataset, Variable};
use granum_learn::surrogate::Content;
use granum_learn::surrogate::{Columns, FitSpec};
use granum_learn::surrogate::{Estimate, Outside, Prediction, causes};
use granum_learn::surrogate::{RunInputs, Surrogate, SurrogateMethod};
use granum_learn::{LearnError, Result};

const NAME: &str = "antony2006";

/// The networks of a mapping of Antony, Zhou and Wang (2006), each for a range of the deviator strain. They are trained as
/// in [`super::Study`] and are bit-identical if the seed is the same.
///
/// ```
/// use granum_antony2006::{MappingMethod, paper_mappings};
/// use granum_learn::SurrogateMethod;
///
/// // By default the mapping of the paper with the requested columns is used; here a mapping is given.
/// let mut method = MappingMethod::default();
/// method.mapping = Some(paper_mappings()[2].with_neurons(5));
/// assert_eq!(method.name(), "antony2006");
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct MappingMethod {
    /// The mapping; `None` for the one of the paper with the requested inputs and outputs.
    pub mapping: Option<Mapping>,
    /// Form in which the force distribution enters the networks.
    pub form: Form,
    /// The trainer.
    pub trainer: SharedTrainer,
    /// Factor on the numbers of epochs in the tables of the paper, for the trainer of the paper.
    pub epoch_factor: f64,
}

impl Default for MappingMethod {
    fn default() -> Self {
        let StudyOptions { form, trainer, epoch_factor, .. } = StudyOptions::default();
        MappingMethod { mapping: None, form, trainer, epoch_factor }
    }
}

impl MappingMethod {
    /// The method for a given mapping.
    pub fn new(mapping: Mapping) -> MappingMethod {
        MappingMethod { mapping: Some(mapping), ..MappingMethod::default() }
    }

    fn chosen(&self, columns: &Columns, forces: &[f64]) -> Result<Mapping> {
        let fits = |mapping: &Mapping| columns_of(mapping, forces) == *columns;
        let known = self.mapping.clone().map_or_else(paper_mappings, |mapping| vec![mapping]);
        known.iter().find(|mapping| fits(mapping)).cloned().ok_or_else(|| {
            let formulas: Vec<String> = known.iter().map(Mapping::formula).collect();
            failed(format!(
                "no mapping goes from ({}) to ({}); there are: {}",
                columns.input_names().join(", "),
                columns.output_names().join(", "),
                formulas.join("; ")
            ))
        })
    }
}

fn failed(reason: impl Into<String>) -> LearnError {
    LearnError::Surrogate { method: NAME.into(), reason: reason.into() }
}

/// Columns of a data set with the unit "1" of the sensors replaced by that of dimensionless numbers.
fn pure(columns: Columns) -> Columns {
    let pure = |variable: Variable| match variable.unit.as_str() {
        "1" => Variable { unit: String::new(), ..variable },
        _ => variable,
    };
    Columns {
        inputs: columns.inputs.into_iter().map(pure).collect(),
        outputs: columns.outputs.into_iter().map(pure).collect(),
    }
}

/// An observer of any work as one of a study.
struct Heard<'a>(SharedObserver<'a>);

impl StudyObserver for Heard<'_> {
    fn progress(&self, progress: &StudyProgress) {
        let StudyProgress { network, epoch, epochs, error } = *progress;
        self.0.part(network).progress(&training_progress(epoch, epochs, error, None));
    }
    fn trained(&self, network: &str, _: &Model, _: f64) {
        self.0.part(network).completed();
    }
    fn stop(&self) -> bool {
        self.0.stopped()
    }
}

impl SurrogateMethod for MappingMethod {
    fn name(&self) -> &str {
        NAME
    }

    fn help(&self) -> &str {
        "the networks of a mapping of Antony, Zhou and Wang (2006), one for each range of strain"
    }

    fn fit(
        &self,
        dataset: &Dataset,
        spec: &FitSpec,
        observer: &mut dyn Observer,
    ) -> Result<Box<dyn Surrogate>> {
        let columns = pure(spec.columns(dataset)?);
        let data = StudyData::all_training(dataset)?;
        let mapping = self.chosen(&columns, &data.forces)?;
        let options = StudyOptions {
            mappings: vec![mapping.clone()],
            form: self.form,
            trainer: self.trainer.clone(),
            epoch_factor: self.epoch_factor,
            seed: spec.seed,
            threads: spec.threads,
        };
        let job = |sub_model: usize| {
            let name = network_name(&mapping, false, sub_model);
            Job { seed: network_seed(spec.seed, &name), name, mapping: &mapping, sub_model }
        };
        let jobs: Vec<Job> = (0..mapping.sub_models.len()).map(job).collect();
        let heard = Heard(SharedObserver::new(observer));
        let trained = train_all(&data, &jobs, &options, &heard)?;
        let networks = trained.into_iter().map(|(model, _)| model).collect();
        Ok(Box::new(MappingNetworks::new(mapping.clone(), self.form, data.forces.clone(), networks)?))
    }

    fn load(&self, columns: Columns, content: &Content) -> Result<Box<dyn Surrogate>> {
        let kept: Kept = content.read()?;
        let models = kept
            .networks
            .iter()
            .map(|value| Model::from_value(value, "network").map_err(|error| failed(error.to_string())));
        let networks = models.collect::<Result<Vec<_>>>()?;
        let surrogate = MappingNetworks::new(kept.mapping, kept.form, kept.forces, networks)?;
        if *Surrogate::columns(&surrogate) != columns {
            return Err(failed("the columns of the mapping are not those that the file names"));
        }
        Ok(Box::new(surrogate))
    }
}

/// A mapping and its networks in a file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Kept {
    mapping: Mapping,
    form: Form,
    forces: Vec<f64>,
    networks: Vec<serde_json::Value>,
}

impl Surrogate for MappingNetworks {
    fn method(&self) -> &str {
        NAME
    }

    fn columns(&self) -> &Columns {
        self.data_columns()
    }

    fn answer(&self, inputs: &RunInputs, level: f64) -> Result<Vec<Prediction>> {
        // If the output is a distribution, the last input of the networks is the force.
        let distribution = self.mapping().output == Quantity::ForceDistribution;
        let forces: Vec<Option<f64>> =
            if distribution { self.forces().iter().copied().map(Some).collect() } else { vec![None] };
        let asked: Vec<f64> = inputs
            .rows()
            .flat_map(|row| forces.iter().flat_map(|force| row.iter().copied().chain(*force)))
            .collect();
        let answers = self.predict_rows(&asked, level)?;
        Ok(answers.chunks(forces.len().max(1)).map(prediction).collect())
    }

    fn content(&self) -> Result<Content> {
        let networks =
            self.networks().iter().map(|model| model.to_value().map_err(|error| failed(error.to_string())));
        Content::new(&Kept {
            mapping: self.mapping().clone(),
            form: self.form(),
            forces: self.forces().to_vec(),
            networks: networks.collect::<Result<_>>()?,
        })
    }
}

/// The prediction for one row, with one estimate for each output.
fn prediction(answers: &[RowAnswer]) -> Prediction {
    let estimate = |answer: &RowAnswer| match (answer.interval, &answer.deviation) {
        (Some(ends), Some(deviation)) => Estimate::new(answer.value).within(ends, causes(deviation)),
        _ => Estimate::new(answer.value),
    };
    let mut outside: Vec<Outside> = Vec::new();
    for found in answers.iter().flat_map(|answer| &answer.outside) {
        if outside.iter().all(|known| known.name != found.name) {
            outside.push(found.clone());
        }
    }
    Prediction::new(answers.iter().map(estimate).collect()).with_outside(outside)
}
