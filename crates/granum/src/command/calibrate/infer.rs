//! Inference by chains on the surrogate.

use granum_calibration::CalibrationError;
use granum_calibration::draws::chains::{ChainOptions, draw};
use granum_calibration::inference::likelihood::{Discrepancy, Posterior};
use granum_calibration::inference::prior::Prior;
use granum_calibration::posterior::outcome::Outcome;
use granum_calibration::simulations::emulator::Emulator;
use granum_calibration::simulations::simulation::parameters;
use granum_calibration::simulations::target::{TargetTest, all_curves};
use granum_core::observer::{Flow, Observer, Progress as Step};
use granum_run::laboratory::ProgressField;

use super::calibration::Calibration;
use crate::context::Context;
use crate::failure::{Failure, Interrupted};
use crate::progress::Progress;

/// A posterior that was found.
pub struct Found {
    pub outcome: Outcome,
    /// The priors of its coordinates.
    pub priors: Vec<Prior>,
    /// How it was found, in words.
    pub how: String,
}

/// Shows the progress of a step, and stops it when the user asks for it.
pub struct Show<'a> {
    context: &'a Context,
    progress: Progress,
}

impl<'a> Show<'a> {
    pub fn new(context: &'a Context, phase: &str) -> Show<'a> {
        let mut progress = context.progress();
        progress.phase(phase);
        Show { context, progress }
    }

    /// Ends the step with a permanent line.
    pub fn end(mut self, text: String) {
        self.progress.end(|| text);
    }
}

impl Observer for Show<'_> {
    fn progress(&mut self, step: &Step) -> Flow {
        self.progress.update(step.completed(), |_| vec![ProgressField::new(0, step.to_string())]);
        self.context.flow()
    }
}

impl Calibration<'_> {
    /// The error of a step, which may be that the user stopped it.
    pub fn stopped(&self, error: CalibrationError) -> Failure {
        match error {
            CalibrationError::Stopped => {
                let left = "what was simulated is kept; the same command goes on".into();
                Interrupted { left }.into()
            }
            other => other.into(),
        }
    }

    /// Draws from the posterior by chains on the surrogate.
    pub fn infer(&self, emulator: &Emulator) -> Result<Found, Failure> {
        self.infer_for("inference", emulator, self.targets, self.file.calibration.inadequacy)
    }

    /// As [`Calibration::infer`], for other targets, of which the parameters are those that they have: a variable that is own to each test is free
    /// in each of them.
    pub fn infer_for(
        &self,
        phase: &str,
        emulator: &Emulator,
        targets: &[TargetTest],
        inadequacy: Option<Discrepancy>,
    ) -> Result<Found, Failure> {
        let table = &self.file.calibration;
        let curves = all_curves(targets);
        let parameters = parameters(self.file, targets);
        let posterior = Posterior::new(&parameters, &curves, emulator, inadequacy)?;
        let mut options = ChainOptions::default();
        (options.chains, options.most_draws) = (table.chains, table.most_draws);
        (options.seed, options.threads) = (u64::from(table.seed), crate::command::hardware::processors());
        let mut show = Show::new(self.context, phase);
        let draws = draw(&posterior, &options, &mut show).map_err(|error| self.stopped(error))?;
        let outcome = Outcome::from_draws(&posterior, &draws);
        let worst = draws.agreement.iter().map(|a| a.r_hat).fold(0.0, f64::max);
        let least = draws.agreement.iter().map(|a| a.effective()).fold(f64::INFINITY, f64::min);
        let how = format!(
            "{} chains of {} draws on a surrogate of the simulations; R-hat at most {worst:.3}, effective sample size at least {least:.0}",
            table.chains,
            outcome.len() / table.chains
        );
        show.end(how.clone());
        Ok(Found { outcome, priors: posterior.priors(), how })
    }
}
