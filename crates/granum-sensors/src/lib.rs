//! Soft sensors: what can be measured on an assembly of grains at one moment, and the record of it over a test.
//!
//! A [`Sensor`] reads only an [`Assembly`](granum_core::Assembly), so that it cannot disturb a run and can also be evaluated on
//! the data of another code; data that are missing are reported. One sensor is one file with its formula and tests, and one line in
//! [`Sensors::standard`]; a program that uses this library adds its own sensors with [`Sensors::with`]. Axis 1 is the
//! axis of compression; axes 2 and 3 are averaged, as in Antony, Zhou and Wang (2006).
//!
//! Grains can have several pieces. Sensors that say nothing of spheres (contacts of a pair of grains, directions of their axes, ...) are
//! measured where an assembly has such grains, and recorded in tests with [`Sensors::for_clumps`].
//!
//! Every column is a finite number for any finite assembly: a mean over nothing (no contacts, no grains, no
//! strong contacts) is 0, and another column gives the count.
//!
//! ```
//! use granum_core::assembly::Assembly;
//!
//! let row = granum_sensors::measure_row(&Assembly::default());
//! let q_over_p = granum_sensors::column_index("stress_ratio").map(|column| row[column]);
//! assert_eq!(q_over_p, Some(0.0));
//! ```

pub mod agglomerate_voids;
pub mod anisotropies;
pub mod attraction;
pub mod bond_fabric;
pub mod bonds;
pub mod chain_buckling;
pub mod contact_motion;
pub mod contacts_per_pair;
pub mod coordination;
pub mod coordination_by_size;
pub mod d2min;
mod declared;
pub mod dilatancy;
pub mod directions;
pub mod energy;
pub mod energy_channel;
pub mod fabric;
pub mod force_chains;
pub mod force_distribution;
pub mod fragments;
pub mod friction_angle;
pub mod granular_temperature;
mod histogram;
pub mod inertial_number;
pub mod invariants;
pub mod liquid;
pub mod local_solid_fraction;
mod neighbours;
pub mod networks;
pub mod nonaffine_displacement;
mod numerics;
mod observation;
pub mod orientation;
pub mod overlap;
pub mod overlap_distribution;
pub mod pair_fabric;
pub mod pair_forces;
pub mod pair_sliding;
pub mod pairs;
mod parameter;
pub mod principal_axes;
pub mod radial_distribution;
mod ratio;
mod record;
mod recorded_state;
mod recorder;
mod registry;
pub mod rolling;
pub mod rose;
pub mod rupture_energies;
pub mod rupture_rate;
pub mod second_order_work;
mod sensor;
pub mod servo;
pub mod sliding;
pub mod solid_fraction;
pub mod spin;
pub mod state_parameter;
mod state_sums;
pub mod strain;
pub mod stress;
pub mod stress_asymmetry;
mod stress_tensor;
pub mod tensor;
pub mod unbalanced_force;
pub mod void_ratio;

#[cfg(test)]
mod clumps;
#[cfg(test)]
mod lattice;

pub use declared::{DeclaredParameter, OWN_KEYS};
pub use histogram::{Bins, Histogram};
pub use observation::Observation;
pub use parameter::{ParameterDefault, SensorParameter};
pub use record::{Histograms, Record, RecordError};
pub use recorded_state::RecordedState;
pub use recorder::{MissedObservations, Recorder, SavedRecorder};
pub use registry::{
    LeftOut, MeasuredSeries, Measurement, SensorError, Sensors, column_index, columns, measure_row,
};
pub use sensor::{Averaging, Memory, Sensor, SensorColumn, SensorDescription, Subject, Values};
