//! Directions of contacts, forces and branches: the tensors `<n n>`, `<N n n> / <N>` and `<l l> / <l . l>`, each of trace one,
//! with the principal values and the direction of the largest (Satake 1982; Kanatani 1984).
//! Every contact of two grains of several pieces counts, with its own normal and the branch between their centres of mass.
//!
//! The direction is a unit vector with a positive x component, so that it is continuous as long as the major direction is not
//! perpendicular to x; over the observations of a state its components are averaged like any other column. In simple shear it
//! shows the rotation of the principal axes. If two principal values are equal, the direction is arbitrary.

use granum_core::Part;
use granum_core::assembly::{Contact, Matrix};

use crate::ratio::ratio;
use crate::tensor::{add_dyad, principal, scaled, trace};
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// The sensor.
pub struct Directions;

/// The columns of one tensor.
macro_rules! columns {
    ($what:literal, $tensor:literal, $needs:expr) => {
        [
            SensorColumn::new(concat!($what, "_major"), "1", concat!("largest principal value of ", $tensor))
                .needing($needs),
            SensorColumn::new(concat!($what, "_middle"), "1", concat!("middle principal value of ", $tensor))
                .needing($needs),
            SensorColumn::new(
                concat!($what, "_minor"),
                "1",
                concat!("smallest principal value of ", $tensor),
            )
            .needing($needs),
            SensorColumn::new(
                concat!($what, "_direction_x"),
                "1",
                "x component of the direction of the largest",
            )
            .needing($needs),
            SensorColumn::new(concat!($what, "_direction_y"), "1", "y component of that direction")
                .needing($needs),
            SensorColumn::new(concat!($what, "_direction_z"), "1", "z component of that direction")
                .needing($needs),
        ]
    };
}

impl Sensor for Directions {
    fn description(&self) -> SensorDescription {
        let forces: &'static [Part] = &[Part::NormalForces];
        let columns = [
            columns!("contact_fabric", "<n n>", &[]),
            columns!("force_fabric", "<N n n> / <N>", forces),
            columns!("branch_fabric", "<l l> / <l . l>", &[]),
        ];
        SensorDescription::new(
            "directions",
            "principal values and directions of contacts, normal forces and branches",
        )
        .speaking_of(Subject::Contacts)
        .columns(columns.into_iter().flatten())
        .needing(&[Part::Contacts])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let tensors = [
            mean_dyad(observation, |contact| (1.0, contact.normal)),
            mean_dyad(observation, |contact| (contact.normal_force, contact.normal)),
            mean_dyad(observation, |contact| (1.0, observation.assembly.branch_of_bodies(contact))),
        ];
        for tensor in tensors {
            let [major, middle, minor] = principal(&tensor);
            values.extend([major.0, middle.0, minor.0]);
            values.extend(major.1);
        }
    }
}

/// The sum of `weight v v` over the contacts, over its trace; zero where that is zero.
fn mean_dyad(observation: &Observation, of: impl Fn(&Contact) -> (f64, [f64; 3])) -> Matrix {
    let mut sum = [[0.0; 3]; 3];
    for contact in &observation.assembly.contacts {
        let (weight, vector) = of(contact);
        add_dyad(&mut sum, weight, &vector, &vector);
    }
    scaled(&sum, ratio(1.0, trace(&sum)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice;
    use crate::sensor::measured;

    /// A simple cubic lattice, loaded with 3 along one axis and 2 and 1 along the others, and turned.
    #[test]
    fn the_major_direction_of_the_forces_turns_with_the_lattice() {
        let mut assembly = lattice::simple_cubic(3, 1e-4, 0.0, 1.0);
        for contact in &mut assembly.contacts {
            let axis = (0..3).find(|&a| contact.normal[a].abs() > 0.5).unwrap();
            contact.normal_force = [1.0, 3.0, 2.0][axis];
        }
        let q = lattice::rotation([0.0, 0.0, 1.0], -std::f64::consts::FRAC_PI_4);
        let row = measured(&Directions, &lattice::rotated(&assembly, &q));
        let third = 1.0 / 3.0;
        for (value, exact) in row[..3].iter().chain(&row[12..15]).zip([third; 6]) {
            assert!((value - exact).abs() < 1e-12, "{row:?}");
        }
        let half = std::f64::consts::FRAC_1_SQRT_2;
        for (value, exact) in row[6..12].iter().zip([0.5, third, 1.0 / 6.0, half, half, 0.0]) {
            assert!((value - exact).abs() < 1e-12, "{row:?}");
        }
    }

    #[test]
    fn long_branches_count_more() {
        let mut assembly = lattice::simple_cubic(3, 1e-4, 0.0, 1.0);
        let along_z = assembly.contacts.iter_mut().filter(|contact| contact.normal[2].abs() > 0.5);
        along_z.for_each(|contact| contact.branch[2] *= 2.0);
        let row = measured(&Directions, &assembly);
        for (value, exact) in row[12..18].iter().zip([4.0 / 6.0, 1.0 / 6.0, 1.0 / 6.0, 0.0, 0.0, 1.0]) {
            assert!((value - exact).abs() < 1e-12, "{row:?}");
        }
    }
}
