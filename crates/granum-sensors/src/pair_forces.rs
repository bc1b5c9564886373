//! Distribution of the normal forces between grains: those of the contacts of two grains of several pieces, taken together.
//!
//! The resultant normal force of a pair of grains is `N_p = |sum N n|` over its contacts, with the sign of `sum N` ([`crate::pairs`]); it is the
//! force of the contact where there is one. `f_p = N_p / <N_p>` with the mean over all pairs; its histogram has the bins of that of the
//! [contacts](crate::force_distribution), from which it differs where one contact of a pair takes over from another.
//!
//! Without pairs, or where `<N_p>` is not positive, f_p is undefined and its moment is 0.

use granum_core::Part;
use granum_dem::config::Recording;

use crate::force_distribution::{BIN_WIDTH, LARGEST_FORCE, SMALLEST_FORCE, bins_of};
use crate::ratio::mean;
use crate::{Bins, Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// The sensor.
pub struct PairForces;

impl Sensor for PairForces {
    fn description(&self) -> SensorDescription {
        SensorDescription::new(
            "pair_forces",
            "distribution of the resultant normal forces of pairs of grains",
        )
        .speaking_of(Subject::Bodies)
        .columns([
            SensorColumn::new(
                "mean_pair_force",
                "N",
                "<N_p>, N_p = |sum N n| of the contacts of a pair of grains",
            ),
            SensorColumn::new("mean_square_pair_force", "1", "<f_p^2>, f_p = N_p/<N_p>"),
            SensorColumn::new("tensile_pair_fraction", "1", "pairs that pull at each other over all pairs"),
        ])
        .parameters([BIN_WIDTH, LARGEST_FORCE])
        .needing(&[Part::Contacts, Part::NormalForces])
    }

    fn histograms(&self, recording: &Recording) -> Vec<Bins> {
        let [width, largest] = bins_of(recording);
        vec![Bins::new("pair_forces", "pair_force", "1").width(width).range(SMALLEST_FORCE, largest)]
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let forces: Vec<f64> = observation.pairs().map(|pair| pair.normal_force()).collect();
        let average = mean(forces.iter().sum::<f64>() + 0.0, forces.len());
        let tensile = forces.iter().filter(|force| **force < 0.0).count();
        let scaled = || forces.iter().filter(|_| average > 0.0).map(|force| force / average);
        let squares: f64 = scaled().map(|f| f * f).sum();
        values.extend([average, mean(squares + 0.0, forces.len()), mean(tensile as f64, forces.len())]);
        values.count(0, scaled());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::force_distribution::ForceDistribution;
    use crate::sensor::measured;
    use crate::{clumps, lattice};

    /// Forces of 3 + 1, 2 and -1: mean 5/3, f = 2.4, 1.2 and -0.6.
    #[test]
    fn contacts_of_a_pair_are_one_force() {
        let assembly = clumps::few();
        let bins = PairForces.histograms(&Recording::default());
        let (mut row, mut counts) = (Vec::new(), bins.iter().map(Bins::empty).collect::<Vec<_>>());
        let mut values = Values::new(&mut row, &mut counts);
        PairForces.measure(&Observation::new(&assembly), &mut Memory::new(), &mut values);
        for (value, exact) in row.iter().zip([5.0 / 3.0, 2.52, 1.0 / 3.0]) {
            assert!((value - exact).abs() < 1e-14, "{row:?}");
        }
        let filled: Vec<f64> = (0..counts[0].bins())
            .filter(|bin| counts[0].counts[*bin] == 1)
            .map(|bin| counts[0].centre(bin))
            .collect();
        assert_eq!((filled, counts[0].total()), (vec![-0.625, 1.125, 2.375], 3));
    }

    #[test]
    fn forces_of_pairs_of_spheres_are_those_of_their_contacts() {
        let mut assembly = lattice::random_contacts(100, 3);
        // Each pair once.
        assembly.contacts.truncate(100);
        let (pairs, contacts) = (measured(&PairForces, &assembly), measured(&ForceDistribution, &assembly));
        assert!((0..3).all(|k| (pairs[k] - contacts[k]).abs() < 1e-12), "{pairs:?} {contacts:?}");
    }

    #[test]
    fn without_a_positive_mean_there_is_no_distribution() {
        let mut assembly = clumps::few();
        assembly.contacts.iter_mut().for_each(|contact| contact.normal_force = -1.0);
        assert_eq!(measured(&PairForces, &assembly)[1..], [0.0, 1.0]);
    }
}
