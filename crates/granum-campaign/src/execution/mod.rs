//! The execution of a campaign on this machine: a coordinator gives each run a process of its own.

mod child_processes;
mod coordinator;
mod element;
mod one_run;
mod pilots;
mod recorder;
mod taking_in;

pub use child_processes::ChildProcesses;
pub use coordinator::{Coordinator, Summary};
pub use element::execute_element;
pub use one_run::execute_run;
pub use pilots::{CampaignEstimate, Pilot, PilotOptions, pilots};
pub use recorder::{CAMPAIGN_CLAIM, CampaignObserver, CampaignProgress, NoCampaignObserver, STOP_REQUEST};
