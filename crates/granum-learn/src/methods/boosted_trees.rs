//! Boosted regression trees over the states of runs: a baseline for tables of any columns, which needs no smoothness, finds
//! interactions of inputs by itself, and ignores inputs without use. [`crate::regression::boosting`] has the formulas.
//!
//! The runs are divided into five parts. For each part trees are grown on the other runs, until its error has not fallen for fifty trees; the
//! number of trees is the one with the least error over all parts, and as many are then grown on all runs. The errors on left-out runs give
//! the intervals.

use std::sync::atomic::{AtomicUsize, Ordering};

use granum_core::observer::{Flow, Observer, Progress, SharedObserver};
use granum_core::parallel;
use serde::{Deserialize, Serialize};

use super::left_out_errors::LeftOutErrors;
use crate::curve::range;
use crate::dataset::Dataset;
use crate::error::{LearnError, Result};
use crate::onnx::{self, OnnxAnswer, OnnxGraph, Value};
use crate::regression::boosting::{Bins, Growth, Tree};
use crate::surrogate::content::Content;
use crate::surrogate::prediction::{Prediction, outside_of};
use crate::surrogate::run_inputs::RunInputs;
use crate::surrogate::spec::{Columns, FitSpec};
use crate::surrogate::surrogate_trait::{Surrogate, SurrogateMethod};

/// Number of parts of the runs.
const PARTS: usize = 5;
/// Number of trees after which a growth ends that has not reduced the error on left-out runs.
const PATIENCE: usize = 50;

/// Boosted regression trees with the settings of their growth.
///
/// ```
/// use granum_core::observer::NoObserver;
/// use granum_core::{Column, Table};
/// use granum_learn::surrogate::{BoostedTrees, FitSpec, SurrogateMethod};
/// use granum_learn::{Dataset, RunStates};
///
/// // Six runs of a step whose height is a parameter.
/// let run = |k: u32| {
///     let x: Vec<f64> = (0..60).map(|i| f64::from(i) / 59.0).collect();
///     let y = x.iter().map(|x| if *x > 0.5 { f64::from(k % 3) } else { 0.0 }).collect();
///     let table = Table::new(vec![Column::new("x", "", x), Column::new("y", "", y)])?;
///     RunStates::new(&format!("run-{k}"), table)?.with_parameter("height", "", f64::from(k % 3))
/// };
/// let dataset = Dataset::new((0..6).map(run).collect::<granum_learn::Result<_>>()?)?;
/// let spec = FitSpec::new(["x", "height"], ["y"]).with_coordinate("x");
/// let fitted = BoostedTrees::default().fit(&dataset, &spec, &mut NoObserver)?;
/// let predicted = fitted.predict_rows(&[0.8, 2.0, 0.2, 2.0], 0.9)?;
/// assert!((predicted[0].values[0].mean - 2.0).abs() < 0.1 && predicted[1].values[0].mean.abs() < 0.1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BoostedTrees {
    /// Most questions from the root of a tree to a leaf (5).
    pub depth: usize,
    /// Most trees (500).
    pub trees: usize,
    /// Fewest states in a leaf (10).
    pub least_states: usize,
    /// Factor with which each tree enters (0.1).
    pub rate: f64,
}

impl Default for BoostedTrees {
    fn default() -> Self {
        BoostedTrees { depth: 5, trees: 500, least_states: 10, rate: 0.1 }
    }
}

const NAME: &str = "boosted-trees";

fn failed(reason: impl Into<String>) -> LearnError {
    LearnError::Surrogate { method: NAME.into(), reason: reason.into() }
}

/// What is kept in a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Fitted {
    /// Place of the coordinate among the inputs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    coordinate: Option<usize>,
    /// Range of each input over the training states.
    ranges: Vec<[f64; 2]>,
    outputs: Vec<Output>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Output {
    /// Mean of the training states.
    mean: f64,
    trees: Vec<Tree>,
    errors: LeftOutErrors,
}

impl Output {
    fn at(&self, row: &[f64]) -> f64 {
        self.mean + self.trees.iter().map(|tree| tree.at(row)).sum::<f64>()
    }
}

impl Fitted {
    fn check(&self, columns: &Columns) -> Result<()> {
        let inputs = columns.inputs.len();
        let output = |output: &Output| {
            output.mean.is_finite()
                && output.trees.iter().all(|tree| tree.is_sound(inputs))
                && output.errors.is_sound()
        };
        let sound = self.coordinate.is_none_or(|place| place < inputs)
            && self.ranges.len() == inputs
            && self.outputs.len() == columns.outputs.len()
            && self.outputs.iter().all(output);
        if sound { Ok(()) } else { Err(failed("its trees are not those of its columns")) }
    }
}

/// The states that are learned from.
struct Rows {
    /// Inputs in row-major order.
    inputs: Vec<f64>,
    width: usize,
    bins: Bins,
    /// The run of each row.
    runs: Vec<usize>,
    /// The coordinate of each row; zeros without one.
    along: Vec<f64>,
}

impl Rows {
    fn row(&self, row: usize) -> &[f64] {
        &self.inputs[row * self.width..(row + 1) * self.width]
    }
}

/// What the runs of a part say of trees that were grown on the other runs.
struct Part {
    /// The rows of the part.
    rows: Vec<usize>,
    /// For each number of trees, from none on, the sum of the squares of the errors.
    squares: Vec<f64>,
    mean: f64,
    trees: Vec<Tree>,
}

impl SurrogateMethod for BoostedTrees {
    fn name(&self) -> &str {
        NAME
    }

    fn help(&self) -> &str {
        "boosted regression trees over the states, without any assumption of smoothness"
    }

    fn fit(
        &self,
        dataset: &Dataset,
        spec: &FitSpec,
        observer: &mut dyn Observer,
    ) -> Result<Box<dyn Surrogate>> {
        if !(self.rate > 0.0 && self.rate <= 1.0) {
            return Err(failed(format!("the rate must be above 0 and at most 1, not {}", self.rate)));
        }
        let columns = spec.columns(dataset)?;
        let inputs = dataset.values(&columns.input_names())?;
        let width = columns.inputs.len();
        let coordinate = spec.place_of_coordinate(&columns);
        let along = inputs.chunks_exact(width).map(|row| coordinate.map_or(0.0, |place| row[place]));
        let rows = Rows {
            along: along.collect(),
            bins: Bins::new(&inputs, width),
            runs: dataset.run_of_rows(),
            width,
            inputs,
        };
        let targets: Vec<Vec<f64>> =
            columns.outputs.iter().map(|output| dataset.values(&[&output.name])).collect::<Result<_>>()?;
        let (follower, total) = (SharedObserver::new(observer), targets.len());
        let done = AtomicUsize::new(0);
        let count = dataset.runs().len();
        let outputs = parallel::map(total, spec.threads, |k| {
            let mut part = follower.part(columns.outputs[k].name.clone());
            let complete = done.load(Ordering::Relaxed);
            let progress = Progress::new("training", "outputs", complete as u64).out_of(total as u64);
            if part.progress(&progress) == Flow::Stop {
                return Err(LearnError::Stopped { done: complete, total });
            }
            let output = self.output(&rows, &targets[k], count);
            done.fetch_add(1, Ordering::Relaxed);
            part.completed();
            Ok(output)
        })?;
        let ends = |k: usize| range(rows.inputs.iter().skip(k).step_by(width).copied());
        let fitted = Fitted { coordinate, ranges: (0..width).map(ends).collect(), outputs };
        Ok(Box::new(FittedTrees { columns, fitted }))
    }

    fn load(&self, columns: Columns, content: &Content) -> Result<Box<dyn Surrogate>> {
        let fitted: Fitted = content.read()?;
        fitted.check(&columns)?;
        Ok(Box::new(FittedTrees { columns, fitted }))
    }
}

impl BoostedTrees {
    /// The trees of an output.
    fn output(&self, rows: &Rows, targets: &[f64], runs: usize) -> Output {
        let parts: Vec<Part> = match runs {
            // A single run cannot be left out.
            0 | 1 => Vec::new(),
            _ => (0..PARTS.min(runs)).map(|part| self.part(rows, targets, part)).collect(),
        };
        let longest = parts.iter().map(|part| part.squares.len()).max().unwrap_or(0);
        // A growth that ended would not have become better.
        let square = |part: &Part, count: usize| part.squares[count.min(part.squares.len() - 1)];
        let error = |count: usize| parts.iter().map(|part| square(part, count)).sum::<f64>();
        let best = (0..longest).min_by(|a, b| error(*a).total_cmp(&error(*b)));
        // With a single run there is none to judge by.
        let count = best.unwrap_or_else(|| self.trees.min(PATIENCE));
        let mut errors: Vec<Vec<(f64, f64)>> = vec![Vec::new(); runs];
        for part in &parts {
            let trees = &part.trees[..count.min(part.trees.len())];
            for &row in &part.rows {
                let own = rows.row(row);
                let predicted = part.mean + trees.iter().map(|tree| tree.at(own)).sum::<f64>();
                errors[rows.runs[row]].push((rows.along[row], predicted - targets[row]));
            }
        }
        errors.retain(|run| !run.is_empty());
        let all: Vec<usize> = (0..targets.len()).collect();
        let (mean, mut trees) = (mean(targets, &all), Vec::with_capacity(count));
        if count > 0 {
            let left: Vec<f64> = targets.iter().map(|target| target - mean).collect();
            rows.bins.grow(&left, &all, &self.growth(), |tree| {
                trees.push(tree.clone());
                trees.len() < count
            });
        }
        let errors = match errors.is_empty() {
            true => LeftOutErrors::new(&[vec![(0.0, 0.0)]]),
            false => LeftOutErrors::new(&errors),
        };
        Output { mean, trees, errors }
    }

    fn growth(&self) -> Growth {
        Growth { depth: self.depth, least_rows: self.least_states, rate: self.rate, shrinkage: 1.0 }
    }

    /// Trees of the runs outside a part, judged by the runs in it.
    fn part(&self, rows: &Rows, targets: &[f64], part: usize) -> Part {
        let (own, others): (Vec<usize>, Vec<usize>) =
            (0..targets.len()).partition(|row| rows.runs[*row] % PARTS == part);
        let mean = mean(targets, &others);
        let left: Vec<f64> = targets.iter().map(|target| target - mean).collect();
        let mut errors: Vec<f64> = own.iter().map(|row| left[*row]).collect();
        let square = |errors: &[f64]| errors.iter().map(|e| e * e).sum::<f64>();
        let (mut squares, mut trees) = (vec![square(&errors)], Vec::new());
        let mut best = 0;
        if self.trees > 0 && !others.is_empty() {
            rows.bins.grow(&left, &others, &self.growth(), |tree| {
                for (error, row) in errors.iter_mut().zip(&own) {
                    *error -= tree.at(rows.row(*row));
                }
                squares.push(square(&errors));
                trees.push(tree.clone());
                if squares[trees.len()] < squares[best] {
                    best = trees.len();
                }
                trees.len() < self.trees && trees.len() < best + PATIENCE
            });
        }
        Part { rows: own, squares, mean, trees }
    }
}

fn mean(values: &[f64], rows: &[usize]) -> f64 {
    rows.iter().map(|row| values[*row]).sum::<f64>() / rows.len().max(1) as f64
}

/// Fitted trees.
struct FittedTrees {
    columns: Columns,
    fitted: Fitted,
}

impl Surrogate for FittedTrees {
    fn method(&self) -> &str {
        NAME
    }

    fn columns(&self) -> &Columns {
        &self.columns
    }

    fn evaluate(&self, inputs: &RunInputs, level: f64) -> Result<Vec<Prediction>> {
        let Fitted { coordinate, ranges, outputs } = &self.fitted;
        let factors: Vec<f64> = outputs.iter().map(|output| output.errors.factor(level)).collect();
        let predict = |row: &[f64]| {
            let x = coordinate.map_or(0.0, |place| row[place]);
            let each = outputs.iter().zip(&factors);
            let values = each.map(|(output, factor)| output.errors.around(output.at(row), x, *factor));
            Prediction::new(values.collect()).with_outside(outside_of(&self.columns, ranges, row))
        };
        Ok(inputs.rows().map(predict).collect())
    }

    fn evaluate_means(&self, inputs: &RunInputs) -> Result<Vec<Vec<f64>>> {
        let means = |row: &[f64]| self.fitted.outputs.iter().map(|output| output.at(row)).collect();
        Ok(inputs.rows().map(means).collect())
    }

    fn onnx_answer(&self, graph: &mut OnnxGraph, inputs: &Value, level: f64) -> Result<OnnxAnswer> {
        let Fitted { coordinate, ranges, outputs } = &self.fitted;
        let along = match coordinate {
            Some(place) => graph.columns(inputs, &[*place]),
            None => {
                let (first, zero) = (graph.columns(inputs, &[0]), graph.number(0.0));
                graph.apply("Mul", &[&first, &zero])
            }
        };
        let mut estimates = Vec::with_capacity(outputs.len());
        for output in outputs {
            let mean = graph.number(output.mean);
            let mean = match &output.trees[..] {
                // A column, as long as the inputs.
                [] => {
                    let zero = graph.number(0.0);
                    let zeros = graph.apply("Mul", &[&along, &zero]);
                    graph.apply("Add", &[&zeros, &mean])
                }
                trees => {
                    let sum = onnx::sum_of_trees(graph, inputs, trees);
                    graph.apply("Add", &[&sum, &mean])
                }
            };
            estimates.push(output.errors.onnx(graph, mean, &along, output.errors.factor(level)));
        }
        let outside = onnx::outside(graph, inputs, ranges);
        Ok(OnnxAnswer { estimates, outside, ranges: ranges.clone() })
    }

    fn content(&self) -> Result<Content> {
        Content::new(&self.fitted)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::comparison::compare;
    use crate::dataset::{RunStates, Split};
    use granum_core::observer::NoObserver;
    use granum_core::{Column, Table};

    fn dataset(runs: u32, noise: f64) -> Dataset {
        let run = |k: u32| {
            let height = f64::from(k * 7 % runs) / f64::from(runs);
            let shift = noise * (f64::from(k * 13 % runs) / f64::from(runs) - 0.5);
            let x: Vec<f64> = (0..50).map(|i| f64::from(i) / 49.0).collect();
            let y = x.iter().map(|x| height * x * x + shift).collect();
            let table = Table::new(vec![Column::new("x", "", x), Column::new("y", "", y)]).unwrap();
            RunStates::new(&format!("run-{k}"), table).unwrap().with_parameter("height", "", height).unwrap()
        };
        Dataset::new((0..runs).map(run).collect()).unwrap()
    }

    fn spec() -> FitSpec {
        FitSpec::new(["x", "height"], ["y"]).with_coordinate("x")
    }

    #[test]
    fn unseen_runs_are_predicted_and_their_states_lie_in_the_intervals() {
        let dataset = dataset(60, 0.2);
        let unseen = (0..60).step_by(4).map(|k| format!("run-{k}"));
        let parts = dataset.split(&Split::default().stride(1).unseen(unseen)).unwrap();
        let method = BoostedTrees::default();
        let scores = compare(&parts, &spec(), &[&method], 0.9, &mut NoObserver).unwrap();
        // The shift of a run, which no input tells, has a standard deviation of 0.058.
        let (score, held) = (scores[0].unseen, scores[0].coverage.unwrap());
        assert!((0.05..0.08).contains(&score.rmse), "{score:?}");
        assert!((0.8..=1.0).contains(&held), "{held}");
    }

    #[test]
    fn the_result_does_not_depend_on_threads_and_one_run_is_enough() {
        let dataset = dataset(7, 0.1);
        let fit = |threads| {
            let spec = FitSpec::new(["x"], ["y", "height"]).with_threads(threads);
            let fitted = BoostedTrees::default().fit(&dataset, &spec, &mut NoObserver).unwrap();
            fitted.content().unwrap()
        };
        assert_eq!(fit(1), fit(2));
        let one = Dataset::new(vec![dataset.runs()[1].clone()]).unwrap();
        let fitted = BoostedTrees::default().fit(&one, &FitSpec::new(["x"], ["y"]), &mut NoObserver).unwrap();
        assert!(fitted.predict_rows(&[0.5], 0.9).unwrap()[0].values[0].interval.is_none());
        let bad = BoostedTrees { rate: 0.0, ..BoostedTrees::default() };
        let text = bad.fit(&one, &spec(), &mut NoObserver).err().unwrap().to_string();
        assert_eq!(text, "boosted-trees: the rate must be above 0 and at most 1, not 0");
    }
}
