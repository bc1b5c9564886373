//! State parameter `psi = e - e_c(p)` (Been and Jefferies 1985): the void ratio less that of the critical state at the same mean
//! stress. It is negative if the sample is denser than in the critical state, so that it tends to dilate.
//!
//! The critical state line is given with the case, `e_c = e_0 - lambda (p / 100 kPa)^xi` with e_0, lambda and xi as
//! `recording.critical_void_ratio`, `critical_slope` and `critical_exponent` (Li and Wang 1998; xi is about 0.7 for sand).

use granum_core::Part;
use granum_core::quantity::Dimension;
use granum_dem::config::Recording;
use granum_simd::exp;

use crate::numerics::ln;
use crate::void_ratio::void_ratio;
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, SensorParameter, Subject, Values};

/// Reference stress of the critical state line, Pa.
const REFERENCE: f64 = 1e5;

/// Critical void ratio e_0.
pub const VOID_RATIO: SensorParameter = SensorParameter::new(
    "critical_void_ratio",
    Dimension::NUMBER,
    0.0,
    [0.01, 10.0],
    "Critical void ratio e_0 at zero mean stress: e_c = e_0 - critical_slope (p / 100 kPa)^critical_exponent",
)
.needed("the critical state line is not known");

/// Slope lambda of the line; 0 where it is not given.
pub const SLOPE: SensorParameter = SensorParameter::new(
    "critical_slope",
    Dimension::NUMBER,
    0.0,
    [0.0, 10.0],
    "Decrease of the critical void ratio from zero mean stress to 100 kPa",
)
.optional("0");

/// Exponent xi of the mean stress; 0.7 where it is not given.
pub const EXPONENT: SensorParameter = SensorParameter::new(
    "critical_exponent",
    Dimension::NUMBER,
    0.7,
    [0.01, 10.0],
    "Exponent of the mean stress in the critical state line",
)
.optional("0.7");

/// The critical state line `[e_0, lambda, xi]` of a recording; `None` without a void ratio.
pub fn line_of(recording: &Recording) -> Option<[f64; 3]> {
    let slope = SLOPE.value(recording).unwrap_or(0.0);
    Some([VOID_RATIO.value(recording)?, slope, EXPONENT.value(recording).unwrap_or(0.7)])
}

/// The sensor.
pub struct StateParameter;

impl Sensor for StateParameter {
    fn description(&self) -> SensorDescription {
        SensorDescription::new(
            "state_parameter",
            "void ratio less that of the critical state at the same mean stress",
        )
        .speaking_of(Subject::Sample)
        .columns([SensorColumn::new("state_parameter", "1", "psi = e - e_c(p), negative in a dense sample")])
        .parameters([VOID_RATIO, SLOPE, EXPONENT])
        .needing(&[
            Part::Cell,
            Part::Radii,
            Part::Contacts,
            Part::NormalForces,
            Part::TangentialForces,
        ])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let psi = |line| void_ratio(observation) - critical_void_ratio(line, observation.stress.mean());
        values.push(line_of(observation.recording).map_or(0.0, psi));
    }
}

/// Void ratio of the critical state `[e_0, lambda, xi]` at a mean stress, Pa; `e_0` where the stress is not positive.
///
/// ```
/// let line = [0.9, 0.02, 0.7];
/// let e = granum_sensors::state_parameter::critical_void_ratio(line, 1e5);
/// assert!((e - 0.88).abs() < 1e-14);
/// ```
pub fn critical_void_ratio([at_zero, slope, exponent]: [f64; 3], mean_stress: f64) -> f64 {
    match mean_stress > 0.0 {
        true => at_zero - slope * exp(exponent * ln(mean_stress / REFERENCE)),
        false => at_zero,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice;
    use crate::{SensorError, Sensors};
    use granum_dem::config::RecordedColumns;

    /// A recording with a critical state line.
    fn with_line(void_ratio: f64, slope: f64) -> Recording {
        Recording::default().with(|recording| {
            recording.parameters = [(VOID_RATIO.key.into(), void_ratio), (SLOPE.key.into(), slope)].into();
        })
    }

    /// The published line of Toyoura sand, 0.934 - 0.019 (p / 101 kPa)^0.7, has the form; here with the stress of reference.
    #[test]
    fn the_line_is_a_power_of_the_mean_stress() {
        let line = [0.934, 0.019, 0.7];
        for p in [1e3f64, 5e4, 3e5, 2e6] {
            let exact = 0.934 - 0.019 * (p / 1e5).powf(0.7);
            assert!((critical_void_ratio(line, p) - exact).abs() < 1e-13, "{p}");
        }
        assert_eq!(critical_void_ratio(line, -1.0), 0.934);
    }

    #[test]
    fn a_dense_lattice_lies_below_and_a_loose_one_above_the_line() {
        let recording = with_line(0.6, 0.01);
        let psi = |assembly: &granum_core::Assembly| {
            let mut row = Vec::new();
            let observation = Observation::new(assembly).with_recording(&recording);
            StateParameter.measure(&observation, &mut Memory::new(), &mut Values::new(&mut row, &mut []));
            row[0]
        };
        // SC has e = 6/pi - 1 = 0.909859 and FCC 0.350474; of the second the pressure is 7.2538e4 Pa.
        assert!((psi(&lattice::simple_cubic(3, 1e-4, 0.0, 0.0)) - 0.309859).abs() < 1e-6);
        let dense = psi(&lattice::face_centred_cubic(3, 1e-4, 0.0, 2.564102564e-4));
        let p: f64 = 2.0 * 2f64.sqrt() * 2.564102564e-4 / 1e-8;
        assert!(
            (dense - (18f64.sqrt() / std::f64::consts::PI - 1.0 - 0.6 + 0.01 * (p / 1e5).powf(0.7))).abs()
                < 1e-12
        );
    }

    #[test]
    fn without_a_line_it_is_refused_by_a_case_and_left_out_of_a_measurement() {
        let sensors = Sensors::standard();
        let mut recording =
            Recording::default().with(|recording| recording.sensors = vec!["state_parameter".into()]);
        let error = sensors.of_test(&recording, RecordedColumns::FirstPublished).unwrap_err();
        assert!(matches!(error, SensorError::Lacks { .. }));
        assert!(error.to_string().contains("set recording.critical_void_ratio"), "{error}");
        recording.parameters = with_line(0.8, 0.02).parameters;
        assert!(sensors.of_test(&recording, RecordedColumns::FirstPublished).is_ok());
        let measured = sensors.measure(&lattice::simple_cubic(3, 1e-4, 0.0, 0.0), granum_core::Parts::all());
        assert_eq!(measured.value("state_parameter"), None);
        let told: Vec<String> = measured.left_out.iter().map(|left_out| left_out.to_string()).collect();
        assert!(
            told.iter().any(|line| line.starts_with("state_parameter: the critical state line is not known")),
            "{told:?}"
        );
    }
}
