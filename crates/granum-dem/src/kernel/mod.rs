//! The stages of a step: every contact adds to the force rows of its grains; every grain sums its rows and moves, and so does every
//! clump with those of its pieces; and before some steps the neighbour list is pruned again to the pairs that need to be evaluated.
//!
//! All stages work on the blocks of the neighbour list, so that their sums do not depend on which thread computed them.
//! [`Views`] gives all threads access to the state during a stage; its `unsafe` code follows the rules of
//! [`crate::team::RawSlice`].

mod choice;
mod clumps;
mod contacts;
mod fetch;
mod grains;
pub(crate) mod laws;
mod near;
mod order;
mod part;
mod prune;
mod push;
mod source;
mod sums;
mod views;

pub(crate) use choice::{ContactStageFunction, ContactStages};
pub(crate) use clumps::ClumpStage;
pub(crate) use grains::{GrainStage, larger};
pub(crate) use prune::PruneStage;
pub(crate) use views::Views;
