//! Campaigns: a [`plan`] of many tests in one file, and its [`execution`], here or by another [`scheduler`], in which nothing is lost.
//!
//! ```text
//! plan.toml --> runs, each resolved and checked --> campaign folder --> a process for each run --> run folders
//! ```
//!
//! The folder of a campaign has `campaign.json` (the runs with all that determines them), `tests/` and `samples/` (their folders, which
//! are the truth about what has been computed), [`journal`] (an index of what happened, made again from the folders where it is lost) and
//! `progress.txt` (a line every minute). Which process works on a run is known by its [`claim`].

pub mod acceptance;
mod campaign;
mod campaign_file;
pub mod claim;
pub mod clock;
pub mod data_set;
pub mod execution;
mod jobs;
pub mod journal;
pub mod message;
pub mod plan;
pub mod rows;
pub mod scheduler;
mod status;

pub use campaign::{CAMPAIGN_FILE, Campaign, PlanDifference, RUNS, SAMPLES};
pub use campaign_file::{CampaignRun, VariableRecord};
pub use status::{CampaignStatus, RunState};
