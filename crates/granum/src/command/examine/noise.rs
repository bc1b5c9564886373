//! `granum examine noise`: what noise in the inputs costs.

use clap::Args;
use granum_learn::examine::{NoiseAnswer, NoiseInInputs, Noisy};

use super::question::{RunFlags, WorkFlags, about, percent, table};
use crate::context::Context;
use crate::failure::Failure;

/// Add normal noise to the inputs from which surrogates learn, to those of the unseen runs, or to both, and measure the errors. A level is the
/// standard deviation of the noise over that of each input. An input that is constant in a run has one noise for the run; the coordinate has none.
#[derive(Args)]
#[command(
    after_help = "Example:\n  granum examine noise study --unseen judges --method ridge,feed-forward --level 0,0.05,0.1,0.2,0.5"
)]
pub struct NoiseFlags {
    #[command(flatten)]
    runs: RunFlags,
    /// The inputs beside the coordinate.
    #[arg(
        long,
        value_name = "COLUMN",
        value_delimiter = ',',
        default_value = "deviator_fabric,mean_square_force,mechanical_coordination_number,sliding_fraction"
    )]
    input: Vec<String>,
    /// The methods.
    #[arg(long, value_name = "NAME", value_delimiter = ',', default_value = "ridge,boosted-trees")]
    method: Vec<String>,
    /// Levels of noise.
    #[arg(long, value_name = "X", value_delimiter = ',', default_value = "0,0.05,0.1,0.2,0.5")]
    level: Vec<f64>,
    /// Largest number of states from which a surrogate learns and on which it is judged.
    #[arg(long, value_name = "N", default_value_t = 6_000, value_parser = clap::value_parser!(u64).range(100..))]
    most_states: u64,
    #[command(flatten)]
    work: WorkFlags,
}

impl NoiseFlags {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        self.work.check(context)?;
        let (training, unseen) = self.runs.read(context, self.work.seed)?;
        let question = NoiseInInputs {
            coordinate: self.work.coordinate.clone(),
            inputs: self.input.clone(),
            outputs: self.work.output.clone(),
            methods: self.method.clone(),
            levels: self.level.clone(),
            most_states: self.most_states as usize,
            seed: self.work.seed,
            threads: self.work.threads(),
        };
        let answers = self.work.answered(context, |observer| {
            question.measure(&training, &unseen, context.methods(), observer)
        })?;
        let mut lines = vec![about(&unseen)];
        for output in &self.work.output {
            lines.extend([String::new(), output.clone()]);
            lines.extend(self.table(&answers, output));
        }
        self.work.tell(context, &answers, lines)
    }

    fn table(&self, answers: &[NoiseAnswer], output: &str) -> Vec<String> {
        let head = ["method", "noise in"].map(String::from).into_iter();
        let head: Vec<String> = head.chain(self.level.iter().map(|level| format!("level {level}"))).collect();
        let mut rows = Vec::new();
        for method in &self.method {
            for (noisy, word) in
                [(Noisy::Training, "training"), (Noisy::Unseen, "unseen runs"), (Noisy::Both, "both")]
            {
                let own = |answer: &&NoiseAnswer| {
                    answer.method == *method && answer.noisy == noisy && answer.output == output
                };
                let errors = answers.iter().filter(own).map(|answer| percent(&answer.error));
                rows.push([method.clone(), word.into()].into_iter().chain(errors).collect());
            }
        }
        table(&head, &rows)
    }
}
