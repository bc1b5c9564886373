//! One preparation or test in its folder.

use std::path::Path;

use granum::contents::{FolderKind, check_free};
use granum_io::{Case, RunFolder};
use granum_run::Laboratory;
use granum_run::laboratory::Source;
use granum_run::queue::RunKind;

use super::hardware::Show;
use super::{foreseen, run_report};
use crate::context::Context;
use crate::failure::Failure;

/// Executes a run in a new folder and prints its result.
pub fn run(
    context: &Context,
    laboratory: &Laboratory,
    kind: RunKind,
    case: &Case,
    source: &Source,
    out: &Path,
) -> Result<(), Failure> {
    let wanted = match kind {
        RunKind::Sample => FolderKind::Sample,
        RunKind::Test => FolderKind::Test,
    };
    check_free(out, wanted, context.force, context.vocabulary())?;
    // Inputs are checked before the folder is created, so that a mistake leaves no folder behind and, with --force, does
    // not delete an older run.
    let mut show = Show::new(context);
    let planned = {
        let _alone = context.nothing_written(None);
        laboratory.plan(kind, case, source, &mut show).map_err(|error| show.failure(error))?
    };
    if kind == RunKind::Test {
        foreseen::tell_one(context, case);
    }
    let folder = RunFolder::create(out, context.force)?;
    let record = planned.in_folder(&folder, &mut show)?;
    run_report::print(context, out, &record)
}
