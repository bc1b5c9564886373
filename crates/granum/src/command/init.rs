//! `granum init`: a commented case file to start from.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;
use granum_io::{Case, atomic::write_atomically, check_output_file};

use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// Write a commented case file with every key at its default.
#[derive(Args)]
#[command(after_help = "Example:\n  granum init my-sand.toml\n  granum shear my-sand.toml")]
pub struct Init {
    /// Path of the case file.
    #[arg(default_value = "case.toml", value_name = "FILE")]
    path: PathBuf,
}

impl Init {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        check_output_file(&self.path, context.force)?;
        write_atomically(&self.path, |file| file.write_all(Case::template().as_bytes()))?;
        output::say(context, &serde_json::json!({ "case": self.path }), || {
            let path = self.path.display();
            format!(
                "wrote {path}, with every key at its default; change values in it and run it: granum shear {path}"
            )
        })
    }
}
