//! What was measured.

use serde::{Deserialize, Serialize};

use super::knowledge::Knowledge;
use super::plan::WorthPlan;
use crate::pooled_error::PooledError;

/// The error of an output from some knowledge.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Answer {
    /// The path of the tests, as in their cases; empty if it is not known.
    pub path: String,
    /// What is predicted: a column, or a histogram with all of its bins.
    pub output: String,
    /// What is known.
    pub knowledge: Knowledge,
    /// Number of training runs.
    pub training_runs: usize,
    /// The method that was chosen.
    pub method: String,
    /// The error on unseen runs.
    pub error: PooledError,
    /// The share of their values that lie within the intervals; null without intervals.
    pub coverage: Option<f64>,
}

/// All answers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Worth {
    /// What was asked.
    pub plan: WorthPlan,
    /// Names of the unseen runs.
    pub unseen: Vec<String>,
    /// The answers, ordered by path, output, number of training runs and knowledge.
    pub answers: Vec<Answer>,
    /// What could not be answered, in words.
    pub remarks: Vec<String>,
}

/// A row of a table: what is known, and an answer for each column.
pub type AnswerRow<'a> = (&'a str, Vec<Option<&'a Answer>>);

impl Worth {
    /// The paths of the tests.
    pub fn paths(&self) -> Vec<&str> {
        distinct(self.answers.iter().map(|answer| answer.path.as_str()))
    }

    /// The answers for a path about some outputs as a table: for each knowledge, in order, and each output the answer with the most training
    /// runs.
    pub fn table<'a>(&'a self, path: &str, outputs: &'a [String]) -> Vec<AnswerRow<'a>> {
        let own = |answer: &&Answer| answer.path == path && outputs.contains(&answer.output);
        let names = distinct(self.answers.iter().filter(own).map(|answer| answer.knowledge.name.as_str()));
        let most = |name: &str, output: &String| {
            let own = self.answers.iter().filter(own);
            let own = own.filter(|answer| answer.knowledge.name == name && answer.output == *output);
            own.max_by_key(|answer| answer.training_runs)
        };
        names
            .into_iter()
            .map(|name| (name, outputs.iter().map(|output| most(name, output)).collect()))
            .collect()
    }

    /// The answers for a path about an output by the number of training runs: for each knowledge one for each of the numbers.
    pub fn by_runs<'a>(&'a self, path: &str, output: &str) -> (Vec<usize>, Vec<AnswerRow<'a>>) {
        let own: Vec<&Answer> =
            self.answers.iter().filter(|answer| answer.path == path && answer.output == output).collect();
        let counts = distinct(own.iter().map(|answer| answer.training_runs));
        let names = distinct(own.iter().map(|answer| answer.knowledge.name.as_str()));
        let answer = |name: &str, count: &usize| {
            own.iter().find(|own| own.knowledge.name == name && own.training_runs == *count).copied()
        };
        let rows =
            names.into_iter().map(|name| (name, counts.iter().map(|count| answer(name, count)).collect()));
        let rows = rows.collect();
        (counts, rows)
    }
}

/// Each value once, in the order of their first occurrence.
fn distinct<T: PartialEq>(values: impl Iterator<Item = T>) -> Vec<T> {
    let mut found: Vec<T> = Vec::new();
    values.for_each(|value| {
        if !found.contains(&value) {
            found.push(value);
        }
    });
    found
}
