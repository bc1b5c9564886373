//! `granum examine components`: how few numbers hold a distribution or a curve.

use clap::Args;
use granum_core::words;
use granum_learn::examine::{ComponentsAnswer, ComponentsOfCurves, ComponentsOfInputs};

use super::question::{RunFlags, WorkFlags, about, percent, table};
use crate::context::Context;
use crate::failure::Failure;

/// Learn from the first principal or independent components of a histogram in place of its bins; with --curves, Gaussian processes learn the
/// weights of so many components of each output's curve. The error on unseen runs tells how many are needed.
#[derive(Args)]
#[command(after_help = "Example:\n  granum examine components study --unseen judges --count 1,2,3,5,10\n  \
                  granum examine components study --unseen judges --curves --count 1,2,4,8")]
pub struct ComponentFlags {
    #[command(flatten)]
    runs: RunFlags,
    /// The histogram.
    #[arg(long, value_name = "NAME", default_value = "probability_density")]
    histogram: String,
    /// Components of the curves of the outputs, in place of those of a histogram.
    #[arg(long, conflicts_with_all = ["histogram", "input", "method"])]
    curves: bool,
    /// Further inputs beside the coordinate.
    #[arg(long, value_name = "COLUMN", value_delimiter = ',')]
    input: Vec<String>,
    /// The method that learns from the components.
    #[arg(long, value_name = "NAME", default_value = "boosted-trees")]
    method: String,
    /// Numbers of components.
    #[arg(long, value_name = "N", value_delimiter = ',', default_value = "1,2,3,4,6,8")]
    count: Vec<usize>,
    /// Largest number of states from which the method learns and on which it is judged; curves use all.
    #[arg(long, value_name = "N", default_value_t = 6_000, value_parser = clap::value_parser!(u64).range(100..))]
    most_states: u64,
    #[command(flatten)]
    work: WorkFlags,
}

impl ComponentFlags {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        self.work.check(context)?;
        let (training, unseen) = self.runs.read(context, self.work.seed)?;
        let (coordinate, outputs) = (self.work.coordinate.clone(), self.work.output.clone());
        let (seed, threads) = (self.work.seed, self.work.threads());
        let answers = if self.curves {
            let question =
                ComponentsOfCurves { coordinate, outputs, counts: self.count.clone(), seed, threads };
            self.work.answered(context, |observer| question.measure(&training, &unseen, observer))?
        } else {
            let question = ComponentsOfInputs {
                histogram: self.histogram.clone(),
                coordinate,
                inputs: self.input.clone(),
                outputs,
                method: self.method.clone(),
                counts: self.count.clone(),
                most_states: self.most_states as usize,
                seed,
                threads,
            };
            let methods = context.methods();
            self.work.answered(context, |observer| question.measure(&training, &unseen, methods, observer))?
        };
        let lines = [about(&unseen), String::new()].into_iter().chain(self.table(&answers)).collect();
        self.work.tell(context, &answers, lines)
    }

    fn table(&self, answers: &[ComponentsAnswer]) -> Vec<String> {
        let outputs = &self.work.output;
        let head = ["components", "kind", "variance held"].map(String::from).into_iter();
        let head: Vec<String> = head.chain(outputs.iter().cloned()).collect();
        let row = |own: &[ComponentsAnswer]| {
            let held = own[0].held.map_or("-".into(), |held| words::percent(held, 1));
            let first = [own[0].components.to_string(), own[0].kind.clone(), held];
            first.into_iter().chain(own.iter().map(|answer| percent(&answer.error))).collect()
        };
        let rows: Vec<Vec<String>> = answers.chunks(outputs.len().max(1)).map(row).collect();
        table(&head, &rows)
    }
}
