//! Inference: by chains on the surrogate, or by rounds of simulations.

use granum_calibration::CalibrationError;
use granum_calibration::chains::{ChainOptions, draw};
use granum_calibration::curve::{ForwardModel, PredictedCurve};
use granum_calibration::emulator::{Emulator, at_strains, check};
use granum_calibration::likelihood::{Discrepancy, Posterior};
use granum_calibration::outcome::Outcome;
use granum_calibration::prior::Prior;
use granum_calibration::sequential::{Sequential, SequentialOptions};
use granum_calibration::simulation::{DesignPoint, Simulated, of_test, parameters};
use granum_calibration::target::{TargetTest, all_curves};
use granum_core::observer::{Flow, Observer, Progress as Step};
use granum_run::laboratory::ProgressField;

use super::calibration::Calibration;
use super::simulate::Runs;
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

    /// By rounds of simulations, without a surrogate.
    pub fn by_simulations(&self) -> Result<(), Failure> {
        let table = &self.file.calibration;
        let curves = all_curves(self.targets);
        let none = |_: &[f64]| None::<Vec<PredictedCurve>>;
        let model: &dyn ForwardModel = &none;
        let posterior = Posterior::new(&self.parameters, &curves, model, table.inadequacy)?;
        let mut options = SequentialOptions::default();
        (options.points, options.seed) = (table.runs, u64::from(table.seed));
        options.least_effective = options.least_effective.min(0.25 * table.runs as f64);
        options.final_effective = options.final_effective.min(table.runs as f64);
        let mut rounds = Sequential::new(self.parameters.len(), options);
        let tests = self.targets.len();
        let priors: Vec<Prior> = self.parameters.iter().map(|free| free.prior).collect();
        while !rounds.is_settled() {
            let round = rounds.rounds() + 1;
            if round > table.rounds {
                return Err(Failure::new(format!(
                    "the posterior still moves after {} rounds (a mean by {:.2} of its deviation, {:.0} effective points); allow more rounds or \
                     runs in a round, or free less; what was simulated is kept",
                    table.rounds,
                    rounds.change(),
                    rounds.effective()
                )));
            }
            let points = rounds.propose()?;
            let values: Vec<Vec<f64>> = points
                .iter()
                .map(|point| priors.iter().zip(point).map(|(prior, share)| prior.value(*share)).collect())
                .collect();
            let of_point = |values: &Vec<f64>| -> Vec<DesignPoint> {
                (0..tests)
                    .map(|test| DesignPoint { test, values: of_test(self.file, tests, values, test) })
                    .collect()
            };
            let simulations: Vec<DesignPoint> = values.iter().flat_map(of_point).collect();
            let Runs { simulated } = self.simulate(&format!("round-{round}"), round, &simulations)?;
            let mut likelihoods = Vec::new();
            for wanted in simulations.chunks(tests) {
                likelihoods.push(self.likelihood(&posterior, wanted, &simulated)?);
            }
            rounds.take(&points, &likelihoods)?;
            self.context.note(&format!(
                "round {round}: {:.0} effective points; the means moved by {:.2} of their deviations at most",
                rounds.effective(),
                rounds.change()
            ));
        }
        let (points, weights) = rounds.weighted();
        let names = self.parameters.iter().map(|free| free.name.clone()).collect();
        let outcome = Outcome::from_weighted(names, &priors, &points, &weights, u64::from(table.seed));
        let how = format!(
            "{} rounds of {} points, each with a simulation of every test (sequential importance sampling); {:.0} effective points",
            rounds.rounds(),
            table.runs,
            rounds.effective()
        );
        let found = Found { outcome, priors, how };
        self.save_posterior(&found)?;
        let (confirmed, runs) = self.confirm(1, &found, None)?;
        self.finish(&found, None, &confirmed, &runs.simulated, Vec::new())
    }

    /// The logarithm of the likelihood of the simulations of all tests at one point; minus infinity if one of them failed.
    fn likelihood(
        &self,
        posterior: &Posterior,
        wanted: &[DesignPoint],
        simulated: &[Simulated],
    ) -> Result<f64, Failure> {
        let mut predicted = Vec::new();
        for (wanted, target) in wanted.iter().zip(self.targets) {
            let Some(one) = simulated.iter().find(|one| one.simulation == *wanted) else {
                return Ok(f64::NEG_INFINITY);
            };
            check(self.file, &one.name, &one.curves)?;
            for (place, curve) in &target.curves {
                let quantity = self.file.calibration.quantities[*place].quantity;
                let mean = at_strains(&one.curves, quantity, &curve.strain);
                predicted.push(PredictedCurve { mean, ..PredictedCurve::default() });
            }
        }
        Ok(posterior.marginal_log_likelihood(&predicted))
    }
}
