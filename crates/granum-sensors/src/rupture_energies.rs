//! Energies that bonds released when they ruptured, as acoustic emissions are counted: the histogram of `log10(E / <E>)` with the mean energy
//! of all ruptures so far.

use granum_core::Part;
use granum_dem::config::Recording;

use crate::ratio::mean;
use crate::{Bins, Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// The sensor.
pub struct RuptureEnergies;

impl Sensor for RuptureEnergies {
    fn description(&self) -> SensorDescription {
        SensorDescription::new(
            "rupture_energies",
            "energies that ruptured bonds released, and their distribution",
        )
        .speaking_of(Subject::Bonds)
        .columns([
            SensorColumn::new("mean_rupture_energy", "J", "mean energy of the bonds that ruptured"),
            SensorColumn::new("largest_rupture_energy", "J", "largest energy of a bond that ruptured"),
        ])
        .needing(&[Part::Bonds])
    }

    fn histograms(&self, _: &Recording) -> Vec<Bins> {
        vec![Bins::new("rupture_energies", "rupture_energy_exponent", "1").width(0.25).range(-4.0, 2.0)]
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let energies = || observation.assembly.broken_bonds.iter().map(|bond| bond.energy);
        let mean_energy = mean(energies().sum::<f64>() + 0.0, observation.assembly.broken_bonds.len());
        values.push(mean_energy);
        values.push(energies().fold(0.0, f64::max));
        values.count(0, energies().map(|energy| libm::log10((energy / mean_energy).max(1e-12))));
    }
}
