//! `granum campaign status`: how far a campaign is.

use std::path::{Path, PathBuf};

use clap::Args;
use granum_campaign::scheduler::{JobRecord, JobState, Jobs};
use granum_campaign::{Campaign, CampaignRun, CampaignStatus, RunState};
use granum_io::shell::{ShowPath, quoted_path};
use serde_json::{Map, Value, json};

use super::folder::campaign_in;
use super::scheduling;
use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// Number of runs that are named.
const MOST_NAMED: usize = 10;
/// The words for states, in the order in which they are counted.
const WORDS: [&str; 9] = [
    "finished",
    "flagged, accepted",
    "flagged",
    "failed",
    "running",
    "queued",
    "lost",
    "unfinished",
    "not begun",
];

/// Print how far a campaign is, which runs failed and why, and which did not pass their checks.
#[derive(Args)]
#[command(after_help = "Example:\n  granum campaign status study\n  granum campaign status study --json")]
pub struct Status {
    /// Folder of the campaign.
    folder: PathBuf,
}

impl Status {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        print(context, &campaign_in(context, &self.folder)?)
    }
}

/// Prints the state of a campaign.
pub fn print(context: &Context, campaign: &Campaign) -> Result<(), Failure> {
    let found = Found::with_jobs(campaign, scheduling::jobs(context, campaign))?;
    output::say(context, &found.json(), || found.text())
}

/// A campaign with the state of its runs.
pub struct Found<'a> {
    campaign: &'a Campaign,
    status: CampaignStatus,
    jobs: Jobs,
}

impl<'a> Found<'a> {
    pub fn read(campaign: &'a Campaign) -> Result<Found<'a>, Failure> {
        Found::with_jobs(campaign, Jobs::default())
    }

    /// The same with what a scheduler knows.
    fn with_jobs(campaign: &'a Campaign, jobs: Jobs) -> Result<Found<'a>, Failure> {
        let status = CampaignStatus::read(campaign)?.with_jobs(campaign, &jobs);
        Ok(Found { campaign, status, jobs })
    }

    /// The jobs, a line each, and what was said of those that ended too early.
    fn job_lines(&self) -> Vec<String> {
        let mut lines = Vec::new();
        for job in &self.jobs.jobs {
            let why =
                if job.reasons.is_empty() { String::new() } else { format!(" ({})", job.reasons.join(", ")) };
            lines.push(format!(
                "  job {}: {} elements queued{why}, {} running, {} done",
                job.job, job.queued, job.running, job.over
            ));
            lines.extend(job.said.iter().map(|said| format!("    {said}")));
        }
        lines
    }

    /// True if the campaign has jobs, which may be over.
    fn was_submitted(&self) -> bool {
        JobRecord::all_in(self.campaign.folder()).is_ok_and(|jobs| !jobs.is_empty())
    }

    /// True if a scheduler still has runs.
    fn is_queued(&self) -> bool {
        self.jobs.jobs.iter().any(|job| job.queued + job.running > 0)
    }

    /// The runs with their states.
    fn runs(&self) -> impl Iterator<Item = (&'a CampaignRun, &RunState)> {
        self.campaign.runs().iter().zip(&self.status.states)
    }

    /// The runs that did not pass a check, a line each.
    pub fn flagged_lines(&self) -> Vec<String> {
        let line = |(run, state): (&CampaignRun, &RunState)| match state {
            RunState::Finished { flags, accepted, .. } if !flags.is_empty() => {
                let checks: Vec<String> = flags
                    .iter()
                    .map(|flag| match flag.value {
                        Some(value) => format!("{} = {value:.3e} (limit {:.3e})", flag.name, flag.limit),
                        None => flag.name.clone(),
                    })
                    .collect();
                let taken = if *accepted { "accepted by the plan" } else { "not part of the data set" };
                Some(format!("  {} {}: {}; {taken}", run.name, self.values(run), checks.join(", ")))
            }
            _ => None,
        };
        let lines: Vec<String> = self.runs().filter_map(line).collect();
        if lines.is_empty() {
            return lines;
        }
        listed(format!("{} runs did not pass all checks:", lines.len()), lines)
    }

    fn failed_lines(&self) -> Vec<String> {
        let line = |(run, state): (&CampaignRun, &RunState)| match state {
            RunState::Failed { reason } => Some(format!("  {} {}: {reason}", run.name, self.values(run))),
            _ => None,
        };
        let lines: Vec<String> = self.runs().filter_map(line).collect();
        if lines.is_empty() { lines } else { listed(format!("{} runs failed:", lines.len()), lines) }
    }

    /// The values of a run, in parentheses.
    fn values(&self, run: &CampaignRun) -> String {
        let pairs = self.campaign.variables().iter().zip(&run.values);
        let pairs: Vec<String> =
            pairs.map(|(variable, value)| format!("{} = {value}", variable.name)).collect();
        format!("({})", pairs.join(", "))
    }

    fn text(&self) -> String {
        let folder = self.campaign.folder();
        let counts: Vec<String> = WORDS
            .iter()
            .map(|word| (self.status.count(word), word))
            .filter(|(count, _)| *count > 0)
            .map(|(count, word)| format!("{count} {word}"))
            .collect();
        let at_work = match (self.status.at_work, self.is_queued()) {
            (true, _) => "at work",
            (_, true) => "given to a scheduler",
            _ => "not at work",
        };
        let all = self.status.states.len();
        let mut lines = vec![format!("{}: {all} runs, {at_work}: {}", folder.shown(), counts.join("; "))];
        lines.extend(last_line(folder).filter(|_| self.status.at_work).map(|line| format!("  {line}")));
        lines.extend(self.job_lines());
        lines.extend(self.failed_lines());
        lines.extend(self.flagged_lines());
        let dropped = self.campaign.no_longer_planned().len();
        if dropped > 0 {
            lines.push(format!("{dropped} folders are of runs that are no longer in the plan"));
        }
        lines.push(self.next());
        lines.join("\n")
    }

    fn next(&self) -> String {
        let name = quoted_path(self.campaign.folder());
        let lost = self.status.count("lost");
        match (self.status.at_work, self.status.is_done()) {
            (true, _) => "a process is at work on it; wait".into(),
            _ if lost > 0 => {
                format!(
                    "the jobs of {lost} runs ended before them; the command with which they were submitted goes on with them"
                )
            }
            _ if self.is_queued() => "wait, and ask again; the same command submits what is then left".into(),
            (_, true) => format!("their results in a table: granum table {name}"),
            _ if self.was_submitted() => "continue it with the command with which it was submitted".into(),
            _ => format!("continue it: granum resume {name}"),
        }
    }

    fn json(&self) -> Value {
        let counts: Map<String, Value> =
            WORDS.iter().map(|word| (word.to_string(), json!(self.status.count(word)))).collect();
        let names: Vec<&str> =
            self.campaign.variables().iter().map(|variable| variable.name.as_str()).collect();
        let run = |(run, state): (&CampaignRun, &RunState)| {
            let values: Map<String, Value> =
                names.iter().zip(&run.values).map(|(name, value)| (name.to_string(), json!(value))).collect();
            let mut object = json!({ "name": run.name, "state": state.word(), "values": values });
            match state {
                RunState::Finished { flags, accepted, seconds } => {
                    object["accepted"] = json!(accepted);
                    object["seconds"] = json!(seconds);
                    object["failed_checks"] = json!(flags);
                }
                RunState::Failed { reason } => object["reason"] = json!(reason),
                _ => {}
            }
            object
        };
        let job = |job: &JobState| {
            json!({
                "job": job.job, "queued": job.queued, "running": job.running, "done": job.over, "reasons": job.reasons,
                "said": job.said,
            })
        };
        json!({
            "folder": output::path(self.campaign.folder()),
            "at_work": self.status.at_work,
            "done": self.status.is_done(),
            "counts": counts,
            "jobs": self.jobs.jobs.iter().map(job).collect::<Vec<_>>(),
            "runs": self.campaign.runs().iter().zip(&self.status.states).map(run).collect::<Vec<_>>(),
            "no_longer_planned": self.campaign.no_longer_planned(),
            "next": self.next(),
        })
    }
}

/// A heading with the first few lines below it.
fn listed(heading: String, lines: Vec<String>) -> Vec<String> {
    let more = lines.len().saturating_sub(MOST_NAMED);
    let mut all = vec![heading];
    all.extend(lines.into_iter().take(MOST_NAMED));
    if more > 0 {
        all.push(format!("  and {more} more; all of them: --json"));
    }
    all
}

/// The last line of the file of progress.
fn last_line(folder: &Path) -> Option<String> {
    let text = granum_core::input::read_text(&folder.join("progress.txt"), 1 << 26).ok()?;
    text.lines().next_back().map(str::to_string)
}
