//! Which runs of a campaign are part of its data set, and why the others are not.

use granum_core::digest::Digest;
use granum_io::Result;

use crate::campaign::Campaign;
use crate::status::{CampaignStatus, RunState};

/// A run that is not part of the data set.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOutRun {
    /// Its number in the plan.
    pub number: usize,
    /// `flagged`, `failed` or `unfinished`.
    pub state: &'static str,
    /// The names of the checks that it did not pass.
    pub checks: Vec<String>,
}

/// The runs by what becomes of them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Contents {
    /// The numbers of the runs that are part of the data set, in the order of the plan.
    pub taken: Vec<usize>,
    /// The others.
    pub left_out: Vec<LeftOutRun>,
}

impl Contents {
    /// From the state of a campaign.
    pub fn new(campaign: &Campaign) -> Result<Contents> {
        let status = CampaignStatus::read(campaign)?;
        let mut contents = Contents::default();
        for (number, state) in status.states.iter().enumerate() {
            let (state, checks) = match state {
                RunState::Finished { accepted: true, .. } => {
                    contents.taken.push(number);
                    continue;
                }
                RunState::Finished { flags, .. } => ("flagged", &flags[..]),
                RunState::Failed { .. } => ("failed", &[][..]),
                RunState::NotBegun
                | RunState::Running
                | RunState::Unfinished
                | RunState::Queued
                | RunState::Lost => ("unfinished", &[][..]),
            };
            let checks = checks.iter().map(|check| check.name.clone()).collect();
            contents.left_out.push(LeftOutRun { number, state, checks });
        }
        Ok(contents)
    }

    /// Number of the runs that were left out in a state.
    pub fn count(&self, state: &str) -> usize {
        self.left_out.iter().filter(|run| run.state == state).count()
    }

    /// SHA-256 of all that determines a data set: results depend on cases and version alone. A data set that was made of the same need
    /// not be made again.
    pub fn digest(&self, campaign: &Campaign) -> String {
        let mut digest = Digest::new();
        digest.text("granum data set 1");
        digest.text(env!("CARGO_PKG_VERSION"));
        digest.text(campaign.version());
        digest.text(campaign.plan_text());
        digest.text(&campaign.base().resolved_toml());
        for number in &self.taken {
            let run = &campaign.runs()[*number];
            digest.text(&run.name);
            digest.text(&run.case_digest);
        }
        for LeftOutRun { number, state, checks } in &self.left_out {
            digest.text(&campaign.runs()[*number].name);
            digest.text(state);
            checks.iter().for_each(|check| digest.text(check));
        }
        digest.finish()
    }
}
