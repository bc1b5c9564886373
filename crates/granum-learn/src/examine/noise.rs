//! What noise in the inputs costs, or gains. Normal noise is added whose standard deviation is a share of that of each input over the
//! training states: to the inputs from which a surrogate learns (training with noise is a penalty on slopes: Bishop, Neural Computation 7 (1995)
//! 108), to those that it is asked with (what an instrument adds), or to both. Inputs that are the same in all states of a run have one noise for the run,
//! others one for each state; the coordinate has none.

use granum_core::observer::Observer;
use serde::{Deserialize, Serialize};

use super::errors::errors_on;
use super::noise_numbers::NormalNumbers;
use super::turn::Turn;
use crate::dataset::{Dataset, RunStates};
use crate::error::{LearnError, Result};
use crate::pooled_error::PooledError;
use crate::study::thinned;
use crate::surrogate::{FitSpec, SurrogateMethods};

/// Where noise is added.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Noisy {
    /// In the inputs that are learned from.
    Training,
    /// In the inputs of the unseen runs.
    Unseen,
    /// In both.
    Both,
}

/// What is learned, by which methods, and the levels of noise.
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseInInputs {
    /// The column along which a test runs; it is an input without noise.
    pub coordinate: String,
    /// The other inputs; the name of a histogram stands for all of its bins.
    pub inputs: Vec<String>,
    /// What is learned and judged.
    pub outputs: Vec<String>,
    /// Names of methods.
    pub methods: Vec<String>,
    /// Standard deviations over those of the inputs; 0 is without noise.
    pub levels: Vec<f64>,
    /// Most states that are learned from and judged.
    pub most_states: usize,
    /// Seed of noise and methods.
    pub seed: u64,
    /// Number of threads; 0 for the number of processors. Answers do not depend on it.
    pub threads: usize,
}

/// The error of an output at a level of noise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NoiseAnswer {
    /// The method.
    pub method: String,
    /// Where the noise is.
    pub noisy: Noisy,
    /// Its standard deviation over that of each input.
    pub level: f64,
    /// The output.
    pub output: String,
    /// Its error on the unseen runs.
    pub error: PooledError,
}

impl NoiseInInputs {
    /// Fits each method without noise and with each level, and judges it.
    ///
    /// # Errors
    /// If a level is negative or not finite, a column or method does not exist, a surrogate cannot be fitted, or the observer stops the measurement.
    pub fn measure(
        &self,
        training: &Dataset,
        unseen: &Dataset,
        methods: &SurrogateMethods,
        observer: &mut dyn Observer,
    ) -> Result<Vec<NoiseAnswer>> {
        if let Some(level) = self.levels.iter().find(|level| !(level.is_finite() && **level >= 0.0)) {
            return Err(LearnError::Dataset(format!("a level of noise of {level} is not possible")));
        }
        let (training, unseen) = (thinned(training, self.most_states), thinned(unseen, self.most_states));
        let mut inputs = training.expand(&self.inputs)?;
        inputs.retain(|name| *name != self.coordinate);
        let deviations =
            inputs.iter().map(|name| deviation(&training, name)).collect::<Result<Vec<f64>>>()?;
        let all = [self.coordinate.clone()]
            .into_iter()
            .chain(self.inputs.iter().filter(|own| **own != self.coordinate).cloned());
        let spec = FitSpec::new(all, self.outputs.clone()).with_coordinate(&self.coordinate);
        let spec = spec.with_seed(self.seed).with_threads(self.threads);
        let mut turn = Turn::new(self.methods.len() * (1 + self.levels.len()), observer);
        let mut answers = Vec::new();
        for name in &self.methods {
            let method = methods.by_name(name)?;
            turn.next(format!("{name}, without noise"))?;
            let clean = turn.work(|observer| method.fit(&training, &spec, observer))?;
            for level in &self.levels {
                turn.next(format!("{name}, noise {level}"))?;
                let noise =
                    |dataset: &Dataset, seed: u64| self.noisy(dataset, &inputs, &deviations, *level, seed);
                let noisy = noise(&training, 1)?;
                let fitted = turn.work(|observer| method.fit(&noisy, &spec, observer))?;
                let asked = noise(&unseen, 2)?;
                let judged = [
                    (Noisy::Training, &fitted, &unseen),
                    (Noisy::Unseen, &clean, &asked),
                    (Noisy::Both, &fitted, &asked),
                ];
                for (noisy, surrogate, runs) in judged {
                    let errors = errors_on(surrogate.as_ref(), runs, &self.outputs)?;
                    let answer = |(output, error): (&String, PooledError)| NoiseAnswer {
                        method: name.clone(),
                        noisy,
                        level: *level,
                        output: output.clone(),
                        error,
                    };
                    answers.extend(self.outputs.iter().zip(errors).map(answer));
                }
            }
        }
        Ok(answers)
    }

    /// The runs with noise in their inputs.
    fn noisy(
        &self,
        dataset: &Dataset,
        inputs: &[String],
        deviations: &[f64],
        level: f64,
        seed: u64,
    ) -> Result<Dataset> {
        if level == 0.0 {
            return Ok(dataset.clone());
        }
        let mut random = NormalNumbers::new(self.seed.wrapping_mul(1000).wrapping_add(seed));
        let mut with_noise = |run: &RunStates| -> Result<RunStates> {
            let mut run = run.clone();
            for (name, deviation) in inputs.iter().zip(deviations) {
                let size = level * deviation;
                let values = run.column(name)?;
                let shifted = match run.table().values(name) {
                    Some(own) => own.iter().map(|value| value + size * random.next()).collect(),
                    None => vec![values[0] + size * random.next(); values.len()],
                };
                run = run.with_values(name, shifted)?;
            }
            Ok(run)
        };
        Dataset::new(dataset.runs().iter().map(&mut with_noise).collect::<Result<_>>()?)
    }
}

/// The standard deviation of a column over all states.
fn deviation(dataset: &Dataset, name: &str) -> Result<f64> {
    let values = dataset.column(name)?;
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    Ok((values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / count).sqrt())
}

#[cfg(test)]
pub(super) mod tests {
    use granum_core::{Column, Table};

    use granum_core::observer::NoObserver;

    use super::*;

    /// Runs whose curve rises to a height that a parameter decides, with a sensor that tells the height as well.
    pub(in crate::examine) fn family(count: u32) -> Dataset {
        let run = |k: u32| {
            let place = f64::from(k * 7 % count) / f64::from(count);
            let height = 1.0 + (3.0 * place).sin();
            let x: Vec<f64> = (0..16).map(|i| f64::from(i) / 15.0).collect();
            let y: Vec<f64> = x.iter().map(|x| height * (1.0 - (-4.0 * x).exp())).collect();
            let sensor = x.iter().map(|x| height + 0.1 * x).collect();
            let columns = [("x", x.clone()), ("y", y), ("sensor", sensor)];
            let table =
                Table::new(columns.into_iter().map(|(name, own)| Column::new(name, "", own)).collect())?;
            RunStates::new(&format!("run-{k}"), table)?.with_parameter("place", "", place)
        };
        Dataset::new((0..count).map(run).collect::<Result<_>>().unwrap()).unwrap()
    }

    /// The first so many runs, and the others.
    pub(in crate::examine) fn split(dataset: &Dataset, first: usize) -> (Dataset, Dataset) {
        let mut runs = dataset.runs().to_vec();
        let unseen = runs.split_off(first);
        (Dataset::new(runs).unwrap(), Dataset::new(unseen).unwrap())
    }

    /// Without noise nothing changes; noise in what is asked costs more than in what is learned, and the noise is as large as it is said to be.
    #[test]
    fn noise_costs_most_where_it_is_asked() {
        let (training, unseen) = split(&family(30), 24);
        let question = NoiseInInputs {
            coordinate: "x".into(),
            inputs: vec!["sensor".into(), "place".into()],
            outputs: vec!["y".into()],
            methods: vec!["ridge".into()],
            levels: vec![0.0, 0.3],
            most_states: 1000,
            seed: 1,
            threads: 1,
        };
        let methods = SurrogateMethods::standard();
        let answers = question.measure(&training, &unseen, &methods, &mut NoObserver).unwrap();
        let of = |noisy: Noisy, level: f64| {
            answers.iter().find(|own| own.noisy == noisy && own.level == level).unwrap().error.relative
        };
        let clean = of(Noisy::Training, 0.0);
        assert_eq!([of(Noisy::Unseen, 0.0), of(Noisy::Both, 0.0)], [clean; 2]);
        assert!(
            of(Noisy::Training, 0.3) > clean && of(Noisy::Unseen, 0.3) > 1.2 * of(Noisy::Training, 0.3),
            "{answers:?}"
        );
        let inputs = ["sensor".to_string(), "place".to_string()];
        let noisy = question.noisy(&training, &inputs, &[1.0, 1.0], 0.5, 1).unwrap();
        let moved: Vec<f64> = noisy
            .column("sensor")
            .unwrap()
            .iter()
            .zip(training.column("sensor").unwrap())
            .map(|(a, b)| a - b)
            .collect();
        let size = (moved.iter().map(|d| d * d).sum::<f64>() / moved.len() as f64).sqrt();
        assert!((size - 0.5).abs() < 0.05, "{size}");
        // A property is the same in all states of a run.
        let places = noisy.runs()[0].column("place").unwrap();
        assert!(
            places.iter().all(|place| *place == places[0])
                && places[0] != training.runs()[0].parameter("place").unwrap()
        );
        assert_eq!(noisy.column("x").unwrap(), training.column("x").unwrap());
        let wrong = NoiseInInputs { levels: vec![-1.0], ..question };
        assert!(wrong.measure(&training, &unseen, &methods, &mut NoObserver).is_err());
    }
}
