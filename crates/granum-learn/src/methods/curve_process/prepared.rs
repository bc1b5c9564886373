//! What is fitted: the curves of the training runs, before any process is.

use std::sync::Arc;

use granum_nets::gaussian_process::Rows;

use super::components::Components;
use super::densities::{Densities, histograms_among};
use super::predicted_curve::Curve;
use super::root::{needs_root, squared};
use super::run_curves::RunCurve;
use super::start_memory::StartMemory;
use crate::dataset::{ColumnGroup, Dataset};

/// What the fits of all outputs share.
pub(super) struct Shared {
    pub runs: Vec<RunCurve>,
    pub points: Vec<f64>,
    pub shares: Vec<f64>,
    pub rows: Option<Arc<Rows>>,
    /// Most components of an output.
    pub most: usize,
    /// Whether components are turned until they are independent.
    pub independent: bool,
}

/// An output, or a coefficient of a histogram, before its processes are fitted.
pub(super) struct Prepared {
    /// Which output it is; `None` for a coefficient of a histogram.
    pub output: Option<usize>,
    /// The input that is its value on the sample.
    pub start: Option<usize>,
    /// How long it remembers that value; without it always.
    pub memory: Option<StartMemory>,
    /// The curves are square roots of the output.
    pub root: bool,
    /// What is left of the curves of the runs without their starts.
    pub curves: Vec<Vec<f64>>,
    pub components: Components,
}

impl Shared {
    /// The curves that are fitted: of each output, and in the place of the bins of a histogram of its coefficients.
    pub fn prepared(&self, starts: &[Option<usize>], histograms: &[Densities]) -> Vec<Prepared> {
        let (mut prepared, mut output) = (Vec::new(), 0);
        while output < starts.len() {
            let Some(densities) = histograms.iter().find(|densities| densities.first == output) else {
                prepared.push(self.output(output, starts[output]));
                output += 1;
                continue;
            };
            let coefficients = |run: &RunCurve| -> Vec<Vec<f64>> {
                let states = self.states(run, output, densities.bins());
                states.iter().map(|state| densities.coefficients(state)).collect()
            };
            let of_runs: Vec<Vec<Vec<f64>>> = self.runs.iter().map(coefficients).collect();
            for k in 0..densities.directions.len() {
                let curve = |states: &Vec<Vec<f64>>| states.iter().map(|state| state[k]).collect();
                prepared.push(self.curves(None, None, of_runs.iter().map(curve).collect()));
            }
            output += densities.bins();
        }
        prepared
    }

    /// An output, of which its value on the sample is taken off if `start` names an input that is.
    fn output(&self, output: usize, start: Option<usize>) -> Prepared {
        let curve = |run: &RunCurve| run.at(&self.points, output, start);
        Prepared { output: Some(output), ..self.curves(start, None, self.runs.iter().map(curve).collect()) }
    }

    /// The same output with a short memory of its start; `None` if its start is not known.
    pub fn forgetting(&self, prepared: &Prepared) -> Option<Prepared> {
        let starts = self.starts(prepared.start?);
        let memory = StartMemory::short(&starts, &self.points);
        let forgotten = |(curve, start): (&Vec<f64>, &f64)| {
            let each = curve.iter().zip(&self.points);
            each.map(|(value, x)| value + start - memory.value(*start, x - self.points[0])).collect()
        };
        let curves = prepared.curves.iter().zip(&starts).map(forgotten).collect();
        Some(Prepared { output: prepared.output, ..self.curves(prepared.start, Some(memory), curves) })
    }

    /// The same output by its square root; `None` if it does not need one.
    pub fn rooted(&self, prepared: &Prepared) -> Option<Prepared> {
        // The difference from a start, and a coefficient of a histogram, can be negative.
        if prepared.start.is_some() || prepared.output.is_none() || !needs_root(&prepared.curves) {
            return None;
        }
        let root = |curve: &Vec<f64>| curve.iter().map(|value| value.sqrt()).collect();
        let curves = self.curves(None, None, prepared.curves.iter().map(root).collect());
        Some(Prepared { output: prepared.output, root: true, ..curves })
    }

    fn curves(&self, start: Option<usize>, memory: Option<StartMemory>, curves: Vec<Vec<f64>>) -> Prepared {
        let components = Components::new(&curves, &self.shares, self.most);
        let components = if self.independent { components.independent() } else { components };
        Prepared { output: None, start, memory, root: false, curves, components }
    }

    fn starts(&self, input: usize) -> Vec<f64> {
        self.runs.iter().map(|run| run.inputs[input]).collect()
    }

    /// Predicted outputs of the runs, less the whole starts of these.
    pub fn outputs(&self, prepared: &Prepared, mut curves: Vec<Curve>) -> Vec<Curve> {
        if prepared.root {
            return curves.into_iter().map(squared).collect();
        }
        for (run, curve) in curves.iter_mut().enumerate() {
            self.take_whole_start(&mut curve.mean, (prepared.start, prepared.memory), run);
        }
        curves
    }

    /// What a run predicts less its whole start, from what it predicts less what is remembered of it.
    pub fn take_whole_start(
        &self,
        mean: &mut [f64],
        (input, memory): (Option<usize>, Option<StartMemory>),
        run: usize,
    ) {
        let (Some(input), Some(memory)) = (input, memory) else { return };
        let start = self.runs[run].inputs[input];
        for (mean, x) in mean.iter_mut().zip(&self.points) {
            *mean += memory.value(start, x - self.points[0]) - start;
        }
    }

    /// The curves of the runs from their starts; none for a coefficient of a histogram.
    pub fn measured_of(&self, prepared: &Prepared) -> Vec<Vec<f64>> {
        let of_run = |output: usize| move |run: &RunCurve| run.at(&self.points, output, prepared.start);
        prepared.output.map_or(Vec::new(), |output| self.runs.iter().map(of_run(output)).collect())
    }

    /// For each output the curves of the runs, from their starts.
    pub fn measured(&self, starts: &[Option<usize>]) -> Vec<Vec<Vec<f64>>> {
        let of_output = |(output, start): (usize, &Option<usize>)| {
            self.runs.iter().map(|run| run.at(&self.points, output, *start)).collect()
        };
        starts.iter().enumerate().map(of_output).collect()
    }

    /// The histograms of which all bins are outputs.
    pub fn histograms(&self, dataset: &Dataset, outputs: &[String]) -> Vec<Densities> {
        let Some(first) = dataset.runs().first() else { return Vec::new() };
        let histogram = |(output, group): (usize, &ColumnGroup)| {
            let of_run = |run: &RunCurve| self.states(run, output, group.centres.len());
            let states: Vec<Vec<f64>> = self.runs.iter().flat_map(of_run).collect();
            Densities::new(group, output, &states, &self.shares.repeat(self.runs.len()))
        };
        histograms_among(first, outputs).into_iter().map(histogram).collect()
    }

    /// The densities of the bins at each point.
    pub fn states(&self, run: &RunCurve, first: usize, bins: usize) -> Vec<Vec<f64>> {
        let curves: Vec<Vec<f64>> =
            (first..first + bins).map(|output| run.at(&self.points, output, None)).collect();
        (0..self.points.len()).map(|k| curves.iter().map(|curve| curve[k]).collect()).collect()
    }
}
