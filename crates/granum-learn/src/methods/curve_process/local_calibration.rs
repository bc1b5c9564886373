//! Intervals that hold in each part of the inputs, and grow outside of what the runs cover.
//!
//! The half width of an interval is the standard deviation times
//!
//! ```text
//! q s(u) (1 + c D)
//! ```
//!
//! with the size s of errors at the inputs ([`super::error_size`]), the growth c with the distance D from the hull of the runs ([`super::corners`],
//! [`super::orthogonal_hull`]), and the factor q of the conformal calibration ([`super::calibration`]) of the errors of training runs over all the
//! rest, where s is fitted without the run and D is its distance from the hull of the others. The bins of a histogram share s and c.

use std::collections::BTreeMap;

use granum_core::observer::Observer;
use serde::{Deserialize, Serialize};

use super::calibration::Calibration;
use super::corners::{CornerRun, Corners, growth};
use super::densities::Densities;
use super::error_size::ErrorSize;
use super::kept_curve::KeptCurve;
use super::orthogonal_hull::OrthogonalHull;
use super::predicted_curve::Curve;
use super::prepared::Shared;
use crate::error::{LearnError, Result};
use crate::onnx::{OnnxGraph, Value};

/// The level of the intervals for which the growth is found.
const LEVEL: f64 = 0.9;

/// By what intervals of an output are wider at one place than at another.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LocalFactor {
    /// The factor of intervals of one standard deviation that are equal everywhere.
    deviation: f64,
    size: ErrorSize,
    growth: f64,
}

impl LocalFactor {
    /// The factor at the places of the inputs, so far from the hull.
    pub fn at(&self, places: &[f64], distance: f64) -> f64 {
        self.size.at(places) * (1.0 + self.growth * distance)
    }

    /// The factor in a graph, for places in rows and a column of distances.
    pub fn onnx(&self, graph: &mut OnnxGraph, places: &Value, distance: &Value) -> Value {
        let [growth, one] = [self.growth, 1.0].map(|value| graph.number(value));
        let grown = graph.apply("Mul", &[distance, &growth]);
        let grown = graph.apply("Add", &[&grown, &one]);
        match self.size.onnx(graph, places) {
            Some(size) => graph.apply("Mul", &[&size, &grown]),
            None => grown,
        }
    }

    /// The factor of intervals of one standard deviation that are equal everywhere.
    pub fn deviation(&self) -> f64 {
        self.deviation
    }

    /// The growth of intervals with the distance from the hull of the runs.
    #[cfg(test)]
    pub fn growth(&self) -> f64 {
        self.growth
    }

    /// True if it can be that of so many inputs.
    pub fn is_sound(&self, inputs: usize) -> bool {
        let positive = |value: f64| value >= 0.0 && value.is_finite();
        self.size.is_sound(inputs) && positive(self.growth) && positive(self.deviation)
    }
}

/// Most rounds in which the factor of the calibration and the growth are found by turns.
const ROUNDS: usize = 20;
/// A growth has settled if it changes by less than this part of one and itself.
const SETTLED: f64 = 1e-3;

/// The factor of the calibration is at least this share of what it is without growth: of few runs nearly all lie at the edge, and little is known
/// of the intervals in their midst.
const LEAST_FACTOR: f64 = 0.5;

/// The size of errors at each training run by a fit to the others, and its distance from their hull.
struct RunsLeftOut<'a> {
    sizes: &'a [f64],
    distances: &'a [f64],
}

/// The training runs as they were measured, and as they are predicted by what was fitted to others.
pub(super) struct LeftOutRuns<'a> {
    /// For each output the curve of each run, from its start.
    pub measured: &'a [Vec<Vec<f64>>],
    /// For each run the curve of each output.
    pub predicted: &'a [Vec<Curve>],
    /// What was fitted.
    pub shared: &'a Shared,
}

/// The calibrations of all outputs.
pub(super) struct Calibrated {
    pub calibrations: Vec<Calibration>,
    /// None if there are no inputs.
    pub local: Vec<LocalFactor>,
    /// The distance beyond which inputs are outside the hull.
    pub limit: Option<f64>,
}

impl LeftOutRuns<'_> {
    /// Where all curves start at the value on their sample, nothing is predicted.
    fn first(&self, output: usize) -> usize {
        usize::from(self.measured[output].iter().all(|curve| curve[0] == 0.0))
    }

    /// For each run its errors over their standard deviations.
    fn errors(&self, output: usize) -> Vec<Vec<f64>> {
        let errors = |(run, measured): (&Vec<Curve>, &Vec<f64>)| -> Vec<f64> {
            (self.first(output)..measured.len()).map(|k| run[output].error(k, measured[k])).collect()
        };
        self.predicted.iter().zip(&self.measured[output]).map(errors).collect()
    }

    /// The calibration of an output whose errors are equally large everywhere.
    fn plain(&self, output: usize) -> Calibration {
        Calibration::new(&self.errors(output), &self.shared.shares[self.first(output)..])
            .with_root_mean_square(self.root_mean_square(output))
    }

    fn root_mean_square(&self, output: usize) -> f64 {
        let square = |(run, measured): (&Vec<Curve>, &Vec<f64>)| -> f64 {
            let apart = measured.iter().zip(&run[output].mean).zip(&self.shared.shares);
            apart.map(|((measured, mean), share)| share * (measured - mean) * (measured - mean)).sum()
        };
        let squares: f64 = self.predicted.iter().zip(&self.measured[output]).map(square).sum();
        (squares / self.predicted.len() as f64).sqrt()
    }

    /// The root mean square of the errors of each run over outputs and points.
    fn of_runs(&self, outputs: &[usize]) -> Vec<f64> {
        let mut squares = vec![0.0; self.predicted.len()];
        for output in outputs {
            let shares = &self.shared.shares[self.first(*output)..];
            let total: f64 = shares.iter().sum();
            for (square, errors) in squares.iter_mut().zip(self.errors(*output)) {
                *square += errors.iter().zip(shares).map(|(e, share)| share * e * e).sum::<f64>() / total;
            }
        }
        squares.iter().map(|square| (square / outputs.len() as f64).sqrt()).collect()
    }

    /// The calibrations.
    ///
    /// # Errors
    /// If the observer asks to stop.
    pub fn calibrated(
        &self,
        curves: &[KeptCurve],
        histograms: &[Densities],
        threads: usize,
        observer: &mut dyn Observer,
    ) -> Result<Calibrated> {
        let outputs = self.measured.len();
        let plain: Vec<Calibration> = (0..outputs).map(|output| self.plain(output)).collect();
        let Some(rows) = self.shared.rows.as_ref().filter(|rows| rows.count() == self.predicted.len()) else {
            return Ok(Calibrated { calibrations: plain, local: Vec::new(), limit: None });
        };
        let hull = OrthogonalHull::new(rows.values(), rows.columns());
        let (limit, distances) = (hull.limit(), hull.distances());
        let places: Vec<Vec<f64>> =
            rows.values().chunks(rows.columns()).map(|row| hull.places(row)).collect();
        let corners = Corners::new(self.shared, curves, (histograms, outputs), threads, observer);
        let outside = match corners.and_then(|corners| corners.outside(limit, threads)) {
            Err(stopped @ LearnError::Stopped { .. }) => return Err(stopped),
            // What cannot be inverted without a corner says nothing of it.
            found => found.unwrap_or_default(),
        };
        let mut calibrations: Vec<Option<Calibration>> = vec![None; outputs];
        let mut local: Vec<Option<LocalFactor>> = vec![None; outputs];
        for unit in units(histograms, outputs) {
            let fitted = ErrorSize::fit(&places, &self.of_runs(&unit));
            let sizes: Vec<f64> = places.iter().map(|places| fitted.size.at(places)).collect();
            let left_out = RunsLeftOut { sizes: &fitted.left_out, distances: &distances };
            let (growth, own) = self.growth_and_calibrations(&unit, &left_out, &sizes, &outside);
            for (output, own) in unit.into_iter().zip(own) {
                calibrations[output] = Some(own.with_six_digits());
                let deviation = plain[output].one_deviation();
                local[output] = Some(LocalFactor { deviation, size: fitted.size.clone(), growth });
            }
        }
        Ok(Calibrated {
            calibrations: calibrations.into_iter().flatten().collect(),
            local: local.into_iter().flatten().collect(),
            limit: Some(limit),
        })
    }

    /// The growth of outputs that are calibrated together, and the calibration of each. The factors of the calibration decide which growth the corners
    /// need, and the growth what the factors must be for the training runs, which lie outside of the hull of the others as often as new runs do.
    fn growth_and_calibrations(
        &self,
        unit: &[usize],
        left_out: &RunsLeftOut,
        sizes: &[f64],
        outside: &[CornerRun],
    ) -> (f64, Vec<Calibration>) {
        let with = |growth: f64| -> Vec<Calibration> {
            unit.iter().map(|output| self.calibration(*output, left_out, growth)).collect()
        };
        let (mut own, mut growth) = (with(0.0), 0.0);
        let least: Vec<f64> = own.iter().map(|own| LEAST_FACTOR * own.interval(LEVEL)).collect();
        let mut first = None;
        for _ in 0..ROUNDS {
            let next = self.growth(unit, &own, sizes, outside);
            if (next - growth).abs() <= SETTLED * (1.0 + growth) {
                return (growth, own);
            }
            first.get_or_insert((next, own));
            (own, growth) = (with(next), next);
            if own.iter().zip(&least).any(|(own, least)| own.interval(LEVEL) < *least) {
                break;
            }
        }
        // Where corners need ever more, intervals are rather too wide near the runs than too narrow.
        first.unwrap_or((growth, own))
    }

    /// The calibration of an output whose intervals grow so with the distance from the hull.
    fn calibration(&self, output: usize, left_out: &RunsLeftOut, growth: f64) -> Calibration {
        let widths = left_out.sizes.iter().zip(left_out.distances).map(|(s, d)| s * (1.0 + growth * d));
        let scaled = |(errors, width): (Vec<f64>, f64)| errors.iter().map(|e| e / width).collect();
        let errors: Vec<Vec<f64>> = self.errors(output).into_iter().zip(widths).map(scaled).collect();
        Calibration::new(&errors, &self.shared.shares[self.first(output)..])
            .with_root_mean_square(self.root_mean_square(output))
    }

    fn growth(
        &self,
        unit: &[usize],
        calibrations: &[Calibration],
        sizes: &[f64],
        outside: &[CornerRun],
    ) -> f64 {
        let mut corners: BTreeMap<usize, Vec<(f64, f64, f64)>> = BTreeMap::new();
        for (output, own) in unit.iter().zip(calibrations) {
            let factor = own.interval(LEVEL);
            for run in outside {
                let measured = &self.measured[*output][run.run];
                let states = corners.entry(run.corner).or_default();
                for k in self.first(*output)..measured.len() {
                    let error = run.curves[*output].error(k, measured[k]).abs();
                    states.push((
                        error / (factor * sizes[run.run]).max(1e-300),
                        run.distance,
                        self.shared.shares[k],
                    ));
                }
            }
        }
        growth(corners.into_values(), LEVEL)
    }
}

/// The outputs that are calibrated together: each alone, and all bins of a histogram.
fn units(histograms: &[Densities], outputs: usize) -> Vec<Vec<usize>> {
    let mut units = Vec::new();
    let mut next = 0;
    while next < outputs {
        let bins = histograms.iter().find(|densities| densities.first == next).map_or(1, Densities::bins);
        units.push((next..next + bins).collect());
        next += bins;
    }
    units
}
