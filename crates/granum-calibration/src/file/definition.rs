//! What the file of a calibration says.

use std::ops::Range;

use granum_campaign::plan::{Plan, in_steps};

use crate::compared::curve::MeasurementError;
use crate::compared::quantity::Quantity;
use crate::inference::likelihood::Discrepancy;
use crate::inference::prior::Prior;

/// A calibration as it is written. [`CalibrationFile::read`] reads it.
#[derive(Clone, Debug)]
pub struct CalibrationFile {
    /// The base case, the keys that all runs have, and all variables, without any run.
    pub plan: Plan,
    /// The variables that are free.
    pub free: Vec<FreeVariable>,
    /// The variables that each test gives.
    pub conditions: Vec<(String, TestCondition)>,
    /// The table `[calibration]`.
    pub calibration: CalibrationTable,
}

/// A variable that is free.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeVariable {
    /// Its name.
    pub name: String,
    /// SI unit of its numbers; empty for pure numbers.
    pub unit: String,
    /// What is known of it beforehand, in SI units.
    pub prior: Prior,
    /// True if each test has a value of its own, false if all tests share one.
    pub own: bool,
    /// A case takes multiples of this: 1 of a key that counts; any number if there is none.
    pub step: Option<f64>,
}

impl FreeVariable {
    /// What a case gets for a value: the nearest multiple of the step that lies between the bounds of the prior.
    pub fn in_case(&self, value: f64) -> f64 {
        let Some(step) = self.step.filter(|_| value.is_finite()) else { return value };
        let [from, to] = self.prior.bounds();
        in_steps(value, Some(step), [from.unwrap_or(f64::NEG_INFINITY), to.unwrap_or(f64::INFINITY)])
    }
}

/// What a test tells of its beginning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TestCondition {
    /// The lateral stress, Pa.
    LateralStress,
    /// The effective mean stress, Pa.
    MeanStress,
    /// The void ratio.
    VoidRatio,
    /// The relative density `(e_max - e) / (e_max - e_min)` between the void ratios of the loosest and densest state of the laboratory.
    RelativeDensity,
    /// The state parameter `psi = e - e_c(p)`: the void ratio less that of the critical state at the mean stress (Been and Jefferies 1985).
    StateParameter,
}

/// The critical state line of the laboratory, `e_c = e_Gamma - lambda_c (p / 101.325 kPa)^xi` (Li and Wang 1998).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CriticalStateOfTests {
    /// e_Gamma, the void ratio without stress.
    pub void_ratio: f64,
    /// lambda_c.
    pub slope: f64,
    /// xi.
    pub exponent: f64,
}

impl CriticalStateOfTests {
    /// The void ratio of the critical state at an effective mean stress in Pa.
    pub fn at(&self, mean_stress: f64) -> f64 {
        self.void_ratio - self.slope * libm::pow(mean_stress / ATMOSPHERE, self.exponent)
    }
}

/// The pressure of the atmosphere, Pa.
const ATMOSPHERE: f64 = 101_325.0;

impl TestCondition {
    /// All of them with their words.
    pub const ALL: [(TestCondition, &'static str); 5] = [
        (TestCondition::LateralStress, "lateral_stress"),
        (TestCondition::MeanStress, "mean_stress"),
        (TestCondition::VoidRatio, "void_ratio"),
        (TestCondition::RelativeDensity, "relative_density"),
        (TestCondition::StateParameter, "state_parameter"),
    ];
}

/// The table `[calibration]`.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationTable {
    /// Names of the tests; empty for all tests of the laboratory's files.
    pub tests: Vec<String>,
    /// Where the names stand.
    pub tests_span: Range<usize>,
    /// The tests that are predicted, and not calibrated on.
    pub predict: PredictedTests,
    /// Where they stand.
    pub predict_span: Range<usize>,
    /// How the posterior is found.
    pub method: Method,
    /// Simulations from which the surrogate learns, of all tests together; for [`Method::Dem`] the points of a round, each with a simulation
    /// of every test.
    pub runs: usize,
    /// Samples of each simulation of a round ([`Method::Dem`]), from which the scatter of samples is estimated.
    pub samples: usize,
    /// Most rounds: of simulations ([`Method::Dem`]), or of confirmations after which the surrogate is fitted again.
    pub rounds: usize,
    /// Draws from the posterior that are simulated to confirm it.
    pub confirm: usize,
    /// Draws from the posterior that are written as a plan of a campaign.
    pub draws: usize,
    /// Number of chains.
    pub chains: usize,
    /// Most draws of each chain.
    pub most_draws: usize,
    /// Seed of the design and of the draws.
    pub seed: u32,
    /// Void ratios of the densest and the loosest state of the laboratory, e_min and e_max.
    pub void_ratio_limits: Option<[f64; 2]>,
    /// The critical state line of the laboratory.
    pub critical_state: Option<CriticalStateOfTests>,
    /// What stresses are divided by while they are learned, Pa; without it by the mean stress at the start of their test. It is for material
    /// whose strength is its own and not the confinement's, as that of cement, and for tests that begin without a stress.
    pub stress_scale: Option<f64>,
    /// Inadequacy of the model; `None` if the model is taken to be right.
    pub inadequacy: Option<Discrepancy>,
    /// What is compared.
    pub quantities: Vec<ComparedQuantity>,
}

impl CalibrationTable {
    /// What a quantity of a test is divided by while it is learned: stresses by the scale of the file, or by the mean stress, Pa, at the start
    /// of the test.
    pub fn scale(&self, quantity: Quantity, mean_stress: f64) -> f64 {
        if quantity.is_stress() { self.stress_scale.unwrap_or(mean_stress) } else { 1.0 }
    }
}

/// Tests of the laboratory's files that are predicted from a calibration on other ones.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PredictedTests {
    /// All that are not calibrated on.
    Others,
    /// Those of these names.
    Named(Vec<String>),
}

/// Why predictions with intervals need a surrogate.
pub const WHY_PREDICTIONS: &str = "a prediction with its interval asks for curves at many draws from the posterior, and simulations alone tell \
                                   them only where they were made";

impl PredictedTests {
    /// The word for all tests that are not calibrated on.
    pub const OTHERS: &'static str = "others";
}

/// How the posterior is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// By chains on a surrogate of the simulations.
    Surrogate,
    /// By rounds of simulations, without a surrogate: sequential importance sampling.
    Dem,
}

impl Method {
    /// All of them with their words.
    pub const ALL: [(Method, &'static str); 2] = [(Method::Surrogate, "surrogate"), (Method::Dem, "dem")];

    /// Its word.
    pub fn word(self) -> &'static str {
        match self {
            Method::Surrogate => "surrogate",
            Method::Dem => "dem",
        }
    }
}

/// A quantity that is compared.
#[derive(Clone, Debug, PartialEq)]
pub struct ComparedQuantity {
    /// The quantity.
    pub quantity: Quantity,
    /// Axial strains at which it is compared, rising.
    pub strains: Vec<f64>,
    /// Exponent of its likelihood.
    pub weight: f64,
    /// Error of its measurement.
    pub error: MeasurementError,
    /// Where it stands.
    pub span: Range<usize>,
}
