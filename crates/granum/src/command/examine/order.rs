//! `granum examine order`: in which order runs teach most.

use clap::Args;
use granum_learn::examine::{Order, OrderAnswer, OrderOfRuns};

use super::question::{RunFlags, WorkFlags, about, percent, table};
use crate::context::Context;
use crate::failure::Failure;

/// Compare orders in which runs are learned from: that of the data, random ones, and active learning, which takes next what a surrogate of the
/// runs so far is least sure of. The training runs are the pool from which each order takes its runs; errors are those of Gaussian processes of
/// curves on unseen runs.
#[derive(Args)]
#[command(
    after_help = "Example:\n  granum examine order study --unseen judges --runs 24,48,96 --batch 8 --orders 3"
)]
pub struct OrderFlags {
    #[command(flatten)]
    runs: RunFlags,
    /// Numbers of runs; active learning chooses from the first of them on.
    #[arg(long = "runs", value_name = "N", value_delimiter = ',', default_value = "24,48,96")]
    counts: Vec<usize>,
    /// Number of runs that are chosen at once.
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u64).range(1..))]
    batch: u64,
    /// Number of random orders, and of active ones that begin with the first runs of each.
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u64).range(0..=100))]
    orders: u64,
    #[command(flatten)]
    work: WorkFlags,
}

impl OrderFlags {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        self.work.check(context)?;
        let (training, unseen) = self.runs.read(context, self.work.seed)?;
        let question = OrderOfRuns {
            coordinate: self.work.coordinate.clone(),
            outputs: self.work.output.clone(),
            counts: self.counts.clone(),
            batch: self.batch as usize,
            seeds: self.orders as usize,
            threads: self.work.threads(),
        };
        let answers =
            self.work.answered(context, |observer| question.measure(&training, &unseen, observer))?;
        let mut lines = vec![about(&unseen)];
        for output in &self.work.output {
            lines.extend([String::new(), output.clone()]);
            lines.extend(self.table(&answers, output));
        }
        self.work.tell(context, &answers, lines)
    }

    /// A line for each order, and the mean of those that differ in the seed alone.
    fn table(&self, answers: &[OrderAnswer], output: &str) -> Vec<String> {
        let head =
            ["order".to_string()].into_iter().chain(self.counts.iter().map(|count| format!("{count} runs")));
        let mut rows = Vec::new();
        for (order, word) in
            [(Order::DataSet, "as in the data"), (Order::Random, "random"), (Order::Active, "active")]
        {
            let of_count = |count: &usize| -> Vec<&OrderAnswer> {
                let own = |answer: &&OrderAnswer| {
                    answer.order == order && answer.output == output && answer.runs == *count
                };
                answers.iter().filter(own).collect()
            };
            let columns: Vec<Vec<&OrderAnswer>> = self.counts.iter().map(of_count).collect();
            let seeds = columns.first().map_or(0, Vec::len);
            for k in 0..seeds {
                let name =
                    if seeds > 1 { format!("{word}, seed {}", columns[0][k].seed) } else { word.into() };
                rows.push(
                    [name].into_iter().chain(columns.iter().map(|own| percent(&own[k].error))).collect(),
                );
            }
            if seeds > 1 {
                // Of the random orders, and of the active ones that begin as these do.
                let mean = |own: &Vec<&OrderAnswer>| {
                    let drawn = own.iter().filter(|answer| answer.seed > 0);
                    let errors: Vec<f64> = drawn.map(|answer| answer.error.relative).collect();
                    format!("{:.2}", 100.0 * errors.iter().sum::<f64>() / errors.len() as f64)
                };
                rows.push(
                    [format!("{word}, mean of seeds 1 to {}", self.orders)]
                        .into_iter()
                        .chain(columns.iter().map(mean))
                        .collect(),
                );
            }
        }
        table(&head.collect::<Vec<_>>(), &rows)
    }
}
