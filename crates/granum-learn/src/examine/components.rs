//! How few numbers hold a curve or a distribution: principal components (uncorrelated, by falling variance) and independent ones (the same
//! directions turned until they are as independent as possible, FastICA).
//!
//! - Of inputs: the bins of a histogram such as `P(f)` are replaced by the first `k` components of the training states before a method learns.
//! - Of curves: each output is a sum of `k` components, whose weights Gaussian processes learn.

use granum_core::observer::Observer;
use serde::{Deserialize, Serialize};

use super::errors::errors_on;
use super::turn::Turn;
use crate::dataset::{Dataset, RunStates};
use crate::error::{LearnError, Result};
use crate::pooled_error::PooledError;
use crate::regression::independent::{independent_rotation, projected};
use crate::study::thinned;
use crate::surrogate::{FitSpec, GaussianProcessOfCurves, SurrogateMethod, SurrogateMethods};
use crate::worth::properties;
use granum_nets::eigenvectors;

/// Beginning of the names of the columns that stand for a histogram.
const COMPONENT: &str = "component_";

/// The components of a histogram as inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct ComponentsOfInputs {
    /// The histogram that is replaced.
    pub histogram: String,
    /// The column along which a test runs; it is an input.
    pub coordinate: String,
    /// Further inputs.
    pub inputs: Vec<String>,
    /// What is learned and judged.
    pub outputs: Vec<String>,
    /// The method that learns.
    pub method: String,
    /// Numbers of components.
    pub counts: Vec<usize>,
    /// Most states that are learned from and judged.
    pub most_states: usize,
    /// Seed of the method.
    pub seed: u64,
    /// Number of threads; 0 for the number of processors. Answers do not depend on it.
    pub threads: usize,
}

/// Curves of outputs from the properties of runs, by Gaussian processes of the weights of their components.
#[derive(Clone, Debug, PartialEq)]
pub struct ComponentsOfCurves {
    /// The column along which a test runs.
    pub coordinate: String,
    /// What is learned and judged.
    pub outputs: Vec<String>,
    /// Numbers of components.
    pub counts: Vec<usize>,
    /// Seed of the processes.
    pub seed: u64,
    /// Number of threads; 0 for the number of processors. Answers do not depend on it.
    pub threads: usize,
}

/// The error of an output with so many components.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ComponentsAnswer {
    /// `principal`, `independent`, or for all bins as they are `whole`.
    pub kind: String,
    /// Number of components, or of bins.
    pub components: usize,
    /// Share of the variance of the training states that the components hold; for curves it is not told.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub held: Option<f64>,
    /// The output.
    pub output: String,
    /// Its error on the unseen runs.
    pub error: PooledError,
}

/// The directions of a histogram over training states.
struct Directions {
    mean: Vec<f64>,
    /// Each of length one, by falling variance.
    vectors: Vec<Vec<f64>>,
    variances: Vec<f64>,
}

impl Directions {
    /// Of rows with a value for each bin.
    fn new(rows: &[f64], bins: usize) -> Directions {
        let count = (rows.len() / bins).max(1) as f64;
        let mean: Vec<f64> =
            (0..bins).map(|k| rows.iter().skip(k).step_by(bins).sum::<f64>() / count).collect();
        let mut matrix = vec![0.0; bins * bins];
        for row in rows.chunks_exact(bins) {
            for i in 0..bins {
                for j in 0..bins {
                    matrix[i * bins + j] += (row[i] - mean[i]) * (row[j] - mean[j]) / count;
                }
            }
        }
        let (values, found) = eigenvectors(matrix, bins);
        let mut order: Vec<usize> = (0..bins).collect();
        order.sort_by(|a, b| values[*b].total_cmp(&values[*a]));
        let vectors = order.iter().map(|k| (0..bins).map(|i| found[i * bins + k]).collect()).collect();
        Directions { mean, vectors, variances: order.iter().map(|k| values[*k].max(0.0)).collect() }
    }

    /// The first `count` of them with a standard deviation of one, or as many as vary at all; turned until they are independent if asked for.
    fn scaled(&self, rows: &[f64], count: usize, independent: bool) -> Vec<Vec<f64>> {
        let least = 1e-12 * self.variances.first().copied().unwrap_or(0.0);
        let used = self.variances.iter().take(count).take_while(|variance| **variance > least).count();
        let scale =
            |k: usize| -> Vec<f64> { self.vectors[k].iter().map(|v| v / self.variances[k].sqrt()).collect() };
        let scaled: Vec<Vec<f64>> = (0..used).map(scale).collect();
        if !independent {
            return scaled;
        }
        let columns: Vec<Vec<f64>> = scaled.iter().map(|direction| self.along(rows, direction)).collect();
        let rotation = independent_rotation(&columns);
        rotation.chunks(used.max(1)).map(|turn| projected(&scaled, turn)).collect()
    }

    /// The values of rows along a direction.
    fn along(&self, rows: &[f64], direction: &[f64]) -> Vec<f64> {
        let dot = |row: &[f64]| -> f64 {
            row.iter().zip(&self.mean).zip(direction).map(|((value, mean), v)| (value - mean) * v).sum()
        };
        rows.chunks_exact(direction.len()).map(dot).collect()
    }

    fn held(&self, count: usize) -> f64 {
        let total: f64 = self.variances.iter().sum();
        if total > 0.0 { self.variances.iter().take(count).sum::<f64>() / total } else { 1.0 }
    }
}

/// Refuses numbers of components that are not there.
fn check_counts(counts: &[usize], most: usize) -> Result<()> {
    match counts.iter().find(|count| !(1..=most).contains(*count)) {
        Some(count) => {
            Err(LearnError::Dataset(format!("{count} components are not possible; there are 1 to {most}")))
        }
        None => Ok(()),
    }
}

impl ComponentsOfInputs {
    /// Fits the method to each number of components of both kinds, and to the whole histogram.
    ///
    /// # Errors
    /// If the histogram, a column or the method does not exist, a number of components is not possible, a surrogate cannot be fitted, or the
    /// observer stops the measurement.
    pub fn measure(
        &self,
        training: &Dataset,
        unseen: &Dataset,
        methods: &SurrogateMethods,
        observer: &mut dyn Observer,
    ) -> Result<Vec<ComponentsAnswer>> {
        let method = methods.by_name(&self.method)?;
        let (training, unseen) = (thinned(training, self.most_states), thinned(unseen, self.most_states));
        let bins = training.expand(&[&self.histogram])?;
        check_counts(&self.counts, bins.len())?;
        let rows = training.values(&bins)?;
        let directions = Directions::new(&rows, bins.len());
        let mut turn = Turn::new(1 + 2 * self.counts.len(), observer);
        let fixed: Vec<String> = [&self.coordinate].into_iter().chain(&self.inputs).cloned().collect();
        let mut answers = Vec::new();
        let mut judge = |turn: &mut Turn,
                         (kind, count): (&str, usize),
                         own: Vec<String>,
                         learned: &Dataset,
                         judged: &Dataset| {
            let spec = FitSpec::new(fixed.iter().cloned().chain(own), self.outputs.clone());
            let spec = spec.with_coordinate(&self.coordinate).with_seed(self.seed).with_threads(self.threads);
            let surrogate = turn.work(|observer| method.fit(learned, &spec, observer))?;
            let errors = errors_on(surrogate.as_ref(), judged, &self.outputs)?;
            answers.extend(self.outputs.iter().zip(errors).map(|(output, error)| ComponentsAnswer {
                kind: kind.into(),
                components: count,
                held: Some(directions.held(count)),
                output: output.clone(),
                error,
            }));
            Ok::<(), LearnError>(())
        };
        turn.next(format!("all {} bins", bins.len()))?;
        judge(&mut turn, ("whole", bins.len()), vec![self.histogram.clone()], &training, &unseen)?;
        for count in &self.counts {
            for (kind, independent) in [("principal", false), ("independent", true)] {
                turn.next(format!("{count} {kind} components"))?;
                let used = directions.scaled(&rows, *count, independent);
                let with = |dataset: &Dataset| -> Result<Dataset> {
                    let run = |run: &RunStates| with_components(run, &bins, &directions, &used);
                    Dataset::new(dataset.runs().iter().map(run).collect::<Result<_>>()?)
                };
                let names = (1..=used.len()).map(|k| format!("{COMPONENT}{k}")).collect();
                judge(&mut turn, (kind, *count), names, &with(&training)?, &with(&unseen)?)?;
            }
        }
        Ok(answers)
    }
}

fn with_components(
    run: &RunStates,
    bins: &[String],
    directions: &Directions,
    used: &[Vec<f64>],
) -> Result<RunStates> {
    let columns = bins.iter().map(|name| run.column(name)).collect::<Result<Vec<_>>>()?;
    let rows: Vec<f64> =
        (0..run.rows()).flat_map(|row| columns.iter().map(move |column| column[row])).collect();
    let mut run = run.clone();
    for (k, direction) in used.iter().enumerate() {
        run = run.with_column(&format!("{COMPONENT}{}", k + 1), "", directions.along(&rows, direction))?;
    }
    Ok(run)
}

impl ComponentsOfCurves {
    /// Fits Gaussian processes with each number of components of both kinds.
    ///
    /// # Errors
    /// If a number of components is not possible, a column does not exist, a surrogate cannot be fitted, or the observer stops the measurement.
    pub fn measure(
        &self,
        training: &Dataset,
        unseen: &Dataset,
        observer: &mut dyn Observer,
    ) -> Result<Vec<ComponentsAnswer>> {
        check_counts(&self.counts, training.runs().len().saturating_sub(1))?;
        let inputs = [self.coordinate.clone()].into_iter().chain(properties(training));
        let spec = FitSpec::new(inputs, self.outputs.clone()).with_coordinate(&self.coordinate);
        let spec = spec.with_seed(self.seed).with_threads(self.threads);
        let mut turn = Turn::new(2 * self.counts.len(), observer);
        let mut answers = Vec::new();
        for components in &self.counts {
            for (kind, independent) in [("principal", false), ("independent", true)] {
                turn.next(format!("{components} {kind} components"))?;
                let method =
                    GaussianProcessOfCurves { components: *components, independent, ..Default::default() };
                let surrogate = turn.work(|observer| method.fit(training, &spec, observer))?;
                let errors = errors_on(surrogate.as_ref(), unseen, &self.outputs)?;
                answers.extend(self.outputs.iter().zip(errors).map(|(output, error)| ComponentsAnswer {
                    kind: kind.into(),
                    components: *components,
                    held: None,
                    output: output.clone(),
                    error,
                }));
            }
        }
        Ok(answers)
    }
}

#[cfg(test)]
mod tests {
    use granum_core::{Column, Table};

    use granum_core::observer::NoObserver;

    use super::*;
    use crate::dataset::ColumnGroup;
    use crate::examine::noise::tests::{family, split};

    /// Components of both kinds are uncorrelated with a mean square of one, and there are no more than the rows have.
    #[test]
    fn components_are_scaled_and_uncorrelated() {
        let row = |k: u32| {
            let (a, b) = (f64::from(k * 7 % 31), f64::from(k * k % 17));
            [1.0 + a, 2.0 * b - a, 3.0 + a + b, 0.5]
        };
        let rows: Vec<f64> = (0..60).flat_map(row).collect();
        let directions = Directions::new(&rows, 4);
        for independent in [false, true] {
            let used = directions.scaled(&rows, 4, independent);
            assert_eq!(used.len(), 2);
            let columns: Vec<Vec<f64>> = used.iter().map(|own| directions.along(&rows, own)).collect();
            let product = |i: usize, j: usize| {
                columns[i].iter().zip(&columns[j]).map(|(x, y)| x * y).sum::<f64>() / 60.0
            };
            assert!((product(0, 0) - 1.0).abs() < 1e-9 && (product(1, 1) - 1.0).abs() < 1e-9);
            assert!(product(0, 1).abs() < 1e-9, "{independent} {}", product(0, 1));
        }
    }

    /// A histogram of two shapes whose amounts decide the output: two components hold it, and one is worse.
    #[test]
    fn two_shapes_need_two_components() {
        let run = |k: u32| {
            let (a, b) = (f64::from(k * 7 % 11) / 11.0, f64::from(k * 5 % 13) / 13.0);
            let x: Vec<f64> = (0..12).map(|i| f64::from(i) / 11.0).collect();
            let y: Vec<f64> = x.iter().map(|x| a * x + b * (1.0 - x)).collect();
            let bin = |j: u32| {
                let shape =
                    |x: &f64| 0.5 + a * x * f64::from(j) / 4.0 + b * (1.0 - x) * f64::from(j * j % 5) / 4.0;
                Column::new(format!("h_{}", f64::from(j) + 0.5), "", x.iter().map(shape).collect())
            };
            let columns =
                [Column::new("x", "", x.clone()), Column::new("y", "", y)].into_iter().chain((0..5).map(bin));
            let group = ColumnGroup {
                name: "h".into(),
                binned: "f".into(),
                bin_width: 1.0,
                centres: (0..5).map(|j| f64::from(j) + 0.5).collect(),
            };
            RunStates::new(&format!("run-{k}"), Table::new(columns.collect())?)?.with_group(group)
        };
        let dataset = Dataset::new((0..20).map(run).collect::<Result<_>>().unwrap()).unwrap();
        let (training, unseen) = split(&dataset, 15);
        let question = ComponentsOfInputs {
            histogram: "h".into(),
            coordinate: "x".into(),
            inputs: Vec::new(),
            outputs: vec!["y".into()],
            method: "ridge".into(),
            counts: vec![1, 2],
            most_states: 1000,
            seed: 1,
            threads: 1,
        };
        let methods = SurrogateMethods::standard();
        let answers = question.measure(&training, &unseen, &methods, &mut NoObserver).unwrap();
        let of = |kind: &str, count: usize| {
            answers.iter().find(|own| own.kind == kind && own.components == count).unwrap()
        };
        assert_eq!((answers.len(), of("whole", 5).components), (5, 5));
        for kind in ["principal", "independent"] {
            assert!(of(kind, 2).error.relative < of(kind, 1).error.relative, "{answers:?}");
        }
        assert!(of("principal", 1).held.unwrap() < 0.9);
        assert!((of("principal", 2).held.unwrap() - 1.0).abs() < 1e-9);
        let wrong = ComponentsOfInputs { counts: vec![6], ..question };
        let error = wrong.measure(&training, &unseen, &methods, &mut NoObserver).unwrap_err().to_string();
        assert!(error.contains("1 to 5"), "{error}");
    }

    /// Curves of one shape need one component, and one component cannot be turned.
    #[test]
    fn curves_of_one_shape_need_one_component() {
        let (training, unseen) = split(&family(24), 18);
        let question = ComponentsOfCurves {
            coordinate: "x".into(),
            outputs: vec!["y".into()],
            counts: vec![1, 2],
            seed: 1,
            threads: 1,
        };
        let answers = question.measure(&training, &unseen, &mut NoObserver).unwrap();
        let errors: Vec<f64> = answers.iter().map(|own| own.error.relative).collect();
        assert_eq!(errors.len(), 4);
        assert!(errors.iter().all(|error| (error - errors[0]).abs() < 1e-6 && *error < 0.1), "{errors:?}");
    }
}
