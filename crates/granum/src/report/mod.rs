//! Reports of runs and studies, and their figures.

pub mod figure;
