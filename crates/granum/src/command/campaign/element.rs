//! The runs of an element of a job, as a cluster executes it.

use std::path::Path;

use granum_campaign::execution::{CampaignObserver, execute_element};
use granum_campaign::journal::LineWriter;
use granum_campaign::scheduler::{JobRecord, element_journal};
use granum_run::Flow;

use super::flags::CarryOutFlags;
use super::folder::campaign_in;
use super::{arguments, scheduling};
use crate::command::checkpoints::CheckpointFlags;
use crate::context::Context;
use crate::failure::{Failure, Interrupted};

/// Executes the runs of an element.
pub fn run(
    context: &Context,
    folder: &Path,
    job: usize,
    element: usize,
    checkpoints: &CheckpointFlags,
) -> Result<(), Failure> {
    let campaign = campaign_in(context, folder)?;
    let record = JobRecord::read(folder, job)?;
    let names = record.elements.get(element).ok_or_else(|| {
        Failure::new(format!(
            "the job {job} has {} elements, from 0, and no element {element}",
            record.elements.len()
        ))
    })?;
    let flags = CarryOutFlags::resumed(checkpoints);
    let executor = scheduling::executor(context, folder, &flags)?;
    let laboratory = arguments::laboratory(context, 1, checkpoints)?;
    let at_once = (processors() / campaign.processors_of_a_run()).max(1);
    let journal = LineWriter::open(&element_journal(folder, job, element))?;
    let ended = execute_element(&campaign, names, journal, &executor, &laboratory, at_once, &Watch(context))?;
    let failed: Vec<String> =
        ended.iter().filter_map(|(name, why)| Some(format!("{name}: {}", why.as_ref()?))).collect();
    if !failed.is_empty() {
        return Err(Failure::new(failed.join("\n")));
    }
    if ended.is_empty() {
        return Ok(());
    }
    Err(Interrupted { left: format!("{} runs of the element are left", ended.len()) }.into())
}

/// The processors that Slurm gave to the element.
fn processors() -> usize {
    let count = std::env::var("SLURM_CPUS_PER_TASK").ok().and_then(|text| text.parse().ok());
    count.unwrap_or(1)
}

/// Shows warnings and stops at a signal.
struct Watch<'a>(&'a Context);

impl CampaignObserver for Watch<'_> {
    fn warn(&self, text: &str) {
        self.0.warn(text);
    }

    fn flow(&self) -> Flow {
        self.0.flow()
    }
}
