//! The state of a campaign, read from its folder without disturbing who works in it.

use granum_io::{OutputFolder, Result, Run, RunStatus};

use crate::acceptance::is_accepted;
use crate::campaign::Campaign;
use crate::campaign_file::CampaignRun;
use crate::claim::is_claimed;
use crate::execution::CAMPAIGN_CLAIM;
use crate::journal::{FailedCheck, JournalEvent, last_events};
use crate::scheduler::{Jobs, Place};

/// The state of a run of a campaign.
#[derive(Clone, Debug, PartialEq)]
pub enum RunState {
    /// It has not been begun.
    NotBegun,
    /// A process is at work on it.
    Running,
    /// It was stopped or killed and is continued by the same command.
    Unfinished,
    /// It was given to a scheduler and waits.
    Queued,
    /// Its job is over before the run was finished; the same command gives it to the scheduler again.
    Lost,
    /// It is finished.
    Finished {
        /// The checks that it did not pass.
        flags: Vec<FailedCheck>,
        /// True if it is part of the data set.
        accepted: bool,
        /// Seconds of work.
        seconds: f64,
    },
    /// It failed.
    Failed {
        /// Why.
        reason: String,
    },
}

impl RunState {
    /// A word for it.
    pub fn word(&self) -> &'static str {
        match self {
            RunState::NotBegun => "not begun",
            RunState::Running => "running",
            RunState::Unfinished => "unfinished",
            RunState::Queued => "queued",
            RunState::Lost => "lost",
            RunState::Finished { flags, .. } if flags.is_empty() => "finished",
            RunState::Finished { accepted: true, .. } => "flagged, accepted",
            RunState::Finished { .. } => "flagged",
            RunState::Failed { .. } => "failed",
        }
    }
}

/// The state of a campaign.
#[derive(Clone, Debug, PartialEq)]
pub struct CampaignStatus {
    /// The state of every run, in the order of the plan.
    pub states: Vec<RunState>,
    /// True if a coordinator is at work.
    pub at_work: bool,
}

impl CampaignStatus {
    /// The state of a campaign: the journal, and the folders of runs of which it does not know the end.
    ///
    /// # Errors
    /// If the record of a run cannot be read.
    pub fn read(campaign: &Campaign) -> Result<CampaignStatus> {
        let (events, accept) = (last_events(campaign.folder()), campaign.accept());
        let rows = campaign.rows_kept()?;
        let state = |run: &CampaignRun| -> Result<RunState> {
            let name = run.name.as_str();
            let finished = |flags: Vec<FailedCheck>, seconds| RunState::Finished {
                accepted: is_accepted(&flags, &accept),
                flags,
                seconds,
            };
            let folder = campaign.folder_of(name);
            let known = events.get(name);
            let in_rows =
                || rows.head(name).filter(|_| campaign.has_rows(&rows, run)).map(|head| &head.event);
            let ended = known.filter(|event| matches!(event, JournalEvent::Finished { .. })).or_else(in_rows);
            if let Some(JournalEvent::Finished { flags, seconds }) = ended {
                return Ok(finished(flags.clone(), *seconds));
            }
            if OutputFolder::is_in_use(&folder) || is_claimed(campaign.folder(), name) {
                return Ok(RunState::Running);
            }
            // What failed here may have been finished by another process since.
            let read = || Run::at(&folder).and_then(|run| run.record());
            let record = match known {
                Some(JournalEvent::Failed { .. }) => read().ok(),
                _ if folder.join("run.json").is_file() => Some(read()?),
                _ => None,
            };
            Ok(match (record, known) {
                (Some(record), _) if record.status == RunStatus::Finished => {
                    match JournalEvent::finished(&record) {
                        JournalEvent::Finished { flags, seconds } => finished(flags, seconds),
                        _ => RunState::Unfinished,
                    }
                }
                (_, Some(JournalEvent::Failed { reason, .. })) => RunState::Failed { reason: reason.clone() },
                (Some(record), _) if record.status == RunStatus::Failed => RunState::Failed {
                    reason: record.notes.last().cloned().unwrap_or_else(|| "it failed".into()),
                },
                (Some(_), _) | (None, Some(_)) => RunState::Unfinished,
                (None, None) => RunState::NotBegun,
            })
        };
        let states = campaign.runs().iter().map(state).collect::<Result<_>>()?;
        let at_work =
            OutputFolder::is_in_use(campaign.folder()) || is_claimed(campaign.folder(), CAMPAIGN_CLAIM);
        Ok(CampaignStatus { states, at_work })
    }

    /// The same with what the scheduler of the campaign knows of its runs.
    pub fn with_jobs(mut self, campaign: &Campaign, jobs: &Jobs) -> CampaignStatus {
        for (run, state) in campaign.runs().iter().zip(&mut self.states) {
            let Some(place) = jobs.places.get(&run.name) else { continue };
            *state = match (place, &*state) {
                // A failure that its element or an earlier one told counts when its job is over.
                (_, RunState::Finished { .. }) | (Place::Over, RunState::Failed { .. }) => continue,
                (Place::Queued, _) => RunState::Queued,
                // It waits for its turn within its element.
                (Place::Running, RunState::Running) => RunState::Running,
                (Place::Running, _) => RunState::Queued,
                (Place::Over, _) => RunState::Lost,
            };
        }
        self
    }

    /// Number of runs in a state of this word.
    pub fn count(&self, word: &str) -> usize {
        self.states.iter().filter(|state| state.word() == word).count()
    }

    /// True if nothing is left to compute: every run is finished or failed.
    pub fn is_done(&self) -> bool {
        self.states.iter().all(|state| matches!(state, RunState::Finished { .. } | RunState::Failed { .. }))
    }
}
