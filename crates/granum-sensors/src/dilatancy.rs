//! Dilatancy angle: `sin(psi) = -tr(d_eps) / (|d_eps_1| + |d_eps_2| + |d_eps_3|)` of the principal strain increments from one
//! observation to the next, compression positive, so that psi is positive where the sample dilates.
//!
//! This formula includes the three usual ones: `-d_eps_v / (d_eps_1 - d_eps_2 - d_eps_3)` in axisymmetric compression
//! (Schanz and Vermeer 1996), `-d_eps_v / (d_eps_1 + d_eps_2 - d_eps_3)` in extension, and `-d_eps_v / (d_eps_1 - d_eps_3)` in
//! plane strain (Hansen 1958). A purely volumetric increment has 90 degrees in expansion and -90 in compression. Elastic
//! strains are included, so that the angle is that of the plastic flow only beyond a strain of a few tenths of a per cent.

use granum_core::Part;
use granum_core::assembly::Matrix;

use crate::numerics::asin_degrees;
use crate::ratio::ratio;
use crate::tensor::{eigenvalues, trace};
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// The sensor.
pub struct Dilatancy;

impl Sensor for Dilatancy {
    fn description(&self) -> SensorDescription {
        SensorDescription::new("dilatancy", "dilatancy angle of the strain between two observations")
            .speaking_of(Subject::Sample)
            .columns([SensorColumn::new(
                "dilatancy_angle",
                "deg",
                "psi of the strain since the last observation, positive in dilation; 0 at the first",
            )])
            .needing(&[Part::Strain])
            .remembering()
    }

    fn measure(&self, observation: &Observation, memory: &mut Memory, values: &mut Values) {
        let now: Vec<f64> = observation.assembly.strain.iter().flatten().copied().collect();
        values.push(match memory.len() == now.len() {
            true => dilatancy_angle(&std::array::from_fn(|i| {
                std::array::from_fn(|j| now[3 * i + j] - memory[3 * i + j])
            })),
            false => 0.0,
        });
        *memory = now;
    }
}

/// Dilatancy angle of an increment of strain, compression positive, in degrees; 0 without strain.
pub fn dilatancy_angle(increment: &Matrix) -> f64 {
    let sum: f64 = eigenvalues(increment).iter().map(|value| value.abs()).sum();
    asin_degrees(ratio(-trace(increment), sum))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice;
    use granum_core::assembly::Assembly;

    fn angle(increment: [f64; 3]) -> f64 {
        dilatancy_angle(&std::array::from_fn(|i| {
            std::array::from_fn(|j| if i == j { increment[i] } else { 0.0 })
        }))
    }

    /// Each kind of test with the formula that is usual for it.
    #[test]
    fn compression_extension_and_plane_strain_have_their_own_formulas() {
        let near =
            |value: f64, sine: f64| assert!((value - sine.asin().to_degrees()).abs() < 1e-10, "{value}");
        near(angle([2e-3, -1.4e-3, -1.4e-3]), 0.8 / 4.8);
        near(angle([-1.4e-3, -1.4e-3, 2e-3]), 0.8 / 4.8);
        near(angle([-2e-3, 1.2e-3, 1.2e-3]), -0.4 / 4.4);
        near(angle([1e-3, 0.0, -1.5e-3]), 0.5 / 2.5);
        assert_eq!(angle([2e-3, -1e-3, -1e-3]), 0.0);
        assert_eq!((angle([1e-3; 3]), angle([-1e-3; 3]), angle([0.0; 3])), (-90.0, 90.0, 0.0));
    }

    #[test]
    fn the_angle_does_not_depend_on_the_axes() {
        let increment = [[2e-3, 0.0, 0.0], [0.0, -1e-3, 0.0], [0.0, 0.0, -1.6e-3]];
        let turned = lattice::conjugate(&lattice::rotation([1.0, 2.0, -0.5], 0.8), &increment);
        assert!((dilatancy_angle(&turned) - dilatancy_angle(&increment)).abs() < 1e-9);
    }

    #[test]
    fn increments_are_counted_from_the_last_observation() {
        let mut memory = Memory::new();
        let mut observe = |axial: f64, lateral: f64| {
            let strain = [[axial, 0.0, 0.0], [0.0, lateral, 0.0], [0.0, 0.0, lateral]];
            let assembly = Assembly { strain, ..Default::default() };
            let mut row = Vec::new();
            Dilatancy.measure(&Observation::new(&assembly), &mut memory, &mut Values::new(&mut row, &mut []));
            row[0]
        };
        assert_eq!(observe(0.1, -0.03), 0.0);
        assert!((observe(0.102, -0.0314) - angle([2e-3, -1.4e-3, -1.4e-3])).abs() < 1e-9);
    }
}
