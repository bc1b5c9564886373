//! The file of a calibration: like the plan of a campaign a base case, keys that all runs have and variables, with a prior for each variable
//! that is free, and the table `[calibration]`.
//!
//! ```toml
//! case = "karlsruhe-dense.toml"
//!
//! [set]
//! grains.count = 1000
//!
//! [calibration]
//! tests = ["TMD1", "TMD22"]
//! runs = 80
//!
//! [calibration.density]               # of the laboratory, for relative_density
//! densest_void_ratio = 0.677
//! loosest_void_ratio = 1.054
//!
//! [[calibration.quantity]]
//! name = "deviator_stress"
//!
//! [[variable]]                        # free
//! name = "friction"
//! key = "grains.material.friction"
//! prior = "uniform"
//! from = 0.2
//! to = 0.8
//!
//! [[variable]]                        # of each test
//! name = "lateral_stress"
//! keys = ["preparation.mean_stress", "stage.1.lateral_stress"]
//! test = "lateral_stress"
//! ```

mod definition;
mod read;
mod read_table;
mod read_variable;
#[cfg(test)]
mod tests;
mod words;

#[cfg(test)]
pub(crate) use tests::{PLAIN_CASE as CASE_FOR_TESTS, STRESS_AND_FRICTION, file as file_for_tests};

pub use definition::{
    CalibrationFile, CalibrationTable, ComparedQuantity, CriticalStateOfTests, FreeVariable, Method,
    PredictedTests, TestCondition, WHY_PREDICTIONS,
};
