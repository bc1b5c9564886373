//! Whether the tests can be explained at all, and whether the posterior explains them.

use granum_calibration::CalibrationError;
use granum_calibration::compared::curve::{ForwardModel, PredictedCurve};
use granum_calibration::inference::reach::{BeyondReach, beyond_reach, values_of_priors};
use granum_calibration::posterior::confirmation::Confirmed;
use granum_calibration::posterior::fit::Fit;
use granum_calibration::posterior::outcome::Outcome;
use granum_calibration::simulations::emulator::Emulator;
use granum_calibration::simulations::known::KnownRun;
use granum_calibration::simulations::simulation::parameters;
use granum_calibration::simulations::target::{TargetTest, all_curves};
use granum_io::shell::ShowPath;
use granum_report::calibration::{CalibratedCurve, curves_figure};

use super::calibration::Calibration;
use super::earlier_results::OF_POSTERIOR;
use super::results::put;
use crate::failure::Failure;

/// The figure of the curves.
const FIGURE: &str = "curves.svg";
/// Relative difference of mean stresses up to which a simulation is drawn over a test.
const SAME_STRESS: f64 = 0.05;
/// What is advised where nothing fits.
const ADVICE: &str = "look at the units and signs of the laboratory's file, at the priors, and at what the case leaves out; or leave the test out";

/// The curves of a test that are drawn over a compared quantity, by the places of the test and of the quantity.
type Lines<'a> = &'a dyn Fn(usize, usize) -> Vec<Vec<[f64; 2]>>;

impl Calibration<'_> {
    /// Ends the calibration if no values within the priors come near to the readings of a test by the surrogate. The simulations are drawn.
    /// Of `results` those of an earlier call are set aside.
    pub fn check_reach(
        &self,
        emulator: &Emulator,
        known: &[KnownRun],
        results: &[&str],
    ) -> Result<(), Failure> {
        let values = values_of_priors(&self.parameters, self.file.calibration.seed);
        let predicted: Vec<Vec<PredictedCurve>> =
            values.iter().filter_map(|values| emulator.predict(values)).collect();
        let lines = |test: usize, place: usize| -> Vec<Vec<[f64; 2]>> {
            let (target, quantity) = (&self.targets[test], self.file.calibration.quantities[place].quantity);
            let is_like = |run: &&KnownRun| {
                (run.mean_stress - target.mean_stress).abs() <= SAME_STRESS * target.mean_stress
            };
            let of_run = |run: &KnownRun| pairs(&run.curves.axial_strain, &quantity.readings(&run.curves));
            known.iter().filter(is_like).map(of_run).collect()
        };
        self.refuse_beyond(&self.beyond(&predicted), &lines, results)
    }

    /// As [`Calibration::check_reach`], by simulations alone: the predictions of the points that fill the priors.
    pub fn check_reach_of(&self, predicted: &[Vec<PredictedCurve>]) -> Result<(), Failure> {
        let mut places: Vec<(usize, usize)> = Vec::new();
        for (test, target) in self.targets.iter().enumerate() {
            places.extend(target.curves.iter().map(|(place, _)| (test, *place)));
        }
        let curves = all_curves(self.targets);
        let lines = |test: usize, place: usize| -> Vec<Vec<[f64; 2]>> {
            let Some(k) = places.iter().position(|of_curve| *of_curve == (test, place)) else {
                return Vec::new();
            };
            predicted.iter().map(|one| pairs(&curves[k].strain, &one[k].mean)).collect()
        };
        self.refuse_beyond(&self.beyond(predicted), &lines, &OF_POSTERIOR)
    }

    fn beyond(&self, predicted: &[Vec<PredictedCurve>]) -> Vec<BeyondReach> {
        let curves = all_curves(self.targets);
        beyond_reach(&curves, predicted.iter().map(Vec::as_slice), self.file.calibration.inadequacy)
    }

    fn refuse_beyond(&self, beyond: &[BeyondReach], lines: Lines, results: &[&str]) -> Result<(), Failure> {
        if beyond.is_empty() {
            return Ok(());
        }
        let mut sentences: Vec<String> = beyond.iter().map(BeyondReach::line).collect();
        sentences.push(ADVICE.into());
        // The figure of the readings and the simulations takes the place of that of an earlier posterior.
        let failure = self.without_results(CalibrationError::NothingFits(sentences).into(), results);
        let path = self.out.join(FIGURE);
        put(curves_figure(&self.without_posterior(lines)).to_svg(), &path)?;
        self.context.note(&format!("the readings and the simulations are drawn in {}", path.shown()));
        Err(failure)
    }

    /// The measured curves with simulations that fill the priors.
    fn without_posterior(&self, lines: Lines) -> Vec<CalibratedCurve> {
        let mut all = Vec::new();
        for (test, target) in self.targets.iter().enumerate() {
            for (place, curve) in &target.curves {
                let quantity = self.file.calibration.quantities[*place].quantity;
                all.push(CalibratedCurve {
                    test: target.name.clone(),
                    quantity: curve.quantity.clone(),
                    unit: quantity.unit().into(),
                    measured: pairs(&target.laboratory.axial_strain, &quantity.readings(&target.laboratory)),
                    band: Vec::new(),
                    simulated: lines(test, *place),
                });
            }
        }
        all
    }

    /// How well a posterior explains the tests that it was found from.
    pub fn fit(
        &self,
        targets: &[TargetTest],
        emulator: Option<&Emulator>,
        outcome: &Outcome,
        confirmed: &[Confirmed],
    ) -> Result<Fit, Failure> {
        let model = emulator.map(|emulator| emulator as &dyn ForwardModel);
        let (parameters, curves) = (parameters(self.file, targets), all_curves(targets));
        let inadequacy = self.file.calibration.inadequacy;
        Ok(Fit::new(&parameters, &curves, model, inadequacy, outcome, confirmed)?)
    }
}

fn pairs(xs: &[f64], ys: &[f64]) -> Vec<[f64; 2]> {
    xs.iter().zip(ys).map(|(x, y)| [*x, *y]).collect()
}
