//! The common part of `granum shear` and `granum run`: the source of the sample, and the output folder.

use std::path::{Path, PathBuf};

use clap::Args;
use granum_run::laboratory::Source;
use granum_run::queue::RunKind;

use super::case_flags::{CaseFlags, Loading};
use super::checkpoints::CheckpointFlags;
use super::engine_flags::EngineFlags;
use super::hardware::HardwareFlags;
use super::{several_runs, single_run};
use crate::context::Context;
use crate::failure::Failure;

#[derive(Args)]
pub struct TestRun {
    /// Folder to create: `run` by default, or `runs` for the folders of several runs.
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Use the sample that `granum prepare` wrote to this folder.
    #[arg(long, value_name = "DIR", conflicts_with = "packing")]
    sample: Option<PathBuf>,
    /// Use the grains of a packing file (CSV: id,x,y,z,radius). A loose packing is compacted as the case specifies; one that
    /// carries its load is only brought to rest.
    #[arg(long, value_name = "FILE")]
    packing: Option<PathBuf>,
    #[command(flatten)]
    flags: CaseFlags,
    #[command(flatten)]
    checkpoints: CheckpointFlags,
    #[command(flatten)]
    engine: EngineFlags,
    #[command(flatten)]
    hardware: HardwareFlags,
}

impl TestRun {
    /// Runs the test of a case file, or of a named path with its parameters in place of it, or the tests of several values.
    pub fn run(&self, context: &Context, file: &Path, path: Loading) -> Result<(), Failure> {
        let cases = self.flags.read_all(context, file, self.packing.is_some(), path)?;
        let laboratory = self.engine.set(self.hardware.laboratory(context, &self.checkpoints)?)?;
        let source = match (&self.sample, &self.packing) {
            (Some(folder), _) => Source::Folder(folder.clone()),
            (_, Some(file)) => Source::Packing(file.clone()),
            _ => Source::Case,
        };
        let out = |usual: &str| self.out.clone().unwrap_or_else(|| usual.into());
        match &cases[..] {
            [one] if one.name.is_empty() => {
                single_run::run(context, &laboratory, RunKind::Test, &one.case, &source, &out("run"))
            }
            _ => several_runs::run(context, &laboratory, RunKind::Test, cases, &source, &out("runs")),
        }
    }
}
