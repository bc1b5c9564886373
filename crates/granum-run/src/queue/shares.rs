//! The completed share of all runs of a queue.

use granum_dem::observer::SimulationProgress;
use granum_dem::preparation::Phase;

use super::outcome::Outcome;
use super::queued_run::QueuedRun;
use super::runner::Queue;
use granum_io::run::RunKind;

/// Share of the preparation in the work of a run that prepares its sample itself.
const PREPARATION_SHARE: f64 = TEST_BEGINS_AT;
/// The completed share at which the test of a run begins that prepares its sample itself.
pub const TEST_BEGINS_AT: f64 = 0.15;

/// The completed share of each run of a queue, weighed by its expected work.
#[derive(Clone, Debug, PartialEq)]
pub struct Shares {
    work: Vec<f64>,
    is_sample: Vec<bool>,
    done: Vec<f64>,
    /// The work of all runs, and what is done of it.
    sums: [f64; 2],
}

impl Shares {
    /// No run has begun.
    pub fn new(queue: &Queue) -> Shares {
        let runs = queue.runs();
        let work: Vec<f64> = runs.iter().map(QueuedRun::expected_work).collect();
        Shares {
            sums: [work.iter().sum(), 0.0],
            work,
            is_sample: runs.iter().map(|run| run.kind == RunKind::Sample).collect(),
            done: vec![0.0; runs.len()],
        }
    }

    /// Notes the progress of a run.
    pub fn update(&mut self, run: usize, progress: &SimulationProgress) {
        // The solid fraction of a sample grows from nearly nothing to about two thirds.
        let prepared = progress.state.solid_fraction();
        let share = match (progress.phase, self.is_sample[run]) {
            (Phase::Test, _) => {
                PREPARATION_SHARE + (1.0 - PREPARATION_SHARE) * progress.fraction.unwrap_or(0.0)
            }
            (_, true) => self.done[run].max(prepared),
            (_, false) => self.done[run].max(PREPARATION_SHARE * prepared),
        };
        self.change(run, share);
    }

    /// Changes the share of a run and the sum of all, which would take the longer to add up the more runs there are.
    fn change(&mut self, run: usize, share: f64) {
        self.sums[1] += self.work[run] * (share - self.done[run]);
        self.done[run] = share;
    }

    /// Notes the completed share of a run, from 0 to 1.
    pub fn set(&mut self, run: usize, share: f64) {
        self.change(run, self.done[run].max(share.clamp(0.0, 1.0)));
    }

    /// Notes the end of a run. One that was interrupted keeps its share.
    pub fn end(&mut self, run: usize, outcome: &Outcome) {
        if !outcome.is_stopped() {
            self.change(run, 1.0);
        }
    }

    /// The completed share of all runs.
    pub fn all(&self) -> f64 {
        let [all, done] = self.sums;
        if all > 0.0 { (done / all).clamp(0.0, 1.0) } else { 1.0 }
    }
}
