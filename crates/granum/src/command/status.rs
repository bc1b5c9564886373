//! `granum status`: how far a run is.

use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;
use granum_hybrid::files::STUDY_FILE;
use granum_hybrid::keeping::Plan;
use granum_hybrid::laboratory::{CHECKPOINT, PREVIOUS_CHECKPOINT};
use granum_io::{Error, OutputFolder, Run, RunStatus};
use serde_json::{Value, json};

use super::train::Train;
use crate::context::Context;
use crate::failure::Failure;
use crate::output;
use crate::progress::readable;

/// Print how far a run, a training or every run of a reproduction is, and what to do next.
#[derive(Args)]
#[command(after_help = "Example:\n  granum status run-1\n  granum status reproduction")]
pub struct Status {
    /// Folder of a run, a training or a reproduction.
    folder: PathBuf,
}

impl Status {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        if Train::is_in(&self.folder) {
            return self.training(context);
        }
        let runs = self.folder.join("runs");
        if !runs.is_dir() {
            let found = Found::of(&self.folder)?;
            return output::say(context, &found.json(), || found.text());
        }
        let read = std::fs::read_dir(&runs).map_err(Error::file("read", &runs))?;
        // A link may lead anywhere; the runs of a reproduction are folders in it.
        let real = |entry: &std::fs::DirEntry| entry.file_type().is_ok_and(|kind| kind.is_dir());
        let mut folders: Vec<PathBuf> =
            read.filter_map(|entry| entry.ok().filter(real).map(|entry| entry.path())).collect();
        folders.sort();
        let found = folders.iter().map(|folder| Found::of(folder)).collect::<Result<Vec<_>, _>>()?;
        let done = self.folder.join("summary.json").is_file();
        let next = if done { "done; see report.html" } else { "`granum reproduce` again goes on from here" };
        let all: Vec<Value> = found.iter().map(Found::json).collect();
        let result = json!({ "folder": self.folder, "runs": all, "finished": done, "next": next });
        output::say(context, &result, || {
            let mut lines: Vec<String> = found.iter().map(Found::text).collect();
            lines.push(format!("{}: {next}", self.folder.display()));
            lines.join("\n")
        })
    }
}

impl Status {
    /// How far a training is.
    fn training(&self, context: &Context) -> Result<(), Failure> {
        let (plan, name) = (Plan::read(&self.folder)?, self.folder.display());
        let networks = plan.networks();
        let there = networks.iter().filter(|file| self.folder.join(file).is_file()).count();
        let finished = self.folder.join(STUDY_FILE).is_file();
        let at_work = OutputFolder::is_in_use(&self.folder);
        let (word, next) = match (at_work, finished) {
            (true, _) => ("running", "a process is at work in it; wait".to_string()),
            (_, true) => ("finished", format!("judge it: granum evaluate {name} RUN...")),
            _ => ("broken off", format!("go on with it: granum resume {name}")),
        };
        let result = json!({
            "folder": self.folder,
            "kind": "train",
            "status": word,
            "networks": there,
            "networks_end": networks.len(),
            "next": next,
        });
        output::say(context, &result, || {
            format!("{name}: training {word}, {there} of {} networks\n  {next}", networks.len())
        })
    }
}

/// What a run folder says of itself.
struct Found {
    folder: PathBuf,
    kind: String,
    status: RunStatus,
    /// What is or was under way, e.g. `compaction, trial 2`.
    phase: String,
    /// A process works in it.
    at_work: bool,
    steps: Value,
    seconds: f64,
    /// Deviator strain recorded, and of the end of the test.
    strain: Option<f64>,
    end: f64,
    checkpoint: Option<Duration>,
    failed_checks: Vec<String>,
    next: String,
}

impl Found {
    fn of(folder: &Path) -> Result<Found, Failure> {
        let run = Run::at(folder)?;
        let (case, record) = (run.case()?, run.record()?);
        let at_work = OutputFolder::is_in_use(folder);
        let strain = run.series().ok().and_then(|t| t.column("deviator_strain").ok()?.last().copied());
        let checkpoint = [CHECKPOINT, PREVIOUS_CHECKPOINT]
            .iter()
            .find_map(|name| std::fs::metadata(folder.join(name)).and_then(|file| file.modified()).ok())
            .map(|time| time.elapsed().unwrap_or_default());
        let name = folder.display();
        let next = match record.status {
            _ if at_work => "a process is at work in it; wait".to_string(),
            RunStatus::Finished if record.kind == "prepare" => {
                format!("shear it: granum shear CASE --sample {name}")
            }
            RunStatus::Finished => format!("look at it: granum report {name}"),
            RunStatus::Failed => format!(
                "{}; once the cause is mended go on with it: granum resume {name}; or change the case and run it again with --force",
                record.notes.last().map_or("it failed", String::as_str)
            ),
            _ if checkpoint.is_some() => format!("go on with it: granum resume {name}"),
            _ => format!("there is no checkpoint yet; begin again from its case: granum resume {name}"),
        };
        Ok(Found {
            folder: folder.to_path_buf(),
            status: record.status,
            at_work,
            steps: json!(record.steps),
            seconds: record.wall_seconds.values().sum(),
            strain: if record.kind == "prepare" { None } else { strain },
            end: case.shear.deviator_strain,
            checkpoint,
            failed_checks: record.quality.iter().filter(|q| !q.passed).map(|q| q.name.clone()).collect(),
            kind: record.kind,
            phase: record.phase,
            next,
        })
    }

    /// One word on where it is; a run that is "running" with no process at work was killed.
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
            "folder": self.folder,
            "kind": self.kind,
            "status": self.word(),
            "phase": self.phase,
            "steps": self.steps,
            "wall_seconds": self.seconds,
            "deviator_strain": self.strain,
            "deviator_strain_end": self.end,
            "checkpoint_age_seconds": self.checkpoint.map(|age| age.as_secs_f64()),
            "failed_checks": self.failed_checks,
            "next": self.next,
        })
    }

    fn text(&self) -> String {
        let mut text = format!("{}: {} {}", self.folder.display(), self.kind, self.word());
        if !self.phase.is_empty() {
            text += &format!(" in {}", self.phase);
        }
        if let Some(strain) = self.strain {
            text += &format!(", recorded to deviator strain {strain:.4} of {}", self.end);
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
        text + &format!("\n  {}", self.next)
    }
}
