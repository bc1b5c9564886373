//! Flags for the threads and the instruction set of a simulation; results do not depend on them.

use clap::Args;
use granum_dem::Isa;
use granum_dem::preparation::{Phase, PreparationError};
use granum_dem::simulation::Hardware;
use std::time::{Duration, Instant};

use granum_run::laboratory::{self, Laboratory, LaboratoryError, ProgressField};
use granum_run::{Flow, SimulationObserver, SimulationProgress, Work};

use super::checkpoints::CheckpointFlags;
use crate::context::Context;
use crate::failure::{Failure, Interrupted};
use crate::progress::{Progress, Room};

/// Threads and instruction set.
#[derive(Args, Clone, Debug)]
pub struct HardwareFlags {
    /// Number of threads that share the work of a step, at most the number of processors, which is the default. Results do
    /// not depend on it.
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
    /// Instruction set: portable, avx2 or avx512; the widest by default. Results do not depend on it.
    #[arg(long, value_name = "NAME")]
    isa: Option<String>,
}

/// Number of processors of this computer.
pub fn processors() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// The instruction set of a given name, if this computer supports it.
pub fn instruction_set(name: &str) -> Result<Isa, Failure> {
    // That of WebAssembly is no choice: its modules have no other.
    let choices = || Isa::ALL.into_iter().filter(|isa| *isa != Isa::Wasm);
    let isa = choices().find(|isa| isa.name() == name).ok_or_else(|| {
        let known: Vec<&str> = choices().map(Isa::name).collect();
        let (last, others) = known.split_last().unwrap_or((&"portable", &[]));
        let known = format!("{} or {last}", others.join(", "));
        Failure::new(format!("--isa {name}: granum has no such instruction set; choose {known}"))
    })?;
    if !isa.available() {
        return Err(Failure::new(format!(
            "--isa {name}: this processor does not have that instruction set; its widest is {}",
            Isa::detect().name()
        )));
    }
    Ok(isa)
}

impl HardwareFlags {
    /// The hardware settings; the number of threads is at most the number of processors.
    pub fn hardware(&self) -> Result<Hardware, Failure> {
        let threads = match self.threads {
            Some(0) => return Err(Failure::new("--threads 0: at least one thread is needed")),
            Some(n) if n > 1024 => {
                return Err(Failure::new(format!(
                    "--threads {n}: at most 1024 threads are possible; the number of cores is best"
                )));
            }
            // With more threads than processors, the threads would wait for each other in every step.
            Some(n) => n.min(processors()),
            None => processors(),
        };
        let isa = match &self.isa {
            None => Isa::detect(),
            Some(name) => instruction_set(name)?,
        };
        Ok(Hardware { threads, isa })
    }

    /// A laboratory with these settings; warns if it has fewer threads than requested.
    pub fn laboratory(
        &self,
        context: &Context,
        checkpoints: &CheckpointFlags,
    ) -> Result<Laboratory, Failure> {
        let mut laboratory = Laboratory::new(self.hardware()?, env!("CARGO_PKG_VERSION"))
            .with_registry(context.run_registry());
        laboratory.resources.checkpoint_every = checkpoints.every()?;
        let used = laboratory.resources.hardware.threads;
        if let Some(asked) = self.threads.filter(|asked| *asked > used) {
            context.warn(&format!(
                "--threads {asked}: this machine has {used} {}, and more threads would only wait for each other; \
                 {used} {} used; results do not depend on it",
                if used == 1 { "processor" } else { "processors" },
                if used == 1 { "is" } else { "are" },
            ));
        }
        if self.threads.is_some() {
            // A requested number of threads is used even if fewer would be faster.
            laboratory.resources.grains_per_thread = 1;
        }
        Ok(laboratory)
    }
}

/// Shows the progress of a run and stops it when the user asks for it.
pub struct Show<'a> {
    context: &'a Context,
    progress: Progress,
    phase: String,
    placing_since: Option<Instant>,
}

/// Time after which the placing of grains is shown: it is over sooner for most samples.
const PLACING_SHOWN_AFTER: Duration = Duration::from_secs(1);

impl<'a> Show<'a> {
    pub fn new(context: &'a Context) -> Show<'a> {
        Show { context, progress: context.progress(), phase: String::new(), placing_since: None }
    }

    /// The failure of work of which nothing has been written yet: an interruption, if the user asked for it.
    pub fn failure(&self, error: LaboratoryError) -> Failure {
        match error {
            LaboratoryError::Preparation(PreparationError::Stopped { phase }) if self.context.stopped() => {
                let left = format!("nothing was written (it was in the {})", phase.name());
                Interrupted { left }.into()
            }
            LaboratoryError::Stopped { phase } if self.context.stopped() => {
                Interrupted { left: format!("nothing was written (it was in the {phase})") }.into()
            }
            error => error.into(),
        }
    }

    fn begin(&mut self, phase: &str) {
        if self.phase != phase {
            self.phase = phase.to_string();
            self.progress.phase(self.phase.clone());
        }
    }

    fn placing(&mut self, placed: usize, count: usize) {
        let since = *self.placing_since.get_or_insert_with(Instant::now);
        if since.elapsed() < PLACING_SHOWN_AFTER {
            return;
        }
        self.begin(Phase::Placing.name());
        let share = placed as f64 / count.max(1) as f64;
        self.progress
            .update(Some(share), |_| vec![ProgressField::new(0, format!("{placed} of {count} grains"))]);
    }
}

impl SimulationObserver for Show<'_> {
    fn progress(&mut self, progress: &SimulationProgress) -> Flow {
        self.placing_since = None;
        self.begin(progress.phase.name());
        self.progress.update(progress.fraction, |room| match room {
            Room::Line => vec![ProgressField::new(0, laboratory::line(progress))],
            Room::Screen => laboratory::fields(progress),
        });
        self.context.flow()
    }
    fn work(&mut self, work: &Work) -> Flow {
        match work {
            Work::Placing { placed, count } => self.placing(*placed, *count),
            Work::Steps(progress) => return self.progress(progress),
            Work::Elsewhere(report) => {
                self.begin(&report.activity);
                self.progress.update(report.completed(), |_| laboratory::fields_of_report(report));
            }
            _ => {}
        }
        self.context.flow()
    }
    fn warn(&mut self, text: &str) {
        self.progress.aside(|| self.context.warn(text));
    }
}
