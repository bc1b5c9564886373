//! A trained study.

use granum_nets::Model;

use super::observer::StudyObserver;
use super::options::StudyOptions;
use super::training::{Job, network_name, network_seed, train_all};
use crate::baseline::Baselines;
use crate::mapping::{Form, Mapping};
use crate::mapping_networks::MappingNetworks;
use crate::study_data::{Run, StudyData};
use granum_learn::dataset::NamedRecord;
use granum_learn::{LearnError, Result};

/// A trained study.
///
/// ```
/// use granum_core::{Column, Table};
/// use granum_antony2006::study::{Silent, Study, StudyOptions};
/// use granum_antony2006::{StudyData, StudyDataOptions};
/// use granum_learn::dataset::{ColumnGroup, RunStates};
/// use granum_antony2006::paper_mappings;
///
/// // Runs as tables: strain increases, the stress ratio is proportional to the fabric, and P(f) has two bins.
/// let run = |name: &str, shift: f64| -> Result<RunStates, Box<dyn std::error::Error>> {
///     let strain: Vec<f64> = (0..=60).map(|k| 0.005 * f64::from(k)).collect();
///     let fabric: Vec<f64> = strain.iter().map(|e| 0.1 * (1.0 - (-40.0 * e).exp()) + shift).collect();
///     let ratio = fabric.iter().map(|f| 6.0 * f).collect();
///     let table = Table::new(vec![
///         Column::new("deviator_strain", "1", strain.clone()),
///         Column::new("stress_ratio", "1", ratio),
///         Column::new("deviator_fabric", "1", fabric),
///         Column::new("probability_density_0.5", "1", strain.iter().map(|e| 0.6 - 0.1 * e).collect()),
///         Column::new("probability_density_1.5", "1", strain.iter().map(|e| 0.3 + 0.1 * e).collect()),
///     ])?;
///     let (name_of, binned) = ("probability_density".to_string(), "force".to_string());
///     let bins = ColumnGroup { name: name_of, binned, bin_width: 1.0, centres: vec![0.5, 1.5] };
///     Ok(RunStates::new(name, table)?.with_group(bins)?)
/// };
/// let data = StudyData::of(&[run("a", 0.0)?, run("b", 0.004)?], &[run("c", 0.002)?], &StudyDataOptions::default())?;
///
/// // The third mapping, q/p = F3(eps_d, phi_d, P(f)), with small networks.
/// let options = StudyOptions { mappings: vec![paper_mappings()[2].with_neurons(3)], ..StudyOptions::default() };
/// let study = Study::train(&data, &options, &Silent)?;
/// let evaluation = &study.evaluate(&data)?[0];
/// assert!(evaluation.network.unseen.relative_rmse < 0.05, "{:?}", evaluation.network.unseen);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Study {
    /// Form in which the force distribution enters the networks.
    pub form: Form,
    /// Name of the trainer.
    pub trainer: String,
    /// Seed of the study.
    pub seed: u64,
    /// Hash of the data set, see [`StudyData::hash`].
    pub dataset_hash: String,
    /// Centres of the bins of f.
    pub forces: Vec<f64>,
    /// Width of a bin.
    pub bin_width: f64,
    /// The mappings, each with its strain-only networks.
    pub mappings: Vec<TrainedMapping>,
    /// The baselines; `None` for a study that was saved by a version that did not store them.
    pub baselines: Option<Baselines>,
}

/// A trained mapping.
#[derive(Clone, Debug)]
pub struct TrainedMapping {
    /// The networks.
    pub surrogate: MappingNetworks,
    /// Strain-only networks of the same size.
    pub strain_only: MappingNetworks,
    /// Training time of each network of `surrogate`, s; 0 for a network that was found finished.
    pub seconds: Vec<f64>,
    /// Training times of the networks of `strain_only`, s.
    pub strain_only_seconds: Vec<f64>,
}

impl Study {
    /// Trains all networks in parallel.
    ///
    /// # Errors
    /// If a sub-model has too few training states, the trainer returns an error, or the observer stops the study.
    pub fn train(dataset: &StudyData, options: &StudyOptions, observer: &dyn StudyObserver) -> Result<Study> {
        let alone: Vec<Mapping> = options.mappings.iter().map(Mapping::strain_only).collect();
        let mut jobs = Vec::new();
        for (mappings, strain_only) in [(&options.mappings, false), (&alone, true)] {
            for mapping in mappings {
                for sub_model in 0..mapping.sub_models.len() {
                    let name = network_name(mapping, strain_only, sub_model);
                    let seed = network_seed(options.seed, &name);
                    jobs.push(Job { name, mapping, sub_model, seed });
                }
            }
        }
        let trained = train_all(dataset, &jobs, options, observer)?;
        let mut trained = trained.into_iter();
        let mut collect = |mappings: &[Mapping]| -> Result<Vec<(MappingNetworks, Vec<f64>)>> {
            mappings.iter().map(|mapping| gather(mapping, options.form, dataset, &mut trained)).collect()
        };
        let surrogates = collect(&options.mappings)?;
        let strain_only = collect(&alone)?;
        let mappings = surrogates.into_iter().zip(strain_only).map(|(own, alone)| TrainedMapping {
            surrogate: own.0,
            seconds: own.1,
            strain_only: alone.0,
            strain_only_seconds: alone.1,
        });
        Ok(Study {
            form: options.form,
            trainer: options.trainer.name().to_owned(),
            seed: options.seed,
            dataset_hash: dataset.hash()?,
            forces: dataset.forces.clone(),
            bin_width: dataset.bin_width,
            mappings: mappings.collect(),
            baselines: Some(Baselines::fit(&options.mappings, dataset)?),
        })
    }

    /// The mapping of the given name.
    ///
    /// # Errors
    /// [`LearnError::Unknown`] if there is no such mapping.
    pub fn mapping(&self, name: &str) -> Result<&TrainedMapping> {
        let names = || self.mappings.iter().map(|m| m.surrogate.mapping().name.as_str()).collect::<Vec<_>>();
        self.mappings.iter().find(|m| m.surrogate.mapping().name == name).ok_or_else(|| LearnError::Unknown {
            kind: "mapping",
            name: name.to_owned(),
            known: names().join(", "),
        })
    }

    /// Takes from any record the states in the form that the networks need.
    ///
    /// # Errors
    /// As [`Run::new`].
    pub fn read(&self, record: &NamedRecord) -> Result<Run> {
        Run::new(record, &self.forces, self.bin_width)
    }

    /// Total training time of all networks except the strain-only ones, s.
    pub fn training_seconds(&self) -> f64 {
        self.mappings.iter().flat_map(|mapping| &mapping.seconds).sum()
    }
}

/// Collects the next networks of an iterator into the surrogate of a mapping.
fn gather(
    mapping: &Mapping,
    form: Form,
    dataset: &StudyData,
    trained: &mut impl Iterator<Item = (Model, f64)>,
) -> Result<(MappingNetworks, Vec<f64>)> {
    let (models, seconds) = trained.take(mapping.sub_models.len()).unzip();
    Ok((MappingNetworks::new(mapping.clone(), form, dataset.forces.clone(), models)?, seconds))
}
