//! `granum resume`: continues an interrupted run, list of runs, training or reproduction.

use std::path::{Path, PathBuf};

use clap::Args;
use granum::contents::Contents;
use granum_io::shell::ShowPath;
use granum_io::{OutputFolder, RunFolder, RunStatus};
use granum_learn::study::STUDY_FILE;
use granum_run::laboratory::SavedRun;
use serde_json::json;

use super::campaign::{self, CarryOutFlags};
use super::checkpoints::CheckpointFlags;
use super::engine_flags::LammpsFlags;
use super::hardware::{HardwareFlags, Show};
use super::reproduce::Reproduce;
use super::run_report;
use super::several_runs;
use super::train::Train;
use super::whole;
use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// Most bytes of the file of a saved run: some million grains.
const LARGEST: u64 = 4_000_000_000;

/// Continue a preparation, test, list of runs, campaign, training or reproduction that was interrupted or killed. The results are exactly those of
/// an uninterrupted run.
///
/// A run that the laboratory page saved to a file goes on in a new folder.
#[derive(Args)]
#[command(after_help = "Example:\n  granum resume run-1\n  granum resume saved-run.json --out run-2")]
pub struct Resume {
    /// The folder of the run, of several runs, of a campaign, of the training or the reproduction; or the file of a run that the laboratory page
    /// saved.
    folder: PathBuf,
    /// Folder to create for a run from a file: `run` by default.
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    checkpoints: CheckpointFlags,
    #[command(flatten)]
    lammps: LammpsFlags,
    #[command(flatten)]
    hardware: HardwareFlags,
}

impl Resume {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        if self.folder.is_file() {
            return self.saved(context);
        }
        // A resumed run continues from the contents of its folder and must not replace anything.
        let context = &context.without_force();
        if let Some(out) = &self.out {
            let (name, out) = (self.folder.shown(), out.shown());
            return Err(Failure::new(format!(
                "--out {out} is for the file of a saved run; the folder {name} is continued where it is"
            )));
        }
        match Contents::read(&self.folder, context.vocabulary())? {
            Contents::Reproduction { of: Some(of), .. } => {
                let (checkpoints, hardware) = (self.checkpoints.clone(), self.hardware.clone());
                Reproduce::resumed(&self.folder, of.options, checkpoints, hardware).run(context)
            }
            unsaid @ Contents::Reproduction { of: None, .. } => {
                let (name, next) = (self.folder.shown(), unsaid.next(&self.folder).text);
                Err(Failure::new(format!("{name}: {next}")))
            }
            Contents::Runs { list, .. } => {
                let laboratory = self.lammps.set(self.hardware.laboratory(context, &self.checkpoints)?)?;
                several_runs::resume(context, &laboratory, &list, &self.folder)
            }
            Contents::Campaign(of) => {
                campaign::resume(context, &of, &CarryOutFlags::resumed(&self.checkpoints), &self.lammps)
            }
            Contents::Training { .. } if Train::is_in(&self.folder) => self.training(context),
            _ => self.of_grains(context, &self.folder),
        }
    }

    /// Makes the folder of a run that was saved to a file, and resumes it.
    fn saved(&self, context: &Context) -> Result<(), Failure> {
        let text = granum_core::input::read_text(&self.folder, LARGEST)
            .map_err(granum_io::Error::file("read", &self.folder))?;
        let saved = SavedRun::from_json(&text, &self.folder)?;
        let out = self.out.clone().unwrap_or_else(|| "run".into());
        saved.write_into(&RunFolder::create(&out, context.force)?)?;
        self.of_grains(&context.without_force(), &out)
    }

    /// Resumes a preparation or a test.
    fn of_grains(&self, context: &Context, place: &Path) -> Result<(), Failure> {
        let laboratory = self.lammps.set(self.hardware.laboratory(context, &self.checkpoints)?)?;
        let folder = RunFolder::open(place)?;
        let before = folder.run().record().ok().filter(|record| record.status == RunStatus::Finished);
        // All files of a finished run are compared with its record; one that is written again is renamed into its place as a whole.
        let checking = before.is_some().then(|| context.nothing_written(Some("checking the files")));
        let record = laboratory.resume(&folder, &mut Show::new(context))?;
        drop(checking);
        if before.as_ref() == Some(&record) {
            return run_report::print_finished(context, place, &record);
        }
        run_report::print(context, place, &record)
    }

    /// Resumes a training.
    fn training(&self, context: &Context) -> Result<(), Failure> {
        let name = self.folder.shown();
        if self.folder.join(STUDY_FILE).is_file() {
            let contents = Contents::Training { finished: true };
            whole::check(&self.folder, &whole::faults(context, &self.folder, &contents)?)?;
            // Opening it removes a temporary file of a process that was killed at the very end; a folder that can only be read is
            // finished all the same.
            drop(OutputFolder::open(&self.folder));
            let result = json!({ "study": output::path(&self.folder), "status": "finished" });
            return output::say(context, &result, || format!("{name}: the training is finished"));
        }
        Train::resume(context, &self.folder, self.hardware.threads, self.checkpoints.clone())
    }
}
