//! The test whether a surrogate of a study uses its inputs.

use crate::curve::{interpolated, never_falls};
use crate::dataset::{Dataset, RunStates};
use crate::error::Result;
use crate::input_use::{Given, InputTest, permutation};
use crate::methods::networks::{is_within, sub_model_at};
use crate::score::Scorer;
use crate::surrogate::{FitSpec, RunInputs, Surrogate};

/// A surrogate with its unseen runs.
pub(super) struct MemberTest<'a> {
    surrogate: &'a dyn Surrogate,
    alone: &'a dyn Surrogate,
    /// Index of the coordinate among the inputs.
    coordinate: Option<usize>,
    runs: Vec<RunColumns>,
}

/// The columns of an unseen run.
struct RunColumns {
    name: String,
    /// One column for each input of the surrogate.
    inputs: Vec<Vec<f64>>,
    /// The inputs of the surrogate with the coordinate only, in row-major order.
    inputs_alone: Vec<f64>,
    /// The outputs in row-major order.
    outputs: Vec<f64>,
    /// For each state whether it is scored.
    scored: Vec<bool>,
    /// The groups within which inputs are permuted: those of a stage and a sub-model, and last those that are not scored.
    groups: Vec<usize>,
}

impl<'a> MemberTest<'a> {
    pub fn new(
        surrogate: &'a dyn Surrogate,
        alone: &'a dyn Surrogate,
        spec: &FitSpec,
        unseen: &Dataset,
    ) -> Result<MemberTest<'a>> {
        surrogate.check(unseen)?;
        let coordinate = spec.place_of_coordinate(surrogate.columns());
        let read = |run: &RunStates| {
            let one = Dataset::new(vec![run.clone()])?;
            let names = surrogate.columns().input_names();
            let inputs = names.iter().map(|name| run.column(name)).collect::<Result<Vec<_>>>()?;
            let scored = spec.scored_states(&one)?;
            let xs = coordinate.map(|place| inputs[place].as_slice());
            Ok(RunColumns {
                name: run.name().to_owned(),
                groups: groups(&run.column("stage")?, xs, &scored, spec),
                scored,
                inputs,
                inputs_alone: one.values(&alone.columns().input_names())?,
                outputs: one.values(&surrogate.columns().output_names())?,
            })
        };
        let mut runs = unseen.runs().iter().map(read).collect::<Result<Vec<_>>>()?;
        // Runs without a state that is scored are omitted.
        runs.retain(|run: &RunColumns| run.scored.contains(&true));
        Ok(MemberTest { surrogate, alone, coordinate, runs })
    }

    /// The inputs of a run in row-major order, with those besides the coordinate replaced.
    fn given(&self, run: &RunColumns, given: Given) -> Vec<f64> {
        let rows = run.scored.len();
        let order = match given {
            Given::Permuted(seed) => permutation(&run.groups, seed),
            _ => (0..rows).collect(),
        };
        let value = |row: usize, input: usize| match (given, self.coordinate) {
            (_, Some(coordinate)) if coordinate == input => run.inputs[input][row],
            (Given::OfRun(other), Some(coordinate)) => {
                let other = &self.runs[other];
                interpolated(run.inputs[coordinate][row], &other.inputs[coordinate], &other.inputs[input])
            }
            _ => run.inputs[input][order[row]],
        };
        let inputs = run.inputs.len();
        (0..rows)
            .flat_map(|row| (0..inputs).map(move |input| (row, input)))
            .map(|(r, i)| value(r, i))
            .collect()
    }
}

impl InputTest for MemberTest<'_> {
    fn runs(&self) -> Vec<String> {
        self.runs.iter().map(|run| run.name.clone()).collect()
    }

    fn is_exchangeable(&self) -> bool {
        let ordered = |coordinate: usize| self.runs.iter().all(|run| never_falls(&run.inputs[coordinate]));
        self.coordinate.is_some_and(ordered)
    }

    fn error(&self, run: usize, given: Given, all: &mut Scorer) -> Result<f64> {
        let run = &self.runs[run];
        error(self.surrogate, &self.given(run, given), run, all)
    }

    fn coordinate_only_error(&self, run: usize) -> Result<f64> {
        let run = &self.runs[run];
        error(self.alone, &run.inputs_alone, run, &mut Scorer::default())
    }
}

/// The group of each state.
fn groups(stages: &[f64], xs: Option<&[f64]>, scored: &[bool], spec: &FitSpec) -> Vec<usize> {
    let count = spec.sub_models.len().max(1);
    let sub_model = |k: usize| match xs {
        Some(xs) if is_within(&spec.sub_models, xs[k], None) => sub_model_at(&spec.sub_models, xs[k]).0,
        _ => 0,
    };
    let last = stages.iter().fold(0.0f64, |most, stage| most.max(*stage)) as usize;
    let group = |k: usize| match scored[k] {
        true => stages[k] as usize * count + sub_model(k),
        false => (last + 1) * count,
    };
    (0..stages.len()).map(group).collect()
}

fn error(surrogate: &dyn Surrogate, inputs: &[f64], run: &RunColumns, all: &mut Scorer) -> Result<f64> {
    let mut own = Scorer::default();
    let outputs = surrogate.columns().outputs.len();
    let inputs = RunInputs::new(inputs.to_vec(), surrogate.columns().inputs.len(), vec![run.scored.len()])?;
    let means = surrogate.means(&inputs)?;
    let states = means.iter().zip(run.outputs.chunks_exact(outputs)).zip(&run.scored);
    for ((means, exact), _) in states.filter(|(_, scored)| **scored) {
        own.add(exact, means);
        all.add(exact, means);
    }
    Ok(own.score().relative_rmse)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input_use::permutation;
    use crate::methods::networks::SubModel;

    #[test]
    fn inputs_are_exchanged_within_stages_and_sub_models() {
        let spec = FitSpec::new(["x", "s"], ["y"]).with_coordinate("x");
        let spec = spec.with_sub_models(SubModel::divided([0.0, 50.0], &[20.0], &[3]));
        let xs: Vec<f64> = (0..60).map(f64::from).collect();
        let stages: Vec<f64> = xs.iter().map(|x| if *x < 30.0 { 1.0 } else { 2.0 }).collect();
        let scored: Vec<bool> = xs.iter().map(|x| is_within(&spec.sub_models, *x, None)).collect();
        let groups = groups(&stages, Some(&xs), &scored, &spec);
        // The first range is in the first stage only, the second in both; states beyond 50 are not scored.
        let found = [0, 19, 20, 29, 30, 50, 51, 59].map(|k| groups[k]);
        assert_eq!(found, [2, 2, 3, 3, 5, 5, 6, 6]);
        let order = permutation(&groups, 1);
        assert!(order.iter().enumerate().all(|(to, from)| groups[to] == groups[*from]));
        // What is not scored does not change the permutation of the others.
        let shorter = permutation(&groups[..51], 1);
        assert_eq!(order[..51], shorter);
    }
}
