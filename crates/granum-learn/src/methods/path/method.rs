//! The methods that fit networks with a state to paths.

use std::sync::Arc;

use granum_core::observer::Observer;
use granum_nets::DataError;
use granum_nets::trainer::{Adam, Options, SharedTrainer};

use super::cell::{CellSizes, PathCell};
use super::channels::Channels;
use super::errors::PathErrors;
use super::fitted::{FittedPath, Kept};
use super::rotation::Rotation;
use super::runs::PathRuns;
use crate::dataset::Dataset;
use crate::error::{LearnError, Result};
use crate::input_use::SplitMix;
use crate::methods::networks_of_parts::networks_of_parts;
use crate::methods::recurrent::ranges;
use crate::surrogate::content::Content;
use crate::surrogate::run_inputs::RunInputs;
use crate::surrogate::spec::{Columns, FitSpec};
use crate::surrogate::surrogate_trait::{Surrogate, SurrogateMethod};

/// Rotations of each run beside the run itself.
const ROTATIONS: usize = 7;

/// Networks with a state for any path, which learn the change for an increment and are rolled out freely along whole paths.
///
/// The path are the six columns of strain (`axial_strain`, `lateral_strain_2`, `lateral_strain_3`, `shear_strain_yz`, `shear_strain_zx`,
/// `shear_strain_xy`), of which the increments between the rows of a run count, or any other inputs that vary along a run. If `volumetric_strain` is an
/// output, only the deviator of the increment is an input. Inputs that are constant in a run describe the sample: `sample.X` is the value of the output
/// `X` before the first row. With strains, six outputs `X_11`, `X_22`, `X_33`, `X_23`, `X_13`, `X_12` are one tensor.
///
/// ```
/// use granum_core::observer::NoObserver;
/// use granum_core::{Column, Table};
/// use granum_nets::trainer::Adam;
/// use granum_learn::surrogate::{FitSpec, PathCell, PathNetworks, RunInputs, SurrogateMethod};
/// use granum_learn::{Dataset, RunStates};
///
/// // A material that yields: ds = k (de - |de| s).
/// let run = |k: u32| {
///     let strain: Vec<f64> = (0..60).map(|i| 1.5 * (0.1 * f64::from(i * (1 + k % 3)) + f64::from(k)).sin()).collect();
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
/// method.trainer = Adam { epochs: 300, learning_rate: 0.02, ..Adam::default() }.into();
/// let fitted = method.fit(&dataset, &FitSpec::new(["strain"], ["stress"]), &mut NoObserver)?;
/// // There and back.
/// let predictions = fitted.predict(&RunInputs::new(vec![0.0, 0.2, 0.4, 0.2, 0.0], 1, vec![5])?, 0.9)?;
/// assert!((predictions[2].values[0].mean - 0.36).abs() < 0.1 && predictions[4].values[0].mean < -0.05, "{predictions:?}");
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
    /// Largest number of rotations of each run, all of which are in memory.
    pub const MOST_ROTATIONS: usize = 1000;

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
    pub(crate) fn adam(cell: PathCell) -> Adam {
        let epochs = if cell == PathCell::TensorStateSpace { 80 } else { 25 };
        Adam { epochs, learning_rate: 0.01, maximum_failures: epochs, ..Adam::default() }
    }

    fn failed(&self, error: impl std::fmt::Display) -> LearnError {
        LearnError::Surrogate { method: self.name().into(), reason: error.to_string() }
    }

    fn sizes(&self) -> CellSizes {
        let PathNetworks { cell, hidden, internal, window, .. } = *self;
        CellSizes { cell, hidden, internal, window }
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
        if self.rotations > PathNetworks::MOST_ROTATIONS {
            let (most, rotations) = (PathNetworks::MOST_ROTATIONS, self.rotations);
            return Err(
                self.failed(format!("the number of rotations must be at most {most}, not {rotations}"))
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
        let networks = networks_of_parts(count, spec.threads, observer, |k, part| {
            let own = |run: usize| count > 1 && run % count == k;
            let seed = spec.seed.wrapping_add(k as u64);
            // Sizes that cannot be are refused before there are data for them.
            let mut network = sizes.network(&widths, seed, None).map_err(|error| self.failed(error))?;
            let mut learned = all.chosen(|run| !own(run));
            let mut random = SplitMix(seed);
            let turned: Vec<PathRuns> =
                (0..turns).map(|_| learned.turned(|| Rotation::random(&mut random))).collect();
            turned.into_iter().for_each(|runs| learned.append(runs));
            let fail = |error: DataError| self.failed(error);
            let mut data = learned.data(&sizes).map_err(fail)?;
            if count > 1 {
                let judged = all.chosen(own).data(&sizes).map_err(fail)?;
                data = data.with_validation(judged).map_err(fail)?;
            }
            let options = Options { seed: Some(seed), ..Options::default() };
            let trainer = self.trainer.adapted(&options).unwrap_or_else(|| self.trainer.clone());
            let report = trainer.resume(&mut *network, &data, None, part);
            let report = report.map_err(|error| self.failed(error))?;
            Ok((network, report.termination))
        })?;
        let ranges = ranges(&inputs);
        let is_mean = turns > 0;
        let mut fitted = FittedPath { columns, channels, sizes, is_mean, networks, ranges, errors: None };
        if count > 1 {
            let means = fitted.outputs_of_networks(&inputs)?;
            let path = fitted.channels.path(&inputs);
            let units = fitted.units(&means);
            fitted.errors = PathErrors::new(&means, &targets, &units, &path);
        }
        Ok(Box::new(Arc::new(fitted)))
    }

    fn load(&self, columns: Columns, content: &Content) -> Result<Box<dyn Surrogate>> {
        let kept: Kept = content.read()?;
        let (inputs, outputs) = (columns.inputs.len(), columns.outputs.len());
        let whole = kept.channels.is_whole(inputs, outputs)
            && kept.sizes.cell == self.cell
            && kept.sizes.window > 0
            && !kept.networks.is_empty()
            && kept.ranges.len() == inputs
            && kept.errors.as_ref().is_none_or(|known| known.is_whole(outputs));
        if !whole {
            return Err(self.failed("the networks are not those of its columns"));
        }
        let widths = kept.channels.widths();
        let network = |weights: Vec<f64>| {
            kept.sizes.network(&widths, 1, Some(weights)).map_err(|error| self.failed(error))
        };
        let networks = kept.networks.into_iter().map(network).collect::<Result<_>>()?;
        let Kept { channels, sizes, is_mean, ranges, errors, .. } = kept;
        let fitted = FittedPath { columns, channels, sizes, is_mean, networks, ranges, errors };
        Ok(Box::new(Arc::new(fitted)))
    }
}
