//! What tests and simulations can tell, asked before they are made: sensitivity, identifiability, the next test and the next simulation.

pub mod candidate_tests;
pub mod identifiability;
pub mod next_run;
pub mod next_test;
pub mod sensitivity;
pub mod telling;
