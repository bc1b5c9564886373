//! How far the curves of runs go. All curves of a fit have one range of the coordinate, and a single test that was ended early would cut it for
//! all of them.

use serde::{Deserialize, Serialize};

use super::run_curves::RunCurve;

/// A run ends early if it has less than this part of the range of the others.
const EARLY: f64 = 0.9;
/// Largest share of the runs that are left out because they end early.
const MOST_LEFT_OUT: f64 = 0.1;

/// A run that was not used because its curve ends early.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EndedEarly {
    /// Its name.
    pub run: String,
    /// The coordinate at its end.
    pub end: f64,
}

/// The runs of a fit, and those that are left out of it.
pub(super) struct Reach {
    pub runs: Vec<RunCurve>,
    pub left_out: Vec<EndedEarly>,
    /// What a user should know of it.
    pub remark: Option<String>,
}

/// Leaves out runs that end early if they are few. If they are many, the range is the one that all runs have, and that is said.
pub(super) fn within_reach(runs: Vec<RunCurve>, names: &[&str], coordinate: &str) -> Reach {
    let ends: Vec<f64> = runs.iter().map(|run| run.xs[run.xs.len() - 1]).collect();
    let start = runs.iter().map(|run| run.xs[0]).fold(f64::NEG_INFINITY, f64::max);
    let mut sorted = ends.clone();
    sorted.sort_by(f64::total_cmp);
    let usual = sorted.get(sorted.len() / 2).copied().unwrap_or(start);
    let is_early = |end: f64| end - start < EARLY * (usual - start);
    let early: Vec<EndedEarly> = names
        .iter()
        .zip(&ends)
        .filter(|(_, end)| is_early(**end))
        .map(|(name, end)| EndedEarly { run: (*name).to_string(), end: *end })
        .collect();
    if early.is_empty() {
        return Reach { runs, left_out: early, remark: None };
    }
    let each: Vec<String> = early.iter().map(|run| format!("{} ({:.4})", run.run, run.end)).collect();
    let each = each.join(", ");
    if early.len() as f64 > MOST_LEFT_OUT * runs.len() as f64 {
        let remark = format!(
            "{} of {} runs end well before the others, which go to {coordinate} {usual:.4}: {each}; curves are learned as far as all runs go",
            early.len(),
            runs.len()
        );
        return Reach { runs, left_out: Vec::new(), remark: Some(remark) };
    }
    let remark = format!(
        "left out because they end well before the others, which go to {coordinate} {usual:.4}: {each}"
    );
    let kept = runs.into_iter().zip(&ends).filter(|(_, end)| !is_early(**end)).map(|(run, _)| run);
    Reach { runs: kept.collect(), left_out: early, remark: Some(remark) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(end: f64) -> RunCurve {
        RunCurve { xs: vec![0.0, 0.5 * end, end], outputs: Vec::new(), inputs: Vec::new() }
    }

    fn reach(ends: &[f64]) -> Reach {
        let names: Vec<String> = (0..ends.len()).map(|k| format!("run-{k}")).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        within_reach(ends.iter().map(|end| run(*end)).collect(), &names, "axial_strain")
    }

    #[test]
    fn few_runs_that_end_early_are_left_out_and_many_are_told() {
        let mut ends = [0.25; 20];
        ends[7] = 0.147;
        let found = reach(&ends);
        assert_eq!(found.runs.len(), 19);
        assert_eq!(found.left_out, [EndedEarly { run: "run-7".into(), end: 0.147 }]);
        assert!(found.remark.is_some_and(|remark| remark.contains("run-7 (0.1470)")));
        // A test that ends a little earlier is not an early one.
        ends[7] = 0.24;
        assert!(reach(&ends).remark.is_none());
        let many = reach(&[0.25, 0.25, 0.1, 0.25]);
        assert_eq!((many.runs.len(), many.left_out.len()), (4, 0));
        assert!(many.remark.is_some_and(|remark| remark.contains("1 of 4 runs")));
    }
}
