//! The subcommands, one file each.

mod init;
#[allow(dead_code, reason = "taken by the commands forces, pair and impact")]
mod law;

use clap::Subcommand;

use crate::context::Context;
use crate::failure::Failure;

/// All subcommands. A new one is a file, a line here and a line in [`Command::run`].
#[derive(Subcommand)]
pub enum Command {
    Init(init::Init),
}

impl Command {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        match self {
            Command::Init(command) => command.run(context),
        }
    }
}
