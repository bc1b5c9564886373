//! Granum as a library: a [`prelude`] with the names that most programs need, one module for each of its parts, and the
//! [`program`] with its command line.

// Output can be lost, and these macros would panic: messages go through `messages`, the output of a command through `output`.
#![deny(clippy::print_stderr, clippy::print_stdout)]

// The commands name this library as its users do.
extern crate self as granum;

mod command;
mod context;
mod failure;
mod interrupt;
mod latency;
mod messages;
mod numbers;
mod output;
#[cfg(test)]
mod owned_tests;
pub mod prelude;
pub mod program;
mod progress;
mod registry;
mod unwritten;

pub use registry::Registry;

/// What a contact law of one's own needs, and where it is registered; `examples/extend/` has one.
pub mod law {
    pub use granum_dem::contact::choice::registry::{Law, Laws};
    pub use granum_dem::contact::{
        AdhesionLaw, AdhesionLosses, Attraction, EnergyChannel, EnergyFate, LawConstants, LawDescription,
        LawEnergies, LawParameter, MAX_ADHESION_HISTORY, MAX_HISTORY, MAX_MOMENT_HISTORY, MAX_NORMAL_HISTORY,
        Mixing, Moment, MomentLaw, NoConstants, Normal, NormalLaw, NormalTraits, PairProperties,
        RelativeSpin, Tangential, TangentialLaw, Unit,
    };
    pub use granum_dem::law_constants;
    pub use granum_simd::{Mask, Real};
}

pub mod contents;
pub mod families;
pub mod gallery;

/// What a loading path of one's own needs, and where it is registered; `examples/extend/` has one.
pub mod path {
    pub use granum_dem::loading::preset::{
        INERTIAL_NUMBER, INTERVAL, PathParameter, PathParameterDefault, PathParameterKind, PathValues, Paths,
        Preset, STATES, deviator, number, optional, stress, word,
    };
    pub use granum_dem::loading::{
        Constraint, Control, Drive, Kinematics, Measure, RecordedStates, Speed, Stage, Target, Turns, Until,
    };
}

pub use granum_antony2006 as antony2006;
pub use granum_campaign as campaign;
pub use granum_core as core;
pub use granum_dem as dem;
pub use granum_io as io;
pub use granum_learn as learn;
pub use granum_nets as nets;
pub use granum_page as page;
pub use granum_point as point;
pub use granum_report as report;
pub use granum_run as run;
pub use granum_sensors as sensors;
pub use granum_shape as shape;
pub use granum_simd as simd;
