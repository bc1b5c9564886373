//! `granum shear`: `granum run` of the test of a case.

use std::path::PathBuf;

use clap::Args;

use super::test_run::TestRun;
use crate::context::Context;
use crate::failure::Failure;

/// Prepare or read a sample, test it as its case says, and write a run folder: the same as `granum run CASE`.
///
/// Several values of a key, between commas, make several runs, as with `granum run`.
#[derive(Args)]
#[command(
    after_help = "Example:\n  granum shear my-sand.toml --out run-1\n  granum shear my-sand.toml --sample sample --out run-2\n  \
                  granum shear my-sand.toml --packing packing.csv --out run-3\n  \
                  granum shear my-sand.toml --set grains.material.friction=0.2 --seed 7 --out run-4\n  \
                  granum shear my-sand.toml --set grains.material.friction=0.2,0.4 --seed 1,2,3 --out study"
)]
pub struct Shear {
    /// The case file.
    case: PathBuf,
    #[command(flatten)]
    test: TestRun,
}

impl Shear {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        self.test.run(context, &self.case, None)
    }
}
