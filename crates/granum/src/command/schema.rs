//! `granum schema`: the JSON schema of case files and of plans, for editors.

use clap::Args;
use granum_campaign::plan::Plan;
use granum_io::Case;

use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// Print the JSON schema of a case file, or of a plan: every key with its meaning, bounds and default, for editors and other programs.
#[derive(Args)]
#[command(
    after_help = "Example:\n  granum schema > granum-case.schema.json\n  granum schema --plan > granum-plan.schema.json"
)]
pub struct Schema {
    /// The schema of a plan of a campaign instead.
    #[arg(long)]
    plan: bool,
}

impl Schema {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        let schema = if self.plan { Plan::schema() } else { Case::schema_with(context.vocabulary()) };
        // The schema is JSON in any case, and nothing is added to it.
        let text = if context.json { schema.to_string() } else { serde_json::to_string_pretty(&schema)? };
        output::say_as_it_is(&text)
    }
}
