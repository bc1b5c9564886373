//! `granum status`: the progress of a run.

use granum_io::RunKind;

use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;
use granum::contents::{Contents, Next};
use granum_core::Table;
use granum_io::run::OWN_ENGINE;
use granum_io::shell::ShowPath;
use granum_io::{OutputFolder, RunStatus};
use granum_learn::study::StudyPlan;
use granum_run::engine::Lammps;
use granum_run::laboratory::{CHECKPOINT, PREVIOUS_CHECKPOINT};
use serde_json::{Value, json};

use super::campaign;
use super::train::Train;
use super::whole;
use crate::context::Context;
use crate::failure::Failure;
use crate::output;
use crate::progress::readable;

/// Print the progress of a run, of a training or of every run of a reproduction or a list of runs, and what to do next.
#[derive(Args)]
#[command(after_help = "Example:\n  granum status run-1\n  granum status reproduction")]
pub struct Status {
    /// Folder of a run, of several runs, of a training or a reproduction.
    folder: PathBuf,
}

impl Status {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        let _alone = context.nothing_written(Some("checking the files"));
        match Contents::read(&self.folder, context.vocabulary())? {
            Contents::Campaign(of) => campaign::print_status(context, &of),
            Contents::Training { finished } => self.training(context, finished),
            contents @ (Contents::Reproduction { .. } | Contents::Runs { .. }) => {
                self.several(context, &contents)
            }
            _ => {
                let found = FolderStatus::read(context, &self.folder)?;
                output::say(context, &found.json(), || found.text())?;
                whole::check(&self.folder, &found.faults)
            }
        }
    }

    /// Prints the progress of every run of a reproduction or a list.
    fn several(&self, context: &Context, contents: &Contents) -> Result<(), Failure> {
        let next = contents.next(&self.folder);
        let (mut all, mut lines) = (Vec::new(), Vec::new());
        let mut faults = whole::faults(context, &self.folder, contents)?;
        for folder in contents.runs(&self.folder) {
            if Contents::read(&folder, context.vocabulary())? == Contents::Nothing {
                all.push(json!({ "folder": output::path(&folder), "status": "not begun" }));
                lines.push(format!("{}: not begun", folder.shown()));
                continue;
            }
            let found = FolderStatus::read(context, &folder)?;
            all.push(found.json());
            lines.push(found.text());
            faults.extend(found.faults);
        }
        lines.push(format!("{}: {}", self.folder.shown(), next.text));
        let result = json!({
            "folder": output::path(&self.folder),
            "runs": all,
            "finished": matches!(
                contents,
                Contents::Reproduction { finished: true, .. } | Contents::Runs { finished: true, .. }
            ),
            "next": next.text,
            "command": next.command,
            "faults": faults,
        });
        output::say(context, &result, || lines.join("\n"))?;
        whole::check(&self.folder, &faults)
    }

    /// Prints the progress of a training.
    fn training(&self, context: &Context, finished: bool) -> Result<(), Failure> {
        let name = self.folder.shown();
        // The surrogates of a finished reproduction have no plan.
        let surrogates = match Train::is_in(&self.folder) {
            true => StudyPlan::read(&self.folder)?.surrogates(),
            false => Vec::new(),
        };
        let there = surrogates.iter().filter(|file| self.folder.join(file).is_file()).count();
        let word = match (OutputFolder::is_in_use(&self.folder), finished) {
            (true, _) => "running",
            (_, true) => "finished",
            _ => "broken off",
        };
        let contents = Contents::Training { finished };
        let (next, faults) = (contents.next(&self.folder), whole::faults(context, &self.folder, &contents)?);
        let result = json!({
            "folder": output::path(&self.folder),
            "kind": "train",
            "status": word,
            "surrogates": there,
            "surrogates_end": surrogates.len(),
            "next": next.text,
            "command": next.command,
            "faults": faults,
        });
        output::say(context, &result, || {
            let count = match surrogates.len() {
                0 => String::new(),
                all => format!(", {there} of {all} surrogates"),
            };
            format!("{name}: training {word}{count}\n  {}", next.text)
        })?;
        whole::check(&self.folder, &faults)
    }
}

/// The status of a run folder.
struct FolderStatus {
    folder: PathBuf,
    kind: RunKind,
    status: RunStatus,
    /// The engine and its version, where it is not granum's own.
    engine: Option<String>,
    /// The current or last phase, e.g. `compaction, trial 2`.
    phase: String,
    /// True if a process is working in the folder.
    at_work: bool,
    steps: Value,
    seconds: f64,
    /// Deviator strain of the last recorded state, and (`end`) that at the end of the test, if the test is one stage that ends at a
    /// deviator strain.
    strain: Option<f64>,
    end: Option<f64>,
    /// Number of the states recorded so far; `None` for a sample.
    states: Option<usize>,
    checkpoint: Option<Duration>,
    failed_checks: Vec<String>,
    /// Files that are missing or are not those that the run wrote.
    faults: Vec<String>,
    next: Next,
}

impl FolderStatus {
    fn read(context: &Context, folder: &Path) -> Result<FolderStatus, Failure> {
        let run = context.run_at(folder)?;
        let (case, record) = (run.case()?, run.record()?);
        let at_work = OutputFolder::is_in_use(folder);
        let faults = whole::faults_of_run(&run)?;
        let series = if record.kind == RunKind::Test { run.series().ok() } else { None };
        let strain = series.as_ref().and_then(|t| t.column("deviator_strain").ok()?.last().copied());
        let states = (record.kind == RunKind::Test).then(|| series.as_ref().map_or(0, Table::rows));
        // Another engine keeps its own restart files.
        let own = record.engine == OWN_ENGINE;
        let checkpoint = (!own)
            .then(|| Lammps::last_restart(folder))
            .flatten()
            .or_else(|| {
                let names = [CHECKPOINT, PREVIOUS_CHECKPOINT];
                names.iter().find_map(|name| {
                    std::fs::metadata(folder.join(name)).and_then(|file| file.modified()).ok()
                })
            })
            .map(|time| time.elapsed().unwrap_or_default());
        let end = case.test_definition().deviator_strain_end().filter(|_| record.kind != RunKind::Sample);
        let contents = Contents::Run(Some(Box::new(record.clone())));
        let next = contents.next(folder);
        Ok(FolderStatus {
            folder: folder.to_path_buf(),
            status: record.status,
            at_work,
            steps: json!(record.steps),
            seconds: record.wall_seconds.values().sum(),
            strain: strain.filter(|_| end.is_some()),
            end,
            states,
            checkpoint,
            failed_checks: record.quality.iter().filter(|q| !q.passed).map(|q| q.name.clone()).collect(),
            kind: record.kind,
            phase: record.phase,
            engine: (record.engine != OWN_ENGINE)
                .then(|| format!("{} {}", record.engine, record.engine_version)),
            next,
            faults,
        })
    }

    /// One word for the status; a run that is recorded as running, but on which no process works, was killed.
    fn word(&self) -> &'static str {
        match self.status {
            _ if self.at_work => "running",
            RunStatus::Running => "killed",
            RunStatus::Interrupted => "interrupted",
            RunStatus::Finished => "finished",
            RunStatus::Failed => "failed",
        }
    }

    fn json(&self) -> Value {
        json!({
            "folder": output::path(&self.folder),
            "kind": self.kind,
            "status": self.word(),
            "phase": self.phase,
            "engine": self.engine,
            "steps": self.steps,
            "wall_seconds": self.seconds,
            "deviator_strain": self.strain,
            "deviator_strain_end": self.end,
            "states": self.states,
            "checkpoint_age_seconds": self.checkpoint.map(|age| age.as_secs_f64()),
            "failed_checks": self.failed_checks,
            "faults": self.faults,
            "next": self.next.text,
            "command": self.next.command,
        })
    }

    fn text(&self) -> String {
        let what = if self.kind == RunKind::Sample { "preparation" } else { "test" };
        let mut text = format!("{}: {what} {}", self.folder.shown(), self.word());
        if let Some(engine) = &self.engine {
            text += &format!(" (by {})", engine.trim());
        }
        if !self.phase.is_empty() {
            text += &format!(" in {}", self.phase);
        }
        if let (Some(strain), Some(end)) = (self.strain, self.end) {
            text += &format!(", recorded to deviator strain {strain:.4} of {end}");
        } else if let Some(states) = self.states.filter(|states| *states > 0) {
            text += &format!(", {states} states recorded");
        }
        if self.seconds > 0.0 {
            text += &format!(", {} of work", readable(Duration::from_secs_f64(self.seconds)));
        }
        if let Some(age) = self.checkpoint {
            text += &format!(", checkpoint {} old", readable(age));
        }
        if !self.failed_checks.is_empty() {
            text += &format!("\n  quality checks not passed: {}", self.failed_checks.join(", "));
        }
        text + &format!("\n  {}", self.next.text)
    }
}
