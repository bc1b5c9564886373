//! Plans: a base case, variables over its keys, a design, constraints and replicates, from which the runs of a campaign are made.
//!
//! ```toml
//! case = "sand.toml"
//! constraints = ["rolling_friction < friction"]
//!
//! [design]
//! kind = "sobol"
//! points = 200
//! replicates = 2
//!
//! [[variable]]
//! name = "friction"
//! key = "grains.material.friction"
//! from = 0.1
//! to = 0.8
//!
//! [[variable]]
//! name = "pressure"
//! keys = ["preparation.mean_stress", "stage.1.lateral_stress"]
//! from = "50 kPa"
//! to = "400 kPa"
//! scale = "log"
//!
//! [[variable]]
//! name = "rolling_friction"
//! key = "contact.rolling_friction"
//! from = 0.05
//! to = 0.5
//! ```

mod check_plan;
mod definition;
mod dependence;
mod design;
mod expression;
mod path_change;
mod read;
mod read_design;
mod read_variables;
mod reader;
mod runs;
mod schema;
mod sequence;
mod units;
mod values;

pub use definition::{
    Choice, DesignKind, DesignTable, FixedKey, Keep, Plan, PlanRow, PlanSource, PlanVariable, RowPlace,
    SampleSeeds, Spanned, VariableKind,
};
pub use design::{DesignSize, PointDesign};
pub use expression::{Condition, Expression};
pub use read_variables::Draft;
pub use reader::{Node, Reader};
pub use runs::{PlanRun, PlannedRuns, apply_settings};
pub use sequence::SequencePoint;
pub use values::{RunValue, in_steps};

#[cfg(test)]
mod tests;
