//! What several tests of one material say together: a critical state line, and an envelope of their strength where grains are cohesive.
//! Only tests that can be trusted take part, and the others are named with the reason.

use granum_io::Case;
use granum_io::run::{RunRecord, RunStatus};
use granum_sensors::Record;

use super::cohesion::is_cohesive;
use super::critical_state_line::{CriticalStateLine, LateState};
use super::criticality::late_change;
use super::envelope::{PeakState, StrengthEnvelope};
use super::measures::of_run;
use super::one_material;

/// A test with all that is judged of it.
#[derive(Clone, Copy, Debug)]
pub struct Tested<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its case.
    pub case: &'a Case,
    /// Its `run.json`.
    pub about: &'a RunRecord,
    /// Its measurements.
    pub record: &'a Record,
}

/// What a test has to say to a line, and the reason if it does not take part.
#[derive(Clone, Debug, PartialEq)]
pub struct Judged<S> {
    /// Name of the test.
    pub name: String,
    /// Its state; `None` if it has none.
    pub state: Option<S>,
    /// Why it does not take part; `None` if it does.
    pub left_out: Option<String>,
}

/// The late states of tests, and the line through those that are critical.
#[derive(Clone, Debug, PartialEq)]
pub struct CriticalStates {
    /// All tests in their order.
    pub tests: Vec<Judged<LateState>>,
    /// The line through the critical states.
    pub line: Option<CriticalStateLine>,
    /// Keys by which the tests are of different materials, which have no line in common.
    pub materials_differ_in: Vec<String>,
}

/// The largest deviator stresses of tests of cohesive grains, and the envelope of those that passed their checks.
#[derive(Clone, Debug, PartialEq)]
pub struct Envelopes {
    /// All tests in their order.
    pub tests: Vec<Judged<PeakState>>,
    /// The envelope.
    pub envelope: Option<StrengthEnvelope>,
}

/// The states that take part.
pub fn taking_part<S: Copy>(tests: &[Judged<S>]) -> Vec<S> {
    tests.iter().filter(|test| test.left_out.is_none()).filter_map(|test| test.state).collect()
}

/// The states that do not.
pub fn left_out<S: Copy>(tests: &[Judged<S>]) -> Vec<S> {
    tests.iter().filter(|test| test.left_out.is_some()).filter_map(|test| test.state).collect()
}

/// Why the results of a run are not used with those of others; `None` if it reached its end and passed its checks.
fn distrust(about: &RunRecord) -> Option<String> {
    if about.status != RunStatus::Finished {
        return Some("it did not reach its end".into());
    }
    let failed: Vec<String> =
        about.quality.iter().filter(|flag| !flag.passed).map(|flag| flag.name.replace('_', " ")).collect();
    (!failed.is_empty()).then(|| format!("it did not pass its checks ({})", failed.join(", ")))
}

impl CriticalStates {
    /// Those of tests.
    pub fn of_tests(tests: &[Tested]) -> CriticalStates {
        let cases: Vec<&Case> = tests.iter().map(|test| test.case).collect();
        let materials_differ_in = one_material::differing(&cases);
        let tests: Vec<Judged<LateState>> = tests.iter().map(judged).collect();
        let line =
            CriticalStateLine::through(&taking_part(&tests)).filter(|_| materials_differ_in.is_empty());
        CriticalStates { tests, line, materials_differ_in }
    }
}

/// The late state of a test with the reason if it is not critical.
fn judged(test: &Tested) -> Judged<LateState> {
    let measures = of_run(test.case, test.about, test.record);
    let value = |name: &str| measures.get(name).copied();
    let state = value("critical_mean_stress")
        .zip(value("critical_void_ratio"))
        .map(|(mean_stress, void_ratio)| LateState { mean_stress, void_ratio });
    let left_out = distrust(test.about).or_else(|| {
        if state.is_none() {
            let liquefied = value("liquefied") == Some(1.0);
            let why = if liquefied { "it has liquefied, so that it" } else { "it" };
            return Some(format!("{why} has no late state under steady shear"));
        }
        if value("at_critical_state") == Some(1.0) {
            return None;
        }
        Some(match late_change(test.record, &test.case.test_stages()) {
            Ok(change) => format!("it is not critical: {}", change.excess()),
            Err(why) => why,
        })
    });
    Judged { name: test.name.to_owned(), state, left_out }
}

impl Envelopes {
    /// Those of tests; `None` if none of them is of cohesive grains.
    pub fn of_tests(tests: &[Tested]) -> Option<Envelopes> {
        if !tests.iter().any(|test| is_cohesive(test.case)) {
            return None;
        }
        let cases: Vec<&Case> = tests.iter().map(|test| test.case).collect();
        let is_one_material = one_material::differing(&cases).is_empty();
        let peak = |test: &Tested| {
            let state = PeakState::of_test(test.record, &test.case.test_stages());
            let none = || state.is_none().then(|| "it is no triaxial compression".to_owned());
            Judged { name: test.name.to_owned(), state, left_out: distrust(test.about).or_else(none) }
        };
        let tests: Vec<Judged<PeakState>> = tests.iter().map(peak).collect();
        let envelope = StrengthEnvelope::through(&taking_part(&tests)).filter(|_| is_one_material);
        Some(Envelopes { tests, envelope })
    }
}

#[cfg(test)]
mod tests {
    use granum_io::run::{Machine, QualityFlag, RunKind};

    use super::super::test_records::triaxial;
    use super::*;

    fn case(more: &str) -> Case {
        let text =
            format!("grains.material.interface_energy = 0\n{more}\n[[stage]]\npath = 'drained-triaxial'\n");
        Case::parse(&text, "case.toml").unwrap()
    }

    fn about(case: &Case, failed: &[&str]) -> RunRecord {
        let mut about = RunRecord::new(RunKind::Test, "0", case, Machine::default());
        about.status = RunStatus::Finished;
        about.quality = failed.iter().map(|name| QualityFlag::at_most(*name, 2.0, 1.0, "")).collect();
        about
    }

    /// Drained tests: q/p of 1.2 at the end, approached at some rate per unit of strain.
    fn record(lateral: f64, rate: f64, solid_fraction: f64) -> Record {
        let rows = (0..=100).map(|k| {
            let x = 0.003 * f64::from(k);
            let ratio = 1.2 + rate * (x - 0.3);
            let p = lateral / (1.0 - ratio / 3.0);
            [x, -0.5 * x, p, ratio * p]
        });
        triaxial(rows, solid_fraction)
    }

    /// A line through five tests of which two are not to be trusted is that through the other three.
    #[test]
    fn the_line_is_that_of_the_critical_states_alone() {
        let case = case("contact.normal = 'hertz'");
        let good = about(&case, &[]);
        let fast = about(&case, &["inertial_number"]);
        let running = RunRecord { status: RunStatus::Interrupted, ..good.clone() };
        let records = [
            (50.0, 0.0, 0.60),
            (100.0, 0.0, 0.61),
            (400.0, 0.0, 0.63),
            (800.0, 1.0, 0.50),
            (900.0, 0.0, 0.40),
            (950.0, 0.0, 0.40),
        ]
        .map(|(lateral, rate, solid)| record(lateral, rate, solid));
        let abouts = [&good, &good, &good, &good, &fast, &running];
        let names = ["a", "b", "c", "rising", "fast", "cut"];
        let tested: Vec<Tested> = (0..6)
            .map(|k| Tested { name: names[k], case: &case, about: abouts[k], record: &records[k] })
            .collect();
        let all = CriticalStates::of_tests(&tested);
        let alone = CriticalStates::of_tests(&tested[..3]);
        assert_eq!(all.line, alone.line);
        assert_eq!(all.line.unwrap().tests, 3);
        let why = |k: usize| all.tests[k].left_out.clone().unwrap();
        assert!(all.tests[..3].iter().all(|test| test.left_out.is_none()), "{all:?}");
        assert!(why(3).contains("not critical") && why(3).contains("+0.050 in q/p"), "{}", why(3));
        assert!(why(4).contains("inertial number") && why(5).contains("did not reach its end"));
        assert_eq!((taking_part(&all.tests).len(), left_out(&all.tests).len()), (3, 3));
        assert_eq!(Envelopes::of_tests(&tested), None, "the grains are not cohesive");
    }

    #[test]
    fn cohesive_grains_have_an_envelope_of_the_tests_that_passed() {
        let case = case("contact.normal = 'jkr'").with_energy();
        let (good, fast) = (about(&case, &[]), about(&case, &["inertial_number"]));
        let records = [record(1.0, 0.0, 0.5), record(5.0, 0.0, 0.5), record(20.0, 0.0, 0.5)];
        let tested = [
            Tested { name: "a", case: &case, about: &good, record: &records[0] },
            Tested { name: "b", case: &case, about: &good, record: &records[1] },
            Tested { name: "c", case: &case, about: &fast, record: &records[2] },
        ];
        let envelopes = Envelopes::of_tests(&tested).unwrap();
        let envelope = envelopes.envelope.unwrap();
        assert!(
            (envelope.slope - 1.2).abs() < 1e-9 && envelope.intercept.abs() < 1e-6 && envelope.tests == 2
        );
        assert!(envelopes.tests[2].left_out.is_some());
    }

    trait WithEnergy {
        fn with_energy(self) -> Case;
    }

    impl WithEnergy for Case {
        fn with_energy(mut self) -> Case {
            self.set("grains.material.interface_energy", "0.01").unwrap();
            self
        }
    }
}
