//! Second-order work `d2W = d_sigma_ij d_eps_ij` from one observation to the next (Hill 1958): where it is positive for every
//! increment, a state is stable; it vanishes at the peak of the stress.
//!
//! Strain and stress are those of the cell, compression positive, so that `d2W` is a work per volume, Pa. It is proportional to
//! the square of the strain between observations, which [`crate::nonaffine_displacement`] records.

use granum_core::Part;
use granum_core::assembly::Matrix;

use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// The sensor.
pub struct SecondOrderWork;

impl Sensor for SecondOrderWork {
    fn description(&self) -> SensorDescription {
        SensorDescription::new("second_order_work", "second-order work between two observations")
            .speaking_of(Subject::Sample)
            .columns([SensorColumn::new(
                "second_order_work",
                "Pa",
                "sum of d_sigma_ij d_eps_ij since the last observation",
            )])
            .needing(&[Part::Cell, Part::Contacts, Part::NormalForces, Part::TangentialForces, Part::Strain])
            .remembering()
    }

    fn measure(&self, observation: &Observation, memory: &mut Memory, values: &mut Values) {
        let symmetric = |t: &Matrix| -> Matrix {
            std::array::from_fn(|i| std::array::from_fn(|j| 0.5 * (t[i][j] + t[j][i])))
        };
        let (stress, strain) =
            (symmetric(&observation.stress.tensor()), symmetric(&observation.assembly.strain));
        let now: Vec<f64> = stress.iter().chain(&strain).flatten().copied().collect();
        let work = match memory.len() == now.len() {
            true => (0..9).map(|k| (now[k] - memory[k]) * (now[9 + k] - memory[9 + k])).sum::<f64>() + 0.0,
            false => 0.0,
        };
        values.push(work);
        *memory = now;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice;

    /// Simple cubic under a strain along x: `d2W = C11 d_eps^2` with the stiffness of the contacts along x.
    #[test]
    fn a_stiffening_is_positive_and_a_softening_negative() {
        let mut assembly = lattice::simple_cubic(3, 1e-4, 1e-4, 2e-4);
        let mut memory = Memory::new();
        let mut observe = |assembly: &granum_core::Assembly| {
            let mut row = Vec::new();
            SecondOrderWork.measure(
                &Observation::new(assembly),
                &mut memory,
                &mut Values::new(&mut row, &mut []),
            );
            row[0]
        };
        assert_eq!(observe(&assembly), 0.0);
        let before = Observation::new(&assembly).stress.tensor()[0][0];
        let push = |assembly: &mut granum_core::Assembly, force: f64| {
            let along_x = assembly.contacts.iter_mut().filter(|contact| contact.normal[0].abs() > 0.5);
            along_x.for_each(|contact| contact.normal_force = force);
        };
        push(&mut assembly, 3e-4);
        assembly.strain[0][0] = 0.01;
        let work = observe(&assembly);
        let exact = 0.5 * before * 0.01;
        assert!((work / exact - 1.0).abs() < 1e-9, "{work} {exact}");
        push(&mut assembly, 1e-4);
        assembly.strain[0][0] = 0.02;
        assert!((observe(&assembly) / (-before * 0.01) - 1.0).abs() < 1e-9);
    }
}
