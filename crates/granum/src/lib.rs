//! The parts of the granum program that others can use: its reports and figures.

pub mod report;
