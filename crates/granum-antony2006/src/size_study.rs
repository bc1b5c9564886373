//! Does a soft sensor permit a smaller network? Error as a function of the number of neurons.
//!
//! The paper concludes this from Tables 1 and 3: the networks for q/p are smaller with the deviator fabric as an input (F3)
//! than without it (F1). Here both are trained with several sizes and several seeds, and the sizes that they need for the
//! same error are compared, that is the smallest size whose median error over the seeds is at most `1 + tolerance` times
//! the best median of the first mapping.

use serde::{Deserialize, Serialize};

use crate::mapping::{Mapping, paper_mappings};
use crate::mapping_networks::MappingNetworks;
use crate::study::observer::StudyObserver;
use crate::study::options::StudyOptions;
use crate::study::training::{Job, network_seed, train_all};
use crate::study_data::StudyData;
use granum_learn::Result;

/// Options of the study of network sizes.
#[derive(Clone, Debug)]
pub struct SizeStudyOptions {
    /// The mappings; the first determines the error to be reached.
    pub mappings: Vec<Mapping>,
    /// Numbers of neurons in each hidden layer.
    pub neurons: Vec<usize>,
    /// Number of seeds for each size.
    pub seeds: usize,
    /// Tolerated excess over the best median error, as a fraction of it.
    pub tolerance: f64,
    /// Form, trainer, seed and threads; the mappings in these options are not used.
    pub study: StudyOptions,
}

impl Default for SizeStudyOptions {
    fn default() -> Self {
        let mappings = paper_mappings().into_iter().filter(|m| m.name == "F1" || m.name == "F3").collect();
        SizeStudyOptions {
            mappings,
            neurons: vec![1, 2, 3, 4, 6, 8, 12, 20, 50],
            seeds: 5,
            tolerance: 0.1,
            study: StudyOptions::default(),
        }
    }
}

impl SizeStudyOptions {
    /// The names of all networks that the study trains.
    pub fn networks(&self) -> Vec<String> {
        let name =
            |(mapping, seed, sub_model): (&Mapping, usize, usize)| network_name(mapping, seed, sub_model);
        networks(&self.sized(), self.seeds()).map(name).collect()
    }

    fn seeds(&self) -> usize {
        self.seeds.max(1)
    }

    /// The mappings with networks of every size.
    fn sized(&self) -> Vec<Mapping> {
        let sizes = |mapping: &'_ Mapping| -> Vec<Mapping> {
            self.neurons.iter().map(|&neurons| mapping.with_neurons(neurons.max(1))).collect()
        };
        self.mappings.iter().flat_map(sizes).collect()
    }
}

/// Mapping, seed from 1, and number of the sub-model of every network, in the order in which they are trained.
fn networks(sized: &[Mapping], seeds: usize) -> impl Iterator<Item = (&Mapping, usize, usize)> {
    sized.iter().flat_map(move |mapping| {
        (1..=seeds).flat_map(move |seed| (0..mapping.sub_models.len()).map(move |k| (mapping, seed, k)))
    })
}

fn network_name(mapping: &Mapping, seed: usize, sub_model: usize) -> String {
    let neurons = mapping.sub_models.first().and_then(|s| s.hidden.first()).copied().unwrap_or(0);
    format!("{}-{neurons}-neurons-seed-{seed}-{}", mapping.name, sub_model + 1)
}

/// Errors as a function of the size of the networks.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SizeStudy {
    /// Tolerated excess over the best median error, as a fraction of it.
    pub tolerance: f64,
    /// Relative RMSE to be reached on held-out states.
    pub held_out_target: f64,
    /// Relative RMSE to be reached on unseen runs, if there are any.
    pub unseen_target: Option<f64>,
    /// One curve for each mapping.
    pub curves: Vec<SizeCurve>,
}

/// Errors of one mapping as a function of the size of its networks.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SizeCurve {
    /// Name of the mapping.
    pub mapping: String,
    /// One point for each size.
    pub points: Vec<SizePoint>,
    /// Smallest size that reaches the target on held-out states.
    pub neurons_for_held_out: Option<usize>,
    /// Smallest size that reaches the target on unseen runs.
    pub neurons_for_unseen: Option<usize>,
}

/// The results for one size: all sub-models of the mapping have the same number of neurons in each hidden layer.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SizePoint {
    /// Number of neurons in each hidden layer.
    pub neurons: usize,
    /// Number of weights and biases of one network.
    pub weights: usize,
    /// Relative RMSE on held-out states, one value per seed.
    pub held_out: Vec<f64>,
    /// Relative RMSE on unseen runs, one value per seed; empty without unseen runs.
    pub unseen: Vec<f64>,
    /// Median over the seeds of the error on held-out states.
    pub median_held_out: f64,
    /// Median over the seeds of the error on unseen runs.
    pub median_unseen: Option<f64>,
}

impl SizeStudy {
    /// Trains every mapping with every size and every seed.
    ///
    /// # Errors
    /// As [`crate::study::Study::train`].
    pub fn run(
        dataset: &StudyData,
        options: &SizeStudyOptions,
        observer: &dyn StudyObserver,
    ) -> Result<SizeStudy> {
        let (seeds, sized) = (options.seeds(), options.sized());
        let job = |(mapping, seed, sub_model): (_, usize, usize)| {
            let name = network_name(mapping, seed, sub_model);
            let seed = network_seed(options.study.seed, &name);
            Job { name, mapping, sub_model, seed }
        };
        let jobs: Vec<Job> = networks(&sized, seeds).map(job).collect();
        let mut trained =
            train_all(dataset, &jobs, &options.study, observer)?.into_iter().map(|(model, _)| model);
        let mut points = Vec::with_capacity(sized.len());
        for mapping in &sized {
            let mut point = SizePoint::default();
            for _ in 0..seeds {
                let models: Vec<_> = trained.by_ref().take(mapping.sub_models.len()).collect();
                if let Some(model) = models.first() {
                    point.weights = model.network().weights().len();
                    point.neurons = model.network().layers().get(1).copied().unwrap_or(0);
                }
                let forces = dataset.forces.clone();
                let surrogate = MappingNetworks::new(mapping.clone(), options.study.form, forces, models)?;
                point.held_out.push(surrogate.evaluate(dataset.held_out(), None)?.relative_rmse);
                if !dataset.unseen_runs.is_empty() {
                    point.unseen.push(surrogate.evaluate(dataset.unseen(), None)?.relative_rmse);
                }
            }
            point.median_held_out = median(&point.held_out).unwrap_or(0.0);
            point.median_unseen = median(&point.unseen);
            points.push(point);
        }
        Ok(conclude(options, points))
    }
}

fn conclude(options: &SizeStudyOptions, points: Vec<SizePoint>) -> SizeStudy {
    let per_mapping = options.neurons.len().max(1);
    let least = |values: &mut dyn Iterator<Item = f64>| values.reduce(f64::min);
    let reference = points.chunks(per_mapping).next().unwrap_or(&[]);
    let factor = 1.0 + options.tolerance;
    let held_out_target = least(&mut reference.iter().map(|p| p.median_held_out)).unwrap_or(0.0) * factor;
    let unseen_target =
        least(&mut reference.iter().filter_map(|p| p.median_unseen)).map(|best| best * factor);
    let smallest = |points: &[SizePoint], reaches: &dyn Fn(&SizePoint) -> bool| {
        points.iter().filter(|point| reaches(point)).map(|point| point.neurons).min()
    };
    let curves = options.mappings.iter().zip(points.chunks(per_mapping)).map(|(mapping, points)| SizeCurve {
        mapping: mapping.name.clone(),
        neurons_for_held_out: smallest(points, &|p| p.median_held_out <= held_out_target),
        neurons_for_unseen: smallest(points, &|p| {
            p.median_unseen.zip(unseen_target).is_some_and(|(e, t)| e <= t)
        }),
        points: points.to_vec(),
    });
    SizeStudy { tolerance: options.tolerance, held_out_target, unseen_target, curves: curves.collect() }
}

/// The median; for an even number of values the mean of the two middle ones.
pub(crate) fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    if sorted.is_empty() {
        None
    } else if sorted.len() % 2 == 1 {
        Some(sorted[middle])
    } else {
        Some(0.5 * (sorted[middle - 1] + sorted[middle]))
    }
}
