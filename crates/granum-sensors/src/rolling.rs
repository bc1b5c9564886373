//! Energy of rolling and twisting, J, where contacts resist them: the energy stored at present, and the work and loss since
//! the start of the phase. In a series of grains that roll freely these columns are omitted.
//!
//! `rolling_work = change of elastic rolling energy + rolling_loss`; the loss in dashpots against rolling is part of
//! `damping_loss`.

use crate::energy::mechanism_columns;
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};
use granum_core::Part;
use granum_core::energy::MechanismGroup;

/// The sensor.
pub struct Rolling;

impl Sensor for Rolling {
    fn description(&self) -> SensorDescription {
        let stored = SensorColumn::new(
            "elastic_rolling_energy",
            "J",
            "stored by the rolling and twisting of all contacts",
        );
        SensorDescription::new("rolling", "energy of rolling and twisting, where contacts resist them")
            .speaking_of(Subject::Contacts)
            .columns(
                [stored]
                    .into_iter()
                    .chain(mechanism_columns(MechanismGroup::Couples))
                    .map(SensorColumn::optional),
            )
            .needing(&[Part::Contacts, Part::ContactEnergies, Part::EnergyBalance])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let stored: f64 = observation.assembly.contacts.iter().map(|contact| contact.rolling_energy).sum();
        // The sum over no contacts is minus zero.
        values.push(stored + 0.0);
        values.extend(MechanismGroup::Couples.values(&observation.assembly.energy));
    }
}

#[cfg(test)]
mod tests {
    use crate::{Recorder, Sensors, column_index, lattice, measure_row};
    use granum_dem::config::Recording;

    #[test]
    fn what_is_stored_is_summed() {
        let mut assembly = lattice::simple_cubic(3, 1e-4, 1e-4, 1e-4);
        let column = column_index("elastic_rolling_energy").unwrap();
        assert_eq!(measure_row(&assembly)[column], 0.0);
        assembly.contacts.iter_mut().for_each(|contact| contact.rolling_energy = 1e-12);
        let expected = assembly.contacts.len() as f64 * 1e-12;
        assert!((measure_row(&assembly)[column] / expected - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_series_without_rolling_has_no_columns_of_it() {
        let series = |energy: f64| {
            let mut assembly = lattice::simple_cubic(3, 1e-4, 1e-4, 1e-4);
            assembly.contacts[0].rolling_energy = energy;
            let mut recorder = Recorder::new(
                &Sensors::standard(),
                &Recording::default().with(|recording| recording.states = 2),
                0.1,
            )
            .unwrap();
            recorder.observe(&assembly);
            recorder.record().series
        };
        assert!(series(0.0).values("rolling_loss").is_none());
        assert_eq!(series(1e-12).values("elastic_rolling_energy"), Some(&[1e-12][..]));
        // If one of them is in use, all are written, so that the energies of a series are complete.
        assert!(series(1e-12).values("rolling_loss").is_some());
    }
}
