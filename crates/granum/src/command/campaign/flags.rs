//! The flags of `granum campaign`.

use std::path::PathBuf;
use std::time::Duration;

use clap::builder::PossibleValuesParser;
use clap::{Args, Command};
use granum_campaign::clock::duration;
use granum_campaign::scheduler::{self, Schedulers};

use super::choice::AdaptiveFlags;
use crate::command::checkpoints::CheckpointFlags;
use crate::command::engine_flags::LammpsFlags;

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
    pub adaptive: AdaptiveFlags,
    #[command(flatten)]
    pub lammps: LammpsFlags,
    #[command(flatten)]
    pub carry_out: CarryOutFlags,
    #[command(flatten)]
    pub scheduler: SchedulerFlags,
}

/// Who executes the runs.
#[derive(Args, Clone, Debug)]
pub struct SchedulerFlags {
    /// Who executes the runs: this machine, or a cluster; the same command later submits what is left.
    #[arg(long, value_name = "NAME", default_value = scheduler::DEFAULT)]
    pub scheduler: String,
    /// Cluster: the time of a job, e.g. 4 h. So many runs are packed into each element of a job that they take about so long.
    #[arg(long, value_name = "TIME", value_parser = duration)]
    pub time: Option<Duration>,
    /// Cluster: number of runs in each element of a job, instead of as many as its time holds.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub per_task: Option<u32>,
    /// Cluster: the partition.
    #[arg(long, value_name = "NAME")]
    pub partition: Option<String>,
    /// Cluster: the account that is charged.
    #[arg(long, value_name = "NAME")]
    pub account: Option<String>,
    /// Cluster: a file whose lines stand at the beginning of the script of each job, such as #SBATCH and module load.
    #[arg(long, value_name = "FILE")]
    pub header: Option<PathBuf>,
}

/// The same command, whose `--scheduler` takes the schedulers that the program knows.
pub fn described(command: Command, schedulers: &Schedulers) -> Command {
    let names = PossibleValuesParser::new(schedulers.names());
    command.mut_arg("scheduler", |argument| argument.value_parser(names))
}

/// How runs are carried out.
#[derive(Args, Clone, Debug)]
pub struct CarryOutFlags {
    /// Number of runs at once, each on one thread; by default as many as there are processors and the memory can hold. On a cluster
    /// the number of elements of a job at once.
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
