//! Soft sensors: what can be measured on an assembly of grains at one moment, and the record of it over a test.
//!
//! A sensor reads an [`Assembly`] and nothing else, so it cannot disturb a run
//! and works as well on another code's data. One sensor is one file with its formula and tests, and one line in
//! [`all`]. Axis 1 is the axis of compression; axes 2 and 3 are averaged, as in Antony, Zhou and Wang (2006).
//!
//! Every column is a finite number for any finite assembly: a mean over nothing (no contacts, no grains, no
//! strong contacts) is 0, and the count that tells so stands in a column beside it.
//!
//! ```
//! use granum_core::assembly::Assembly;
//!
//! let row = granum_sensors::measure_row(&Assembly::default());
//! let q_over_p = granum_sensors::column_index("stress_ratio").map(|column| row[column]);
//! assert_eq!(q_over_p, Some(0.0));
//! ```

pub mod attraction;
pub mod coordination;
pub mod energy;
pub mod fabric;
pub mod force_distribution;
pub mod inertial_number;
pub mod invariants;
mod look;
mod numerics;
pub mod overlap;
mod record;
mod recorder;
pub mod rolling;
pub mod rose;
mod sensor;
pub mod servo;
pub mod sliding;
pub mod solid_fraction;
pub mod strain;
pub mod stress;
pub mod tensor;
pub mod unbalanced_force;

#[cfg(test)]
mod lattice;

pub use look::Look;
pub use record::{Record, RecordError};
pub use recorder::{Recorder, Shortfall};
pub use sensor::{Averaging, Sensor, SensorColumn};

use granum_core::assembly::Assembly;

/// Every sensor, in the order of the columns of a series. A new sensor is one file and one line here.
pub fn all() -> &'static [Sensor] {
    const ALL: &[Sensor] = &[
        strain::SENSOR,
        stress::SENSOR,
        servo::SENSOR,
        fabric::SENSOR,
        force_distribution::SENSOR,
        coordination::SENSOR,
        solid_fraction::SENSOR,
        sliding::SENSOR,
        inertial_number::SENSOR,
        unbalanced_force::SENSOR,
        overlap::SENSOR,
        energy::SENSOR,
        rolling::SENSOR,
        attraction::SENSOR,
        rose::SENSOR,
    ];
    ALL
}

/// The columns of every sensor, in the order of [`measure_row`].
pub fn columns() -> impl Iterator<Item = &'static SensorColumn> {
    all().iter().flat_map(|sensor| sensor.columns)
}

/// The columns of a test that is given as stages: those of every sensor, and the general invariants.
pub fn stage_columns() -> impl Iterator<Item = &'static SensorColumn> {
    columns().chain(invariants::SENSOR.columns)
}

/// Where a column of that name stands in [`measure_row`].
pub fn column_index(name: &str) -> Option<usize> {
    columns().position(|column| column.name == name)
}

/// Measures every sensor: one value a column of [`columns`].
pub fn measure_row(assembly: &Assembly) -> Vec<f64> {
    let look = Look::new(assembly);
    let mut row = Vec::with_capacity(columns().count());
    for sensor in all() {
        (sensor.measure)(&look, &mut row);
    }
    row
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn every_sensor_gives_as_many_values_as_columns_and_names_are_unique() {
        let empty = Assembly::default();
        let packing = lattice::face_centred_cubic(3, 1e-4, 1e-4, 1e-4);
        let mut names = HashSet::new();
        for sensor in all() {
            assert!(!sensor.description.is_empty());
            for assembly in [&empty, &packing] {
                let mut row = Vec::new();
                (sensor.measure)(&Look::new(assembly), &mut row);
                assert_eq!(row.len(), sensor.columns.len(), "{}", sensor.name);
                assert!(row.iter().all(|value| value.is_finite()), "{}: {row:?}", sensor.name);
            }
            for column in sensor.columns {
                assert!(names.insert(column.name), "two columns named {}", column.name);
                assert!(!column.description.is_empty() && !column.unit.is_empty());
            }
        }
    }

    #[test]
    fn grains_without_contacts_and_one_single_contact_are_measured() {
        let mut assembly = lattice::simple_cubic(3, 1e-4, 1e-4, 1e-4);
        let one = assembly.contacts[0];
        assembly.contacts.clear();
        assert!(measure_row(&assembly).iter().all(|value| value.is_finite()));
        assembly.contacts.push(one);
        assert!(measure_row(&assembly).iter().all(|value| value.is_finite()));
        assembly.contacts[0].normal_force = -1e-6;
        assert!(measure_row(&assembly).iter().all(|value| value.is_finite()));
    }
}
