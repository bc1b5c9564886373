//! The test whether a surrogate of a study uses its inputs.

use crate::curve::{increases, interpolated};
use crate::dataset::{Dataset, RunStates};
use crate::error::Result;
use crate::input_use::{Given, InputTest, permutation};
use crate::score::Scorer;
use crate::surrogate::{RunInputs, Surrogate};

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
    /// The stage of each state.
    stages: Vec<usize>,
}

impl<'a> MemberTest<'a> {
    pub fn new(
        surrogate: &'a dyn Surrogate,
        alone: &'a dyn Surrogate,
        coordinate: Option<usize>,
        unseen: &Dataset,
    ) -> Result<MemberTest<'a>> {
        let read = |run: &RunStates| {
            let one = Dataset::new(vec![run.clone()])?;
            let names = surrogate.columns().input_names();
            let inputs = names.iter().map(|name| run.column(name));
            Ok(RunColumns {
                name: run.name().to_owned(),
                inputs: inputs.collect::<Result<_>>()?,
                inputs_alone: one.values(&alone.columns().input_names())?,
                outputs: one.values(&surrogate.columns().output_names())?,
                stages: run.column("stage")?.iter().map(|stage| *stage as usize).collect(),
            })
        };
        let runs = unseen.runs().iter().map(read).collect::<Result<_>>()?;
        Ok(MemberTest { surrogate, alone, coordinate, runs })
    }

    /// The inputs of a run in row-major order, with those besides the coordinate replaced.
    fn given(&self, run: &RunColumns, given: Given) -> Vec<f64> {
        let rows = run.stages.len();
        let order = match given {
            Given::Permuted(seed) => permutation(&run.stages, seed),
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
        let ordered = |coordinate: usize| self.runs.iter().all(|run| increases(&run.inputs[coordinate]));
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

fn error(surrogate: &dyn Surrogate, inputs: &[f64], run: &RunColumns, all: &mut Scorer) -> Result<f64> {
    let mut own = Scorer::default();
    let outputs = surrogate.columns().outputs.len();
    let inputs = RunInputs::new(inputs.to_vec(), surrogate.columns().inputs.len(), vec![run.stages.len()])?;
    for (prediction, exact) in surrogate.predict(&inputs, 0.5)?.iter().zip(run.outputs.chunks_exact(outputs))
    {
        let means: Vec<f64> = prediction.values.iter().map(|estimate| estimate.mean).collect();
        own.add(exact, &means);
        all.add(exact, &means);
    }
    Ok(own.score().relative_rmse)
}
