//! The flags of `granum campaign`.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use granum_campaign::clock::duration;

use crate::command::checkpoints::CheckpointFlags;

/// What can be done with a plan.
#[derive(Args)]
pub struct PlanFlags {
    /// The plan.
    #[arg(required = true)]
    pub plan: Option<PathBuf>,
    /// Folder of the campaign; by default the name of the plan without its ending.
    #[arg(short, long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print what will be run, and an estimate of time, memory and disk from a few short pilot runs; nothing stays of them.
    #[arg(long)]
    pub dry_run: bool,
    /// Number of pilot runs of --dry-run; 0 for no estimate.
    #[arg(long, value_name = "N", default_value_t = 3, requires = "dry_run")]
    pub pilots: usize,
    /// Longest time of a pilot run; one that is not finished by then is judged by the part that it has done.
    #[arg(long, value_name = "TIME", default_value = "20 s", value_parser = duration, requires = "dry_run")]
    pub pilot_time: Duration,
    /// Print a command for each run, to be executed anywhere in any order, and run nothing here.
    #[arg(long, conflicts_with_all = ["dry_run", "collect"])]
    pub list_jobs: bool,
    /// Take up what such commands have done, and run nothing here.
    #[arg(long, conflicts_with = "dry_run")]
    pub collect: bool,
    #[command(flatten)]
    pub carry_out: CarryOutFlags,
}

/// How runs are carried out.
#[derive(Args, Clone, Debug)]
pub struct CarryOutFlags {
    /// Number of runs at once, each on one thread; by default as many as there are processors and the memory can hold.
    #[arg(long, value_name = "N")]
    pub workers: Option<usize>,
    /// End all runs in good order after this time, e.g. 8 h; the same command goes on.
    #[arg(long, value_name = "TIME", value_parser = duration)]
    pub stop_after: Option<Duration>,
    /// Also try runs again that failed for a reason that lies in their case.
    #[arg(long)]
    pub again: bool,
    #[command(flatten)]
    pub checkpoints: CheckpointFlags,
}
