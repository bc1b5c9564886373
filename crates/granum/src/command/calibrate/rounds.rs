//! Inference by rounds of simulations, without a surrogate.

use granum_calibration::compared::curve::{ForwardModel, PredictedCurve};
use granum_calibration::compared::sample_scatter::{SampleScatter, push_predicted};
use granum_calibration::draws::sequential::{Sequential, SequentialOptions};
use granum_calibration::inference::likelihood::Posterior;
use granum_calibration::inference::prior::Prior;
use granum_calibration::posterior::outcome::Outcome;
use granum_calibration::simulations::emulator::{at_strains, check};
use granum_calibration::simulations::simulation::{DesignPoint, Simulated, of_test};
use granum_calibration::simulations::target::all_curves;

use super::calibration::Calibration;
use super::earlier_results::OF_POSTERIOR;
use super::infer::Found;
use super::simulate::Runs;
use crate::failure::Failure;

/// The compared curves of the samples of one point, one after another, for each test; empty for a test of which no sample is used.
type PointCurves = Vec<Vec<Vec<f64>>>;

impl Calibration<'_> {
    /// Finds the posterior by rounds of simulations, and confirms it.
    pub fn by_simulations(&self) -> Result<(), Failure> {
        let table = &self.file.calibration;
        let curves = all_curves(self.targets);
        let none = |_: &[f64]| None::<Vec<PredictedCurve>>;
        let model: &dyn ForwardModel = &none;
        let posterior = Posterior::new(&self.parameters, &curves, model, table.inadequacy)?;
        let mut rounds = Sequential::new(self.parameters.len(), self.options());
        let priors: Vec<Prior> = self.parameters.iter().map(|free| free.prior).collect();
        let mut simulated: Vec<PointCurves> = Vec::new();
        while !rounds.is_settled() {
            let round = rounds.rounds() + 1;
            if round > table.rounds {
                let failure = Failure::new(format!(
                    "the posterior still moves after {} rounds (a mean by {:.2} of its deviation, {:.0} effective points); allow more rounds or \
                     runs in a round, or free less; what was simulated is kept",
                    table.rounds,
                    rounds.change(),
                    rounds.effective()
                ));
                return Err(self.without_results(failure, &OF_POSTERIOR));
            }
            let points = rounds.propose()?;
            let value = |(prior, share): (&Prior, &f64)| prior.value(*share);
            let values: Vec<Vec<f64>> =
                points.iter().map(|point| priors.iter().zip(point).map(value).collect()).collect();
            let earlier = simulated.len();
            simulated.extend(self.simulate_round(round, &values)?);
            if round == 1 {
                self.check_reach_of(&self.predictions_of(&simulated))?;
            }
            let likelihoods = self.likelihoods(&posterior, &simulated);
            rounds.judge_again(&likelihoods[..earlier])?;
            rounds.take(&points, &likelihoods[earlier..])?;
            self.context.note(&format!(
                "round {round}: {:.0} effective points; the means moved by {:.2} of their deviations at most",
                rounds.effective(),
                rounds.change()
            ));
        }
        let (points, weights) = rounds.weighted();
        let names = self.parameters.iter().map(|free| free.name.clone()).collect();
        let outcome = Outcome::from_weighted(names, &priors, &points, &weights, u64::from(table.seed));
        let samples = match table.samples {
            1 => "a simulation".to_string(),
            more => format!("{more} simulations"),
        };
        let how = format!(
            "{} rounds of {} points, each with {samples} of every test (sequential importance sampling); {:.0} effective points",
            rounds.rounds(),
            table.runs,
            rounds.effective()
        );
        let found = Found { outcome, priors, how };
        self.save_posterior(&found)?;
        let (confirmed, runs) = self.confirm(1, &found, None)?;
        let remarks = if table.samples == 1 { vec![WITHOUT_SCATTER.into()] } else { Vec::new() };
        self.finish(&found, None, &confirmed, &runs.simulated, remarks)
    }

    fn options(&self) -> SequentialOptions {
        let table = &self.file.calibration;
        let mut options = SequentialOptions::default();
        (options.points, options.seed) = (table.runs, u64::from(table.seed));
        options.least_effective = options.least_effective.min(0.25 * table.runs as f64);
        options.final_effective = options.final_effective.min(table.runs as f64);
        options
    }

    /// Simulates all tests at each point, as many samples as the file asks for.
    fn simulate_round(&self, round: usize, values: &[Vec<f64>]) -> Result<Vec<PointCurves>, Failure> {
        let tests = self.targets.len();
        let of_point = |values: &Vec<f64>| -> Vec<DesignPoint> {
            (0..tests)
                .map(|test| DesignPoint { test, values: of_test(self.file, tests, values, test) })
                .collect()
        };
        let simulations: Vec<DesignPoint> = values.iter().flat_map(of_point).collect();
        let samples = self.file.calibration.samples;
        let Runs { simulated } =
            self.simulate_samples(&format!("round-{round}"), round, &simulations, samples)?;
        simulations.chunks(tests).map(|wanted| self.point_curves(wanted, &simulated)).collect()
    }

    /// The compared curves of the samples of a point.
    fn point_curves(&self, wanted: &[DesignPoint], simulated: &[Simulated]) -> Result<PointCurves, Failure> {
        let mut all = Vec::new();
        for (wanted, target) in wanted.iter().zip(self.targets) {
            let mut samples = Vec::new();
            for one in simulated.iter().filter(|one| one.simulation == *wanted) {
                check(self.file, &one.name, &one.curves)?;
                let compared = target.curves.iter().flat_map(|(place, curve)| {
                    let quantity = self.file.calibration.quantities[*place].quantity;
                    at_strains(&one.curves, quantity, &curve.strain)
                });
                samples.push(compared.collect());
            }
            all.push(samples);
        }
        Ok(all)
    }

    /// The logarithms of the likelihood of all points, with the scatter of samples that all of them tell; minus infinity where no sample of a
    /// test is used.
    fn likelihoods(&self, posterior: &Posterior, points: &[PointCurves]) -> Vec<f64> {
        let scatters = self.scatters(points);
        let of_point = |point: &PointCurves| {
            self.prediction_of(point, &scatters)
                .map_or(f64::NEG_INFINITY, |predicted| posterior.marginal_log_likelihood(&predicted))
        };
        points.iter().map(of_point).collect()
    }

    /// The predictions of all points of which samples of every test are used.
    fn predictions_of(&self, points: &[PointCurves]) -> Vec<Vec<PredictedCurve>> {
        let scatters = self.scatters(points);
        points.iter().filter_map(|point| self.prediction_of(point, &scatters)).collect()
    }

    /// The scatter of samples of each test.
    fn scatters(&self, points: &[PointCurves]) -> Vec<Option<SampleScatter>> {
        let scatter_of = |test: usize| {
            let of_test: Vec<Vec<Vec<f64>>> = points.iter().map(|point| point[test].clone()).collect();
            SampleScatter::pooled(&of_test)
        };
        (0..self.targets.len()).map(scatter_of).collect()
    }

    /// The curves that the samples of a point predict; `None` where no sample of a test is used.
    fn prediction_of(
        &self,
        point: &PointCurves,
        scatters: &[Option<SampleScatter>],
    ) -> Option<Vec<PredictedCurve>> {
        if point.iter().any(Vec::is_empty) {
            return None;
        }
        let mut predicted = Vec::new();
        for ((samples, target), scatter) in point.iter().zip(self.targets).zip(scatters) {
            let lengths: Vec<usize> = target.curves.iter().map(|(_, curve)| curve.strain.len()).collect();
            push_predicted(&mut predicted, samples, &lengths, scatter.as_ref());
        }
        Some(predicted)
    }
}

/// What is left out where each point has one sample.
const WITHOUT_SCATTER: &str = "the scatter of samples is not in the posterior, since each point was simulated with one sample: intervals are too \
                               narrow where it matters; samples = 2 estimates it";
