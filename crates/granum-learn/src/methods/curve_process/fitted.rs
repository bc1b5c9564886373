//! Fitted processes of curves.

use std::sync::{Arc, Mutex, PoisonError};

use granum_core::parallel;
use granum_nets::gaussian_process::{GaussianProcess, ProcessPrediction, Rows};
use serde::{Deserialize, Serialize};

use super::calibration::Calibration;
use super::densities::Densities;
use super::failure::failed;
use super::groups::Group;
use super::kept_curve::KeptCurve;
use super::local_calibration::LocalFactor;
use super::orthogonal_hull::{HullDistance, OrthogonalHull};
use super::predicted_curve::{Curve, curves_needed, curves_of_outputs};
use super::reach::EndedEarly;
use super::run_curves::{RunCurve, shares};
use crate::curve::{increases, interpolated};
use crate::dataset::RunStates;
use crate::error::Result;
use crate::surrogate::possible_values::cut_to_possible;
use crate::surrogate::prediction::{Cause, Estimate, Prediction, UnseenCombination, outside_of};
use crate::surrogate::run_inputs::RunInputs;
use crate::surrogate::spec::Columns;
use crate::surrogate::surrogate_trait::Surrogate;

/// Fewest runs for intervals.
pub(super) const FEWEST_RUNS: usize = 3;
/// A run reaches the last point if it lacks no more than this part of the range.
const ALMOST: f64 = 0.005;

/// What is kept in a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Kept {
    /// Place of the coordinate among the inputs.
    pub coordinate: usize,
    /// Number of training runs.
    pub runs: usize,
    /// The points of the curves.
    pub points: Vec<f64>,
    /// What the processes see of the inputs beside the coordinate.
    pub groups: Vec<Group>,
    /// Range of each of these inputs.
    pub ranges: Vec<[f64; 2]>,
    /// The values of the groups of the training runs, in row-major order.
    pub rows: Vec<f64>,
    /// The histograms among the outputs.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub histograms: Vec<Densities>,
    /// The curves: one of each output, and in the place of the bins of a histogram those of its coefficients.
    pub curves: Vec<KeptCurve>,
    /// For each output.
    pub calibrations: Vec<Calibration>,
    /// For each output by what its intervals are wider at one place than at another; none in files of earlier versions.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub local: Vec<LocalFactor>,
    /// The distance from the hull of the training runs beyond which inputs are a combination that they do not have.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit: Option<f64>,
    /// Runs that were not used.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<EndedEarly>,
}

/// A predicted curve of a single run, with the correlation of its error along the curve.
#[derive(Clone, Debug, PartialEq)]
pub struct CorrelatedCurve {
    /// The mean at each value of the coordinate.
    pub mean: Vec<f64>,
    /// The covariance of a run about the mean, row-major.
    pub covariance: Vec<f64>,
}

/// Gaussian processes of curves, fitted to runs.
pub struct FittedCurves {
    pub(super) columns: Columns,
    pub(super) kept: Kept,
    /// For each curve the process of each component.
    pub(super) processes: Vec<Vec<GaussianProcess>>,
    /// Which combinations of inputs the training runs have, if intervals depend on it.
    pub(super) hull: Option<OrthogonalHull>,
    last: Mutex<Option<Arc<KnownCurves>>>,
}

/// What was computed last: rows of a run differ in the coordinate alone, also if they are asked for one after the other.
struct KnownCurves {
    /// The inputs beside the coordinate.
    inputs: Vec<f64>,
    curves: Vec<Curve>,
    /// Their places among the training runs, and the distance from these.
    at: Option<(Vec<f64>, HullDistance)>,
}

/// Where the inputs of a run are among those of the training runs.
struct Place {
    /// For each output the half width of its intervals there, in standard deviations.
    factors: Vec<f64>,
    combination: Option<UnseenCombination>,
}

impl FittedCurves {
    pub(super) fn new(columns: Columns, kept: Kept, threads: usize) -> Result<FittedCurves> {
        let bad = || failed("the content is not that of its columns");
        if !is_sound(&columns, &kept) {
            return Err(bad());
        }
        let mut processes: Vec<Vec<GaussianProcess>> = kept.curves.iter().map(|_| Vec::new()).collect();
        if !kept.groups.is_empty() {
            let rows = Arc::new(Rows::new(kept.rows.clone(), kept.groups.len()).map_err(failed)?);
            let parts: Vec<(usize, usize)> = (0..kept.curves.len())
                .flat_map(|curve| {
                    (0..kept.curves[curve].weights.len()).map(move |component| (curve, component))
                })
                .collect();
            let found = parallel::map(parts.len(), threads, |k| {
                let (curve, component) = parts[k];
                let KeptCurve { weights, parameters, .. } = &kept.curves[curve];
                GaussianProcess::with_parameters(
                    rows.clone(),
                    &weights[component],
                    parameters[component].clone(),
                )
            });
            for ((curve, _), process) in parts.iter().zip(found.map_err(failed)?) {
                processes[*curve].push(process);
            }
        }
        let hull = (!kept.groups.is_empty() && !kept.local.is_empty())
            .then(|| OrthogonalHull::new(&kept.rows, kept.groups.len()));
        Ok(FittedCurves { columns, kept, processes, hull, last: Mutex::new(None) })
    }

    /// Bands that should contain the share `level` of the whole curves of new runs, and not only of their states: for each state the
    /// prediction with the band at it as its interval.
    ///
    /// # Errors
    /// As [`Surrogate::predict`].
    pub fn bands(&self, inputs: &RunInputs, level: f64) -> Result<Vec<Prediction>> {
        // Checks the inputs and the level.
        self.predict(inputs, level)?;
        let bands = self.predictions(inputs, &|calibration| calibration.band(level));
        Ok(cut_to_possible(bands, |output| self.possible_values(output)))
    }

    /// The points of the coordinate at which curves are learned; between them they are straight.
    pub fn points(&self) -> &[f64] {
        &self.kept.points
    }

    /// The part of the coordinate that each point stands for; the sum is 1.
    pub fn shares(&self) -> Vec<f64> {
        shares(&self.kept.points)
    }

    /// The curves of a run at the points, one for each output, as they are learned; `None` if the run ends before the last point.
    ///
    /// # Errors
    /// If the run lacks a column, or the coordinate turns in it.
    pub fn measured(&self, run: &RunStates) -> Result<Option<Vec<Vec<f64>>>> {
        let coordinate = &self.columns.inputs[self.kept.coordinate].name;
        let curve = RunCurve::new(run, coordinate, &[], &self.columns.output_names())?;
        let points = &self.kept.points;
        let last = points[points.len() - 1];
        if curve.xs[curve.xs.len() - 1] < last - ALMOST * (last - points[0]) {
            return Ok(None);
        }
        Ok(Some((0..self.columns.outputs.len()).map(|output| curve.at(points, output, None)).collect()))
    }

    /// The number of runs to which it was fitted.
    pub fn runs(&self) -> usize {
        self.kept.runs
    }

    /// The runs that were not used because their curves end well before those of the others.
    pub fn left_out(&self) -> &[EndedEarly] {
        &self.kept.left_out
    }

    /// The range of each input over the runs, in the order of the columns.
    pub fn ranges(&self) -> Vec<[f64; 2]> {
        let Kept { coordinate, points, ranges, .. } = &self.kept;
        let mut ranges = ranges.clone();
        ranges.insert(*coordinate, [points[0], points[points.len() - 1]]);
        ranges
    }

    /// An output of a run at increasing values of the coordinate, from the inputs beside the coordinate in their order: the mean, and the
    /// covariance of a run about it, `f^2 (sum_j s_j^2 v_j(a) v_j(b) + r(a) [a = b])` with the variance `s_j^2` of the weight of each
    /// component `v_j`, the variance r that the components do not contain, and the factor f by which intervals of one standard deviation that are
    /// equal everywhere were calibrated on training runs left out. For an output that is learned by its square root this is the covariance `C` of
    /// the root, with the mean `m`, and that of the output is `C (4 m(a) m(b) + 2 C)`.
    ///
    /// # Errors
    /// If there is no such output, it is a bin of a histogram, whose values are not normal, or there are other inputs.
    pub fn correlated_curve(&self, inputs: &[f64], output: usize, at: &[f64]) -> Result<CorrelatedCurve> {
        self.joint(inputs, &[(output, at)], None)
    }

    /// What the processes see of the inputs beside the coordinate.
    pub(super) fn row(&self, inputs: &[f64]) -> Result<Vec<f64>> {
        if inputs.len() + 1 != self.columns.inputs.len() || inputs.iter().any(|value| !value.is_finite()) {
            return Err(failed("a curve needs a finite value of every input beside the coordinate"));
        }
        Ok(self.kept.groups.iter().map(|group| group.value(inputs)).collect())
    }

    /// An output whose error is normal, and the factor by which its standard deviations were calibrated.
    pub(super) fn normal_output(&self, output: usize) -> Result<(&KeptCurve, f64)> {
        let Kept { calibrations, histograms, curves, local, .. } = &self.kept;
        match (curves.get(output), calibrations.get(output), histograms.is_empty()) {
            (Some(kept), Some(calibration), true) => {
                let plain = local.get(output).map(LocalFactor::deviation);
                Ok((kept, plain.unwrap_or_else(|| calibration.one_deviation())))
            }
            _ => Err(failed("there is no such output whose error has a covariance")),
        }
    }

    /// The root mean square error of an output over the training runs, each predicted by what was fitted to others; `None` if it is not
    /// known, as for files of earlier versions.
    pub fn left_out_error(&self, output: usize) -> Option<f64> {
        self.kept.calibrations.get(output)?.root_mean_square()
    }

    pub(super) fn predictions(
        &self,
        inputs: &RunInputs,
        factor: &dyn Fn(&Calibration) -> f64,
    ) -> Vec<Prediction> {
        let Kept { coordinate, runs, points, calibrations, .. } = &self.kept;
        let factors: Vec<f64> = calibrations.iter().map(factor).collect();
        let all_ranges = self.ranges();
        let mut known: Option<(Arc<KnownCurves>, Place)> = None;
        let mut predictions = Vec::with_capacity(inputs.len());
        for row in inputs.rows() {
            let x = row[*coordinate];
            let own = self.beside_coordinate(row);
            // The rows of a run differ in the coordinate alone.
            let (run, place) = match known.take() {
                Some(same) if same.0.inputs == own => known.insert(same),
                _ => {
                    let run = self.known(own);
                    let place = self.place(&run, &factors);
                    known.insert((run, place))
                }
            };
            let at = |values: &[f64]| interpolated(x, points, values);
            let estimate = |(curve, factor): (&Curve, &f64)| {
                let mean = Estimate::new(at(&curve.mean));
                // One or two runs say nothing of their scatter.
                if *runs < FEWEST_RUNS {
                    return mean;
                }
                let causes = vec![
                    (Cause::Noise, at(&curve.noise).sqrt()),
                    (Cause::Parameters, at(&curve.parameters).sqrt()),
                ];
                mean.by(causes, *factor)
            };
            let estimates = run.curves.iter().zip(&place.factors).map(estimate).collect();
            let outside = outside_of(&self.columns, &all_ranges, row);
            // An input that is outside of its own range is named already.
            let combination = place.combination.clone().filter(|_| outside.is_empty());
            predictions.push(Prediction::new(estimates).with_outside(outside).with_combination(combination));
        }
        predictions
    }

    /// The curves for the inputs beside the coordinate: those that were computed last, or else others, which are kept in their place. The same inputs have the same bits.
    fn known(&self, inputs: Vec<f64>) -> Arc<KnownCurves> {
        let last = || self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(same) = last().as_ref().filter(|known| known.inputs == inputs) {
            return Arc::clone(same);
        }
        let at = self.hull.as_ref().map(|hull| {
            let row: Vec<f64> = self.kept.groups.iter().map(|group| group.value(&inputs)).collect();
            let places = hull.places(&row);
            let distance = hull.distance(&places);
            (places, distance)
        });
        let found = Arc::new(KnownCurves { curves: self.curves(&inputs), at, inputs });
        *last() = Some(Arc::clone(&found));
        found
    }

    /// Where inputs are; `factors` are those of intervals that are equal everywhere.
    fn place(&self, run: &KnownCurves, factors: &[f64]) -> Place {
        let Some((places, HullDistance { distance, pair })) = &run.at else {
            return Place { factors: factors.to_vec(), combination: None };
        };
        let input = |group: usize| {
            let input = self.kept.groups[group].input();
            // The coordinate is one of the columns.
            let column = &self.columns.inputs[input + usize::from(input >= self.kept.coordinate)];
            (column.name.clone(), run.inputs[input])
        };
        let is_unseen = self.kept.limit.is_some_and(|limit| *distance > limit) && pair[0] != pair[1];
        let factor = |(own, all): (&LocalFactor, &f64)| all * own.at(places, *distance);
        Place {
            factors: self.kept.local.iter().zip(factors).map(factor).collect(),
            combination: is_unseen.then(|| UnseenCombination { inputs: pair.map(input) }),
        }
    }

    /// The curves of all outputs for the inputs beside the coordinate.
    fn curves(&self, inputs: &[f64]) -> Vec<Curve> {
        self.curves_by(inputs, |_, process, row| process.predict(row))
    }

    /// The same for whom the means are enough. The variance of a weight is zero where no mean depends on it.
    pub(super) fn curves_of_means(&self, inputs: &[f64]) -> Vec<Curve> {
        self.curves_by(inputs, |kept, process, row| match kept.root {
            true => process.predict(row),
            false => process.predict_mean(row),
        })
    }

    fn curves_by(
        &self,
        inputs: &[f64],
        predict: impl Fn(&KeptCurve, &GaussianProcess, &[f64]) -> ProcessPrediction,
    ) -> Vec<Curve> {
        let row: Vec<f64> = self.kept.groups.iter().map(|group| group.value(inputs)).collect();
        let curve = |(kept, processes): (&KeptCurve, &Vec<GaussianProcess>)| {
            let points = &self.kept.points;
            let from_start = points.iter().map(|x| kept.start_at(inputs, x - points[0]));
            let each = kept.components.iter().zip(processes);
            let weights: Vec<_> =
                each.map(|(component, process)| (component, predict(kept, process, &row))).collect();
            let mean = from_start.zip(&kept.mean).map(|(start, mean)| start + mean).collect();
            kept.output(Curve::new(mean, kept.rest.clone(), &weights))
        };
        let curves = self.kept.curves.iter().zip(&self.processes).map(curve);
        curves_of_outputs(curves, &self.kept.histograms, self.columns.outputs.len())
    }

    /// The inputs of a row beside the coordinate.
    pub(super) fn beside_coordinate(&self, row: &[f64]) -> Vec<f64> {
        let mut own = row.to_vec();
        own.remove(self.kept.coordinate);
        own
    }
}

fn is_sound(columns: &Columns, kept: &Kept) -> bool {
    let (inputs, points) = (columns.inputs.len(), kept.points.len());
    let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
    let is_curve = |values: &Vec<f64>| values.len() == points && finite(values);
    let (groups, runs) = (kept.groups.len(), kept.runs);
    let outputs = columns.outputs.len();
    let curve = |curve: &KeptCurve| {
        curve.start.is_none_or(|start| start + 1 < inputs)
            && curve.memory.is_none_or(|memory| memory.is_sound())
            && is_curve(&curve.mean)
            && is_curve(&curve.rest)
            && curve.rest.iter().all(|variance| *variance >= 0.0)
            && curve.components.iter().all(is_curve)
            && (groups > 0 || curve.components.is_empty())
            && curve.weights.len() == curve.components.len()
            && curve.parameters.len() == curve.components.len()
            && curve.weights.iter().all(|weights| weights.len() == runs)
    };
    let firsts: Vec<usize> = kept.histograms.iter().map(|densities| densities.first).collect();
    let ends: Vec<usize> =
        kept.histograms.iter().map(|densities| densities.first + densities.bins()).collect();
    kept.coordinate < inputs
        && points > 1
        && increases(&kept.points)
        && finite(&kept.points)
        && runs > 0
        && kept.rows.len() == runs * groups
        && kept.groups.iter().all(|group| group.is_sound(inputs - 1))
        && kept.ranges.len() + 1 == inputs
        && kept.histograms.iter().all(|densities| densities.is_sound(outputs))
        && ends.iter().zip(firsts.iter().skip(1)).all(|(end, first)| end <= first)
        && kept.curves.len() == curves_needed(&kept.histograms, outputs)
        && kept.curves.iter().all(curve)
        && kept.calibrations.len() == outputs
        && kept.calibrations.iter().all(Calibration::is_sound)
        && (kept.local.is_empty() || kept.local.len() == outputs)
        && kept.local.iter().all(|local| local.is_sound(groups))
}
