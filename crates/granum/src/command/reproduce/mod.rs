//! `granum reproduce`: reproduces the whole paper with one command.

mod many;
mod plan;
mod runs;
mod study;

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use granum::contents::{Contents, FolderKind, check_free, taken};
use granum_antony2006::PaperSummary;
use granum_antony2006::reproduction::{
    REPRODUCTION_FILE, Reproduction, ReproductionOptions, SPEED_FILE, SUMMARY_FILE,
};
use granum_io::shell::ShowPath;
use granum_io::{OutputFolder, figure_list};
use granum_learn::LearnError;
use granum_learn::networks::TIMES_FILE;
use granum_run::Laboratory;
use serde_json::json;

use self::plan::ReproductionPlan;
use super::checkpoints::CheckpointFlags;
use super::hardware::HardwareFlags;
use super::summary_file::read_summary;
use super::{scores, whole};
use crate::context::Context;
use crate::failure::Failure;
use crate::output;
use crate::progress::readable;

/// Folders inside the folder of a reproduction.
const FOLDERS: [&str; 4] = ["runs", "models", "figures", "sizes"];

/// Recompute Antony, Zhou and Wang (2006): DEM tests, soft sensors, eighteen networks, comparison, report.
///
/// As in the paper, the networks are trained on one run; two unseen runs with other seeds serve for evaluation. In addition,
/// the same networks are trained on more runs, which shows the soft sensors that then improve them. The folder stores the
/// options with which it was created: the same command, or `granum resume DIR`, continues it, and other options are refused.
#[derive(Args)]
#[command(
    after_help = "Example:\n  granum reproduce\n  granum reproduce --quick --out quick\n  granum reproduce --trainer traingdx\n  granum \
                  reproduce --training-runs 16 --out more"
)]
pub struct Reproduce {
    /// Use 1000 grains, fewer states and a faster test: shows that everything works in a few minutes of processor time; not to be
    /// cited.
    #[arg(long)]
    quick: bool,
    /// Folder of the results; created if it does not exist, and continued if it holds the same reproduction.
    #[arg(short, long, default_value = "reproduction", value_name = "DIR")]
    out: PathBuf,
    #[arg(long, default_value = granum_nets::trainer::NAMES[0], value_name = "NAME", help = super::train::trainers())]
    trainer: String,
    /// Number of additional training runs for the same mappings, 0 to 64 (0 omits this part); by default 8 runs of 2000
    /// grains, with --quick 4 runs of 1000 grains.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(0..=64))]
    training_runs: Option<u64>,
    /// Number of grains of every run, 50 to 1000000; by default 5000 (additional runs 2000), with --quick 1000.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(50..=1_000_000))]
    grains: Option<u64>,
    #[command(flatten)]
    checkpoints: CheckpointFlags,
    #[command(flatten)]
    hardware: HardwareFlags,
}

impl Reproduce {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        let started = Instant::now();
        granum_nets::trainer::by_name(&self.trainer, &Default::default())?;
        let laboratory = self.hardware.laboratory(context, &self.checkpoints)?;
        let plan = ReproductionPlan::new(&self.options());
        let folder = self.folder(context, &plan)?;
        if !context.force && self.is_finished(&folder, &plan, &laboratory) {
            whole::check(&self.out, &whole::faults_of_reproduction(folder.path(), true)?)?;
            // The process may have been killed between its last file and its tidying up.
            study::tidy(&folder)?;
            return self.print(context, &folder, &read_summary(folder.path())?, None);
        }
        let runs = runs::all(context, &laboratory, &plan, &self.out)?;
        let settings = study::TrainingSettings {
            options: self.options(),
            every: self.checkpoints.every()?,
            threads: self.hardware.hardware()?.threads,
        };
        let summary = study::all(context, &folder, &plan, &runs, &settings)?;
        self.print(context, &folder, &summary, Some(started))
    }

    /// The reproduction in a folder, with the options that the folder records.
    pub fn resumed(
        out: &Path,
        options: ReproductionOptions,
        checkpoints: CheckpointFlags,
        hardware: HardwareFlags,
    ) -> Reproduce {
        let ReproductionOptions { quick, trainer, training_runs, grains } = options;
        let training_runs = training_runs.map(|runs| runs as u64);
        Reproduce { quick, out: out.to_path_buf(), trainer, training_runs, grains, checkpoints, hardware }
    }

    /// The options that determine the results.
    fn options(&self) -> ReproductionOptions {
        let training_runs = self.training_runs.map(|runs| runs as usize);
        ReproductionOptions {
            quick: self.quick,
            trainer: self.trainer.clone(),
            training_runs,
            grains: self.grains,
        }
    }

    /// The output folder: a new one, that of the same reproduction, which is continued, or, with `--force`, that of any
    /// reproduction.
    fn folder(&self, context: &Context, plan: &ReproductionPlan) -> Result<OutputFolder, Failure> {
        let wanted = Reproduction::new(self.options(), plan.names());
        let Contents::Reproduction { .. } = Contents::read(&self.out, context.vocabulary())? else {
            check_free(&self.out, FolderKind::Reproduction, context.force, context.vocabulary())?;
            let folder = OutputFolder::create(&self.out, context.force)?;
            wanted.write(folder.path())?;
            return Ok(folder);
        };
        let folder = OutputFolder::open(&self.out)?;
        folder.refuse_links(&FOLDERS)?;
        let difference = match Reproduction::read(&self.out)? {
            Some(of) if of.differences(&wanted).is_empty() => return Ok(folder),
            Some(of) => format!(" that differs in {}", of.differences(&wanted).join(", ")),
            None => " whose options are not recorded".to_string(),
        };
        if !context.force {
            // The lock must be released first, since otherwise the folder would appear to be in use.
            drop(folder);
            let mut refusal =
                taken(&self.out, &Contents::read(&self.out, context.vocabulary())?, "this one", true);
            if let LearnError::Taken { holds, .. } = &mut refusal {
                holds.push_str(&difference);
            }
            return Err(refusal.into());
        }
        // Runs and networks of the same settings are used again, and the others are replaced one by one.
        let figures =
            figure_list::names(&folder.file("figures")).into_iter().map(|name| format!("figures/{name}"));
        let old: Vec<String> =
            ["report.html", SPEED_FILE, TIMES_FILE, "models/study.json", "models/seconds.json"]
                .map(String::from)
                .into_iter()
                .chain(figures)
                .chain([SUMMARY_FILE, REPRODUCTION_FILE].map(String::from))
                .collect();
        folder.replace(&old, || wanted.write(folder.path()))?;
        Ok(folder)
    }

    /// True if the reproduction is complete.
    fn is_finished(&self, folder: &OutputFolder, plan: &ReproductionPlan, laboratory: &Laboratory) -> bool {
        [SUMMARY_FILE, "report.html"].iter().all(|name| folder.file(name).is_file())
            && runs::are_finished(laboratory, folder.path(), plan)
    }

    /// Prints the result of a reproduction that finished now or earlier.
    fn print(
        &self,
        context: &Context,
        folder: &OutputFolder,
        summary: &PaperSummary,
        started: Option<Instant>,
    ) -> Result<(), Failure> {
        let (report, numbers) = (folder.file("report.html"), folder.file(SUMMARY_FILE));
        let seconds = started.map(|started| started.elapsed());
        let result = json!({
            "report": output::path(&report),
            "summary": output::path(&numbers),
            "seconds": seconds.map(|seconds| seconds.as_secs_f64()),
        });
        output::say_complete(context, &self.out, &result, || {
            let end = match seconds {
                Some(seconds) => format!("done in {}", readable(seconds)),
                None => "it was already finished; nothing was left to do".to_string(),
            };
            format!("{}\nreport: {}\nnumbers: {}\n{end}", table(summary), report.shown(), numbers.shown())
        })
    }
}

/// A table of the mappings with their errors, for the terminal.
fn table(summary: &PaperSummary) -> String {
    let mut lines = scores::lines(&summary.mappings, "seed scatter");
    if summary.speed.factor > 0.0 {
        lines.push(format!(
            "the networks are {:.0} times faster than DEM ({:.0} s against {:.2e} s)",
            summary.speed.factor, summary.speed.dem_seconds, summary.speed.network_seconds
        ));
    }
    lines.join("\n")
}
