//! How much larger errors are outside of what the runs cover, seen by leaving corners of the inputs out.
//!
//! From each process all runs are left out that have both of two inputs beyond their median, in one of the four corners, and those at an end of a
//! single input (`granum_nets::gaussian_process::LeftOutBlocks`; parameters and components stay those of all runs). A run of the corner at the
//! distance D from the hull of the others ([`super::orthogonal_hull`]) then has the errors `e` over the half widths of its intervals. In one corner
//! intervals hold their share of the states outside the hull if they are
//!
//! ```text
//! 1 + c D
//! ```
//!
//! times as wide, with the quantile c of `(e - 1) / D` over these states. The growth is the c with which nine of ten corners hold theirs, and at
//! least 0.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use granum_core::observer::{Flow, Observer, Progress, SharedObserver};
use granum_core::parallel;
use granum_nets::gaussian_process::{GaussianProcess, ProcessPrediction, Rows};

use super::densities::Densities;
use super::failure::failed;
use super::kept_curve::KeptCurve;
use super::orthogonal_hull::OrthogonalHull;
use super::predicted_curve::{Curve, curves_of_outputs};
use super::prepared::Shared;
use crate::error::{LearnError, Result};

/// Most runs, evenly spread, from which corners are left out.
const MOST_RUNS: usize = 400;
/// Places of the inputs beyond which a run is in a corner or at an end.
const CORNER: f64 = 0.5;
const END: f64 = 0.25;
/// Fewest runs of a corner outside the hull, and fewest such corners, that tell anything.
const FEWEST_RUNS: usize = 5;
const FEWEST_CORNERS: usize = 10;
/// Share of the corners that should hold their share of states.
const SHARE_OF_CORNERS: f64 = 0.9;

/// A block of runs that are left out.
struct Corner {
    runs: Vec<usize>,
    /// The distance of each from the hull of the others.
    distances: Vec<f64>,
}

/// The runs left out of the processes in corners.
pub(super) struct Corners<'a> {
    /// The runs that are used, of all.
    used: Vec<usize>,
    corners: Vec<Corner>,
    shared: &'a Shared,
    curves: &'a [KeptCurve],
    histograms: &'a [Densities],
    outputs: usize,
    /// For each process, in the order of curves and components, and each corner its runs as predicted from others.
    left_out: Vec<Vec<Vec<ProcessPrediction>>>,
}

/// A run that was left out, with its predicted outputs.
pub(super) struct CornerRun {
    /// The number of its corner, and its own among all runs.
    pub corner: usize,
    pub run: usize,
    pub distance: f64,
    pub curves: Vec<Curve>,
}

impl<'a> Corners<'a> {
    /// Leaves corners out of the processes of curves. There are none without inputs.
    pub fn new(
        shared: &'a Shared,
        curves: &'a [KeptCurve],
        (histograms, outputs): (&'a [Densities], usize),
        threads: usize,
        observer: &mut dyn Observer,
    ) -> Result<Corners<'a>> {
        let rows = shared.rows.as_ref().ok_or_else(|| failed("there are no inputs"))?;
        let (count, kept) = (rows.count(), rows.count().min(MOST_RUNS));
        let used: Vec<usize> = (0..kept).map(|k| k * count / kept).collect();
        let inputs = rows.columns();
        let values: Vec<f64> = used.iter().flat_map(|run| rows.row(*run).iter().copied()).collect();
        let corners = corners(&values, inputs);
        let rows = Arc::new(Rows::new(values, inputs).map_err(failed)?);
        let processes: Vec<(&Vec<f64>, &Vec<f64>)> =
            curves.iter().flat_map(|curve| curve.weights.iter().zip(&curve.parameters)).collect();
        let (follower, done, total) = (SharedObserver::new(observer), AtomicUsize::new(0), processes.len());
        let left_out = parallel::map(total, threads, |k| {
            let complete = done.load(Ordering::Relaxed);
            let progress = Progress::new("corners", "processes", complete as u64).out_of(total as u64);
            if follower.part(format!("corners of process {}", k + 1)).progress(&progress) == Flow::Stop {
                return Err(LearnError::Stopped { done: complete, total });
            }
            let (weights, parameters) = processes[k];
            let targets: Vec<f64> = used.iter().map(|run| weights[*run]).collect();
            let process = GaussianProcess::with_parameters(rows.clone(), &targets, parameters.clone());
            let process = process.map_err(failed)?;
            let blocks = process.left_out_blocks();
            let left = |corner: &Corner| {
                let found = blocks.without(&targets, &corner.runs);
                found.ok_or_else(|| failed("the runs without a corner cannot be inverted"))
            };
            let left = corners.iter().map(left).collect::<Result<Vec<_>>>()?;
            done.fetch_add(1, Ordering::Relaxed);
            Ok(left)
        })?;
        Ok(Corners { used, corners, shared, curves, histograms, outputs, left_out })
    }

    /// The runs that are farther from the hull of the others than the limit, of corners that have a few of them.
    pub fn outside(&self, limit: f64, threads: usize) -> Result<Vec<CornerRun>> {
        let mut outside: Vec<(usize, usize, f64)> = Vec::new();
        for (corner, own) in self.corners.iter().enumerate() {
            let all = own.distances.iter().enumerate().map(|(place, distance)| (corner, place, *distance));
            let far: Vec<_> = all.filter(|(.., distance)| *distance > limit).collect();
            if far.len() >= FEWEST_RUNS {
                outside.extend(far);
            }
        }
        parallel::map(outside.len(), threads, |k| {
            let (corner, place, distance) = outside[k];
            let mut left = self.left_out.iter().map(|corners| corners[corner][place]);
            let run = self.used[self.corners[corner].runs[place]];
            let curve = |kept: &KeptCurve| {
                let weights: Vec<_> = kept.components.iter().zip(left.by_ref()).collect();
                let mut curve = kept.output(Curve::new(kept.mean.clone(), kept.rest.clone(), &weights));
                self.shared.take_whole_start(&mut curve.mean, (kept.start, kept.memory), run);
                curve
            };
            let curves: Vec<Curve> = self.curves.iter().map(curve).collect();
            let curves = curves_of_outputs(curves, self.histograms, self.outputs);
            Ok(CornerRun { corner, run, distance, curves })
        })
    }
}

/// The corners of each pair of inputs, and the ends of each input.
fn corners(values: &[f64], inputs: usize) -> Vec<Corner> {
    let hull = OrthogonalHull::new(values, inputs);
    let places: Vec<Vec<f64>> = values.chunks(inputs).map(|row| hull.places(row)).collect();
    let mut corners = Vec::new();
    let mut add = |is_in: &dyn Fn(&[f64]) -> bool| {
        let (runs, others): (Vec<usize>, Vec<usize>) =
            (0..places.len()).partition(|run| is_in(&places[*run]));
        if runs.is_empty() || others.is_empty() {
            return;
        }
        let row = |run: usize| &values[run * inputs..(run + 1) * inputs];
        let known: Vec<f64> = others.iter().flat_map(|run| row(*run).iter().copied()).collect();
        let hull = OrthogonalHull::new(&known, inputs);
        let distances = runs.iter().map(|run| hull.distance(&hull.places(row(*run))).distance).collect();
        corners.push(Corner { runs, distances });
    };
    for e in 0..inputs {
        add(&|places| places[e] < END);
        add(&|places| places[e] > 1.0 - END);
        for d in 0..e {
            for [low, other_low] in [[true, true], [true, false], [false, true], [false, false]] {
                let beyond = |place: f64, low: bool| if low { place < CORNER } else { place > CORNER };
                add(&|places| beyond(places[d], low) && beyond(places[e], other_low));
            }
        }
    }
    corners
}

/// The growth with which most corners hold the share `level` of their states; 0 if there are too few corners. For each corner its states, see
/// [`growth_of_corner`].
pub(super) fn growth(corners: impl Iterator<Item = Vec<(f64, f64, f64)>>, level: f64) -> f64 {
    let mut needed: Vec<f64> = corners.map(|mut states| growth_of_corner(&mut states, level)).collect();
    if needed.len() < FEWEST_CORNERS {
        return 0.0;
    }
    needed.sort_by(f64::total_cmp);
    let rank = (SHARE_OF_CORNERS * (needed.len() + 1) as f64).ceil() as usize;
    needed[rank.clamp(1, needed.len()) - 1]
}

/// The growth with which the share `level` of the states holds: for each the error over the half width of its interval, the distance, and its
/// weight.
fn growth_of_corner(states: &mut [(f64, f64, f64)], level: f64) -> f64 {
    let needed = |(error, distance, _): &(f64, f64, f64)| (error - 1.0) / distance;
    states.sort_by(|a, b| needed(a).total_cmp(&needed(b)));
    let total: f64 = states.iter().map(|(.., weight)| weight).sum();
    let mut sum = 0.0;
    for state in states.iter() {
        sum += state.2;
        if sum >= level * total {
            return needed(state).max(0.0);
        }
    }
    0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_corner_has_the_runs_with_both_inputs_beyond_their_median() {
        let values: Vec<f64> =
            (0..10).flat_map(|i| (0..10).map(move |j| [f64::from(i), f64::from(j)])).flatten().collect();
        let corners = corners(&values, 2);
        // Two ends of each input, and four corners.
        assert_eq!(corners.len(), 8);
        assert_eq!(corners.iter().filter(|corner| corner.runs.len() == 25).count(), 4);
        let last = &corners[7];
        assert!(last.runs.iter().all(|run| run / 10 > 4 && run % 10 > 4), "{:?}", last.runs);
        let far = last.runs.iter().position(|run| *run == 99).unwrap();
        let near = last.runs.iter().position(|run| *run == 55).unwrap();
        assert!(last.distances[far] > 2.0 * last.distances[near] && last.distances[near] > 0.0);
    }

    #[test]
    fn growth_is_what_the_share_of_states_needs() {
        // Nine states of ten have an error of one and a half half widths at a distance of a quarter.
        let mut states = vec![(1.5, 0.25, 1.0); 9];
        states.push((100.0, 0.25, 1.0));
        assert_eq!(growth_of_corner(&mut states, 0.9), 2.0);
        assert_eq!(growth_of_corner(&mut [(0.5, 0.25, 1.0)], 0.9), 0.0);
        assert_eq!(growth_of_corner(&mut [], 0.9), 0.0);
        // Corners that need 0, 1, ..., 19: nine of ten hold with 18.
        let corner = |k: u32| vec![(1.0 + 0.5 * f64::from(k), 0.5, 1.0)];
        assert_eq!(growth((0..20).map(corner), 0.9), 18.0);
        assert_eq!(growth((0..5).map(corner), 0.9), 0.0);
    }
}
