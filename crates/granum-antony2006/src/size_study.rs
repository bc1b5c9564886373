//! Does a soft sensor permit a smaller network? Error as a function of the number of neurons.
//!
//! The paper concludes this from Tables 1 and 3: the networks for q/p are smaller with the deviator fabric as an input (F3)
//! than without it (F1). Here both are trained with several sizes and several seeds, and the sizes that they need for the
//! same error are compared, that is the smallest size whose median error over the seeds is at most `1 + tolerance` times
//! the best median of the first mapping.

use std::sync::atomic::{AtomicUsize, Ordering};

use serde::{Deserialize, Serialize};

use granum_core::observer::{Flow, Progress};
use granum_core::parallel;
use granum_learn::networks::networks_of;
use granum_learn::study::StudyObserver;
use granum_learn::{Dataset, LearnError, Result, Surrogate, score_where};

use crate::data::PaperData;
use crate::mapping::{Mapping, paper_mappings};
use crate::method::NAME;
use crate::options::PaperOptions;

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
    pub study: PaperOptions,
}

impl Default for SizeStudyOptions {
    fn default() -> Self {
        let mappings = paper_mappings().into_iter().filter(|m| m.name == "F1" || m.name == "F3").collect();
        SizeStudyOptions {
            mappings,
            neurons: vec![1, 2, 3, 4, 6, 8, 12, 20, 50],
            seeds: 5,
            tolerance: 0.1,
            study: PaperOptions::default(),
        }
    }
}

impl SizeStudyOptions {
    /// The names under which all networks of the study are kept while it runs.
    pub fn networks(&self) -> Vec<String> {
        let sized = self.sized();
        let each = fits(&sized, self.seeds()).flat_map(|(mapping, seed)| {
            let name = fit_name(mapping, seed);
            (1..=mapping.sub_models.len()).map(move |k| format!("{name}-{k}"))
        });
        each.collect()
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

/// Mapping and seed from 1 of every fit, in the order in which they are trained.
fn fits(sized: &[Mapping], seeds: usize) -> impl Iterator<Item = (&Mapping, usize)> {
    sized.iter().flat_map(move |mapping| (1..=seeds).map(move |seed| (mapping, seed)))
}

fn fit_name(mapping: &Mapping, seed: usize) -> String {
    let neurons = mapping.sub_models.first().and_then(|s| s.hidden.first()).copied().unwrap_or(0);
    format!("{}-{neurons}-neurons-seed-{seed}", mapping.name)
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
    /// If a sub-model has too few training states, the trainer returns an error, or the observer stops the study.
    pub fn run(
        data: &PaperData,
        options: &SizeStudyOptions,
        observer: &dyn StudyObserver,
    ) -> Result<SizeStudy> {
        let (seeds, sized) = (options.seeds(), options.sized());
        let all: Vec<(&Mapping, usize)> = fits(&sized, seeds).collect();
        let done = AtomicUsize::new(0);
        let fitted = parallel::map(all.len(), options.study.threads, |k| {
            let stopped = || LearnError::Stopped { done: done.load(Ordering::Relaxed), total: all.len() };
            if observer.stop() {
                return Err(stopped());
            }
            let surrogate = fit(data, all[k], options, observer).map_err(|error| match error {
                LearnError::Stopped { .. } => stopped(),
                other => other,
            })?;
            done.fetch_add(1, Ordering::Relaxed);
            Ok(surrogate)
        })?;
        let mut points = Vec::with_capacity(sized.len());
        for (mapping, surrogates) in sized.iter().zip(fitted.chunks(seeds)) {
            let mut point = SizePoint::default();
            let spec = mapping.fit(&data.bins);
            let error = |surrogate: &dyn Surrogate, part: &Dataset| -> Result<f64> {
                Ok(score_where(surrogate, part, &spec.scored_states(part)?)?.relative_rmse)
            };
            for surrogate in surrogates.iter().map(AsRef::as_ref) {
                if let Some(model) = networks_of(surrogate).and_then(|networks| networks.networks().first()) {
                    point.weights = model.network().weights().len();
                    point.neurons = model.network().layers().get(1).copied().unwrap_or(0);
                }
                point.held_out.push(error(surrogate, &data.parts.held_out)?);
                if data.parts.unseen.rows() > 0 {
                    point.unseen.push(error(surrogate, &data.parts.unseen)?);
                }
            }
            point.median_held_out = median(&point.held_out).unwrap_or(0.0);
            point.median_unseen = median(&point.unseen);
            points.push(point);
        }
        Ok(conclude(options, points))
    }
}

fn fit(
    data: &PaperData,
    (mapping, seed): (&Mapping, usize),
    options: &SizeStudyOptions,
    observer: &dyn StudyObserver,
) -> Result<Box<dyn Surrogate>> {
    let name = fit_name(mapping, seed);
    let spec = mapping.fit(&data.bins).with_name(&name).with_seed(options.study.seed).with_threads(1);
    let mut listen = |progress: &Progress| {
        observer.progress(&name, progress);
        if observer.stop() { Flow::Stop } else { Flow::Continue }
    };
    let methods = options.study.methods();
    methods.by_name(NAME)?.fit_resumable(&data.parts.training, &spec, &mut listen, observer.networks())
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
