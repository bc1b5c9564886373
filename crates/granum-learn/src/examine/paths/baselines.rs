//! What must be beaten: the state of the sample, and the simplest law of any path.

use super::columns::Learned;
use super::quantities::{Quantity, Row, rows_of, samples, strains};
use crate::dataset::Dataset;
use crate::error::Result;
use crate::methods::COMPONENTS;

/// The state of the sample, for every state of its run.
pub(super) fn first_states(learned: &Learned, runs: &Dataset) -> Result<Vec<Row>> {
    let samples = samples(learned, runs)?;
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
    pub fn fit(learned: &Learned, training: &Dataset) -> Result<ElasticPerfectlyPlastic> {
        let (rows, strains) = (rows_of(learned, training)?, strains(training)?);
        let starts = samples(learned, training)?;
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
    pub fn rows(&self, learned: &Learned, runs: &Dataset) -> Result<Vec<Row>> {
        Ok(self.stresses(runs, &strains(runs)?, &samples(learned, runs)?))
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
