//! `granum examine designs`: which design teaches most.

use clap::Args;
use granum_learn::examine::compare_designs;

use super::question::{RunFlags, WorkFlags, about, percent, table};
use crate::context::Context;
use crate::failure::Failure;

/// Compare campaigns whose runs were placed by different designs, on the same unseen runs: Gaussian processes of curves are fitted to each, with
/// the properties in which its runs differ as inputs.
#[derive(Args)]
#[command(after_help = "Example:\n  granum examine designs factorial hypercube sobol --unseen judges")]
pub struct DesignFlags {
    #[command(flatten)]
    runs: RunFlags,
    #[command(flatten)]
    work: WorkFlags,
}

impl DesignFlags {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        self.work.check(context)?;
        let (designs, unseen) = self.runs.read_each(context)?;
        let (coordinate, outputs) = (&self.work.coordinate, &self.work.output);
        let answers = self.work.answered(context, |observer| {
            compare_designs(&designs, &unseen, coordinate, outputs, self.work.threads(), observer)
        })?;
        let head: Vec<String> =
            ["design".into(), "runs".into()].into_iter().chain(outputs.iter().cloned()).collect();
        let rows: Vec<Vec<String>> = answers
            .chunks(outputs.len().max(1))
            .map(|own| {
                let name = [own[0].design.clone(), own[0].runs.to_string()];
                name.into_iter().chain(own.iter().map(|answer| percent(&answer.error))).collect()
            })
            .collect();
        let lines = [about(&unseen), String::new()].into_iter().chain(table(&head, &rows)).collect();
        self.work.tell(context, &answers, lines)
    }
}
