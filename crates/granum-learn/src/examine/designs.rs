//! Which design teaches most: data sets whose runs were placed by different designs, judged on the same unseen runs.

use granum_core::observer::Observer;
use serde::{Deserialize, Serialize};

use super::errors::errors_on;
use super::turn::Turn;
use crate::dataset::Dataset;
use crate::error::Result;
use crate::pooled_error::PooledError;
use crate::surrogate::{FitSpec, GaussianProcessOfCurves, SurrogateMethod};
use crate::worth::properties;

/// The error of an output with the runs of a design.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DesignAnswer {
    /// The name of the data set.
    pub design: String,
    /// Number of its runs.
    pub runs: usize,
    /// The output.
    pub output: String,
    /// Its error on the unseen runs.
    pub error: PooledError,
}

/// Fits Gaussian processes of curves to each data set, with the properties in which its runs differ as inputs, and judges them on unseen runs.
///
/// # Errors
/// If a column does not exist, a surrogate cannot be fitted, or the observer stops the measurement.
pub fn compare_designs(
    designs: &[(String, Dataset)],
    unseen: &Dataset,
    coordinate: &str,
    outputs: &[String],
    threads: usize,
    observer: &mut dyn Observer,
) -> Result<Vec<DesignAnswer>> {
    let mut turn = Turn::new(designs.len(), observer);
    let mut answers = Vec::new();
    for (name, runs) in designs {
        turn.next(name)?;
        let inputs = [coordinate.to_owned()].into_iter().chain(properties(runs));
        let spec = FitSpec::new(inputs, outputs.to_vec()).with_coordinate(coordinate).with_threads(threads);
        let surrogate =
            turn.work(|observer| GaussianProcessOfCurves::default().fit(runs, &spec, observer))?;
        let errors = errors_on(surrogate.as_ref(), unseen, outputs)?;
        answers.extend(outputs.iter().zip(errors).map(|(output, error)| DesignAnswer {
            design: name.clone(),
            runs: runs.runs().len(),
            output: output.clone(),
            error,
        }));
    }
    Ok(answers)
}

#[cfg(test)]
mod tests {
    use granum_core::observer::NoObserver;

    use super::*;
    use crate::examine::noise::tests::{family, split};

    /// Runs that fill the range of the unseen ones teach more than runs in a part of it.
    #[test]
    fn a_design_that_fills_the_range_is_better() {
        let (training, unseen) = split(&family(30), 24);
        let part = training.select(|run, _| run.parameter("place").is_some_and(|place| place < 0.4));
        let spread = training.select(|run, _| {
            run.parameter("place").is_some_and(|p| ((30.0 * p).round() as u32).is_multiple_of(2))
        });
        let designs = [("part".to_string(), part), ("spread".to_string(), spread)];
        let answers = compare_designs(&designs, &unseen, "x", &["y".into()], 1, &mut NoObserver).unwrap();
        assert_eq!(answers.iter().map(|own| own.design.as_str()).collect::<Vec<_>>(), ["part", "spread"]);
        assert!(answers[1].error.relative < 0.5 * answers[0].error.relative, "{answers:?}");
    }
}
