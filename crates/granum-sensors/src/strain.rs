//! Strain of the cell, and time.
//!
//! Logarithmic strain since the start of the phase, compression positive. The deviator strain is the paper's
//! `eps_d = eps_1 - eps_3` with axes 2 and 3 averaged; the volumetric strain `eps_v = eps_1 + eps_2 + eps_3` is positive in
//! compaction, so that it is negative in a dilating sample.

use granum_core::Part;
use granum_core::assembly::Assembly;

use crate::tensor::{deviator, trace};
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// The sensor.
pub struct Strain;

impl Sensor for Strain {
    fn description(&self) -> SensorDescription {
        SensorDescription::new(
            "strain",
            "strain of the cell since the start of the phase, compression positive, and the simulated time",
        )
        .speaking_of(Subject::Sample)
        .columns([
            SensorColumn::new("deviator_strain", "1", "eps_d = eps_1 - eps_3, axes 2 and 3 averaged"),
            SensorColumn::new("axial_strain", "1", "eps_1"),
            SensorColumn::new("lateral_strain_2", "1", "eps_2"),
            SensorColumn::new("lateral_strain_3", "1", "eps_3"),
            SensorColumn::new("volumetric_strain", "1", "eps_1 + eps_2 + eps_3, positive in compaction"),
            SensorColumn::new("time", "s", "time since the start of the phase").needing(&[Part::Time]),
        ])
        .needing(&[Part::Strain])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let strain = &observation.assembly.strain;
        values.extend([
            deviator_strain(observation.assembly),
            strain[0][0],
            strain[1][1],
            strain[2][2],
            volumetric_strain(observation.assembly),
            observation.assembly.time,
        ]);
    }
}

/// Deviator strain `eps_1 - (eps_2 + eps_3) / 2`.
pub fn deviator_strain(assembly: &Assembly) -> f64 {
    deviator(&assembly.strain)
}

/// Volumetric strain `eps_1 + eps_2 + eps_3`.
pub fn volumetric_strain(assembly: &Assembly) -> f64 {
    trace(&assembly.strain)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axisymmetric_strain_is_split_into_deviator_and_volume() {
        let assembly = Assembly {
            strain: [[0.2, 0.0, 0.0], [0.0, -0.08, 0.0], [0.0, 0.0, -0.12]],
            time: 3.0,
            ..Default::default()
        };
        assert!((deviator_strain(&assembly) - 0.3).abs() < 1e-15);
        assert!(volumetric_strain(&assembly).abs() < 1e-15);
        assert_eq!(crate::measure_row(&assembly)[5], 3.0);
    }
}
