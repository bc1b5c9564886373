//! `granum campaign run`: one run of a campaign, as the coordinator starts it or a user's own scheduler.

use std::collections::BTreeSet;
use std::io::{Read, Write};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use clap::Args;
use granum_campaign::Campaign;
use granum_campaign::execution::execute_run;
use granum_campaign::message::{End, Message};
use granum_run::Flow;

use super::{arguments, element};
use crate::command::checkpoints::CheckpointFlags;
use crate::context::Context;
use crate::failure::{Failure, Interrupted};

/// Execute runs of a campaign on one thread, or continue them, by their names.
#[derive(Args)]
#[command(after_help = "Example:\n  granum campaign run study 3f2a9c11d0ab")]
pub struct OneRun {
    /// Folder of the campaign.
    folder: PathBuf,
    /// Names of runs, or of samples.
    #[arg(required_unless_present = "job")]
    names: Vec<String>,
    /// The job of which an element is executed.
    #[arg(long, value_name = "NUMBER", requires = "element", conflicts_with_all = ["names", "watched"])]
    job: Option<usize>,
    /// The element of the job, from 0.
    #[arg(long, value_name = "NUMBER", requires = "job")]
    element: Option<usize>,
    /// End in good order when the standard input is closed, and tell what happens as lines of JSON.
    #[arg(long)]
    watched: bool,
    #[command(flatten)]
    checkpoints: CheckpointFlags,
}

impl OneRun {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        if let (Some(job), Some(element)) = (self.job, self.element) {
            return element::run(context, &self.folder, job, element, &self.checkpoints);
        }
        let laboratory = arguments::laboratory(context, 1, &self.checkpoints)?;
        let closed = Arc::new(AtomicBool::new(false));
        if self.watched {
            watch_input(closed.clone());
        }
        let flow = || match context.stopped() || closed.load(Ordering::Relaxed) {
            true => Flow::Stop,
            false => Flow::Continue,
        };
        let tell = |message: &Message| match message {
            _ if self.watched => say(message),
            Message::Warning { text } => context.warn(text),
            _ => {}
        };
        let mut failed = Vec::new();
        let taken_in = self.taken_in(context)?;
        for name in self.names.iter().filter(|name| !taken_in.contains(name)) {
            match execute_run(&self.folder, name, &laboratory, &flow, &tell)? {
                End::Finished => {}
                End::Interrupted => {
                    return Err(Interrupted { left: format!("{name} goes on with the same command") }.into());
                }
                End::Failed { reason, .. } => failed.push(format!("{name}: {reason}")),
            }
        }
        if failed.is_empty() { Ok(()) } else { Err(Failure::new(failed.join("\n"))) }
    }

    /// The runs whose rows have been taken in and whose folders are gone: they are finished. A coordinator knows which they are.
    fn taken_in(&self, context: &Context) -> Result<Vec<&String>, Failure> {
        if self.watched {
            return Ok(Vec::new());
        }
        let Some(campaign) = Campaign::read(&self.folder, context.vocabulary())? else {
            return Ok(Vec::new());
        };
        let rows = campaign.rows_kept()?;
        let runs = campaign.runs().iter().filter(|run| campaign.has_rows(&rows, run));
        let names: BTreeSet<&str> = runs.map(|run| run.name.as_str()).collect();
        Ok(self.names.iter().filter(|name| names.contains(name.as_str())).collect())
    }
}

/// Notes when the standard input is closed: by the coordinator, or by the system after its end.
fn watch_input(closed: Arc<AtomicBool>) {
    thread::spawn(move || {
        let mut buffer = [0; 64];
        let mut input = std::io::stdin().lock();
        while matches!(input.read(&mut buffer), Ok(1..)) {}
        closed.store(true, Ordering::Relaxed);
    });
}

/// Tells the coordinator. If it is gone the run soon learns that from its input.
fn say(message: &Message) {
    let mut out = std::io::stdout().lock();
    let _ = out.write_all(format!("{}\n", message.line()).as_bytes()).and_then(|()| out.flush());
}
