//! What must be beaten, and what cannot be: baselines, and the scatter between samples on the same path.

use super::quantities::{COMPONENTS, Quantity, Row, rows_of, samples, strains};
use super::{ALL, PathAnswer, kind, kinds};
use crate::dataset::{Dataset, RunStates};
use crate::error::Result;
use crate::pooled_error::PooledError;

/// The state of the sample, for every state of its run.
pub(super) fn first_states(runs: &Dataset) -> Result<Vec<Row>> {
    let samples = samples(runs)?;
    let each = runs.runs().iter().zip(samples);
    Ok(each.flat_map(|(run, sample)| std::iter::repeat_n(sample, run.rows())).collect())
}

/// The simplest law of any path: `ds = 2 G de`, and no more than a limit of the norm of `s`, with the two numbers that fit the training runs best.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ElasticPerfectlyPlastic {
    /// `2 G` over mean stress.
    stiffness: f64,
    /// Largest norm of the deviator of stress over mean stress.
    limit: f64,
}

/// Steps of the search, factors between which it looks.
const STEPS: usize = 12;

impl ElasticPerfectlyPlastic {
    /// Searches a grid: stiffnesses from 10 to 2000, and limits up to the largest norm.
    pub fn fit(training: &Dataset) -> Result<ElasticPerfectlyPlastic> {
        let (rows, strains) = (rows_of(training)?, strains(training)?);
        let starts = samples(training)?;
        let norm = |row: &Row| row.stress.iter().map(|c| c * c).sum::<f64>().sqrt();
        let most = rows.iter().map(norm).fold(0.0, f64::max);
        let mut best = (f64::INFINITY, ElasticPerfectlyPlastic { stiffness: 100.0, limit: most });
        let mut stiffness = 10.0;
        while stiffness < 2000.0 {
            for step in 1..=STEPS {
                let law = ElasticPerfectlyPlastic { stiffness, limit: most * step as f64 / STEPS as f64 };
                let predicted = law.stresses(training, &strains, &starts);
                let error =
                    rows.iter().zip(&predicted).map(|(exact, row)| Quantity::Stress.square(exact, row));
                let error: f64 = error.sum();
                if error < best.0 {
                    best = (error, law);
                }
            }
            stiffness *= 1.4;
        }
        Ok(best.1)
    }

    /// The states along runs; only stresses mean something.
    pub fn rows(&self, runs: &Dataset) -> Result<Vec<Row>> {
        Ok(self.stresses(runs, &strains(runs)?, &samples(runs)?))
    }

    fn stresses(&self, runs: &Dataset, strains: &[[f64; COMPONENTS]], starts: &[Row]) -> Vec<Row> {
        let mut found = Vec::with_capacity(strains.len());
        for (run, start) in runs.runs().iter().zip(starts) {
            let mut stress = start.stress;
            let mut last = [0.0; COMPONENTS];
            for strain in &strains[found.len()..found.len() + run.rows()] {
                (0..COMPONENTS).for_each(|c| stress[c] += self.stiffness * (strain[c] - last[c]));
                let norm = stress.iter().map(|c| c * c).sum::<f64>().sqrt();
                if norm > self.limit {
                    stress = stress.map(|c| c * self.limit / norm);
                }
                last = *strain;
                found.push(Row { stress, ..Row::default() });
            }
        }
        found
    }
}

/// The numbers of stage and state of each row of a run.
fn keys(run: &RunStates) -> Vec<[f64; 2]> {
    let column = |name: &str| run.table().values(name).unwrap_or_default().to_vec();
    column("stage").into_iter().zip(column("state")).map(|(stage, state)| [stage, state]).collect()
}

/// True if two runs differ in their samples alone: all parameters but the seed of the preparation and what was measured are the same.
fn is_same_path(a: &RunStates, b: &RunStates) -> bool {
    let key = |run: &RunStates| {
        let own = run
            .parameters()
            .iter()
            .filter(|own| !own.key.starts_with("sample.") && own.key != "preparation.seed");
        own.cloned().collect::<Vec<_>>()
    };
    key(a) == key(b)
}

/// The standard deviation of single runs about the mean of all samples, from pairs of runs on the same path.
pub(super) fn scatter(runs: &Dataset, exact: &[Row], means: &Row) -> Vec<PathAnswer> {
    let mut firsts = Vec::new();
    let mut row = 0;
    for run in runs.runs() {
        firsts.push(row);
        row += run.rows();
    }
    let all = runs.runs();
    let mut pairs = Vec::new();
    for a in 0..all.len() {
        // Each run with the next on the same path.
        pairs.extend((a + 1..all.len()).find(|b| is_same_path(&all[a], &all[*b])).map(|b| (a, b)));
    }
    let mut found = Vec::new();
    for of_kind in kinds(runs) {
        for quantity in Quantity::ALL {
            let own = pairs.iter().filter(|(a, _)| of_kind == ALL || kind(&all[*a]) == of_kind);
            let squares = own.map(|(a, b)| {
                let (of_a, of_b) = (keys(&all[*a]), keys(&all[*b]));
                let (mut first, mut second) = (Vec::new(), Vec::new());
                for (k, key) in of_a.iter().enumerate() {
                    if let Some(other) = of_b.iter().position(|other| other == key) {
                        first.push(exact[firsts[*a] + k]);
                        second.push(exact[firsts[*b] + other]);
                    }
                }
                let [errors, values] = quantity.squares(&first, &second, means);
                [0.5 * errors, values]
            });
            let squares: Vec<[f64; 2]> = squares.collect();
            if !squares.is_empty() {
                found.push(PathAnswer {
                    method: "another sample".into(),
                    kind: of_kind.clone(),
                    quantity: quantity.name().into(),
                    error: PooledError::new(&squares),
                });
            }
        }
    }
    found
}
