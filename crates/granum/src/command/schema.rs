//! `granum schema`: the JSON schema of case files, for editors.

use clap::Args;
use granum_io::Case;

use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// Print the JSON schema of a case file: every key with its meaning, bounds and default, for editors and other programs.
#[derive(Args)]
#[command(after_help = "Example:\n  granum schema > granum-case.schema.json")]
pub struct Schema {}

impl Schema {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        let schema = Case::schema();
        // The schema is JSON in any case, and nothing is added to it.
        let text = if context.json { schema.to_string() } else { serde_json::to_string_pretty(&schema)? };
        output::say_as_it_is(&text)
    }
}
