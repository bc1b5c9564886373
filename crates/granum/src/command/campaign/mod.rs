//! `granum campaign`: the runs of a plan.

mod arguments;
mod estimate;
mod execute;
mod one_run;
mod plan_text;
mod show;
mod status;

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, Subcommand};
use granum_campaign::clock::duration;

use super::checkpoints::CheckpointFlags;
use crate::context::Context;
use crate::failure::Failure;

pub use execute::resume;
pub use status::print as print_status;

/// Carry out a plan: many runs of one base case with variables over its keys, in one folder.
///
/// Every run is resolved and checked before any begins, and has a process of its own. The same command goes on after any interruption,
/// uses again what is finished, and takes a plan that was changed: runs that are still in it are kept. Runs that do not pass their checks
/// are kept and listed.
#[derive(Args)]
#[command(
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    after_help = "Example:\n  granum init --plan friction-pressure-density\n  granum campaign friction-pressure-density.toml --dry-run\n  \
                  granum campaign friction-pressure-density.toml --out study\n  granum campaign status study\n  granum report study"
)]
pub struct Campaign {
    #[command(subcommand)]
    action: Option<Action>,
    #[command(flatten)]
    plan: PlanFlags,
}

/// What can be done with a plan.
#[derive(Args)]
pub struct PlanFlags {
    /// The plan.
    #[arg(required = true)]
    plan: Option<PathBuf>,
    /// Folder of the campaign; by default the name of the plan without its ending.
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print what will be run, and an estimate of time, memory and disk from a few short pilot runs; nothing stays of them.
    #[arg(long)]
    dry_run: bool,
    /// Number of pilot runs of --dry-run; 0 for no estimate.
    #[arg(long, value_name = "N", default_value_t = 3, requires = "dry_run")]
    pilots: usize,
    /// Longest time of a pilot run; one that is not finished by then is judged by the part that it has done.
    #[arg(long, value_name = "TIME", default_value = "20 s", value_parser = duration, requires = "dry_run")]
    pilot_time: Duration,
    /// Print a command for each run, to be executed anywhere in any order, and run nothing here.
    #[arg(long, conflicts_with_all = ["dry_run", "collect"])]
    list_jobs: bool,
    /// Take up what such commands have done, and run nothing here.
    #[arg(long, conflicts_with = "dry_run")]
    collect: bool,
    #[command(flatten)]
    carry_out: CarryOutFlags,
}

/// How runs are carried out.
#[derive(Args, Clone, Debug)]
pub struct CarryOutFlags {
    /// Number of runs at once, each on one thread; by default as many as there are processors and the memory can hold.
    #[arg(long, value_name = "N")]
    workers: Option<usize>,
    /// End all runs in good order after this time, e.g. 8 h; the same command goes on.
    #[arg(long, value_name = "TIME", value_parser = duration)]
    stop_after: Option<Duration>,
    /// Also try runs again that failed for a reason that lies in their case.
    #[arg(long)]
    again: bool,
    #[command(flatten)]
    checkpoints: CheckpointFlags,
}

/// Actions on the folder of a campaign.
#[derive(Subcommand)]
enum Action {
    /// Print how far a campaign is.
    Status(status::Status),
    /// Execute runs of a campaign here, by their names.
    #[command(hide = true)]
    Run(one_run::OneRun),
}

impl Campaign {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        match &self.action {
            Some(Action::Status(status)) => status.run(context),
            Some(Action::Run(run)) => run.run(context),
            None => execute::run(context, &self.plan),
        }
    }
}
