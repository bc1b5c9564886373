//! The bonds of a case: tables `[[bond]]`, each of which is made before a stage.

mod case_bond;
mod keys;
mod read;
mod schema;
#[cfg(test)]
mod tests;
mod write;

pub use case_bond::CaseBond;
pub(super) use schema::schema;

/// The heading, and the beginning of its keys.
pub(super) const BOND: &str = "bond";
