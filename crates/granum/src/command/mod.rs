//! The subcommands, one file each.

mod bench;
mod case_flags;
mod checkpoints;
mod compare;
mod digest;
mod evaluate;
mod export;
mod export_deck;
mod forces;
mod hardware;
mod impact;
mod init;
mod law;
mod limits;
mod measure;
mod pair;
mod predict;
mod predict_surrogate;
mod prediction_input;
mod prepare;
mod records;
mod relation;
mod report;
mod reproduce;
mod resume;
mod run;
mod run_report;
mod schema;
mod scores;
mod shear;
mod sources;
mod spread;
mod status;
mod stiffness;
mod test_run;
mod train;
mod trained_range;

use clap::Subcommand;

use crate::context::Context;
use crate::failure::Failure;

/// All subcommands. A new one is a file, a line here and a line in [`Command::run`].
#[derive(Subcommand)]
pub enum Command {
    Init(init::Init),
    Schema(schema::Schema),
    Prepare(prepare::Prepare),
    Shear(shear::Shear),
    Run(run::Run),
    Limits(limits::Limits),
    Compare(compare::Compare),
    Resume(resume::Resume),
    Status(status::Status),
    Digest(digest::Digest),
    Report(report::Report),
    Train(train::Train),
    Predict(predict::Predict),
    Evaluate(evaluate::Evaluate),
    Measure(measure::Measure),
    Stiffness(stiffness::MeasureStiffness),
    Export(export::Export),
    Forces(forces::Forces),
    Pair(pair::Pair),
    Impact(impact::Impact),
    Reproduce(reproduce::Reproduce),
    Bench(bench::Bench),
}

impl Command {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        match self {
            Command::Init(command) => command.run(context),
            Command::Schema(command) => command.run(context),
            Command::Prepare(command) => command.run(context),
            Command::Shear(command) => command.run(context),
            Command::Run(command) => command.run(context),
            Command::Limits(command) => command.run(context),
            Command::Compare(command) => command.run(context),
            Command::Resume(command) => command.run(context),
            Command::Status(command) => command.run(context),
            Command::Digest(command) => command.run(context),
            Command::Report(command) => command.run(context),
            Command::Train(command) => command.run(context),
            Command::Predict(command) => command.run(context),
            Command::Evaluate(command) => command.run(context),
            Command::Measure(command) => command.run(context),
            Command::Stiffness(command) => command.run(context),
            Command::Export(command) => command.run(context),
            Command::Forces(command) => command.run(context),
            Command::Pair(command) => command.run(context),
            Command::Impact(command) => command.run(context),
            Command::Reproduce(command) => command.run(context),
            Command::Bench(command) => command.run(context),
        }
    }
}
