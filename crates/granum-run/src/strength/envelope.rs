//! The strength of cohesive grains as an envelope: the largest deviator stress against the mean stress there, in triaxial compression.
//!
//! `q = M p + c` by least squares over the tests. In the terms of Mohr and Coulomb `sin phi = 3 M / (6 + M)` and the cohesion is
//! `c (3 - sin phi) / (6 cos phi)`; the line meets q = 0 at `p = -c/M`, the isotropic tensile strength, and the path of unconfined
//! compression `p = q/3` at `q = 3 c / (3 - M)`. Extrapolated tensile strengths are upper bounds where the envelope is curved near the
//! origin (Schulze 2008, Powders and Bulk Solids).

use granum_dem::loading::Stage;
use granum_sensors::Record;

use super::critical_state_line::LEAST_RANGE;
use super::curves::Curves;
use super::regression::Regression;

/// The state of the largest deviator stress of a test in triaxial compression.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeakState {
    /// Mean stress, Pa.
    pub mean_stress: f64,
    /// Deviator stress q, Pa.
    pub deviator_stress: f64,
}

impl PeakState {
    /// That of a test with these stages; `None` if it is no triaxial compression.
    pub fn of_test(record: &Record, stages: &[Stage]) -> Option<PeakState> {
        let curves = Curves::new(record, stages);
        let rows = curves.test_rows();
        if curves.axis().is_none() || !curves.tells_strength(&rows) {
            return None;
        }
        let (q, p) = (curves.deviator_stress(), curves.mean_stress());
        let carries = curves.carry_stress(&rows);
        let states = rows.zip(carries).filter(|(row, carries)| *carries && q[*row].is_finite());
        let (row, _) = states.max_by(|a, b| q[a.0].abs().total_cmp(&q[b.0].abs()))?;
        let state = PeakState { mean_stress: *p.get(row)?, deviator_stress: q[row] };
        (state.deviator_stress > 0.0).then_some(state)
    }
}

/// A fitted envelope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrengthEnvelope {
    /// M, the slope of q over p.
    pub slope: f64,
    /// Standard error of M; `None` for two tests.
    pub slope_error: Option<f64>,
    /// c, the deviator stress at p = 0, Pa.
    pub intercept: f64,
    /// Standard error of c, Pa; `None` for two tests.
    pub intercept_error: Option<f64>,
    /// Standard deviation of q about the line, Pa; `None` for two tests.
    pub scatter: Option<f64>,
    /// Number of tests.
    pub tests: usize,
    /// Smallest and largest mean stress of the tests, Pa, beyond which the line is extrapolated.
    pub range: [f64; 2],
}

impl StrengthEnvelope {
    /// The envelope of peak states; `None` with fewer than two, if their mean stresses span less than [`LEAST_RANGE`], or if q does not
    /// grow with p.
    ///
    /// ```
    /// use granum_run::strength::envelope::{PeakState, StrengthEnvelope};
    ///
    /// let states = [2e3, 5e3, 20e3].map(|p| PeakState { mean_stress: p, deviator_stress: 1.2 * p + 3e3 });
    /// let envelope = StrengthEnvelope::through(&states).unwrap();
    /// assert!((envelope.slope - 1.2).abs() < 1e-12 && (envelope.tensile_strength() - 2500.0).abs() < 1e-9);
    /// ```
    pub fn through(states: &[PeakState]) -> Option<StrengthEnvelope> {
        let usable = |state: &&PeakState| state.mean_stress > 0.0 && state.deviator_stress.is_finite();
        let points: Vec<[f64; 2]> =
            states.iter().filter(usable).map(|state| [state.mean_stress, state.deviator_stress]).collect();
        let range =
            points.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], [p, _]| [a.min(*p), b.max(*p)]);
        if points.len() < 2 || range[1] < LEAST_RANGE * range[0] {
            return None;
        }
        let line = Regression::through(&points)?;
        (line.gradient > 0.0).then_some(StrengthEnvelope {
            slope: line.gradient,
            slope_error: line.gradient_error,
            intercept: line.intercept,
            intercept_error: line.intercept_error,
            scatter: line.scatter,
            tests: points.len(),
            range,
        })
    }

    /// The isotropic tensile strength c/M, Pa, at which the line has no deviator stress.
    pub fn tensile_strength(&self) -> f64 {
        self.intercept / self.slope
    }

    /// The sine of the friction angle; `None` for M of 3 and more, which no friction has.
    fn sine(&self) -> Option<f64> {
        (self.slope < 3.0).then(|| 3.0 * self.slope / (6.0 + self.slope))
    }

    /// The friction angle of the envelope, degrees; `None` for M of 3 and more.
    pub fn friction_angle(&self) -> Option<f64> {
        self.sine().map(|sine| libm::asin(sine).to_degrees())
    }

    /// The cohesion of Mohr and Coulomb, Pa; `None` for M of 3 and more.
    pub fn cohesion(&self) -> Option<f64> {
        let of = |sine: f64| self.intercept * (3.0 - sine) / (6.0 * (1.0 - sine * sine).sqrt());
        self.sine().map(of)
    }

    /// The unconfined strength `3 c / (3 - M)`, Pa; `None` for M of 3 and more, which the path of unconfined compression does not meet.
    pub fn unconfined_strength(&self) -> Option<f64> {
        (self.slope < 3.0).then(|| 3.0 * self.intercept / (3.0 - self.slope))
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_records::{drained_stages, triaxial, undrained_stages};
    use super::*;

    /// A material of Mohr and Coulomb with 30 degrees and 1 kPa: sigma_1 = 3 sigma_3 + 2 sqrt(3) kPa.
    #[test]
    fn the_envelope_is_that_of_mohr_and_coulomb() {
        let state = |lateral: f64| {
            let q = 2.0 * lateral + 2.0 * 3f64.sqrt() * 1e3;
            PeakState { mean_stress: lateral + q / 3.0, deviator_stress: q }
        };
        let envelope = StrengthEnvelope::through(&[state(1e3), state(4e3), state(10e3)]).unwrap();
        assert!((envelope.friction_angle().unwrap() - 30.0).abs() < 1e-9, "{envelope:?}");
        assert!((envelope.cohesion().unwrap() / 1e3 - 1.0).abs() < 1e-9, "{envelope:?}");
        // c cot phi, and 2 c cos phi / (1 - sin phi).
        assert!((envelope.tensile_strength() / (1e3 * 3f64.sqrt()) - 1.0).abs() < 1e-9);
        assert!((envelope.unconfined_strength().unwrap() / (2.0 * 3f64.sqrt() * 1e3) - 1.0).abs() < 1e-9);
        assert!(envelope.slope_error.unwrap() < 1e-9 && envelope.tests == 3);
        assert_eq!(StrengthEnvelope::through(&[state(1e3), state(1.05e3)]), None, "one stress makes no line");
    }

    /// A line that is steeper than any friction has a slope and a tensile strength, and nothing that is not a number.
    #[test]
    fn an_envelope_steeper_than_any_friction_has_no_angle() {
        let states = [1e3, 4e3].map(|p| PeakState { mean_stress: p, deviator_stress: 3.5 * p - 5e2 });
        let envelope = StrengthEnvelope::through(&states).unwrap();
        assert_eq!(
            (envelope.friction_angle(), envelope.cohesion(), envelope.unconfined_strength()),
            (None, None, None)
        );
        assert!(envelope.tensile_strength().is_finite());
    }

    #[test]
    fn the_peak_of_a_test_is_its_largest_deviator_stress() {
        let rows = [[0.0, 0.0, 10.0, 0.0], [0.02, -0.01, 14.0, 12.0], [0.04, -0.02, 13.0, 9.0]];
        let record = triaxial(rows.into_iter(), 0.5);
        let peak = PeakState::of_test(&record, &drained_stages()).unwrap();
        assert!((peak.deviator_stress - 12e3).abs() < 1e-9 && (peak.mean_stress - 14e3).abs() < 1e-9);
        assert!(PeakState::of_test(&record, &undrained_stages()).is_some());
    }
}
