//! What no surrogate can beat: the scatter between samples on the same path.

use granum_io::case::CaseParameter;

use super::answers::PathAnswer;
use super::columns::{is_of, kinds};
use super::quantities::{Quantity, Row};
use crate::dataset::{Dataset, RunStates};
use crate::pooled_error::PooledError;

/// The numbers of stage and state of each row of a run.
fn keys(run: &RunStates) -> Vec<[f64; 2]> {
    let column = |name: &str| run.table().values(name).unwrap_or_default().to_vec();
    column("stage").into_iter().zip(column("state")).map(|(stage, state)| [stage, state]).collect()
}

/// True if two runs differ in their samples alone: all parameters but the seed of the preparation and what was measured are the same.
fn is_same_path(a: &RunStates, b: &RunStates) -> bool {
    let of_path = |own: &&CaseParameter| !own.key.starts_with("sample.") && own.key != "preparation.seed";
    a.parameters().iter().filter(of_path).eq(b.parameters().iter().filter(of_path))
}

/// The standard deviation of single runs about the mean of all samples, from pairs of runs on the same path.
pub(super) fn scatter(
    runs: &Dataset,
    exact: &[Row],
    means: &Row,
    quantities: &[Quantity],
) -> Vec<PathAnswer> {
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
    // The states that both runs of a pair have, with one of them.
    let in_both = |(a, b): &(usize, usize)| {
        let (of_a, of_b) = (keys(&all[*a]), keys(&all[*b]));
        let (mut first, mut second) = (Vec::new(), Vec::new());
        for (k, key) in of_a.iter().enumerate() {
            if let Some(other) = of_b.iter().position(|other| other == key) {
                first.push(exact[firsts[*a] + k]);
                second.push(exact[firsts[*b] + other]);
            }
        }
        (&all[*a], first, second)
    };
    let pairs: Vec<_> = pairs.iter().map(in_both).collect();
    let mut found = Vec::new();
    for of_kind in kinds(runs) {
        for quantity in quantities {
            let own = pairs.iter().filter(|(run, ..)| is_of(run, &of_kind));
            let squares = own.map(|(_, first, second)| {
                let [errors, values] = quantity.squares(first, second, means);
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
