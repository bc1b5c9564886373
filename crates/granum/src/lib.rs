//! Granum as a library: a [`prelude`] for most programs, and one name for each of its parts.

pub mod prelude;

pub use granum_core as core;
pub use granum_dem as dem;
pub use granum_io as io;
pub use granum_learn as learn;
pub use granum_nets as nets;
pub use granum_report as report;
pub use granum_run as run;
pub use granum_sensors as sensors;
pub use granum_simd as simd;
