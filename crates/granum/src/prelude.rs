//! The names that most programs need: `use granum::prelude::*;`.
//!
//! A complete example that prepares and shears a sample and prints its series:
//!
//! ```
//! use granum::prelude::*;
//!
//! let case = Case::parse("grains.count = 60\npreparation.solid_fraction = 'none'\npreparation.unbalanced_force = 0.05\n\
//!                         shear.deviator_strain = 0.01\nshear.inertial_number = 0.01\nrecording.states = 4", "case")?;
//! let test = Laboratory::here().test(&case)?;
//! let [strain, ratio] = test.record.series.select(["deviator_strain", "stress_ratio"])?;
//! for (strain, ratio) in strain.iter().zip(ratio) {
//!     println!("{strain:.4} {ratio:.3}");
//! }
//! # assert_eq!(strain.len(), 5);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub use crate::registry::Registry;
pub use granum_core::assembly::{Assembly, Matrix, Vector};
pub use granum_core::quantity::Dimension;
pub use granum_core::{Cell, Column, Part, Parts, RegistrationError, Table};
pub use granum_dem::config::{
    ContactModel, Grains, Material, NormalKind, Preparation, Recording, RollingKind, Shear, TangentialKind,
};
pub use granum_dem::servo::CellControl;
pub use granum_dem::simulation::{Hardware, InitialSphere, Properties, Simulation};
pub use granum_io::formats::{Formats, PackingFormat, ResultFormat, TableFormat};
pub use granum_io::packing::{PackedGrain, Packing};
pub use granum_io::{
    Case, Run, RunFolder, read_columns, read_packing, read_table, write_packing, write_table,
};
pub use granum_learn::study::{NoStudyObserver, Study, StudyDefinition, StudyObserver};
pub use granum_learn::surrogate::Estimate;
pub use granum_learn::{
    Dataset, FitSpec, NamedRecord, Prediction, RunStates, Split, Surrogate, SurrogateMethod,
    SurrogateMethods, compare,
};

pub use granum_run::{
    Engine, EngineRun, Flow, Laboratory, NoObserver, Observer, PlannedRun, Progress, Resources, RunKind,
    RunRegistry, RunResult, SimulationObserver, SimulationProgress, Sink, Source, Task,
};
pub use granum_sensors::{
    Bins, Histogram, Memory, Observation, Record, Sensor, SensorColumn, SensorDescription, SensorParameter,
    Sensors, Subject, Values, column_index, measure_row,
};
