//! The methods that fit networks with a state to paths.

use std::sync::Arc;

use granum_core::observer::{Observer, SharedObserver};
use granum_core::parallel;
use granum_nets::trainer::{Adam, Options, SharedTrainer, TerminationReason};
use granum_nets::{Data, DataError, Sequences};

use super::cell::{CellSizes, PathCell};
use super::channels::{Channels, Widths};
use super::fitted::{FittedPath, Kept};
use super::rotation::Rotation;
use crate::dataset::Dataset;
use crate::error::{LearnError, Result};
use crate::input_use::SplitMix;
use crate::surrogate::content::Content;
use crate::surrogate::recurrent::ranges;
use crate::surrogate::registry::SurrogateMethods;
use crate::surrogate::run_inputs::RunInputs;
use crate::surrogate::scatter_of_networks::RunVariances;
use crate::surrogate::spec::{Columns, FitSpec};
use crate::surrogate::surrogate_trait::{Surrogate, SurrogateMethod};

/// Rotations of each run beside the run itself.
const ROTATIONS: usize = 7;

/// Networks with a state for any path; the documentation of [this module](super) says how columns are read.
///
/// ```
/// use granum_core::observer::NoObserver;
/// use granum_core::{Column, Table};
/// use granum_learn::surrogate::{FitSpec, PathCell, PathNetworks, RunInputs, SurrogateMethod};
/// use granum_learn::{Dataset, RunStates};
///
/// // A material that yields: ds = k (de - |de| s).
/// let run = |k: u32| {
///     let strain: Vec<f64> = (0..40).map(|i| 2.0 * (0.2 * f64::from(i * (1 + k % 4)) + f64::from(k)).sin()).collect();
///     let mut stress = vec![0.0];
///     for pair in strain.windows(2) {
///         let step = pair[1] - pair[0];
///         stress.push(stress[stress.len() - 1] * (1.0 - step.abs()) + step);
///     }
///     RunStates::new(&format!("run-{k}"), Table::new(vec![Column::new("strain", "", strain), Column::new("stress", "", stress)])?)
/// };
/// let dataset = Dataset::new((0..12).map(run).collect::<granum_learn::Result<_>>()?)?;
/// let mut method = PathNetworks::new(PathCell::StateSpace);
/// (method.hidden, method.internal, method.networks) = (8, 0, 1);
/// let fitted = method.fit(&dataset, &FitSpec::new(["strain"], ["stress"]), &mut NoObserver)?;
/// // There and back.
/// let predictions = fitted.predict(&RunInputs::new(vec![0.0, 0.3, 0.6, 0.3, 0.0], 1, vec![5])?, 0.9)?;
/// assert!((predictions[2].values[0].mean - 0.51).abs() < 0.15 && predictions[4].values[0].mean < -0.05, "{predictions:?}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct PathNetworks {
    /// The kind of network.
    pub cell: PathCell,
    /// Number of hidden neurons.
    pub hidden: usize,
    /// Number of internal variables of `path-state-space`; of internal tensors and of internal scalars of `path-tensor`.
    pub internal: usize,
    /// Number of increments that `path-window` sees, the present one included.
    pub window: usize,
    /// Number of networks, at most one for each run (4).
    pub networks: usize,
    /// Number of random rotations of each run beside the run itself, for networks that are not objective. With none, predictions are no means
    /// over rotations either.
    pub rotations: usize,
    /// The trainer (mini-batch Adam).
    pub trainer: SharedTrainer,
}

impl PathNetworks {
    /// A method with settings that did well on random paths of sand, on runs that were kept out of the training runs.
    pub fn new(cell: PathCell) -> PathNetworks {
        let (hidden, internal, rotations) = match cell {
            PathCell::Gru | PathCell::Lstm => (64, 0, ROTATIONS),
            PathCell::StateSpace => (48, 16, ROTATIONS),
            PathCell::Window => (48, 0, ROTATIONS),
            PathCell::TensorStateSpace => (24, 1, 0),
        };
        let trainer = PathNetworks::adam(cell).into();
        PathNetworks { cell, hidden, internal, window: 20, networks: 4, rotations, trainer }
    }

    /// With rotations an epoch has that many more sequences.
    fn adam(cell: PathCell) -> Adam {
        let epochs = if cell == PathCell::TensorStateSpace { 80 } else { 25 };
        Adam { epochs, learning_rate: 0.01, maximum_failures: epochs, ..Adam::default() }
    }

    /// A method of a registry by its name, or networks with a state and settings: `path-tensor:hidden=12,internal=0`. The settings are `hidden`, `internal`,
    /// `window`, `networks`, `rotations`, `epochs` and `rate` (of learning).
    ///
    /// ```
    /// use granum_learn::surrogate::{PathNetworks, SurrogateMethods};
    ///
    /// let methods = SurrogateMethods::standard();
    /// assert_eq!(PathNetworks::from_words("path-window:window=5,epochs=20", &methods)?.name(), "path-window");
    /// assert!(PathNetworks::from_words("path-window:size=5", &methods).is_err());
    /// # Ok::<(), granum_learn::LearnError>(())
    /// ```
    ///
    /// # Errors
    /// If there is no such method or setting, or its value is no number.
    pub fn from_words(words: &str, methods: &SurrogateMethods) -> Result<Arc<dyn SurrogateMethod>> {
        let Some((name, settings)) = words.split_once(':') else { return methods.shared(words) };
        methods.by_name(name)?;
        let known = PathCell::ALL.into_iter().find(|cell| cell.name() == name);
        let cell = known.ok_or_else(|| LearnError::Surrogate {
            method: name.into(),
            reason: "it has no settings; networks of paths have them".into(),
        })?;
        let mut method = PathNetworks::new(cell);
        let mut adam = PathNetworks::adam(cell);
        for setting in settings.split(',') {
            let bad = || {
                let known = "hidden, internal, window, networks, rotations, epochs, rate";
                method_error(
                    name,
                    format!(
                        "`{setting}` is no setting: each is a word and a number, as hidden=12; there are {known}"
                    ),
                )
            };
            let (key, value) = setting.split_once('=').ok_or_else(bad)?;
            let whole = || value.parse::<usize>().map_err(|_| bad());
            match key {
                "hidden" => method.hidden = whole()?,
                "internal" => method.internal = whole()?,
                "window" => method.window = whole()?,
                "networks" => method.networks = whole()?,
                "rotations" => method.rotations = whole()?,
                "epochs" => (adam.epochs, adam.maximum_failures) = (whole()? as u64, whole()? as u64),
                "rate" => adam.learning_rate = value.parse().map_err(|_| bad())?,
                _ => return Err(bad()),
            }
        }
        method.trainer = adam.into();
        Ok(Arc::new(method))
    }

    fn failed(&self, error: impl std::fmt::Display) -> LearnError {
        method_error(self.name(), error.to_string())
    }

    fn sizes(&self) -> CellSizes {
        let PathNetworks { cell, hidden, internal, window, .. } = *self;
        CellSizes { cell, hidden, internal, window }
    }
}

fn method_error(method: &str, reason: String) -> LearnError {
    LearnError::Surrogate { method: method.into(), reason }
}

/// Whole runs in the units of networks.
pub(super) struct PathRuns {
    pub widths: Widths,
    pub increments: Vec<f64>,
    pub starts: Vec<f64>,
    pub targets: Vec<f64>,
    pub lengths: Vec<usize>,
}

impl PathRuns {
    /// Some of the runs.
    fn chosen(&self, keep: impl Fn(usize) -> bool) -> PathRuns {
        let (width, starts, outputs) = (self.widths.increment(), self.widths.starts(), self.widths.outputs());
        let (mut increments, mut targets) = (Vec::new(), Vec::new());
        let (mut of_starts, mut lengths) = (Vec::new(), Vec::new());
        let mut row = 0;
        for (run, length) in self.lengths.iter().enumerate() {
            if keep(run) {
                increments.extend(&self.increments[row * width..(row + length) * width]);
                targets.extend(&self.targets[row * outputs..(row + length) * outputs]);
                of_starts.extend(&self.starts[run * starts..(run + 1) * starts]);
                lengths.push(*length);
            }
            row += length;
        }
        PathRuns { widths: self.widths, increments, starts: of_starts, targets, lengths }
    }

    /// The same runs in other axes: one rotation for each.
    pub fn turned(&self, rotation: impl Fn(usize) -> Rotation) -> PathRuns {
        let Widths { tensors, direction, .. } = self.widths;
        let (width, starts, outputs) = (self.widths.increment(), self.widths.starts(), self.widths.outputs());
        let (mut increments, mut targets) = (self.increments.clone(), self.targets.clone());
        let mut of_starts = self.starts.clone();
        let mut row = 0;
        for (run, length) in self.lengths.iter().enumerate() {
            let rotation = rotation(run);
            for own in increments[row * width..(row + length) * width].chunks_exact_mut(width) {
                rotation.turn(own, 1, usize::from(direction > 0));
            }
            if !targets.is_empty() {
                for own in targets[row * outputs..(row + length) * outputs].chunks_exact_mut(outputs) {
                    rotation.turn(own, 0, tensors);
                }
            }
            rotation.turn(&mut of_starts[run * starts..(run + 1) * starts], 0, tensors);
            row += length;
        }
        PathRuns {
            widths: self.widths,
            increments,
            starts: of_starts,
            targets,
            lengths: self.lengths.clone(),
        }
    }

    fn append(&mut self, others: PathRuns) {
        self.increments.extend(others.increments);
        self.starts.extend(others.starts);
        self.targets.extend(others.targets);
        self.lengths.extend(others.lengths);
    }

    /// The sequences with their start values.
    pub fn sequences(&self) -> std::result::Result<Sequences, DataError> {
        Sequences::new(self.lengths.clone())?.with_starts(self.starts.clone(), self.widths.starts())
    }

    fn data(&self, sizes: &CellSizes) -> std::result::Result<Data, DataError> {
        let inputs = sizes.inputs(&self.widths, &self.increments, &self.lengths);
        let rows: usize = self.lengths.iter().sum();
        let columns = inputs.len() / rows.max(1);
        Data::with_target_columns(inputs, columns, self.targets.clone(), self.widths.outputs())?
            .with_sequences(self.sequences()?)
    }
}

impl SurrogateMethod for PathNetworks {
    fn name(&self) -> &str {
        self.cell.name()
    }

    fn help(&self) -> &str {
        self.cell.help()
    }

    fn has_memory(&self) -> bool {
        true
    }

    fn fit(
        &self,
        dataset: &Dataset,
        spec: &FitSpec,
        observer: &mut dyn Observer,
    ) -> Result<Box<dyn Surrogate>> {
        if self.networks == 0 || self.window == 0 {
            return Err(
                self.failed("the numbers of networks and of increments in a window must be 1 or more, not 0")
            );
        }
        let columns = spec.columns(dataset)?;
        let inputs = RunInputs::from_dataset(dataset, &columns)?;
        let targets = dataset.values(&columns.output_names())?;
        let channels = Channels::fit(&columns, &inputs, &targets)?;
        let (sizes, widths, outputs) = (self.sizes(), channels.widths(), columns.outputs.len());
        let all = PathRuns {
            widths,
            increments: channels.increments(&inputs),
            starts: channels.starts(&inputs),
            targets: channels.measured(&targets, outputs),
            lengths: inputs.lengths().to_vec(),
        };
        let runs = all.lengths.len();
        let count = self.networks.min(runs);
        let turns = if sizes.is_objective(&widths) { 0 } else { self.rotations };
        let shared = SharedObserver::new(observer);
        let done = std::sync::atomic::AtomicUsize::new(0);
        let networks = parallel::map(count, spec.threads, |k| {
            let stopped = || LearnError::Stopped {
                done: done.load(std::sync::atomic::Ordering::Relaxed),
                total: count,
            };
            if shared.stopped() {
                return Err(stopped());
            }
            let mut part = shared.part(format!("network {}", k + 1));
            let own = |run: usize| count > 1 && run % count == k;
            let mut learned = all.chosen(|run| !own(run));
            let seed = spec.seed.wrapping_add(k as u64);
            let first = all.chosen(|run| !own(run));
            let mut random = SplitMix(seed);
            for _ in 0..turns {
                let rotations: Vec<Rotation> =
                    first.lengths.iter().map(|_| Rotation::random(&mut random)).collect();
                learned.append(first.turned(|run| rotations[run].clone()));
            }
            let fail = |error: DataError| self.failed(error);
            let mut data = learned.data(&sizes).map_err(fail)?;
            if count > 1 {
                let judged = all.chosen(own).data(&sizes).map_err(fail)?;
                data = data.with_validation(judged).map_err(fail)?;
            }
            let mut network = sizes.network(&widths, seed, None).map_err(|error| self.failed(error))?;
            let options = Options { seed: Some(seed), ..Options::default() };
            let trainer = self.trainer.adapted(&options).unwrap_or_else(|| self.trainer.clone());
            let report = trainer.resume(&mut *network, &data, None, &mut part);
            let report = report.map_err(|error| self.failed(error))?;
            if report.termination == TerminationReason::Stopped {
                return Err(stopped());
            }
            done.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            part.completed();
            Ok(network)
        })?;
        let ranges = ranges(&inputs);
        let is_mean = turns > 0;
        let mut fitted =
            FittedPath { columns, channels, sizes, is_mean, networks, ranges, run_variances: None };
        if count > 1 {
            let means = fitted.outputs_of_networks(&inputs)?;
            fitted.run_variances = Some(RunVariances::new(&means, &targets, outputs, inputs.lengths()));
        }
        Ok(Box::new(fitted))
    }

    fn load(&self, columns: Columns, content: &Content) -> Result<Box<dyn Surrogate>> {
        let kept: Kept = content.read()?;
        let (inputs, outputs) = (columns.inputs.len(), columns.outputs.len());
        let whole = kept.channels.is_whole(inputs, outputs)
            && kept.sizes.cell == self.cell
            && kept.sizes.window > 0
            && !kept.networks.is_empty()
            && kept.ranges.len() == inputs
            && kept.run_variances.as_ref().is_none_or(|known| known.is_whole(outputs));
        if !whole {
            return Err(self.failed("the networks are not those of its columns"));
        }
        let widths = kept.channels.widths();
        let network = |weights: Vec<f64>| {
            kept.sizes.network(&widths, 1, Some(weights)).map_err(|error| self.failed(error))
        };
        let networks = kept.networks.into_iter().map(network).collect::<Result<_>>()?;
        let Kept { channels, sizes, is_mean, ranges, run_variances, .. } = kept;
        Ok(Box::new(FittedPath { columns, channels, sizes, is_mean, networks, ranges, run_variances }))
    }
}
