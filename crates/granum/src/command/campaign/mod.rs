//! `granum campaign`: the runs of a plan.

mod adaptive;
mod arguments;
mod cancel;
mod choice;
mod element;
mod estimate;
mod execute;
mod flags;
mod folder;
mod one_run;
mod plan_text;
mod scheduling;
mod show;
mod status;

use clap::{Args, Subcommand};

use crate::context::Context;
use crate::failure::Failure;

use flags::PlanFlags;

pub use execute::{carry_out_for, resume};
pub use flags::{CarryOutFlags, described};
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

/// Actions on the folder of a campaign.
#[derive(Subcommand)]
enum Action {
    /// Print how far a campaign is.
    Status(status::Status),
    /// End all runs of a campaign that are queued or go on, in good order.
    Cancel(cancel::Cancel),
    /// Execute runs of a campaign here, by their names.
    #[command(hide = true)]
    Run(one_run::OneRun),
}

impl Campaign {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        match &self.action {
            Some(Action::Status(status)) => status.run(context),
            Some(Action::Cancel(cancel)) => cancel.run(context),
            Some(Action::Run(run)) => run.run(context),
            None => match &self.plan.adaptive.adaptive {
                Some(surrogate) => adaptive::run(context, &self.plan, surrogate),
                None => execute::run(context, &self.plan),
            },
        }
    }
}
